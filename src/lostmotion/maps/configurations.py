"""Configurations of an arm at given points, by inverse kinematics from sampled poses."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from lostmotion.error_model.poses import REPLICATES, sample_poses
from lostmotion.mechanism.inverse import inverse_kinematics, stepped_towards
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from lostmotion.maps.cells import CellPoses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

T = TypeVar("T")
# Nearest poses from which a point is tried first, and differing ones from which it is tried then
# before it counts as out of reach.
STARTS: Final = 3
_STARTS_SPREAD: Final = 5
# Number of nearest poses from which starts are chosen, and of starts that differ most (other elbow,
# other side of a limit); the rest by distance.
_AMONG: Final = 64
_MOST_SPREAD: Final = 8
# Joint values closer than this (rad; for prismatic joints a share of the cell edge) are one
# configuration.
_SAME: Final = 0.02
_STEPS: Final = 12
_NEXT: Final = 6
TOLERANCE: Final = 1e-3
BATCH: Final = 2048


def configurations_at(
    arm: Arm, wanted: Floats, poses: int, each: int, seed: int, edge: float, threads: int = 1
) -> tuple[Floats, np.ndarray]:
    """Return up to `each` configurations q (pose, joint) at each point of `wanted` (point, 3), from
    a sample, and the point of each (pose,).
    """
    q, _ = interleaved_poses(arm, poses, seed)
    start = spread_starts(arm, q, tool_points(arm, q), wanted, each).ravel()
    goal = np.repeat(np.arange(len(wanted)), each)
    goal, start = goal[start >= 0], start[start >= 0]
    with ThreadPoolExecutor(threads) as pool:
        arrived, done = _damped_newton_to(arm, q[start], wanted[goal], pool)
    found, at = arrived[done], goal[done]
    alone = distinct_configurations(arm, found, at, edge)
    return found[alone], at[alone]


def solve_positions(
    arm: Arm, cells: CellPoses, wanted: Floats, threads: int = 1
) -> tuple[Floats, np.ndarray]:
    """Return poses q (pose, joint) with the tool at these points (point, 3), solved from poses near
    them, and which points were reached.

    An unreached point is not proven to be out of reach.
    """
    if not len(wanted):
        return np.zeros((0, len(arm.driven))), np.zeros(0, bool)
    with ThreadPoolExecutor(threads) as pool:
        q, done, _ = from_nearest_poses(arm, cells, wanted, STARTS, pool, cells.grid.edge)
        left = np.flatnonzero(~done)
        if len(left):
            q[left], done[left], _ = from_nearest_poses(
                arm, cells, wanted[left], _STARTS_SPREAD, pool
            )
    # Near a singularity the steps become ever shorter; the tolerance of cell centres suffices.
    return q, np.asarray(
        done | (np.abs(tool_points(arm, q) - wanted) < TOLERANCE * cells.grid.edge).all(axis=1)
    )


def distinct_configurations(arm: Arm, q: Floats, cell: np.ndarray, edge: float) -> np.ndarray:
    """Return which poses (pose, joint), sorted by cell, differ from all earlier ones of their cell;
    full turns do not count as a difference.
    """
    alone = np.ones(len(q), bool)
    begins = np.flatnonzero(np.r_[True, cell[1:] != cell[:-1]]) if len(q) else np.zeros(0, int)
    rank = np.arange(len(q)) - np.repeat(begins, np.diff(np.r_[begins, len(q)]))
    scale = np.array([1.0 if joint.type == "revolute" else edge for joint in arm.driven])
    for back in range(1, int(rank.max(initial=0)) + 1):
        later = np.flatnonzero(rank >= back)
        alone[
            later[
                (_configuration_distance(arm, q[later], q[later - back]) < _SAME * scale).all(
                    axis=1
                )
            ]
        ] = False
    return alone


def _configuration_distance(arm: Arm, one: Floats, other: Floats) -> Floats:
    """Return the differences of joint values (..., joint), rad or m, modulo full turns."""
    off = np.abs(one - other)
    turning = np.array([joint.type == "revolute" for joint in arm.driven])
    return np.asarray(np.where(turning, np.abs(off - 2 * np.pi * np.round(off / (2 * np.pi))), off))


def spread_starts(arm: Arm, q: Floats, points: Floats, wanted: Floats, count: int) -> np.ndarray:
    """Return starting poses (point, count) for points (point, 3): the nearest one, then near ones
    that differ most from those before; -1: no more.

    The nearest poses alone may all have the same elbow, or lie beyond a joint limit.
    """
    scaled = q / (arm.limits[:, 1] - arm.limits[:, 0])
    out = np.full((len(wanted), count), -1)
    for first in range(0, len(wanted), BATCH):
        near_by = _nearest_poses(points, wanted[first : first + BATCH], max(_AMONG, count))
        there, rows = near_by >= 0, np.arange(len(near_by))
        chosen = np.zeros((len(near_by), min(count, _MOST_SPREAD)), np.int64)
        unlike = np.where(there, np.inf, -np.inf)
        for k in range(1, chosen.shape[1]):
            last = scaled[near_by[rows, chosen[:, k - 1]]]
            unlike = np.minimum(unlike, np.abs(scaled[near_by] - last[:, None, :]).max(axis=2))
            unlike[rows, chosen[:, k - 1]] = -np.inf
            chosen[:, k] = unlike.argmax(axis=1)
        used = np.zeros(near_by.shape, bool)
        used[rows[:, None], chosen] = True
        rest = np.argsort(used, axis=1, kind="stable")[:, : count - chosen.shape[1]]
        which = np.take_along_axis(near_by, np.hstack([chosen, rest]), axis=1)
        out[first : first + BATCH] = np.where(
            np.arange(count) < there.sum(axis=1)[:, None], which, -1
        )
    return out


def interleaved_poses(arm: Arm, poses: int, seed: int) -> tuple[Floats, np.ndarray]:
    """Return sampled poses q (pose, joint) and the set of each, one of each set in turn, so that
    any first few come from all sets.
    """
    chosen = sample_poses(arm, poses, seed=seed).q
    each = len(chosen) // REPLICATES
    q = np.ascontiguousarray(
        chosen.reshape(REPLICATES, each, -1).transpose(1, 0, 2).reshape(len(chosen), -1)
    )
    return q, np.tile(np.arange(REPLICATES), each)


def from_nearest_poses(
    arm: Arm,
    cells: CellPoses,
    wanted: Floats,
    count: int,
    pool: ThreadPoolExecutor,
    edge: float | None = None,
) -> tuple[Floats, np.ndarray, np.ndarray]:
    """Solve for points (point, 3) from the nearest poses, one after another until one succeeds.

    Returns q, which points were reached, and the pose from which each started. Plain Newton steps
    where the cell edge is stated, else damped ones.
    """
    starts = (
        _nearest_poses(cells.points, wanted, count)
        if count <= STARTS
        else spread_starts(arm, cells.q, cells.points, wanted, count)
    )
    out, done, start = cells.q[starts[:, 0]], np.zeros(len(wanted), bool), starts[:, 0].copy()
    for each in starts.T:
        left = np.flatnonzero(~done & (each >= 0))
        if len(left):
            from_there, to = cells.q[each[left]], wanted[left]
            out[left], done[left] = (
                _damped_newton_to(arm, from_there, to, pool)
                if edge is None
                else newton_to(arm, from_there, to, edge, pool)
            )
            start[left] = each[left]
    return out, done, start


def newton_to(
    arm: Arm, start: Floats, wanted: Floats, edge: float, pool: ThreadPoolExecutor
) -> tuple[Floats, np.ndarray]:
    """Return joint values after plain Newton steps to points in neighbouring cells, and which
    arrived: cheap, and enough of many starts succeed.
    """
    q = np.empty_like(start)
    for here, moved in batches(
        pool, len(start), lambda here: stepped_towards(arm, start[here], wanted[here], _NEXT)
    ):
        q[here] = moved
    return q, np.asarray((np.abs(tool_points(arm, q) - wanted) < TOLERANCE * edge).all(axis=1))


def _damped_newton_to(
    arm: Arm, start: Floats, wanted: Floats, pool: ThreadPoolExecutor
) -> tuple[Floats, np.ndarray]:
    """Return joint values after damped Newton steps to points, and which arrived."""
    q, done = np.empty_like(start), np.zeros(len(start), bool)
    goal = np.tile(np.eye(4), (len(start), 1, 1))
    goal[:, :3, 3] = wanted
    for here, (moved, arrived) in batches(
        pool,
        len(start),
        lambda here: inverse_kinematics(
            arm, goal[here], start[here], with_orientation=False, steps=_STEPS
        ),
    ):
        q[here], done[here] = moved, arrived
    return q, done


def batches(
    pool: ThreadPoolExecutor, count: int, work: Callable[[slice], T]
) -> Iterator[tuple[slice, T]]:
    """Yield slices and the results of `work` on them, computed in parallel; the slices do not
    depend on the number of threads.
    """
    slices = [slice(first, first + BATCH) for first in range(0, count, BATCH)]
    return zip(slices, pool.map(work, slices), strict=True)


def _nearest_poses(points: Floats, wanted: Floats, count: int) -> np.ndarray:
    """Return the numbers (point, count) of the poses nearest to each point, nearest first; -1 where
    there are fewer.
    """
    from scipy.spatial import KDTree

    at = KDTree(points).query(wanted, k=np.arange(1, count + 1))[1]
    return np.where(at < len(points), at, -1)
