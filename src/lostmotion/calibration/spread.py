"""Whether measured poses are spread over the workspace or lie in a slab."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.model import model_of
from lostmotion.mechanism.inverse import inverse_kinematics

if TYPE_CHECKING:
    from lostmotion.calibration.model import RobotModel
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats

# Extent along a principal axis, as a share of the largest, below which the poses lie in a slab.
_THIN: Final = 0.25
_WITH_ORIENTATION: Final = 6
_FEWEST: Final = 3


def variance_elsewhere(model: RobotModel, covariance: Floats) -> float:
    """Return the mean predicted variance of the tool beside the measured poses over that at them: 1
    where they extend in all directions.

    covariance  (stream, stream) of the estimates

    Beside them are poses of the same orientation, along the directions in which the measured
    points extend least, as far as they extend in the others.
    """
    arm, frames = model.matrix.state.arm, model.matrix.state.frames[-1]
    points = frames[:, :3, 3]
    _, sizes, directions = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    thin = sizes < _THIN * sizes[0]
    if not thin.any():
        return 1.0
    far = np.sqrt(3.0) * sizes[0] / np.sqrt(len(points))
    moved = [
        _moved(frames, sign * far * direction) for direction in directions[thin] for sign in (-1, 1)
    ]
    beside = _reached(arm, np.concatenate(moved), np.tile(model.matrix.state.q, (len(moved), 1)))
    if len(beside) < _FEWEST:
        return 1.0
    there = model_of(arm.calibrated(None), beside, _added(arm))
    columns = there.columns[:, 3:, there.numbers(model.streams)]
    return _variance(columns, covariance) / _variance(model.columns[:, 3:], covariance)


def _added(arm: Arm) -> tuple[PlacedTerm, ...]:
    return () if arm.calibration is None else arm.calibration.added


def _moved(frames: Floats, by: Floats) -> Floats:
    """Return frames (pose, 4, 4) shifted by a vector (3,), m."""
    out = frames.copy()
    out[:, :3, 3] += by
    return out


def _reached(arm: Arm, wanted: Floats, start: Floats) -> Floats:
    full = len(arm.driven) >= _WITH_ORIENTATION
    q, reached = inverse_kinematics(arm, wanted, start, with_orientation=full)
    return np.asarray(q[reached])


def _variance(columns: Floats, covariance: Floats) -> float:
    return float(np.einsum("pik,kl,pil->p", columns, covariance, columns).mean())
