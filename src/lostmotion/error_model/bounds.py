"""Every error at its limit: the worst case, and the root-sum-square rule of tolerancing, from the same pose matrix as all other figures."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.pose_matrix import Draws, PoseMatrix
    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats


class _Limits(NamedTuple):
    """The length of the bias (pose,) and the size of each independent error at its limit (error, pose), m; and which have no bound (error,)."""

    bias: Floats
    errors: Floats
    unbounded: list[bool]


def worst_case(matrix: PoseMatrix) -> Floats:
    """Return the largest possible error of the tool at each pose (pose,), m: |bias| + the sum of all errors at their bounds.

    An upper bound: no draw exceeds it. The two parts of a harmonic count as one, since they share a phase. Infinite where a law is unbounded.
    """
    bias, errors, unbounded = _limits(matrix)
    for row, endless in zip(errors, unbounded, strict=True):
        if endless:
            row[:] = np.where(row > 0, np.inf, 0.0)
    return np.asarray(bias + sum(errors))


def root_sum_square(matrix: PoseMatrix) -> Floats:
    """Return the error of the tool at each pose by the root-sum-square rule of tolerancing (pose,), m: |bias| + root of the sum of squared limits.

    A distribution without limits counts with the amount that the file states, three standard deviations.
    """
    bias, errors, _ = _limits(matrix)
    return np.asarray(bias + np.sqrt(sum(errors**2)))


def _limits(matrix: PoseMatrix) -> _Limits:
    rest = _without_mixed_plays(matrix)
    columns = rest.merged
    found: dict[str, Floats] = {}
    endless: dict[str, bool] = {}
    for name, phases in independent_errors(columns.infos).items():
        found[name] = _together([[(np.sqrt(columns.squares[k]) * columns.infos[k].limit) for k in members] for members in phases])
        endless[name] = any(math.isinf(columns.infos[k].bound) for members in phases for k in members)
    if rest is not matrix:
        for name, play, unbounded in _plays_closed_in_some(matrix):
            found[name] = found.get(name, 0.0) + play
            endless[name] = endless.get(name, False) or unbounded
    errors = np.array(list(found.values())).reshape(-1, len(matrix.tool))
    return _Limits(np.linalg.norm(rest.bias[:, 3:], axis=1), errors, list(endless.values()))


def _together(phases: Sequence[Sequence[Floats]]) -> Floats:
    """Return the size of an error (pose,) by the sizes of its columns: those of a phase add, phases count by the root of the sum of squares."""
    return np.asarray(np.sqrt(sum(sum(members) ** 2 for members in phases)))


def independent_errors(infos: Sequence[Draws]) -> dict[str, list[list[int]]]:
    """Return the drawn columns by the name of the stream that decides their sign or phase, and within it by the two phases of a harmonic.

    That stream is the one drawn per visit, or else the one drawn per robot. Columns of one phase, such as a play and its scatter, are largest at the
    same draws and so add; the two phases of a harmonic never are, and count by the root of the sum of their squares.
    """
    out: dict[str, dict[Law, list[int]]] = {}
    for k, info in enumerate(infos):
        deciding = info.visit or info.robot
        if deciding is not None:
            out.setdefault(deciding.name, {}).setdefault(deciding.law, []).append(k)
    return {name: list(phases.values()) for name, phases in out.items()}


def _without_mixed_plays(matrix: PoseMatrix) -> PoseMatrix:
    """Return the matrix without the plays that are closed in some robots only, where they are; the matrix itself where there is none."""
    some = matrix.closed_in_some
    if not some.any():
        return matrix
    rows = [closing.row if (closing := info.closing or info.mean_by) is not None else None for info in matrix.infos]
    there = np.array([np.ones(len(matrix.tool)) if row is None else ~some[row] for row in rows]).T
    return replace(matrix, tool=matrix.tool * there[:, None])


def _plays_closed_in_some(matrix: PoseMatrix) -> list[tuple[str, Floats, bool]]:
    """Return of each play the stream that decides its side, its size at its limit (pose,), m, and whether it has no bound.

    The size is the larger of a closed play, on the side of the load, and an open one, wherever it lets the part rest; zero at poses where the play is
    closed in all robots or open in all.
    """
    by_friction: dict[str, list[int]] = {}
    for k, info in enumerate(matrix.infos):
        if info.mean_by is not None:
            by_friction.setdefault(info.mean_by.stream.name, []).append(k)
    out = []
    for friction, members in by_friction.items():
        size: dict[bool, dict[Law | None, list[Floats]]] = {True: {}, False: {}}
        side = friction
        for k in members:
            info = matrix.infos[k]
            if info.mean_by is None:
                continue
            closed, above = matrix.closed[info.mean_by.row], info.mean_by.above
            share = np.where(matrix.closed_in_some[info.mean_by.row], closed if above else 1 - closed, np.inf)
            size[above].setdefault(None if info.visit is None else info.visit.law, []).append(np.sqrt(matrix.squares[k]) / share * info.limit)
            side = side if info.visit is None else info.visit.name
        closed_size, open_size = (_together([*phases.values(), [np.zeros(len(matrix.tool))]]) for phases in size.values())
        out.append((side, np.maximum(closed_size, open_size), any(math.isinf(matrix.infos[k].bound) for k in members)))
    return out
