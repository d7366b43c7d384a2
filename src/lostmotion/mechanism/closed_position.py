"""Position of a closed chain: the motions of the passive joints at which all closures are met.

Newton's method on the closures, for many poses at once. Every pose is reached by continuation from
home, so the chain stays in the assembly mode of its home: where the orientation of the closures'
Jacobian would change, a parallel singularity is crossed, and the pose is refused.
Twists are about the tool point, in the base's axes. Lengths are divided by the size of the chain.
"""

from __future__ import annotations

import contextlib
import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.carry import at_tool_point, carry
from lostmotion.mechanism.frames import place_frames
from lostmotion.spatial import cross, exp, rotation_vector

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# A closure counts as met below this misfit, rad and as a share of the size of the chain; Newton's
# last step is far below it.
MET: Final = 1e-9
# Singular values below this share of the largest one count as zero.
RANK: Final = 1e-7
# The same at home, near which a double root of Newton's method leaves the square root of `MET`.
_RANK_AT_HOME: Final = 2e-4
# Drives are moved by this, rad or as a share of the size, to look at a chain beside its home.
_BESIDE: Final = 0.02
# Trace of a rotation matrix just above that of half a turn.
_HALF_A_TURN: Final = -1.0 + 1e-6
# Met well enough for a pose on the way to another.
_NEARLY_MET: Final = 1e-3
_LONGEST_STEP: Final = 0.3
# Longest step of the drives from pose to pose of a continuation, rad or as a share of the size.
_STRIDE: Final = 0.5
_MOST_STEPS, _MOST_AT_HOME, _MOST_AIMING = 6, 200, 30
_SHORTEST: Final = 2.0**-7
ASSEMBLED, NOT_ASSEMBLED, SINGULAR, LIMITED, NEAR_SINGULAR = range(5)
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
    """

    frames: Floats
    problem: NDArray[np.int64]
    joint: NDArray[np.int64]


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
    return rows, _motion_units(tree, [each.place for each in tree.passive])


def twist_units(tree: Tree) -> Floats:
    """Return the factors (6,) by which a twist becomes free of units."""
    return np.concatenate([np.ones(3), np.full(3, 1 / size(tree))])


def _motion_units(tree: Tree, places: Sequence[int]) -> Floats:
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


def _newton(
    tree: Tree, q: Floats, motions: Floats, most: int, idle: int, met: Floats | float = MET
) -> tuple[Floats, Floats, Floats]:
    """Return motions, Jacobian and misfit (pose,) after Newton's steps from these motions, which
    end where the misfit is below `met` (pose,).
    """
    met = np.broadcast_to(met, len(q))
    rows, columns = balance(tree)
    motions = motions.copy()
    active = np.arange(len(q))
    jacobian = np.empty((len(q), len(rows), len(columns)))
    misfit, last = np.full(len(q), np.inf), np.full(len(q), np.inf)
    for _ in range(most + 1):
        at = _frames(tree, q[active], motions[:, active])
        away = misfits(tree, at).reshape(len(active), -1) * rows
        jacobian[active] = here = _jacobian(tree, at)
        misfit[active] = now = np.abs(away).max(axis=1, initial=0.0)
        # one more step after the closures are met, which squares what is left
        going = np.isfinite(now) & ~((now < met[active]) & (last[active] < met[active] ** 0.5))
        going &= now > np.finfo(float).eps
        last[active] = now
        active, here, away = active[going], here[going], away[going]
        if not len(active) or not len(columns):
            break
        step = -_least_squares(here, away, idle)
        step /= np.maximum(np.abs(step).max(axis=1, keepdims=True) / _LONGEST_STEP, 1.0)
        motions[:, active] = moved_on(tree, motions[:, active], step * columns)
    return motions, jacobian, misfit


def _least_squares(matrix: Floats, right: Floats, idle: int) -> Floats:
    """Return the smallest least-squares solution (pose, column) of matrix @ x = right."""
    found = np.full((len(matrix), matrix.shape[2]), np.inf)
    if not idle:
        # Newton's steps correct what normal equations lose
        square = matrix.shape[1] == matrix.shape[2]
        turned = matrix.transpose(0, 2, 1)
        left, sides = (
            (matrix, right[..., None]) if square else (turned @ matrix, turned @ right[..., None])
        )
        with contextlib.suppress(np.linalg.LinAlgError):
            found = np.linalg.solve(left, sides)[..., 0]
    wild = ~(np.abs(found).max(axis=1, initial=0.0) < 1 / RANK)
    if wild.any():
        found[wild] = (np.linalg.pinv(matrix[wild], rcond=RANK) @ right[wild, :, None])[..., 0]
    return np.asarray(found)


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
    motions, jacobian, _ = _newton(tree, q, start, _MOST_AT_HOME, 1)
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
    home, reach = home_of(tree), _motion_units(tree, tree.moved)
    sides = np.array([[1.0], [-1.0]]) * _BESIDE * np.linspace(1.0, 0.5, len(reach))
    beside, start = np.array(tree.home) + sides * reach, np.repeat(home.motions, 2, axis=1)
    found = _newton(tree, beside, start, _MOST_AT_HOME, 1)[1]
    return max(rank_of(each) for each in found)


def tool_columns(tree: Tree, at: Floats) -> Floats:
    """Return the twist of the tool per motion of the passive joints (pose, 6, freedom), free of
    units.
    """
    _, columns = balance(tree)
    moved = [carry(tree, at, each.place) @ tree.places[each.place].twist for each in tree.passive]
    return np.asarray(np.concatenate(moved, axis=2) * twist_units(tree)[:, None] * columns)


def assemble(tree: Tree, q: Floats) -> Assembly:
    """Return the closed chain at these values of the driven joints (pose, joint), rad or m."""
    home, strides = home_of(tree), _STRIDE * _motion_units(tree, tree.moved)
    count, start = len(q), np.array(tree.home)
    most = np.abs((q - start) / strides).max(axis=1, initial=0.0)
    longest = 1 / np.maximum(np.ceil(most), 1.0)
    step, done = longest.copy(), np.zeros(count)
    motions = np.repeat(home.motions, count, axis=1)
    jacobian = np.repeat(home.jacobian, count, axis=0)
    problem = np.full(count, ASSEMBLED)
    active = np.arange(count)
    while len(active):
        reach = np.minimum(done[active] + step[active], 1.0)
        here = start + reach[:, None] * (q[active] - start)
        close = np.where(reach < 1.0, _NEARLY_MET, MET)
        moved, columns, misfit = _newton(
            tree, here, motions[:, active], _MOST_STEPS, home.idle, close
        )
        met = misfit < close
        good = met & _same_side(jacobian[active], columns, home.idle)
        ahead = active[good]
        motions[:, ahead], jacobian[ahead], done[ahead] = moved[:, good], columns[good], reach[good]
        step[ahead] = np.minimum(2 * step[ahead], longest[ahead])
        step[active[~good]] /= 2
        problem[active] = np.where(good, ASSEMBLED, np.where(met, SINGULAR, NOT_ASSEMBLED))
        active = active[(reach < 1.0) | ~good]
        active = active[step[active] >= _SHORTEST * longest[active]]
    joint = np.full(count, -1)
    for k in reversed(range(len(tree.passive))):
        outside = _outside(tree, k, motions[k])
        joint[outside] = k
    at = _frames(tree, q, motions)
    problem[(problem == ASSEMBLED) & (joint >= 0)] = LIMITED
    near = problem == ASSEMBLED
    near[near] = gain(tree, at[:, near], jacobian[near]) > MOST_GAIN * home_gain(tree)
    problem[near] = NEAR_SINGULAR
    return Assembly(at, problem, joint)


@functools.lru_cache(maxsize=32)
def home_gain(tree: Tree) -> float:
    """Return the gain at home."""
    home, q = home_of(tree), np.array(tree.home)[None]
    return float(gain(tree, _frames(tree, q, home.motions), home.jacobian)[0])


def gain(tree: Tree, at: Floats, jacobian: Floats) -> Floats:
    """Return how far (pose,) the tool moves per unit error of the drives, the largest over all
    combinations; rad, and lengths as shares of the size of the chain.

    jacobian  (pose, equation, freedom) of the closures, balanced
    """
    drives, units = list(tree.moved), _motion_units(tree, tree.moved)
    rows, _ = balance(tree)
    driven = loop_columns(tree, at, drives) * rows[:, None] * units
    tool = np.concatenate([carry(tree, at, k) @ tree.places[k].twist for k in drives], axis=2)
    tool = tool * twist_units(tree)[:, None] * units
    if tree.passive:
        tool = tool - tool_columns(tree, at) @ (np.linalg.pinv(jacobian, rcond=RANK) @ driven)
    return np.asarray(np.linalg.norm(tool, ord=2, axis=(1, 2)))


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
