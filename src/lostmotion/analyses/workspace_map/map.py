"""How accurate is the arm in each cell of its workspace, which share of that is good enough, and which part is to blame where?

Every figure of a cell is over the poses looked at there: the best and the worst of them bound what the arm can do from one side only, and move on
with more poses; their mean does not. The tool may stand in any direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.workspace_map.cell_statistics import BYS, QUANTILE, By, Errors, by_cell, ends_by_cell, errors
from lostmotion.analyses.workspace_map.cells import within
from lostmotion.analyses.workspace_map.placement import Boxes, best_boxes, keeping_clear
from lostmotion.analyses.workspace_map.reach import Reached, reach, reach_points
from lostmotion.analyses.workspace_map.validation_points import SAMPLED as SAMPLED_AFRESH
from lostmotion.analyses.workspace_map.validation_points import Afresh, look_afresh, of_count
from lostmotion.error_model.budget import Cost, Tally, costs
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.pose_matrix import screws
from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from lostmotion.analyses.workspace_map.reach import Progress
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

SAMPLED: Final = 131_072
PER_CELL: Final = 8
_BLOCK: Final = 1024
_MOST_IN_BUDGET: Final = 16_384


@dataclass(frozen=True, repr=False)
class Looked:
    """The poses by the cells that they reach, and the error of each; `level` is the share that the quantile is of."""

    reached: Reached
    level: float
    errors: Errors

    @property
    def uncertain(self) -> np.ndarray:
        """Return which cells (cell,) have poses, but a valid figure at none of them."""
        count = int(np.prod(self.reached.grid.shape))
        some, valid = (np.bincount(self.reached.cell[kept], minlength=count) > 0 for kept in (slice(None), self.errors.valid))
        return np.asarray(some & ~valid)

    def poses_of(self, cells: np.ndarray, by: By, figures: Floats) -> np.ndarray:
        """Which poses do these cells' figures (cell numbers, of `figures`) rest on? The best or the worst of each, or all."""
        mine = np.isin(self.reached.cell, cells) & (self.errors.valid | self.uncertain[self.reached.cell])
        if by == "mean":
            return np.flatnonzero(mine)
        same = np.flatnonzero(mine & (self.errors.quantile == figures[QUANTILE, BYS.index(by)][self.reached.cell]))
        return same[np.unique(self.reached.cell[same], return_index=True)[1]]


@dataclass(frozen=True, slots=True)
class Within:
    """How much of the workspace is within the target: the share, and its size (m^3, in a plane m^2, on a line m), as `Afresh.share`.

    Where no point could be looked at afresh it is the share of the cells, with the interval as if those were drawn.
    cells   (x, y, z) whose figure is within the target
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

    ends      (end, measure, by, x, y, z) between which each figure lies, as `by_cell.ends_by_cell`
    looked    every pose with its error
    afresh    points drawn evenly over the workspace, with figures; None where none was reached
    size      of the whole workspace, as `Within.size`; without points afresh from cells all of whose neighbours are reached to all reached
    uncertain (x, y, z) cells at none of whose poses both figures are known to 5 %
    """

    arm: Arm
    by: By
    per_cell: int
    seed: int
    approach: float
    looked: Looked
    figures: Floats
    ends: Floats
    uncertain: np.ndarray
    afresh: Afresh | None
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
            raise refuse_argument("by", self.by, "one of " + ", ".join(BYS), by="best")
        self._refuse_kinds()
        if not 0.25 <= self.level <= 0.9995:  # noqa: PLR2004 - as `analytic`
            raise refuse_argument("level", self.level, "a share from 0.25 to 0.9995", level=0.95)
        if self.target is not None and not (math.isfinite(self.target) and self.target > 0):
            raise refuse_argument("target", self.target, "a length above zero, m", target=0.0005)
        if self.box is not None and (len(self.box) != 3 or not all(math.isfinite(x) and x >= 0 for x in self.box) or not any(self.box)):  # noqa: PLR2004
            raise refuse_argument("box", self.box, "three lengths along x, y and z, m, one above zero at least", box=(0.3, 0.2, 0.1))
        if not (math.isfinite(self.clear) and self.clear >= 0):
            raise refuse_argument("clear", self.clear, "a length, zero or more, m", clear=0.2)
        if math.isnan(self.floor):
            raise refuse_argument("floor", self.floor, "a height, m", floor=0.0)
        if not 2 <= self.per_cell <= 1024:  # noqa: PLR2004 - best and worst of one are no two figures
            raise refuse_argument("per_cell", self.per_cell, "from 2 to 1024 poses", per_cell=PER_CELL)

    def _refuse_kinds(self) -> None:
        """Refuse lengths that are no numbers, and what only counts for a box where none is asked for."""
        for name in ("cell", "target", "clear", "floor"):
            if not isinstance(getattr(self, name), Real | None):
                raise refuse_argument(name, getattr(self, name), "a number of metres", **{name: "50 mm"})
        for name in ("box_by_mean", "turned", "clear", "floor"):
            if self.box is None and getattr(self, name) != type(self).__dataclass_fields__[name].default:
                raise refuse_argument(name, getattr(self, name), "a box beside it, which alone it counts for", box=(0.3, 0.2, 0.1))


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

    `approach` and `threads` as in `analytic`; threads change no bit. Errors of position over all robots and visits, by sums over terms.
    Raises InputError for cells too small, and for a box that has a side along an axis that the tool cannot move along.
    """
    tell = progress or (lambda *_: None)
    reached = reach(arm, wish.poses, wish.cell, wish.per_cell, seed, threads=threads, progress=tell)
    looked = Looked(reached, wish.level, errors(arm, reached.q, wish.level, approach=approach, threads=threads, progress=tell))
    shape = reached.grid.shape
    cells = int(np.prod(shape))
    figures = by_cell(looked.errors, reached.cell, cells)
    # More joints than the point needs: a family of configurations without end, of which some are looked at.
    family = len(arm.tree.drives) > reached.grid.dimensions
    ends = ends_by_cell(looked.errors, reached.cell, cells, family | ~reached.centre.ravel())
    shown = figures[QUANTILE, BYS.index(wish.by)]
    centre = _counted(reached)
    new = look_afresh(arm, reached, wish.level, wish.per_cell, seed + 2, approach=approach, threads=threads, progress=tell)
    size = _size(reached) if new is None else new.size
    share = None if wish.target is None else _within(new, wish.by, wish.target, shown.reshape(shape), centre, size)
    boxes = None
    if wish.box is not None:
        tell("looking for places", 0, 1)

        column = BYS.index(wish.by)

        def afresh(points: Floats) -> tuple[Floats, Floats, int]:
            q, at = reach_points(arm, points, SAMPLED_AFRESH, wish.per_cell, seed + 1, reached.grid.edge, threads)
            found = errors(arm, q, wish.level, approach=approach, threads=threads)
            between = ends_by_cell(found, at, len(points), np.full(len(points), family))
            return by_cell(found, at, len(points))[QUANTILE, column], between[:, QUANTILE, column], len(q)

        allowed = keeping_clear(reached.grid, wish.clear, wish.floor)
        boxes = best_boxes(
            arm,
            reached,
            shown.reshape(shape),
            wish.box,
            allowed,
            ends=ends[:, QUANTILE, column],
            by_mean=wish.box_by_mean,
            turned=wish.turned,
            afresh=afresh,
        )
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
        ends.reshape(2, 2, len(BYS), *shape),
        looked.uncertain.reshape(shape),
        new,
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


def _within(new: Afresh | None, by: By, target: float, shown: Floats, centre: np.ndarray, size: Estimate) -> Within:
    """How much of the workspace is within the target, and which cells (x, y, z) are?"""
    cells = shown <= target
    if new is not None:
        return Within(target, *new.share(QUANTILE, by, target), cells)
    counted = centre & np.isfinite(shown)
    share = of_count(int(np.count_nonzero(cells & counted)), int(np.count_nonzero(counted)))
    return Within(target, share, Estimate(share.value * size.value, share.low * size.low, share.high * size.high), cells)


def _budget(arm: Arm, looked: Looked, name: str, cells: np.ndarray, by: By, figures: Floats, approach: float) -> ZoneBudget:
    """What does each part cost in a zone, over at most so many of its poses in equal steps?"""
    which = looked.poses_of(cells, by, figures)
    which = which[np.unique(np.linspace(0, len(which) - 1, min(len(which), _MOST_IN_BUDGET)).astype(int))]
    q = looked.reached.q[which]
    tally = Tally.of(screws(arm, q[:_BLOCK], approach=approach))
    for start in range(_BLOCK, len(q), _BLOCK):
        tally = tally + Tally.of(screws(arm, q[start : start + _BLOCK], approach=approach))
    return ZoneBudget(name, len(cells), len(q), math.sqrt(tally.total / tally.poses), tuple(costs(tally)))
