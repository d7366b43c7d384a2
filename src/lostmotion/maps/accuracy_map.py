"""Accuracy map of an arm: error in each cell of its workspace, share within a target, error budget
by zone, best placement for a task.

Figures of a cell refer to the evaluated poses. Best and worst pose are one-sided bounds that change
with more poses; the mean does not. Any orientation of the tool counts.
"""

from __future__ import annotations

import functools
import math
import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.budget import Cost, Tally, costs
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.pose_matrix import pose_matrices
from lostmotion.maps.cell_statistics import (
    CONFIGURATIONS,
    QUANTILE,
    Configuration,
    PoseErrors,
    bounds_by_cell,
    cell_figures,
    errors,
)
from lostmotion.maps.cells import CellPoses, interior
from lostmotion.maps.configurations import configurations_at
from lostmotion.maps.gain import gain_by_cell
from lostmotion.maps.placement import Placements, best_placements, clear_cells
from lostmotion.maps.reach import reachable_cells
from lostmotion.maps.validation_points import SAMPLED as VALIDATION_SAMPLES
from lostmotion.maps.validation_points import ValidationPoints, of_count, validate

if TYPE_CHECKING:
    from lostmotion.maps.reach import Progress
    from lostmotion.maps.request import MapRequest
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


_MOST_IN_BUDGET: Final = 16_384


@dataclass(frozen=True, repr=False)
class EvaluatedPoses:
    """Poses by cell with the position error at each; `level` is the probability of the quantile."""

    reached: CellPoses
    level: float
    errors: PoseErrors

    @property
    def uncertain(self) -> np.ndarray:
        """Return which cells (cell,) have poses, but a valid figure at none of them."""
        count = int(np.prod(self.reached.grid.shape))
        some, valid = (
            np.bincount(self.reached.cell[kept], minlength=count) > 0
            for kept in (slice(None), self.errors.valid)
        )
        return np.asarray(some & ~valid)

    def poses_of(self, cells: np.ndarray, by: Configuration, figures: Floats) -> np.ndarray:
        """Return the poses on which the figures of these cells (cell numbers) are based: the best
        or the worst of each, or all.
        """
        mine = np.isin(self.reached.cell, cells) & (
            self.errors.valid | self.uncertain[self.reached.cell]
        )
        if by == "mean":
            return np.flatnonzero(mine)
        same = np.flatnonzero(
            mine
            & (
                self.errors.quantile
                == figures[QUANTILE, CONFIGURATIONS.index(by)][self.reached.cell]
            )
        )
        return same[np.unique(self.reached.cell[same], return_index=True)[1]]


@dataclass(frozen=True, slots=True)
class ShareWithinTarget:
    """Share of the workspace within the target, and its size (m^3, in a plane m^2, on a line m), as
    `ValidationPoints.share`.

    Without validation points it is the share of the cells, with the interval of as many independent
    draws.
    cells   (x, y, z) whose figure is within the target
    """

    target: float
    share: Estimate
    size: Estimate
    cells: np.ndarray


@dataclass(frozen=True, slots=True)
class ZoneBudget:
    """Error budget of a zone over the poses on which its cells' figures are based: exact sums over
    terms.
    """

    zone: str
    cells: int
    poses: int
    rms: float
    costs: tuple[Cost, ...]


@dataclass(frozen=True, repr=False)
class WorkspaceMap:
    """The accuracy map of an arm; errors (measure, configuration, x, y, z) in m, NaN where no pose
    was found.

    bounds         (end, measure, configuration, x, y, z) lower and upper bounds of each figure, as
                   `bounds_by_cell`
    evaluated      every pose with its error
    validation     uniformly sampled points of the workspace with figures; None where none was
                   reached
    size           size of the whole workspace, as `ShareWithinTarget.size`; without validation
                   points from the cells
    uncertain      (x, y, z) cells without a pose at which both figures are known to 5 %
    gain           (x, y, z) as `gain_by_cell`; None for an open chain
    """

    arm: Arm
    by: Configuration
    per_cell: int
    seed: int
    approach: float
    evaluated: EvaluatedPoses
    errors: Floats
    bounds: Floats
    uncertain: np.ndarray
    validation: ValidationPoints | None
    size: Estimate
    within_target: ShareWithinTarget | None
    placements: Placements | None
    budgets: tuple[ZoneBudget, ...]
    gain: Floats | None

    @property
    def level(self) -> float:
        """Return the probability of the quantile."""
        return self.evaluated.level

    @property
    def reached(self) -> CellPoses:
        """Return the poses by cell."""
        return self.evaluated.reached

    @property
    def selected(self) -> Floats:
        """Return the quantile (x, y, z) for the selected configuration."""
        return np.asarray(self.errors[QUANTILE, CONFIGURATIONS.index(self.by)])

    @property
    def centre(self) -> np.ndarray:
        """Return which cells (x, y, z) were reached at their centre; where none was, all reached
        cells.
        """
        return _cells_with_figures(self.reached)

    @property
    def best_place(self) -> Floats:
        """Return the centre (3,) of the best placement, or without one of the most accurate cell
        surrounded by others, m.
        """
        if self.placements is not None and self.placements.best:
            return self.placements.best[0].centre
        inner = interior(self.centre, self.reached.grid.flat)
        eligible = np.where(
            inner if inner.any() else np.isfinite(self.selected), self.selected, np.nan
        )
        return np.asarray(self.reached.grid.centres(np.array([np.nanargmin(eligible)]))[0])


def map_workspace(
    arm: Arm,
    request: MapRequest,
    *,
    seed: int = 1,
    approach: float = 0.0,
    threads: int = 1,
    progress: Progress | None = None,
) -> WorkspaceMap:
    """Return the accuracy map of an arm, and the best placements of the requested box.

    `approach` and `threads` as in `analytic`; results do not depend on `threads`. Position errors
    over all robots and visits, by sums over terms. Raises InputError for cells too small, and for a
    box with a side along an axis that the tool cannot move along.
    """
    report = progress or (lambda *_: None)
    reached = reachable_cells(
        arm, request.poses, request.cell, request.per_cell, seed, threads=threads, progress=report
    )
    evaluated = EvaluatedPoses(
        reached,
        request.level,
        errors(arm, reached.q, request.level, approach=approach, threads=threads, progress=report),
    )
    shape = reached.grid.shape
    cells = int(np.prod(shape))
    figures = cell_figures(evaluated.errors, reached.cell, cells)
    # A redundant arm reaches a point in infinitely many configurations, of which these are a
    # sample.
    family = len(arm.tree.tool_joints) > reached.grid.dimensions
    bounds = bounds_by_cell(evaluated.errors, reached.cell, cells, family | ~reached.centre.ravel())
    shown = figures[QUANTILE, CONFIGURATIONS.index(request.by)]
    centre = _cells_with_figures(reached)
    validation = validate(
        arm,
        reached,
        request.level,
        request.per_cell,
        seed + 2,
        approach=approach,
        threads=threads,
        progress=report,
    )
    size = _size(reached) if validation is None else validation.size
    share = (
        None
        if request.target is None
        else _within(validation, request.by, request.target, shown.reshape(shape), centre, size)
    )
    placements = None
    if request.box is not None:
        report("searching for placements", 0, 1)

        column = CONFIGURATIONS.index(request.by)

        def at_points(points: Floats) -> tuple[Floats, Floats, int]:
            q, at = configurations_at(
                arm,
                points,
                VALIDATION_SAMPLES,
                request.per_cell,
                seed + 1,
                reached.grid.edge,
                threads,
            )
            found = errors(arm, q, request.level, approach=approach, threads=threads)
            between = bounds_by_cell(found, at, len(points), np.full(len(points), family))
            return (
                cell_figures(found, at, len(points))[QUANTILE, column],
                between[:, QUANTILE, column],
                len(q),
            )

        allowed = clear_cells(reached.grid, request.clear, request.floor)
        placements = best_placements(
            arm,
            reached,
            shown.reshape(shape),
            request.box,
            allowed,
            bounds=bounds[:, QUANTILE, column],
            by_mean=request.box_by_mean,
            turned=request.turned,
            validation=at_points,
        )
    zones: dict[str, np.ndarray] = {}
    if placements is not None and placements.best:
        zones["best box"] = placements.best[0].cells
    if share is not None and share.cells.any():
        zones["within the target"] = np.flatnonzero(share.cells)
    zones["all cells"] = np.flatnonzero(np.isfinite(shown))
    report("computing error budgets", 0, 1)
    budgets = tuple(
        _budget(arm, evaluated, name, cells, request.by, figures, approach)
        for name, cells in zones.items()
    )
    return WorkspaceMap(
        arm,
        request.by,
        request.per_cell,
        seed,
        approach,
        evaluated,
        figures.reshape(2, len(CONFIGURATIONS), *shape),
        bounds.reshape(2, 2, len(CONFIGURATIONS), *shape),
        evaluated.uncertain.reshape(shape),
        validation,
        size,
        share,
        placements,
        budgets,
        gain_by_cell(arm, reached),
    )


def _cells_with_figures(reached: CellPoses) -> np.ndarray:
    """Return the cells (x, y, z) that count: those reached at their centre; where none was, all
    reached cells.
    """
    return reached.centre if reached.centre.any() else np.asarray(reached.counts > 0)


def _size(reached: CellPoses) -> Estimate:
    """Return the size of the workspace: the cells reached at their centre; at least those
    surrounded by such, at most all reached cells.
    """
    visited = reached.counts > 0
    centre, inner = reached.centre, interior(visited, reached.grid.flat)
    # A surface has reached cells, hardly any of them at the centre, and no volume.
    return Estimate(
        *(
            float(np.count_nonzero(cells)) * reached.grid.cell_size
            for cells in (centre, inner & centre, visited)
        )
    )


def _within(
    validation: ValidationPoints | None,
    by: Configuration,
    target: float,
    shown: Floats,
    centre: np.ndarray,
    size: Estimate,
) -> ShareWithinTarget:
    """Return the share of the workspace within the target, and the cells (x, y, z) within it."""
    cells = shown <= target
    if validation is not None:
        return ShareWithinTarget(target, *validation.share(QUANTILE, by, target), cells)
    counted = centre & np.isfinite(shown)
    share = of_count(int(np.count_nonzero(cells & counted)), int(np.count_nonzero(counted)))
    return ShareWithinTarget(
        target,
        share,
        Estimate(share.value * size.value, share.low * size.low, share.high * size.high),
        cells,
    )


def _budget(
    arm: Arm,
    evaluated: EvaluatedPoses,
    name: str,
    cells: np.ndarray,
    by: Configuration,
    figures: Floats,
    approach: float,
) -> ZoneBudget:
    """Return the error budget of a zone, over at most so many of its poses in equal steps."""
    which = evaluated.poses_of(cells, by, figures)
    which = which[
        np.unique(np.linspace(0, len(which) - 1, min(len(which), _MOST_IN_BUDGET)).astype(int))
    ]
    q = evaluated.reached.q[which]
    blocks = (matrix for _, matrix in pose_matrices(arm, q, approach=approach))
    tally = functools.reduce(operator.add, map(Tally.of, blocks))
    return ZoneBudget(
        name, len(cells), len(q), math.sqrt(tally.total / tally.poses), tuple(costs(tally))
    )
