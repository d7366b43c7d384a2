"""Frames that tolerances of a task are relative to, under errors that turn them by milliradians."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lostmotion.error_model.datum_frames import carried_by, datum_motion, fitted_motion, seen_from

VALIDATES = (
    (
        "frames fitted to the places of a task, or fixed by datum features",
        "SciPy's least-squares rotation of points; a turned body",
        "1e-3 of the residual at 6 mrad; 3e-5 of the motion",
        "error_model/datum_frames.py",
    ),
)
RNG = np.random.default_rng(8)
POINTS = RNG.uniform(-40e-3, 40e-3, (9, 3))
ABOUT = POINTS - POINTS.mean(axis=0)


def residual(motion, errors):
    """Return what is left of errors (place, 6) in the frame, with what second order leaves fitted
    away.
    """
    seen = seen_from(motion, ABOUT, errors[..., None])
    return (seen - carried_by(ABOUT) @ np.tensordot(motion, seen, axes=2))[..., 0]


def test_a_fit_is_that_of_the_turned_points():
    """A process force turns a part by 6 mrad and moves its places by a third of a millimetre beside
    that: to first order the residuals are 1 % off.
    """
    turn = Rotation.from_rotvec([2e-3, -3e-3, 5e-3])
    errors = np.zeros((9, 6))
    errors[:, 3:] = turn.apply(ABOUT) - ABOUT + RNG.normal(0, 2e-4, (9, 3)) + [1e-3, 2e-3, 0]
    at = ABOUT + errors[:, 3:]
    back, _ = Rotation.align_vectors(ABOUT, at - at.mean(axis=0))
    wanted = back.apply(at - at.mean(axis=0)) - ABOUT
    motion = fitted_motion(ABOUT)
    size = np.abs(wanted).max()
    np.testing.assert_allclose(residual(motion, errors)[:, 3:], wanted, atol=1e-3 * size)
    linear = errors - carried_by(ABOUT) @ np.tensordot(motion, errors, axes=2)
    assert np.abs(linear[:, 3:] - wanted).max() > 2e-3 * size


@pytest.mark.parametrize("fixed", [(0, 1, 2), (4, 5, 6, 7)])
def test_a_turned_body_leaves_nothing(fixed):
    """Places and orientations that turn together are where they belong relative to some of them."""
    turn = Rotation.from_rotvec([2e-3, -3e-3, 5e-3])
    errors = np.zeros((9, 6))
    errors[:, :3] = turn.as_rotvec()
    errors[:, 3:] = turn.apply(ABOUT) - ABOUT
    motion = datum_motion(ABOUT, [(np.array(fixed), np.eye(3))])
    found = residual(motion, errors)
    size = np.abs(errors[:, 3:]).max()
    np.testing.assert_allclose(found[:, 3:], 0, atol=3e-5 * size)
    linear = errors - carried_by(ABOUT) @ np.tensordot(motion, errors, axes=2)
    assert np.abs(linear[:, 3:]).max() > 1e-3 * size
    np.testing.assert_allclose(found[:, :3], 0, atol=3e-5 * np.abs(turn.as_rotvec()).max())
