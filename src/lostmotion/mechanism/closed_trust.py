"""How far first order is valid in a closed chain with errors: the size of a second step of Newton's
method beside the first one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.closed_composition import placed
from lostmotion.mechanism.closed_jacobian import balance, misfits, motion_units, moved_on
from lostmotion.mechanism.closed_position import assemble
from lostmotion.mechanism.closed_statics import Loops
from lostmotion.spatial import inverse

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# Steps of the passive joints below this, rad or as a share of the size of the chain, are rounding.
_ROUNDING: Final = 1e-9


def share_neglected(loops: Loops, twists: Mapping[int, Floats]) -> Floats:
    """Return the share (pose,) of the motion of the passive joints that first order neglects, with
    places displaced by twists (pose, 6) in their own axes, rad and m.

    The share is |second step| / |first step| of Newton's method with the errors in. The first step
    is first order; the second one is taken with the Jacobian where the first one ends. It is
    infinite where that Jacobian is singular. Near a parallel singularity with a double root the
    chain does not assemble with the errors in only where the share is above one half.
    """
    tree, at = loops.tree, loops.at
    own = {k: inverse(at[place.parent]) @ at[k] for k, place in enumerate(tree.places[1:], start=1)}
    passive = np.array([own[each.place] for each in tree.passive])
    every, units = np.arange(at.shape[1]), balance(tree)[1]
    loads, sizes = np.zeros((len(every), 6 * len(tree.welds))), []
    here, now = placed(loops, own, passive, twists, loads, every), loops
    for _ in range(2):
        misfit = misfits(tree, here).reshape(len(every), -1, 1)
        load, step = now.solved(-misfit, np.zeros((len(every), len(units), 1)))
        sizes.append(np.linalg.norm(step[..., 0] / units, axis=1))
        loads, passive = loads + load[..., 0], moved_on(tree, passive, step[..., 0])
        here = placed(loops, own, passive, twists, loads, every)
        now = Loops(tree, here, loops.compliance, loops.exact)
    first, second = sizes
    share = second / np.maximum(first, _ROUNDING)
    return np.asarray(np.where(np.isfinite(share), share, np.inf))


def loosest(tree: Tree, q: Floats) -> tuple[Floats, Floats]:
    """Return the unit twist (pose, 6) of the tool that errors of the drives move most, and by how
    much (pose,): the gain. Free of units: rotation, and shift as a share of the size of the chain.

    q  (pose, joint) values of the driven joints at which the chain is assembled
    """
    columns = assemble(tree, q).columns * motion_units(tree, tree.moved)
    directions, gains, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(directions[:, :, 0]), np.asarray(gains[:, 0])
