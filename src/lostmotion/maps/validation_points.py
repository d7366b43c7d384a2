"""Size of the workspace and share of it within a target, from points sampled uniformly in space and
evaluated independently of the map.

Cell centres do not represent the points between them: no cell may be within a target that some
points of the cells meet. Uniform points do.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.share_intervals import share_interval
from lostmotion.error_model.sobol import Sobol
from lostmotion.maps.cell_statistics import (
    CONFIGURATIONS,
    Configuration,
    bounds_by_cell,
    cell_figures,
    errors,
)
from lostmotion.maps.cells import dilated
from lostmotion.maps.configurations import configurations_at, solve_positions
from lostmotion.mechanism.standing import falls_at

if TYPE_CHECKING:
    from lostmotion.maps.cells import CellPoses
    from lostmotion.maps.reach import Progress
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Two to this power points; sampled poses from which their configurations are solved.
_POWER: Final = 11
SAMPLED: Final = 32_768
# Probability beyond either limit of an interval.
_TAIL: Final = 0.025


@dataclass(frozen=True, repr=False)
class ValidationPoints:
    """Points sampled uniformly over the reachable cells and those that touch them, with the figures
    of the reachable ones.

    region   size of those cells, m^3 (in a plane m^2, on a line m)
    drawn    number of sampled points
    points   (point, 3) reachable ones, m
    poses    number of configurations evaluated there, none of them from the map
    figures  (measure, by, point) m
    bounds   (end, measure, by, point) lower and upper bounds, as `bounds_by_cell`; best and worst
             refer to the evaluated configurations
    """

    region: float
    drawn: int
    points: Floats
    poses: int
    figures: Floats
    bounds: Floats

    @property
    def size(self) -> Estimate:
        """Return the size of the workspace."""
        return _within((len(self.points),) * 3, self.drawn, self.region)

    def share(self, measure: int, by: Configuration, target: float) -> tuple[Estimate, Estimate]:
        """Return the share of the workspace within a target (m), and its size.

        Clopper-Pearson intervals (Biometrika 26 (1934) 404). The lower limit counts the points
        whose upper bound is within the target, the upper limit those whose lower bound is. The
        points are a low-discrepancy sequence, which is at least as precise as the independent
        points that the intervals assume.
        """
        column = CONFIGURATIONS.index(by)
        low, value, high = (
            int(np.count_nonzero(each[measure, column] <= target))
            for each in (self.bounds[1], self.figures, self.bounds[0])
        )
        counts = low, value, high
        return _within(counts, len(self.points)), _within(counts, self.drawn, self.region)

    def quantile(self, measure: int, by: Configuration, share: float) -> Estimate:
        """Return the figure (m) below which this share of the workspace lies, with a
        distribution-free interval from order statistics.

        The limits are NaN for too few points.
        """
        from scipy.stats import binom

        column, count = CONFIGURATIONS.index(by), len(self.points)
        value = float(np.quantile(self.figures[measure, column], share))
        ranks = int(binom.ppf(_TAIL, count, share)) - 1, int(binom.ppf(1 - _TAIL, count, share))
        low, high = (
            float(np.sort(bounds[measure, column])[rank]) if 0 <= rank < count else np.nan
            for rank, bounds in zip(ranks, self.bounds, strict=True)
        )
        return Estimate(value, low, high)


def _within(counts: tuple[int, int, int], of: int, whole: float = 1.0) -> Estimate:
    """Return the part of a whole that `value` of so many draws are, with limits from the fewest and
    the most that are uncertain: `counts` is (low, value, high).
    """
    low, value, high = counts
    return Estimate(
        whole * value / of,
        whole * share_interval(low, of, method="exact")[0],
        whole * share_interval(high, of, method="exact")[1],
    )


def of_count(count: int, of: int) -> Estimate:
    """Return the proportion of `count` in `of` draws, with its 95 % confidence interval."""
    return Estimate(count / of, *share_interval(count, of, method="exact"))


def validate(  # noqa: PLR0913 - a study is these numbers
    arm: Arm,
    reached: CellPoses,
    level: float,
    each: int,
    seed: int,
    *,
    approach: float = 0.0,
    threads: int = 1,
    progress: Progress | None = None,
) -> ValidationPoints | None:
    """Return the errors at points sampled uniformly over the workspace; None where none is
    reachable, as for a workspace without volume.

    Up to `each` configurations of every point, solved from a sample of their own.
    """
    if progress is not None:
        progress("evaluating validation points", 0, 1)
    drawn, region = _points_label(reached, seed)
    q, done = solve_positions(arm, reached, drawn, threads)
    points = drawn[done]
    if not len(points):
        return None
    new, at = configurations_at(arm, points, SAMPLED, each, seed, reached.grid.edge, threads)
    # Points not reached from this sample keep the pose that reached them first.
    lost = np.setdiff1d(np.arange(len(points)), at)
    new, at = np.vstack([new, q[done][lost]]), np.r_[at, lost]
    order = np.argsort(at, kind="stable")
    order = order[falls_at(arm, new[order]) < 0]  # a soft arm has no figure where it falls
    new, at = new[order], at[order]
    found = errors(arm, new, level, approach=approach, threads=threads)
    bounds = bounds_by_cell(found, at, len(points), np.zeros(len(points), bool))
    return ValidationPoints(
        region, len(drawn), points, len(new), cell_figures(found, at, len(points)), bounds
    )


def _points_label(reached: CellPoses, seed: int) -> tuple[Floats, float]:
    """Return points (point, 3) sampled uniformly over all reachable cells and those that touch
    them, m, and the total size of these cells.
    """
    grid = reached.grid
    cells = np.argwhere(
        dilated(np.pad(reached.counts > 0, [(0, 0) if still else (1, 1) for still in grid.flat]))
    )
    cells -= np.where(grid.flat, 0, 1)
    draws = Sobol.scrambled(4, np.random.default_rng(seed)).points(_POWER)
    low = cells[(draws[:, 0] * len(cells)).astype(int)]
    return np.asarray(grid.low + grid.edge * (low + np.where(grid.flat, 0.5, draws[:, 1:]))), len(
        cells
    ) * grid.cell_size
