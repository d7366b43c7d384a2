"""A study stops when its figures reach the requested precision, and reports when they do not."""

import numpy as np
import pytest

import lostmotion
from lostmotion import sample_poses
from lostmotion.error_model.robot_intervals import two_way
from lostmotion.propagation.montecarlo.stopping import (
    STAGES,
    SamplingStage,
    Tolerance,
    Watched,
    _capped,
    settle,
)
from tests.arms import arm_of
from tests.reporting.first_screen import first_screen

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "precision asked for with --until",
        "1 000 synthetic studies; coverage of the last intervals",
        "99 % reach it; 92 to 98 % cover the true value",
        "propagation/montecarlo/stopping.py",
    ),
)

SETS = 8


def synthetic(seed, of_robots, of_cells, of_poses):
    """Return the sampler of a synthetic study with true value 1, whose robots, sets of poses and
    cells scatter; more robots keep the first ones.
    """
    of_all_robots = np.random.default_rng([seed, 1]).normal(0, of_robots, 50_000)

    def sample(poses, robots):
        rng = np.random.default_rng([seed, 2, poses])
        of_sets = rng.normal(0, of_poses / np.sqrt(poses / SETS), (SETS, 1))
        return (
            1
            + of_all_robots[:robots]
            + of_sets
            + rng.normal(0, of_cells / np.sqrt(poses / SETS), (SETS, robots))
        )

    return sample


def watch(values):
    """Return the grand mean with its half-width and the share that the poses contribute to its
    variance.
    """
    spread = two_way(values)
    whole = spread.of_poses + spread.of_robots
    return {"mean": Watched("mean", float(values.mean()), spread.half, spread.of_poses / whole)}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pilot", "until", "scatter"), [(50, "1 %", (0.3, 0.0, 0.0)), (40, "2 %", (0.3, 0.5, 0.2))]
)
def test_intervals_at_the_stop_cover_the_true_value(pilot, until, scatter):
    """Of 1 000 synthetic studies 99 % reach the requested precision, and 92 to 98 % of their last
    intervals cover the true value.
    """
    covered = reached = 0
    for seed in range(1000):
        values, stopping = settle(
            synthetic(seed, *scatter),
            watch,
            64,
            pilot,
            Tolerance.of(until),
            most_poses=65_536,
            most_robots=50_000,
        )
        figure = stopping.stages[-1].figures["mean"]
        covered += abs(values.mean() - 1) <= figure.half
        reached += stopping.reached
        assert stopping.reached == (figure.half <= stopping.tolerance.share * figure.value)
    assert 0.92 <= covered / 1000 <= 0.98
    assert reached / 1000 >= 0.99


def test_most_studies_stop_after_two_stages():
    """Of 100 studies at least 80 stop after the second stage, and none takes more than four
    stages.
    """
    stages = []
    for seed in range(100):
        _, stopping = settle(
            synthetic(seed, 0.3, 0, 0),
            watch,
            64,
            50,
            Tolerance.of(0.02),
            most_poses=64,
            most_robots=50_000,
        )
        stages.append(len(stopping.stages))
    assert stages.count(2) >= 80
    assert max(stages) <= STAGES


def test_an_intermediate_stage_comes_before_a_large_one():
    """An intermediate stage avoids most of the samples where the scatter of poses falls faster than
    assumed.
    """

    def sobol(poses, robots):
        rng = np.random.default_rng([7, poses])
        # error as 1 / poses
        return (
            1
            + np.random.default_rng(3).normal(0, 0.3, 50_000)[:robots]
            + rng.normal(0, 6 / poses, (SETS, 1))
        )

    _, stopping = settle(
        sobol, watch, 64, 50, Tolerance.of("2 %"), most_poses=65_536, most_robots=50_000
    )
    samples = [stage.poses * stage.robots for stage in stopping.stages]
    assert stopping.reached
    assert 3 <= len(samples) <= STAGES
    assert 2 < samples[1] / samples[0] <= 8.1
    half = stopping.stages[-1].figures["mean"].relative
    assert half > 0.008  # not several times more precise than requested
    # A study far from the requested precision also reaches it.
    _, distant = settle(
        synthetic(1, 0.3, 0.5, 0.2),
        watch,
        64,
        20,
        Tolerance.of("0.5 %"),
        most_poses=65_536,
        most_robots=50_000,
    )
    assert distant.reached


def test_a_stage_grows_by_up_to_sixty_four_and_by_eight_where_more_is_needed():
    """A stage takes at most 64 times the samples, and eight times where it seems to need more,
    since few sets of poses estimate variances poorly.
    """
    stage = SamplingStage(64, 20, {})
    assert _capped(stage, 64 * 8, 20 * 8) == (64 * 8, 20 * 8)
    poses, robots = _capped(stage, 64 * 16, 20 * 16)
    assert poses * robots == pytest.approx(8 * 64 * 20, rel=0.05)
    # the poses do not change and the robots suffice
    assert _capped(SamplingStage(64, 30, {}), 64, 30 * 1000) == (64, 30 * 1000)


def test_a_missed_precision_is_reported_with_its_reason():
    """A study limited by its robots or its fixed poses takes the largest allowed number and reports
    which of the two limits it.
    """
    _, short = settle(
        synthetic(1, 0.3, 0, 0), watch, 64, 50, Tolerance.of(0.01), most_poses=64, most_robots=400
    )
    assert (short.reached, short.limited_by, short.stages[-1].robots) == (False, "robots", 400)
    _, fixed = settle(
        synthetic(1, 0.01, 0, 0.3),
        watch,
        64,
        50,
        Tolerance.of(0.01),
        most_poses=64,
        most_robots=400,
    )
    assert (fixed.reached, fixed.limited_by) == (False, "poses")
    assert fixed.missed == ("mean",)


def test_a_precise_pilot_run_ends_the_study():
    """A pilot run of the requested precision, or without any error, ends the study."""
    _, easy = settle(synthetic(1, 0.01, 0, 0), watch, 64, 100, Tolerance.of(0.05), most_poses=64)
    assert len(easy.stages) == 1
    assert easy.reached
    ideal = settle(
        lambda *_: 0,
        lambda _: {"mean": Watched("mean", 0.0, 0.0, 0.0)},
        64,
        10,
        Tolerance.of("3 digits"),
        most_poses=64,
    )[1]
    assert ideal.reached


def test_digits_mean_half_a_unit_of_the_last_one():
    """Two significant digits of 0.4633 mean a half-width of 0.005, and of 1234 one of 50 (JCGM 101,
    7.9.2).
    """
    two = Tolerance.of("2 digits")
    assert two.half(0.4633) == pytest.approx(0.005)
    assert two.half(1234.0) == pytest.approx(50)
    assert Tolerance.of("1 %").half(0.5) == pytest.approx(0.005)
    assert str(two) == "2 significant digits"


@pytest.mark.parametrize(
    "until", ["1", "one %", "0 %", "80 %", "9 digits", "2.5 digits", 0.0001, -1.0, float("nan"), ""]
)
def test_an_invalid_precision_is_rejected(until):
    """A precision is a percentage or a number of digits, and anything else is rejected."""
    with pytest.raises(lostmotion.InputError, match="until"):
        Tolerance.of(until)


def test_a_study_with_a_stopping_rule_is_the_study_of_its_last_stage():
    """A study with a stopping rule has the bits of a study with the counts of its last stage, and
    reports the requested and the reached precision.
    """
    arm = arm_of(2)
    found = lostmotion.study(arm, 64, 40, 3, until="8 %", threads=1)
    assert found.stopping is not None
    assert found.stopping.reached
    last = found.stopping.stages[-1]
    assert (len(found.poses), found.sampled.robots) == (last.poses, last.robots)
    again = lostmotion.study(arm, last.poses, last.robots, 3, threads=1)
    np.testing.assert_array_equal(found.sampled.robot_means, again.sampled.robot_means)
    assert f"Reached ±8 % after {last.robots} robots and {last.poses} poses." in first_screen(
        found.sheet
    )
    rows = next(section for section in found.sheet.sections if section.key == "stopping").rows
    assert [row.key for row in rows] == list(last.figures)
    assert rows[1].cells[-1].as_shown == pytest.approx(100 * last.figures["p95"].relative)


def test_a_study_adds_poses_where_their_choice_limits_its_precision():
    """A study extends its sequence of poses where their choice limits the precision, but never adds
    to poses that the user states.
    """
    arm = arm_of(2)
    stages = lostmotion.study(arm, 16, 100, 1, until="5 %", threads=1).stopping.stages
    assert stages[0].poses == 16 < stages[-1].poses
    given = lostmotion.study(
        arm, sample_poses(arm, 16).q, 100, 1, until="5 %", most_robots=300, threads=1
    ).stopping
    assert {stage.poses for stage in given.stages} == {16}
    assert given.most_poses == 16


def test_a_study_reports_that_it_missed_the_precision():
    """A study with too few robots reports the widest half-width and its figure, and rejects a
    stopping rule that it cannot apply.
    """
    found = lostmotion.study(
        arm_of(2), np.zeros((1, 2)), 100, 3, until="0.5 %", most_robots=120, threads=1
    )
    assert "Did not reach ±0.5 %: half-width" in first_screen(found.sheet)
    assert "after the most robots allowed, 120" in first_screen(found.sheet)
    with pytest.raises(lostmotion.InputError, match="most_robots"):
        lostmotion.study(arm_of(2), 8, 100, 3, until="1 %", most_robots=50)
    with pytest.raises(lostmotion.InputError, match="until"):
        lostmotion.study(arm_of(2), 8, 100, 3, until="1 %", method="analytic")


def test_a_half_width_that_needs_more_robots_is_not_known():
    """The 95th percentile of 24 robots has no upper end, and the stage states "not known" instead
    of a number.
    """
    found = lostmotion.study(
        arm_of(2), np.zeros((1, 2)), 24, 3, until="50 %", most_robots=24, threads=1
    )
    rows = next(section for section in found.sheet.sections if section.key == "stopping").rows
    printed = {row.label: str(row.cells[0]) for row in rows}
    assert printed["AP, 95th percentile of robots"] == "not known"
    assert not any("nan" in text for text in printed.values())


@pytest.mark.parametrize(("pilot", "margin"), [(100, 0.85), (20, 0.6)])
def test_the_last_stage_takes_a_larger_margin_only_where_an_earlier_one_was_capped(pilot, margin):
    """The robots grow by the square of the ratio of half-widths with a margin of 85 %, or of 60 %
    where a small pilot run capped the growth.
    """
    # an estimated scatter that grows with the number of robots
    halves = {1: 1.0, 2: 0.5, 3: 0.12, 4: 0.01}
    runs = []
    _, stopping = settle(
        lambda _, robots: runs.append(robots) or len(runs),
        lambda run: {"mean": Watched("mean", 1.0, halves[run], 0.0)},
        64,
        pilot,
        Tolerance.of("10 %"),
        most_poses=64,
        most_robots=10**9,
    )
    assert stopping.reached
    assert runs[3] / runs[2] == pytest.approx((1.2 / margin) ** 2, rel=1e-3)
