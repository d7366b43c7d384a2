"""What must hold for every study."""

import numpy as np
import pytest

import lostmotion
from lostmotion import sample_poses, screws, worst_case
from lostmotion.analyses.accuracy.workspace import workspace
from lostmotion.analyses.iso9283.characteristics import pose_repeatability
from lostmotion.error_model.bounds import root_sum_square
from lostmotion.error_model.budget import Tally, costs
from lostmotion.error_model.intervals import pooled_mean, pooled_quantile, quantile, robots_quantile
from lostmotion.laws.distributions import Normal
from lostmotion.parts.forms import Constant
from lostmotion.parts.standard_terms import limit_terms
from lostmotion.parts.term import Parameter
from lostmotion.propagation import exact
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.propagation.montecarlo.sensitivity import halving
from lostmotion.spatial import pose_of
from tests.conftest import JOINT, arm_of

ARCMIN = np.pi / 10800


def small(size: float) -> lostmotion.Arm:
    """Return an arm whose only errors are lumped joint angles of a stated size."""
    lumped = {"angle": size * ARCMIN, "law": "uniform", "offset": size * 1e-5}
    return arm_of(gearbox=None, bearing=None, encoder=None, mounting=None, lumped=lumped, link={"length": 0.4})


def test_the_first_order_sum_equals_exact_composition_and_the_rest_falls_with_the_square():
    """For arcminute errors the difference is below 0.2 % of the 95 % error; a third of the size leaves a ninth of it."""
    left = []
    for size in (3.0, 1.0):
        arm = small(size)
        poses = sample_poses(arm, 64)
        found = run(arm, poses, 64, 4, 1)
        q95 = quantile(found.group_hist.sum(axis=0), 0.95)
        assert found.exact.largest < 0.002 * q95
        left.append(found.exact.largest)
    assert left[0] / left[1] == pytest.approx(9, rel=0.02)


def test_parts_of_every_kind_compose_as_the_first_order_sum_says(arm):
    """With every kind of part at work, halving all errors quarters what first order neglects."""
    matrix = screws(arm, sample_poses(arm, 8).q)
    rows = np.arange(8)
    whole = exact.check(matrix, 0, rows, 1, 20, 5)
    half = matrix.scaled(np.full(len(matrix.infos), 0.5))
    assert whole.mean / exact.check(half, 0, rows, 1, 20, 5).mean == pytest.approx(4, rel=0.02)


def test_no_sample_exceeds_the_worst_case_and_root_sum_square_lies_below_it(arm):
    """RSS <= worst case, and Monte Carlo <= worst case, at every pose."""
    poses = sample_poses(arm, 256)
    found = run(arm, poses, 200, 10, 1)
    assert (found.per_pose[:, kernel.LARGEST] <= found.worst).all()
    assert (found.rss <= found.worst).all()
    assert (found.worst > 0).all()


def test_the_worst_case_is_reached_when_one_error_is_all_there_is():
    """One two-sided angle error: the worst case is the lever times the angle, and every sample is there."""
    arm = arm_of(1, gearbox=None, bearing=None, encoder=None, mounting=None, lumped={"angle": 1e-3, "law": "two-sided"}, link={"length": 0.4})
    matrix = screws(arm, np.zeros((1, 1)))
    assert worst_case(matrix)[0] == pytest.approx(0.4e-3, rel=1e-12)
    assert root_sum_square(matrix)[0] == pytest.approx(0.4e-3, rel=1e-12)
    assert run(arm, sample_poses(arm, 8), 10, 2, 1).per_pose[0, kernel.MEAN] == pytest.approx(0.4e-3, rel=1e-12)


def test_turning_the_base_changes_no_error_size(arm):
    """The same arm bolted to a frame that is turned about the vertical errs as much."""
    turned = arm.model_copy(
        update={
            "joints": (arm.joints[0].model_copy(update={"origin": arm.joints[0].origin.model_copy(update={"rpy": (0, 0, 0.7)})}), *arm.joints[1:])
        }
    )
    q = sample_poses(arm, 64).q
    first, second = screws(arm, q), screws(turned, q)
    rotation = pose_of(rpy=(0, 0, 0.7))[:3, :3]
    np.testing.assert_allclose(second.tool[:, 3:], rotation @ first.tool[:, 3:], atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(second.bias[:, 3:], axis=1), np.linalg.norm(first.bias[:, 3:], axis=1), rtol=1e-9)


def test_mean_square_of_the_samples_is_the_exact_sum_over_terms(arm):
    """|bias|^2 plus the variances is what Monte Carlo finds, within its own interval."""
    poses = sample_poses(arm, 128)
    found = run(arm, poses, 2000, 4, 2)
    sampled = found.per_pose[:, kernel.MEAN_SQUARE].mean()
    assert sampled == pytest.approx(found.tally.total / found.tally.poses, rel=0.01)


def test_shares_add_to_one_and_halving_is_what_a_second_run_finds(arm):
    """Costs per part add to the mean square to 1e-12, and 'if halved' equals the sum with that part's terms halved."""
    matrix = screws(arm, sample_poses(arm, 64).q)
    listed = costs(Tally.of(matrix))
    assert sum(cost.share for cost in listed) == pytest.approx(1, abs=1e-12)
    for cost in listed:
        factor = np.array([0.5 if info.owner == cost.part else 1.0 for info in matrix.infos])
        again = Tally.of(matrix.scaled(factor))
        assert cost.rms_if_halved == pytest.approx(np.sqrt(again.total / again.poses), rel=1e-10)


def test_halving_a_part_that_makes_no_error_buys_nothing(arm):
    """The paired run finds exactly zero for a part with no lever on the tool, and a gain for the largest."""
    arm = arm_of(2, link={"length": 0.0}).model_copy(
        update={"joints": (*arm_of(1).joints, arm_of(2, link={"length": 0.0}, bearing=None, mounting=None).joints[1])}
    )
    poses = sample_poses(arm, 64)
    found = halving(arm, poses, 100, 4, 1)
    assert found.gains["joints.A.gearbox"].value == 0  # turns the tool about itself
    largest = costs(Tally.of(screws(arm, poses.q)))[0].part
    assert found.gains[largest].value == max(gain.value for gain in found.gains.values())
    assert found.gains[largest].low > 0


def test_repeatability_has_the_constants_of_the_standard():
    """RP of isotropic normal scatter tends to 3.61609, 3.21872, 2.60632 sigma in 3, 2, 1 dimensions; at n = 30 it is 3.537 +- 0.329."""
    rng = np.random.default_rng(1)
    for axes, constant in ((3, 3.61609), (2, 3.21872), (1, 2.60632)):
        positions = np.zeros((1_000_000, 3))
        positions[:, :axes] = rng.normal(size=(1_000_000, axes))
        assert pose_repeatability(positions) == pytest.approx(constant, rel=3e-3)
    at_thirty = pose_repeatability(rng.normal(size=(50_000, 30, 3)))
    assert at_thirty.mean() == pytest.approx(3.537, rel=3e-3)
    assert at_thirty.std() == pytest.approx(0.329, rel=0.02)


@pytest.mark.parametrize(("law", "constant"), [("uniform", 1.36603), ("two-sided", 1 + 3 * np.sqrt(2 / np.pi / 3000))])
def test_the_engine_repeats_like_the_standard_says(law, constant):
    """A joint with a lumped angle of +-b repeats within 1.36603 b (uniform) or b (stop to stop) times its lever.

    Stop to stop the limit b is reached slowly: the barycentre of n visits lies off the middle by b sqrt(2/pi/n) on average, and RP
    counts that three times.
    """
    arm = arm_of(1, gearbox=None, bearing=None, encoder=None, mounting=None, lumped={"angle": 1e-4, "law": law}, link={"length": 1.0})
    found = run(arm, sample_poses(arm, 8), 20, 3000, 1)
    assert found.repeatability[:, 0].mean() == pytest.approx(constant * 1e-4, rel=3e-3)


def test_play_closes_under_load_and_opens_without():
    """Under gravity the horizontal joints repeat; without gravity their backlash shows in repeatability."""
    only = {"backlash": "2 arcmin", "rated_torque": "100 N m"}
    held = arm_of(3, gearbox=only, bearing=None, encoder=None, mounting=None, limits=(-0.3, 0.3))
    loose = held.model_copy(update={"gravity": 0.0})
    rp = [run(a, sample_poses(a, 8), 20, 30, 1).repeatability[:, 0].mean() for a in (held, loose)]
    assert rp[0] < 0.75 * rp[1]  # the vertical axis carries no gravity torque and stays loose


def test_arriving_always_from_one_side_repeats_better_than_from_either():
    """With a stated approach the play takes one side and leaves repeatability alone."""
    arm = arm_of(2, gearbox={"backlash": "2 arcmin"}, bearing=None, encoder=None, mounting=None)
    one_side = run(arm, sample_poses(arm, 8), 10, 30, 1, approach=1.0)
    assert one_side.repeatability[:, 0].max() < 1e-12
    assert run(arm, sample_poses(arm, 8), 10, 30, 1).repeatability[:, 0].max() > 1e-5


def test_intervals_hold_the_truth_as_often_as_they_say():
    """Over 400 synthetic studies the 95 % interval of a pooled mean and of a robots' quantile holds the truth in about 95 %."""
    rng = np.random.default_rng(3)
    mean_held = quantile_held = 0
    for _ in range(400):
        means = rng.normal(1, 0.2, 100) + rng.normal(0, 0.05, (8, 1))  # robots that differ, seen over sets of poses that differ
        estimate = pooled_mean(means)
        mean_held += estimate.low <= 1 <= estimate.high
        _, low, high = robots_quantile(rng.uniform(size=500))
        quantile_held += low <= 0.95 <= high
    assert 0.93 <= mean_held / 400 <= 0.99
    assert 0.93 <= quantile_held / 400 <= 0.98


def test_the_interval_of_the_pooled_95_percent_error_covers(arm):
    """Repeating a whole small study with other seeds, its 95 % interval holds the long run's value most of the time."""
    poses = sample_poses(arm, 256)
    long = run(arm, poses, 4000, 4, 99)
    truth = quantile(long.group_hist.sum(axis=0), 0.95)
    held = 0
    for seed in range(40):
        found = run(arm, poses, 128, 4, seed)
        estimate = pooled_quantile(found.group_hist, found.replicate_hist[:1], 0.95)
        held += estimate.low <= truth <= estimate.high
    assert held >= 33


def test_a_surface_has_no_volume():
    """Three turns about one point carry the tool over a sphere: a surface, whatever the grid."""
    limits = (-1.0, 1.0)
    turns = [{"name": name, "type": "revolute", "axis": axis, "limits": limits} for name, axis in (("pan", "z"), ("tilt", "y"), ("roll", "x"))]
    arm = lostmotion.Arm.model_validate({"name": "wrist", "joints": turns, "tool": {"frame": {"xyz": (0.3, 0, 0.2)}}})
    assert workspace(arm).volume == 0


def test_an_arm_without_errors_errs_by_nothing():
    """An arm stated to be rigid, without other errors: mean, quantiles and largest are zero, not a histogram's lowest bin."""
    ideal = {"gearbox": None, "bearing": None, "encoder": None, "mounting": None, "link": {"length": 0.4, "rigid": True}}
    study = lostmotion.study(arm_of(2, **ideal), 16, robots=10, visits=2)
    rows = next(section["rows"] for section in study.result()["sections"] if section["key"] == "error")
    assert {row["figures"][0]["value"] for row in rows} == {0.0}


def test_no_quantile_exceeds_the_largest_sample():
    """Where the error is one constant, every quantile is that constant, and the interval holds it."""
    only = arm_of(1, gearbox=None, bearing=None, encoder=None, mounting=None, lumped={"angle": 1e-3, "law": "two-sided"}, link={"length": 0.4})
    found = run(only, sample_poses(only, 8), 50, 4, 1)
    estimate = pooled_quantile(found.group_hist, found.replicate_hist, 0.95, float(found.per_pose[:, kernel.LARGEST].max()))
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
def test_nonsense_is_refused_by_name(arm, words, named):
    """A wrong word or number in a call is one clear error, and an InputError is a ValueError."""
    with pytest.raises(ValueError, match=named):
        lostmotion.study(arm, **{"poses": 8, "robots": 4, "visits": 2, **words})


def test_poses_in_uneven_sets_are_refused():
    """Ten poses cannot be three independent sets of equal size."""
    with pytest.raises(lostmotion.InputError, match="divides the 10 poses"):
        lostmotion.Poses(np.zeros((10, 3)), "given", 3)


def test_one_robot_gives_no_interval(arm):
    """Nothing is claimed of other robots when only one was built."""
    found = run(arm, sample_poses(arm, 8), 1, 5, 1)
    assert np.isnan(pooled_quantile(found.group_hist, found.replicate_hist, 0.95).low)


def test_the_volume_of_a_ball_is_found_within_its_bracket():
    """A pan, a tilt and a slide from 0.5 to 1 m sweep a hollow ball of 3.665 m^3."""
    bare = dict.fromkeys(("gearbox", "encoder", "bearing"))
    arm = lostmotion.Arm.model_validate(
        {
            "name": "ball",
            "joints": [
                {"name": "pan", "type": "revolute", "axis": "z", "limits": (-np.pi, np.pi), **bare},
                {"name": "tilt", "type": "revolute", "axis": "y", "limits": (-np.pi / 2, np.pi / 2), **bare},
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


def test_the_front_door_keeps_its_promise(arm, capsys):
    """The README's sentence works: read aside, study, summary, repr, arrays and plain figures."""
    study = lostmotion.study(arm, 16, robots=40, visits=5, seed=1)
    study.summary()
    printed = capsys.readouterr().out
    assert "Position error over the workspace" in printed
    assert "95th percentile" in repr(study)
    assert study.arrays()["error_mean"].attrs["units"] == "m"
    keys = [section["key"] for section in study.result()["sections"]]
    by_level = ["budget_levels", "causes_levels"]
    first = ["workspace", "error", "iso9283", "levels", "waterfall", "budget", "causes"]
    assert keys == [*first, *by_level, "bending", "torques", "exact_check", "states", "assumed"]


def test_every_public_name_opens_and_none_is_missing():
    """The front door lists exactly what it can give, with a docstring each."""
    for name in lostmotion.__all__:
        assert getattr(lostmotion, name) is not None
        if name != "__version__":
            assert getattr(lostmotion, name).__doc__
    assert len(lostmotion.__all__) < 45  # few enough to be read at once
    assert dir(lostmotion) == sorted(lostmotion.__all__)


def test_a_tolerance_limit_is_never_left():
    """A term made from a limit reaches it at the law's bound and no further."""
    (term,) = limit_terms("x", Constant(np.ones(6)), 5e-5, Normal(), Parameter("x"))
    assert term.bound * term.scale == pytest.approx(5e-5, rel=1e-12)
    assert JOINT["link"]["length"] == "400 mm ± 50 µm"
