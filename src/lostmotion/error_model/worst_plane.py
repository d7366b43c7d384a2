"""Estimates and confidence intervals for AT and RT at the worst plane of a measured path, as many
cycles would show.

The planes are traversed together in each cycle, so their errors are correlated, and the largest of
several figures is biased high. Each limit is found by test inversion: the value under which
simulated tests of as many cycles reach the observed figure with the tail probability. The coverage
depends on the path; benchmarks/path_intervals.py measures it, and docs/theory/iso9283.md states it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.expected_repeatability import expected_repeatability
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.visit_intervals import (
    LEVEL,
    MIN_VISITS,
    UNKNOWN,
    generator,
    shrunk_covariance,
    unbiased_square,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

_SAMPLES: Final = 2000
_BATCH: Final = 100
# Share of the largest variance below which a variance along an axis counts as zero.
_FLAT: Final = 1e-12
_BISECTIONS: Final = 24  # far finer than the simulated tests resolve


def largest_mean(vectors: Floats, level: float = LEVEL) -> Estimate:
    """Return the largest length of the true means and its interval, of vectors (plane, cycle, k) of
    planes traversed together.

    The estimate is the largest of the sample lengths after shrinkage to their true variance,
    clipped to the interval.

    Lower limit: the lengths of the other planes are reduced by what is significant of their
    difference to the longest, less one standard deviation; all shrink towards the limit in
    proportion to their scatter. Upper limit: the lengths keep their estimated true variance; the
    plane that needs the least change is moved to the limit, and the others follow by their
    correlation with it. The means are normal with the shrunk sample covariance; Student's
    distribution applies as far as the scatter of a plane is not known from the others. NaN for
    fewer than two cycles and for values that are not finite.
    """
    count = vectors.shape[1]
    if count < MIN_VISITS or not np.isfinite(vectors).all():
        return UNKNOWN
    mean = vectors.mean(axis=1)
    centred = np.swapaxes(vectors - mean[:, None], 0, 1)
    moving = (centred**2).sum(axis=(0, 2)) > 0
    fixed = float(np.linalg.norm(mean[~moving], axis=1).max(initial=0.0))
    if not moving.any():
        return Estimate(fixed, fixed, fixed)
    found = _largest_length_interval(
        mean[moving], *_sampling_distribution(centred[:, moving]), (1 - level) / 2
    )
    return Estimate(*(max(each, fixed) for each in (found.value, found.low, found.high)))


def _sampling_distribution(centred: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the sampling distribution of the means of tests like this one (cycle, plane, k).

    Standard deviations (plane,), a root (root, plane, k) of their covariance, and simulated
    deviations of the means (draw, plane, k).
    """
    count, planes, size = centred.shape
    own = np.zeros(planes)
    scatter = np.sqrt((centred**2).sum(axis=(0, 2)) / (count - 1))
    standardised = centred / scatter[:, None]
    shared = np.ones(1)  # with two cycles all planes seem fully correlated
    root = standardised / math.sqrt(count - 1)
    if count > MIN_VISITS:
        spread, chance, common = _log_deviations(_projected(centred)[None])
        # The planes together determine the common scatter, their correlation counts as one plane,
        # and each determines only its own difference.
        kept = _kept_share(spread, chance, _true_share(spread, chance))[0]
        shared, own = np.maximum(common, 1 / planes), kept * chance[0] * 2 * (count - 1)
        # A log deviation is biased low by its variance: Student's distribution corrects single
        # planes, not those shrunk together.
        scatter, root = (
            np.exp(_shrunk(spread, chance)[0] + chance[0] * (1 - kept)),
            _root(standardised),
        )
    deviation = scatter / math.sqrt(count)
    root = root.reshape(-1, planes, size) * deviation[:, None]
    rng = generator("largest mean")
    moved = (rng.standard_normal((_SAMPLES, len(root))) @ root.reshape(len(root), -1)).reshape(
        _SAMPLES, planes, size
    )
    for share in (shared, own):
        freedom = (count - 1) / np.maximum(share, _FLAT)
        moved *= np.sqrt(freedom / rng.chisquare(freedom, (_SAMPLES, len(share))))[:, :, None]
    return deviation, root, moved


def _largest_length_interval(
    mean: Floats, deviation: Floats, root: Floats, moved: Floats, tail: float
) -> Estimate:
    """Return the largest true length of means (plane, k) with this sampling distribution, and its
    interval.

    `tail` is the probability beyond either limit.
    """
    length = np.linalg.norm(mean, axis=1)
    found, worst = float(length.max()), int(length.argmax())
    along = (
        np.where(length[:, None] > 0, mean, np.eye(mean.shape[1])[0])
        / np.where(length > 0, length, 1.0)[:, None]
    )
    radial = (root * along).sum(axis=2)
    covariance = radial.T @ radial
    variance = np.maximum(np.diag(covariance), _FLAT * (found**2 + float((root**2).sum())))
    between = (
        covariance - covariance.mean(axis=0) - covariance.mean(axis=1)[:, None] + covariance.mean()
    )
    chance = np.trace(between) / max(len(mean) - 1, 1)
    # Relative standard deviation of the sampling variance; half of it as a margin meets the level
    # in all cases of benchmarks/path_intervals.py.
    relative = math.sqrt(2 * float((between**2).sum())) / max(
        float(np.trace(between)), np.finfo(float).tiny
    )
    significant = float(_true_share(length[None], np.array([chance * (1 + relative / 2)]))[0])
    true = max(float(length.var()) * len(mean) / max(len(mean) - 1, 1) - chance, 0.0)
    middle = np.average(length, weights=1 / (true + variance))
    estimated = middle + np.sqrt(true / (true + variance)) * (length - middle)
    # The longest may be so by chance alone: the others may be as long, or half a path with a common
    # offset would count as one plane.
    near = found - significant * (found - length) + np.sqrt(significant * variance)
    across, squares = (moved * along).sum(axis=2), (moved**2).sum(axis=2)

    def exceedance(there: Floats, limit: float) -> float:
        """Return how often tests with these true lengths show a plane at least as many deviations
        beyond the limit.
        """
        there = np.clip(there, 0.0, limit)
        reached = np.maximum(limit + float(((length - limit) / deviation).max()) * deviation, 0.0)
        return float((there * (there + 2 * across) + squares >= reached**2).any(axis=1).mean())

    def below(limit: float) -> float:
        return exceedance(near - (found - limit) * deviation / deviation[worst], limit)

    def above(limit: float) -> float:
        plane = int(np.argmin((limit - length) / np.sqrt(variance)))
        there = estimated + covariance[plane] / variance[plane] * (limit - length[plane])
        there[plane] = limit
        return exceedance(there, limit)

    low = 0.0 if below(0.0) > tail else _bisect(below, tail, 0.0, found)
    high = found + math.sqrt(variance.max())
    while above(high) < 1 - tail:
        high = 2 * high
    high = _bisect(above, 1 - tail, low, high)
    return Estimate(min(max(float(estimated.max()), low), high), low, high)


def _true_share(values: Floats, chance: Floats) -> Floats:
    """Return the share (set,) of the variance of values (set, plane) that exceeds their sampling
    variance (set,).
    """
    if values.shape[1] < MIN_VISITS:
        return np.ones(len(values))
    seen = values.var(axis=1, ddof=1)
    return np.asarray(np.clip(1 - chance / np.where(seen > 0, seen, np.inf), 0.0, 1.0))


def _bisect(share: Callable[[float], float], at: float, low: float, high: float) -> float:
    """Return where a rising function passes the value `at`, by bisection."""
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        low, high = (low, middle) if share(middle) > at else (middle, high)
    return (low + high) / 2


def largest_scatter(vectors: Floats, level: float = LEVEL) -> Estimate:
    """Return the largest scatter for many cycles and its interval, of vectors (plane, cycle, k) of
    planes traversed together.

    The scatter is mean + 3 s of the distances from the mean, or 3 s of vectors with one component.
    The estimate is the largest after the planes' log deviations are shrunk by their sampling
    variance, each by one standard deviation at most. The limits are the scatters under which
    simulated tests of as many cycles show so large an estimate with the tail probability; they are
    normal with the shrunk sample covariance. Below the estimate all planes are clipped at the
    limit, with half a standard deviation of slack. Above it the worst plane is moved to the limit;
    the others follow by their correlation with it, and all together as far as their difference is
    not significant. The sample's own largest value is biased high and may lie above the interval.
    NaN for fewer than three cycles, zero scatter, and values that are not finite.
    """
    count = vectors.shape[1]
    if count <= MIN_VISITS or not np.isfinite(vectors).all():
        return UNKNOWN
    centred = np.swapaxes(vectors - vectors.mean(axis=1, keepdims=True), 0, 1)
    centred = centred[:, (centred**2).sum(axis=(0, 2)) > 0]
    if not centred.size:
        return UNKNOWN
    centred = _projected(centred)
    standardised = centred / np.sqrt((centred**2).sum(axis=(0, 2)) / (count - 1))[:, None]
    many = (
        np.full(centred.shape[1], math.log(3.0))
        if vectors.shape[2] == 1
        else np.log(_limit_repeatability(standardised))
    )
    spread, chance, _ = _log_deviations(centred[None])
    shrunk = _shrunk(spread, chance)[0] + many
    estimate, worst = float(shrunk.max()), int(shrunk.argmax())
    root = covariance_root(standardised)
    of_chance, chances = simulated_tests(root, count)
    # Half a standard deviation less sampling variance, so that true differences between planes are
    # not missed.
    between = of_chance.var(axis=1)
    surplus = between.std() / max(between.mean(), np.finfo(float).tiny) / 2
    apart = _true_share(spread, chance * (1 - surplus))
    mean = spread.mean()
    separated = mean + _kept_share(spread, chance, np.sqrt(apart))[0] * (spread[0] - mean) + many
    squares = (np.einsum("rpi,rj->pij", root, root[:, worst]) ** 2).sum(axis=(1, 2))
    correlation = squares / np.sqrt(
        squares[worst] * (np.einsum("rpi,rpj->pij", root, root) ** 2).sum(axis=(1, 2))
    )
    follows = 1 - apart[0] * (1 - correlation)
    near = shrunk + math.sqrt(float(_true_share(spread, chance)[0] * chance[0])) / 2

    def exceedance(there: Floats) -> float:
        """Return how often tests with these true log scatters show an estimate at least as
        large.
        """
        return float(
            ((_shrunk(of_chance + there - many, chances) + many).max(axis=1) >= estimate).mean()
        )

    def below(limit: float) -> float:
        return exceedance(np.minimum(near, limit))

    def above(limit: float) -> float:
        return exceedance(np.minimum(separated + (limit - separated[worst]) * follows, limit))

    tail, low, high = (1 - level) / 2, estimate - 1, estimate + 1
    while below(low) > tail:
        low -= 1
    while above(high) < 1 - tail:
        high += 1
    low = _bisect(below, tail, low, high)
    high = _bisect(above, 1 - tail, low, high)
    return Estimate(*(math.exp(each) for each in (min(max(estimate, low), high), low, high)))


def _projected(centred: Floats) -> Floats:
    """Return vectors (cycle, plane, k) within the plane, or on the line, that contains all of
    them.
    """
    if centred.shape[2] == 1:
        return centred
    values, axes = np.linalg.eigh(np.einsum("npi,npj->ij", centred, centred))
    return np.asarray(centred @ axes[:, values > _FLAT * values[-1]])


def covariance_root(standardised: Floats) -> Floats:
    """Return a root (root, plane, k) of the covariance from which tests are simulated, of
    standardised vectors (cycle, plane, k).
    """
    _, _, common = _log_deviations(standardised[None])
    return _root(
        standardised, effective=1 / max(float(common[0]), 1 / standardised.shape[1])
    ).reshape(-1, *standardised.shape[1:])


def simulated_tests(root: Floats, count: int) -> tuple[Floats, Floats]:
    """Return log deviations (draw, plane) and their sampling variance (draw,) of simulated tests
    with this number of cycles.

    `root` (root, plane, k) is a root of the covariance.
    """
    flat = root.reshape(len(root), -1)
    rng, found = generator("largest scatter"), []
    for _ in range(0, _SAMPLES, _BATCH):
        sets = (rng.standard_normal((_BATCH, count, len(root))) @ flat).reshape(
            _BATCH, count, *root.shape[1:]
        )
        found.append(_log_deviations(sets - sets.mean(axis=1, keepdims=True)))
    spreads, chances, _ = zip(*found, strict=True)
    return np.concatenate(spreads), np.concatenate(chances)


def _root(standardised: Floats, effective: float = 1.0) -> Floats:
    """Return a root of the covariance of planes (cycle, plane, k), with correlations and eigenvalue
    spread corrected for the small sample.

    `effective` is the effective number of independent planes, for the shrinkage of each plane's own
    covariance.
    """
    count, planes, size = standardised.shape
    flat = standardised.reshape(count, -1)
    covariance = (flat.T @ flat / (count - 1)).reshape(planes, size, planes, size)
    square = (covariance**2).sum(axis=(1, 3))
    own = np.sqrt(np.outer(np.diag(square), np.diag(square)))
    least = 1 / (count - 1)  # expectation for two independent planes
    true = (square - least) / np.maximum(own - least, np.finfo(float).tiny) * own
    share = np.sqrt(np.clip(true / np.maximum(square, least), 0.0, 1.0))
    # The clip at zero biases the correlations high: scale the others so that their sum is unbiased.
    np.fill_diagonal(true, 0.0)
    np.fill_diagonal(share, 0.0)
    kept = float((share**2 * square).sum())
    share *= math.sqrt(min(max(float(true.sum()) / kept, 0.0), 1.0)) if kept > 0 else 0.0
    np.fill_diagonal(share, 1.0)
    covariance *= share[:, None, :, None]
    each = np.arange(planes)
    covariance[each, :, each] = shrunk_covariance(covariance[each, :, each], count, effective)
    values, vectors = np.linalg.eigh(covariance.reshape(planes * size, -1))
    root = (vectors * np.sqrt(np.maximum(values, 0.0))).T
    trace = (root.reshape(-1, planes, size) ** 2).sum(axis=(0, 2))
    return np.asarray(root / np.repeat(np.sqrt(trace), size))


def _limit_repeatability(standardised: Floats) -> Floats:
    """Return mean + 3 s of the distances for many cycles, of planes (cycle, plane, k) of unit
    trace, from their shrunk covariances.
    """
    count, _, size = standardised.shape
    covariance = shrunk_covariance(
        np.einsum("npi,npj->pij", standardised, standardised) / (count - 1), count
    )
    return expected_repeatability(np.pad(covariance, ((0, 0), (0, 3 - size), (0, 3 - size))))[0]


def _log_deviations(sets: Floats) -> tuple[Floats, Floats, Floats]:
    """Return log deviations (set, plane) of centred sets (set, cycle, plane, k), their sampling
    variance (set,), and the planes' correlation (set,).

    A log deviation has the variance tr C^2 / (tr C)^2 / (2 (n - 1)), a pair of planes the
    covariance |C_12|^2 / (tr C_1 tr C_2) / (2 (n - 1)). What all planes share does not make them
    differ. The squared sample correlation of independent planes averages 1 / (n - 1), that of
    identical planes one.
    """
    count, _, size = sets.shape[1:]
    least = 1 / (count - 1)
    trace = (sets**2).sum(axis=(1, 3)) / (count - 1)
    standardised = sets / np.sqrt(trace)[:, None, :, None]
    covariance = np.einsum("dnpi,dnpj->dpij", standardised, standardised) / (count - 1)
    own = (covariance**2).sum(axis=(2, 3))
    single = np.clip(unbiased_square(own, count), 1 / size, 1.0).mean(axis=1)
    flat = standardised.reshape(*standardised.shape[:2], -1)
    across = (
        flat @ np.swapaxes(flat, 1, 2)
        if flat.shape[1] < flat.shape[2]
        else np.swapaxes(flat, 1, 2) @ flat
    )
    seen = (across**2).sum(axis=(1, 2)) / (standardised.shape[2] * (count - 1)) ** 2
    common = np.clip(
        (seen - least) / np.maximum(own.mean(axis=1) - least, np.finfo(float).tiny), 0.0, 1.0
    )
    return np.log(trace) / 2, single * (1 - common) / (2 * (count - 1)), common


def _shrunk(spread: Floats, chance: Floats) -> Floats:
    """Return log deviations (set, plane) shrunk towards their mean by their sampling variance
    (set,).
    """
    mean = spread.mean(axis=1, keepdims=True)
    return np.asarray(
        mean + _kept_share(spread, chance, _true_share(spread, chance)) * (spread - mean)
    )


def _kept_share(spread: Floats, chance: Floats, share: Floats) -> Floats:
    """Return the share (set, plane) of its distance from the mean that each log deviation keeps,
    given the overall share (set,).

    None is shrunk by more than one standard deviation of the sampling variance, which would treat a
    single bad plane as chance (B. Efron and C. Morris, Limiting the risk of Bayes and empirical
    Bayes estimators, part II, JASA 67, 1972, p. 130).
    """
    furthest = np.sqrt(chance)[:, None]
    off = np.abs(spread - spread.mean(axis=1, keepdims=True))
    return np.asarray(
        np.maximum(
            share[:, None],
            1 - furthest / np.maximum(off, np.maximum(furthest, np.finfo(float).tiny)),
        )
    )
