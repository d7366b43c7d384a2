"""Largest test cube in an arm's workspace, by flood fill of a grid with inverse kinematics and a
compass search.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.iso9283.cube import (
    SAME_CONFIGURATION,
    SAMPLES,
    SPACE,
    STARTS,
    STEPS,
    Candidate,
    candidate_rotations,
    check_points,
    orientation_clause,
    poses_at,
    refuse_planar,
    solve_outward,
    verified_cube,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.iso9283.cube import Cube
    from lostmotion.spatial import Floats

# Grid cells along the longest side of the workspace.
CELLS: Final = 20
# Fewest grid cells along the shortest side, and largest number of grid points for it.
_ACROSS: Final = 8
_MOST_POINTS: Final = 40_000
# Number of configurations for which the grid is filled.
_CONFIGURATIONS: Final = 2
# Number of cubes that are enlarged; the range (in grid steps) behind the farthest one; the share of
# the largest side that counts as equal.
_ENLARGED: Final = 8
_BESIDE: Final = 3.5
_EQUAL_SIDE: Final = 0.95
# Last step of the compass search, in grid steps.
_FINEST: Final = 1 / 16
# Directions of the compass search: none, along an axis, along several.
_WAYS: Final = np.array(
    sorted(itertools.product((0.0, 1.0, -1.0), repeat=3), key=lambda way: sum(map(abs, way)))
)
# Feasible directions of a coarse check that are checked at all points.
_WAYS_TRIED: Final = 3
_ROUNDING: Final = 1e-9
# Points along each half of the arm's column.
_ALONG: Final = 60
# Neighbours from which a grid point is tried.
_MOST_TRIES: Final = 2
_NEIGHBOURS: Final = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
# Clearance of the cube from the arm's own column, as a share of the reach.
_CLEARANCE: Final = 0.1
# Factor by which a cube is reduced until all its check points are reached, and largest number of
# reductions.
_SHRUNK: Final = 0.97
_TRIES: Final = 24


def largest_cube(
    arm: Arm,
    rotation: Floats | None = None,
    floor: float | None = 0.0,
    cells: int = CELLS,
    progress: Callable[[str, int, int], None] | None = None,
) -> Cube:
    """Return the largest cube that the tool reaches entirely, with constant orientation where the
    arm can hold one, and its five poses.

    rotation  (3, 3) of the tool; None: downward, forward, and that in the middle of the joint
              ranges are tried, and the largest cube is taken
    floor     lowest height of the cube in the base frame, m; None: no floor
    cells     grid cells along the longest side of the workspace, which set the resolution; along
              the shortest side there are at least eight

    From sampled poses, grid points over the workspace are reached from their neighbours by inverse
    kinematics, so that the cube is reached without a change of configuration. The largest cubes of
    reached points are moved and enlarged by a compass search, and the chosen one is reduced until
    all its check points are reached. Among cubes within 5 % of the largest, the one farthest along
    the base's x axis is taken, which points to the middle of the workspace by ISO 9787.
    Constraints: joint limits, the floor, and a clearance of a tenth of the reach from the line base
    - first joint - second joint, unless the first one slides; no obstacles, no self-collision.
    Raises InputError where there is no cube.
    """
    refuse_planar(arm)
    cloud = sample_poses(arm, SAMPLES).q
    tools = state_of(arm, cloud).frames[-1]
    grid, step = _grid(tools, floor, cells)
    clearance = float(np.linalg.norm(tools[:, :3, 3], axis=1).max()) * _CLEARANCE
    free = _off_column(arm, grid, clearance)
    tried = candidate_rotations(arm, rotation)
    found: list[Candidate] = []
    for number, orientation in enumerate(tried):
        if progress is not None:
            progress("searching for the test cube", number, len(tried))
        for joint_values, reached in _flood_fills(arm, grid, free, orientation, cloud, tools):
            found += _candidates(grid, step, joint_values, reached, orientation)
    if not found:
        expected = (
            "a part of the workspace above the floor that the tool reaches "
            f"entirely{orientation_clause(arm)}"
        )
        raise refuse_argument("cube", "none", expected, floor="-500 mm")
    found.sort(key=lambda each: (each.side, each.centre[0]), reverse=True)
    at_least = found[0].side - 1.5 * step
    grown = [
        _enlarged(arm, each, step, clearance, floor)
        for each in found[:_ENLARGED]
        if each.side > at_least
    ]
    most = max(each.side for each in grown)
    best = max(
        (each for each in grown if each.side >= _EQUAL_SIDE * most),
        key=lambda each: float(each.centre[0]),
    )
    text = f"a grid of {step * 1e3:.0f} mm over the workspace, {grid[..., 0].size} points" + (
        f", {len(tried)} orientations of the tool tried" if len(tried) > 1 else ""
    )
    return _reduced(arm, best, step * _FINEST, text)


def _candidates(
    grid: Floats, step: float, joint_values: Floats, reached: np.ndarray, orientation: Floats | None
) -> list[Candidate]:
    """Return some of the largest cubes of reached grid points: for each size the one farthest along
    x, and the lowest and highest near it.
    """
    edges = _largest_at(reached)
    most = int(edges.max())
    out = []
    for edge in range(most, max(most - 2, 0), -1):
        corners = np.argwhere(edges == edge)
        if not len(corners):
            continue
        points = grid[tuple(corners.T)]
        aside = np.abs(points[:, 1] + edge * step / 2)
        front = np.flatnonzero(points[:, 0] > points[:, 0].max() - _BESIDE * step)
        heights = points[front, 2]
        picked = {int(np.lexsort((-aside, points[:, 0]))[-1])}
        picked |= {int(front[np.lexsort((aside[front], sign * heights))[0]]) for sign in (1, -1)}
        chosen = [tuple(corner) for corner in corners[sorted(picked)]]
        middles = [tuple(np.add(corner, edge // 2)) for corner in chosen]
        out += [
            Candidate(
                edge * step, grid[corner] + edge * step / 2, joint_values[middle], orientation
            )
            for corner, middle in zip(chosen, middles, strict=True)
        ]
    return out


def _enlarged(
    arm: Arm, initial: Candidate, step: float, clearance: float, floor: float | None
) -> Candidate:
    """Return a cube moved and enlarged by steps, halved where none succeeds, while corners and
    centres of edges and faces stay in reach.
    """
    line = np.linspace(-1.0, 1.0, 3)
    coarse = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    middle, reached = inverse_kinematics(
        arm,
        poses_at(initial.centre[None], initial.orientation),
        initial.start[None],
        with_orientation=initial.orientation is not None,
    )
    if not reached.all():
        return Candidate(0.0, initial.centre, initial.start, initial.orientation)
    best = Candidate(initial.side, initial.centre, middle[0], initial.orientation)
    column = _column(arm)
    size = step / 2
    while size >= step * _FINEST:
        centres, side = best.centre + _WAYS * size / 2, best.side + size
        points = centres[:, None] + side / 2 * coarse
        feasible = np.array(
            [not _contains_any(column, centre, side / 2 + clearance) for centre in centres]
        )
        if floor is not None:
            feasible &= points[..., 2].min(axis=1) >= floor - _ROUNDING
        q, feasible = solve_outward(arm, best.centre, points - best.centre, best, feasible)
        wider = (
            Candidate(side, centres[k], q[k, len(coarse) // 2], best.orientation)
            for k in np.flatnonzero(feasible)[:_WAYS_TRIED]
        )
        larger = next((each for each in wider if _reachable(arm, each)), None)
        if larger is None:
            size /= 2
        else:
            best = larger
    return best


def _reachable(arm: Arm, cube: Candidate) -> bool:
    """Return whether the tool reaches all check points of a cube from its centre."""
    return bool(
        solve_outward(
            arm, cube.centre, cube.side / 2 * check_points()[None], cube, np.ones(1, bool)
        )[1][0]
    )


def _contains_any(points: Floats, centre: Floats, half: float) -> bool:
    """Return whether any of these points (point, 3) lies in the cube."""
    return bool((np.abs(points - centre) <= half).all(axis=1).any())


def _reduced(arm: Arm, candidate: Candidate, resolution: float, text: str) -> Cube:
    """Return the cube reduced about its centre until all its check points are reached."""
    for share in _SHRUNK ** np.arange(_TRIES):
        tried = Candidate(
            candidate.side * float(share), candidate.centre, candidate.start, candidate.orientation
        )
        cube = verified_cube(arm, tried, resolution, text)
        if cube is not None:
            return cube
    raise refuse_argument(
        "cube",
        "none that is reachable on a finer grid",
        "a stated cube",
        cube="300 mm",
        centre="600 mm, 0 mm, 400 mm",
    )


def _grid(tools: Floats, floor: float | None, cells: int) -> tuple[Floats, float]:
    """Return a grid (i, j, k, 3) over the tool points of many poses (pose, 4, 4) and above the
    floor, and its step, m.
    """
    low, high = tools[:, :3, 3].min(axis=0), tools[:, :3, 3].max(axis=0)
    if floor is not None:
        low[2] = max(low[2], floor)
    if (high <= low).any():
        raise refuse_argument(
            "cube",
            "no part of the workspace above the floor",
            "a floor below the workspace",
            floor="-500 mm",
        )
    # A cube is no larger than the shortest side: a long rail or a flat workspace needs cells of its
    # own size, as many as the memory takes.
    extents = np.sort(high - low)
    step = float(
        max(
            min(extents[-1] / cells, extents[0] / _ACROSS),
            (extents.prod() / _MOST_POINTS) ** (1 / 3),
        )
    )
    axes = [
        np.arange(a, b + 1e-9, step) + ((b - a) % step) / 2 for a, b in zip(low, high, strict=True)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1), step


def _flood_fills(
    arm: Arm,
    grid: Floats,
    free: np.ndarray,
    orientation: Floats | None,
    cloud: Floats,
    tools: Floats,
) -> Iterator[tuple[Floats, np.ndarray]]:
    """Yield joint values (i, j, k, joint) and reached points of the grid (i, j, k, 3), for a few
    different configurations.
    """
    from scipy.spatial import KDTree

    points = grid[free]
    if not len(points):
        return
    picked = points[:: max(len(points) // STARTS, 1)]
    nearest = KDTree(tools[:, :3, 3]).query(picked)[1]
    q, reached = inverse_kinematics(
        arm, poses_at(picked, orientation), cloud[nearest], with_orientation=orientation is not None
    )
    seeds = [
        (tuple(np.argwhere((grid == point).all(axis=-1))[0]), values)
        for point, values in zip(picked[reached], q[reached], strict=True)
    ]
    found: list[tuple[Floats, np.ndarray]] = []
    # Central points first: they lead to the largest part of a configuration's range.
    middle = picked[reached].mean(axis=0) if seeds else np.zeros(3)
    seeds.sort(key=lambda seed: float(np.linalg.norm(grid[seed[0]] - middle)))
    for place, values in seeds:
        if len(found) == _CONFIGURATIONS:
            return
        if any(
            seen[place] and np.abs(known[place] - values).max() < SAME_CONFIGURATION
            for known, seen in found
        ):
            continue
        found.append(_flood_fill(arm, grid, free, orientation, place, values))
        yield found[-1]


def _flood_fill(
    arm: Arm,
    grid: Floats,
    free: np.ndarray,
    orientation: Floats | None,
    place: tuple[int, ...],
    values: Floats,
) -> tuple[Floats, np.ndarray]:
    """Return joint values and reached points of the grid by flood fill from one point."""
    q = np.zeros((*free.shape, len(values)))
    reached = np.zeros(free.shape, bool)
    q[place], reached[place] = values, True
    fresh = np.array([place])
    tries = np.zeros(free.shape, np.int8)
    while len(fresh):
        beside = (fresh[:, None] + _NEIGHBOURS).reshape(-1, SPACE)
        origin = np.repeat(fresh, len(_NEIGHBOURS), axis=0)
        inside = ((beside >= 0) & (beside < free.shape)).all(axis=1)
        beside, origin = beside[inside], origin[inside]
        wanted = (
            free[tuple(beside.T)]
            & ~reached[tuple(beside.T)]
            & (tries[tuple(beside.T)] < _MOST_TRIES)
        )
        beside, first = np.unique(beside[wanted], axis=0, return_index=True)
        if not len(beside):
            break
        start = q[tuple(origin[wanted][first].T)]
        solved, ok = inverse_kinematics(
            arm,
            poses_at(grid[tuple(beside.T)], orientation),
            start,
            with_orientation=orientation is not None,
            steps=STEPS,
        )
        tries[tuple(beside.T)] += 1
        fresh = beside[ok]
        q[tuple(fresh.T)], reached[tuple(fresh.T)] = solved[ok], True
    return q, reached


def _largest_at(reached: np.ndarray) -> np.ndarray:
    """Return the edge, in grid steps, of the largest cube of reached points with its corner of
    least coordinates at each point.
    """
    size = np.zeros(np.array(reached.shape) + 1, int)
    for i, j, k in np.argwhere(reached)[::-1]:
        size[i, j, k] = 1 + size[i : i + 2, j : j + 2, k : k + 2].ravel()[1:].min()
    return np.asarray(np.maximum(size[:-1, :-1, :-1] - 1, 0))


def _column(arm: Arm) -> Floats:
    """Return points (point, 3) along the line base - first moving joint - second one, with all
    joints in the middle of their ranges.

    None where the first of them slides: then the column moves out of the way.
    """
    if arm.driven[arm.tree.tool_joints[0]].type == "prismatic":
        return np.empty((0, SPACE))
    at = state_of(arm, arm.limits.mean(axis=1)).frames
    moved = [arm.tree.moved[drive] for drive in arm.tree.tool_joints[:2]]
    line = np.vstack(
        [np.zeros(3), at[[arm.tree.places[place].parent for place in moved], 0, :3, 3]]
    )
    share = np.linspace(0.0, 1.0, _ALONG)[:, None]
    return np.vstack([a + share * (b - a) for a, b in itertools.pairwise(line)])


def _off_column(arm: Arm, grid: Floats, clearance: float) -> np.ndarray:
    """Return which points (..., 3) are farther than this from the arm's column."""
    from scipy.spatial import KDTree

    column = _column(arm)
    return (
        np.asarray(KDTree(column).query(grid)[0] > clearance)
        if len(column)
        else np.ones(grid.shape[:-1], dtype=bool)
    )
