"""Between which does a figure of measured visits lie? Intervals for scatter that is normal, or nearly so.

Student's for averages along an axis, chi-square's for 3 s; for the lengths AP_p and RP_l the same idea by sampling, since no closed form is known.
AP_p's is of where many visits would put the average, RP_l's of what many visits would give, of which the n of the sample show a little less.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.iso9283 import characteristics as iso
from lostmotion.analyses.iso9283.expected_repeatability import expected_repeatability
from lostmotion.error_model.draws import key
from lostmotion.error_model.intervals import Estimate, student

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

LEVEL: Final = 0.95
UNKNOWN: Final = Estimate(math.nan, math.nan, math.nan)
MIN_VISITS: Final = 2
_DRAWN: Final = 2000


def student_interval(values: Floats, level: float = LEVEL) -> Estimate:
    """What is the mean of values (visit,), and between which does it lie? Student's interval."""
    mean, count = float(values.mean()), len(values)
    if count < MIN_VISITS:
        return Estimate(mean, math.nan, math.nan)
    half = student(count - 1, level) * float(values.std(ddof=1)) / math.sqrt(count)
    return Estimate(mean, mean - half, mean + half)


def scatter_interval(values: Floats, level: float = LEVEL) -> Estimate:
    """What are 3 s of values (visit,), and between which do they lie? Chi-square's interval for a normal scatter."""
    from scipy.special import chdtri

    count = len(values)
    if count < MIN_VISITS:
        return UNKNOWN
    spread = 3 * float(values.std(ddof=1))
    low, high = (math.sqrt((count - 1) / float(chdtri(count - 1, tail))) for tail in ((1 - level) / 2, (1 + level) / 2))
    return Estimate(spread, spread * low, spread * high)


def accuracy_interval(errors: Floats, level: float = LEVEL) -> Estimate:
    """What is AP_p of errors (visit, 3), and between which does it lie?

    The square of the average's length is too large by the trace of its covariance C, and has the variance 4 b'Cb + 2 tr C^2 (normal scatter);
    Student's share of its root to both sides, never below zero. Holds its level where AP_p is half of the scatter of a visit or more; above it below.
    """
    if len(errors) < MIN_VISITS:
        return Estimate(float(np.linalg.norm(errors.mean(axis=0))), math.nan, math.nan)
    return length_interval(errors.mean(axis=0), np.cov(errors.T) / len(errors), len(errors) - 1, level)


def length_interval(mean: Floats, covariance: Floats, freedom: int, level: float) -> Estimate:
    """Give the length of an average with this covariance, and its interval."""
    value = float(np.linalg.norm(mean))
    square = value**2 - float(np.trace(covariance))
    half = student(freedom, level) * math.sqrt(float(4 * mean @ covariance @ mean + 2 * (covariance**2).sum()))
    return Estimate(value, math.sqrt(max(square - half, 0.0)), math.sqrt(max(square + half, 0.0)))


def repeatability_interval(errors: Floats, level: float = LEVEL) -> Estimate:
    """What is RP_l of errors (visit, 3), and between which does the RP_l of many visits lie?

    Sets of as many visits are drawn from a normal scatter with the covariance found; how their RP_l stands to the limit is how this one is taken to.
    The covariance is first made rounder by what a sample's is too unequal.
    """
    value, count = float(iso.pose_repeatability(errors)) if len(errors) >= MIN_VISITS else math.nan, len(errors)
    if not value > 0 or count <= MIN_VISITS:
        return Estimate(value, math.nan, math.nan)
    covariance = shrunk_covariance(np.cov(errors.T)[None], count)[0]
    limit = float(expected_repeatability(covariance[None] / np.trace(covariance))[0][0]) * math.sqrt(float(np.trace(covariance)))
    sets = generator("repeatability").standard_normal((_DRAWN, count, 3)) @ _root(covariance).T
    low, high = np.quantile(iso.pose_repeatability(sets) / limit, [(1 - level) / 2, (1 + level) / 2])
    return Estimate(value, value / float(high), value / float(low))


@functools.cache
def isotropic_repeatability(count: int) -> float:
    """Give RP_l that so many visits show on the average, in deviations of a round normal scatter; zero for a single visit."""
    return float(expected_repeatability(np.eye(3)[None], count)[0][0]) if count >= MIN_VISITS else 0.0


def shrunk_covariance(covariance: Floats, count: int, telling: float = math.inf) -> Floats:
    """Draw samples' covariances (n, k, k) towards round ones, until eigenvalues are as unequal as the true ones are, on the average over all n.

    Where only so many samples are `telling`, the others being like them, only as far as they surely are too unequal, by two deviations: by how much
    chance makes a sample unequal scatters by nearly as much.
    """
    size = covariance.shape[-1]
    trace = np.trace(covariance, axis1=1, axis2=2)
    square = (covariance**2).sum(axis=(1, 2)) / trace**2
    found, true = float(square.mean()) - 1 / size, float(unbiased_square(square, count).mean()) - 1 / size
    true += 2 * max(found - true, 0.0) / math.sqrt(telling)
    share = math.sqrt(min(max(true / found, 0.0), 1.0)) if found > 0 else 0.0
    return np.asarray(share * covariance + (1 - share) / size * trace[:, None, None] * np.eye(size))


def unbiased_square(square: Floats, count: int) -> Floats:
    """Take from samples' tr C^2 / (tr C)^2 what chance alone adds.

    E tr S^2 = (1 + 1/m) tr C^2 + (tr C)^2 / m with m = count - 1, of normal visits.
    """
    freedom = count - 1
    return freedom**2 / ((freedom - 1) * (freedom + 2)) * (square - 1 / freedom)


def _root(covariance: Floats) -> Floats:
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def generator(name: str) -> np.random.Generator:
    """Give the stream of this name: the same numbers in every run."""
    return np.random.Generator(np.random.Philox(key=key(1, f"iso9283.{name}")))
