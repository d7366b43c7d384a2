"""Covariance of many estimates by few numbers: base and tool frame that fit the robot best, draws
of little effect that count as independent, and few directions of the others.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.controller_model.percentile import percentile95

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from lostmotion.spatial import Floats

# Change of the mean 95 % radius of the tool that is accepted by each of the two approximations.
_CHANGE: Final = 0.005


def in_best_frames(columns: Floats, frames: NDArray[np.bool_]) -> Floats:
    """Return the matrix (draw, draw) from the draws of a robot to those of the same robot compared
    with the base and tool frame that fit it best: base and tool are no errors of the robot.

    columns  (pose, row, draw) motion of the tool per unit of each draw
    frames   (draw,) which of them move the base or tool frame

    The draws of the frames become those that cancel as much as possible of the motion by all
    others, by least squares over the poses. Valid to first order.
    """
    rows = columns.reshape(-1, columns.shape[2])
    out = np.diag((~frames).astype(float))
    cancelling = np.linalg.lstsq(rows[:, frames], rows[:, ~frames], rcond=1e-9)[0]
    out[np.ix_(frames, ~frames)] = -cancelling
    return out


def reduced(columns: Floats, covariance: Floats) -> Floats:
    """Return a covariance (draw, draw) of few numbers in place of this one, which changes the mean
    95 % radius of the tool by at most 1 %.

    columns  (pose, 3, draw) motion of the tool point per unit of each draw, m

    Draws of little effect become independent of all others. Of the others few principal directions
    of the mean square motion of the tool remain, so that combinations which cancel are dropped.
    """
    whole = _mean_radius(columns, covariance)
    coupling = np.abs(np.einsum("pik,pil->kl", columns, columns) * covariance)
    order = np.argsort(coupling.sum(axis=1) - np.diag(coupling), kind="stable")
    size = len(order)

    def joint(count: int) -> Floats:
        """Return the covariance of all but the `count` draws of least effect; zeros for these."""
        out = covariance.copy()
        out[order[:count]], out[:, order[:count]] = 0.0, 0.0
        return out

    def alone(count: int) -> Floats:
        return np.diag(np.where(np.isin(np.arange(size), order[:count]), np.diag(covariance), 0.0))

    def near(part: Floats, change: float) -> bool:
        return abs(_mean_radius(columns, part) - whole) <= change * whole

    left = _smallest(size, lambda k: near(joint(size - k) + alone(size - k), _CHANGE))
    own = alone(size - left)
    factor = _principal(columns, joint(size - left))
    few = _smallest(left, lambda k: near(factor[:, :k] @ factor[:, :k].T + own, 2 * _CHANGE))
    found = factor[:, :few] @ factor[:, :few].T
    return np.asarray((found + found.T) / 2 + own)


def _smallest(most: int, enough: Callable[[int], bool]) -> int:
    """Return the smallest number of at most `most` that is enough, as are all larger ones."""
    low, high = 0, most
    while low < high:
        middle = (low + high) // 2
        if enough(middle):
            high = middle
        else:
            low = middle + 1
    return high


def _principal(columns: Floats, covariance: Floats) -> Floats:
    """Return a factor F of the covariance F F' whose columns are principal directions of the mean
    square motion of the tool, the largest first.
    """
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    moved = columns @ root
    _, across = np.linalg.eigh(np.einsum("pik,pil->kl", moved, moved))
    factor = root @ across[:, ::-1]
    factor[~covariance.any(axis=1)] = 0.0  # of draws without it there is rounding alone
    return np.asarray(factor)


def _mean_radius(columns: Floats, covariance: Floats) -> float:
    """Return the mean 95 % radius of the tool, m."""
    spread = columns @ covariance @ columns.transpose(0, 2, 1)
    return float(percentile95(np.zeros((len(columns), 3)), spread).mean())
