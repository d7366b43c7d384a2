"""The study without sampling: mean vector and covariance of the error are exact sums over terms; `error_magnitude` gives the figures of its length.

Over all poses together the lengths at Sobol points are counted in one histogram, as Monte Carlo counts its samples.
"""

from __future__ import annotations

import functools
import math
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Lock
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from lostmotion.error_model.bounds import root_sum_square, worst_case
from lostmotion.error_model.cumulants import cumulants
from lostmotion.error_model.error_bins import BINS
from lostmotion.error_model.intervals import Estimate, of_length, pooled_quantile, quantile, student
from lostmotion.error_model.pose_matrix import PoseMatrix, screws
from lostmotion.error_model.poses import Poses
from lostmotion.errors import refuse_argument
from lostmotion.laws.distributions import COMPARED
from lostmotion.mechanism.serial import as_poses
from lostmotion.propagation.error_magnitude import (
    BLOCKS,
    LEVELS,
    POINTS,
    POOLED_POINTS,
    TILE,
    Magnitude,
    Plays,
    figures,
    pooled_counts,
    sobol_draws,
)
from lostmotion.propagation.montecarlo.memory import keep_freed

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterator, Sequence

    from numpy.typing import NDArray

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_Found = TypeVar("_Found")
# A deviation that is a smaller share of the mean is what rounding leaves of none.
_ROUNDING: Final = 1e-12
_LEAST_LEVEL: Final = 0.25
_MOST_LEVEL: Final = 0.9995
# Poses at a time, a multiple of TILE: every block walks the arm once.
_BLOCK: Final = 8 * TILE
# So many poses at most have as many points each over all of them as they have by themselves.
_FEW: Final = 1024
# A figure is valid, and printed, where its uncertainty is at most this share of it.
MOST_UNCERTAIN: Final = 0.05


@dataclass(frozen=True)
class Analytic:
    """The error at every pose over all robots and visits, in SI, by sums over terms.

    bias            (pose, 3) mean error, m
    covariance      (pose, 3, 3) of the error, m^2
    mean            (pose,) mean distance, m
    deviation       (pose,) standard deviation of the distance, m
    quantiles       (pose, level) distance that this share stays below, m
    mean_uncertainty, deviation_uncertainty, quantiles_uncertainty: how far each of these may be off, m, about 95 %
    nearly_normal   (pose,) whether the error is near enough to a normal vector for integration along rays; the others are by points
    excess          (pose,) by which share the scatter's mean fourth power differs from a normal vector's: 0 normal, below 0 flat or two-sided
    worst, rss      (pose,) everything at its limit, and root-sum-square, m
    """

    levels: tuple[float, ...]
    bias: Floats
    covariance: Floats
    mean: Floats
    deviation: Floats
    quantiles: Floats
    mean_uncertainty: Floats
    deviation_uncertainty: Floats
    quantiles_uncertainty: Floats
    nearly_normal: NDArray[np.bool_]
    excess: Floats
    worst: Floats
    rss: Floats

    @property
    def mean_square(self) -> Floats:
        """Return the mean square error (pose,), m^2: exact."""
        return np.asarray(np.einsum("pii->p", self.covariance) + np.einsum("pi,pi->p", self.bias, self.bias))

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Return where (pose,) the mean and all quantiles are known to 5 %."""
        mean = self.mean_uncertainty <= MOST_UNCERTAIN * self.mean
        return np.asarray(mean & (self.quantiles_uncertainty <= MOST_UNCERTAIN * self.quantiles).all(axis=1))


@dataclass(frozen=True, slots=True)
class Pooled:
    """Figures over all poses, m: the mean, the lengths that these shares of all errors stay below, and the lengths' standard deviation.

    Each interval holds what the choice of poses leaves (independent sets of poses, 95 %) and the uncertainty of the figures at the poses; poses that
    were given are taken as they are. NaN where that uncertainty alone exceeds 5 % of the value.
    """

    levels: tuple[float, ...]
    mean: Estimate
    quantiles: tuple[Estimate, ...]
    deviation: Estimate


def analytic(
    arm: Arm,
    poses: Poses | Floats,
    *,
    approach: float = 0.0,
    levels: Sequence[float] = LEVELS,
    threads: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Analytic:
    """Return how far off the tool is at these poses, over all robots and visits, by sums over terms instead of samples.

    First order in the errors. What one robot does, and how it repeats, only Monte Carlo shows.

    poses     `Poses`, or q (pose, joint) in rad or m
    approach  sign of the joints' last motion, 0 where it differs from visit to visit
    threads   change no bit
    progress  is called with what is done, how many poses, of how many

    Raises InputError for no poses, and for approach or threads out of range, ValueError for levels outside 0.25 … 0.9995 and for q of another shape
    or not finite.
    """
    wanted = tuple(float(level) for level in levels)
    if not all(_LEAST_LEVEL <= level <= _MOST_LEVEL for level in wanted):
        raise ValueError(f"levels {list(levels)}; expected shares from {_LEAST_LEVEL} to {_MOST_LEVEL}")
    if threads < 1:
        raise refuse_argument("threads", threads, "at least 1", threads=2)
    if approach not in (-1, 0, 1):
        raise refuse_argument("approach", approach, "-1, 0 or 1", approach=0)
    q = as_poses(arm, poses.q if isinstance(poses, Poses) else poses)
    if not len(q):
        raise refuse_argument("poses", "none", "at least one", poses=128)
    keep_freed()
    drawn = Drawn(screws(arm, q[:TILE], approach=approach))
    found: list[Analytic] = []
    for one in _over(arm, q, _blocks(0, len(q)), approach, threads, lambda matrix: of_screws(matrix, drawn, wanted)):
        found.append(one)
        if progress is not None:
            progress("summing up terms", min(len(found) * _BLOCK, len(q)), len(q))
    arrays = [name for name in Analytic.__dataclass_fields__ if name != "levels"]
    return Analytic(wanted, *(np.concatenate([getattr(one, name) for one in found]) for name in arrays))


def of_screws(matrix: PoseMatrix, drawn: Drawn, levels: Sequence[float] = LEVELS) -> Analytic:
    """Return the figures at the poses of this matrix."""
    shift, bias = drawn.shift(matrix), np.ascontiguousarray(matrix.bias[:, 3:])
    found = drawn.figures(matrix, shift, bias, levels)
    return Analytic(
        tuple(levels),
        bias,
        shift @ shift.transpose(0, 2, 1),
        *(found.values[:, 0], found.values[:, 1], found.values[:, 2:]),
        *(found.uncertainty[:, 0], found.uncertainty[:, 1], found.uncertainty[:, 2:]),
        found.nearly_normal,
        found.excess,
        worst_case(matrix),
        root_sum_square(matrix),
    )


def pooled(arm: Arm, poses: Poses, found: Analytic, *, approach: float = 0.0, threads: int = 1) -> Pooled:
    """Return how far off the tool is over all these poses together, of which `found` holds the figures of each."""
    if len(poses) == 1:
        return _of_one(found)
    drawn = Drawn(screws(arm, poses.q[:TILE], approach=approach))
    points = POINTS if len(poses) <= _FEW else POOLED_POINTS
    each = len(poses) // poses.replicates
    blocks = [block for first in range(0, len(poses), each) for block in _blocks(first, first + each)]
    by_block, by_set = np.zeros((BLOCKS, BINS), np.int64), np.zeros((poses.replicates, BINS), np.int64)

    def count(matrix: PoseMatrix) -> NDArray[np.int64]:
        return drawn.pooled_counts(matrix, points)

    for block, counts in zip(blocks, _over(arm, poses.q, blocks, approach, threads, count), strict=True):
        by_block += counts
        by_set[block.start // each] += counts.sum(axis=0)
    mean = _estimate(float(found.mean.mean()), float(found.mean_uncertainty.mean()), found.mean.reshape(poses.replicates, -1).mean(axis=1))
    largest = float(found.worst.max())
    return Pooled(
        found.levels,
        mean,
        tuple(_quantile(by_block, by_set, level, largest) for level in found.levels),
        _deviation(found, poses.replicates),
    )


def _of_one(found: Analytic) -> Pooled:
    """Return the figures over all poses where there is one pose: its own."""
    alone = np.zeros(1)
    return Pooled(
        found.levels,
        _estimate(float(found.mean[0]), float(found.mean_uncertainty[0]), alone),
        tuple(_estimate(float(value), float(off), alone) for value, off in zip(found.quantiles[0], found.quantiles_uncertainty[0], strict=True)),
        _estimate(float(found.deviation[0]), float(found.deviation_uncertainty[0]), alone),
    )


class Drawn:
    """The drawn columns of an arm's pose matrix, one per draw and the same at every pose: their cumulants, and their draws at Sobol points.

    The columns that change with the robots whose play is closed are the last ones, and count only at poses where that is so in some robots.
    cumulants   of the other columns; with_plays of all columns
    plays       rows of the matrix's `closed`, in the order of the closings of `with_plays`
    """

    def __init__(self, matrix: PoseMatrix) -> None:
        """Take the columns of the matrix at some poses; the sizes of its columns there decide which draws the sequence serves best."""
        infos = matrix.merged.infos
        drawn = matrix.merged.columns("robot", "visit", "robot x visit")
        self._columns = np.array(sorted(drawn, key=lambda k: infos[k].closing is not None), dtype=int)
        closings = [closing for k in self._columns if (closing := infos[k].closing) is not None]
        self._steady = len(self._columns) - len(closings)
        # Two plays with one friction, such as an axial play that any of three loads closes, differ in their shares: as if by a draw each.
        terms = [
            [((stream, closing.row) if (closing := infos[k].closing) and law == COMPARED else stream, law) for stream, law in infos[k].draws]
            for k in self._columns
        ]
        self.cumulants = cumulants(terms[: self._steady])
        self.with_plays = cumulants(terms) if closings else self.cumulants
        by_row = {closing.row: closing for closing in closings}
        self.plays = np.array(list(by_row), dtype=int)
        self._of_term = np.array([list(by_row).index(closing.row) for closing in closings], dtype=int)
        importance: Counter[Hashable] = Counter()
        for k, size in zip(self._columns, (self.shift(matrix) ** 2).sum(axis=(0, 1)), strict=True):
            for stream, _ in infos[k].draws:
                importance[stream] += size
        own = [[(stream, law) for stream, law in infos[k].draws if law != COMPARED] for k in self._columns]
        uniforms = [[(("closing", closing.stream.name), COMPARED)] for closing in by_row.values()]
        # The draws (term, count) at so many points, and after them the uniforms by which plays are closed.
        self._drawn = functools.cache(functools.partial(sobol_draws, own + uniforms, importance))

    def draws(self, count: int) -> Floats:
        """Return the draws (term, count) at so many points, of plays without what decides whether they are closed."""
        return self._drawn(count)[: len(self._columns)]

    def _steady_draws(self, count: int) -> Floats:
        return self.draws(count)[: self._steady]

    def shift(self, matrix: PoseMatrix) -> Floats:
        """Return by how much a unit of each draw moves the tool point (pose, 3, term), m."""
        return np.ascontiguousarray(matrix.merged.tool[:, 3:][:, :, self._columns])

    def figures(self, matrix: PoseMatrix, shift: Floats, bias: Floats, levels: Sequence[float]) -> Magnitude:
        """Return the figures of the error's magnitude at each pose; shift and bias (pose, 3) m as the matrix has them."""
        some = np.asarray(matrix.closed_in_some.any(axis=0))
        if not some.any():
            return figures(shift[:, :, : self._steady], bias, self.cumulants, self._steady_draws, levels)
        elsewhere = figures(shift[~some][:, :, : self._steady], bias[~some], self.cumulants, self._steady_draws, levels)
        plays = self._deciding(POINTS, matrix, some)
        there = figures(shift[some], bias[some], self.with_plays, self.draws, levels, plays)
        back = np.argsort(np.concatenate([np.flatnonzero(~some), np.flatnonzero(some)]))
        return Magnitude(*(np.concatenate([getattr(elsewhere, name), getattr(there, name)])[back] for name in Magnitude.__dataclass_fields__))

    def pooled_counts(self, matrix: PoseMatrix, points: int) -> NDArray[np.int64]:
        """Return how many lengths at these points fall into each bin (block, bin), over all poses of the matrix."""
        shift, bias, some = self.shift(matrix), np.ascontiguousarray(matrix.bias[:, 3:]), np.asarray(matrix.closed_in_some.any(axis=0))
        out = pooled_counts(shift[~some][:, :, : self._steady], bias[~some], self._steady_draws(points))
        if some.any():
            out += pooled_counts(shift[some], bias[some], self.draws(points), self._deciding(points, matrix, some))
        return out

    def _deciding(self, points: int, matrix: PoseMatrix, poses: NDArray[np.bool_]) -> Plays:
        """Return what decides at these poses (pose,) of the matrix whether plays are closed."""
        return Plays(self._drawn(points)[len(self._columns) :], matrix.closed[self.plays][:, poses].T, self._of_term)


def _blocks(first: int, last: int) -> list[slice]:
    return [slice(start, min(start + _BLOCK, last)) for start in range(first, last, _BLOCK)]


def _over(arm: Arm, q: Floats, blocks: Sequence[slice], approach: float, threads: int, work: Callable[[PoseMatrix], _Found]) -> Iterator[_Found]:
    """Yield what `work` returns for the screws of each block of poses, in order."""
    # Walking the arm is many short steps in Python: two threads at it would hold each other up.
    walking = Lock()

    def one(block: slice) -> _Found:
        with walking:
            matrix = screws(arm, q[block], approach=approach)
        return work(matrix)

    if threads == 1:
        yield from map(one, blocks)
        return
    with ThreadPoolExecutor(threads) as pool:
        yield from pool.map(one, blocks)


def _estimate(value: float, uncertainty: float, of_sets: Floats) -> Estimate:
    """Return a value with its uncertainty and that of the choice of poses, by its values over each set; NaN where the first exceeds 5 %."""
    if not uncertainty <= MOST_UNCERTAIN * value:
        return Estimate(math.nan, math.nan, math.nan)
    sets = len(of_sets)
    half = math.hypot(uncertainty, student(sets - 1) * float(of_sets.std(ddof=1)) / math.sqrt(sets)) if sets > 1 else uncertainty
    return of_length(value, value - half, value + half)


def _deviation(found: Analytic, sets: int) -> Estimate:
    """Return the standard deviation over all poses: the mean variance at a pose and the variance of the means add; by the delta method over sets."""
    variances = found.deviation**2 + (found.mean - found.mean.mean()) ** 2
    value = math.sqrt(float(variances.mean()))
    if value <= _ROUNDING * float(found.mean.mean()):
        return Estimate(0.0, 0.0, 0.0)
    uncertainty = np.maximum(found.deviation_uncertainty, found.mean_uncertainty)
    return _estimate(value, float(uncertainty.mean()), variances.reshape(sets, -1).mean(axis=1) / (2 * value))


def _quantile(by_block: NDArray[np.int64], by_set: NDArray[np.int64], level: float, largest: float) -> Estimate:
    """Return the length that a share of all errors stays below, from counts by block of points and by set of poses."""
    whole = by_block.sum(axis=0)
    alone, found = (pooled_quantile(by_block, sets, level, largest) for sets in (whole[None], by_set))
    # One point more or less at each pose shows a gap, in which blocks would agree.
    low, high = (quantile(whole, level + by / POOLED_POINTS) for by in (-1, 1))
    low, high = min(alone.low, low), min(max(alone.high, high), max(largest, alone.high))
    if max(found.value - low, high - found.value) > MOST_UNCERTAIN * found.value:
        return Estimate(math.nan, math.nan, math.nan)
    return Estimate(found.value, min(found.low, low), max(found.high, high))
