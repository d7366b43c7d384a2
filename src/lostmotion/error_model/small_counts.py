"""Confidence intervals where few robots or poses make the figure: order statistics, degrees of
freedom, and a floor by counting.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# Number of samples from which an interval is narrower than rounding.
_MANY: Final = 1e15


def order_statistics(level: float, count: float, confidence: float) -> tuple[float, float]:
    """Return the shares, 0..1, of a sample below the ends of the interval of its quantile at
    `level`, from `count` independent samples (any number).

    The number of samples below the true quantile has a binomial distribution. An end beyond the
    extreme sample is that sample.
    """
    if count > _MANY:
        return level, level
    from scipy.special import bdtrik

    tail = (1 - confidence) / 2
    low, high = (float(bdtrik(share, count, level)) for share in (tail, 1 - tail))
    none_below, all_below = (1 - level) ** count, level**count
    return (low + 1) / (count + 1) if none_below <= tail else 0.0, (high + 1) / (
        count + 1
    ) if all_below <= tail else 1.0


def satterthwaite(squares: list[float], freedoms: Sequence[float]) -> tuple[float, float]:
    """Return the sum of variances and its degrees of freedom, by Satterthwaite's formula."""
    total = sum(squares)
    if not total > 0:
        return 0.0, float(max(freedoms))
    return total, total**2 / sum(
        square**2 / freedom
        for square, freedom in zip(squares, freedoms, strict=True)
        if freedom > 0
    )


def freedom_of_variance(members: Floats) -> float:
    """Return the degrees of freedom of the variance of members (member,): those of the chi-square
    distribution with the same relative variance.

    The variance of a sample variance s^2 is s^4 (2/(n - 1) + excess/n), with the excess kurtosis of
    the members (B. O'Neill, American Statistician 68 (2014) 282). A negative excess counts as zero.
    """
    count, variance = len(members), float(members.var())
    if not variance > 0:
        return float(count - 1)
    excess = float(((members - members.mean()) ** 4).mean()) / variance**2 - 3
    return 2 / (2 / (count - 1) + max(excess, 0.0) / count)


def counting_floor(of_poses: Floats, sets: int, confidence: float = 0.95) -> float:
    """Return the smallest half-width of the interval of a mean over poses, from its value at each
    pose (pose,), which are in independent `sets`.

    A set has a whole number of poses with an error that begins abruptly, such as an open play.
    Stratified sets often have the same number: they then show no variance, though the share of such
    poses is not known better than to 1 - 0.025^(1/sets) poses in each, the upper limit of a
    binomial proportion without an event (C. Clopper, E. Pearson, Biometrika 26 (1934) 404). The
    mean is the sum, over the gaps between neighbouring values in order, of gap times share of poses
    above it; gaps add as independent. So the floor is that of the whole gap where there is one, and
    nearly zero where the values vary smoothly. Zero for a single set, whose poses were not chosen
    at random.
    """
    if sets < 2:  # noqa: PLR2004 - a single set
        return 0.0
    unseen = 1 - ((1 - confidence) / 2) ** (1 / sets)
    return float(unseen * sets / len(of_poses) * np.linalg.norm(np.diff(np.sort(of_poses))))


def clustered_share(shares: Floats, runs: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return the ends of the interval of a mean share, from the share of each robot (robot,) over
    so many runs.

    It is the exact binomial interval of as many independent samples as have the same variance (E.
    Korn, B. Graubard, Survey Methodology 24 (1998) 193; C. Clopper, E. Pearson, Biometrika 26
    (1934) 404). Where all robots have the same share of zero or one, each robot counts once. NaN
    for a single robot.
    """
    from scipy.special import betaincinv, stdtrit

    count, mean = len(shares), float(shares.mean())
    if count < 2:  # noqa: PLR2004 - a single one shows no differences
        return math.nan, math.nan
    variance = float(shares.var(ddof=1)) / count
    tail = (1 - confidence) / 2
    samples = float(count)
    if variance > 0:
        ratio = float(stdtrit(1e9, 1 - tail) / stdtrit(count - 1, 1 - tail))
        samples = min(mean * (1 - mean) / variance * ratio**2, float(count * runs))
    found = mean * samples
    low = 0.0 if mean == 0 else float(betaincinv(found, samples - found + 1, tail))
    high = 1.0 if mean == 1 else float(betaincinv(found + 1, samples - found, 1 - tail))
    return low, high
