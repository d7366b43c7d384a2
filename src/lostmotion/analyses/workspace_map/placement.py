"""Where should work of a given size stand? The box of cells whose worst, or mean, error is least, and of which the tool reaches every cell.

Every place on the grid and, where asked for, every yaw of the list is compared, by sliding maxima; what the tool reaches is found by inverse
kinematics from several starts, and so is a search.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.workspace_map.reach import in_reach
from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.analyses.workspace_map.cells import Grid
    from lostmotion.analyses.workspace_map.reach import Reached
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

PLACES: Final = 3
# Yaws that a turned box may stand at, rad: a half turn brings any box back onto itself.
YAWS: Final = tuple(math.radians(15.0 * k) for k in range(12))
# A box that fills its cells to rounding does not need another one.
_FULL: Final = 1e-9


@dataclass(frozen=True, repr=False)
class Box:
    """A place for a box: its middle (3,) and sides (3,) in m, its yaw about z (rad), and the numbers of the cells that it touches.

    worst, mean     over its cells, of the figure asked for, m
    ends            (end, figure) between which worst, mean, afresh_worst and afresh_mean lie, as the cells' own ends; NaN where not known
    afresh_worst, afresh_mean   the same at the points of a lattice over the box, corners included, from other poses: `afresh_poses` in all, at
                    `afresh_reached` of `afresh_points` points
    """

    centre: Floats
    size: Floats
    yaw: float
    cells: np.ndarray
    worst: float
    mean: float
    ends: Floats
    afresh_worst: float = math.nan
    afresh_mean: float = math.nan
    afresh_poses: int = 0
    afresh_points: int = 0
    afresh_reached: int = 0

    def points(self, edge: float) -> Floats:
        """Give a lattice (point, 3) over the box, its corners included, with steps of an edge at most, m."""
        along = [np.linspace(-0.5, 0.5, max(math.ceil(side / edge - _FULL), 0) + 1) * side if side > 0 else np.zeros(1) for side in self.size]
        own = np.stack(np.meshgrid(*along, indexing="ij"), axis=-1).reshape(-1, 3)
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return np.asarray(self.centre + own @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]))


@dataclass(frozen=True, repr=False)
class Boxes:
    """The best places for a box of this size (m), no two of which share a cell, the best first.

    by_mean   whether boxes were judged by the mean over their cells, else by the worst one
    turned    whether other yaws were tried
    tried     how many places have all of their cells in reach
    whole     (x, y, z) cells that the tool reaches in the middle and at all corners, and that the box may stand in
    largest   sides (3,) of the largest box of these proportions that fits anywhere on the grid, m; None where none does
    """

    size: tuple[float, float, float]
    by_mean: bool
    turned: bool
    tried: int
    whole: np.ndarray
    largest: Floats | None
    found: tuple[Box, ...]


def best_boxes(  # noqa: PLR0913 - a search is these numbers
    arm: Arm,
    reached: Reached,
    figures: Floats,
    size: tuple[float, float, float],
    allowed: np.ndarray | None = None,
    *,
    ends: Floats | None = None,
    by_mean: bool = False,
    turned: bool = False,
    afresh: Callable[[Floats], tuple[Floats, Floats, int]] | None = None,
) -> Boxes:
    """Where does a box of this size (m) see the least error, `figures` (x, y, z) over the cells?

    allowed (x, y, z) cells that it may stand in; left out, all
    ends    (end, cell) between which the figures lie; left out, not known
    afresh  gives the figures at points (point, 3) from other poses, the ends (end, point) of each, and how many poses those were
    A side of zero is one layer of cells. Raises InputError for a side along an axis that the tool cannot move along.
    """
    grid = reached.grid
    stuck = grid.flat & (np.array(size) > 0)
    if stuck.any():
        axes = ", ".join(f"{'xyz'[k]} = {grid.plane[k] * 1e3:.4g} mm" for k in np.flatnonzero(stuck))
        asked = " x ".join(f"{x * 1e3:.4g}" for x in size)
        fits = " x ".join(f"{0 if flat else x * 1e3:.4g} mm" for x, flat in zip(size, grid.flat, strict=True))
        raise refuse_argument("box", f"{asked} mm, and the tool cannot leave {axes}", "0 mm along such an axis", box=fits)
    whole = whole_cells(arm, reached)
    if allowed is not None:
        whole &= allowed
    field = np.where(whole, figures, np.inf)
    largest = _largest(whole, np.array(size), grid, turned=turned)
    yaws = (YAWS if turned else YAWS[:1]) if max(size) <= _longest(grid) else ()
    prints = [(yaw, footprint(size, yaw, grid.edge)) for yaw in yaws]
    maps = [judged(field, cover, by_mean=by_mean) for _, cover in prints]
    tried = sum(int(np.isfinite(one).sum()) for one in maps)
    boxes: list[Box] = []
    taken = np.zeros(grid.shape, bool)
    while prints and len(boxes) < PLACES:
        open_now = [np.where(_touches(taken, cover), np.inf, one) for one, (_, cover) in zip(maps, prints, strict=True)]
        best = min(range(len(prints)), key=lambda k: float(open_now[k].min(initial=np.inf)))
        if not np.isfinite(open_now[best]).any():
            break
        yaw, cover = prints[best]
        low = np.array(np.unravel_index(int(open_now[best].argmin()), grid.shape))
        at = np.argwhere(cover) + low
        taken[tuple(at.T)] = True
        cells = np.ravel_multi_index(tuple(at.T), grid.shape)
        centre = grid.low + grid.edge * (low + np.array(cover.shape) / 2)
        values = figures.ravel()[cells]
        of_map = np.full((2, 2), np.nan) if ends is None else _worst_and_mean(ends[:, cells])
        box = Box(np.asarray(centre), np.array(size), yaw, cells, float(values.max()), float(values.mean()), _joined(of_map))
        boxes.append(box if afresh is None else _checked(box, *afresh(box.points(grid.edge))))
    return Boxes(size, by_mean, turned, tried, whole, largest, tuple(boxes))


def _longest(grid: Grid) -> float:
    """Give the grid's diagonal, m: a box with a longer side fits at no yaw, and its footprint would fill the memory."""
    return grid.edge * math.hypot(*grid.shape)


def _worst_and_mean(ends: Floats) -> Floats:
    """Between which ends (end, figure) lie the largest and the mean of figures that each lie between such ends (end, cell)?"""
    return np.column_stack([ends.max(axis=1), ends.mean(axis=1)])


def _joined(of_map: Floats, afresh: Floats | None = None) -> Floats:
    return np.hstack([of_map, np.full((2, 2), np.nan) if afresh is None else afresh])


def _checked(box: Box, values: Floats, between: Floats, poses: int) -> Box:
    there = np.isfinite(values)
    known, ends = values[there], box.ends
    worst = mean = math.nan
    if len(known):
        worst, mean, ends = float(known.max()), float(known.mean()), _joined(box.ends[:, :2], _worst_and_mean(between[:, there]))
    return replace(box, ends=ends, afresh_worst=worst, afresh_mean=mean, afresh_poses=poses, afresh_points=len(values), afresh_reached=len(known))


def whole_cells(arm: Arm, reached: Reached) -> np.ndarray:
    """Which cells (x, y, z) does the tool reach in the middle and at every corner?"""
    grid = reached.grid
    corners = np.zeros(tuple(n if still else n + 1 for n, still in zip(grid.shape, grid.flat, strict=True)), bool)
    steps = [
        tuple(slice(s, s + n) for s, n in zip(step, grid.shape, strict=True)) for step in np.ndindex(*(1 if still else 2 for still in grid.flat))
    ]
    for there in steps:
        corners[there] |= reached.centre
    goal = np.argwhere(corners)
    corners[tuple(goal.T)] = in_reach(arm, reached, grid.low + grid.edge * (goal + np.where(grid.flat, 0.5, 0.0)))
    out = reached.centre.copy()
    for there in steps:
        out &= corners[there]
    return out


def keeping_clear(grid: Grid, clear: float, floor: float) -> np.ndarray:
    """Which cells (x, y, z) lie at least this far from the base's z axis, seen from above, and above this height?"""
    x, y = (np.maximum(np.abs(grid.along(k)) - grid.edge / 2, 0.0) for k in range(2))
    away = np.hypot(x[:, None], y) >= clear * (1 - _FULL)
    above = grid.along(2) - grid.edge / 2 >= floor - _FULL * grid.edge
    return np.asarray(away[:, :, None] & above)


def footprint(size: tuple[float, float, float] | Floats, yaw: float, edge: float) -> np.ndarray:
    """Which cells (x, y, z) does a box touch? Unturned it begins at a corner of a cell; turned its middle lies amid a cell, seen from above."""
    count = [max(math.ceil(side / edge - _FULL), 1) for side in size]
    if yaw == 0:
        return np.ones(count, bool)
    half = np.array(size[:2]) / 2
    cos, sin = math.cos(yaw), math.sin(yaw)
    wide = [abs(cos) * half[0] + abs(sin) * half[1], abs(sin) * half[0] + abs(cos) * half[1]]
    along = [np.arange(-reach, reach + 1) * edge for reach in (math.ceil(w / edge - 0.5 - _FULL) for w in wide)]
    x, y = np.meshgrid(*along, indexing="ij")
    # Two rectangles touch unless a side of one of them separates them.
    own = edge / 2 * (abs(cos) + abs(sin))
    slack = _FULL * edge
    touch = (np.abs(cos * x + sin * y) < half[0] + own - slack) & (np.abs(cos * y - sin * x) < half[1] + own - slack)
    touch &= (np.abs(x) < wide[0] + edge / 2 - slack) & (np.abs(y) < wide[1] + edge / 2 - slack)
    return np.repeat(touch[:, :, None], count[2], axis=2)


def judged(field: Floats, cover: np.ndarray, *, by_mean: bool) -> Floats:
    """What is the largest value, or the mean, under a footprint that begins at each cell? (x, y, z), infinite where it holds an infinite one."""
    worst = _largest_under(field, cover)
    if not by_mean:
        return worst
    fits = np.isfinite(worst)
    total = np.zeros(field.shape)
    padded = np.zeros(tuple(n + m for n, m in zip(field.shape, cover.shape, strict=True)))
    padded[tuple(slice(n) for n in field.shape)] = np.where(np.isfinite(field), field, 0.0)
    for step in np.argwhere(cover):
        total += padded[tuple(slice(int(s), int(s) + n) for s, n in zip(step, field.shape, strict=True))]
    return np.where(fits, total / np.count_nonzero(cover), np.inf)


def _largest_under(field: Floats, cover: np.ndarray) -> Floats:
    """Give the largest value under a footprint that begins at each cell: upright, so one filter from above and one along z."""
    from scipy.ndimage import maximum_filter

    flat, tall = cover[:, :, :1], np.ones((1, 1, cover.shape[2]), bool)
    out = field
    for shape in (flat, tall):
        out = maximum_filter(out, footprint=shape, mode="constant", cval=np.inf, origin=[-(n // 2) for n in shape.shape])
    return np.asarray(out)


def _touches(taken: np.ndarray, cover: np.ndarray) -> np.ndarray:
    return np.isinf(_largest_under(np.where(taken, np.inf, 0.0), cover))


def _largest(whole: np.ndarray, size: Floats, grid: Grid, *, turned: bool) -> Floats | None:
    """Find the largest scale of a box at which it fits: fitting ends once for good as the box grows, where a side passes a whole number of cells."""
    field = np.where(whole, 0.0, np.inf)
    sides = np.flatnonzero(size > 0)
    scales = np.unique(np.concatenate([np.arange(1, grid.shape[k] + 1) * grid.edge / size[k] for k in sides]))
    scales = scales[scales * size.max() <= _longest(grid)]

    def fits(scale: float) -> bool:
        covers = (footprint(scale * size, yaw, grid.edge) for yaw in (YAWS if turned else YAWS[:1]))
        return any(np.isfinite(_largest_under(field, cover)).any() for cover in covers if all(np.array(cover.shape) <= whole.shape))

    low, high = 0, len(scales)  # scales[:low] fit, scales[high:] do not
    while low < high:
        middle = (low + high) // 2
        low, high = (middle + 1, high) if fits(float(scales[middle])) else (low, middle)
    return None if low == 0 else np.asarray(scales[low - 1] * size)
