"""Best placement of a box for a task: the reachable box of cells with the smallest worst or mean
error.

All positions on the grid and, on request, all yaws of a list are compared by sliding maxima. Reach
is tested by inverse kinematics from several starts, so an unreached point is not proven to be out
of reach.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.maps.configurations import solve_positions

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.maps.cells import CellPoses, Grid
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

PLACES: Final = 3
# Yaws that are tried, rad; a box is symmetric under half a turn.
YAWS: Final = tuple(math.radians(15.0 * k) for k in range(12))
# Rounding tolerance of a box that exactly fills its cells, as a share of the edge.
_FULL: Final = 1e-9


@dataclass(frozen=True, repr=False)
class Placement:
    """A placement of a box: centre (3,) and sides (3,) in m, yaw about z (rad), and the numbers of
    the cells that it touches.

    worst, mean         of the selected figure over its cells, m
    bounds              (end, figure) lower and upper bounds of worst, mean, validated_worst and
                        validated_mean; NaN where unknown validated_worst, validated_mean    the
                        same at the points of a lattice over the box, corners included, from
                        `validation_poses` other poses, reached at `validation_reached` of
                        `validation_points` points
    """

    centre: Floats
    size: Floats
    yaw: float
    cells: np.ndarray
    worst: float
    mean: float
    bounds: Floats
    validated_worst: float = math.nan
    validated_mean: float = math.nan
    validation_poses: int = 0
    validation_points: int = 0
    validation_reached: int = 0

    def points(self, edge: float) -> Floats:
        """Return a lattice (point, 3) over the box, corners included, with steps of at most one
        edge, m.
        """
        along = [
            np.linspace(-0.5, 0.5, max(math.ceil(side / edge - _FULL), 0) + 1) * side
            if side > 0
            else np.zeros(1)
            for side in self.size
        ]
        own = np.stack(np.meshgrid(*along, indexing="ij"), axis=-1).reshape(-1, 3)
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return np.asarray(
            self.centre + own @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        )


@dataclass(frozen=True, repr=False)
class Placements:
    """The best placements of a box of this size (m), the best first; no two share a cell.

    by_mean   whether placements are compared by the mean over their cells, else by the worst cell
    turned    whether other yaws were tried
    tried     number of placements with all cells in reach
    whole     (x, y, z) cells with the centre and all corners in reach, where the box may be placed
    largest   sides (3,) of the largest box of these proportions that fits on the grid, m; None
              where none does
    """

    size: tuple[float, float, float]
    by_mean: bool
    turned: bool
    tried: int
    whole: np.ndarray
    largest: Floats | None
    best: tuple[Placement, ...]


def best_placements(  # noqa: PLR0913 - a search is these numbers
    arm: Arm,
    reached: CellPoses,
    figures: Floats,
    size: tuple[float, float, float],
    allowed: np.ndarray | None = None,
    *,
    bounds: Floats | None = None,
    by_mean: bool = False,
    turned: bool = False,
    validation: Callable[[Floats], tuple[Floats, Floats, int]] | None = None,
) -> Placements:
    """Return the placements of a box of this size (m) with the smallest error, `figures` (x, y, z)
    over the cells.

    allowed      (x, y, z) cells where it may be placed; None: all
    bounds       (end, cell) lower and upper bounds of the figures; None: unknown
    validation   returns the figures at points (point, 3) from other poses, their bounds (end,
                 point), and the number of those poses
    A side of zero is one layer of cells. Raises InputError for a side along an axis that the tool
    cannot move along.
    """
    grid = reached.grid
    stuck = grid.flat & (np.array(size) > 0)
    if stuck.any():
        axes = ", ".join(
            f"{'xyz'[k]} = {grid.plane[k] * 1e3:.4g} mm" for k in np.flatnonzero(stuck)
        )
        sides = " x ".join(f"{x * 1e3:.4g}" for x in size)
        fits = " x ".join(
            f"{0 if flat else x * 1e3:.4g} mm" for x, flat in zip(size, grid.flat, strict=True)
        )
        raise refuse_argument(
            "box",
            f"{sides} mm, and the tool cannot leave {axes}",
            "0 mm along such an axis",
            box=fits,
        )
    whole = fully_reachable_cells(arm, reached)
    if allowed is not None:
        whole &= allowed
    field = np.where(whole, figures, np.inf)
    largest = _largest(whole, np.array(size), grid, turned=turned)
    yaws = (YAWS if turned else YAWS[:1]) if max(size) <= _longest(grid) else ()
    prints = [(yaw, footprint(size, yaw, grid.edge)) for yaw in yaws]
    maps = [placement_scores(field, cover, by_mean=by_mean) for _, cover in prints]
    tried = sum(int(np.isfinite(one).sum()) for one in maps)
    placements: list[Placement] = []
    taken = np.zeros(grid.shape, bool)
    while prints and len(placements) < PLACES:
        open_now = [
            np.where(_overlaps(taken, cover), np.inf, one)
            for one, (_, cover) in zip(maps, prints, strict=True)
        ]
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
        of_map = np.full((2, 2), np.nan) if bounds is None else _worst_and_mean(bounds[:, cells])
        box = Placement(
            np.asarray(centre),
            np.array(size),
            yaw,
            cells,
            float(values.max()),
            float(values.mean()),
            _joined(of_map),
        )
        placements.append(
            box if validation is None else _validated(box, *validation(box.points(grid.edge)))
        )
    return Placements(size, by_mean, turned, tried, whole, largest, tuple(placements))


def _longest(grid: Grid) -> float:
    """Return the grid's diagonal, m: a box with a longer side fits at no yaw, and its footprint
    would fill the memory.
    """
    return grid.edge * math.hypot(*grid.shape)


def _worst_and_mean(bounds: Floats) -> Floats:
    """Return the bounds (end, figure) of the largest and the mean of figures with these bounds
    (end, cell).
    """
    return np.column_stack([bounds.max(axis=1), bounds.mean(axis=1)])


def _joined(of_map: Floats, validation: Floats | None = None) -> Floats:
    """Return bounds (2, 4) over the map's cells and at the validation points; NaN for those
    unknown.
    """
    return np.hstack([of_map, np.full((2, 2), np.nan) if validation is None else validation])


def _validated(box: Placement, values: Floats, between: Floats, poses: int) -> Placement:
    """Return a placement with its figures at the validation points."""
    there = np.isfinite(values)
    known, bounds = values[there], box.bounds
    worst = mean = math.nan
    if len(known):
        worst, mean, bounds = (
            float(known.max()),
            float(known.mean()),
            _joined(box.bounds[:, :2], _worst_and_mean(between[:, there])),
        )
    return replace(
        box,
        bounds=bounds,
        validated_worst=worst,
        validated_mean=mean,
        validation_poses=poses,
        validation_points=len(values),
        validation_reached=len(known),
    )


def fully_reachable_cells(arm: Arm, reached: CellPoses) -> np.ndarray:
    """Return which cells (x, y, z) have the centre and all corners in reach."""
    grid = reached.grid
    corners = np.zeros(
        tuple(n if still else n + 1 for n, still in zip(grid.shape, grid.flat, strict=True)), bool
    )
    steps = [
        tuple(slice(s, s + n) for s, n in zip(step, grid.shape, strict=True))
        for step in np.ndindex(*(1 if still else 2 for still in grid.flat))
    ]
    for there in steps:
        corners[there] |= reached.centre
    goal = np.argwhere(corners)
    corners[tuple(goal.T)] = solve_positions(
        arm, reached, grid.low + grid.edge * (goal + np.where(grid.flat, 0.5, 0.0))
    )[1]
    out = reached.centre.copy()
    for there in steps:
        out &= corners[there]
    return out


def clear_cells(grid: Grid, clear: float, floor: float) -> np.ndarray:
    """Return which cells (x, y, z) are at least this far from the base's z axis, in top view, and
    above this height.
    """
    x, y = (np.maximum(np.abs(grid.centres_along(k)) - grid.edge / 2, 0.0) for k in range(2))
    away = np.hypot(x[:, None], y) >= clear * (1 - _FULL)
    above = grid.centres_along(2) - grid.edge / 2 >= floor - _FULL * grid.edge
    return np.asarray(away[:, :, None] & above)


def footprint(size: tuple[float, float, float] | Floats, yaw: float, edge: float) -> np.ndarray:
    """Return the cells (x, y, z) that a box touches; without yaw it starts at a cell corner, with
    yaw its centre is a cell centre in top view.
    """
    count = [max(math.ceil(side / edge - _FULL), 1) for side in size]
    if yaw == 0:
        return np.ones(count, bool)
    half = np.array(size[:2]) / 2
    cos, sin = math.cos(yaw), math.sin(yaw)
    wide = [abs(cos) * half[0] + abs(sin) * half[1], abs(sin) * half[0] + abs(cos) * half[1]]
    along = [
        np.arange(-reach, reach + 1) * edge
        for reach in (math.ceil(w / edge - 0.5 - _FULL) for w in wide)
    ]
    x, y = np.meshgrid(*along, indexing="ij")
    # Two rectangles touch unless a side of one of them separates them (separating axis theorem).
    own = edge / 2 * (abs(cos) + abs(sin))
    slack = _FULL * edge
    touch = (np.abs(cos * x + sin * y) < half[0] + own - slack) & (
        np.abs(cos * y - sin * x) < half[1] + own - slack
    )
    touch &= (np.abs(x) < wide[0] + edge / 2 - slack) & (np.abs(y) < wide[1] + edge / 2 - slack)
    return np.repeat(touch[:, :, None], count[2], axis=2)


def placement_scores(field: Floats, cover: np.ndarray, *, by_mean: bool) -> Floats:
    """Return the largest value or the mean (x, y, z) under a footprint that starts at each cell;
    infinite where it contains an infinite value.
    """
    worst = _largest_under(field, cover)
    if not by_mean:
        return worst
    fits = np.isfinite(worst)
    total = np.zeros(field.shape)
    padded = np.zeros(tuple(n + m for n, m in zip(field.shape, cover.shape, strict=True)))
    padded[tuple(slice(n) for n in field.shape)] = np.where(np.isfinite(field), field, 0.0)
    for step in np.argwhere(cover):
        total += padded[
            tuple(slice(int(s), int(s) + n) for s, n in zip(step, field.shape, strict=True))
        ]
    return np.where(fits, total / np.count_nonzero(cover), np.inf)


def _largest_under(field: Floats, cover: np.ndarray) -> Floats:
    """Return the largest value under a footprint that starts at each cell, by one filter in the
    plane and one along z.
    """
    from scipy.ndimage import maximum_filter

    flat, tall = cover[:, :, :1], np.ones((1, 1, cover.shape[2]), bool)
    out = field
    for shape in (flat, tall):
        out = maximum_filter(
            out,
            footprint=shape,
            mode="constant",
            cval=np.inf,
            origin=[-(n // 2) for n in shape.shape],
        )
    return np.asarray(out)


def _overlaps(taken: np.ndarray, cover: np.ndarray) -> np.ndarray:
    """Return at which cells a footprint would overlap cells already taken."""
    return np.isinf(_largest_under(np.where(taken, np.inf, 0.0), cover))


def _largest(whole: np.ndarray, size: Floats, grid: Grid, *, turned: bool) -> Floats | None:
    """Return the sides of the largest box of these proportions that fits, by bisection over the
    scales at which a side spans whole cells.
    """
    field = np.where(whole, 0.0, np.inf)
    sides = np.flatnonzero(size > 0)
    scales = np.unique(
        np.concatenate([np.arange(1, grid.shape[k] + 1) * grid.edge / size[k] for k in sides])
    )
    scales = scales[scales * size.max() <= _longest(grid)]

    def fits(scale: float) -> bool:
        covers = (footprint(scale * size, yaw, grid.edge) for yaw in (YAWS if turned else YAWS[:1]))
        return any(
            np.isfinite(_largest_under(field, cover)).any()
            for cover in covers
            if all(np.array(cover.shape) <= whole.shape)
        )

    low, high = 0, len(scales)  # scales[:low] fit, scales[high:] do not
    while low < high:
        middle = (low + high) // 2
        low, high = (middle + 1, high) if fits(float(scales[middle])) else (low, middle)
    return None if low == 0 else np.asarray(scales[low - 1] * size)
