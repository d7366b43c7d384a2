"""The study without sampling: mean vector and covariance of the error are exact sums over terms, its mean and quantiles follow by quadrature.

The terms' fourth cumulants enter as well, so flat, two-sided and wavy draws count as what they are, to first order. Where a few such draws dominate,
the sum is no nearly normal vector: then there is no figure here, and Monte Carlo is the way.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.laws.normal_length import ACCURACY, normal_length, share_below
from lostmotion.laws.normal_length_forms_kernel import FOURTHS, THIRDS, add_up
from lostmotion.studies.cumulants import Cumulants, cumulants
from lostmotion.studies.intervals import Estimate, student
from lostmotion.studies.screws import Screws, root_sum_square, screws, worst_case

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from lostmotion.arm import Arm
    from lostmotion.spatial import Floats
    from lostmotion.studies.poses import Poses

LEVELS: Final = (0.5, 0.95, 0.99, 0.997)
BLOCK: Final = 1024
# A figure that the next order may move by a larger share of itself is not told, and none at a pose where it moves any one by the second share.
MOST_LEFT_OUT: Final = 0.02
FAR_FROM_NORMAL: Final = 0.1
# Over all poses: their departures partly cancel, and the bound that is told counts them all alike.
MOST_LEFT_OUT_POOLED: Final = 0.05


@dataclass(frozen=True)
class Analytic:
    """What the terms say of every pose, in SI; nothing was drawn.

    bias            (pose, 3) mean error, m
    covariance      (pose, 3, 3) of the error, m^2
    fourth          (pose, 15) fourth cumulants of the error as a quartic form (`normal_length_FOURTHS`), m^4
    mean            (pose,) mean distance, m; NaN where the error is too far from normal for it
    mean_bound      (pose,) how far `mean` may be off: quadrature, and an estimate of what lies beyond fourth cumulants
    quantiles       (pose, level) distance that this share stays below, NaN likewise; quantiles_bound as mean_bound
    normal          (pose,) whether the error is near enough to normal for all of these figures
    excess          (pose,) by which share the scatter's mean fourth power differs from a normal vector's: 0 normal, below 0 flat or two-sided
    worst, rss      (pose,) everything at its limit, and root-sum-square
    """

    levels: tuple[float, ...]
    bias: Floats
    covariance: Floats
    third: Floats
    fourth: Floats
    mean: Floats
    mean_bound: Floats
    quantiles: Floats
    quantiles_bound: Floats
    normal: np.ndarray
    excess: Floats
    worst: Floats
    rss: Floats

    @property
    def mean_square(self) -> Floats:
        """Give the mean square error (pose,), m^2: exact."""
        return np.asarray(np.einsum("pii->p", self.covariance) + np.einsum("pi,pi->p", self.bias, self.bias))


def analytic(
    arm: Arm,
    poses: Poses,
    *,
    approach: float = 0.0,
    levels: Sequence[float] = LEVELS,
    threads: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Analytic:
    """How far off is the tool at these poses, over all robots and visits, by sums over terms instead of samples?

    `approach`, `threads` and `progress` as in `montecarlo.run`; threads change no bit. Over all robots and visits together: what one robot does, and
    how it repeats, Monte Carlo tells. First order in the errors. Raises InputError for approach or threads out of range, ValueError for levels.
    """
    if threads < 1:
        raise refuse_argument("threads", threads, "at least 1", "threads = 2")
    if approach not in (-1, 0, 1):
        raise refuse_argument("approach", approach, "-1, 0 or 1", "approach = 0")
    asked = tuple(float(level) for level in levels)
    known: list[Cumulants] = []  # of the draws: the same at every pose

    def block(first: int) -> Analytic:
        matrix = screws(arm, poses.q[first : first + BLOCK], approach=approach)
        if not known:
            known.append(cumulants(matrix.infos, matrix.columns("robot", "visit", "robot x visit")))
        return _block(matrix, known[0], asked)

    starts = range(0, len(poses), BLOCK)
    found = []
    with ThreadPoolExecutor(threads) as pool:
        for one in pool.map(block, starts):
            found.append(one)
            if progress is not None:
                progress("summing up terms", min(len(found) * BLOCK, len(poses)), len(poses))
    arrays = [name for name in Analytic.__dataclass_fields__ if name != "levels"]
    return Analytic(asked, *(np.concatenate([getattr(one, name) for one in found]) for name in arrays))


def of_screws(matrix: Screws, levels: Sequence[float] = LEVELS, *, only: Sequence[str] = ("robot", "visit", "robot x visit")) -> Analytic:
    """What do the terms of these poses say by themselves? `only` names the levels of chance that vary; the bias counts whole."""
    columns = matrix.columns(*only)  # type: ignore[arg-type]
    return _block(matrix, cumulants(matrix.infos, columns), tuple(levels))


def _block(matrix: Screws, known: Cumulants, levels: tuple[float, ...]) -> Analytic:
    bias, covariance, third, fourth = sums(matrix, known)
    length = normal_length(bias, covariance, levels, fourth, third=third)
    mean_bound = length.mean_left + ACCURACY * length.mean
    quantiles_bound = length.quantiles_left + ACCURACY * length.quantiles
    told = _told(np.column_stack([length.mean, length.quantiles]), np.column_stack([mean_bound, quantiles_bound]))
    return Analytic(
        levels,
        bias,
        covariance,
        third,
        fourth,
        np.where(told[:, 0], length.mean, np.nan),
        mean_bound,
        np.where(told[:, 1:], length.quantiles, np.nan),
        quantiles_bound,
        np.asarray(told.all(axis=1)),
        _excess(covariance, fourth),
        worst_case(matrix),
        root_sum_square(matrix),
    )


def sums(matrix: Screws, known: Cumulants) -> tuple[Floats, Floats, Floats, Floats]:
    """Sum the terms' cumulants up to bias (pose, 3), covariance (pose, 3, 3) and forms of the third (pose, 10) and fourth (pose, 15)."""
    count = len(matrix.tool)
    pairs, third, fourth = np.zeros((6, count)), np.zeros((len(THIRDS), count)), np.zeros((len(FOURTHS), count))
    add_up(
        *(matrix.along_poses[3:], known.pairs, known.pair_values, known.threes, known.three_values, known.fours, known.four_values),
        *(pairs, third, fourth),
    )
    covariance = np.ascontiguousarray(pairs.T[:, [[0, 5, 4], [5, 1, 3], [4, 3, 2]]])
    return np.ascontiguousarray(matrix.bias[:, 3:]), covariance, np.ascontiguousarray(third.T), np.ascontiguousarray(fourth.T)


def _told(figures: Floats, bounds: Floats) -> NDArray[np.bool_]:
    """Say which figures (pose, figure) are known well enough; those of a tool that does not err are."""
    near = np.all(bounds <= FAR_FROM_NORMAL * figures, axis=1, keepdims=True)
    return np.asarray((bounds <= MOST_LEFT_OUT * figures) & near)


def _excess(covariance: Floats, forms: Floats) -> Floats:
    """Give k_iijj over the mean fourth power of a normal vector, (tr C)^2 + 2 tr C^2."""
    weight = np.array([1.0 if max(powers) == 4 else 1 / 3 if sorted(powers) == [0, 2, 2] else 0.0 for powers in FOURTHS])  # noqa: PLR2004 - x^4; x^2 y^2
    normal = np.einsum("pii->p", covariance) ** 2 + 2 * np.einsum("pij,pij->p", covariance, covariance)
    return np.asarray(forms @ weight / np.where(normal > 0, normal, 1.0))


@dataclass(frozen=True, slots=True)
class Pooled:
    """Figures over all poses, m: the mean, and the lengths that these shares of all errors stay below.

    Each `Estimate` holds what the choice of poses leaves (independent sets of poses, 95 %) and what the quadrature and the terms' departure from the
    normal law may add; poses that were given are taken as they are. NaN where that departure may move a value by more than MOST_LEFT_OUT_POOLED.
    """

    levels: tuple[float, ...]
    mean: Estimate
    quantiles: tuple[Estimate, ...]


def pooled(found: Analytic, replicates: int = 1, threads: int = 1) -> Pooled:
    """How far off is the tool over all poses together? `replicates` independent sets of poses of equal size follow each other."""
    length = normal_length(found.bias, found.covariance, (), found.fourth)
    # Nothing moves a mean further than to the root mean square.
    left = np.minimum(length.mean_left, np.sqrt(length.mean_square)) + ACCURACY * length.mean
    mean = _estimate(float(length.mean.mean()), length.mean.reshape(replicates, -1).mean(axis=1), float(left.mean()))
    return Pooled(found.levels, mean, tuple(_pooled_quantile(found, length.mean_square, level, replicates, threads) for level in found.levels))


def _pooled_quantile(found: Analytic, mean_square: Floats, level: float, replicates: int, threads: int) -> Estimate:
    """Find the root of the mean of all poses' shares below: between the least and the largest quantile of single poses."""
    from scipy.optimize import brentq

    def shares(limit: float) -> tuple[Floats, Floats]:
        parts = [slice(first, first + BLOCK) for first in range(0, len(found.bias), BLOCK)]
        with ThreadPoolExecutor(threads) as pool:
            blocks = list(pool.map(lambda at: share_below(found.bias[at], found.covariance[at], [limit], found.fourth[at]), parts))
        return np.concatenate([share[:, 0] for share, _ in blocks]), np.concatenate([left[:, 0] for _, left in blocks])

    single = normal_length(found.bias, found.covariance, (level,), found.fourth).quantiles
    if not np.isfinite(single).all():  # the series has no quantile somewhere; the mean square bounds it (Chebyshev)
        single = np.append(np.zeros(1), np.sqrt(mean_square.mean() / (1 - level)))
    least, most = float(single.min()), float(single.max())
    if most - least <= ACCURACY * most:
        value = most
    else:
        value = float(
            brentq(lambda limit: shares(limit)[0].mean() - level, least * (1 - ACCURACY), most * (1 + ACCURACY), xtol=ACCURACY * most, rtol=ACCURACY)
        )
    if not value > 0:
        return Estimate(value, value, value)
    below, left = shares(value)
    step = 1e-3 * value
    density = float((shares(value + step)[0] - shares(value - step)[0]).mean()) / (2 * step)
    of_sets = value - (below.reshape(replicates, -1).mean(axis=1) - level) / density
    return _estimate(value, of_sets, float(np.minimum(left, 1.0).mean()) / density + ACCURACY * value)


def _estimate(value: float, of_sets: Floats, left: float) -> Estimate:
    if not left <= MOST_LEFT_OUT_POOLED * value:
        return Estimate(np.nan, np.nan, np.nan)
    sets = len(of_sets)
    half = left + (student(sets - 1) * float(of_sets.std(ddof=1) / np.sqrt(sets)) if sets > 1 else 0.0)
    return Estimate(value, value - half, value + half)
