"""Which cells of space can the tool reach, and by which poses? Many sampled poses, brought to the middles of cells by inverse kinematics.

The tool may stand in any direction: a point is reached when the tool point is there.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from lostmotion.analyses.workspace_map.cells import Grid, amid, grid_over, near
from lostmotion.error_model.poses import REPLICATES, sample_poses
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.inverse import inverse_kinematics, tool_and_jacobian
from lostmotion.mechanism.serial import tool_points

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

    Progress = Callable[[str, int, int], None]

T = TypeVar("T")

MOST_POSES: Final = 4_000_000
# Starts from which a point is tried before it counts as out of reach, the nearest poses first, and steps from each.
_STARTS: Final = 3
# And of points amid others that are in reach: the nearest poses may all stand beyond a joint's limit from there.
_STARTS_AMID: Final = 16
# And of points that plain steps from the nearest did not reach, most of them out of reach.
_STARTS_UNLIKE: Final = 5
# Of so many nearest poses the starts are chosen that differ most from each other: other elbows, other sides of a limit; further ones by nearness.
_AMONG: Final = 64
_UNLIKE: Final = 8
# Joint values nearer than this, rad, are one configuration; of sliding joints this share of the cells' edge.
_SAME: Final = 0.02
_STEPS: Final = 12
# Rounds in which poses are sought for cells that have too few.
_ROUNDS: Final = 3
_HARDER: Final = 3
# Plain Newton steps within a cell and from one to the next, and how near they must come, as a share of the edge.
_WITHIN: Final = 4
_NEXT: Final = 6
_NEAR: Final = 1e-3
_DAMPING: Final = 1e-9
_BATCH: Final = 2048


@dataclass(frozen=True)
class Reached:
    """Poses by the cells of a grid that they reach; poses lie by cell, in the order in which they were found.

    q         (pose, joint) rad or m; points (pose, 3) m where they put the tool: in the middle of their cell, but for cells of which only the rim is
              in reach
    cell      (pose,) number of the cell; members (pose,) which of the independent sets of poses it comes from
    brought   (pose,) whether it came from another cell, by inverse kinematics
    sampled   how many poses were sampled
    centre    (x, y, z) whether the middle of the cell was reached
    """

    grid: Grid
    q: Floats
    points: Floats
    cell: np.ndarray
    members: np.ndarray
    brought: np.ndarray
    sampled: int
    centre: np.ndarray

    @property
    def counts(self) -> np.ndarray:
        """Give how many poses each cell has (x, y, z)."""
        return np.bincount(self.cell, minlength=int(np.prod(self.grid.shape))).reshape(self.grid.shape)


def reach(arm: Arm, poses: int, edge: float | None, per_cell: int, seed: int, *, threads: int = 1, progress: Progress | None = None) -> Reached:
    """Which cells does the tool reach, by up to `per_cell` poses each?

    Sampled poses come first, in the order of their Sobol sequences. Inverse kinematics goes for the middle of every cell that touches a reached one,
    until no further cell is reached; sampled poses move on to the middle of their cell; and cells with fewer poses than asked get some from around.
    Threads change no bit. Raises InputError for cells too small.
    """
    tell = progress or (lambda *_: None)
    tell("sampling poses", 0, 1)
    q, members = _interleaved(arm, poses, seed)
    points = tool_points(arm, q)
    grid = grid_over(points, edge)
    every = Reached(grid, q, points, grid.number(points), members, np.zeros(len(q), bool), len(q), np.zeros(grid.shape, bool))
    found = _first(every, per_cell)
    _refuse_too_many(len(np.unique(found.cell)), per_cell)
    with ThreadPoolExecutor(threads) as pool:
        tell("bringing poses to the middles of cells", 0, 1)
        centred = _centred(arm, found, pool)
        centred, found = _spread(arm, centred, found, pool, tell)
        # Many more cells may be reached than were sampled.
        _refuse_too_many(int(np.count_nonzero((centred.counts > 0) | centred.centre)), per_cell)
        there = _at_middle(centred) | ~centred.centre.ravel()[centred.cell]
        centred = _taken(centred, np.flatnonzero(there))
        centred = _taken(centred, np.flatnonzero(distinct(arm, centred.q, centred.cell, grid.edge)))
        found = _filled(arm, centred, found, per_cell, pool, tell)
    return _cropped(found)


def _refuse_too_many(cells: int, per_cell: int) -> None:
    """Refuse more poses than memory holds."""
    if cells * per_cell > MOST_POSES:
        raise refuse_argument(
            "cell, per_cell",
            f"{cells} cells reached with {per_cell} poses each",
            f"at most {MOST_POSES} poses in all: a larger cell, or fewer poses per cell",
        )


def reach_points(arm: Arm, wanted: Floats, poses: int, each: int, seed: int, edge: float, threads: int = 1) -> tuple[Floats, np.ndarray]:
    """Which configurations, up to `each`, bring the tool to these points (point, 3), from a sample? q (pose, joint), whose (pose,), by point."""
    q, _ = _interleaved(arm, poses, seed)
    start = _unlike(arm, q, tool_points(arm, q), wanted, each).ravel()
    goal = np.repeat(np.arange(len(wanted)), each)
    goal, start = goal[start >= 0], start[start >= 0]
    with ThreadPoolExecutor(threads) as pool:
        arrived, done = _bring(arm, q[start], wanted[goal], pool)
    found, at = arrived[done], goal[done]
    alone = distinct(arm, found, at, edge)
    return found[alone], at[alone]


def in_reach(arm: Arm, found: Reached, wanted: Floats) -> np.ndarray:
    """Which of these points (point, 3) can the tool be brought to from poses near them? No proof for those where it could not."""
    return brought_to(arm, found, wanted)[1]


def brought_to(arm: Arm, found: Reached, wanted: Floats, threads: int = 1) -> tuple[Floats, np.ndarray]:
    """Which poses q (pose, joint) bring the tool to these points (point, 3), from poses near them, and which were reached?"""
    if not len(wanted):
        return np.zeros((0, len(arm.moving))), np.zeros(0, bool)
    with ThreadPoolExecutor(threads) as pool:
        q, done, _ = _arrived(arm, found, wanted, _STARTS, pool, found.grid.edge)
        left = np.flatnonzero(~done)
        if len(left):
            q[left], done[left], _ = _arrived(arm, found, wanted[left], _STARTS_UNLIKE, pool)
    # A stretched-out arm comes near its goal by ever shorter steps: as near as the middle of a cell has to be is near enough.
    return q, np.asarray(done | (np.abs(tool_points(arm, q) - wanted) < _NEAR * found.grid.edge).all(axis=1))


def distinct(arm: Arm, q: Floats, cell: np.ndarray, edge: float) -> np.ndarray:
    """Which of these poses (pose, joint) differ from all earlier ones of their cell? Poses lie by cell; whole turns are no difference."""
    alone = np.ones(len(q), bool)
    begins = np.flatnonzero(np.r_[True, cell[1:] != cell[:-1]]) if len(q) else np.zeros(0, int)
    rank = np.arange(len(q)) - np.repeat(begins, np.diff(np.r_[begins, len(q)]))
    scale = np.array([1.0 if joint.type == "revolute" else edge for joint in arm.moving])
    for back in range(1, int(rank.max(initial=0)) + 1):
        later = np.flatnonzero(rank >= back)
        alone[later[(_between(arm, q[later], q[later - back]) < _SAME * scale).all(axis=1)]] = False
    return alone


def _between(arm: Arm, one: Floats, other: Floats) -> Floats:
    """How far do joint values (..., joint) differ, rad or m, whole turns left out?"""
    off = np.abs(one - other)
    turning = np.array([joint.type == "revolute" for joint in arm.moving])
    return np.asarray(np.where(turning, np.abs(off - 2 * np.pi * np.round(off / (2 * np.pi))), off))


def _unlike(arm: Arm, q: Floats, points: Floats, wanted: Floats, count: int) -> np.ndarray:
    """Which poses (point, count) to start from to points (point, 3)? The nearest, then those near that are least like the ones before; -1: no more.

    Nearest poses alone may all be of one elbow, or beyond a joint's limit.
    """
    scaled = q / (arm.limits[:, 1] - arm.limits[:, 0])
    out = np.full((len(wanted), count), -1)
    for first in range(0, len(wanted), _BATCH):
        near_by = _nearest(points, wanted[first : first + _BATCH], max(_AMONG, count))
        there, rows = near_by >= 0, np.arange(len(near_by))
        chosen = np.zeros((len(near_by), min(count, _UNLIKE)), np.int64)
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
        out[first : first + _BATCH] = np.where(np.arange(count) < there.sum(axis=1)[:, None], which, -1)
    return out


def _interleaved(arm: Arm, poses: int, seed: int) -> tuple[Floats, np.ndarray]:
    """Which poses are sampled, q (pose, joint), and which set does each belong to? One of each set in turn, so that any first few come from all."""
    chosen = sample_poses(arm, poses, seed=seed).q
    each = len(chosen) // REPLICATES
    q = np.ascontiguousarray(chosen.reshape(REPLICATES, each, -1).transpose(1, 0, 2).reshape(len(chosen), -1))
    return q, np.tile(np.arange(REPLICATES), each)


def _first(found: Reached, per_cell: int) -> Reached:
    """Keep the first few poses of each cell, and none outside the grid."""
    order = np.argsort(found.cell, kind="stable")
    order = order[found.cell[order] >= 0]
    cell = found.cell[order]
    begins = np.flatnonzero(np.r_[True, cell[1:] != cell[:-1]])
    rank = np.arange(len(cell)) - np.repeat(begins, np.diff(np.r_[begins, len(cell)]))
    return _taken(found, order[rank < per_cell])


def _taken(found: Reached, which: np.ndarray) -> Reached:
    arrays = (found.q[which], found.points[which], found.cell[which], found.members[which], found.brought[which])
    return Reached(found.grid, *arrays, found.sampled, found.centre)


def _joined(arm: Arm, found: Reached, q: Floats, goal: np.ndarray, members: np.ndarray) -> Reached:
    """Add poses that were brought, where they lie in the cell that they were meant for."""
    if not len(q):
        return found
    points = tool_points(arm, q)
    right = found.grid.number(points) == goal
    whole = Reached(
        found.grid,
        np.vstack([found.q, q[right]]),
        np.vstack([found.points, points[right]]),
        np.r_[found.cell, goal[right]],
        np.r_[found.members, members[right]],
        np.r_[found.brought, np.ones(int(right.sum()), bool)],
        found.sampled,
        found.centre,
    )
    return _taken(whole, np.argsort(whole.cell, kind="stable"))


def _centred(arm: Arm, found: Reached, pool: ThreadPoolExecutor) -> Reached:
    """Move poses on to the middle of their cell. Those that do not get there stay where they are, in cells where none does."""
    goal = found.grid.centres(found.cell)
    q = np.empty_like(found.q)
    for here, moved in _in_batches(pool, len(q), lambda here: _short_way(arm, found.q[here], goal[here], _WITHIN)):
        q[here] = moved
    on = Reached(found.grid, q, tool_points(arm, q), found.cell, found.members, found.brought, found.sampled, found.centre)
    there = _at_middle(on)
    found.centre.ravel()[found.cell[there]] = True
    left = np.flatnonzero(~found.centre.ravel()[found.cell])
    on.q[left], on.points[left] = found.q[left], found.points[left]
    there[left] = True
    return _taken(on, np.flatnonzero(there))


def _at_middle(found: Reached) -> np.ndarray:
    """Tell which poses put the tool in the middle of their cell."""
    return np.asarray((np.abs(found.points - found.grid.centres(found.cell)) < _NEAR * found.grid.edge).all(axis=1))


def _spread(arm: Arm, centred: Reached, starts: Reached, pool: ThreadPoolExecutor, tell: Progress) -> tuple[Reached, Reached]:
    """Go for the middles of all other cells that touch reached ones, until no more are found; harder for those that lie amid reached ones.

    From the poses of `starts`, as they were sampled. Gives both sets of poses with those that were brought.
    """
    centre, edge, dimensions = centred.centre, centred.grid.edge, centred.grid.dimensions
    # By plain steps first; where those fail by damped ones, and by more of them amid cells that are reached.
    tried = [centre.copy() for _ in range(3)]
    while True:
        reached = centred.counts > 0
        ways = (near(reached), _STARTS, edge), (near(reached), _STARTS, None), (amid(reached, dimensions), _STARTS_AMID, None)
        fronts = [(cells & ~centre & ~done_with, *how, done_with) for (cells, *how), done_with in zip(ways, tried, strict=True)]
        front, count, plain, done_with = next((each for each in fronts if each[0].any()), fronts[0])
        goal = np.flatnonzero(front)
        if not len(goal):
            return centred, starts
        done_with |= front
        tell("looking for the end of the reach", int(tried[0].sum()) - len(goal), int(tried[0].sum()))
        q, done, start = _arrived(arm, starts, centred.grid.centres(goal), count, pool, plain)
        centre.ravel()[goal[done]] = True
        brought = q[done], goal[done], starts.members[start[done]]
        centred, starts = _joined(arm, centred, *brought), _joined(arm, starts, *brought)


def _short_way(arm: Arm, q: Floats, goal: Floats, steps: int) -> Floats:
    """Go a short way to points (pose, 3) by plain Newton steps, least motion as a share of the joints' ranges, within their limits."""
    low, high = arm.limits.T
    for _ in range(steps):
        at, levers = tool_and_jacobian(arm, q)
        push = levers[:, 3:] * (high - low)
        square = push @ np.swapaxes(push, 1, 2)
        square += (_DAMPING * np.einsum("pii->p", square) + np.finfo(float).tiny)[:, None, None] * np.eye(3)
        move = np.linalg.solve(square, (goal - at[:, :3, 3])[..., None])
        q = np.clip(q + (np.swapaxes(push, 1, 2) @ move)[..., 0] * (high - low), low, high)
    return q


def _filled(arm: Arm, found: Reached, starts: Reached, per_cell: int, pool: ThreadPoolExecutor, tell: Progress) -> Reached:
    """Bring poses from other cells (of `starts`) to those that have fewer than `per_cell`. Cells that stay short are mostly at the end of the reach.

    To the middle, where that is in reach; else to where the pose that it starts from lies within its own cell.
    """
    cells = np.flatnonzero((found.counts.ravel() > 0) | found.centre.ravel())
    cells = cells[found.counts.ravel()[cells] < per_cell]
    around = _unlike(arm, starts.q, starts.points, found.grid.centres(cells), _ROUNDS * per_cell)
    for turn in range(_ROUNDS):
        tell("bringing poses to cells", turn, _ROUNDS)
        lacking = np.maximum(per_cell - found.counts.ravel()[cells], 0)
        # Later rounds try more starts than lack: those that are left are the hard ones. Another rank in each, so that none comes twice.
        tries = lacking if turn == 0 else np.minimum(_HARDER * lacking, per_cell)
        row = np.repeat(np.arange(len(cells)), tries)
        if not len(row):
            break
        start = around[row, np.concatenate([np.arange(n) for n in tries]) + turn * per_cell]
        goal, start = cells[row][start >= 0], start[start >= 0]
        there = found.grid.centres(goal)
        there += np.where(found.centre.ravel()[goal][:, None], 0.0, starts.points[start] - found.grid.centres(starts.cell[start]))
        arrived, done = _stepped(arm, starts.q[start], there, found.grid.edge, pool)
        found = _joined(arm, found, arrived[done], goal[done], starts.members[start[done]])
        found = _first(_taken(found, np.flatnonzero(distinct(arm, found.q, found.cell, found.grid.edge))), per_cell)
    return found


def _arrived(
    arm: Arm, found: Reached, wanted: Floats, count: int, pool: ThreadPoolExecutor, edge: float | None = None
) -> tuple[Floats, np.ndarray, np.ndarray]:
    """Bring the tool to points (point, 3) from the nearest poses, one after the other until one succeeds: q, which were reached, from which pose.

    By plain steps where the `edge` of the cells is told, else by damped ones.
    """
    starts = _nearest(found.points, wanted, count) if count <= _STARTS else _unlike(arm, found.q, found.points, wanted, count)
    out, done, start = found.q[starts[:, 0]], np.zeros(len(wanted), bool), starts[:, 0].copy()
    for each in starts.T:
        left = np.flatnonzero(~done & (each >= 0))
        if len(left):
            from_there, to = found.q[each[left]], wanted[left]
            out[left], done[left] = _bring(arm, from_there, to, pool) if edge is None else _stepped(arm, from_there, to, edge, pool)
            start[left] = each[left]
    return out, done, start


def _stepped(arm: Arm, start: Floats, wanted: Floats, edge: float, pool: ThreadPoolExecutor) -> tuple[Floats, np.ndarray]:
    """Go from cell to cell by plain Newton steps: cheap, and of many starts enough arrive."""
    q = np.empty_like(start)
    for here, moved in _in_batches(pool, len(start), lambda here: _short_way(arm, start[here], wanted[here], _NEXT)):
        q[here] = moved
    return q, np.asarray((np.abs(tool_points(arm, q) - wanted) < _NEAR * edge).all(axis=1))


def _bring(arm: Arm, start: Floats, wanted: Floats, pool: ThreadPoolExecutor) -> tuple[Floats, np.ndarray]:
    q, done = np.empty_like(start), np.zeros(len(start), bool)
    goal = np.tile(np.eye(4), (len(start), 1, 1))
    goal[:, :3, 3] = wanted
    for here, (moved, arrived) in _in_batches(
        pool, len(start), lambda here: inverse_kinematics(arm, goal[here], start[here], turned=False, steps=_STEPS)
    ):
        q[here], done[here] = moved, arrived
    return q, done


def _in_batches(pool: ThreadPoolExecutor, count: int, work: Callable[[slice], T]) -> Iterator[tuple[slice, T]]:
    """Do work on slices of so many things, side by side: the slices are the same whatever the threads."""
    slices = [slice(first, first + _BATCH) for first in range(0, count, _BATCH)]
    return zip(slices, pool.map(work, slices), strict=True)


def _nearest(points: Floats, wanted: Floats, count: int) -> np.ndarray:
    """Which poses lie nearest to each of these points? Their numbers (point, count), nearest first; -1 where there are not so many."""
    from scipy.spatial import KDTree

    at = KDTree(points).query(wanted, k=np.arange(1, count + 1))[1]
    return np.where(at < len(points), at, -1)


def _cropped(found: Reached) -> Reached:
    """Leave out the grid's empty margin."""
    old = found.grid
    grid = old.around(np.unique(found.cell))
    shift = np.array(grid.first) - np.array(old.first)
    at = np.column_stack(np.unravel_index(found.cell, old.shape)) - shift
    cell = np.ravel_multi_index(tuple(at.T), grid.shape)
    centre = found.centre[tuple(slice(int(a), int(a) + n) for a, n in zip(shift, grid.shape, strict=True))]
    return Reached(grid, found.q, found.points, cell, found.members, found.brought, found.sampled, np.ascontiguousarray(centre))
