"""A study stops when its figures have the precision asked for, and reports when they do not."""

import numpy as np
import pytest

import lostmotion
from lostmotion import sample_poses
from lostmotion.error_model.intervals import two_way
from lostmotion.propagation.montecarlo.stopping import STAGES, Stage, Tolerance, Watched, _capped, settle
from tests.conftest import arm_of

SETS = 8


def synthetic(seed, of_robots, of_cells, of_poses):
    """Return a study of a quantity whose true value is 1: robots, poses and cells that differ; more robots keep the first ones."""
    robots_there_are = np.random.default_rng([seed, 1]).normal(0, of_robots, 50_000)

    def sample(poses, robots):
        rng = np.random.default_rng([seed, 2, poses])
        of_sets = rng.normal(0, of_poses / np.sqrt(poses / SETS), (SETS, 1))
        return 1 + robots_there_are[:robots] + of_sets + rng.normal(0, of_cells / np.sqrt(poses / SETS), (SETS, robots))

    return sample


def watch(values):
    """Watch the grand mean."""
    spread = two_way(values)
    whole = spread.of_poses + spread.of_robots
    return {"mean": Watched(float(values.mean()), spread.half, spread.of_poses / whole)}


@pytest.mark.slow
@pytest.mark.parametrize(("pilot", "until", "scatter"), [(50, "1 %", (0.3, 0.0, 0.0)), (40, "2 %", (0.3, 0.5, 0.2))])
def test_the_rule_covers(pilot, until, scatter):
    """1 000 synthetic studies with a requested precision: they reach it, and 92-98 % of their last intervals hold the truth."""
    held = reached = 0
    for seed in range(1000):
        values, stopping = settle(synthetic(seed, *scatter), watch, 64, pilot, Tolerance.of(until), most_poses=65_536, most_robots=50_000)
        figure = stopping.stages[-1].figures["mean"]
        held += abs(values.mean() - 1) <= figure.half
        reached += stopping.reached
        assert stopping.reached == (figure.half <= stopping.tolerance.share * figure.value)
    assert 0.92 <= held / 1000 <= 0.98
    assert reached / 1000 >= 0.99


def test_two_stages_are_mostly_enough():
    """Of 100 studies at least 80 stop after the second stage, and none takes more than four."""
    stages = []
    for seed in range(100):
        _, stopping = settle(synthetic(seed, 0.3, 0, 0), watch, 64, 50, Tolerance.of(0.02), most_poses=64, most_robots=50_000)
        stages.append(len(stopping.stages))
    assert stages.count(2) >= 80
    assert max(stages) <= STAGES


def test_a_modest_stage_comes_before_a_large_one():
    """Poses whose scatter is known from eight sets, and so falls faster than assumed: a modest stage between spares most of the samples."""

    def sobol(poses, robots):
        rng = np.random.default_rng([7, poses])
        return 1 + np.random.default_rng(3).normal(0, 0.3, 50_000)[:robots] + rng.normal(0, 6 / poses, (SETS, 1))  # error as 1 / poses

    _, stopping = settle(sobol, watch, 64, 50, Tolerance.of("2 %"), most_poses=65_536, most_robots=50_000)
    samples = [stage.poses * stage.robots for stage in stopping.stages]
    assert stopping.reached
    assert 3 <= len(samples) <= STAGES
    assert 2 < samples[1] / samples[0] <= 8.1
    half = stopping.stages[-1].figures["mean"].relative
    assert half > 0.008  # not several times more precise than requested
    # What is far off gets there all the same: the stages after it take what they take.
    _, far = settle(synthetic(1, 0.3, 0.5, 0.2), watch, 64, 20, Tolerance.of("0.5 %"), most_poses=65_536, most_robots=50_000)
    assert far.reached


def test_a_growth_of_up_to_sixty_four_is_taken_at_once_and_a_larger_one_by_eight():
    """Variances from few sets of poses are hardly known: a stage takes 64 times the samples at most, and eight times where more seem to be needed."""
    stage = Stage(64, 20, {})
    assert _capped(stage, 64 * 8, 20 * 8) == (64 * 8, 20 * 8)
    poses, robots = _capped(stage, 64 * 16, 20 * 16)
    assert poses * robots == pytest.approx(8 * 64 * 20, rel=0.05)
    assert _capped(Stage(64, 30, {}), 64, 30 * 1000) == (64, 30 * 1000)  # poses as they are, and robots enough


def test_what_was_not_reached_is_reported_with_its_reason():
    """Too few robots allowed, or poses that are fixed: not reached, for want of that; the most that was allowed was used."""
    _, short = settle(synthetic(1, 0.3, 0, 0), watch, 64, 50, Tolerance.of(0.01), most_poses=64, most_robots=400)
    assert (short.reached, short.limited_by, short.stages[-1].robots) == (False, "robots", 400)
    _, fixed = settle(synthetic(1, 0.01, 0, 0.3), watch, 64, 50, Tolerance.of(0.01), most_poses=64, most_robots=400)
    assert (fixed.reached, fixed.limited_by) == (False, "poses")
    assert fixed.missed == ("mean",)


def test_a_pilot_that_is_sure_enough_is_all():
    """No second stage where the first one will do, nor where nothing errs."""
    _, easy = settle(synthetic(1, 0.01, 0, 0), watch, 64, 100, Tolerance.of(0.05), most_poses=64)
    assert len(easy.stages) == 1
    assert easy.reached
    ideal = settle(lambda *_: 0, lambda _: {"mean": Watched(0.0, 0.0, 0.0)}, 64, 10, Tolerance.of("3 digits"), most_poses=64)[1]
    assert ideal.reached


def test_digits_mean_half_a_unit_of_the_last_one():
    """JCGM 101, 7.9.2: two digits of 0.4633 are 0.46, known to 0.005; of 1234 they are 12 hundreds, known to 50."""
    two = Tolerance.of("2 digits")
    assert two.half(0.4633) == pytest.approx(0.005)
    assert two.half(1234.0) == pytest.approx(50)
    assert Tolerance.of("1 %").half(0.5) == pytest.approx(0.005)
    assert str(two) == "2 significant digits"


@pytest.mark.parametrize("nonsense", ["1", "one %", "0 %", "80 %", "9 digits", "2.5 digits", 0.0001, -1.0, float("nan"), ""])
def test_nonsense_is_refused(nonsense):
    """A tolerance is a share with its sign, or digits."""
    with pytest.raises(lostmotion.InputError, match="until"):
        Tolerance.of(nonsense)


def test_a_study_that_says_when_to_stop_is_the_study_of_its_last_stage():
    """The same counts without the rule give the same bits; its sheet says what was asked for and what was reached."""
    arm = arm_of(2)
    found = lostmotion.study(arm, 64, 40, 3, until="8 %", threads=1)
    assert found.stopping is not None
    assert found.stopping.reached
    last = found.stopping.stages[-1]
    assert (len(found.poses), found.sampled.robots) == (last.poses, last.robots)
    again = lostmotion.study(arm, last.poses, last.robots, 3, threads=1)
    np.testing.assert_array_equal(found.sampled.robot_means, again.sampled.robot_means)
    assert f"Reached ±8 % after {last.robots} robots and {last.poses} poses." in found.sheet.verdict
    rows = next(section for section in found.sheet.sections if section.key == "stopping").rows
    assert [row.label for row in rows] == list(last.figures)
    assert rows[1].figures[-1].value == pytest.approx(100 * last.figures["95th percentile"].relative)


def test_a_study_takes_more_poses_where_their_choice_limits_it():
    """Sixteen poses leave more than 5 % open whatever the robots: a longer sequence is taken. The same poses, if given, are all there are."""
    arm = arm_of(2)
    stages = lostmotion.study(arm, 16, 100, 1, until="5 %", threads=1).stopping.stages
    assert stages[0].poses == 16 < stages[-1].poses
    given = lostmotion.study(arm, sample_poses(arm, 16).q, 100, 1, until="5 %", most_robots=300, threads=1).stopping
    assert {stage.poses for stage in given.stages} == {16}
    assert given.most_poses == 16


def test_a_study_says_that_it_did_not_reach():
    """Few robots allowed: not reached, with the widest half-width and its figure; the figures themselves are reported all the same."""
    found = lostmotion.study(arm_of(2), np.zeros((1, 2)), 100, 3, until="0.5 %", most_robots=120, threads=1)
    assert "Did not reach ±0.5 %: half-width" in found.sheet.verdict
    assert "after the most robots allowed, 120" in found.sheet.verdict
    with pytest.raises(lostmotion.InputError, match="most_robots"):
        lostmotion.study(arm_of(2), 8, 100, 3, until="1 %", most_robots=50)
    with pytest.raises(lostmotion.InputError, match="until"):
        lostmotion.study(arm_of(2), 8, 100, 3, until="1 %", method="analytic")


def test_figures_that_need_more_robots_are_replaced_by_words():
    """Of 24 robots no 95 % has an upper end: the stage says "not known", in no unit, and not a number that is none."""
    found = lostmotion.study(arm_of(2), np.zeros((1, 2)), 24, 3, until="50 %", most_robots=24, threads=1)
    rows = next(section for section in found.sheet.sections if section.key == "stopping").rows
    said = {row.label: str(row.figures[0]) for row in rows}
    assert said["AP, 95th percentile of robots"] == "not known"
    assert not any("nan" in text for text in said.values())


@pytest.mark.parametrize(("pilot", "margin"), [(100, 0.85), (20, 0.6)])
def test_the_last_stage_takes_a_larger_margin_only_where_an_earlier_one_was_cut_short(pilot, margin):
    """Robots grow by the square of the half-width over the requested one, with a margin: 85 %, or 60 % after a pilot of few robots cut the growth."""
    halves = {1: 1.0, 2: 0.5, 3: 0.12, 4: 0.01}  # a scatter that seems to grow as more robots are seen
    runs = []
    _, stopping = settle(
        lambda _, robots: runs.append(robots) or len(runs),
        lambda run: {"mean": Watched(1.0, halves[run], 0.0)},
        64,
        pilot,
        Tolerance.of("10 %"),
        most_poses=64,
        most_robots=10**9,
    )
    assert stopping.reached
    assert runs[3] / runs[2] == pytest.approx((1.2 / margin) ** 2, rel=1e-3)
