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

from lostmotion.mechanism.carry import at_tool_point, carry
from lostmotion.mechanism.closed_continuation_kernel import ASSEMBLED
from lostmotion.mechanism.closed_continuation_kernel import assemble as continue_from_home
from lostmotion.mechanism.closed_kernel import LONGEST_STEP, MET, Chain
from lostmotion.mechanism.frames import place_frames
from lostmotion.spatial import cross, exp, rotation_vector

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# Singular values below this share of the largest one count as zero.
RANK: Final = 1e-7
# The same at home, near which a double root of Newton's method leaves the square root of `MET`.
_RANK_AT_HOME: Final = 2e-4
# Drives are moved by this, rad or as a share of the size, to look at a chain beside its home.
_BESIDE: Final = 0.02
# Trace of a rotation matrix just above that of half a turn.
_HALF_A_TURN: Final = -1.0 + 1e-6
# Longest step of the drives from pose to pose of a continuation, rad or as a share of the size.
_STRIDE: Final = 0.5
_MOST_AT_HOME, _MOST_AIMING = 200, 30
LIMITED, NEAR_SINGULAR = 3, 4
# Poses at which errors of the drives move the tool this many times as far as at home are too near
# a parallel singularity to be sampled: there is no finite mean square near it.
MOST_GAIN: Final = 5.0


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


@dataclass(frozen=True, eq=False)
class Home:
    """A closed chain where it is first assembled.

    motions   (passive, 1, 4, 4) motions of the passive joints
    jacobian  (1, equation, freedom) of the closures
    misfit    (closure, 2) distance from closing, rad and m
    rank      rank of the Jacobian
    crossed   whether the way from the stated start led through a singularity
    """

    motions: Floats
    jacobian: Floats
    misfit: Floats
    rank: int
    crossed: bool

    @property
    def idle(self) -> int:
        """Return the number of freedoms that no closure holds."""
        return int(self.jacobian.shape[2]) - self.rank

    @property
    def met(self) -> bool:
        """Return whether all closures are met."""
        return bool(np.isfinite(self.misfit).all() and (self.misfit < MET).all())


@functools.lru_cache(maxsize=32)
def size(tree: Tree) -> float:
    """Return the longest fixed distance within the chain, m."""
    return max((float(np.linalg.norm(each.pose[:3, 3])) for each in tree.places), default=0) or 1.0


@functools.lru_cache(maxsize=32)
def signs(tree: Tree) -> NDArray[np.int64]:
    """Return (closure, place): 1 where the place carries only the first frame of the closure, -1
    where it carries only the second one, else 0.
    """
    out = np.zeros((len(tree.welds), len(tree.places)), dtype=np.int64)
    for row, weld in zip(out, tree.welds, strict=True):
        for place, sign in zip(weld.places, (1, -1), strict=True):
            row[list(tree.inboard(place))] += sign
    return out


def loop_columns(tree: Tree, at: Floats, places: list[int]) -> Floats:
    """Return the misfit of all closures per motion of these places (pose, equation, freedom), about
    the tool point, rad and m.
    """
    out, sign = [], signs(tree)
    for place in places:
        moved = at_tool_point(at, place) @ tree.places[place].twist
        out.append(np.concatenate([each * moved for each in sign[:, place]], axis=1))
    return np.concatenate(out, axis=2) if out else np.zeros((at.shape[1], 6 * len(tree.welds), 0))


def balance(tree: Tree) -> tuple[Floats, Floats]:
    """Return the factors by which equations (equation,) and freedoms (freedom,) of the passive
    joints become free of units.
    """
    rows = np.tile(twist_units(tree), len(tree.welds))
    return rows, motion_units(tree, [each.place for each in tree.passive])


def twist_units(tree: Tree) -> Floats:
    """Return the factors (6,) by which a twist becomes free of units."""
    return np.concatenate([np.ones(3), np.full(3, 1 / size(tree))])


def motion_units(tree: Tree, places: Sequence[int]) -> Floats:
    """Return the motions (freedom,) of these places that count as one: a radian of those that turn,
    the size of the chain of those that slide.
    """
    long = size(tree)
    units = [np.where(tree.places[k].twist[:3].any(axis=0), 1.0, long) for k in places]
    return np.concatenate([*units, np.zeros(0)])


def _jacobian(tree: Tree, at: Floats) -> Floats:
    rows, columns = balance(tree)
    return loop_columns(tree, at, [each.place for each in tree.passive]) * rows[:, None] * columns


def misfits(tree: Tree, at: Floats) -> Floats:
    """Return how far the first frame of each closure is from the second (pose, closure, 6), about
    the tool point, rad and m.
    """
    out = np.empty((at.shape[1], len(tree.welds), 6))
    for k, weld in enumerate(tree.welds):
        first, second = (
            at[place] @ frame for place, frame in zip(weld.places, weld.frames, strict=True)
        )
        turned = first[:, :3, :3] @ second[:, :3, :3].transpose(0, 2, 1)
        rotation = rotation_vector(turned)
        turned_over = np.einsum("pii->p", turned) < _HALF_A_TURN
        if turned_over.any():  # where the sines of rotation matrices say little
            from scipy.spatial.transform import Rotation

            rotation[turned_over] = Rotation.from_matrix(turned[turned_over]).as_rotvec()
        middle = (first[:, :3, 3] + second[:, :3, 3]) / 2
        out[:, k, :3] = rotation
        out[:, k, 3:] = (
            first[:, :3, 3] - second[:, :3, 3] + cross(rotation, at[-1, :, :3, 3] - middle)
        )
    return out


def _frames(tree: Tree, q: Floats, motions: Floats) -> Floats:
    moved = {each.place: motions[k] for k, each in enumerate(tree.passive)}
    return place_frames(tree, q, moved)


def moved_on(tree: Tree, motions: Floats, step: Floats) -> Floats:
    """Return motions of the passive joints (passive, pose, 4, 4) after a further step (pose,
    freedom), rad and m.
    """
    out, first = np.empty_like(motions), 0
    for k, each in enumerate(tree.passive):
        twist = tree.places[each.place].twist
        last = first + twist.shape[1]
        out[k] = motions[k] @ exp(step[:, first:last] @ twist.T)
        first = last
    return out


def _newton(tree: Tree, q: Floats, motions: Floats) -> tuple[Floats, Floats]:
    """Return motions and Jacobian of one chain at each of few poses after Newton's steps from these
    motions, of any rank.
    """
    rows, columns = balance(tree)
    motions = motions.copy()
    active = np.arange(len(q))
    jacobian = np.empty((len(q), len(rows), len(columns)))
    last = np.full(len(q), np.inf)
    for _ in range(_MOST_AT_HOME + 1):
        at = _frames(tree, q[active], motions[:, active])
        away = misfits(tree, at).reshape(len(active), -1) * rows
        jacobian[active] = here = _jacobian(tree, at)
        now = np.abs(away).max(axis=1, initial=0.0)
        # one more step after the closures are met, which squares what is left
        going = np.isfinite(now) & ~((now < MET) & (last[active] < MET**0.5))
        going &= now > np.finfo(float).eps
        last[active] = now
        active, here, away = active[going], here[going], away[going]
        if not len(active) or not len(columns):
            break
        step = -(np.linalg.pinv(here, rcond=RANK) @ away[:, :, None])[..., 0]
        step /= np.maximum(np.abs(step).max(axis=1, keepdims=True) / LONGEST_STEP, 1.0)
        motions[:, active] = moved_on(tree, motions[:, active], step * columns)
    return motions, jacobian


def _same_side(before: Floats, now: Floats, idle: int) -> NDArray[np.bool_]:
    """Return whether (pose,) two Jacobians have one orientation: no singularity is between."""
    product = before.transpose(0, 2, 1) @ now
    if not product.shape[1]:
        return np.ones(len(product), dtype=bool)
    if not idle:
        return np.asarray(np.linalg.slogdet(product)[0] > 0)
    values = np.linalg.eigvals(product)
    kept = np.take_along_axis(values, np.argsort(np.abs(values), axis=1)[:, idle:], axis=1)
    return np.asarray(kept.prod(axis=1).real > 0)


@functools.lru_cache(maxsize=32)
def home_of(tree: Tree) -> Home:
    """Return the chain at home: from where its file states that the passive joints start."""
    q = np.array(tree.home)[None]
    start = _aimed(tree, q, np.array([each.start for each in tree.passive]).reshape(-1, 1, 4, 4))
    before = _jacobian(tree, _frames(tree, q, start))
    motions, jacobian = _newton(tree, q, start)
    at = _frames(tree, q, motions)
    away = misfits(tree, at)[0]
    rank = rank_of(jacobian[0])
    idle = jacobian.shape[2] - rank
    return Home(
        motions,
        jacobian,
        np.linalg.norm(away.reshape(-1, 2, 3), axis=2) / [1.0, size(tree)],
        rank,
        not bool(_same_side(before, jacobian, idle)[0]),
    )


def _aimed(tree: Tree, q: Floats, motions: Floats) -> Floats:
    """Return motions at which legs aim at the bodies that they carry, whose start stays: legs all
    straight up have no orientation that could be compared with that of the closed chain.
    """
    rows, columns = balance(tree)
    wide = [tree.places[each.place].twist.shape[1] for each in tree.passive]
    held = np.repeat([freedoms == len(twist_units(tree)) for freedoms in wide], wide)
    for _ in range(_MOST_AIMING if held.any() else 0):
        at = _frames(tree, q, motions)
        away = (misfits(tree, at).reshape(1, -1) * rows)[..., None]
        step = -(np.linalg.pinv(_jacobian(tree, at) * ~held, rcond=RANK) @ away)[..., 0]
        motions = moved_on(tree, motions, np.clip(step, -_LONGEST_STEP, _LONGEST_STEP) * columns)
    return motions


def rank_of(matrix: Floats) -> int:
    """Return the rank of a balanced Jacobian (equation, freedom)."""
    values = np.linalg.svd(matrix, compute_uv=False)
    return int((values > _RANK_AT_HOME * values.max(initial=0.0)).sum())


def nearby_rank(tree: Tree) -> int:
    """Return the largest rank of the closures' Jacobian beside home."""
    home, reach = home_of(tree), motion_units(tree, tree.moved)
    sides = np.array([[1.0], [-1.0]]) * _BESIDE * np.linspace(1.0, 0.5, len(reach))
    beside, start = np.array(tree.home) + sides * reach, np.repeat(home.motions, 2, axis=1)
    found = _newton(tree, beside, start)[1]
    return max(rank_of(each) for each in found)


def tool_columns(tree: Tree, at: Floats) -> Floats:
    """Return the twist of the tool per motion of the passive joints (pose, 6, freedom), free of
    units.
    """
    _, columns = balance(tree)
    moved = [carry(tree, at, each.place) @ tree.places[each.place].twist for each in tree.passive]
    return np.asarray(np.concatenate(moved, axis=2) * twist_units(tree)[:, None] * columns)


@functools.lru_cache(maxsize=32)
def chain_of(tree: Tree) -> Chain:
    """Return a closed chain as the kernels take it."""
    places, passive = tree.places, tree.passive
    by_joint = [places[each.place].twist.T for each in passive]
    held = np.abs(signs(tree)).sum(axis=0)
    of = np.repeat([each.place for each in passive], [len(each) for each in by_joint]).astype(int)
    moved_by = np.full(len(places), -1)
    moved_by[[each.place for each in passive]] = np.arange(len(passive))
    twists = [np.zeros(6) if place.joint is None else place.twist[:, 0] for place in places]
    return Chain(
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


def assemble(tree: Tree, q: Floats) -> Assembly:
    """Return the closed chain at these values of the driven joints (pose, joint), rad or m."""
    home, chain, drives = home_of(tree), chain_of(tree), motion_units(tree, tree.moved)
    count = len(q)
    at = np.empty((len(tree.places), 4, 4, count))
    motions = np.empty((count, len(tree.passive), 3, 4))
    columns, problem = np.empty((count, 6, len(drives))), np.empty(count, dtype=np.int64)
    continue_from_home(
        chain,
        np.array(tree.home),
        _STRIDE * drives,
        np.ascontiguousarray(home.motions[:, 0, :3]),
        np.ascontiguousarray(home.jacobian[0][:, chain.order]),
        np.ascontiguousarray(q, dtype=float),
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
    return Assembly(at.transpose(0, 3, 1, 2), problem, joint, motions, columns)


@functools.lru_cache(maxsize=32)
def home_gain(tree: Tree) -> float:
    """Return the gain at home."""
    home, at = home_of(tree), _frames(tree, np.array(tree.home)[None], home_of(tree).motions)
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
