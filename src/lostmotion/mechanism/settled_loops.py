"""The closures of a chain with its springs at the loads that they carry."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.mechanism.closed_statics import Loops
from lostmotion.mechanism.opened_constraints import opened

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.mechanism.closed_statics import Spring
    from lostmotion.mechanism.opened_constraints import Way
    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# Rounds in which springs that depend on their load settle, and the change (share) that ends them.
_ROUNDS: Final = 20
_SETTLED: Final = 1e-6


def settled_loops(
    tree: Tree,
    at: Floats,
    of_tree: Floats,
    springs: Callable[[Floats], Sequence[Spring]],
    open_ways: Sequence[Way] = (),
    *,
    exact: bool,
) -> tuple[Loops, Floats]:
    """Return the closures of a chain and the wrenches on its places (place, pose, 6), with the
    springs at their loads.

    of_tree  (place, pose, 6) wrenches of the open tree
    springs  returns the springs under wrenches (place, pose, 6)
    open_ways  places and directions of plays that open constraints (`opened_constraints`)
    exact    whether the closures determine the passive joints exactly

    Raises DidNotConvergeError where springs that depend on their load do not settle.
    """
    if exact:
        loops = Loops(tree, at, {}, exact)
        return loops, loops.wrenches(of_tree)
    found, last = of_tree, None
    for _ in range(_ROUNDS):
        own = springs(found)
        by_place: dict[int, Floats] = {}
        left: dict[int, Floats] = {}
        for place, twist, compliance in own:
            by_place[place] = by_place.get(place, 0.0) + compliance
            free = twist - np.einsum("pij,pj->pi", compliance, found[place])
            left[place] = left.get(place, 0.0) + free
        if last is not None and _equal(last, (by_place, left)):
            return loops, found
        last = by_place, left
        loops, before = Loops(tree, at, by_place, exact), found
        if open_ways:
            by_place = opened(loops, open_ways)
            left = {place: left.get(place, np.zeros((at.shape[1], 6))) for place in by_place}
            loops = Loops(tree, at, by_place, exact)
        found = loops.wrenches(of_tree, [(k, each, by_place[k]) for k, each in left.items()])
        change = np.abs(found - before).max(initial=0.0)
        if change <= _SETTLED * np.abs(found).max(initial=0.0):
            return loops, found
    raise DidNotConvergeError(
        f"closed chain: the loads of springs that depend on their load did not settle in {_ROUNDS} "
        "rounds; state springs that do not depend on it"
    )


def _equal(one: tuple[dict[int, Floats], ...], other: tuple[dict[int, Floats], ...]) -> bool:
    """Return whether the springs of two rounds are equal."""
    return all(
        np.allclose(a[place], b[place], rtol=_SETTLED, atol=0.0)
        for a, b in zip(one, other, strict=True)
        for place in a
    )
