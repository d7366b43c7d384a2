"""Which share of the workspace is within a target, and how large is the workspace? From points of space drawn evenly, each looked at afresh.

Middles of cells are no sample of the points between them: no cell may be within a target that some points of cells keep. Points drawn evenly are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.workspace_map.cell_statistics import BYS, By, by_cell, ends_by_cell, errors
from lostmotion.analyses.workspace_map.cells import near
from lostmotion.analyses.workspace_map.reach import brought_to, reach_points
from lostmotion.error_model.intervals import Estimate

if TYPE_CHECKING:
    from lostmotion.analyses.workspace_map.reach import Progress, Reached
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Points drawn, and poses sampled from which the tool is brought to them.
_POINTS: Final = 2048
SAMPLED: Final = 32_768
# Of an interval that an error of either side leaves equally often.
_TAIL: Final = 0.025


@dataclass(frozen=True, repr=False)
class Afresh:
    """Points drawn evenly over the cells that the tool reaches and those that touch them; figures of the ones in reach.

    region   size of those cells, m^3 (in a plane m^2, on a line m); drawn: how many points
    points   (point, 3) that were reached, m
    poses    how many configurations were looked at there, none of them the map's
    figures  (measure, by, point) m; ends (end, measure, by, point) between which each lies, as `by_cell.ends_by_cell`, the best's and the worst's
             over the configurations that were looked at
    """

    region: float
    drawn: int
    points: Floats
    poses: int
    figures: Floats
    ends: Floats

    @property
    def size(self) -> Estimate:
        """Tell how large the workspace is."""
        return self._of(len(self.points), len(self.points), len(self.points))

    def share(self, measure: int, by: By, target: float) -> tuple[Estimate, Estimate]:
        """How much of the workspace is within a target (m): the share, and its size?

        The intervals are those of Clopper and Pearson (Biometrika 26 (1934) 404), from the count of points that are surely within it, whatever the
        bounds of their figures, to that of points that may be. Evenly drawn points know no less than independent ones, which these are for.
        """
        column = BYS.index(by)
        sure, value, may = (int(np.count_nonzero(each[measure, column] <= target)) for each in (self.ends[1], self.figures, self.ends[0]))
        count = len(self.points)
        return Estimate(value / count, _least(sure, count), _most(may, count)), self._of(sure, value, may)

    def quantile(self, measure: int, by: By, share: float) -> Estimate:
        """Which figure (m) does this share of the workspace stay within? Between order statistics, whatever the law; NaN of too few points."""
        from scipy.stats import binom

        column, count = BYS.index(by), len(self.points)
        value = float(np.quantile(self.figures[measure, column], share))
        ranks = int(binom.ppf(_TAIL, count, share)) - 1, int(binom.ppf(1 - _TAIL, count, share))
        low, high = (
            float(np.sort(ends[measure, column])[rank]) if 0 <= rank < count else np.nan for rank, ends in zip(ranks, self.ends, strict=True)
        )
        return Estimate(value, low, high)

    def _of(self, sure: int, value: int, may: int) -> Estimate:
        return Estimate(self.region * value / self.drawn, self.region * _least(sure, self.drawn), self.region * _most(may, self.drawn))


def of_count(count: int, of: int) -> Estimate:
    """Which share is this count of so many draws, with its 95 % interval?"""
    return Estimate(count / of, _least(count, of), _most(count, of))


def _least(count: int, of: int) -> float:
    from scipy.stats import beta

    return float(beta.ppf(_TAIL, count, of - count + 1)) if count else 0.0


def _most(count: int, of: int) -> float:
    from scipy.stats import beta

    return float(beta.ppf(1 - _TAIL, count + 1, of - count)) if count < of else 1.0


def look_afresh(  # noqa: PLR0913 - a study is these numbers
    arm: Arm, reached: Reached, level: float, each: int, seed: int, *, approach: float = 0.0, threads: int = 1, progress: Progress | None = None
) -> Afresh | None:
    """How far off is the tool at points drawn evenly over the workspace? None where none is reached: the workspace is a surface, or next to nothing.

    Up to `each` configurations of every point, brought there from a sample of their own.
    """
    if progress is not None:
        progress("looking afresh", 0, 1)
    drawn, region = _drawn(reached, seed)
    q, done = brought_to(arm, reached, drawn, threads)
    points = drawn[done]
    if not len(points):
        return None
    new, at = reach_points(arm, points, SAMPLED, each, seed, reached.grid.edge, threads)
    # Points that the sample's poses were not brought to keep the pose that reached them.
    lost = np.setdiff1d(np.arange(len(points)), at)
    new, at = np.vstack([new, q[done][lost]]), np.r_[at, lost]
    order = np.argsort(at, kind="stable")
    new, at = new[order], at[order]
    found = errors(arm, new, level, approach=approach, threads=threads)
    ends = ends_by_cell(found, at, len(points), np.zeros(len(points), bool))
    return Afresh(region, len(drawn), points, len(new), by_cell(found, at, len(points)), ends)


def _drawn(reached: Reached, seed: int) -> tuple[Floats, float]:
    """Draw points (point, 3) evenly, m, over all cells in reach and those that touch them; and how large are these together?"""
    from scipy.stats import qmc

    grid = reached.grid
    cells = np.argwhere(near(np.pad(reached.counts > 0, [(0, 0) if still else (1, 1) for still in grid.flat])))
    cells -= np.where(grid.flat, 0, 1)
    draws = qmc.Sobol(4, scramble=True, rng=np.random.default_rng(seed)).random(_POINTS)
    low = cells[(draws[:, 0] * len(cells)).astype(int)]
    return np.asarray(grid.low + grid.edge * (low + np.where(grid.flat, 0.5, draws[:, 1:]))), len(cells) * grid.cell_size
