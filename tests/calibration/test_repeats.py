"""Poses that are visited repeatedly: what repeats average, and what they do not."""

from __future__ import annotations

import numpy as np
import pytest

import lostmotion
from lostmotion.calibration.choices import Asked
from lostmotion.calibration.drift import drifting
from lostmotion.calibration.fit import fit
from lostmotion.calibration.instruments import MeasuredVisits, Points
from lostmotion.calibration.model import model_of
from lostmotion.calibration.repeats import at_poses, repeats_of
from lostmotion.calibration.terms import Deviations, added_terms
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.state import state_of
from tests.calibration.ur5_grid import ARM, EXAMPLES

POSES, VISITS, ROBOTS = 10, 10, 24
# What the model lacks is one at all visits to a pose; the instrument's noise is of each, m.
LACK, NOISE = 50e-6, 20e-6
# A row of docs/validation.md: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "errors estimated from ten visits to each of ten poses, 24 drawn robots",
        "the drawn errors; what is out of tolerance where nothing is",
        "90 to 99 % within their 95 % intervals; at most one",
        "calibration/repeats.py calibration/fit.py",
    ),
)


@pytest.fixture(scope="module")
def model():
    """Return the model of an arm at the poses."""
    arm = lostmotion.read(ARM)
    q = sample_poses(arm, 64, "sobol", 3).q[:POSES]
    return model_of(arm, q, added_terms(arm, Deviations()))


def visited(model, seed: int, count: int = VISITS):
    """Return the visits of a drawn robot, one cycle of the poses after another, and its draws."""
    chance = np.random.default_rng(seed)
    draws = chance.normal(size=len(model.streams))
    points = model.frames(draws)[:, :3, 3] + chance.normal(0, LACK, (len(model), 3))
    points = np.tile(points, (count, 1)) + chance.normal(0, NOISE, (count * len(model), 3))
    return MeasuredVisits(np.tile(model.matrix.state.q, (count, 1)), point=points), draws


def repeated(model, visits: MeasuredVisits):
    """Return which visits are of one pose, the model of their means, and the instrument."""
    instrument = Points(visits.point)
    frames = state_of(model.matrix.state.arm, visits.q).frames[-1]
    repeats = repeats_of(visits, instrument, frames)
    mean = repeats.mean(instrument)
    return repeats, at_poses(model, repeats, mean, np.arange(len(model))), mean


def test_repeats_are_no_measurements_of_other_poses(model):
    """The intervals of the estimates contain what was drawn, and no part is found out of tolerance,
    though what the model lacks is the same at all visits to a pose.
    """
    inside, released = [], 0
    for seed in range(ROBOTS):
        visits, draws = visited(model, seed)
        _, there, mean = repeated(model, visits)
        found = fit(there.model, mean, Asked(np.ones(len(draws))))
        inside.append(np.abs(found.mean - draws) < 1.96 * np.sqrt(np.diag(found.covariance)))
        released += bool(found.released)
    assert 0.90 < np.mean(inside) < 0.99
    assert released <= 1


def test_the_noise_of_repeats_is_split_from_what_the_model_lacks(model):
    """A mean of visits has the first divided by their number, and the whole of the second."""
    visits, _ = visited(model, 1)
    _, there, mean = repeated(model, visits)
    assert there.scatter.deviation == pytest.approx(NOISE, rel=0.15)
    assert there.predicted == 0.0
    np.testing.assert_allclose(there.model.reading, there.scatter.deviation**2 / VISITS)
    found = fit(there.model, mean, Asked(np.ones(len(model.streams)), release=False))
    assert found.noise == pytest.approx(LACK, rel=0.5)


def test_means_of_repeats_are_those_of_the_points(model):
    """The rows of the mean are those of the averaged points, at any poses of them in any order."""
    visits, draws = visited(model, 2, 3)
    _, _, mean = repeated(model, visits)
    frames, rows = model.frames(draws), np.array([7, 2, 5])
    points = visits.point.reshape(3, POSES, 3).mean(axis=0)
    expected = points - frames[:, :3, 3]
    np.testing.assert_allclose(mean.rows(frames, np.zeros(0)).residual, expected, atol=1e-12)
    part = mean.part(rows).rows(frames[rows], np.zeros(0))
    np.testing.assert_allclose(part.residual, expected[rows], atol=1e-12)
    moved = drifting(Points(visits.point), np.arange(3.0 * POSES))
    drift = repeated(model, visits)[0].mean(moved).rows(frames, np.zeros(7)).by_unknown
    each = moved.rows(np.tile(frames, (3, 1, 1)), np.zeros(7)).by_unknown
    np.testing.assert_allclose(drift, each.reshape(3, POSES, 3, 7).mean(axis=0), atol=1e-15)


def test_a_visit_far_from_the_others_of_its_pose_is_not_used(model):
    """One of ten that is wrong by a millimetre moves their mean by a tenth of one; without it the
    others are as if it had not been measured. Of two visits neither is the wrong one.
    """
    visits, _ = visited(model, 3)
    visits.point[4] += [1e-3, 0, 0]
    repeats = repeated(model, visits)[0]
    np.testing.assert_array_equal(np.flatnonzero(~repeats.used), [4])
    assert repeats.counts.tolist() == [10, 10, 10, 10, 9, *[10] * 5]
    two, _ = visited(model, 3, 2)
    two.point[4] += [1e-3, 0, 0]
    assert repeated(model, two)[0].used.all()


def test_normal_visits_are_used():
    """Of three visits to each of a thousand poses at most one in a thousand is called wrong."""
    arm = lostmotion.read(ARM)
    q = np.repeat(np.random.default_rng(1).uniform(-1, 1, (1000, 6)), 3, axis=0)
    frames = state_of(arm, q).frames[-1]
    points = frames[:, :3, 3] + np.random.default_rng(2).normal(0, NOISE, (3000, 3))
    assert (~repeats_of(MeasuredVisits(q, point=points), Points(points), frames).used).sum() <= 3


def test_an_unknown_side_of_approach_is_not_averaged():
    """All visits to a pose may come from one side. Where it is stated, a mean has the scatter of
    what remains, divided by their number.
    """
    arm = lostmotion.read(EXAMPLES / "six-axis.toml")
    q = sample_poses(arm, 64, "sobol", 3).q[:4]
    for approach, kept in ((0.0, True), (np.ones((4, 6)), False)):
        model = model_of(arm, q, approach=approach)
        assert bool(model.sides.any()) is kept
        points = np.tile(model.matrix.state.frames[-1, :, :3, 3], (2, 1))
        points[:4] += 1e-5
        visits = MeasuredVisits(np.tile(q, (2, 1)), point=points)
        there = repeated(model, visits)[1].model
        expected = (model.scatter - model.sides) / 2 + model.sides
        np.testing.assert_allclose(there.scatter, expected, atol=1e-18)
        assert (there.scatter[:, 3:, 3:] <= model.scatter[:, 3:, 3:].max()).all()
