"""Properties that every study has."""

from dataclasses import replace

import numpy as np
import pytest

import lostmotion
from lostmotion import sample_poses, worst_case
from lostmotion.accuracy.workspace import workspace
from lostmotion.error_model.bounds import bounds
from lostmotion.error_model.budget import Tally, costs
from lostmotion.error_model.intervals import pooled_quantile, quantile
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.robot_intervals import pooled_mean, robots_quantile
from lostmotion.laws.distributions import Normal
from lostmotion.laws.iso9283 import pose_repeatability
from lostmotion.parts.forms import Constant
from lostmotion.parts.standard_terms import limit_terms
from lostmotion.parts.term import Parameter
from lostmotion.propagation import exact
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.propagation.montecarlo.sensitivity import halving
from lostmotion.spatial import pose_of
from tests.arms import JOINT, arm_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "first order",
        "product of exponentials",
        "0.2 % at arcminutes; falls with the square",
        "propagation/exact.py propagation/first_order.py",
    ),
    (
        "mean square",
        "exact sum over terms against samples",
        "within the interval",
        "propagation/montecarlo/kernel.py",
    ),
    (
        "RP",
        "constants of isotropic normal, uniform and two-valued scatter",
        "0.3 %",
    ),
    (
        "workspace volume",
        "hollow ball",
        "inside its bracket",
    ),
)

ARCMIN = np.pi / 10800


def small(size: float) -> lostmotion.Arm:
    """Return an arm whose only errors are lumped joint errors of this size."""
    lumped = {"angle": size * ARCMIN, "law": "uniform", "offset": size * 1e-5}
    return arm_of(
        gearbox=None, bearing=None, encoder=None, mounting=None, lumped=lumped, link={"length": 0.4}
    )


def test_the_error_of_the_first_order_sum_falls_with_the_square():
    """The first-order sum neglects below 0.2 % of the 95th percentile at arcminutes, and a ninth of
    that at a third of the error.
    """
    neglected = []
    for size in (3.0, 1.0):
        arm = small(size)
        poses = sample_poses(arm, 64)
        found = run(arm, poses, 64, 4, 1)
        q95 = quantile(found.group_hist.sum(axis=0), 0.95)
        assert found.exact.largest < 0.002 * q95
        neglected.append(found.exact.largest)
    assert neglected[0] / neglected[1] == pytest.approx(9, rel=0.02)


def test_halving_all_errors_quarters_the_neglected_part(arm):
    """Halving the terms of every kind of part quarters the error of the first-order sum: the arm
    deflects half as far, and its robots scatter half as far about where it stands.
    """
    half = arm.model_copy()
    half.__dict__["terms"] = tuple(
        replace(each, term=replace(each.term, scale=each.term.scale / 2)) for each in arm.terms
    )
    q, rows = sample_poses(arm, 8).q, np.arange(8)
    whole, less = (
        exact.check(pose_matrix(each, q), 0, rows, 1, 20, 5).mean for each in (arm, half)
    )
    assert whole / less == pytest.approx(4, rel=0.02)


def test_no_sample_exceeds_the_worst_case_and_root_sum_square_lies_below_it(arm):
    """At every pose neither a sample nor the root-sum-square exceeds the worst case."""
    poses = sample_poses(arm, 256)
    found = run(arm, poses, 200, 10, 1)
    assert (found.per_pose[:, kernel.LARGEST] <= found.worst).all()
    assert (found.rss <= found.worst).all()
    assert (found.worst > 0).all()


def test_a_single_two_sided_error_reaches_the_worst_case():
    """The worst case of one two-sided angle error is the lever arm times the angle, and every
    sample reaches it.
    """
    arm = arm_of(
        1,
        gearbox=None,
        bearing=None,
        encoder=None,
        mounting=None,
        lumped={"angle": 1e-3, "law": "two-sided"},
        link={"length": 0.4},
    )
    matrix = pose_matrix(arm, np.zeros((1, 1)))
    assert worst_case(matrix)[0] == pytest.approx(0.4e-3, rel=1e-12)
    assert bounds(matrix).root_sum_square[0] == pytest.approx(0.4e-3, rel=1e-12)
    assert run(arm, sample_poses(arm, 8), 10, 2, 1).per_pose[0, kernel.MEAN] == pytest.approx(
        0.4e-3, rel=1e-12
    )


def test_rotating_the_base_changes_no_error_magnitude(arm):
    """An arm on a base rotated about the vertical has the same error magnitudes."""
    turned = arm.model_copy(
        update={
            "joints": (
                arm.joints[0].model_copy(
                    update={"origin": arm.joints[0].origin.model_copy(update={"rpy": (0, 0, 0.7)})}
                ),
                *arm.joints[1:],
            )
        }
    )
    q = sample_poses(arm, 64).q
    first, second = pose_matrix(arm, q), pose_matrix(turned, q)
    rotation = pose_of(rpy=(0, 0, 0.7))[:3, :3]
    np.testing.assert_allclose(second.tool[:, 3:], rotation @ first.tool[:, 3:], atol=1e-15)
    np.testing.assert_allclose(
        np.linalg.norm(second.bias[:, 3:], axis=1),
        np.linalg.norm(first.bias[:, 3:], axis=1),
        rtol=1e-9,
    )


def test_mean_square_of_the_samples_is_the_exact_sum_over_terms(arm):
    """The sampled mean square equals |bias|^2 plus the variances of all terms within 1 %."""
    poses = sample_poses(arm, 128)
    found = run(arm, poses, 2000, 4, 2)
    sampled = found.per_pose[:, kernel.MEAN_SQUARE].mean()
    assert sampled == pytest.approx(found.tally.total / found.tally.poses, rel=0.01)


def test_shares_add_to_one_and_halving_equals_a_second_sum(arm):
    """The shares of all parts add to one within 1e-12, and 'if halved' equals the sum with that
    part's terms halved.
    """
    matrix = pose_matrix(arm, sample_poses(arm, 64).q)
    listed = costs(Tally.of(matrix))
    assert sum(cost.share for cost in listed) == pytest.approx(1, abs=1e-12)
    for cost in listed:
        factor = np.array([0.5 if info.owner == cost.part else 1.0 for info in matrix.infos])
        again = Tally.of(matrix.scaled(factor))
        assert cost.rms_if_halved == pytest.approx(np.sqrt(again.total / again.poses), rel=1e-10)


def test_halving_a_part_without_error_gains_nothing(arm):
    """Halving a part without a lever arm to the tool gains exactly zero, and halving the largest
    contributor gains most.
    """
    arm = arm_of(2, link={"length": 0.0}).model_copy(
        update={
            "joints": (
                *arm_of(1).joints,
                arm_of(2, link={"length": 0.0}, bearing=None, mounting=None).joints[1],
            )
        }
    )
    poses = sample_poses(arm, 64)
    found = halving(arm, poses, 100, 4, 1)
    assert found.gains["joints.A.gearbox"].value == 0  # rotates the tool about its own point
    largest = costs(Tally.of(pose_matrix(arm, poses.q)))[0].part
    assert found.gains[largest].value == max(gain.value for gain in found.gains.values())
    assert found.gains[largest].low > 0


def test_repeatability_has_the_constants_of_the_standard():
    """RP of isotropic normal scatter tends to 3.61609, 3.21872, 2.60632 sigma in 3, 2, 1
    dimensions, and is 3.537 +- 0.329 for 30 visits.
    """
    rng = np.random.default_rng(1)
    for axes, constant in ((3, 3.61609), (2, 3.21872), (1, 2.60632)):
        positions = np.zeros((1_000_000, 3))
        positions[:, :axes] = rng.normal(size=(1_000_000, axes))
        assert pose_repeatability(positions) == pytest.approx(constant, rel=3e-3)
    at_thirty = pose_repeatability(rng.normal(size=(50_000, 30, 3)))
    assert at_thirty.mean() == pytest.approx(3.537, rel=3e-3)
    assert at_thirty.std() == pytest.approx(0.329, rel=0.02)


@pytest.mark.parametrize(
    ("law", "constant"), [("uniform", 1.36603), ("two-sided", 1 + 3 * np.sqrt(2 / np.pi / 3000))]
)
def test_the_repeatability_of_a_lumped_angle_has_its_closed_form(law, constant):
    """A joint with a lumped angle of ±b has an RP of 1.36603 b (uniform) or b (two-sided) times its
    lever arm.

    The two-sided limit b is approached slowly: the barycentre of n visits lies off the middle by b
    sqrt(2/pi/n) on average, and RP counts that three times.
    """
    arm = arm_of(
        1,
        gearbox=None,
        bearing=None,
        encoder=None,
        mounting=None,
        lumped={"angle": 1e-4, "law": law},
        link={"length": 1.0},
    )
    found = run(arm, sample_poses(arm, 8), 20, 3000, 1)
    assert found.repeatability[:, 0].mean() == pytest.approx(constant * 1e-4, rel=3e-3)


def test_gravity_closes_backlash_and_improves_repeatability():
    """Gravity closes the backlash of horizontal joints and lowers RP; without gravity the backlash
    adds to RP.
    """
    only = {"backlash": "2 arcmin", "rated_torque": "100 N m"}
    loaded = arm_of(3, gearbox=only, bearing=None, encoder=None, mounting=None, limits=(-0.3, 0.3))
    loose = loaded.model_copy(update={"gravity": 0.0})
    rp = [run(a, sample_poses(a, 8), 20, 30, 1).repeatability[:, 0].mean() for a in (loaded, loose)]
    # the vertical axis carries no gravity torque, so its play stays open
    assert rp[0] < 0.75 * rp[1]


def test_a_fixed_approach_repeats_better_than_a_random_one():
    """Backlash adds nothing to RP where every joint approaches from one side."""
    arm = arm_of(2, gearbox={"backlash": "2 arcmin"}, bearing=None, encoder=None, mounting=None)
    one_side = run(arm, sample_poses(arm, 8), 10, 30, 1, approach=1.0)
    assert one_side.repeatability[:, 0].max() < 1e-12
    assert run(arm, sample_poses(arm, 8), 10, 30, 1).repeatability[:, 0].max() > 1e-5


def test_intervals_cover_at_their_nominal_rate():
    """Over 400 synthetic studies the 95 % intervals of a pooled mean and of a robots' quantile
    cover the true value in about 95 %.
    """
    rng = np.random.default_rng(3)
    mean_covered = quantile_covered = 0
    for _ in range(400):
        # robots and sets of poses both scatter
        means = rng.normal(1, 0.2, 100) + rng.normal(0, 0.05, (8, 1))
        estimate = pooled_mean(means)
        mean_covered += estimate.low <= 1 <= estimate.high
        _, low, high = robots_quantile(rng.uniform(size=500))
        quantile_covered += low <= 0.95 <= high
    assert 0.93 <= mean_covered / 400 <= 0.99
    assert 0.93 <= quantile_covered / 400 <= 0.98


def test_the_interval_of_the_pooled_95_percent_error_covers(arm):
    """The 95 % interval of a small study's pooled 95th percentile covers the value of a long run in
    at least 33 of 40 seeds.
    """
    poses = sample_poses(arm, 64)
    long = run(arm, poses, 4000, 4, 99)
    truth = quantile(long.group_hist.sum(axis=0), 0.95)
    covered = 0
    for seed in range(40):
        found = run(arm, poses, 128, 4, seed)
        estimate = pooled_quantile(found.group_hist, found.replicate_hist[:1], 0.95)
        covered += estimate.low <= truth <= estimate.high
    assert covered >= 33


def test_a_surface_has_no_volume():
    """Three rotations about one point move the tool on a sphere, whose volume is zero."""
    limits = (-1.0, 1.0)
    turns = [
        {"name": name, "type": "revolute", "axis": axis, "limits": limits}
        for name, axis in (("pan", "z"), ("tilt", "y"), ("roll", "x"))
    ]
    arm = lostmotion.Arm.model_validate(
        {"name": "wrist", "joints": turns, "tool": {"frame": {"xyz": (0.3, 0, 0.2)}}}
    )
    assert workspace(arm).volume == 0


def test_an_arm_without_errors_has_zero_error():
    """Mean, quantiles and largest error of a rigid arm without errors are zero, not the lowest bin
    of a histogram.
    """
    ideal = {
        "gearbox": None,
        "bearing": None,
        "encoder": None,
        "mounting": None,
        "link": {"length": 0.4, "rigid": True},
    }
    study = lostmotion.study(arm_of(2, **ideal), 16, robots=10, visits=2)
    rows = next(
        section["rows"] for section in study.result()["sections"] if section["key"] == "error"
    )
    assert {row["figures"][0]["value"] for row in rows} == {0.0}


def test_no_quantile_exceeds_the_largest_sample():
    """Every quantile of a constant error is that constant, and its interval contains it."""
    only = arm_of(
        1,
        gearbox=None,
        bearing=None,
        encoder=None,
        mounting=None,
        lumped={"angle": 1e-3, "law": "two-sided"},
        link={"length": 0.4},
    )
    found = run(only, sample_poses(only, 8), 50, 4, 1)
    estimate = pooled_quantile(
        found.group_hist, found.replicate_hist, 0.95, float(found.per_pose[:, kernel.LARGEST].max())
    )
    assert estimate.value <= found.per_pose[:, kernel.LARGEST].max()
    assert estimate.low <= 0.4e-3 <= estimate.high
    np.testing.assert_allclose(found.per_pose[:, kernel.FIRST_QUANTILE], 0.4e-3, rtol=1e-6)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ({"pose_law": "nrmal"}, "pose_law"),
        ({"approach": "sideways"}, "approach"),
        ({"seed": -1}, "seed"),
        ({"poses": 0}, "poses"),
        ({"robots": 10**7}, "robots"),
        ({"poses": np.zeros((2, 5))}, "q has shape"),
        ({"poses": 10**6, "pose_law": "grid", "visits": 0}, "visits"),
    ],
)
def test_an_invalid_argument_is_rejected_by_name(arm, words, named):
    """A study rejects an invalid argument with a ValueError that names it."""
    with pytest.raises(ValueError, match=named):
        lostmotion.study(arm, **{"poses": 8, "robots": 4, "visits": 2, **words})


def test_poses_in_uneven_sets_are_refused():
    """Ten poses do not divide into three independent sets of equal size."""
    with pytest.raises(lostmotion.InputError, match="divides the 10 poses"):
        lostmotion.Poses(np.zeros((10, 3)), "given", 3)


def test_one_robot_has_no_interval(arm):
    """A single robot has no interval over robots."""
    found = run(arm, sample_poses(arm, 8), 1, 5, 1)
    assert np.isnan(pooled_quantile(found.group_hist, found.replicate_hist, 0.95).low)


@pytest.mark.usual_counts
def test_the_volume_of_a_ball_is_found_within_its_bracket():
    """The tool on a pan, a tilt and a slide from 0.5 to 1 m sweeps a hollow ball of 3.665 m^3."""
    bare = dict.fromkeys(("gearbox", "encoder", "bearing"))
    arm = lostmotion.Arm.model_validate(
        {
            "name": "ball",
            "joints": [
                {"name": "pan", "type": "revolute", "axis": "z", "limits": (-np.pi, np.pi), **bare},
                {
                    "name": "tilt",
                    "type": "revolute",
                    "axis": "y",
                    "limits": (-np.pi / 2, np.pi / 2),
                    **bare,
                },
                {"name": "slide", "type": "prismatic", "axis": "x", "limits": (0.5, 1.0), **bare},
            ],
        },
    )
    space = workspace(arm)
    truth = 4 / 3 * np.pi * (1 - 0.125)
    assert space.volume_low < truth < space.volume_high
    assert space.volume == pytest.approx(truth, rel=0.08)
    assert space.reach == pytest.approx(1, abs=1e-3)
    assert space.nearest == pytest.approx(0.5, abs=1e-3)


def test_a_study_has_the_interface_that_the_readme_states(arm, capsys):
    """A study has the summary, the representation, the arrays and the sections that the README
    states.
    """
    study = lostmotion.study(arm, 16, robots=40, visits=5, seed=1)
    study.summary()
    short = capsys.readouterr().out
    assert "Which part is to blame" in short
    assert len(short.splitlines()) < 50
    study.summary(full=True)
    printed = capsys.readouterr().out
    assert "Position error over the workspace" in printed
    assert "95th percentile" in repr(study)
    assert study.arrays()["error_mean"].attrs["units"] == "m"
    keys = [section["key"] for section in study.result()["sections"]]
    by_level = ["budget_levels", "causes_levels"]
    first = [
        "workspace",
        "error",
        "iso9283",
        "levels",
        "rp_made_of",
        "waterfall",
        "budget",
        "causes",
    ]
    assert keys == [
        *first,
        *by_level,
        "bending",
        "torques",
        "exact_check",
        "states",
        "inputs",
        "laws",
    ]


def test_every_public_name_exists_and_has_a_docstring():
    """The package lists exactly its public names, each with a docstring."""
    for name in lostmotion.__all__:
        assert getattr(lostmotion, name) is not None
        if name != "__version__":
            assert getattr(lostmotion, name).__doc__
    assert len(lostmotion.__all__) < 60  # a list that a reader can take in at once
    assert dir(lostmotion) == sorted(lostmotion.__all__)


def test_a_tolerance_limit_is_never_exceeded():
    """A term from a tolerance reaches its limit at the bound of its distribution and never exceeds
    it.
    """
    (term,) = limit_terms("x", Constant(np.ones(6)), 5e-5, Normal(), Parameter("x"))
    assert term.bound * term.scale == pytest.approx(5e-5, rel=1e-12)
    assert JOINT["link"]["length"] == "400 mm ± 50 µm"
