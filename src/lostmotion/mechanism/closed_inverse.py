"""Inverse kinematics of closed chains with any controlled components of the tool, for many poses
at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.closed_arrays import ASSEMBLED
from lostmotion.mechanism.closed_home import home_of
from lostmotion.mechanism.closed_inverse_kernel import reach
from lostmotion.mechanism.closed_jacobian import motion_units, size, twist_units
from lostmotion.mechanism.closed_position import NEAR_SINGULAR, assemble, chain_of

if TYPE_CHECKING:
    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# Longest step of a drive, rad or as a share of the size of the chain.
_LONGEST_STEP: Final = 0.4
# A pose that continuation from home assembles elsewhere, by more than so many times the difference
# at which a pose counts as reached, is in another assembly mode.
_ELSEWHERE: Final = 100.0


def tool_and_columns(tree: Tree, q: Floats) -> tuple[Floats, Floats]:
    """Return the pose of the tool (pose, 4, 4), m, and its twist per motion of each drive (pose, 6,
    drive), rad or m per rad or m; of no meaning where the chain is not assembled.
    """
    found = assemble(tree, q)
    return found.frames[-1], found.columns / twist_units(tree)[:, None]


def solved(
    tree: Tree,
    limits: Floats,
    wanted: Floats,
    start: Floats,
    rows: np.ndarray,
    tolerance: float,
    steps: int,
) -> tuple[Floats, np.ndarray]:
    """Return values of the drives (pose, drive), rad or m, that bring the tool to the wanted poses
    (pose, 4, 4), m, in the assembly mode of home, and a mask (pose,) of those that were reached.

    limits     (drive, 2) rad or m
    start      (pose, drive) values to start from; home where the chain is not assembled there
    rows       controlled components of the tool: 0 to 2 rotation, 3 to 5 position, base axes
    tolerance  rad and m

    Every step is halved until the closures are met again without crossing a singularity. A pose
    with a passive joint outside its limits, or near a parallel singularity, is not reached. The
    drives of a pose that is not reached are those of its start.
    """
    chain, drives = chain_of(tree), motion_units(tree, tree.moved)
    first = assemble(tree, start)
    good = (first.problem == ASSEMBLED) | (first.problem == NEAR_SINGULAR)
    home = home_of(tree)
    begin = np.where(good[:, None], start, np.array(tree.home))
    q, motions = np.array(begin), np.array(first.motions)
    motions[~good] = home.motions[:, 0, :3]
    done = np.empty(len(q), dtype=bool)
    columns = np.empty((len(q), 6, len(drives)))
    reach(
        chain,
        q,
        motions,
        np.ascontiguousarray(wanted[:, :3], dtype=float),
        np.asarray(rows, dtype=np.int64),
        np.ascontiguousarray(limits),
        _LONGEST_STEP * drives,
        np.array([tolerance, tolerance / size(tree)]),
        steps,
        columns,
        done,
    )
    last = assemble(tree, q)
    # what a pose is, is where continuation from home assembles it
    ahead = np.abs(last.motions - motions).max(axis=(1, 2, 3), initial=0.0)
    there = (last.problem == ASSEMBLED) | (last.problem == NEAR_SINGULAR)
    there &= ahead < _ELSEWHERE * tolerance
    q[~there] = begin[~there]
    return q, done & there & (last.problem == ASSEMBLED)
