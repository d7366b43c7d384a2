"""How far off is the tool at many poses, and what does that make of cells: their best, mean and worst pose, with the ends of what each may be?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from lostmotion.error_model.intervals import student
from lostmotion.error_model.poses import Poses
from lostmotion.propagation.analytic import analytic

if TYPE_CHECKING:
    from lostmotion.analyses.workspace_map.reach import Progress
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

By = Literal["best", "mean", "worst"]
BYS: Final[tuple[By, ...]] = get_args(By)
MEAN, QUANTILE = 0, 1
_CHUNK: Final = 65_536


@dataclass(frozen=True, repr=False)
class Errors:
    """The position error at each of many poses, m: its mean and what a share of it stays below.

    low, high (measure, pose) between which mean and quantile lie: figures less and plus their uncertainty
    valid     (pose,) whether both figures are known to 5 %: a level may fall into a gap between the lengths of a few two-sided errors
    """

    mean: Floats
    quantile: Floats
    low: Floats
    high: Floats
    valid: np.ndarray


def errors(arm: Arm, q: Floats, level: float, *, approach: float = 0.0, threads: int = 1, progress: Progress | None = None) -> Errors:
    """Return how far off the tool is at each of these poses, by sums over terms."""
    count = len(q)
    values, off = np.empty((2, 2, count))
    valid = np.empty(count, bool)
    for start in range(0, count, _CHUNK):
        here = slice(start, min(start + _CHUNK, count))
        if progress is not None:
            progress("summing up terms", start, count)
        found = analytic(arm, Poses(q[here], "given"), approach=approach, levels=(level,), threads=threads)
        values[:, here] = found.mean, found.quantiles[:, 0]
        off[:, here] = found.mean_uncertainty, found.quantiles_uncertainty[:, 0]
        valid[here] = found.valid
    return Errors(values[MEAN], values[QUANTILE], np.maximum(values - off, 0.0), values + off, valid)


def by_cell(found: Errors, cell: np.ndarray, cells: int) -> Floats:
    """What are mean and quantile (measure, by, cell) of each of so many cells by its best, mean and worst pose? NaN where it has none.

    cell (pose,) is the cell of each pose. Poses whose figures are not valid are left out where a cell has others.
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
    some_valid = np.bincount(cell[found.valid], minlength=cells) > 0
    chosen = np.flatnonzero(found.valid | ~some_valid[cell])
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
