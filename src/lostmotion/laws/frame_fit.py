"""Best-fit base and tool frames of measured or simulated positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.spatial import exp, nearest_rotation, skew

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Relative eigenvalue of the normal equations below which the poses do not determine a parameter.
_SINGULAR: Final = 1e-12
_STEPS: Final = 50
_TOLERANCE: Final = 1e-14
_MIN_POSES: Final = 3


@dataclass(frozen=True)
class Fit:
    """Least-squares frames: attained = base (command + rotation tool).

    base (4, 4)         pose of the actual base frame in the commanded one, m
    tool (3,)           offset of the tool point in tool axes, m; zero where no orientations were
                        given
    residual (pose, 3)  residuals along the axes of the commanded base frame, m
    with_tool           whether a tool offset was fitted
    rank                number of the 6 or 9 frame parameters that the poses determine; the others
                        are zero
    """

    base: Floats
    tool: Floats
    residual: Floats
    with_tool: bool
    rank: int


def best_fit(attained: Floats, command: Floats, rotation: Floats | None = None) -> Fit:
    """Return the base and tool frames that fit attained positions (pose, 3) to commanded ones
    (pose, 3), m, by least squares.

    `rotation` (pose, 3, 3) is the commanded orientation of the tool; None: only the base frame is
    fitted. Gauss-Newton steps from the closed form for the base frame alone (K. Arun, T. Huang, S.
    Blostein, IEEE PAMI 9 (1987) 698). Parameters that the poses do not determine get the smallest
    norm: with a single orientation a tool offset is indistinguishable from a base shift. Raises
    ValueError for fewer than three poses, DidNotConvergeError where the steps do not converge.
    """
    attained, command = np.asarray(attained, dtype=float), np.asarray(command, dtype=float)
    if len(attained) < _MIN_POSES:
        raise ValueError(f"{len(attained)} positions; a frame needs at least {_MIN_POSES}")
    base, tool = rigid(attained, command), np.zeros(3)
    size = max(float(np.abs(command - command.mean(axis=0)).max()), float(np.finfo(float).tiny))
    for _ in range(_STEPS):
        stands = command if rotation is None else command + rotation @ tool
        moved = stands @ base[:3, :3].T + base[:3, 3]
        matrix = _jacobian(
            moved, moved.mean(axis=0), None if rotation is None else base[:3, :3] @ rotation, size
        )
        step = _pseudo_inverse(matrix) @ (attained - moved).ravel()
        turn = exp(np.concatenate([step[:3] / size, np.zeros(3)]))
        about = moved.mean(axis=0)
        turn[:3, 3] = about - turn[:3, :3] @ about + step[3:6]
        base = turn @ base
        if rotation is not None:
            tool = tool + step[6:]
        if np.abs(step).max() < _TOLERANCE * max(size, 1.0) * 100:
            stands = command if rotation is None else command + rotation @ tool
            residual = attained - (stands @ base[:3, :3].T + base[:3, 3])
            return Fit(
                base,
                tool,
                residual,
                rotation is not None,
                int(np.linalg.matrix_rank(matrix.T @ matrix, rtol=_SINGULAR, hermitian=True)),
            )
    raise DidNotConvergeError(
        "the frame fit did not converge: are attained and commanded positions in the same "
        "order and unit?"
    )


def residual_after_fit(errors: Floats, command: Floats, rotation: Floats | None = None) -> Floats:
    """Return the residuals of small errors (pose, ..., 3) at commanded positions (pose, 3), m,
    after the best fit of base and tool frame.

    First order, for many robots at once; `best_fit` is exact. Arguments as there.
    """
    size = max(float(np.abs(command - command.mean(axis=0)).max()), float(np.finfo(float).tiny))
    matrix = _jacobian(command, command.mean(axis=0), rotation, size)
    flat = np.moveaxis(np.asarray(errors, dtype=float), 0, -2).reshape(-1, matrix.shape[0])
    left = flat - (flat @ _pseudo_inverse(matrix).T) @ matrix.T
    shape = np.moveaxis(np.empty(errors.shape), 0, -2).shape
    return np.moveaxis(left.reshape(shape), -2, 0)


def _pseudo_inverse(matrix: Floats) -> Floats:
    """Return the least-squares inverse of a tall matrix from its normal equations; repeated steps
    compensate for the squared condition number.
    """
    return np.asarray(np.linalg.pinv(matrix.T @ matrix, rcond=_SINGULAR, hermitian=True) @ matrix.T)


def rigid(attained: Floats, command: Floats) -> Floats:
    """Return the rigid motion (4, 4) of least squares from commanded to attained positions
    (pose, 3), m, in closed form: the base frame that fits best without a tool offset.
    """
    there, here = attained.mean(axis=0), command.mean(axis=0)
    rotation = nearest_rotation((attained - there).T @ (command - here))
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation, there - rotation @ here
    return out


def _jacobian(points: Floats, about: Floats, rotation: Floats | None, size: float) -> Floats:
    """Return the derivatives of the points (3 pose, 6 or 9) by rotations about a centre (times
    `size`), shifts, and tool offsets.
    """
    blocks = [-skew(points - about) / size, np.broadcast_to(np.eye(3), (len(points), 3, 3))]
    if rotation is not None:
        blocks.append(rotation)
    return np.concatenate(blocks, axis=-1).reshape(3 * len(points), -1)
