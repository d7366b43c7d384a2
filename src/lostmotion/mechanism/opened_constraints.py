"""Constraints of over-constrained loops that a play opens: their closures then carry nothing there.

A play wider than the misfit of its loop removes a constraint that the others do not need. The part
with the play then has no stiffness in the directions that are redundant; in all others it holds,
because the chain needs it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.mechanism.carry import at_tool_point
from lostmotion.mechanism.closed_home import RANK, home_of
from lostmotion.mechanism.closed_jacobian import balance, signs
from lostmotion.parts.play import HeldPlay, seats_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.mechanism.closed_statics import Loops
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats


class Way(NamedTuple):
    """The plays of a part: its full name and place, their directions (m, 6) in the axes of the
    place, and their half widths (m,), rad or m; infinite where a table states the play.
    """

    part: str
    place: int
    directions: Floats
    half: Floats


# An open constraint gives so many times as much as all springs of the loops: figures differ by 2e-5
# or less from those without it, and the other springs keep their digits.
_GIVES: Final = 1e6


def redundant_ways(loops: Loops, way: Way) -> Floats:
    """Return the twists (pose, 6, m) at a place, in its own axes, by which a play in these
    directions would open constraints that the chain does not need; zero beyond their number.

    Each moves the closures by one, rad or as a share of the size of the chain.
    """
    place, directions, tree = way.place, way.directions, loops.tree
    rows, _ = balance(tree)
    sign = signs(tree)[:, place]
    moved = rows[:6, None] * (at_tool_point(loops.at, place) @ directions.T)
    misfit = np.concatenate([each * moved for each in sign], axis=1)
    size = np.linalg.norm(misfit, axis=1).max(axis=1, initial=0.0)[:, None, None]
    size[size == 0] = 1.0
    felt = loops.redundant.transpose(0, 2, 1) @ misfit / size
    _, found, chosen = np.linalg.svd(felt, full_matrices=False)
    chosen = chosen * (found > RANK)[:, :, None]
    return np.asarray(directions.T @ chosen.transpose(0, 2, 1) / size)


def opened(loops: Loops, ways: Sequence[Way]) -> dict[int, Floats]:
    """Return the compliances (pose, 6, 6) of the places of a chain with the constraints open that
    the chain does not need in the directions of these plays.
    """
    rows, _ = balance(loops.tree)
    most = np.abs(loops.loop_compliance * rows[:, None] * rows).max(axis=(1, 2), initial=0.0)
    give = _GIVES * np.where(most > 0, most, 1.0)[:, None, None]
    out = dict(loops.compliance)
    for way in ways:
        twists = redundant_ways(loops, way)
        out[way.place] = out.get(way.place, 0.0) + give * (twists @ twists.transpose(0, 2, 1))
    return out


def ways_of(terms: Iterable[PlacedTerm]) -> list[Way]:
    """Return the plays of each part that has some, by these terms."""
    found: dict[tuple[str, int], dict[bytes, tuple[Floats, float]]] = {}
    for placed in terms:
        form, level = placed.term.form, placed.term.level
        for seat in seats_of(form):
            own = found.setdefault((placed.whole_part, placed.place), {})
            if not isinstance(form, HeldPlay) or level == "design":
                half = placed.term.scale if isinstance(form, HeldPlay) else math.inf
                own[seat.way.tobytes()] = seat.way, half
    return [
        Way(
            part,
            place,
            np.vstack([way for way, _ in own.values()]),
            np.concatenate([np.full(len(way), half) for way, half in own.values()]),
        )
        for (part, place), own in found.items()
    ]


def has_redundant(tree: Tree) -> bool:
    """Return whether the closures of a chain constrain it more often than it needs."""
    return bool(tree.welds) and home_of(tree).rank < home_of(tree).jacobian.shape[1]
