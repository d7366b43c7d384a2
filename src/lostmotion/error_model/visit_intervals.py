"""Confidence intervals of pose characteristics measured on one robot, for normally distributed
scatter.

Means along an axis use Student's t distribution, 3 s the chi-square distribution. AP_p uses the
moments of its square; RP_l, for which no closed form is known, uses parametric bootstrap samples.
Both refer to the limit of many visits.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.draws import key
from lostmotion.error_model.expected_repeatability import expected_repeatability
from lostmotion.error_model.intervals import Estimate, student
from lostmotion.laws import iso9283 as iso

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

LEVEL: Final = 0.95
UNKNOWN: Final = Estimate(math.nan, math.nan, math.nan)
MIN_VISITS: Final = 2
_SAMPLES: Final = 2000
# Multiple of the median distance beyond which a visit is outlying, and fewest visits for it.
_OUTLYING: Final = 15.0
_FEWEST_FOR_OUTLIERS: Final = 10


def student_interval(values: Floats, level: float = LEVEL) -> Estimate:
    """Return the mean of values (visit,) with its confidence interval by Student's t
    distribution.
    """
    mean, count = float(values.mean()), len(values)
    if count < MIN_VISITS:
        return Estimate(mean, math.nan, math.nan)
    half = student(count - 1, level) * float(values.std(ddof=1)) / math.sqrt(count)
    return Estimate(mean, mean - half, mean + half)


def scatter_interval(values: Floats, level: float = LEVEL) -> Estimate:
    """Return 3 s of values (visit,) with its confidence interval by the chi-square distribution,
    for normal scatter.
    """
    from scipy.special import chdtri

    count = len(values)
    if count < MIN_VISITS:
        return UNKNOWN
    spread = 3 * float(values.std(ddof=1))
    low, high = (
        math.sqrt((count - 1) / float(chdtri(count - 1, tail)))
        for tail in ((1 - level) / 2, (1 + level) / 2)
    )
    return Estimate(spread, spread * low, spread * high)


def accuracy_interval(errors: Floats, level: float = LEVEL) -> Estimate:
    """Return AP_p of errors (visit, 3) with its confidence interval.

    The squared length of the mean is biased by the trace of its covariance C and has the variance 4
    b'Cb + 2 tr C^2 for normal scatter. The interval is the bias-corrected square plus and minus
    Student's t times its standard deviation, never below zero. Its coverage is nominal where AP_p
    is at least half of the scatter of a visit, and higher below that.
    """
    if len(errors) < MIN_VISITS:
        return Estimate(float(np.linalg.norm(errors.mean(axis=0))), math.nan, math.nan)
    return length_interval(
        errors.mean(axis=0), np.cov(errors.T) / len(errors), len(errors) - 1, level
    )


def length_interval(mean: Floats, covariance: Floats, freedom: int, level: float) -> Estimate:
    """Return the length of a mean vector (k,) with this covariance (k, k), and its confidence
    interval.
    """
    value = float(np.linalg.norm(mean))
    square = value**2 - float(np.trace(covariance))
    half = student(freedom, level) * math.sqrt(
        float(4 * mean @ covariance @ mean + 2 * (covariance**2).sum())
    )
    return Estimate(value, math.sqrt(max(square - half, 0.0)), math.sqrt(max(square + half, 0.0)))


def repeatability_interval(errors: Floats, level: float = LEVEL) -> Estimate:
    """Return RP_l of errors (visit, 3) with the confidence interval of its limit for many visits.

    Parametric bootstrap: RP_l of sets of as many visits, drawn from a normal distribution with the
    shrunk sample covariance, relative to its limit.
    """
    value, count = (
        float(iso.pose_repeatability(errors)) if len(errors) >= MIN_VISITS else math.nan,
        len(errors),
    )
    if not value > 0 or count <= MIN_VISITS:
        return Estimate(value, math.nan, math.nan)
    covariance = shrunk_covariance(np.cov(errors.T)[None], count)[0]
    limit = float(
        expected_repeatability(covariance[None] / np.trace(covariance))[0][0]
    ) * math.sqrt(float(np.trace(covariance)))
    sets = _standard_sets(count, _SAMPLES) @ _root(covariance).T
    low, high = np.quantile(
        iso.pose_repeatability(sets) / limit, [(1 - level) / 2, (1 + level) / 2]
    )
    return Estimate(value, value / float(high), value / float(low))


@functools.lru_cache(maxsize=2)  # a megabyte and a half for thirty visits
def _standard_sets(count: int, samples: int) -> Floats:
    """Return the normal numbers (sample, visit, 3) of all poses with this number of visits."""
    sets = generator("repeatability").standard_normal((samples, count, 3))
    sets.flags.writeable = False
    return sets


@functools.cache
def isotropic_repeatability(count: int) -> float:
    """Return the expected RP_l of this many visits with isotropic normal scatter of unit standard
    deviation; zero for a single visit.
    """
    return (
        float(expected_repeatability(np.eye(3)[None], count)[0][0]) if count >= MIN_VISITS else 0.0
    )


def shrunk_covariance(covariance: Floats, count: int, effective: float = math.inf) -> Floats:
    """Return sample covariances (n, k, k) shrunk towards isotropic ones, so that their eigenvalue
    spread is unbiased on average over all n.

    `effective` is the effective number of independent samples; fewer of them shrink less, by two
    standard deviations of the spread.
    """
    size = covariance.shape[-1]
    trace = np.trace(covariance, axis1=1, axis2=2)
    square = (covariance**2).sum(axis=(1, 2)) / trace**2
    found, true = (
        float(square.mean()) - 1 / size,
        float(unbiased_square(square, count).mean()) - 1 / size,
    )
    true += 2 * max(found - true, 0.0) / math.sqrt(effective)
    kept = math.sqrt(min(max(true / found, 0.0), 1.0)) if found > 0 else 0.0
    return np.asarray(kept * covariance + (1 - kept) / size * trace[:, None, None] * np.eye(size))


def unbiased_square(square: Floats, count: int) -> Floats:
    """Return the unbiased estimate of tr C^2 / (tr C)^2 (n,) from the same ratio of sample
    covariances of `count` normal visits.

    E tr S^2 = (1 + 1/m) tr C^2 + (tr C)^2 / m with m = count - 1.
    """
    freedom = count - 1
    return freedom**2 / ((freedom - 1) * (freedom + 2)) * (square - 1 / freedom)


def _root(covariance: Floats) -> Floats:
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def generator(name: str) -> np.random.Generator:
    """Return the random generator of this name, which yields the same numbers in every run."""
    return np.random.Generator(np.random.Philox(key=key(1, f"iso9283.{name}")))


def outlying_visits(attained: Floats) -> dict[int, float]:
    """Return the visits (visit, 3) that lie far from the others, with their distances from the
    median, m.

    Far is 15 times the median of these distances: ten standard deviations of normal scatter along a
    line, more in a plane or in space. Of normal scatter along a line, 10 visits have one so far in
    2 of 1 000 cases. Where more than a tenth of the visits lie so far, they belong to the scatter.
    """
    distance = np.linalg.norm(attained - np.median(attained, axis=0), axis=1)
    far = np.flatnonzero(distance > _OUTLYING * np.median(distance))
    if (
        len(attained) < _FEWEST_FOR_OUTLIERS
        or not np.median(distance)
        or len(far) > max(1, len(attained) // 10)
    ):
        return {}
    return {int(k): float(distance[k]) for k in far}


def without_instrument(repeat: Estimate, floor: float) -> Estimate:
    """Return a repeatability and its limits with the instrument's own repeatability subtracted in
    squares.
    """
    return Estimate(
        *(
            math.sqrt(max(each**2 - floor**2, 0.0)) if math.isfinite(each) else each
            for each in (repeat.value, repeat.low, repeat.high)
        )
    )
