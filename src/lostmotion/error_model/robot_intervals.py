"""Confidence intervals of means and quantiles over robots, from one figure of each robot and set of
poses. Both are crossed random factors; robots and sets of poses are the samples.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.intervals import (
    CONFIDENCE,
    Estimate,
    Spread,
    of_length,
    student,
    variance_of_mean,
)
from lostmotion.error_model.small_counts import (
    counting_floor,
    satterthwaite,
)

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Largest number of groups of robots, and smallest number of robots in each. Groups separate the
# effect of few robots from that of few poses.
_GROUPS: Final = 16
_IN_GROUP: Final = 20


def pooled_mean(robot_means: Floats, of_poses: Floats | None = None) -> Estimate:
    """Return the mean over robots and poses of these mean lengths (set of poses, robot), with its
    confidence interval; no end is below zero.

    of_poses  (pose,) mean over the robots at each pose, set after set, for the floor of
              `counting_floor`; without it, errors that begin abruptly in rare poses may leave the
              interval too narrow

    Robots and sets of poses are crossed random factors: each set is visited by all robots (see
    `two_way`). NaN ends for a single robot.
    """
    value = float(robot_means.mean())
    if robot_means.shape[1] < 2:  # noqa: PLR2004 - a single one shows no differences
        return Estimate(value, math.nan, math.nan)
    half = mean_spread(robot_means, of_poses).half
    return of_length(value, value - half, value + half)


def mean_spread(robot_means: Floats, of_poses: Floats | None = None) -> Spread:
    """Return the uncertainty of the mean of `pooled_mean`: that of `two_way`, with the share of the
    poses at least that of `counting_floor`.
    """
    found = two_way(robot_means)
    variance = found.of_robots + found.of_poses
    least = 0.0 if of_poses is None else counting_floor(of_poses, len(robot_means), CONFIDENCE)
    factor = found.half / math.sqrt(variance) if variance > 0 else student(math.inf)
    if not least > factor * math.sqrt(found.of_poses):
        return found
    chosen = (least / factor) ** 2
    return Spread(found.of_robots, chosen, factor * math.sqrt(found.of_robots + chosen))


def root_mean_square(of_sets: Floats, of_poses: Floats | None = None) -> Estimate:
    """Return the square root of the mean of the mean squares (set,) of independent sets of poses,
    with its confidence interval.

    of_poses  (pose,) mean square at each pose, for the floor as for `pooled_mean`

    The ends are the roots of those of Student's interval of the mean. NaN ends for a single set.
    """
    mean = float(of_sets.mean())
    half = student(len(of_sets) - 1) * math.sqrt(variance_of_mean(of_sets))
    if of_poses is not None:
        half = max(half, counting_floor(of_poses, len(of_sets), CONFIDENCE))
    return Estimate(
        math.sqrt(mean), float(np.sqrt(np.maximum(mean - half, 0.0))), math.sqrt(mean + half)
    )


def root_mean_square_of_samples(squares: Floats) -> Estimate:
    """Return the root mean square of independent samples from their positive squares (sample,),
    with its confidence interval.

    The sum of the squares is approximated by a scaled chi-square distribution of the same mean and
    variance, with 2 n mean^2/variance degrees of freedom (F. Satterthwaite, Biometrics Bulletin 2
    (1946) 110). It has their long upper tail, and is exact for a normal error and for a harmonic of
    random phase. NaN ends for a single sample.
    """
    from scipy.special import gammaincinv

    mean, variance = (
        float(squares.mean()),
        float(squares.var(ddof=1)) if len(squares) > 1 else math.nan,
    )
    if not variance > 0:
        return Estimate(
            math.sqrt(mean), *((math.sqrt(mean),) * 2 if variance == 0 else (math.nan, math.nan))
        )
    half = len(squares) * mean**2 / variance  # half of the degrees of freedom
    low, high = (
        float(gammaincinv(half, share)) / half
        for share in ((1 + CONFIDENCE) / 2, (1 - CONFIDENCE) / 2)
    )
    return Estimate(math.sqrt(mean), math.sqrt(mean / low), math.sqrt(mean / high))


def two_way(values: Floats) -> Spread:
    """Return the uncertainty of the mean of these values (set of poses, robot or group of robots),
    by a two-way analysis of variance.

    The variance of the grand mean is the sum of the mean squares of sets and of robots less that of
    the cells (S. Searle et al., Variance Components, 1992, ch. 4). F. Satterthwaite's formula
    (Biometrics Bulletin 2 (1946) 110) gives its degrees of freedom. A negative component counts as
    zero.
    """
    sets, robots = values.shape
    squares = [variance_of_mean(values.mean(axis=0)), variance_of_mean(values.mean(axis=1))]
    freedoms = [robots - 1, sets - 1]
    cells = _mean_square_of_cells(values)
    # Both mean squares contain that of the cells; a factor with less than that has no variance of
    # its own.
    real = [k for k in (0, 1) if squares[k] > cells]
    if len(real) > 1:
        variance, freedom = satterthwaite(
            [*squares, -cells], [*freedoms, (sets - 1) * (robots - 1)]
        )
    else:
        k = real[0] if real else 0
        variance, freedom = max(squares[k], cells), float(freedoms[k])
    of_poses = min(max(squares[1] - cells, 0.0), variance)
    return Spread(variance - of_poses, of_poses, student(freedom) * math.sqrt(variance))


def robots_quantile(values: Floats, level: float = 0.95) -> Floats:
    """Return the quantile over robots of values (..., robot): (..., 3), the quantile and the ends
    of its confidence interval.

    The ends are order statistics, interpolated between two robots (A. Hutson, J. Applied Statistics
    26 (1999) 343). Each end is missed in 1.5 to 3 % of cases from 128 robots on, for short and for
    long tails, and in up to 5.5 % with fewer robots. An end outside the sample is NaN. Valid for
    finite values.
    """
    from scipy.special import bdtr, bdtrik

    ordered = np.sort(values, axis=-1)
    count = values.shape[-1]
    out = np.full((*values.shape[:-1], 3), math.nan)
    out[..., 0] = ordered[..., math.ceil(level * count) - 1]
    for k, tail in enumerate(((1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2), start=1):
        place = float(bdtrik(tail, count, level))  # number of robots below it, not an integer
        if bdtr(0, count, level) <= tail and place <= count - 1:
            before = min(int(place), count - 2)
            out[..., k] = ordered[..., before] + (place - before) * (
                ordered[..., before + 1] - ordered[..., before]
            )
    return out


def pooled_robots_quantile(
    robot_means: Floats, level: float = 0.95, of_poses: Floats | None = None
) -> Estimate:
    """Return the quantile over robots of their mean over the poses, with its confidence interval,
    from means (set of poses, robot).

    The means are first shrunk towards their common mean by the variance due to few poses and
    visits, estimated from the sets. Without this the quantile would be biased upwards. The interval
    is that of `robots_quantile`, widened by the uncertainty due to the choice of poses
    (`quantile_spread`), at least by that of `counting_floor` with `of_poses` as for `pooled_mean`.
    """
    sets = len(robot_means)
    value, low, high = (float(x) for x in robots_quantile(shrunk_means(robot_means), level))
    chosen = student(sets - 1) * math.sqrt(quantile_spread(robot_means, level)) if sets > 1 else 0.0
    if of_poses is not None:
        chosen = max(chosen, counting_floor(of_poses, sets, CONFIDENCE))
    return of_length(
        value, value - math.hypot(value - low, chosen), value + math.hypot(high - value, chosen)
    )


def shrunk_means(robot_means: Floats) -> Floats:
    """Return each robot's mean (robot,), shrunk so that their variance is that between robots, from
    means (set of poses, robot).

    Source: T. Louis, J. Am. Stat. Assoc. 79 (1984) 393. With a single set the means are returned
    unchanged.
    """
    found = robot_means.mean(axis=0)
    if min(robot_means.shape) < 2:  # noqa: PLR2004 - no differences to estimate it from
        return np.asarray(found)
    centre, observed = found.mean(), variance_of_mean(found)
    real = max(1 - _mean_square_of_cells(robot_means) / observed, 0.0) if observed > 0 else 0.0
    return np.asarray(centre + math.sqrt(real) * (found - centre))


def quantile_spread(robot_means: Floats, level: float = 0.95) -> float:
    """Return the variance of a quantile over robots that is due to the choice of poses, from means
    (set of poses, robot).

    Groups of robots in each set separate the effect of the choice of robots (see `two_way`). Zero
    for a single set.
    """
    sets, robots = robot_means.shape
    if sets < 2:  # noqa: PLR2004 - a single set
        return 0.0
    groups = min(max(robots // _IN_GROUP, 1), _GROUPS)
    of_groups = [
        np.quantile(part, level, axis=1) for part in np.array_split(robot_means, groups, axis=1)
    ]
    return (
        variance_of_mean(of_groups[0])
        if groups < 2  # noqa: PLR2004
        else two_way(np.stack(of_groups, axis=1)).of_poses
    )


def _mean_square_of_cells(values: Floats) -> float:
    """Return the contribution to the squared standard error of the grand mean from the interaction
    of values (set of poses, robot).
    """
    sets, robots = values.shape
    if sets < 2:  # noqa: PLR2004 - a single set has no interaction
        return 0.0
    rest = values - values.mean(axis=0) - values.mean(axis=1)[:, None] + values.mean()
    return float((rest**2).sum() / ((sets - 1) * (robots - 1)) / (sets * robots))
