"""Error budget: exact shares by part, cause, level and term, at a pose, over the workspace and in a
zone, and the gain from halving each.
"""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion import sample_poses
from lostmotion.error_model.budget import LABELS, Tally, budget, costs, label_of, tally
from lostmotion.error_model.intervals import Estimate, quantile, quantile_drop
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.io.pose_and_zone_text import read_pose, read_zone
from lostmotion.parts.link import Link
from lostmotion.propagation.analytic import DrawnColumns, of_screws
from lostmotion.propagation.montecarlo import montecarlo
from lostmotion.propagation.montecarlo.common_random_numbers import Paired
from lostmotion.propagation.montecarlo.sensitivity import halving
from tests.arms import arm_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "what halving a part takes off",
        "a second study with those errors halved; 100 paired studies",
        "1e-9; 90 % of the intervals cover",
        "propagation/montecarlo/sensitivity.py propagation/montecarlo/common_random_numbers.py",
    ),
)

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


@pytest.fixture(scope="module")
def study(arm):
    """Return a short study of the arm with every kind of error."""
    return lostmotion.study(arm, 64, 40, 4, threads=1)


@pytest.mark.parametrize("by", list(LABELS))
def test_shares_add_to_one_for_any_grouping_of_terms(arm, by):
    """Shares add to one within 1e-12, levels add to their share, and 'if halved' equals the sum of
    scaled terms, over poses and at one pose.
    """
    label = label_of(by)
    assert {cost.name for cost in costs(tally(arm, sample_poses(arm, 8).q, by))} == {
        label(info) for info in pose_matrix(arm, sample_poses(arm, 8).q).infos
    }
    for q in (sample_poses(arm, 64).q, np.array([[0.3, -0.2, 0.8]])):
        found = costs(tally(arm, q, by))
        assert sum(cost.share for cost in found) == pytest.approx(1, abs=1e-12)
        matrix = pose_matrix(arm, q)
        for cost in found:
            assert sum(cost.levels) == pytest.approx(cost.share, abs=1e-12)
            factors = np.array([0.5 if label(info) == cost.part else 1.0 for info in matrix.infos])
            again = Tally.of(matrix.scaled(factors))
            assert cost.rms_if_halved == pytest.approx(
                np.sqrt(again.total / again.poses), rel=1e-10
            )


def test_shares_are_those_of_the_sum_written_out(arm):
    """At one pose the share of a part equals the projection of its terms on the sum of all terms of
    the same draw.
    """
    q = np.array([[0.3, -0.2, 0.8]])
    matrix = pose_matrix(arm, q)
    shift = matrix.tool[0, 3:]
    together = [
        sum(
            (shift[:, j] for j, other in enumerate(matrix.infos) if other.draws == info.draws),
            np.zeros(3),
        )
        for info in matrix.infos
    ]
    by_term = (shift * np.transpose(together)).sum(axis=0)
    whole = by_term.sum()
    by_term /= whole
    bias = shift[:, [info.level == "design" for info in matrix.infos]].sum(axis=1)
    for cost in costs(tally(arm, q)):
        mine = [info.owner == cost.part for info in matrix.infos]
        assert cost.share == pytest.approx(by_term[mine].sum(), abs=1e-13)
    levels = {cost.part: cost.share for cost in costs(tally(arm, q, "level"))}
    assert levels["design"] == pytest.approx(bias @ bias / whole, abs=1e-13)
    assert sum(budget(arm, q).parts[0].levels) == pytest.approx(
        budget(arm, q).parts[0].share, abs=1e-13
    )


def test_a_term_of_zero_size_has_zero_share():
    """The gearbox of a wrist whose axis passes through the tool point has zero share, because it
    has no lever arm.
    """
    wrist = arm_of(2, link={"length": 0.0}, bearing=None, mounting=None)
    whole = arm_of(2).model_copy(
        update={"joints": (*arm_of(2).joints, wrist.joints[1].model_copy(update={"name": "W"}))}
    )
    q = sample_poses(whole, 16).q
    shares = {cost.part: cost for cost in costs(tally(whole, q, "term"))}
    without_lever = [cost for name, cost in shares.items() if name.startswith("joints.W.gearbox")]
    assert without_lever
    for cost in without_lever:
        assert (cost.share, cost.alone, cost.levels) == (0, 0, (0, 0, 0))


def test_a_cause_is_one_kind_of_error_over_all_joints(arm):
    """A cause adds one kind of error over all joints, for example all backlash or all harmonics."""
    causes = {cost.part for cost in budget(arm, sample_poses(arm, 16).q).causes}
    assert causes == {
        "gearbox wind-up",
        "gearbox stiffness scatter",
        "gearbox backlash",
        "gearbox hysteresis",
        "gearbox transmission error",
        "bearing clearance",
        "encoder resolution",
        "encoder noise",
        "encoder eccentricity",
        "encoder zero",
        "mounting axis tilt",
        "mounting axis offset",
        "link length",
        "link bending under load",
        "link sag under own weight",
    }


def test_a_pose_by_number_by_value_and_in_a_zone_is_the_same_pose(study):
    """A pose has the same costs by its number, by its joint values and as a zone of one pose, and a
    zone of all poses has the costs of the study.
    """
    mask = np.arange(len(study.poses)) == 7
    found = study.costs(at=7)
    assert found == study.costs(at=study.poses.q[7]) == study.costs(zone=mask)
    everywhere = study.costs(zone=np.ones(len(mask), dtype=bool))
    assert (
        [cost.part for cost in everywhere]
        == [cost.part for cost in study.costs()]
        == [cost.part for cost in study.budget.parts]
    )
    for cost, of_study in zip(everywhere, costs(study.sampled.tally), strict=True):
        assert cost.share == pytest.approx(of_study.share, abs=1e-12)


def test_mean_squares_of_two_zones_add_up_to_the_workspace(study):
    """The mean squares of a zone and of the remaining poses, weighted by their numbers of poses,
    add up to that of the workspace.
    """
    middle = float(np.median(study.tool[:, 2]))
    low, high = (
        study.with_budget(zone={"z": (-10, middle)}),
        study.with_budget(zone={"z": (np.nextafter(middle, 10), 10)}),
    )
    parts = [found.budgets[0] for found in (low, high)]
    assert sum(part.poses for part in parts) == len(study.poses)
    squares = sum(part.poses * part.rms**2 for part in parts)
    assert squares == pytest.approx(len(study.poses) * study.budget.rms**2, rel=1e-12)
    keys = [section.key for section in low.sheet.sections]
    assert {"budget_at_1", "causes_at_1"} <= set(keys)
    assert "-10000 … " in next(
        section.title for section in low.sheet.sections if section.key == "budget_at_1"
    )


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ({"at": 64}, "from 0 to 63"),
        ({"at": -1}, "from 0 to 63"),
        ({"at": [0.0, 1.0]}, "3 finite joint values"),
        ({"at": [0.0, 1.0, np.nan]}, "3 finite joint values"),
        ({"zone": {"x": (5, 6)}}, "none of the 64 poses"),
        ({"zone": {"w": (0, 1)}}, "x, y or z"),
        ({"zone": {"x": (1, 0)}}, "the lower one first"),
        ({"zone": np.ones(3, dtype=bool)}, "each of the 64 poses"),
        ({"at": 1, "zone": {"x": (0, 1)}}, "one of them"),
        ({"by": "gearbox"}, "part, cause, level, term"),
    ],
)
def test_invalid_poses_and_zones_are_rejected(study, words, named):
    """A budget rejects a number beyond the poses, a wrong number of joint values and a zone without
    poses.
    """
    with pytest.raises(lostmotion.InputError, match=named):
        study.costs(**words)


def test_a_pose_and_a_zone_are_read_from_a_line_of_text(arm):
    """A line of text states a pose by its number or by joint values with units in any order, and a
    zone by limits that may share a unit.
    """
    np.testing.assert_allclose(
        read_pose("B=-10deg O = 0.1rad, A=30 deg", arm), [0.1, np.radians(30), np.radians(-10)]
    )
    assert read_pose(" 17 ", arm) == 17
    assert read_zone("x 0.2..0.5 m, Y -100 .. 1e2 mm") == {"x": (0.2, 0.5), "y": (-0.1, 0.1)}
    assert read_zone("x 200 mm..0.5m, z -10mm .. 1 m") == {"x": (0.2, 0.5), "z": (-0.01, 1)}


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("A=30deg", "no value for"),
        ("A=30deg B=10deg O=1", "unit"),
        ("A=30deg B=10deg O=500deg", "within its limits"),
        ("A=30deg A=30deg B=1deg O=0deg", "twice"),
        ("Z=30deg A=1deg B=1deg O=0deg", "each joint once"),
        ("A=30mm B=10deg O=0deg", "A=30mm"),
        ("up", "joint=value"),
        ("A=1deg " * 1000, "at most 2000"),
        ("", "no value for"),
        ("-3", "joint=value"),
    ],
)
def test_text_that_is_no_pose_is_rejected(arm, text, named):
    """Invalid text for a pose causes one message that names the mistake."""
    with pytest.raises(lostmotion.InputError, match=named):
        read_pose(text, arm)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "no '..'"),
        ("x 1..2", "no unit"),
        ("q 1..2 m", "no axis 'q'"),
        ("1..2 m", "no axis, and a space,"),
        ("x 2..1 m", "higher end stands first"),
        ("x 300 mm..0.2 m", "higher end stands first"),
        ("x 1..2 m, X 1..2 m", "x comes twice"),
        ("x 1..2 kg", "not a unit of length"),
        ("x 1.2 m", "no '..'"),
        ("x -inf..2 m", "no numbers with their unit"),
    ],
)
def test_text_that_is_no_zone_is_rejected(text, why):
    """Invalid text for a zone causes one message with the mistake, its reason and a valid
    example.
    """
    with pytest.raises(lostmotion.InputError, match=why) as refused:
        read_zone(text)
    assert "lower one first" in str(refused.value)


def test_a_part_that_moves_the_tool_by_rounding_alone_has_zero_share():
    """The last joint of the Z-arm, whose axis passes through the tool point, has 0 % share and zero
    gain without an interval. Its link is rigid here: one that bends takes the tool off the axis.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    *others, roll = arm.joints
    rigid = Link(length=roll.link.length, mass=0.3, rigid=True)
    arm = arm.model_copy(update={"joints": (*others, roll.model_copy(update={"link": rigid}))})
    study = lostmotion.study(arm, 32, 20, 2)
    matrix = pose_matrix(arm, study.poses.q)
    size = sum(
        matrix.squares[k].sum()
        for k, info in enumerate(matrix.infos)
        if info.owner == "joints.roll.gearbox"
    )
    assert 0 < size < 1e-30  # rounding error alone
    sections = {
        section.key: {row.label: row for row in section.rows} for section in study.sheet.sections
    }
    for part in ("roll.gearbox", "roll.encoder"):
        alone, share, gain = sections["budget"][part].cells
        assert [str(figure) for figure in (alone, share, gain)] == ["0 µm", "0 %", "0 µm"]
        assert gain.interval == ""
        assert part not in sections["budget_levels"]
    assert sections["budget"]["O.gearbox"].cells[2].interval
    assert study.halving.gains["joints.roll.gearbox"] == Estimate(0, 0, 0)


@pytest.mark.parametrize("by", ["part", "term"])
def test_the_gain_from_halving_equals_a_second_run(arm, monkeypatch, by):
    """The gain from halving a part, cause or term equals the drop of the 95th percentile in a
    second run with those terms halved.
    """
    poses = sample_poses(arm, 64)
    found = halving(arm, poses, 40, 4, 1, by=by)
    for gains, label in ((found.gains, label_of(by)), (found.causes, label_of("cause"))):
        largest = max(gains, key=lambda name, gains=gains: gains[name].value)

        def halved(*words, label=label, largest=largest, **options):
            matrix = pose_matrix(*words, **options)
            return matrix.scaled(
                np.array([0.5 if label(info) == largest else 1.0 for info in matrix.infos])
            )

        monkeypatch.setattr(montecarlo, "pose_matrix", halved)
        again = montecarlo.run(arm, poses, 40, 4, 1)
        gain = gains[largest]
        assert gain.value == pytest.approx(
            found.before - quantile(again.group_hist.sum(axis=0), 0.95), rel=1e-9
        )
        assert gain.low < gain.value < gain.high


def test_the_gain_from_halving_at_a_pose_equals_the_analytic_gain():
    """At one pose of the Z-arm the sampled gains of the largest three parts equal the analytic
    gains within their interval and 3 %.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    poses = sample_poses(arm, 8)
    matrix = pose_matrix(arm, poses.q[5:6])
    study = lostmotion.study(arm, poses, 20, 2).with_budget(at=5)
    found = study.budgets[0].halving
    assert found.samples == 4 * 65_536
    before = of_screws(matrix, DrawnColumns(matrix))
    for part in sorted(found.gains, key=lambda name: -found.gains[name].value)[:3]:
        halved = matrix.scaled(
            np.array([0.5 if info.owner == part else 1.0 for info in matrix.infos])
        )
        after = of_screws(halved, DrawnColumns(halved))
        difference = abs(
            found.gains[part].value - float(before.quantiles[0, 1] - after.quantiles[0, 1])
        )
        assert found.gains[part].value > 20e-6
        assert (
            difference
            < (found.gains[part].high - found.gains[part].value) + 0.03 * found.gains[part].value
        )
    section = next(each for each in study.sheet.sections if each.key == "halving_at_1")
    assert {"A.gearbox", "gearbox wind-up, at every joint"} <= {row.label for row in section.rows}


@pytest.mark.slow
def test_the_interval_of_a_paired_drop_covers():
    """At least 90 of 100 paired studies of one halved gearbox have an interval that covers the mean
    of 24 larger studies.
    """
    small = arm_of(2, bearing=None, encoder=None, mounting=None)

    def gain(poses, robots, seed):
        paired = Paired.of(small, sample_poses(small, poses, seed=seed), robots, 4, seed, 0.0)
        before, after = (
            paired.run(
                np.array(
                    [
                        factor if info.owner == "joints.A.gearbox" else 1.0
                        for info in paired.matrix.infos
                    ]
                )
            )
            for factor in (1.0, 0.5)
        )
        return quantile_drop((before.groups, before.sets), (after.groups, after.sets), 0.95)

    truth = np.mean([gain(512, 128, 1000 + k).value for k in range(24)])
    covered = sum(
        found.low <= truth <= found.high for found in (gain(64, 64, seed) for seed in range(100))
    )
    assert covered >= 90


def test_blocks_of_poses_add_up(arm):
    """The tally of two blocks of poses is the sum of their tallies, and tallies of different arms
    do not add.
    """
    q = sample_poses(arm, 2048).q
    whole, first, second = (
        tally(arm, q, "cause"),
        tally(arm, q[:1024], "cause"),
        tally(arm, q[1024:], "cause"),
    )
    for name in ("own", "shared", "levels"):
        np.testing.assert_allclose(getattr(whole, name), getattr(first + second, name), rtol=1e-12)
    with pytest.raises(ValueError, match="different arms"):
        _ = first + dataclasses.replace(second, owners=())


def test_the_interval_of_an_rms_error_covers_the_choice_of_poses():
    """At least 34 of 40 intervals from eight sets of poses cover the r.m.s. error over many poses,
    and stated poses have no interval.
    """
    arm = arm_of(2, bearing=None, mounting=None)
    many = budget(arm, sample_poses(arm, 8192, seed=77).q)
    covered = dict.fromkeys([(0, 1, 2), (0,), (1,), (2,)], 0)
    true = {levels: many.rms_interval(*levels).value for levels in covered}
    for seed in range(40):
        poses = sample_poses(arm, 64, "uniform", seed=1000 + seed)
        found = budget(arm, poses.q, replicates=poses.replicates)
        assert found.rms_interval().value == pytest.approx(found.rms, rel=1e-12)
        for levels in covered:
            rms = found.rms_interval(*levels)
            covered[levels] += rms.low <= true[levels] <= rms.high
    # 95 % of 40, less three standard deviations
    assert all(34 <= count <= 40 for count in covered.values()), covered
    assert found.rms_interval().high < 1.5 * found.rms_interval().low
    given = budget(arm, sample_poses(arm, 64).q).rms_interval()
    assert np.isnan(given.low)
    assert np.isnan(given.high)


def test_backlash_varies_per_visit_without_a_stated_last_motion():
    """The backlash of an unloaded joint is a design error of half its width for a stated approach,
    and varies per visit without one.
    """
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "z",
        "limits": (-1, 1),
        "gearbox": {"backlash": "2 arcmin"},
        "link": {"length": "1 m"},
    }
    arm, q = (
        lostmotion.Arm.model_validate({"name": "unloaded", "joints": [joint]}),
        np.array([[0.2]]),
    )
    assert budget(arm, q).levels == pytest.approx((0, 0, 1))
    assert budget(arm, q, approach=-1.0).levels == pytest.approx((1, 0, 0))
    assert budget(arm, q).rms == pytest.approx(budget(arm, q, approach=-1.0).rms)
