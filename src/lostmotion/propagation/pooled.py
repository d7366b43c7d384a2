"""Figures of the study without sampling over all poses together.

They come from one histogram of magnitudes at Sobol points, as those of Monte Carlo come from one of
its samples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.error_bins import BINS
from lostmotion.error_model.intervals import Estimate, of_length, pooled_quantile, quantile, student
from lostmotion.error_model.pose_sets import blocks_of_sets
from lostmotion.error_model.remedies import STAGES, screws_at_stage
from lostmotion.error_model.small_counts import counting_floor
from lostmotion.mechanism.state import BLOCK
from lostmotion.propagation.analytic import (
    MOST_UNCERTAIN,
    Analytic,
    DrawnColumns,
    over_blocks,
)
from lostmotion.propagation.error_magnitude import BLOCKS, POINTS, POOLED_POINTS, TILE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Up to this number of poses, the pooled histogram uses POINTS points at each pose; above it,
# POOLED_POINTS.
_FEW: Final = 1024
# A standard deviation that is a smaller share of the mean is rounding, and counts as zero.
_ROUNDING: Final = 1e-12


@dataclass(frozen=True, slots=True)
class Pooled:
    """Figures of the error's magnitude over all poses, m: the mean, the quantiles at these levels,
    and the standard deviation.

    Each 95 % interval includes the uncertainty due to the choice of poses (from independent sets of
    poses) and that of the figures at the poses. Poses that the user gave have no uncertainty of
    choice. NaN where the uncertainty of the figures alone exceeds 5 % of the value.
    """

    levels: tuple[float, ...]
    mean: Estimate
    quantiles: tuple[Estimate, ...]
    deviation: Estimate


def pooled(
    arm: Arm,
    poses: Poses,
    analytic: Analytic,
    *,
    approach: float = 0.0,
    stage: str = STAGES[0],
    threads: int = 1,
) -> Pooled:
    """Return the figures over all these poses together; `analytic` are the figures at each of them.
    Other arguments as for `analytic`.
    """
    if len(poses) == 1:
        return _of_one(analytic)
    drawn = DrawnColumns(screws_at_stage(arm, poses.q[:TILE], stage, approach=approach))
    histogram = PooledHistogram(poses)
    blocks = histogram.blocks(BLOCK)

    def count(matrix: PoseMatrix) -> NDArray[np.int64]:
        return drawn.pooled_counts(matrix, histogram.points)

    for block, counts in zip(
        blocks, over_blocks(arm, poses.q, blocks, (stage, approach), threads, count), strict=True
    ):
        histogram.add(block, counts)
    return histogram.figures(analytic)


class PooledHistogram:
    """Histogram of the error's magnitude over all poses, block by block.

    points  Sobol points at each pose, for `Drawn.pooled_counts`
    """

    def __init__(self, poses: Poses) -> None:
        """Begin without magnitudes."""
        self.points: Final = POINTS if len(poses) <= _FEW else POOLED_POINTS
        self._sets = poses.replicates
        self._each = len(poses) // self._sets
        self._by_block, self._by_set = (
            np.zeros((BLOCKS, BINS), np.int64),
            np.zeros((self._sets, BINS), np.int64),
        )

    def blocks(self, most: int) -> list[slice]:
        """Return blocks of at most this number of poses, each within one of the independent
        sets.
        """
        return blocks_of_sets(self._sets * self._each, self._sets, most)

    def add(self, block: slice, counts: NDArray[np.int64]) -> None:
        """Add the numbers of magnitudes in each bin (block of points, bin) at the poses of a
        block.
        """
        self._by_block += counts
        self._by_set[block.start // self._each] += counts.sum(axis=0)

    def figures(self, analytic: Analytic) -> Pooled:
        """Return the figures over all poses, once each block is added; `analytic` are those at
        each pose.
        """
        of_sets, least = (
            analytic.mean.reshape(self._sets, -1).mean(axis=1),
            counting_floor(analytic.mean, self._sets),
        )
        mean = _estimate(
            float(analytic.mean.mean()), float(analytic.mean_uncertainty.mean()), of_sets, least
        )
        largest = float(analytic.worst.max())
        quantiles = tuple(
            _quantile(self._by_block, self._by_set, level, largest) for level in analytic.levels
        )
        return Pooled(analytic.levels, mean, quantiles, _deviation(analytic, self._sets))


def _of_one(analytic: Analytic) -> Pooled:
    """Return the figures over all poses for a single pose, which are its own."""
    alone = np.zeros(1)
    return Pooled(
        analytic.levels,
        _estimate(float(analytic.mean[0]), float(analytic.mean_uncertainty[0]), alone),
        tuple(
            _estimate(float(value), float(off), alone)
            for value, off in zip(
                analytic.quantiles[0], analytic.quantiles_uncertainty[0], strict=True
            )
        ),
        _estimate(float(analytic.deviation[0]), float(analytic.deviation_uncertainty[0]), alone),
    )


def _estimate(value: float, uncertainty: float, of_sets: Floats, least: float = 0.0) -> Estimate:
    """Return a value with an interval for its uncertainty and for the choice of poses (from its
    values by set); NaN if the former exceeds 5 %.

    least  smallest half-width for the choice of poses
    """
    if not uncertainty <= MOST_UNCERTAIN * value:
        return Estimate(math.nan, math.nan, math.nan)
    sets = len(of_sets)
    chosen = student(sets - 1) * float(of_sets.std(ddof=1)) / math.sqrt(sets) if sets > 1 else 0.0
    half = math.hypot(uncertainty, max(chosen, least))
    return of_length(value, value - half, value + half)


def _deviation(analytic: Analytic, sets: int) -> Estimate:
    """Return the standard deviation over all poses, from the mean variance plus the variance of the
    means; interval by the delta method over sets.
    """
    variances = analytic.deviation**2 + (analytic.mean - analytic.mean.mean()) ** 2
    value = math.sqrt(float(variances.mean()))
    if value <= _ROUNDING * float(analytic.mean.mean()):
        return Estimate(0.0, 0.0, 0.0)
    uncertainty = np.maximum(analytic.deviation_uncertainty, analytic.mean_uncertainty)
    return _estimate(
        value, float(uncertainty.mean()), variances.reshape(sets, -1).mean(axis=1) / (2 * value)
    )


def _quantile(
    by_block: NDArray[np.int64], by_set: NDArray[np.int64], level: float, largest: float
) -> Estimate:
    """Return a quantile of the magnitude over all poses (m), from counts by block of points and by
    set of poses.
    """
    whole = by_block.sum(axis=0)
    alone, found = (
        pooled_quantile(by_block, sets, level, largest) for sets in (whole[None], by_set)
    )
    # One point more or less at each pose reveals a gap in the distribution, where the blocks would
    # agree by chance.
    low, high = (quantile(whole, level + by / POOLED_POINTS) for by in (-1, 1))
    low, high = min(alone.low, low), min(max(alone.high, high), max(largest, alone.high))
    if max(found.value - low, high - found.value) > MOST_UNCERTAIN * found.value:
        return Estimate(math.nan, math.nan, math.nan)
    return Estimate(found.value, min(found.low, low), max(found.high, high))
