"""Bounds of the tool error with every error at its limit: worst case and the root-sum-square rule
of tolerancing, from the pose matrix.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lostmotion.error_model.closing import closed_in_some

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.closing import Closing
    from lostmotion.error_model.columns import Draws
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats


class Bounds(NamedTuple):
    """Bounds of the tool error at each pose, m.

    worst_case       (pose,) |bias| + the sum of all errors at their bounds
    root_sum_square  (pose,) |bias| + root of the sum of squared limits, the rule of tolerancing
    """

    worst_case: Floats
    root_sum_square: Floats


def worst_case(matrix: PoseMatrix) -> Floats:
    """Return the worst-case error of the tool at each pose (pose,), m: |bias| + the sum of all
    errors at their bounds.

    No draw exceeds this upper bound. The two phases of a harmonic count as one error. Infinite
    where an unbounded distribution moves the tool.
    """
    return bounds(matrix).worst_case


def bounds(matrix: PoseMatrix) -> Bounds:
    """Return the worst case and the root-sum-square of the tool error at each pose.

    The worst case is infinite where an unbounded distribution moves the tool. In the
    root-sum-square such a distribution counts with the tolerance that the file states, which is
    three standard deviations.
    """
    rest = _without_mixed_plays(matrix)
    columns = rest.merged
    sizes = np.sqrt(columns.squares) * np.array([info.limit for info in columns.infos])[:, None]
    # The size of each independent error at its limit (pose,), m, and whether its distribution has
    # no bound.
    found: dict[str, Floats] = {}
    unbounded: dict[str, bool] = {}
    for name, phases in independent_errors(columns.infos).items():
        found[name] = _combined([[sizes[k] for k in members] for members in phases])
        unbounded[name] = any(
            math.isinf(columns.infos[k].bound) for members in phases for k in members
        )
    if rest is not matrix:
        for name, play, infinite in _plays_closed_in_some(matrix):
            found[name] = found.get(name, 0.0) + play
            unbounded[name] = unbounded.get(name, False) or infinite
    limits = np.array(list(found.values())).reshape(-1, len(matrix.tool))
    largest = np.where(
        np.array(list(unbounded.values()), dtype=bool)[:, None] & (limits > 0), np.inf, limits
    )
    bias = np.linalg.norm(rest.bias[:, 3:], axis=1)
    return Bounds(np.asarray(bias + sum(largest)), np.asarray(bias + np.sqrt(sum(limits**2))))


def _combined(phases: Sequence[Sequence[Floats]]) -> Floats:
    """Return the size of an error (pose,) from the sizes of its columns: columns of one phase add,
    the phases add as squares.
    """
    return np.asarray(np.sqrt(sum(sum(members) ** 2 for members in phases)))


def independent_errors(infos: Sequence[Draws]) -> dict[str, list[list[int]]]:
    """Return the numbers of the drawn columns, one list per phase, by the name of the stream that
    determines their sign or phase.

    That stream is the one drawn per visit, or else the one drawn per robot. Columns of one phase,
    such as a play and its scatter, reach their largest size at the same draws, and so add. The two
    phases of a harmonic never do: they count by the root of the sum of their squares.
    """
    out: dict[str, dict[Law, list[int]]] = {}
    for k, info in enumerate(infos):
        stream = info.visit or info.robot
        if stream is not None:
            out.setdefault(stream.name, {}).setdefault(stream.law, []).append(k)
    return {name: list(phases.values()) for name, phases in out.items()}


def _without_mixed_plays(matrix: PoseMatrix) -> PoseMatrix:
    """Return the matrix with zeros for plays at poses where only some robots have them closed; the
    matrix itself where there are none.
    """
    some = matrix.closed_in_some
    if not some.any():
        return matrix
    rows = [
        closing.row if (closing := info.closing or info.mean_by) is not None else None
        for info in matrix.infos
    ]
    uniform = np.array([np.ones(len(matrix.tool)) if row is None else ~some[row] for row in rows]).T
    return replace(matrix, tool=matrix.tool * uniform[:, None])


def _plays_closed_in_some(matrix: PoseMatrix) -> list[tuple[str, Floats, bool]]:
    """Return for each play the name of the stream of its side, its size at its limit (pose,) in m,
    and whether it is unbounded.

    The size is the larger of two: the closed play, with the part on the side of the load, and the
    open play, with the part at its farthest position. It is zero at poses where the play is closed
    in all robots or open in all.
    """
    by_friction: dict[str, list[tuple[int, Closing]]] = {}
    for k, info in enumerate(matrix.infos):
        if info.mean_by is not None:
            by_friction.setdefault(info.mean_by.stream.name, []).append((k, info.mean_by))
    out = []
    for friction, members in by_friction.items():
        size: dict[bool, dict[Law | None, list[Floats]]] = {True: {}, False: {}}
        side = friction
        for k, closing in members:
            info, closed = matrix.infos[k], matrix.closed[closing.row]
            share = np.where(
                closed_in_some(closed), closed if closing.above else 1 - closed, np.inf
            )
            size[closing.above].setdefault(
                None if info.visit is None else info.visit.law, []
            ).append(np.sqrt(matrix.squares[k]) / share * info.limit)
            side = side if info.visit is None else info.visit.name
        closed_size, open_size = (
            _combined([*phases.values(), [np.zeros(len(matrix.tool))]]) for phases in size.values()
        )
        out.append(
            (
                side,
                np.maximum(closed_size, open_size),
                any(math.isinf(matrix.infos[k].bound) for k, _ in members),
            )
        )
    return out
