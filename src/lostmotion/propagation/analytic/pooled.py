"""The study without sampling over all poses together: the mean of their means, and the lengths that shares of all their errors stay below."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.intervals import Estimate, of_length, student
from lostmotion.laws.normal_length import ACCURACY, WORST, normal_length, share_and_density

if TYPE_CHECKING:
    from lostmotion.propagation.analytic.analytic import Analytic
    from lostmotion.spatial import Floats

# Newton's steps; one of this share of the value is the last.
_TRIES: Final = 60
_SHORT: Final = 2e-4
# The poses' departures from their nearly normal parts partly cancel, and the bound that is told counts them all alike.
MOST_LEFT_OUT_POOLED: Final = 0.05
# A variance that is a smaller share of the mean square is what rounding leaves of none.
_ROUNDING: Final = 1e-12


@dataclass(frozen=True, slots=True)
class Pooled:
    """Figures over all poses, m: the mean, the lengths that these shares of all errors stay below, and the lengths' standard deviation.

    Each `Estimate` holds what the choice of poses leaves (independent sets of poses, 95 %) and what the quadrature and the terms' departure from the
    normal law may add; poses that were given are taken as they are. NaN where that departure may move a value by more than MOST_LEFT_OUT_POOLED.
    """

    levels: tuple[float, ...]
    mean: Estimate
    quantiles: tuple[Estimate, ...]
    deviation: Estimate


def pooled(found: Analytic, replicates: int = 1, threads: int = 1) -> Pooled:
    """How far off is the tool over all poses together? `replicates` independent sets of poses of equal size follow each other."""
    parts, mixture = found.parts
    length = normal_length(parts.bias, parts.covariance, (), parts.fourth, third=parts.third, mixture=mixture, threads=threads)
    # Nothing moves a mean further than to the root mean square.
    left = np.minimum(length.mean_left, np.sqrt(length.mean_square)) + WORST * length.mean
    better = found.mean_bound < left
    means, left = np.where(better, found.mean, length.mean), np.where(better, found.mean_bound, left)
    of_sets = means.reshape(replicates, -1).mean(axis=1)
    mean = _estimate(float(means.mean()), of_sets, float(left.mean()))
    deviation = _deviation(float(means.mean()), float(left.mean()), of_sets, found.mean_square.reshape(replicates, -1).mean(axis=1))
    return Pooled(found.levels, mean, _pooled_quantiles(found, replicates, threads), deviation)


def _deviation(mean: float, left: float, means: Floats, squares: Floats) -> Estimate:
    """Return the root of mean square less squared mean: the former is exact; by the delta method, sets of poses (set,) and the mean's bound."""
    variance = float(squares.mean()) - mean * mean
    if not variance > _ROUNDING * float(squares.mean()):
        return Estimate(0.0, 0.0, 0.0) if left <= MOST_LEFT_OUT_POOLED * mean else Estimate(np.nan, np.nan, np.nan)
    value = float(np.sqrt(variance))
    of_sets = value + (squares - 2 * mean * (means - mean) - float(squares.mean())) / (2 * value)
    return _estimate(value, of_sets, mean * left / value)


def _pooled_quantiles(found: Analytic, replicates: int, threads: int) -> tuple[Estimate, ...]:
    """Find the roots of the mean of all poses' shares below: Newton's steps for all levels at once, kept between what is below and above."""
    wanted = np.array(found.levels)
    # The mean square bounds every quantile (Chebyshev).
    low, high = np.zeros(len(wanted)), np.sqrt(found.mean_square.mean() / (1 - wanted))
    if not (high > 0).all():
        return tuple(Estimate(0.0, 0.0, 0.0) for _ in wanted)
    at = _first_guess(found, wanted)
    for _ in range(_TRIES):
        shares, densities, left = _below(found, at, threads)
        share, density = shares.mean(axis=0), densities.mean(axis=0)
        low, high = np.where(share < wanted, at, low), np.where(share >= wanted, at, high)
        step = (wanted - share) / np.maximum(density, 1e-300)
        inside = (at + step > low) & (at + step < high)
        value = np.where(inside | (np.abs(step) < ACCURACY * at), at + step, 0.5 * (low + high))
        # A step so short leaves its square.
        if (np.abs(value - at) < _SHORT * at).all():
            break
        at = value
    of_sets = value - (shares.reshape(replicates, -1, len(wanted)).mean(axis=1) - share) / np.maximum(density, 1e-300)
    bounds = left.mean(axis=0) / np.maximum(density, 1e-300) + WORST * value
    return tuple(_estimate(float(value[k]), of_sets[:, k], float(bounds[k])) for k in range(len(wanted)))


def _below(found: Analytic, at: Floats, threads: int) -> tuple[Floats, Floats, Floats]:
    """Give which share of every pose's errors lies below these lengths, how dense they are there, and how far the share may be off (pose, level)."""
    parts, mixture = found.parts
    shares, densities, left = share_and_density(parts.bias, parts.covariance, at, parts.fourth, third=parts.third, mixture=mixture, threads=threads)
    # A pose whose share is not known may have any.
    unknown = ~(np.isfinite(shares) & np.isfinite(densities))
    shares, densities, left = np.where(unknown, 0.5, shares), np.where(unknown, 0.0, densities), np.where(unknown, 1.0, np.minimum(left, 1.0))
    for poses, law, own in found.laws:
        share, density = law.share(own, np.tile(at, (len(own), 1)))
        better = law.missed[own, None] < left[poses]
        rows, columns = np.nonzero(better)
        shares[poses[rows], columns], densities[poses[rows], columns] = share[better], density[better]
        left[poses[rows], columns] = law.missed[own][rows]
    return shares, densities, left


def _first_guess(found: Analytic, wanted: Floats) -> Floats:
    """Guess the quantiles over all poses: as of samples that stand for the poses' own quantiles, and nothing below the first of them."""
    order = np.argsort(wanted)
    edges = np.concatenate([[0.0], (wanted[order][1:] + wanted[order][:-1]) / 2, [1.0]])
    values, weights = found.quantiles[:, order].ravel(), np.tile(np.diff(edges), len(found.quantiles))
    known = np.isfinite(values)
    if not known.any():
        return np.asarray(np.full(len(wanted), np.sqrt(found.mean_square.mean())))
    rising = np.argsort(values[known])
    share = np.cumsum(weights[known][rising])
    return np.maximum(np.interp(wanted, (share - 0.5 * weights[known][rising]) / share[-1], values[known][rising]), 1e-300)


def _estimate(value: float, of_sets: Floats, left: float) -> Estimate:
    if not left <= MOST_LEFT_OUT_POOLED * value:
        return Estimate(np.nan, np.nan, np.nan)
    sets = len(of_sets)
    with np.errstate(over="ignore", invalid="ignore"):  # where the share has no slope a set's quantile lies as far off as numbers go
        half = left + (student(sets - 1) * float(of_sets.std(ddof=1) / np.sqrt(sets)) if sets > 1 else 0.0)
    if not np.isfinite(half):
        return Estimate(value, np.nan, np.nan)
    return of_length(value, value - half, value + half)
