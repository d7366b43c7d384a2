"""Loops of a closed chain, one for each closure: which joints they move, and how often they are
over-constrained.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from lostmotion.mechanism.closed_home import home_of, rank_of
from lostmotion.mechanism.closed_jacobian import signs

if TYPE_CHECKING:
    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats


class ClosedLoop(NamedTuple):
    """A loop: names of the two places that its closure joins, those of its passive joints, and how
    many of its six constraints those before it and its passive joints do not need.
    """

    joins: tuple[str, str]
    passive: tuple[str, ...]
    redundant: int


def loops_of(tree: Tree) -> tuple[ClosedLoop, ...]:
    """Return the loops of a closed chain, with the constraints that are redundant at home.

    Closures count in the order of the file, so that their redundant constraints add up to those of
    the chain: the second and third leg of a planar stage are over-constrained three times each, and
    the first one, which alone holds the platform, is not.
    """
    if not tree.welds:
        return ()
    jacobian, out, before = home_of(tree).jacobian[0], [], 0
    for k, (weld, sign) in enumerate(zip(tree.welds, signs(tree), strict=True)):
        rank = rank_of(jacobian[: 6 * k + 6])
        passive = dict.fromkeys(each.joint for each in tree.passive if sign[each.place])
        first, second = (tree.places[place].name for place in weld.places)
        out.append(ClosedLoop((first, second), tuple(passive), 6 - rank + before))
        before = rank
    return tuple(out)


def joined_points(tree: Tree) -> list[tuple[int, Floats]]:
    """Return a place of each closure and the point (3,), m, in its frame at which it closes."""
    return [(weld.places[0], weld.frames[0][:3, 3]) for weld in tree.welds]
