"""Closures of a chain in given frames: how far they are from being met, and their Jacobian.

Twists are about the tool point, in the base's axes. Lengths are divided by the size of the chain
where a quantity is free of units.
"""

from __future__ import annotations

import functools
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

# Trace of a rotation matrix just above that of half a turn.
_HALF_A_TURN: Final = -1.0 + 1e-6


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


def balanced_jacobian(tree: Tree, at: Floats) -> Floats:
    """Return the Jacobian of the closures (pose, equation, freedom), free of units."""
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


def frames_at(tree: Tree, q: Floats, motions: Floats) -> Floats:
    """Return the frames (place, pose, 4, 4) of all places, m, at values of the drives (pose, drive)
    and motions of the passive joints (passive, pose, 4, 4).
    """
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


def tool_columns(tree: Tree, at: Floats) -> Floats:
    """Return the twist of the tool per motion of the passive joints (pose, 6, freedom), free of
    units.
    """
    _, columns = balance(tree)
    moved = [carry(tree, at, each.place) @ tree.places[each.place].twist for each in tree.passive]
    return np.asarray(np.concatenate(moved, axis=2) * twist_units(tree)[:, None] * columns)
