"""Inverse kinematics of closed chains with any controlled components of the tool, for many poses
at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.closed_arrays import ASSEMBLED, MET, NOT_ASSEMBLED
from lostmotion.mechanism.closed_chain import assembled_frames
from lostmotion.mechanism.closed_home import home_of
from lostmotion.mechanism.closed_jacobian import motion_units, size, twist_units
from lostmotion.mechanism.closed_position import NEAR_SINGULAR, assemble, chain_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# Longest step of a drive, rad or as a share of the size of the chain.
_LONGEST_STEP: Final = 0.4
# Where continuation from home puts the tool elsewhere, by more than so many times the difference at
# which a pose counts as reached, the steps have led to another assembly mode.
_ELSEWHERE: Final = 100.0
# A drive is outside its limits: besides the problems of `assemble`.
OUT_OF_RANGE: Final = 5
_MOST_STEPS: Final = 40


def tool_and_columns(tree: Tree, q: Floats) -> tuple[Floats, Floats]:
    """Return the pose of the tool (pose, 4, 4), m, and its twist per motion of each drive (pose, 6,
    drive), rad or m per rad or m. Raises InputError for a pose at which the chain is not assembled.
    """
    found = assemble(tree, q)
    if not np.isin(found.problem, (ASSEMBLED, NEAR_SINGULAR)).all():
        assembled_frames(tree, q)  # raises, with the pose and the reason
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
    start      (pose, drive) values to start from; home where the chain is not assembled there, or
               is near a parallel singularity
    rows       controlled components of the tool: 0 to 2 rotation, 3 to 5 position, base axes
    tolerance  rad and m

    Every step is halved until the closures are met again without crossing a singularity. The drives
    of a pose that is not reached are where the steps end; those of the start where the chain then
    has a passive joint outside its limits, is near a parallel singularity, or is in another
    assembly mode. So the chain is assembled at all values that are returned.
    """
    begin, q, done, problem = _ends(tree, limits, wanted, start, rows, tolerance, steps)
    there = problem == ASSEMBLED
    q[~there] = begin[~there]
    return q, done & there


def reached_from_home(
    tree: Tree, limits: Floats, wanted: Floats, rows: np.ndarray, tolerance: float
) -> tuple[Floats, NDArray[np.int64]]:
    """Return values of the drives (pose, drive), rad or m, that bring the tool from home to the
    wanted poses (pose, 4, 4), m, and what is wrong with each (pose,): `ASSEMBLED` for nothing,
    `NOT_ASSEMBLED` where it is not reached, `OUT_OF_RANGE` where a drive is outside its limits, or
    a problem of `assemble`.

    Arguments as `solved`. The limits of the drives do not bend the way: those of poses that are not
    reached without them count last.
    """
    without = np.repeat([[-np.inf, np.inf]], len(limits), axis=0)
    start = np.tile(np.array(tree.home), (len(wanted), 1))
    _, q, done, problem = _ends(tree, without, wanted, start, rows, tolerance, _MOST_STEPS)
    low, high = limits.T
    out = ((q < low - MET) | (q > high + MET)).any(axis=1)
    problem[(problem == ASSEMBLED) & out] = OUT_OF_RANGE
    problem[~done] = NOT_ASSEMBLED
    return np.clip(q, low, high), problem


def _ends(
    tree: Tree,
    limits: Floats,
    wanted: Floats,
    start: Floats,
    rows: np.ndarray,
    tolerance: float,
    steps: int,
) -> tuple[Floats, Floats, NDArray[np.bool_], NDArray[np.int64]]:
    """Return values of the drives (pose, drive) where the steps begin and where they end, whether
    (pose,) they end at the wanted poses, and what `assemble` finds there (pose,).
    """
    from lostmotion.mechanism.closed_inverse_kernel import reach

    chain, drives = chain_of(tree), motion_units(tree, tree.moved)
    first = assemble(tree, start)
    good = first.problem == ASSEMBLED
    home = home_of(tree)
    begin = np.where(good[:, None], start, np.array(tree.home))
    q, motions = np.array(begin), np.array(first.motions)
    motions[~good] = home.motions[:, 0, :3]
    done = np.empty(len(q), dtype=bool)
    tools = np.empty((len(q), 3, 4))
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
        tools,
        done,
    )
    last = assemble(tree, q)
    # passive joints are not compared: idle freedoms stand as the way to them has left them
    away = np.abs(last.frames[-1, :, :3] - tools).max(axis=(1, 2))
    problem = np.where(away < _ELSEWHERE * tolerance, last.problem, NOT_ASSEMBLED)
    return begin, q, done, problem
