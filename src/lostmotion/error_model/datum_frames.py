"""The frame that tolerances of a task are relative to: fitted over all places, or fixed by datum
features one after the other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.spatial import skew

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from lostmotion.spatial import Floats

# Relative singular value below which places do not determine a motion of their frame.
_SINGULAR: Final = 1e-9


def size_of(about: Floats) -> float:
    """Return the largest coordinate (m) of points (place, 3) from their middle."""
    return max(float(np.abs(about).max()), 1e-9)


def carried_by(about: Floats) -> Floats:
    """Return the errors (place, 6, 6) of points (place, 3) per motion of a frame about the origin,
    to first order.
    """
    out = np.zeros((len(about), 6, 6))
    out[:] = np.eye(6)
    out[:, 3:, :3] = -skew(about)
    return out


def fitted_motion(about: Floats) -> Floats:
    """Return the motion (6, place, 6) of a frame per error of the points (place, 3), m, that it is
    fitted to by least squares of their displacements.
    """
    size = size_of(about)
    inverse = np.linalg.pinv(_shape(about, size).reshape(-1, 6), rcond=_SINGULAR)
    return _of_errors(np.asarray(inverse, dtype=float), size)


def datum_motion(about: Floats, datum: Iterable[tuple[NDArray[np.int64], Floats]]) -> Floats:
    """Return the motion (6, place, 6) of a frame per error of the points (place, 3), m.

    datum  features one after the other, each with its places and the directions (n, 3) that it
           fixes there; each fixes what those before it leave free
    """
    size, count = size_of(about), len(about)
    shape = _shape(about, size)
    found, free = np.zeros((6, 3 * count)), np.eye(6)
    for places, ways in datum:
        rows = np.zeros((len(places), len(ways), count, 3))
        for k, place in enumerate(places):
            rows[k, :, place] = ways
        reads = rows.reshape(-1, 3 * count)
        moved = reads @ shape.reshape(-1, 6)
        left, values, right = np.linalg.svd(moved @ free)
        fixed = values > _SINGULAR * max(float(np.linalg.norm(moved)), 1e-300)
        rank = int(fixed.sum())
        inverse = right[:rank].T @ ((left[:, :rank] / values[:rank]).T)
        found = found + free @ inverse @ (reads - moved @ found)
        free = free @ right[rank:].T
    return _of_errors(found, size)


def seen_from(motion: Floats, about: Floats, errors: Floats) -> Floats:
    """Return errors (place, 6, sample) of points (place, 3), m, in the frame that they move by
    `motion`: to second order in its rotation.

    Where a process force turns the frame by milliradians, what is left of the errors turns with it.
    """
    moved = np.tensordot(motion, errors, axes=2)
    turn, at = moved[:3].T, about[:, None]
    carried = np.cross(turn, at)
    turned = np.moveaxis(errors[:, :3], 1, 2) - turn
    shifted = np.moveaxis(errors[:, 3:], 1, 2) - moved[3:].T - carried
    turned = turned - np.cross(turn, turned) / 2
    shifted = shifted - np.cross(turn, shifted + carried / 2)
    return np.moveaxis(np.concatenate([turned, shifted], axis=2), 2, 1)


def _shape(about: Floats, size: float) -> Floats:
    """Return displacements (place, 3, 6) per motion of the frame, rotations times `size`."""
    moved = carried_by(about)[:, 3:]
    moved[..., :3] /= size
    return moved


def _of_errors(motion: Floats, size: float) -> Floats:
    """Return a motion (6, 3 place), rotations times `size`, as (6, place, 6) of errors."""
    out = np.zeros((6, motion.shape[1] // 3, 6))
    out[..., 3:] = motion.reshape(6, -1, 3)
    out[:3] /= size
    return out
