"""A closed chain at home, from where its file states that the passive joints start: any rank."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.closed_arrays import LONGEST_STEP, MET
from lostmotion.mechanism.closed_jacobian import (
    balance,
    balanced_jacobian,
    frames_at,
    loop_columns,
    misfits,
    motion_units,
    moved_on,
    size,
    twist_units,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# Singular values below this share of the largest one count as zero.
RANK: Final = 1e-7
# The same at home, near which a double root of Newton's method leaves the square root of `MET`.
_RANK_AT_HOME: Final = 2e-4
# Drives are moved by this, rad or as a share of the size, to look at a chain beside its home.
_BESIDE: Final = 0.02
# Closures beside home count as met below this misfit, rad and m: far below the way to them.
_NEARLY_MET: Final = 1e-5
# Passive joints are moved by this, rad or as a share of the size, away from a singularity.
_AWAY: Final = 0.3
_MOST_AT_HOME, _MOST_AIMING = 200, 30


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
        at = frames_at(tree, q[active], motions[:, active])
        away = misfits(tree, at).reshape(len(active), -1) * rows
        jacobian[active] = here = balanced_jacobian(tree, at)
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


@dataclass(frozen=True)
class _HomeShape:
    """What decides how a chain is assembled at home, compared by its numbers: arms that differ in
    their errors alone share it.
    """

    numbers: bytes
    tree: Tree = field(compare=False)


@functools.lru_cache(maxsize=32)
def home_of(tree: Tree) -> Home:
    """Return the chain at home: from where its file states that the passive joints start."""
    counted: list[int] = [len(tree.places), len(tree.passive), len(tree.welds)]
    arrays: list[ArrayLike] = [tree.home]
    for place in tree.places:
        counted += [place.parent, -1 if place.joint is None else place.joint, place.twist.shape[1]]
        arrays += [place.pose, place.twist]
    for each in tree.passive:
        counted.append(each.place)
        arrays.append(each.start)
    for weld in tree.welds:
        counted += weld.places
        arrays += weld.frames
    numbers = [np.array(counted), *(np.asarray(each, dtype=float) for each in arrays)]
    return _home(_HomeShape(b"".join(each.tobytes() for each in numbers), tree))


@functools.lru_cache(maxsize=32)
def _home(shape: _HomeShape) -> Home:
    tree = shape.tree
    q = np.array(tree.home)[None]
    start = _aimed(tree, q, np.array([each.start for each in tree.passive]).reshape(-1, 1, 4, 4))
    before = balanced_jacobian(tree, frames_at(tree, q, start))
    motions, jacobian = _newton(tree, q, start)
    at = frames_at(tree, q, motions)
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
        at = frames_at(tree, q, motions)
        away = (misfits(tree, at).reshape(1, -1) * rows)[..., None]
        step = -(np.linalg.pinv(balanced_jacobian(tree, at) * ~held, rcond=RANK) @ away)[..., 0]
        motions = moved_on(tree, motions, np.clip(step, -LONGEST_STEP, LONGEST_STEP) * columns)
    return motions


def rank_of(matrix: Floats) -> int:
    """Return the rank of a balanced Jacobian (equation, freedom)."""
    values = np.linalg.svd(matrix, compute_uv=False)
    return int((values > _RANK_AT_HOME * values.max(initial=0.0)).sum())


def nearby_rank(tree: Tree) -> int:
    """Return the largest rank of the closures' Jacobian beside home, where they are met there."""
    home, reach = home_of(tree), motion_units(tree, tree.moved)
    sides = np.array([[1.0], [-1.0]]) * _BESIDE * np.linspace(1.0, 0.5, len(reach))
    beside, start = np.array(tree.home) + sides * reach, np.repeat(home.motions, 2, axis=1)
    motions, found = _newton(tree, beside, start)
    away = np.abs(misfits(tree, frames_at(tree, beside, motions))).max(axis=(1, 2))
    return max((rank_of(each) for each in found[away < _NEARLY_MET]), default=home.rank)


def holds_drives(tree: Tree) -> bool:
    """Return whether closures hold drives also with the passive joints away from where Newton's
    method ended: where it did not close the chain, that is often a singularity, such as legs
    stretched towards each other.
    """
    rows, columns = balance(tree)
    step = _AWAY * np.sin(np.arange(1.0, len(columns) + 1)) * columns
    motions = moved_on(tree, home_of(tree).motions, step[None])
    at = frames_at(tree, np.array(tree.home)[None], motions)
    passive = balanced_jacobian(tree, at)[0]
    driven = loop_columns(tree, at, list(tree.moved))[0] * rows[:, None]
    return rank_of(np.concatenate([driven, passive], axis=1)) > rank_of(passive)
