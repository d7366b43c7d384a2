"""Instruments that see one number of each pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import lostmotion
from lostmotion.calibration.alignment import WrongArmError
from lostmotion.calibration.choices import Asked
from lostmotion.calibration.drift import drifting
from lostmotion.calibration.fit import fit
from lostmotion.calibration.instruments import (
    Camera,
    FullPoses,
    Instrument,
    MeasuredVisits,
    Points,
    Readings,
)
from lostmotion.calibration.model import model_of
from lostmotion.calibration.partial import instrument_of
from lostmotion.calibration.robot import robot_of
from lostmotion.calibration.sets import InSets
from lostmotion.calibration.tags import CORNERS, Tags, tags_of
from lostmotion.calibration.terms import Deviations, added_terms
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.state import state_of
from lostmotion.spatial import exp
from tests.calibration.test_terms import six_axes

CHANCE = np.random.default_rng(3)


def some_frames(count: int) -> np.ndarray:
    """Return random frames of a tool within half a metre."""
    return exp(CHANCE.normal(0, 0.5, (count, 6)))


def instruments(frames: np.ndarray) -> dict:
    """Return one instrument of each kind, off its readings."""
    count = len(frames)
    pair = tuple("AB"[k % 2] for k in range(count))
    axes = tuple("xyz"[k % 3] for k in range(count))
    near = CHANCE.normal(0, 1e-3, count)
    turned = frames @ exp(CHANCE.normal(0, 0.2, (count, 6)))
    return {
        "points": Points(turned[:, :3, 3]),
        "poses": FullPoses(turned),
        "distance": instrument_of(Readings("distance", 1 + near, pair), frames),
        "plane": instrument_of(Readings("plane", near, pair), frames),
        "sphere": instrument_of(Readings("sphere", 0.4 + 0 * near, pair), frames),
        "dial": instrument_of(Readings("dial", near, axes), frames),
        "angle": instrument_of(Readings("angle", near, axes), turned),
        "tags": some_tags(frames),
        "drift": drifting(FullPoses(turned), np.arange(len(frames))),
        "sets": some_sets(FullPoses(turned)),
        "sets that drift": drifting(some_sets(Points(turned[:, :3, 3])), np.arange(len(frames))),
    }


def some_sets(instrument: Instrument) -> InSets:
    """Return an instrument that was set up three times."""
    sizes = np.repeat([0.1, 0.2], 3)
    return InSets(instrument, ("A", "B", "C"), np.arange(24) % 3, sizes)


def some_tags(frames: np.ndarray) -> Tags:
    """Return two tags on the tool, seen from two metres."""
    count, camera = len(frames), Camera(800, 790, 320, 240, 0.04)
    at = np.diag([1.0, -1.0, -1.0, 1.0])
    at[2, 3] = 2.0
    pixel = CHANCE.uniform(0, 480, (count, 4, 2))
    return Tags(("A", "B"), np.arange(count) % 2, pixel, camera, at, exp(np.zeros((2, 6))), 2.0)


KINDS = (
    *("points", "poses", "distance", "plane", "sphere", "dial", "angle", "tags", "drift"),
    *("sets", "sets that drift"),
)


@pytest.mark.parametrize("kind", KINDS)
def test_rows_equal_central_differences(kind):
    """The derivative of each reading by the tool's twist and by the instrument's unknowns equals a
    central difference to 1e-7.
    """
    frames = some_frames(24)
    made = instruments(frames)[kind]
    unknowns = CHANCE.normal(0, {"drift": 100, "sets": 1}.get(kind, 0.1), len(made.unknowns))
    rows, step = made.rows(frames, unknowns), 1e-5
    for k in range(6):
        ends = []
        for sign in (1, -1):
            twist = np.zeros(6)
            twist[k] = sign * step
            moved = frames.copy()
            turn = exp(np.concatenate([twist[:3], np.zeros(3)]))
            moved[:, :3, :3] = turn[:3, :3] @ frames[:, :3, :3]
            moved[:, :3, 3] += twist[3:]
            ends.append(made.rows(moved, unknowns).residual)
        found = -(ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(found, rows.by_twist[:, :, k], atol=1e-7)
    for k in range(len(unknowns)):
        aside = np.zeros(len(unknowns))
        aside[k] = step
        ends = [made.rows(frames, unknowns + sign * aside).residual for sign in (1, -1)]
        found = -(ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(found, rows.by_unknown[:, :, k], atol=1e-7)


def test_camera_and_tag_are_found_without_first_estimates():
    """By exact pixels of a camera and a tag anywhere, composed by homogeneous matrices."""
    frames = some_frames(60)
    camera = Camera(800, 790, 320, 240, 0.04)
    on = exp(np.array([0.4, -0.9, 2.0, 0.02, -0.03, 0.05]))
    at = exp(np.array([3.0, 0.2, -0.3, 0.0, 0.0, 0.0]))
    at[:3, 3] = 0.2, 0.4, 4.0
    pixels = []
    for frame in frames:
        places = [np.linalg.inv(at) @ frame @ on @ [*corner, 1.0] for corner in 0.04 * CORNERS]
        assert all(z > 0.3 for _, _, z, _ in places)
        pixels.append([[800 * x / z + 320, 790 * y / z + 240] for x, y, z, _ in places])
    found = tags_of(Readings("tags", np.array(pixels), ("A",) * len(frames), camera), frames)
    np.testing.assert_allclose(found.at, at, atol=1e-6)
    np.testing.assert_allclose(found.on[0], on, atol=1e-6)
    assert np.abs(found.rows(frames, np.zeros(12)).residual).max() < 1e-6


@pytest.mark.parametrize(("beside", "lost"), [(0.0, 25), (0.08, 27)])
def test_ranks_of_partial_measurements(beside, lost):
    """A distance to a known centre loses three turns about it, an unknown centre the whole base
    frame and nothing of the robot (Everett, Driels and Mooring).
    """
    arm = six_axes(beside)
    q = np.random.default_rng(1).uniform(-3, 3, (400, 6))
    model = model_of(arm, q, added_terms(arm, Deviations()))
    frames = model.matrix.state.frames[-1]
    centre = np.array([0.3, 0.2, 0.1])
    distance = np.linalg.norm(frames[:, :3, 3] - centre, axis=1)
    made = instrument_of(Readings("distance", distance, ("A",) * len(q)), frames)
    rows = made.rows(frames, np.zeros(4))
    robot = (rows.by_twist @ model.columns)[:, 0]
    own = rows.by_unknown[:, 0]
    assert rank(robot) == lost - 3
    assert rank(np.hstack([robot, own])) - rank(own) == lost - 6


def rank(columns: np.ndarray) -> int:
    """Return how many singular values exceed 1e-7 of the largest, columns as scaled."""
    values = np.linalg.svd(columns, compute_uv=False)
    return int((values > 1e-7 * values[0]).sum())


def far_tags(arm, count: int, pixel: float, robot: int) -> tuple:
    """Return a model, the draws of one robot and its tag of 50 mm, 13 px wide at three metres, as
    homogeneous coordinates project it; and where the camera is.
    """
    sizes = replace(Deviations(), tool_turn=0.01)
    at = np.array([[0, 0, -1, 3], [1, 0, 0, 0], [0, -1, 0, 0.3], [0, 0, 0, 1.0]])
    q = sample_poses(arm, 16 * count, "sobol", 3).q
    normal = state_of(arm, q).frames[-1][:, 0, 2]  # the camera looks along -x
    q = q[normal > np.cos(np.radians(65))][:count]
    model = model_of(arm, q, added_terms(arm, sizes))
    chance = np.random.default_rng(robot)
    draws = chance.normal(size=len(model.streams))
    on = exp(np.array([0.3, -0.2, 1.0, 0.01, -0.02, 0.03]))
    corners = np.column_stack([0.05 * CORNERS, np.ones(4)])
    seen = np.linalg.inv(at) @ model.frames(draws) @ on @ corners.T
    pixels = 800 * (seen[:, :2] / seen[:, 2:3]).transpose(0, 2, 1) + [320, 240]
    pixels += chance.normal(0, pixel, pixels.shape)
    readings = Readings("tags", pixels, ("A",) * len(q), Camera(800, 800, 320, 240, 0.05))
    return model, draws, readings, at


@pytest.mark.parametrize("pixel", [0.13, 1.0])
def test_small_tags_far_away_release_nothing(pixel):
    """Single images of a tag of 13 px place the camera a metre off; all corners together to a few
    centimetres, as the errors of the robot allow, from where its errors are estimated as stated.
    """
    arm = lostmotion.read("examples/ur5e.urdf")
    inside = []
    for robot in range(3):
        model, draws, readings, at = far_tags(arm, 40, pixel, robot)
        seen = tags_of(readings, model.matrix.state.frames[-1])
        assert np.linalg.norm(seen.at[:3, 3] - at[:3, 3]) < 0.06
        assert seen.distance == pytest.approx(3, rel=0.2)
        found = fit(model, seen, Asked(np.ones(len(draws) + len(seen.unknowns))))
        assert not found.released
        assert found.noise == pytest.approx(pixel * seen.distance / 800, rel=0.1)
        assert np.abs(found.mean[len(draws) :]).max() < 2
        deviation = np.sqrt(np.diag(found.covariance))[: len(draws)]
        inside.append(np.abs(found.mean[: len(draws)] - draws) < 1.96 * deviation)
    assert 0.9 < np.mean(inside) < 0.99


@pytest.mark.parametrize(("kind", "zero"), [("dial", 0.08), ("angle", np.radians(100))])
def test_a_gauge_may_be_far_from_its_zero(kind, zero):
    """A constant reading of any size is a zero, and no part of the robot out of tolerance."""
    arm = six_axes(0.1)
    q = np.random.default_rng(1).uniform(-3, 3, (20, 6))
    value = zero + np.random.default_rng(2).normal(0, 1e-4, 20)
    measured = MeasuredVisits(q, readings=Readings(kind, value, ("z",) * 20))
    found = robot_of(arm, measured, terms="geometry")
    assert not found.climb.kept.fit.released
    assert np.abs(found.climb.kept.fit.mean).max() < 2


def test_a_lost_instrument_is_refused():
    """Distances with a zero of six times its prior deviation belong to another bar: base, tool and
    robot would share what the prior holds it back.
    """
    arm = six_axes(0.1)
    q = np.random.default_rng(1).uniform(-3, 3, (40, 6))
    beside = state_of(arm, q).frames[-1][:, :3, 3] - [0.3, -0.9, 0.2]
    measured = MeasuredVisits(
        q, readings=Readings("distance", np.linalg.norm(beside, axis=1) + 0.06, ("A",) * 40)
    )
    with pytest.raises(WrongArmError, match=r"estimate of A zero is 60 mm from where it starts"):
        robot_of(arm, measured, terms="geometry")
