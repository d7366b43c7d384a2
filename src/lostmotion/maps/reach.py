"""Reachable cells of the workspace and arm configurations in each, from sampled poses and inverse
kinematics.

Any orientation of the tool counts: a cell is reached when the tool point is there.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.trust import trusted
from lostmotion.errors import refuse_argument
from lostmotion.maps.cells import CellPoses, dilated, grid_around, mostly_enclosed
from lostmotion.maps.configurations import (
    STARTS,
    TOLERANCE,
    batches,
    distinct_configurations,
    from_nearest_poses,
    interleaved_poses,
    newton_to,
    spread_starts,
)
from lostmotion.mechanism.inverse import stepped_towards
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

    Progress = Callable[[str, int, int], None]


MOST_POSES: Final = 4_000_000
# Starts for a cell enclosed by reachable ones: the nearest poses may all be separated from it by a
# joint limit.
_STARTS_ENCLOSED: Final = 16
# Rounds of adding poses to cells that have too few, and the number of starts per missing pose from
# the second round on.
_ROUNDS: Final = 3
_HARDER: Final = 3
# Newton steps from a sampled pose to the centre of its cell.
_WITHIN: Final = 4


def reachable_cells(
    arm: Arm,
    poses: int,
    edge: float | None,
    per_cell: int,
    seed: int,
    *,
    threads: int = 1,
    progress: Progress | None = None,
) -> CellPoses:
    """Return the cells that the tool reaches, with up to `per_cell` poses each.

    Sampled poses come first, in the order of their Sobol sequences, moved to the centre of their
    cell. Inverse kinematics then tries the centre of every cell that touches a reached one, until
    no more are reached, and adds poses from neighbouring cells where a cell has too few. Results do
    not depend on `threads`. Raises InputError for cells too small.
    """
    report = progress or (lambda *_: None)
    report("sampling poses", 0, 1)
    q, members = interleaved_poses(arm, poses, seed)
    points = tool_points(arm, q)
    grid = grid_around(points, edge)
    every = CellPoses(
        grid,
        q,
        points,
        grid.cell_numbers(points),
        members,
        np.zeros(len(q), bool),
        len(q),
        np.zeros(grid.shape, bool),
    )
    found = _first_per_cell(every, per_cell)
    _refuse_too_many(len(np.unique(found.cell)), per_cell)
    with ThreadPoolExecutor(threads) as pool:
        report("moving poses to the centres of cells", 0, 1)
        centred = _move_to_centres(arm, found, pool)
        centred, found = _expand(arm, centred, found, pool, report)
        # Many more cells may be reached than sampled poses hit.
        _refuse_too_many(int(np.count_nonzero((centred.counts > 0) | centred.centre)), per_cell)
        there = _at_centre(centred) | ~centred.centre.ravel()[centred.cell]
        centred = _selected(centred, np.flatnonzero(there))
        centred = _selected(
            centred,
            np.flatnonzero(distinct_configurations(arm, centred.q, centred.cell, grid.edge)),
        )
        found = _fill_up(arm, centred, found, per_cell, pool, report)
    return _without_margin(_where_first_order_holds(arm, found))


def _where_first_order_holds(arm: Arm, cells: CellPoses) -> CellPoses:
    """Return the poses without those of a closed chain at which first order is not valid, and
    without the cells that have no others.
    """
    valid = trusted(arm, cells.q)
    if valid.all():
        return cells
    kept = _selected(cells, np.flatnonzero(valid))
    return replace(kept, centre=kept.centre & (kept.counts > 0))


def _refuse_too_many(cells: int, per_cell: int) -> None:
    """Refuse more poses than fit into memory."""
    if cells * per_cell > MOST_POSES:
        raise refuse_argument(
            "cell, per_cell",
            f"{cells} cells reached with {per_cell} poses each",
            f"at most {MOST_POSES} poses in all: a larger cell, or fewer poses per cell",
        )


def _first_per_cell(cells: CellPoses, per_cell: int) -> CellPoses:
    """Return the first few poses of each cell, without those outside the grid."""
    order = np.argsort(cells.cell, kind="stable")
    order = order[cells.cell[order] >= 0]
    cell = cells.cell[order]
    begins = np.flatnonzero(np.r_[True, cell[1:] != cell[:-1]])
    rank = np.arange(len(cell)) - np.repeat(begins, np.diff(np.r_[begins, len(cell)]))
    return _selected(cells, order[rank < per_cell])


def _selected(cells: CellPoses, which: np.ndarray) -> CellPoses:
    arrays = (
        cells.q[which],
        cells.points[which],
        cells.cell[which],
        cells.members[which],
        cells.brought[which],
    )
    return CellPoses(cells.grid, *arrays, cells.sampled, cells.centre)


def _joined(
    arm: Arm, cells: CellPoses, q: Floats, goal: np.ndarray, members: np.ndarray
) -> CellPoses:
    """Return the poses with those solved for other cells added, where they lie in their target
    cell.
    """
    if not len(q):
        return cells
    points = tool_points(arm, q)
    right = cells.grid.cell_numbers(points) == goal
    whole = CellPoses(
        cells.grid,
        np.vstack([cells.q, q[right]]),
        np.vstack([cells.points, points[right]]),
        np.r_[cells.cell, goal[right]],
        np.r_[cells.members, members[right]],
        np.r_[cells.brought, np.ones(int(right.sum()), bool)],
        cells.sampled,
        cells.centre,
    )
    return _selected(whole, np.argsort(whole.cell, kind="stable"))


def _move_to_centres(arm: Arm, cells: CellPoses, pool: ThreadPoolExecutor) -> CellPoses:
    """Return the poses moved to the centre of their cell; poses that do not arrive stay, in cells
    where none arrives.
    """
    goal = cells.grid.centres(cells.cell)
    q = np.empty_like(cells.q)
    for here, moved in batches(
        pool, len(q), lambda here: stepped_towards(arm, cells.q[here], goal[here], _WITHIN)
    ):
        q[here] = moved
    on = CellPoses(
        cells.grid,
        q,
        tool_points(arm, q),
        cells.cell,
        cells.members,
        cells.brought,
        cells.sampled,
        cells.centre,
    )
    there = _at_centre(on)
    cells.centre.ravel()[cells.cell[there]] = True
    left = np.flatnonzero(~cells.centre.ravel()[cells.cell])
    on.q[left], on.points[left] = cells.q[left], cells.points[left]
    there[left] = True
    return _selected(on, np.flatnonzero(there))


def _at_centre(cells: CellPoses) -> np.ndarray:
    """Return which poses put the tool at the centre of their cell."""
    return np.asarray(
        (np.abs(cells.points - cells.grid.centres(cells.cell)) < TOLERANCE * cells.grid.edge).all(
            axis=1
        )
    )


def _expand(
    arm: Arm, centred: CellPoses, starts: CellPoses, pool: ThreadPoolExecutor, report: Progress
) -> tuple[CellPoses, CellPoses]:
    """Reach for the centres of all cells that touch reached ones, until no more are found; with
    more starts for enclosed cells.

    Starts from the poses of `starts` as sampled. Returns both sets of poses with the new ones
    added.
    """
    centre, edge, dimensions = centred.centre, centred.grid.edge, centred.grid.dimensions
    # Plain Newton steps first, then damped ones, then damped ones from more starts for enclosed
    # cells.
    tried = [centre.copy() for _ in range(3)]
    while True:
        reached = centred.counts > 0
        ways = (
            (dilated(reached), STARTS, edge),
            (dilated(reached), STARTS, None),
            (mostly_enclosed(reached, dimensions), _STARTS_ENCLOSED, None),
        )
        fronts = [
            (cells & ~centre & ~done_with, *how, done_with)
            for (cells, *how), done_with in zip(ways, tried, strict=True)
        ]
        front, count, plain, done_with = next((each for each in fronts if each[0].any()), fronts[0])
        goal = np.flatnonzero(front)
        if not len(goal):
            return centred, starts
        done_with |= front
        report(
            "searching for the boundary of the workspace",
            int(tried[0].sum()) - len(goal),
            int(tried[0].sum()),
        )
        q, done, start = from_nearest_poses(
            arm, starts, centred.grid.centres(goal), count, pool, plain
        )
        centre.ravel()[goal[done]] = True
        brought = q[done], goal[done], starts.members[start[done]]
        centred, starts = _joined(arm, centred, *brought), _joined(arm, starts, *brought)


def _fill_up(
    arm: Arm,
    cell_poses: CellPoses,
    starts: CellPoses,
    per_cell: int,
    pool: ThreadPoolExecutor,
    report: Progress,
) -> CellPoses:
    """Return the poses with others, from the poses of `starts`, added to cells with fewer than
    `per_cell`; cells at the end of reach stay short.

    The target is the centre of the cell where it is in reach, else the same place within the cell
    as that of the starting pose.
    """
    cells = np.flatnonzero((cell_poses.counts.ravel() > 0) | cell_poses.centre.ravel())
    cells = cells[cell_poses.counts.ravel()[cells] < per_cell]
    around = spread_starts(
        arm, starts.q, starts.points, cell_poses.grid.centres(cells), _ROUNDS * per_cell
    )
    for turn in range(_ROUNDS):
        report("adding poses to cells", turn, _ROUNDS)
        lacking = np.maximum(per_cell - cell_poses.counts.ravel()[cells], 0)
        # Later rounds try more starts than are missing, since the remaining cells are harder; each
        # round uses other starts.
        tries = lacking if turn == 0 else np.minimum(_HARDER * lacking, per_cell)
        row = np.repeat(np.arange(len(cells)), tries)
        if not len(row):
            break
        start = around[row, np.concatenate([np.arange(n) for n in tries]) + turn * per_cell]
        goal, start = cells[row][start >= 0], start[start >= 0]
        there = cell_poses.grid.centres(goal)
        there += np.where(
            cell_poses.centre.ravel()[goal][:, None],
            0.0,
            starts.points[start] - cell_poses.grid.centres(starts.cell[start]),
        )
        arrived, done = newton_to(arm, starts.q[start], there, cell_poses.grid.edge, pool)
        cell_poses = _joined(
            arm, cell_poses, arrived[done], goal[done], starts.members[start[done]]
        )
        cell_poses = _first_per_cell(
            _selected(
                cell_poses,
                np.flatnonzero(
                    distinct_configurations(
                        arm, cell_poses.q, cell_poses.cell, cell_poses.grid.edge
                    )
                ),
            ),
            per_cell,
        )
    return cell_poses


def _without_margin(cells: CellPoses) -> CellPoses:
    """Return the poses on a grid without its empty margin."""
    old = cells.grid
    grid = old.cropped_to(np.unique(cells.cell))
    shift = np.array(grid.first) - np.array(old.first)
    at = np.column_stack(np.unravel_index(cells.cell, old.shape)) - shift
    cell = np.ravel_multi_index(tuple(at.T), grid.shape)
    centre = cells.centre[
        tuple(slice(int(a), int(a) + n) for a, n in zip(shift, grid.shape, strict=True))
    ]
    return CellPoses(
        grid,
        cells.q,
        cells.points,
        cell,
        cells.members,
        cells.brought,
        cells.sampled,
        np.ascontiguousarray(centre),
    )
