"""Set-ups of the instrument: one robot, and a frame of the instrument for each."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import lostmotion
from lostmotion.calibration.alignment import WrongArmError, plausible_rows
from lostmotion.calibration.instruments import MeasuredVisits, Readings
from lostmotion.calibration.ladder import DRIFT
from lostmotion.calibration.model import model_of
from lostmotion.calibration.robot import measured_in_base, robot_of
from lostmotion.calibration.terms import Deviations, added_terms, is_frame
from lostmotion.calibration.validation import blocked_folds, folds_in_sets, kept_aside
from lostmotion.error_model.poses import sample_poses
from lostmotion.laws.frame_fit import rigid
from lostmotion.mechanism.state import state_of
from lostmotion.spatial import exp
from tests.calibration.test_robot import differences
from tests.calibration.ur5_grid import EXAMPLES

ARM = lostmotion.read(EXAMPLES / "ur5e.urdf")
EVERY = sample_poses(ARM, 128, "sobol", 3).q
Q, UNUSED = EVERY[:30], EVERY[60:120]
ADDED = added_terms(ARM, Deviations())
NOISE = 2e-5
# The instrument after it was moved: by 20 degrees about a tilted axis and 300 mm, m.
MOVED = exp(np.radians(20) * np.array([0.6, 0, 0.8, 0, 0, 0]))
MOVED[:3, 3] = 0.3 * np.array([2, -1, 2]) / 3
# A row of docs/validation.md: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "errors of a drawn robot from two set-ups of the instrument, 300 mm and 20° apart",
        "the same robot and noise in one set-up; the drawn robot at other poses",
        "one standard deviation; mean error at most 1.3 times as large",
        "calibration/sets.py calibration/alignment.py",
    ),
)


def drawn() -> np.ndarray:
    """Return the errors of a robot drawn from the prior, in deviations."""
    model = model_of(ARM, Q[:1], ADDED)
    return np.random.default_rng(5).normal(size=len(model.streams))


def measured(second: np.ndarray | None = None, *, named: bool = True) -> MeasuredVisits:
    """Return the points of the drawn robot, those of some rows after the instrument was moved."""
    points = model_of(ARM, Q, ADDED).frames(drawn())[:, :3, 3]
    points = points + np.random.default_rng(6).normal(0, NOISE, points.shape)
    if second is None:
        return MeasuredVisits(Q, point=points)
    points[second] = points[second] @ MOVED[:3, :3].T + MOVED[:3, 3]
    sets = np.where(np.isin(np.arange(len(Q)), second), "B", "A")
    return MeasuredVisits(Q, point=points, sets=sets if named else None)


def error_elsewhere(robot) -> float:
    """Return the mean distance of predicted from true points at unused poses, m, each with the
    base frame that fits best.
    """
    model, found = model_of(ARM, UNUSED, ADDED), robot.climb
    streams = found.model.streams
    draws = np.zeros(len(model.streams))
    draws[model.numbers(streams)] = found.kept.fit.mean[: len(streams)]
    predicted, true = (model.frames(each)[:, :3, 3] for each in (draws, drawn()))
    frame = rigid(true, predicted)
    left = true - predicted @ frame[:3, :3].T - frame[:3, 3]
    return float(np.linalg.norm(left, axis=1).mean())


@functools.cache
def by_two_set_ups(second: tuple[int, ...]):
    """Return the robot of which these rows were measured after the instrument was moved."""
    return robot_of(ARM, measured(np.array(second)), terms="geometry", noise=NOISE)


@pytest.fixture(scope="module")
def one():
    """Return the robot by one set-up."""
    return robot_of(ARM, measured(), terms="geometry", noise=NOISE)


@pytest.mark.parametrize(
    "second",
    [np.arange(0, 30, 2), np.argsort(state_of(ARM, Q).frames[-1, :, 0, 3])[:14], np.arange(26, 30)],
    ids=["every other row", "half of the workspace", "four rows"],
)
def test_two_set_ups_are_as_good_as_one(one, second):
    """Estimates differ by less than their standard deviation, unused poses are predicted as well,
    and held-out ones are: no fold takes the poses that the frame of a set needs.
    """
    robot = by_two_set_ups(tuple(second))
    own = np.flatnonzero([not is_frame(owner) for owner in one.climb.model.owners])
    here, there = robot.climb.kept.fit, one.climb.kept.fit
    deviation = np.sqrt(np.diag(here.covariance))[own]
    np.testing.assert_array_less(np.abs(here.mean[own] - there.mean[own]), deviation)
    assert error_elsewhere(one) < 5e-5
    assert error_elsewhere(robot) < 1.3 * error_elsewhere(one)
    assert robot.climb.kept.blocked.mean < 2 * one.climb.kept.blocked.mean
    assert robot.climb.random.mean < 2 * one.climb.random.mean


def test_the_frame_of_a_set_is_no_error_of_the_robot():
    """It is shown as of the instrument, and neither drawn nor in the calibration of the arm."""
    robot = by_two_set_ups(tuple(range(26, 30)))
    shown = [each for each in robot.errors if each.name.startswith("instrument.set B")]
    assert [each.unit for each in sorted(shown, key=lambda e: e.draw)] == ["rad"] * 3 + ["m"] * 3
    assert all(each.frame and not each.in_file for each in shown)
    assert {each.prior for each in shown} == {10e-3}
    assert min(each.resolved for each in shown) > 0.99
    assert all(
        name in {s.name for s in robot.climb.model.streams} for name, _ in robot.calibration.streams
    )
    assert robot.alignments["A"] is None
    assert robot.alignments["B"].shift == pytest.approx(0.3, abs=0.02)
    assert np.degrees(robot.alignments["B"].turn) == pytest.approx(20, abs=1.5)


def test_rows_of_two_set_ups_without_their_names_are_refused():
    """They are those of no arm: more than 5 % of the reach remain."""
    with pytest.raises(WrongArmError, match="% of the reach"):
        robot_of(ARM, measured(np.arange(15, 30), named=False), terms="geometry", noise=NOISE)


def test_one_name_changes_nothing(one):
    """Every estimate has the same bits."""
    visits = MeasuredVisits(Q, point=measured().point, sets=np.full(len(Q), "A"))
    found = robot_of(ARM, visits, terms="geometry", noise=NOISE).climb.kept.fit
    np.testing.assert_array_equal(found.mean, one.climb.kept.fit.mean)
    np.testing.assert_array_equal(found.covariance, one.climb.kept.fit.covariance)


def test_full_poses_of_each_set_are_brought_into_the_base():
    """Of a nominal arm nothing remains, in positions and rotations."""
    frames = state_of(ARM, Q).frames[-1]
    seen, sets = frames.copy(), np.where(np.arange(30) < 20, "A", "B")
    seen[20:] = MOVED @ frames[20:]
    visits = MeasuredVisits(Q, seen[:, :3, 3], rotation=seen[:, :3, :3], sets=sets)
    found = measured_in_base(ARM, visits, Deviations(tool_turn=0.01))
    rows = found.instrument.rows(frames, np.zeros(6))
    np.testing.assert_allclose(rows.residual, 0, atol=1e-9)
    np.testing.assert_allclose(found.alignments["B"].frame, MOVED, atol=1e-9)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_sign_of_differences_is_found_with_sets(sign):
    """By bases that are turned by 50 mrad, one way and the other."""
    arm, q, beside = differences(0.05)
    back = differences(-0.05)[2]
    half = np.arange(len(q)) % 2 == 0
    both = np.where(half[:, None], beside, back)
    visits = MeasuredVisits(q, difference=sign * both, sets=np.where(half, "A", "B"))
    seen = measured_in_base(arm, visits, Deviations())
    assert (seen.sign, seen.favoured) == (sign, sign)


def test_drift_and_rows_held_out_keep_their_set():
    """A drift is tried, and rows kept aside are predicted in the frame of their set."""
    time = np.arange(30.0)[::3]
    visits = measured(np.arange(15, 30)).rows(np.arange(0, 30, 3))
    visits = MeasuredVisits(visits.q, visits.point, sets=visits.sets, time=time)
    robot = robot_of(ARM, visits, noise=NOISE, hold_out=0.2)
    assert DRIFT in [rung.name for rung in robot.climb.rungs]
    assert len(robot.aside.error) == 2
    assert robot.aside.mean < 2e-3  # a frame that is off by 300 mm is far more


def test_a_share_that_is_held_out_leaves_the_poses_of_a_frame():
    """Three of each set, and whole poses: one that both sets measured is held out of both."""
    sets = np.repeat(["A", "B"], [25, 5])
    q = np.concatenate([Q[:25], Q[:3], Q[28:]])
    for seed in range(20):
        apart = kept_aside(MeasuredVisits(q, sets=sets), 0.7, seed)
        assert (~apart[25:]).sum() >= 3
        np.testing.assert_array_equal(apart[:3], apart[25:28])


def test_no_fold_takes_a_set_away():
    """Of sets in regions of their own every fold leaves three poses or more of each; folds of
    regions that both sets measured are those of all poses.
    """
    points = state_of(ARM, Q).frames[-1, :, :3, 3]
    whole = blocked_folds(points)
    sets = np.where(whole == 0, "B", "A")
    folds = folds_in_sets(lambda rows: blocked_folds(points[rows]), len(Q), sets)
    for name in "AB":
        here = sets == name
        assert here.sum() - np.bincount(folds[here]).max() >= 3
    mixed = np.where(np.arange(30) % 2, "B", "A")
    folds = folds_in_sets(lambda rows: blocked_folds(points[rows]), len(Q), mixed)
    np.testing.assert_array_equal(folds, whole)


def test_a_gross_mistake_is_found_within_its_set():
    """Though the other set is farther away."""
    visits = measured(np.arange(15, 30))
    visits.point[17] += [0.5, 0, 0]
    np.testing.assert_array_equal(np.setdiff1d(np.arange(30), plausible_rows(ARM, visits)), [17])


@pytest.mark.parametrize(
    ("second", "text"), [((28, 29), "2 poses do not determine its frame"), ((), "from a line")]
)
def test_a_set_without_a_frame_is_refused(second, text):
    """With two poses, or with points on a line."""
    visits = measured(np.array(second, dtype=int))
    if not second:
        turned = np.tile(Q[0], (4, 1))
        turned[:, -1] += np.arange(4)  # the tool turns in place
        at = np.concatenate([Q, turned])
        points = state_of(ARM, at).frames[-1, :, :3, 3].copy()
        points[30:] = points[30:] @ MOVED[:3, :3].T + MOVED[:3, 3]
        visits = MeasuredVisits(at, points, sets=np.repeat(["A", "B"], [30, 4]))
    with pytest.raises(WrongArmError, match=f"^set B: .*{text}"):
        measured_in_base(ARM, visits, Deviations())


def test_sets_of_partial_readings_are_refused():
    """Their places are unknowns already."""
    readings = Readings("distance", np.ones(30), ("A",) * 30)
    visits = MeasuredVisits(Q, readings=readings, sets=measured(np.arange(15)).sets)
    with pytest.raises(ValueError, match="several sets"):
        measured_in_base(ARM, visits, Deviations())
