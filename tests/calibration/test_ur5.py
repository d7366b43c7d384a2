"""A measured UR5, 1 000 poses of a laser tracker: accuracy at poses that were not used."""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.calibration.choices import Asked
from lostmotion.calibration.fit import fit
from lostmotion.calibration.ladder import climb
from lostmotion.calibration.terms import is_frame
from tests.calibration.ur5_grid import grid_model, mean_error

# A row of docs/validation.md: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "Calibration of a measured robot",
        "UR5, 1 000 poses of a laser tracker, fitted at 20, errors at the other 980",
        "0.684 mm with base and tool alone, 0.115 mm with the prior of the parts",
        "calibration/fit.py",
    ),
)
TILT = "joints.J4.seat.tilt 2"


@pytest.mark.parametrize(
    ("step", "frames", "normal", "released"),
    [(50, 0.684, 0.2705, 0.115), (5, 0.619, 0.1065, 0.105), (100, 1.022, 0.634, 0.370)],
)
def test_few_poses_calibrate_all_others(step, frames, normal, released):
    """The rows 0, k, 2k of the grid predict all others as an independent program computed."""
    model, measured = grid_model()
    rows = np.arange(0, 1000, step)
    part, seen = model.rows(rows), measured.part(rows)
    every = np.ones(len(model.streams))
    outer = np.array([float(is_frame(owner)) for owner in model.owners])
    cases = (
        (Asked(outer, 7e-5, release=False, robust=False), frames),
        (Asked(every, 7e-5, release=False), normal),
        (Asked(every, 7e-5), released),
    )
    for asked, expected in cases:
        found = fit(part, seen, asked)
        assert mean_error(rows, model, measured, found.mean) == pytest.approx(expected, rel=0.02)
    ((draw, factor, gain),) = found.released
    assert model.streams[draw].name == TILT
    assert factor == 16
    if step == 50:
        assert 136 < gain < 141


@pytest.mark.parametrize(("step", "expected"), [(50, 0.1145), (5, 0.1049)])
def test_a_student_prior_needs_no_release(step, expected):
    """With heavy tails the normal prior of no error has to be widened by a choice: the same axis is
    out of tolerance, and the other poses are predicted as well.
    """
    model, measured = grid_model()
    rows = np.arange(0, 1000, step)
    asked = Asked(np.ones(len(model.streams)), 7e-5, student=True)
    found = fit(model.rows(rows), measured.part(rows), asked)
    assert mean_error(rows, model, measured, found.mean) == pytest.approx(expected, rel=0.02)
    ((draw, factor, gain),) = found.released
    assert model.streams[draw].name == TILT
    assert factor == pytest.approx(14, rel=0.02)
    assert gain > 100
    np.testing.assert_array_equal(found.prior, 1.0)


def test_least_squares_needs_more_poses():
    """Without a prior, by a fixed basis of the 25 combinations that points can distinguish."""
    model, measured = grid_model()
    rows = np.arange(0, 1000, 50)
    part = model.rows(rows)
    columns = part.columns[:, 3:].reshape(3 * len(rows), -1)
    _, _, across = np.linalg.svd(model.columns[:, 3:].reshape(3000, -1), full_matrices=False)
    basis, z = across[:25].T, np.zeros(25)
    for _ in range(5):
        left = (measured.measured[rows] - part.frames(basis @ z)[:, :3, 3]).ravel()
        z = z + np.linalg.lstsq(columns @ basis, left, rcond=None)[0]
    assert mean_error(rows, model, measured, basis @ z) == pytest.approx(0.124, rel=0.02)


def test_a_fit_without_the_tilt_blames_encoders():
    """With the errors of the arm's file, base and tool alone, 0.5 mm remain, and encoder zeros are
    out of tolerance that are right.
    """
    model, measured = grid_model()
    rows = np.arange(0, 1000, 50)
    stated = [k for k, owner in enumerate(model.owners) if not owner.endswith(".seat")]
    part = model.keeping(np.array(stated))
    found = fit(part.rows(rows), measured.part(rows), Asked(np.ones(len(stated)), 7e-5))
    assert mean_error(rows, part, measured, found.mean) == pytest.approx(0.50, abs=0.03)
    assert any("encoder" in part.streams[each.draw].name for each in found.released)


def test_random_poses_suffice():
    """Ten random poses leave 0.17 mm at the others, twenty 0.13, fifty 0.115."""
    model, measured = grid_model()
    chance = np.random.default_rng(5)
    for count, most in ((10, 0.17), (20, 0.13), (50, 0.115)):
        errors = []
        for _ in range(11 if count == 10 else 5):
            rows = np.sort(chance.choice(1000, count, replace=False))
            asked = Asked(np.ones(len(model.streams)), 7e-5)
            found = fit(model.rows(rows), measured.part(rows), asked)
            errors.append(mean_error(rows, model, measured, found.mean))
        assert np.median(errors) <= most


def test_a_wrong_measurement_is_weighted_down():
    """One row of twenty that is wrong by 5 mm changes the result by less than a tenth."""
    model, measured = grid_model()
    rows = np.arange(0, 1000, 50)
    wrong = measured.part(rows)
    wrong.measured[7] += [0.005, 0, 0]
    found = fit(model.rows(rows), wrong, Asked(np.ones(len(model.streams))))
    assert found.weights[7] < 1e-3
    assert mean_error(rows, model, measured, found.mean) < 0.127


@pytest.mark.slow
def test_periodic_errors_of_the_joints_are_found():
    """Regions of the workspace that were excluded are predicted to 0.065 mm, and 95 % of them
    within their 95 % regions.
    """
    model, measured = grid_model(32)
    rows = np.arange(0, 1000, 2)
    found = climb(model.rows(rows), measured.part(rows))
    assert [rung.kept for rung in found.rungs] == [True, True, True]
    held = found.kept.blocked
    assert held.mean <= 65e-6
    assert 0.92 <= held.coverage <= 0.98
