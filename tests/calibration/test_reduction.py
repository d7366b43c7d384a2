"""Base and tool are no errors of a robot, and few numbers hold the covariance of many estimates."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lostmotion
from lostmotion.calibration.alignment import align
from lostmotion.calibration.choices import Asked
from lostmotion.calibration.correction import expected_tool
from lostmotion.calibration.fit import fit
from lostmotion.calibration.instruments import Points
from lostmotion.calibration.model import model_of
from lostmotion.calibration.reduction import in_best_frames, reduced
from lostmotion.calibration.robot import calibrations_of
from lostmotion.calibration.terms import Deviations, added_terms, is_frame
from lostmotion.controller_model.c_source import table_source
from lostmotion.controller_model.percentile import percentile95
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.calibration import Calibration
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.exact import compose, draws_of
from tests.calibration.ur5_grid import EXAMPLES, grid_model

# A row of docs/validation.md: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "Base and tool frame of a calibrated robot",
        "rigid motion and tool offset by singular values, UR5 of 20 measured poses",
        "mean error within 1 %",
        "calibration/reduction.py",
    ),
)


def calibrated_by(points, rows):
    """Return the calibrations of the UR5 by these points at these rows of the grid."""
    model, _ = grid_model()
    part = model.rows(rows)
    found = fit(part, Points(points), Asked(np.ones(len(part.streams)), 7e-5))
    arm = model.matrix.state.arm.calibrated(None)
    return arm, calibrations_of(arm, part, found, Deviations())


def test_a_calibrated_robot_is_compared_with_the_frames_that_fit_it_best():
    """The mean error of its tool is what remains of the measured robot after the best rigid motion
    and tool offset, by another method, and not the millimetres of base and tool.
    """
    rows = np.arange(0, 1000, 50)
    arm, (own, measured) = calibrated_by(grid_model()[1].measured[rows], rows)
    q = sample_poses(arm, 256, "sobol", 1).q
    nominal = state_of(arm, q).frames[-1]
    there = expected_tool(arm.calibrated(measured), q)[:, :3, 3]
    best = align(nominal, there)
    square = nominal[:, :3, :3] @ best.offset + nominal[:, :3, 3]
    square = square @ best.frame[:3, :3].T + best.frame[:3, 3] - there
    error = lostmotion.screws(state_of(arm.calibrated(own), q)).summed.bias[:, 3:]
    assert np.sqrt((error**2).sum(axis=1).mean()) == pytest.approx(
        np.sqrt((square**2).sum(axis=1).mean()), rel=0.01
    )
    whole = np.linalg.norm(there - nominal[:, :3, 3], axis=1).mean()
    assert np.linalg.norm(error, axis=1).mean() < 0.7 * whole


def test_a_shifted_base_changes_no_figure():
    """The same robot on a foot that is 8 mm and 5 mrad elsewhere has the same errors."""
    rows = np.arange(0, 1000, 50)
    points = grid_model()[1].measured[rows]
    moved = Rotation.from_rotvec([0, 0.003, 0.004]).apply(points) + np.array([0.008, -0.003, 0.002])
    q, errors = grid_model()[0].matrix.state.q[::25], []
    for each in (points, moved):
        arm, (own, _) = calibrated_by(each, rows)
        errors.append(lostmotion.screws(state_of(arm.calibrated(own), q)).summed.bias)
    assert np.abs(errors[0][:, 3:]).max() > 1e-3
    np.testing.assert_allclose(errors[1][:, 3:], errors[0][:, 3:], atol=3e-5)


@functools.cache
def arm_and_model(arm_file: str, count: int):
    """Return the arm of an example, and its model at `count` poses."""
    arm = lostmotion.read(EXAMPLES / arm_file)
    q = sample_poses(arm, count, "sobol", 3).q[:count]
    return arm, model_of(arm, q, added_terms(arm, Deviations()))


@functools.cache
def robot_of(number: int, arm_file: str, count: int):
    """Return a drawn robot: the arm, its model, draws, fit and calibrations by `count` poses."""
    arm, model = arm_and_model(arm_file, count)
    matrix, rows = model.matrix, np.arange(count)
    robots = np.full(count, number)
    draws = draws_of(matrix, rows, 5, rows, robots, rows)
    points = compose(matrix, rows, draws.T[:, :, None])[:, 0, :3, 3]
    points = points + 2e-5 * np.random.default_rng(number).normal(size=points.shape)
    asked = Asked(np.ones(len(model.streams)), 2e-5, release=False)
    found = fit(model, Points(points), asked)
    return arm, model, found, calibrations_of(arm, model, found, Deviations())


def test_few_numbers_hold_the_covariance():
    """Of a hundred estimates fewer than half are correlated, by at most twenty directions, and the
    mean 95 % radius of the tool is that of the whole covariance within 1 %.
    """
    arm, model, found, (own, _) = robot_of(1, "z-arm-drawn.toml", 30)
    assert len(own.streams) > 100
    factor = own.correlations.factor
    assert factor.any(axis=0).sum() <= 20
    assert len(factor) < len(own.streams) / 2
    there = model_of(arm, sample_poses(arm, 128, "sobol", 9).q, own.added)
    columns = there.columns[:, :, there.numbers(model.streams)]
    frames = np.array([is_frame(owner) for owner in model.owners])
    best = in_best_frames(columns[:, 3:], frames)
    radius = []
    for covariance in (best @ found.covariance @ best.T, own.covariance):
        spread = columns[:, 3:] @ covariance @ columns[:, 3:].transpose(0, 2, 1)
        radius.append(percentile95(np.zeros((len(spread), 3)), spread).mean())
    assert radius[1] == pytest.approx(radius[0], rel=0.02)


def test_tables_of_a_calibrated_arm_are_short():
    """With all 75 errors that its file states estimated by thirty poses, the tables of a controller
    are less than 1.5 times as long as without.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm-drawn.toml")
    model = model_of(arm, sample_poses(arm, 64, "sobol", 3).q[:30])
    chance = np.random.default_rng(1)
    points = model.frames(chance.normal(size=len(model.streams)))[:, :3, 3]
    points += chance.normal(0, 5e-5, points.shape)
    found = fit(model, Points(points), Asked(np.ones(len(model.streams)), 5e-5))
    every = model_of(arm, sample_poses(arm, 256, "sobol", 1).q)
    covariance = reduced(every.columns[:, 3:], found.covariance)
    streams = tuple((stream.name, stream.law) for stream in model.streams)
    assert len(streams) == 75
    calibration = Calibration(streams, found.mean, covariance)
    lengths = [
        len(table_source(lostmotion.controller(arm, calibration=each).tables))
        for each in (calibration, None)
    ]
    assert lengths[0] < 1.5 * lengths[1]


def test_study_map_and_controller_agree_on_a_calibrated_robot():
    """Mean and covariance of the error by the pose matrix of a study equal those by the sums of a
    map to 1e-9, and in the frames of the command those by the tables of a controller.
    """
    arm, _, _, (own, _) = robot_of(1, "ur5e.urdf", 20)
    calibrated = arm.calibrated(own)
    q = sample_poses(arm, 64, "sobol", 7).q
    mapped = analytic(calibrated, q)
    exported = lostmotion.controller(arm, calibration=own).predict(q)
    for matrix, bias, covariance in (
        (pose_matrix(calibrated, q), mapped.bias, mapped.covariance),
        (
            lostmotion.screws(state_of(calibrated, q)),
            exported.screw[:, 3:],
            exported.covariance,
        ),
    ):
        summed, scale = matrix.merged, np.abs(bias).max()
        x = summed.tool[:, 3:, [k for k, info in enumerate(summed.infos) if info.level != "design"]]
        np.testing.assert_allclose(summed.bias[:, 3:], bias, atol=1e-9 * scale)
        np.testing.assert_allclose(x @ x.transpose(0, 2, 1), covariance, atol=1e-9 * scale**2)


@pytest.mark.slow
def test_robots_land_inside_the_radius_of_their_calibration():
    """Robots drawn from the arm's file, with visits, measured at 20 poses: at other poses the
    distance from their best frames is within its 95th percentile in 93 to 97 % of visits.
    """
    arm, _, _, (first, _) = robot_of(0, "ur5e.urdf", 20)
    inside, added = [], first.added
    q = sample_poses(arm, 128, "sobol", 11).q
    there = model_of(arm, q, added)
    every = model_of(arm, sample_poses(arm, 256, "sobol", 1).q, added)
    rows = np.arange(len(q))
    for number in range(16):
        _, _, _, (own, _) = robot_of(number, "ur5e.urdf", 20)
        assert [each.name for each in own.added] == [each.name for each in added]
        draws = draws_of(there.matrix, rows, 5, rows, np.full(len(q), number), rows)
        frames = np.array([is_frame(owner) for owner in there.owners])
        robot = np.array([draws[np.flatnonzero(there.of == k)[0], 0] for k in range(len(frames))])
        best = in_best_frames(every.columns[:, 3:], frames) @ robot
        for k in np.flatnonzero(frames):
            draws[there.of == k] = best[k]
        tool = compose(there.matrix, rows, draws.T[:, :, None])[:, 0]
        error = np.linalg.norm((tool - there.matrix.state.frames[-1])[:, :3, 3], axis=1)
        predicted = analytic(arm.calibrated(own), q, levels=(0.95,))
        inside.append((error <= predicted.quantiles[:, 0]).mean())
    assert 0.93 <= np.mean(inside) <= 0.97
