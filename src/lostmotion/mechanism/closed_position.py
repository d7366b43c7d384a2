"""Position of a closed chain: the motions of the passive joints at which all closures are met.

Newton's method on the closures, for many poses at once. Every pose is reached by continuation from
home, so the chain stays in the assembly mode of its home: where the orientation of the closures'
Jacobian would change, a parallel singularity is crossed, and the pose is refused.
Twists are about the tool point, in the base's axes. Lengths are divided by the size of the chain.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.carry import carry
from lostmotion.mechanism.closed_arrays import ASSEMBLED, MET, ChainArrays
from lostmotion.mechanism.closed_home import RANK, home_of
from lostmotion.mechanism.closed_jacobian import (
    balance,
    frames_at,
    loop_columns,
    motion_units,
    signs,
    size,
    tool_columns,
    twist_units,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# Longest step of the drives from pose to pose of a continuation, rad or as a share of the size.
_STRIDE: Final = 0.5
LIMITED, NEAR_SINGULAR = 3, 4
# Poses at which errors of the drives move the tool this many times as far as at home are too near
# a parallel singularity to be sampled: there is no finite mean square near it.
MOST_GAIN: Final = 5.0
# Bytes of solved poses kept of a chain: some ten thousand poses of a hexapod.
_MOST_KEPT: Final = 96 << 20
# Fewer poses than this are solved faster than they are put beside those kept.
_WORTH_KEEPING: Final = 64


@dataclass(frozen=True, eq=False)
class Assembly:
    """A closed chain at poses.

    frames   (place, pose, 4, 4) of all places, m; of no meaning where the chain is not assembled
    problem  (pose,) `ASSEMBLED`, or why it is not: `NOT_ASSEMBLED`, `SINGULAR` (beyond a parallel
             singularity), `LIMITED` (a passive joint is outside its limits) or `NEAR_SINGULAR`
             (assembled, with a gain above `MOST_GAIN`)
    joint    (pose,) index in `tree.passive` of the joint outside its limits; -1 elsewhere
    motions  (pose, passive, 3, 4) motions of the passive joints
    columns  (pose, 6, drive) twist of the tool about the tool point, in the base's axes, per motion
             of each drive; rad, and lengths as shares of the size of the chain
    """

    frames: Floats
    problem: NDArray[np.int64]
    joint: NDArray[np.int64]
    motions: Floats
    columns: Floats

    @property
    def bytes(self) -> int:
        """Return how many bytes the arrays take."""
        return self.frames.nbytes + self.motions.nbytes + self.columns.nbytes

    def at(self, rows: list[int]) -> Assembly:
        """Return the chain at these poses, its frames in memory pose by pose in each component."""
        frames = self.frames.transpose(0, 2, 3, 1).take(rows, axis=3).transpose(0, 3, 1, 2)
        passive = self.problem[rows], self.joint[rows], self.motions[rows]
        return Assembly(frames, *passive, self.columns[rows])

    def with_more(self, other: Assembly) -> Assembly:
        """Return the chain at these poses and those of another."""
        one, two = (each.frames.transpose(0, 2, 3, 1) for each in (self, other))
        return Assembly(
            np.concatenate([one, two], axis=3).transpose(0, 3, 1, 2),
            np.concatenate([self.problem, other.problem]),
            np.concatenate([self.joint, other.joint]),
            np.concatenate([self.motions, other.motions]),
            np.concatenate([self.columns, other.columns]),
        )


@functools.lru_cache(maxsize=32)
def chain_of(tree: Tree) -> ChainArrays:
    """Return a closed chain as the kernels take it."""
    places, passive = tree.places, tree.passive
    by_joint = [places[each.place].twist.T for each in passive]
    held = np.abs(signs(tree)).sum(axis=0)
    of = np.repeat([each.place for each in passive], [len(each) for each in by_joint]).astype(int)
    moved_by = np.full(len(places), -1)
    moved_by[[each.place for each in passive]] = np.arange(len(passive))
    twists = [np.zeros(6) if place.joint is None else place.twist[:, 0] for place in places]
    return ChainArrays(
        np.array([place.parent for place in places]),
        np.array([place.pose[:3] for place in places]),
        np.array([-1 if place.joint is None else place.joint for place in places]),
        moved_by,
        np.array(twists),
        np.concatenate([[0], np.cumsum([len(each) for each in by_joint])]).astype(int),
        np.concatenate([*by_joint, np.zeros((0, 6))]),
        of,
        signs(tree),
        np.array([weld.places for weld in tree.welds]),
        np.array([weld.frames for weld in tree.welds])[:, :, :3].copy(),
        np.isin(np.arange(len(places)), tree.tool_path),
        np.argsort(held[of], kind="stable"),
        balance(tree)[1],
        np.array(tree.moved),
        size(tree),
        home_of(tree).idle,
    )


class _SolvedPoses:
    """Poses of one chain that were solved last, and the row of each by its values."""

    def __init__(self) -> None:
        """Begin without any."""
        self.last: tuple[dict[bytes, int], Assembly | None] = {}, None

    def with_new(self, keys: list[bytes], new: Assembly) -> tuple[dict[bytes, int], Assembly]:
        """Return all kept poses with new ones of these keys, and keep them, or those alone where
        all together are too large.
        """
        rows, found = self.last
        if found is None or found.bytes + new.bytes > _MOST_KEPT:
            rows, found = {}, new
        else:
            found = found.with_more(new)
        first = len(found.problem) - len(keys)
        rows = {**rows, **{key: first + k for k, key in enumerate(keys)}}
        self.last = (rows, found) if found.bytes <= _MOST_KEPT else ({}, None)
        return rows, found


@functools.lru_cache(maxsize=2)
def _kept(tree: Tree) -> _SolvedPoses:
    del tree  # the key of what is kept
    return _SolvedPoses()


def assemble(tree: Tree, q: Floats) -> Assembly:
    """Return the closed chain at these values of the driven joints (pose, joint), rad or m.

    Poses are solved one by one, so those solved a short while ago are kept.
    """
    values, kept = np.ascontiguousarray(q, dtype=float), _kept(tree)
    keys = [row.tobytes() for row in values]
    rows, found = kept.last
    new = [k for k, key in enumerate(keys) if key not in rows]
    if found is None or len(new) == len(keys):
        solved = _solved(tree, values)
        if len(new) >= _WORTH_KEEPING:
            kept.with_new(keys, solved)
        return solved
    if new:
        rows, found = kept.with_new([keys[k] for k in new], _solved(tree, values[new]))
    if any(key not in rows for key in keys):  # those kept had to make room
        return _solved(tree, values)
    return found.at([rows[key] for key in keys])


def _solved(tree: Tree, q: Floats) -> Assembly:
    # compiled kernels are loaded where they are needed
    from lostmotion.mechanism.closed_continuation_kernel import assemble as continue_from_home

    home, chain, drives = home_of(tree), chain_of(tree), motion_units(tree, tree.moved)
    count = len(q)
    at = np.empty((len(tree.places), 4, 4, count))
    motions = np.empty((count, len(tree.passive), 3, 4))
    columns, problem = np.zeros((count, 6, len(drives))), np.empty(count, dtype=np.int64)
    continue_from_home(
        chain,
        np.array(tree.home),
        _STRIDE * drives,
        np.ascontiguousarray(home.motions[:, 0, :3]),
        np.ascontiguousarray(home.jacobian[0][:, chain.order]),
        q,
        at,
        motions,
        columns,
        problem,
    )
    joint = outside(tree, motions)
    problem[(problem == ASSEMBLED) & (joint >= 0)] = LIMITED
    near = problem == ASSEMBLED
    near[near] = gain(columns[near] * drives) > MOST_GAIN * home_gain(tree)
    problem[near] = NEAR_SINGULAR
    for each in (at, problem, joint, motions, columns):
        each.flags.writeable = False  # they may be kept
    return Assembly(at.transpose(0, 3, 1, 2), problem, joint, motions, columns)


@functools.lru_cache(maxsize=32)
def home_gain(tree: Tree) -> float:
    """Return the gain at home."""
    home, at = home_of(tree), frames_at(tree, np.array(tree.home)[None], home_of(tree).motions)
    drives, units = list(tree.moved), motion_units(tree, tree.moved)
    rows, _ = balance(tree)
    driven = loop_columns(tree, at, drives) * rows[:, None] * units
    tool = np.concatenate([carry(tree, at, k) @ tree.places[k].twist for k in drives], axis=2)
    tool = tool * twist_units(tree)[:, None] * units
    if tree.passive:
        pinv = np.linalg.pinv(home.jacobian, rcond=RANK)
        tool = tool - tool_columns(tree, at) @ (pinv @ driven)
    return float(gain(tool)[0])


def gain(columns: Floats) -> Floats:
    """Return how far (pose,) the tool moves per unit error of the drives, the largest over all
    combinations; rad, and lengths as shares of the size of the chain.

    columns  (pose, 6, drive) twist of the tool per unit motion of each drive, free of units
    """
    return np.asarray(np.linalg.norm(columns, ord=2, axis=(1, 2)))


def outside(tree: Tree, motions: Floats) -> NDArray[np.int64]:
    """Return the first passive joint outside its limits or its cone (pose,); -1 for none.

    motions  (pose, passive, 3, 4)
    """
    joint = np.full(len(motions), -1)
    for k in reversed(range(len(tree.passive))):
        joint[_outside(tree, k, motions[:, k])] = k
    return joint


def _outside(tree: Tree, passive: int, motion: Floats) -> NDArray[np.bool_]:
    """Return whether (pose,) a passive joint is outside its limits or its cone."""
    each = tree.passive[passive]
    out = np.zeros(len(motion), dtype=bool)
    if each.limits is not None:
        value = joint_value(tree.places[each.place].twist[:, 0], motion)
        out |= (value < each.limits[0] - MET) | (value > each.limits[1] + MET)
    if each.cone is not None:
        angle, axis = each.cone
        out |= np.einsum("i,pij,j->p", axis, motion[:, :3, :3], axis) < np.cos(angle)
    return out


def joint_value(twist: Floats, motion: Floats) -> Floats:
    """Return the value (pose,) of a joint with this unit twist (6,) from its motion (pose, 4, 4),
    rad in -pi..pi, or m.
    """
    if not twist[:3].any():
        return np.asarray(motion[:, :3, 3] @ twist[3:])
    turned = motion[:, :3, :3]
    sine = np.stack(
        [turned[:, k, j] - turned[:, j, k] for j, k in ((1, 2), (2, 0), (0, 1))], axis=1
    )
    return np.asarray(np.arctan2(sine @ twist[:3], np.einsum("pii->p", turned) - 1.0))
