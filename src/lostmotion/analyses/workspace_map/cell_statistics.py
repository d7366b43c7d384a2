"""How far off is the tool at many poses, and what does that make of cells: their best, mean and worst pose, with the ends of what each may be?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from lostmotion.error_model.intervals import student
from lostmotion.error_model.poses import Poses
from lostmotion.laws.normal_length import normal_length
from lostmotion.propagation.analytic.analytic import analytic

if TYPE_CHECKING:
    from lostmotion.analyses.workspace_map.reach import Progress
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

By = Literal["best", "mean", "worst"]
BYS: Final[tuple[By, ...]] = get_args(By)
MEAN, QUANTILE = 0, 1
_CHUNK: Final = 65_536
# What the departure from the normal law may add, as a share, for a figure to be told with it added.
_QUITE_NORMAL: Final = 0.25


@dataclass(frozen=True, repr=False)
class Errors:
    """The position error at each of many poses, m: its mean and what a share of it stays below.

    low, high (measure, pose) between which mean and quantile lie: figures less and plus their bounds
    told      (pose,) whether the error is near enough to normal for both figures as they are
    careful   (pose,) where it is not quite, the quantile is that of the normal law with the same mean vector and covariance, raised by what
              the departure from it may add, where that is a quarter at most; its low end is the normal law's less that
    The rest have bounds instead: the mean lies between the length of the mean vector and the root mean square (Jensen), and a share `level` below
    root(mean square / (1 - level)) (Chebyshev) and the worst case; not below root((mean square - (1 - level) worst case^2) / level).
    """

    mean: Floats
    quantile: Floats
    low: Floats
    high: Floats
    told: np.ndarray
    careful: np.ndarray

    @property
    def known(self) -> np.ndarray:
        """Tell which poses have figures, not bounds alone."""
        return np.asarray(self.told | self.careful)


def errors(arm: Arm, q: Floats, level: float, *, approach: float = 0.0, threads: int = 1, progress: Progress | None = None) -> Errors:
    """How far off is the tool at each of these poses, by sums over terms?"""
    count = len(q)
    values, low, high = (np.empty((2, count)) for _ in range(3))
    told, careful = np.empty(count, bool), np.zeros(count, bool)
    for start in range(0, count, _CHUNK):
        here = slice(start, min(start + _CHUNK, count))
        if progress is not None:
            progress("summing up terms", start, count)
        found = analytic(arm, Poses(q[here], "given"), approach=approach, levels=(level,), threads=threads)
        quantile, left = found.quantiles[:, 0], found.quantiles_bound[:, 0]
        told[here] = np.isfinite(found.mean) & np.isfinite(quantile)
        square, known = found.mean_square, np.isfinite(found.mean)
        values[MEAN, here] = np.where(known, found.mean, np.sqrt(square))
        low[MEAN, here] = np.where(known, np.maximum(found.mean - found.mean_bound, 0.0), np.linalg.norm(found.bias, axis=1))
        high[MEAN, here] = np.where(known, found.mean + found.mean_bound, np.sqrt(square))
        most = np.minimum(np.sqrt(square / (1 - level)), found.worst)
        least = np.sqrt(np.maximum(square - (1 - level) * found.worst**2, 0.0) / level)
        values[QUANTILE, here] = np.where(told[here], quantile, most)
        low[QUANTILE, here] = np.where(told[here], np.maximum(quantile - left, 0.0), least)
        high[QUANTILE, here] = np.where(told[here], quantile + left, most)
        rest = np.flatnonzero(~told[here])
        if len(rest):
            normal = normal_length(found.bias[rest], found.covariance[rest], (level,)).quantiles[:, 0]
            near = np.isfinite(left[rest]) & (left[rest] <= _QUITE_NORMAL * normal)
            careful[here][rest] = near
            raised = rest[near] + start
            values[QUANTILE, raised] = np.minimum((normal + left[rest])[near], values[QUANTILE, raised])
            high[QUANTILE, raised] = values[QUANTILE, raised]
            low[QUANTILE, raised] = np.maximum((normal - left[rest])[near], low[QUANTILE, raised])
    return Errors(values[MEAN], values[QUANTILE], low, high, told, careful)


def by_cell(found: Errors, cell: np.ndarray, cells: int) -> Floats:
    """What are mean and quantile (measure, by, cell) of each of so many cells by its best, mean and worst pose? NaN where it has none.

    cell (pose,) is the cell of each pose. Poses with bounds alone are left out where a cell has others.
    """
    chosen, begins = _chosen(found, cell, cells)
    return _over(np.stack([found.mean, found.quantile])[:, chosen], cell[chosen], begins, cells)


def ends_by_cell(found: Errors, cell: np.ndarray, cells: int, drawn: np.ndarray) -> Floats:
    """Between which ends (end, measure, by, cell) does each figure of `by_cell` lie?

    drawn   (cell,) whether the poses of a cell are drawn out of a family without end. Then their mean has the 95 % interval of such a sample besides
            (Student; not known of one pose), and nothing is known of how much better the best pose is, nor of how much worse the worst
    """
    chosen, begins = _chosen(found, cell, cells)
    out = np.stack([_over(end[:, chosen], cell[chosen], begins, cells) for end in (found.low, found.high)])
    if not len(chosen):
        return out
    at = cell[chosen]
    sizes = np.diff(np.r_[begins, len(at)])
    factor = np.array([np.nan, np.nan, *(student(n - 1) / np.sqrt(n * (n - 1)) for n in range(2, int(sizes.max()) + 1))])[sizes]
    for measure, values in ((MEAN, found.mean[chosen]), (QUANTILE, found.quantile[chosen])):
        middle = np.add.reduceat(values, begins) / sizes
        square = np.add.reduceat((values - np.repeat(middle, sizes)) ** 2, begins)
        half = np.where(drawn[at[begins]], factor * np.sqrt(square), 0.0)
        out[0, measure, 1, at[begins]] = np.maximum(out[0, measure, 1, at[begins]] - half, 0.0)
        out[1, measure, 1, at[begins]] += half
    out[0, :, 0, drawn] = np.nan
    out[1, :, 2, drawn] = np.nan
    return out


def _chosen(found: Errors, cell: np.ndarray, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Which poses do the cells' figures rest on, by cell, and where among them does each cell begin?"""
    some_known = np.bincount(cell[found.known], minlength=cells) > 0
    chosen = np.flatnonzero(found.known | ~some_known[cell])
    chosen = chosen[np.argsort(cell[chosen], kind="stable")]
    at = cell[chosen]
    return chosen, np.flatnonzero(np.r_[True, at[1:] != at[:-1]]) if len(at) else np.zeros(0, int)


def _over(values: Floats, at: np.ndarray, begins: np.ndarray, cells: int) -> Floats:
    """Take least, mean and largest (measure, by, cell) of values (measure, pose) of poses that lie by cell, `at` (pose,)."""
    out = np.full((2, len(BYS), cells), np.nan)
    if len(at):
        sizes = np.diff(np.r_[begins, len(at)])
        low, high = np.minimum.reduceat(values, begins, axis=1), np.maximum.reduceat(values, begins, axis=1)
        out[:, :, at[begins]] = np.stack([low, np.clip(np.add.reduceat(values, begins, axis=1) / sizes, low, high), high], axis=1)
    return out
