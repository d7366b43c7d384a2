"""How accurate is the arm in each cell of its workspace, which share of that is good enough, and which part is to blame where?

Every figure of a cell is over the poses looked at there: the best and the worst of them bound what the arm can do from one side only, and move on
with more poses; their mean does not. The tool may stand in any direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.laws.normal_length import normal_length
from lostmotion.studies.analytic.analytic import analytic
from lostmotion.studies.budget import Cost, Tally, costs
from lostmotion.studies.intervals import Estimate, student
from lostmotion.studies.poses import REPLICATES, Poses
from lostmotion.studies.screws import screws
from lostmotion.studies.zones.boxes import Boxes, best_boxes, keeping_clear
from lostmotion.studies.zones.cells import within
from lostmotion.studies.zones.reach import Reached, reach, reach_points

if TYPE_CHECKING:
    from lostmotion.arm import Arm
    from lostmotion.spatial import Floats
    from lostmotion.studies.zones.reach import Progress

By = Literal["best", "mean", "worst"]
BYS: Final[tuple[By, ...]] = get_args(By)
MEAN, QUANTILE = 0, 1
SAMPLED: Final = 131_072
PER_CELL: Final = 8
# Poses looked at anew in a box are brought there from a smaller sample.
_AFRESH: Final = 32_768
_CHUNK: Final = 65_536
# What the departure from the normal law may add, as a share, for a figure to be told with it added.
_QUITE_NORMAL: Final = 0.25
_BLOCK: Final = 1024
_MOST_IN_BUDGET: Final = 16_384


@dataclass(frozen=True, repr=False)
class Errors:
    """The position error at each of many poses, m: its mean and what a share of it stays below.

    told      (pose,) whether the error is near enough to normal for both figures as they are
    careful   (pose,) where it is not quite, the quantile is that of the normal law with the same mean vector and covariance, raised by what
              the departure from it may add, where that is a quarter at most
    The rest have bounds instead: the mean lies below the root mean square, and a share `level` below root(mean square / (1 - level)) (Chebyshev)
    and below the worst case.
    """

    mean: Floats
    quantile: Floats
    told: np.ndarray
    careful: np.ndarray

    @property
    def known(self) -> np.ndarray:
        """Tell which poses have figures, not bounds alone."""
        return np.asarray(self.told | self.careful)


def errors(arm: Arm, q: Floats, level: float, *, approach: float = 0.0, threads: int = 1, progress: Progress | None = None) -> Errors:
    """How far off is the tool at each of these poses, by sums over terms?"""
    count = len(q)
    mean, quantile, told, careful = np.empty(count), np.empty(count), np.empty(count, bool), np.zeros(count, bool)
    for start in range(0, count, _CHUNK):
        here = slice(start, min(start + _CHUNK, count))
        if progress is not None:
            progress("summing up terms", start, count)
        found = analytic(arm, Poses(q[here], "given"), approach=approach, levels=(level,), threads=threads)
        told[here] = np.isfinite(found.mean) & np.isfinite(found.quantiles[:, 0])
        square = found.mean_square
        mean[here] = np.where(np.isfinite(found.mean), found.mean, np.sqrt(square))
        quantile[here] = np.where(told[here], found.quantiles[:, 0], np.minimum(np.sqrt(square / (1 - level)), found.worst))
        rest = np.flatnonzero(~told[here])
        if len(rest):
            normal = normal_length(found.bias[rest], found.covariance[rest], (level,)).quantiles[:, 0]
            left = found.quantiles_bound[rest, 0]
            near = np.isfinite(left) & (left <= _QUITE_NORMAL * normal)
            careful[here][rest] = near
            quantile[here][rest[near]] = np.minimum(normal + left, quantile[here][rest])[near]
    return Errors(mean, quantile, told, careful)


def by_cell(found: Errors, cell: np.ndarray, cells: int, kept: np.ndarray | None = None) -> Floats:
    """What are mean and quantile (measure, by, cell) of each of so many cells by its best, mean and worst pose? NaN where it has none.

    cell (pose,) is the cell of each pose; `kept` (pose,) looks at some poses alone. Poses with bounds alone are left out where a cell has others.
    """
    use = np.ones(len(cell), bool) if kept is None else kept
    some_known = np.bincount(cell[use & found.known], minlength=cells) > 0
    chosen = np.flatnonzero(use & (found.known | ~some_known[cell]))
    chosen = chosen[np.argsort(cell[chosen], kind="stable")]
    out = np.full((2, len(BYS), cells), np.nan)
    if not len(chosen):
        return out
    at = cell[chosen]
    begins = np.flatnonzero(np.r_[True, at[1:] != at[:-1]])
    sizes = np.diff(np.r_[begins, len(at)])
    for measure, values in ((MEAN, found.mean[chosen]), (QUANTILE, found.quantile[chosen])):
        low, high = np.minimum.reduceat(values, begins), np.maximum.reduceat(values, begins)
        out[measure][:, at[begins]] = low, np.clip(np.add.reduceat(values, begins) / sizes, low, high), high
    return out


@dataclass(frozen=True, repr=False)
class Looked:
    """The poses by the cells that they reach, and the error of each; `level` is the share that the quantile is of."""

    reached: Reached
    level: float
    errors: Errors

    @property
    def bounded(self) -> np.ndarray:
        """Tell which cells (cell,) have poses, but bounds alone for all of them."""
        count = int(np.prod(self.reached.grid.shape))
        some, known = (np.bincount(self.reached.cell[kept], minlength=count) > 0 for kept in (slice(None), self.errors.known))
        return np.asarray(some & ~known)

    def poses_of(self, cells: np.ndarray, by: By, figures: Floats) -> np.ndarray:
        """Which poses do these cells' figures (cell numbers, of `figures`) rest on? The best or the worst of each, or all."""
        mine = np.isin(self.reached.cell, cells) & (self.errors.known | self.bounded[self.reached.cell])
        if by == "mean":
            return np.flatnonzero(mine)
        same = np.flatnonzero(mine & (self.errors.quantile == figures[QUANTILE, BYS.index(by)][self.reached.cell]))
        return same[np.unique(self.reached.cell[same], return_index=True)[1]]


@dataclass(frozen=True, slots=True)
class Within:
    """How much of the workspace is within the target: the share, and its size (m^3, in a plane m^2, on a line m).

    The share's interval holds what the choice of poses leaves (independent sets, jackknife, 95 %) and the change to cells of twice the edge.
    """

    target: float
    share: Estimate
    size: Estimate
    cells: np.ndarray


@dataclass(frozen=True, slots=True)
class ZoneBudget:
    """What each part costs in a zone, over the poses that its cells' figures rest on: exact sums over terms."""

    zone: str
    cells: int
    poses: int
    rms: float
    costs: tuple[Cost, ...]


@dataclass(frozen=True, repr=False)
class Zones:
    """The accuracy map of an arm; figures (measure, by, x, y, z) in m with NaN where no pose was found.

    looked    every pose with its error; size of the whole workspace as `Within.size`, from cells all of whose neighbours are reached to all reached
    bounded   (x, y, z) cells whose figures are bounds, none of their poses being near enough to normal
    """

    arm: Arm
    by: By
    per_cell: int
    seed: int
    approach: float
    looked: Looked
    figures: Floats
    bounded: np.ndarray
    size: Estimate
    within: Within | None
    boxes: Boxes | None
    budgets: tuple[ZoneBudget, ...]

    @property
    def level(self) -> float:
        """Give the share of errors that the quantile is of."""
        return self.looked.level

    @property
    def reached(self) -> Reached:
        """Give the poses by cell."""
        return self.looked.reached

    @property
    def shown(self) -> Floats:
        """Give the quantile (x, y, z) by the configuration asked for."""
        return np.asarray(self.figures[QUANTILE, BYS.index(self.by)])

    @property
    def centre(self) -> np.ndarray:
        """Tell which cells (x, y, z) were reached in their middle; where none was, all that were reached."""
        return _counted(self.reached)

    @property
    def best_place(self) -> Floats:
        """Give the middle (3,) of the best box, or where none was asked for or fits of the most accurate cell that others surround, m."""
        if self.boxes is not None and self.boxes.found:
            return self.boxes.found[0].centre
        inner = within(self.centre, self.reached.grid.flat)
        shown = np.where(inner if inner.any() else np.isfinite(self.shown), self.shown, np.nan)
        return np.asarray(self.reached.grid.centres(np.array([np.nanargmin(shown)]))[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class Wish:
    """What a map is asked for; lengths in m.

    cell         edge of the cells; None: chosen
    by, level    the configuration of the arm that a cell is judged by, and the share of errors that its figure stays below
    target       an error that is good enough
    box          three sides of the work to be placed; box_by_mean: by the mean of its cells, else by the worst; turned: at other yaws as well
    clear, floor the box keeps this far off the base's z axis, and above this height
    poses        how many are sampled; per_cell: how many are looked at in a cell
    """

    cell: float | None = None
    by: By = "mean"
    level: float = 0.95
    target: float | None = None
    box: tuple[float, float, float] | None = None
    box_by_mean: bool = False
    turned: bool = False
    clear: float = 0.0
    floor: float = -math.inf
    poses: int = SAMPLED
    per_cell: int = PER_CELL

    def __post_init__(self) -> None:
        """Refuse what cannot be asked for, in one message each."""
        if self.by not in BYS:
            raise refuse_argument("by", self.by, "one of " + ", ".join(BYS), 'by = "best"')
        self._refuse_kinds()
        if not 0.25 <= self.level <= 0.9995:  # noqa: PLR2004 - where the quadrature is sure, laws.normal_length
            raise refuse_argument("level", self.level, "a share from 0.25 to 0.9995", "level = 0.95")
        if self.target is not None and not (math.isfinite(self.target) and self.target > 0):
            raise refuse_argument("target", self.target, "a length above zero, m", "target = 0.0005")
        if self.box is not None and (len(self.box) != 3 or not all(math.isfinite(x) and x >= 0 for x in self.box) or not any(self.box)):  # noqa: PLR2004
            raise refuse_argument("box", self.box, "three lengths along x, y and z, m, one above zero at least", "box = (0.3, 0.2, 0.1)")
        if not (math.isfinite(self.clear) and self.clear >= 0):
            raise refuse_argument("clear", self.clear, "a length, zero or more, m", "clear = 0.2")
        if math.isnan(self.floor):
            raise refuse_argument("floor", self.floor, "a height, m", "floor = 0.0")
        if not 2 <= self.per_cell <= 1024:  # noqa: PLR2004 - best and worst of one are no two figures
            raise refuse_argument("per_cell", self.per_cell, "from 2 to 1024 poses", f"per_cell = {PER_CELL}")

    def _refuse_kinds(self) -> None:
        """Refuse lengths that are no numbers, and what only counts for a box where none is asked for."""
        for name in ("cell", "target", "clear", "floor"):
            if not isinstance(getattr(self, name), Real | None):
                raise refuse_argument(name, getattr(self, name), "a number of metres", f"{name} = 0.05")
        for name in ("box_by_mean", "turned", "clear", "floor"):
            if self.box is None and getattr(self, name) != type(self).__dataclass_fields__[name].default:
                raise refuse_argument(name, getattr(self, name), "a box beside it, which alone it counts for", "box = (0.3, 0.2, 0.1)")


def zones(
    arm: Arm,
    wish: Wish,
    *,
    seed: int = 1,
    approach: float = 0.0,
    threads: int = 1,
    progress: Progress | None = None,
) -> Zones:
    """How accurate is this arm in each cell of its workspace, and where should work stand?

    `approach` and `threads` as in `analytic.analytic`; threads change no bit. Errors of position over all robots and visits, by sums over terms.
    Raises InputError for cells too small, and for a box that has a side along an axis that the tool cannot move along.
    """
    tell = progress or (lambda *_: None)
    reached = reach(arm, wish.poses, wish.cell, wish.per_cell, seed, threads=threads, progress=tell)
    looked = Looked(reached, wish.level, errors(arm, reached.q, wish.level, approach=approach, threads=threads, progress=tell))
    shape = reached.grid.shape
    figures = by_cell(looked.errors, reached.cell, int(np.prod(shape)))
    shown = figures[QUANTILE, BYS.index(wish.by)]
    centre = _counted(reached)
    size = _size(reached)
    share = None if wish.target is None else _within(looked, wish.by, wish.target, shown, centre, size)
    boxes = None
    if wish.box is not None:
        tell("looking for places", 0, 1)

        def afresh(points: Floats) -> tuple[Floats, int]:
            q, at = reach_points(arm, points, _AFRESH, wish.per_cell, seed + 1, reached.grid.edge, threads)
            new = errors(arm, q, wish.level, approach=approach, threads=threads)
            return by_cell(new, at, len(points))[QUANTILE, BYS.index(wish.by)], len(q)

        allowed = keeping_clear(reached.grid, wish.clear, wish.floor)
        boxes = best_boxes(arm, reached, shown.reshape(shape), wish.box, allowed, by_mean=wish.box_by_mean, turned=wish.turned, afresh=afresh)
    wanted: dict[str, np.ndarray] = {}
    if boxes is not None and boxes.found:
        wanted["best box"] = boxes.found[0].cells
    if share is not None and share.cells.any():
        wanted["within the target"] = np.flatnonzero(share.cells)
    wanted["all cells"] = np.flatnonzero(np.isfinite(shown))
    tell("adding up parts", 0, 1)
    budgets = tuple(_budget(arm, looked, name, cells, wish.by, figures, approach) for name, cells in wanted.items())
    return Zones(
        arm,
        wish.by,
        wish.per_cell,
        seed,
        approach,
        looked,
        figures.reshape(2, len(BYS), *shape),
        looked.bounded.reshape(shape),
        size,
        share,
        boxes,
        budgets,
    )


def _counted(reached: Reached) -> np.ndarray:
    """Which cells (x, y, z) count: those reached in their middle; where none was, all that were reached."""
    return reached.centre if reached.centre.any() else np.asarray(reached.counts > 0)


def _size(reached: Reached) -> Estimate:
    """How large is the workspace? The cells reached in their middle; at least those surrounded by such, at most all that were reached."""
    visited = reached.counts > 0
    centre, inner = reached.centre, within(visited, reached.grid.flat)
    # A surface has cells that are reached, hardly one of them in its middle, and no size.
    return Estimate(*(float(np.count_nonzero(cells)) * reached.grid.cell_size for cells in (centre, inner & centre, visited)))


def _within(looked: Looked, by: By, target: float, shown: Floats, centre: np.ndarray, size: Estimate) -> Within:
    """Which cells are within the target, and how sure is their share?"""
    reached, column = looked.reached, BYS.index(by)
    counted = np.flatnonzero(centre)

    def share(figures: Floats) -> float:
        known = figures[np.isfinite(figures)]
        return float(np.mean(known <= target)) if len(known) else math.nan

    value = share(shown[counted])
    cells = int(np.prod(reached.grid.shape))
    left_out = [share(by_cell(looked.errors, reached.cell, cells, reached.members != one)[QUANTILE, column][counted]) for one in range(REPLICATES)]
    pseudo = REPLICATES * value - (REPLICATES - 1) * np.array(left_out)
    of_poses = student(REPLICATES - 1) * float(pseudo.std(ddof=1)) / math.sqrt(REPLICATES)
    # Cells of twice the edge, each with the mean of those that it is made of.
    grid = reached.grid
    at = np.column_stack(np.unravel_index(counted, grid.shape)) + np.where(grid.flat, 0, np.array(grid.first))
    of_parent = np.unique(at // 2, axis=0, return_inverse=True)[1].ravel()
    known = np.isfinite(shown[counted])
    sums, members = np.bincount(of_parent[known], shown[counted][known]), np.bincount(of_parent[known])
    coarse = np.where(known, sums[of_parent] / np.maximum(members[of_parent], 1), np.nan)
    half = math.hypot(of_poses, share(coarse) - value)
    low, high = max(value - half, 0.0), min(value + half, 1.0)
    estimate = Estimate(value, low, high)
    return Within(target, estimate, Estimate(value * size.value, low * size.low, high * size.high), (shown <= target).reshape(grid.shape))


def _budget(arm: Arm, looked: Looked, name: str, cells: np.ndarray, by: By, figures: Floats, approach: float) -> ZoneBudget:
    """What does each part cost in a zone, over at most so many of its poses in equal steps?"""
    which = looked.poses_of(cells, by, figures)
    which = which[np.unique(np.linspace(0, len(which) - 1, min(len(which), _MOST_IN_BUDGET)).astype(int))]
    q = looked.reached.q[which]
    tally = Tally.of(screws(arm, q[:_BLOCK], approach=approach))
    for start in range(_BLOCK, len(q), _BLOCK):
        tally = tally + Tally.of(screws(arm, q[start : start + _BLOCK], approach=approach))
    return ZoneBudget(name, len(cells), len(q), math.sqrt(tally.total / tally.poses), tuple(costs(tally)))
