"""How large a test cube does the workspace of this arm hold? Found by flooding a grid with inverse kinematics, then moved and grown."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.iso9283.cube import (
    SAME_CONFIGURATION,
    SAMPLES,
    SPACE,
    STARTS,
    STEPS,
    Candidate,
    candidate_rotations,
    check_points,
    checked,
    orientation_clause,
    poses_at,
    refuse_planar,
    spread,
)
from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.mechanism.serial import frames

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from lostmotion.analyses.iso9283.cube import Cube
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Grid cells along the longest side of the workspace, at first and for the best that was found.
CELLS: Final = 20
# So many configurations are followed over the grid.
_CONFIGURATIONS: Final = 2
# Cubes of grid points that are moved and grown; those within this share of the largest count as equals.
_FOLLOWED: Final = 8
_BESIDE: Final = 3.5
_ALIKE_SIDE: Final = 0.95
# Of the grid's step: by how much a cube is moved and grown last.
_FINEST: Final = 1 / 16
# Where a cube may move to as it grows: nowhere, along an axis, or both ways along several.
_WAYS: Final = np.array(sorted(itertools.product((0.0, 1.0, -1.0), repeat=3), key=lambda way: sum(map(abs, way))))
# So many of the ways that the coarse look allows are looked at on the finer grid.
_WAYS_TRIED: Final = 3
_ROUNDING: Final = 1e-9
# Points along each half of the arm's column.
_ALONG: Final = 60
# From so many neighbours a grid point is tried.
_MOST_TRIES: Final = 2
_NEIGHBOURS: Final = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
# Of the reach: how far the cube stays off the arm's own column.
_CLEARANCE: Final = 0.1
# By what, and how often, a cube is made smaller until all points in it hold.
_SHRUNK: Final = 0.97
_TRIES: Final = 24


def largest_cube(
    arm: Arm, rotation: Floats | None = None, floor: float | None = 0.0, cells: int = CELLS, progress: Callable[[str, int, int], None] | None = None
) -> Cube:
    """Which is the largest cube that the tool can be brought to all over, held alike where it can be, and where are its five poses?

    rotation  (3, 3) of the tool; left out: pointing down, forward, and as in the middle of the joints' ranges are tried, the largest cube counts
    floor     m: no point lies below this height in the base frame; None: no floor
    cells     of the grid along the longest side of the workspace: sets the resolution

    From points that sampled poses lead to, every point of a grid over the workspace is reached from its neighbours by inverse kinematics, so that the
    cube is reached without changing the arm's configuration. The largest cubes of such points are moved and grown by a compass search, and the one
    taken is made smaller until all of a grid of its own holds. Of equals (5 %) it is the one farthest along the base's x, which points to the
    middle of the workspace where a base is drawn by ISO 9787. Joint limits, floor, and a tenth of the reach kept
    off the line base - first joint - second joint; no other obstacle or self-collision. Raises InputError where there is no cube.
    """
    refuse_planar(arm)
    cloud = sample_poses(arm, SAMPLES).q
    tools = frames(arm, cloud)[-1]
    grid, step = _grid(tools, floor, cells)
    clearance = float(np.linalg.norm(tools[:, :3, 3], axis=1).max()) * _CLEARANCE
    free = _off_column(arm, grid, clearance)
    tried = candidate_rotations(arm, rotation)
    found: list[Candidate] = []
    for number, held in enumerate(tried):
        if progress is not None:
            progress("looking for the test cube", number, len(tried))
        for joint_values, reached in _floods(arm, grid, free, held, cloud, tools):
            found += _candidates(grid, step, joint_values, reached, held)
    if not found:
        expected = f"a part of the workspace above the floor that the tool reaches all over{orientation_clause(arm)}"
        raise refuse_argument("cube", "none", expected, floor="-500 mm")
    found.sort(key=lambda each: (each.side, each.centre[0]), reverse=True)
    at_least = found[0].side - 1.5 * step
    grown = [_grown(arm, each, step, clearance, floor) for each in found[:_FOLLOWED] if each.side > at_least]
    most = max(each.side for each in grown)
    best = max((each for each in grown if each.side >= _ALIKE_SIDE * most), key=lambda each: float(each.centre[0]))
    text = f"a grid of {step * 1e3:.0f} mm over the workspace, {grid[..., 0].size} points" + (
        f", {len(tried)} orientations of the tool tried" if len(tried) > 1 else ""
    )
    return _settled(arm, best, step * _FINEST, text)


def _candidates(grid: Floats, step: float, joint_values: Floats, reached: np.ndarray, held: Floats | None) -> list[Candidate]:
    """Give a few of the largest cubes of reached grid points: of each size the one farthest along x, and the lowest and highest beside it."""
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
            Candidate(edge * step, grid[corner] + edge * step / 2, joint_values[middle], held) for corner, middle in zip(chosen, middles, strict=True)
        ]
    return out


def _grown(arm: Arm, begun: Candidate, step: float, clearance: float, floor: float | None) -> Candidate:
    """Move and grow a cube as long as its corners and the middles of edges and faces stay within reach: by steps, halved where no way helps."""
    line = np.linspace(-1.0, 1.0, 3)
    coarse = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    middle, reached = inverse_kinematics(arm, poses_at(begun.centre[None], begun.held), begun.start[None], turned=begun.held is not None)
    if not reached.all():
        return Candidate(0.0, begun.centre, begun.start, begun.held)
    best = Candidate(begun.side, begun.centre, middle[0], begun.held)
    column = _column(arm)
    size = step / 2
    while size >= step * _FINEST:
        centres, side = best.centre + _WAYS * size / 2, best.side + size
        points = centres[:, None] + side / 2 * coarse
        may = np.array([not _holds_any(column, centre, side / 2 + clearance) for centre in centres])
        if floor is not None:
            may &= points[..., 2].min(axis=1) >= floor - _ROUNDING
        q, may = spread(arm, best.centre, points - best.centre, best, may)
        wider = (Candidate(side, centres[k], q[k, len(coarse) // 2], best.held) for k in np.flatnonzero(may)[:_WAYS_TRIED])
        larger = next((each for each in wider if _reached_within(arm, each)), None)
        if larger is None:
            size /= 2
        else:
            best = larger
    return best


def _reached_within(arm: Arm, cube: Candidate) -> bool:
    """Tell whether the tool can be brought from the middle of a cube to all points looked at in it."""
    return bool(spread(arm, cube.centre, cube.side / 2 * check_points()[None], cube, np.ones(1, bool))[1][0])


def _holds_any(points: Floats, centre: Floats, half: float) -> bool:
    return bool((np.abs(points - centre) <= half).all(axis=1).any())


def _settled(arm: Arm, found: Candidate, resolution: float, text: str) -> Cube:
    """Make a cube smaller, about its middle, until all points of a grid of its own hold."""
    for share in _SHRUNK ** np.arange(_TRIES):
        tried = Candidate(found.side * float(share), found.centre, found.start, found.held)
        cube = checked(arm, tried, resolution, text)
        if cube is not None:
            return cube
    raise refuse_argument("cube", "none that holds on a finer grid", "a cube by hand", cube="300 mm", centre="600 mm, 0 mm, 400 mm")


def _grid(tools: Floats, floor: float | None, cells: int) -> tuple[Floats, float]:
    """Lay a grid (i, j, k, 3) over the tool points of many poses (pose, 4, 4) and above the floor; gives its step, m, too."""
    low, high = tools[:, :3, 3].min(axis=0), tools[:, :3, 3].max(axis=0)
    if floor is not None:
        low[2] = max(low[2], floor)
    if (high <= low).any():
        raise refuse_argument("cube", "no part of the workspace above the floor", "a floor below the workspace", floor="-500 mm")
    step = float((high - low).max()) / cells
    axes = [np.arange(a, b + 1e-9, step) + ((b - a) % step) / 2 for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1), step


def _floods(arm: Arm, grid: Floats, free: np.ndarray, held: Floats | None, cloud: Floats, tools: Floats) -> Iterator[tuple[Floats, np.ndarray]]:
    """Reach the grid (i, j, k, 3) from a few points in different configurations: joint values (i, j, k, joint), and which points were reached."""
    from scipy.spatial import KDTree

    points = grid[free]
    if not len(points):
        return
    picked = points[:: max(len(points) // STARTS, 1)]
    nearest = KDTree(tools[:, :3, 3]).query(picked)[1]
    q, reached = inverse_kinematics(arm, poses_at(picked, held), cloud[nearest], turned=held is not None)
    seeds = [(tuple(np.argwhere((grid == point).all(axis=-1))[0]), values) for point, values in zip(picked[reached], q[reached], strict=True)]
    found: list[tuple[Floats, np.ndarray]] = []
    # From the middle of what was reached outward: what stands in the middle of a configuration's share leads farthest.
    middle = picked[reached].mean(axis=0) if seeds else np.zeros(3)
    seeds.sort(key=lambda seed: float(np.linalg.norm(grid[seed[0]] - middle)))
    for place, values in seeds:
        if len(found) == _CONFIGURATIONS:
            return
        if any(seen[place] and np.abs(known[place] - values).max() < SAME_CONFIGURATION for known, seen in found):
            continue
        found.append(_flood(arm, grid, free, held, place, values))
        yield found[-1]


def _flood(arm: Arm, grid: Floats, free: np.ndarray, held: Floats | None, place: tuple[int, ...], values: Floats) -> tuple[Floats, np.ndarray]:
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
        wanted = free[tuple(beside.T)] & ~reached[tuple(beside.T)] & (tries[tuple(beside.T)] < _MOST_TRIES)
        beside, first = np.unique(beside[wanted], axis=0, return_index=True)
        if not len(beside):
            break
        start = q[tuple(origin[wanted][first].T)]
        solved, ok = inverse_kinematics(arm, poses_at(grid[tuple(beside.T)], held), start, turned=held is not None, steps=STEPS)
        tries[tuple(beside.T)] += 1
        fresh = beside[ok]
        q[tuple(fresh.T)], reached[tuple(fresh.T)] = solved[ok], True
    return q, reached


def _largest_at(reached: np.ndarray) -> np.ndarray:
    """Give the edge, in steps of the grid, of the largest cube of reached points whose corner of least coordinates stands at each point."""
    size = np.zeros(np.array(reached.shape) + 1, int)
    for i, j, k in np.argwhere(reached)[::-1]:
        size[i, j, k] = 1 + size[i : i + 2, j : j + 2, k : k + 2].ravel()[1:].min()
    return np.asarray(np.maximum(size[:-1, :-1, :-1] - 1, 0))


def _column(arm: Arm) -> Floats:
    """Give points along the line base - first moving joint - second one, with all joints in the middle of their ranges (point, 3)."""
    at = frames(arm, arm.limits.mean(axis=1)[None])
    moved = [arm.tree.moved[drive] for drive in arm.tree.drives[:2]]
    line = np.vstack([np.zeros(3), at[[arm.tree.places[place].parent for place in moved], 0, :3, 3]])
    share = np.linspace(0.0, 1.0, _ALONG)[:, None]
    return np.vstack([a + share * (b - a) for a, b in itertools.pairwise(line)])


def _off_column(arm: Arm, grid: Floats, clearance: float) -> np.ndarray:
    """Tell which points (..., 3) stand farther than this from the arm's column."""
    from scipy.spatial import KDTree

    return np.asarray(KDTree(_column(arm)).query(grid)[0] > clearance)
