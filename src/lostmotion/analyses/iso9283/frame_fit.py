"""How accurate is the arm once base and tool frame are set as well as can be? The best fit of both to measured or simulated positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.spatial import exp, skew

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Directions of the fit that the poses do not tell: their share, in squares, of the best told one.
_UNTOLD: Final = 1e-12
_STEPS: Final = 50
_CLOSE: Final = 1e-14
_FEWEST: Final = 3
_BASE: Final = 6


@dataclass(frozen=True)
class Fit:
    """Frames that fit best: attained = base (command + rotation tool), by least squares.

    base (4, 4)   where the base frame really is, seen from the commanded one; m
    tool (3,)     by how much the tool point stands off, in the tool's axes, m; zero where the orientations were not given
    residual (pose, 3)  what no frame takes away, m, along the commanded base's axes
    with_tool     whether a tool frame was looked for
    told          how many of the 6 or 9 numbers the poses tell; the others are zero
    """

    base: Floats
    tool: Floats
    residual: Floats
    with_tool: bool
    told: int


def best_fit(attained: Floats, command: Floats, rotation: Floats | None = None) -> Fit:
    """Which base and tool frame bring the commanded positions (pose, 3) nearest to the attained ones (pose, 3), m?

    `rotation` (pose, 3, 3) of the commanded tool; left out, only the base is fitted. Least squares over positions by Gauss and Newton's steps, from
    the closed form for the base alone (K. Arun, T. Huang, S. Blostein, IEEE PAMI 9 (1987) 698). What the poses do not tell is left small: with
    one orientation at all of them, an offset of the tool cannot be told from a shift of the base.
    Raises ValueError for fewer than three poses, DidNotConvergeError where the steps do not end.
    """
    attained, command = np.asarray(attained, dtype=float), np.asarray(command, dtype=float)
    if len(attained) < _FEWEST:
        raise ValueError(f"{len(attained)} positions; a frame needs at least {_FEWEST}")
    base, tool = _closed_form(attained, command), np.zeros(3)
    size = max(float(np.abs(command - command.mean(axis=0)).max()), float(np.finfo(float).tiny))
    for _ in range(_STEPS):
        stands = command if rotation is None else command + rotation @ tool
        moved = stands @ base[:3, :3].T + base[:3, 3]
        matrix = _jacobian(moved, moved.mean(axis=0), None if rotation is None else base[:3, :3] @ rotation, size)
        step = _pseudo_inverse(matrix) @ (attained - moved).ravel()
        turn = exp(np.concatenate([step[:3] / size, np.zeros(3)]))
        about = moved.mean(axis=0)
        turn[:3, 3] = about - turn[:3, :3] @ about + step[3:6]
        base = turn @ base
        if rotation is not None:
            tool = tool + step[6:]
        if np.abs(step).max() < _CLOSE * max(size, 1.0) * 100:
            stands = command if rotation is None else command + rotation @ tool
            residual = attained - (stands @ base[:3, :3].T + base[:3, 3])
            return Fit(base, tool, residual, rotation is not None, int(np.linalg.matrix_rank(matrix.T @ matrix, rtol=_UNTOLD, hermitian=True)))
    raise DidNotConvergeError("the best-fit frames were not found: are attained and commanded positions in the same order and unit?")


def residual_after_fit(errors: Floats, command: Floats, rotation: Floats | None = None) -> Floats:
    """What is left of small errors (pose, ..., 3) at commanded positions (pose, 3), m, once base and tool frame fit best? To first order.

    For many robots at once; `best_fit` is exact. Source as there.
    """
    size = max(float(np.abs(command - command.mean(axis=0)).max()), float(np.finfo(float).tiny))
    matrix = _jacobian(command, command.mean(axis=0), rotation, size)
    flat = np.moveaxis(np.asarray(errors, dtype=float), 0, -2).reshape(-1, matrix.shape[0])
    left = flat - (flat @ _pseudo_inverse(matrix).T) @ matrix.T
    shape = np.moveaxis(np.empty(errors.shape), 0, -2).shape
    return np.moveaxis(left.reshape(shape), -2, 0)


def _pseudo_inverse(matrix: Floats) -> Floats:
    """Give the least-squares inverse of a tall matrix, by its few columns alone: steps that are repeated make up for the squared condition."""
    return np.asarray(np.linalg.pinv(matrix.T @ matrix, rcond=_UNTOLD, hermitian=True) @ matrix.T)


def _closed_form(attained: Floats, command: Floats) -> Floats:
    """Give the base (4, 4) alone that fits best."""
    there, here = attained.mean(axis=0), command.mean(axis=0)
    u, _, vt = np.linalg.svd((attained - there).T @ (command - here))
    rotation = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation, there - rotation @ here
    return out


def _jacobian(points: Floats, about: Floats, rotation: Floats | None, size: float) -> Floats:
    """Give what small turns about a middle (times size), shifts and offsets of the tool do to the points: (3 pose, 6 or 9)."""
    blocks = [-skew(points - about) / size, np.broadcast_to(np.eye(3), (len(points), 3, 3))]
    if rotation is not None:
        blocks.append(rotation)
    return np.concatenate(blocks, axis=-1).reshape(3 * len(points), -1)
