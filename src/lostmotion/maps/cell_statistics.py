"""Position errors at many poses, and the figures of grid cells by their best, mean and worst
pose.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from lostmotion.error_model.intervals import student
from lostmotion.error_model.poses import Poses
from lostmotion.error_model.trust import trusted
from lostmotion.mechanism.assembly import may_not_assemble
from lostmotion.propagation.analytic import analytic

if TYPE_CHECKING:
    from lostmotion.maps.reach import Progress
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

Configuration = Literal["best", "mean", "worst"]
CONFIGURATIONS: Final[tuple[Configuration, ...]] = get_args(Configuration)
MEAN, QUANTILE = 0, 1
_CHUNK: Final = 65_536


@dataclass(frozen=True, repr=False)
class PoseErrors:
    """Position error at each of many poses, m: mean and quantile.

    low, high (measure, pose) mean and quantile less and plus their uncertainty
    valid     (pose,) whether both figures are known to 5 %: a level may fall into a gap between the
              lengths of a few two-valued errors; and whether first order is valid
    """

    mean: Floats
    quantile: Floats
    low: Floats
    high: Floats
    valid: np.ndarray


def errors(
    arm: Arm,
    q: Floats,
    level: float,
    *,
    approach: float = 0.0,
    threads: int = 1,
    progress: Progress | None = None,
) -> PoseErrors:
    """Return the position errors at these poses by sums over terms, without sampling."""
    count = len(q)
    values, off = np.empty((2, 2, count))
    valid = np.empty(count, bool)
    for start in range(0, count, _CHUNK):
        here = slice(start, min(start + _CHUNK, count))
        if progress is not None:
            progress("summing up terms", start, count)
        found = analytic(
            arm, Poses(q[here], "given"), approach=approach, levels=(level,), threads=threads
        )
        values[:, here] = found.mean, found.quantiles[:, 0]
        off[:, here] = found.mean_uncertainty, found.quantiles_uncertainty[:, 0]
        # an open arm stands at these poses: `analytic` refuses any other
        valid[here] = found.valid & trusted(arm, q[here]) if may_not_assemble(arm) else found.valid
    return PoseErrors(
        values[MEAN], values[QUANTILE], np.maximum(values - off, 0.0), values + off, valid
    )


def cell_figures(pose_errors: PoseErrors, cell: np.ndarray, cells: int) -> Floats:
    """Return mean and quantile (measure, configuration, cell) of each cell by its best, mean and
    worst pose; NaN for cells without poses.

    `cell` (pose,) is the cell of each pose. Poses with invalid figures count only in cells without
    others.
    """
    chosen, begins = _chosen(pose_errors, cell, cells)
    return _over(
        np.stack([pose_errors.mean, pose_errors.quantile])[:, chosen], cell[chosen], begins, cells
    )


def bounds_by_cell(
    pose_errors: PoseErrors, cell: np.ndarray, cells: int, drawn: np.ndarray
) -> Floats:
    """Return lower and upper bounds (end, measure, configuration, cell) of the figures of
    `cell_figures`.

    `drawn` (cell,) marks cells whose poses are a sample of infinitely many configurations. The
    bounds of their mean include the 95 % confidence interval of a sample (Student; NaN for a single
    pose); the lower bound of their best and the upper bound of their worst pose are unknown (NaN).
    """
    chosen, begins = _chosen(pose_errors, cell, cells)
    out = np.stack(
        [
            _over(end[:, chosen], cell[chosen], begins, cells)
            for end in (pose_errors.low, pose_errors.high)
        ]
    )
    if not len(chosen):
        return out
    at = cell[chosen]
    sizes = np.diff(np.r_[begins, len(at)])
    factor = np.array(
        [
            np.nan,
            np.nan,
            *(student(n - 1) / np.sqrt(n * (n - 1)) for n in range(2, int(sizes.max()) + 1)),
        ]
    )[sizes]
    for measure, values in (
        (MEAN, pose_errors.mean[chosen]),
        (QUANTILE, pose_errors.quantile[chosen]),
    ):
        middle = np.add.reduceat(values, begins) / sizes
        square = np.add.reduceat((values - np.repeat(middle, sizes)) ** 2, begins)
        half = np.where(drawn[at[begins]], factor * np.sqrt(square), 0.0)
        out[0, measure, 1, at[begins]] = np.maximum(out[0, measure, 1, at[begins]] - half, 0.0)
        out[1, measure, 1, at[begins]] += half
    out[0, :, 0, drawn] = np.nan
    out[1, :, 2, drawn] = np.nan
    return out


def _chosen(pose_errors: PoseErrors, cell: np.ndarray, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the poses on which the cells' figures are based, sorted by cell, and the start of each
    cell among them.
    """
    some_valid = np.bincount(cell[pose_errors.valid], minlength=cells) > 0
    chosen = np.flatnonzero(pose_errors.valid | ~some_valid[cell])
    chosen = chosen[np.argsort(cell[chosen], kind="stable")]
    at = cell[chosen]
    return chosen, np.flatnonzero(np.r_[True, at[1:] != at[:-1]]) if len(at) else np.zeros(0, int)


def _over(values: Floats, at: np.ndarray, begins: np.ndarray, cells: int) -> Floats:
    """Return minimum, mean and maximum (measure, configuration, cell) of values (measure, pose) of
    poses sorted by cell, `at` (pose,).
    """
    out = np.full((2, len(CONFIGURATIONS), cells), np.nan)
    if len(at):
        sizes = np.diff(np.r_[begins, len(at)])
        low, high = (
            np.minimum.reduceat(values, begins, axis=1),
            np.maximum.reduceat(values, begins, axis=1),
        )
        out[:, :, at[begins]] = np.stack(
            [low, np.clip(np.add.reduceat(values, begins, axis=1) / sizes, low, high), high], axis=1
        )
    return out
