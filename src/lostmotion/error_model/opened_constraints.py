"""Over-constrained chains with plays: whether the constraint that a play could open is closed or
open, whichever makes the larger error.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.pose_matrix import screws
from lostmotion.errors import InputError
from lostmotion.mechanism.assembly import may_not_assemble
from lostmotion.mechanism.carry import at_tool_point
from lostmotion.mechanism.even_poses import few_even_poses
from lostmotion.mechanism.opened_constraints import has_redundant, redundant_ways, ways_of
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.mechanism.state import state_of
from lostmotion.printed import digits

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.closed_statics import Loops
    from lostmotion.mechanism.opened_constraints import Way
    from lostmotion.spatial import Floats

# Every 16th of the 256 poses spread evenly.
_EVERY: Final = 16
_DEVIATIONS: Final = 2
# An error that is larger by less than this share changes no digit that is printed.
_MATTERS: Final = 1e-3


def redundant_plays(arm: Arm, q: Floats) -> list[Way]:
    """Return the plays in directions of constraints that the closed chain does not need, at any of
    these values of the driven joints (pose, joint).
    """
    closed = state_of(arm, q).closed if has_redundant(arm.tree) else None
    if closed is None:
        return []
    return [way for way in ways_of(arm.terms) if redundant_ways(closed[0], way).any()]


def open_matrices(arm: Arm, q: Floats, ways: Iterable[Way]) -> dict[str, PoseMatrix]:
    """Return the pose matrix with the constraints of each of these plays open, by its part, but for
    those across which loads and errors carry the part at all poses q (pose, joint), and those that
    leave an error of rigid parts without an answer.
    """
    out = {}
    for way in ways:
        try:
            matrix = screws(state_of(arm.with_open_play(way.part), q))
        except InputError:
            continue
        if matrix.state.closed is not None and _may_be_open(matrix, *matrix.state.closed, way):
            out[way.part] = matrix
    return out


def _may_be_open(matrix: PoseMatrix, loops: Loops, wrenches: Floats, way: Way) -> bool:
    """Return whether a part with its constraints open stays within its play at any pose: loads and
    errors, their mean and two deviations, move it less than that far.
    """
    # position in the play (pose, m, 6) per wrench on the place
    gives = np.linalg.pinv(way.directions.T) @ loops.compliance[way.place]
    own = at_tool_point(loops.at, way.place).transpose(0, 2, 1)
    errors = gives @ own @ loops.on_place(way.place, loops.loads(matrix.place, matrix.local))
    drawn = np.array([bool(info.draws) for info in matrix.infos])
    fixed = np.array([not (info.draws or info.of.term.form.elastic) for info in matrix.infos])
    others = np.array([info.of.whole_part != way.part for info in matrix.infos])
    moved = (gives @ wrenches[way.place, :, :, None])[..., 0]
    moved = moved + errors[:, :, fixed & others].sum(axis=2)
    spread = np.sqrt((errors[:, :, drawn & others] ** 2).sum(axis=2))
    return bool((np.abs(moved) - _DEVIATIONS * spread <= way.half).all(axis=1).any())


def with_larger_error(arm: Arm) -> Arm:
    """Return an over-constrained arm with all its constraints closed, or with those open that the
    play of one part opens: whichever has the larger r.m.s. error over 16 poses spread evenly, by
    0.1 % at least, with a remark on both. Any other arm as it is.

    Loads smaller than those that carry a part across its play leave a redundant constraint open,
    larger ones close it; which it is differs from robot to robot. Plays of several parts that are
    open together are not evaluated.
    """
    if not may_not_assemble(arm) or arm.open_ways or not has_redundant(arm.tree):
        return arm
    try:
        q = few_even_poses(arm)[::_EVERY]
        ways = redundant_plays(arm, q)
        closed = _root_mean_square(screws(state_of(arm, q))) if ways else 0.0
    except InputError:  # what is asked of it says so
        return arm
    if not ways:
        return arm
    where = f"at {len(q)} poses spread evenly"
    errors = {part: _root_mean_square(each) for part, each in open_matrices(arm, q, ways).items()}
    if not errors:
        return arm.with_open_play(
            "",
            f"loads and errors carry every part across its play in redundant constraints {where}: "
            "they are all closed",
        )
    largest = max(errors, key=lambda part: errors[part])
    more, name = errors[largest] / closed - 1, short_name(largest)
    opens = more > _MATTERS
    compared = f"{digits(100 * abs(more))} % {'more' if more >= 0 else 'less'} than with all closed"
    counted = "1 part" if len(errors) == 1 else f"{len(errors)} parts"
    return arm.with_open_play(
        largest if opens else "",
        f"plays of {counted} may leave redundant constraints open. Opened one by one, "
        f"that of {name} makes the largest r.m.s. error {where}: {compared}. All figures are with "
        + (f"those of {name} open" if opens else "all closed"),
    )


def _root_mean_square(matrix: PoseMatrix) -> float:
    """Return the r.m.s. error of the tool point (m) over the poses of a pose matrix."""
    return math.sqrt(float(np.mean(matrix.merged.level_squares.sum(axis=1))))
