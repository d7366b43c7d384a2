"""Differences between two arms with paired confidence intervals: the same robots, visits and sets
of poses, taken together.

Robot r and set of poses k of one arm belong to robot r and set k of the other: they have the same
named draws. What both arms share cancels in their difference, so its interval is narrower than the
two intervals suggest. The interval is also valid where nothing cancels, since other robots and
other sets are independent. All differences are after minus before; exchanging the arms changes the
sign and nothing else. All intervals are of 95 %.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.intervals import (
    Estimate,
    quantile_drop,
    squares_about,
    student,
    variance_of_mean,
)
from lostmotion.error_model.robot_intervals import robots_quantile, shrunk_means, two_way
from lostmotion.error_model.small_counts import satterthwaite

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# Smallest number of robots in a group, and largest number of groups, of the jackknife over robots.
_IN_GROUP: Final = 20
_GROUPS: Final = 16
ZERO: Final = Estimate(0.0, 0.0, 0.0)


def mean_difference(before: Floats, after: Floats) -> Estimate:
    """Return the difference of the mean over robots and poses from these means (set of poses,
    robot), with its interval.

    The differences of single robots on single sets are analysed as in `two_way`. NaN ends for a
    single robot.
    """
    value = float(after.mean()) - float(before.mean())
    if before.shape[1] < 2:  # noqa: PLR2004 - a single one shows no differences
        return Estimate(value, math.nan, math.nan)
    return _about(value, two_way(after - before).half)


def quantile_difference(
    before: tuple[np.ndarray, np.ndarray],
    after: tuple[np.ndarray, np.ndarray],
    level: float,
    values: tuple[float, float],
) -> Estimate:
    """Return the difference of the quantile at `level` of all samples, with its interval.

    before, after  histograms by group of robots and by set of poses, as for `quantile_drop`
    values         both quantiles as reported, m

    The interval is that of `quantile_drop`, centred on the difference of the reported values.
    """
    larger, smaller = (before, after) if values[0] >= values[1] else (after, before)
    return _about(values[1] - values[0], quantile_drop(larger, smaller, level).half)


def deviation_difference(
    before: tuple[np.ndarray, np.ndarray],
    after: tuple[np.ndarray, np.ndarray],
    means: tuple[float, float],
    values: tuple[float, float],
) -> Estimate:
    """Return the difference of the standard deviation of all samples, with its interval.

    before, after  histograms by group of robots and by set of poses, as for `standard_deviation`
    means, values  mean and standard deviation as reported, m

    By the delta method on the differences of the groups and of the sets. NaN ends for a single
    group.
    """
    value = values[1] - values[0]
    if len(before[0]) < 2:  # noqa: PLR2004 - a single one shows no differences
        return Estimate(value, math.nan, math.nan)
    slopes = [
        [
            squares_about(mean, hists) / (2 * own) if own > 0 else np.zeros(len(hists))
            for hists in arm
        ]
        for arm, mean, own in zip((before, after), means, values, strict=True)
    ]
    members = [other - one for one, other in zip(*slopes, strict=True)]
    variance, freedom = satterthwaite(
        [variance_of_mean(each) for each in members], [len(each) - 1 for each in members]
    )
    return _about(value, student(freedom) * math.sqrt(variance))


def robots_quantile_difference(before: Floats, after: Floats, level: float = 0.95) -> Estimate:
    """Return the difference of the quantile over robots of their mean over the poses, from means
    (set of poses, robot), with its interval.

    The quantiles are those of `pooled_robots_quantile`. One group of robots, or one set of poses,
    is omitted at a time, before and after together (jackknife, B. Efron 1982, ch. 3). Groups have
    at least 20 robots, since the jackknife of a quantile needs many: NaN ends for fewer than 40.
    """
    value = _quantile_of_robots(after, level) - _quantile_of_robots(before, level)
    sets, robots = before.shape
    groups = min(robots // _IN_GROUP, _GROUPS)
    if groups < 2:  # noqa: PLR2004 - a single one shows no differences
        return Estimate(value, math.nan, math.nan)

    def changed(keep_sets: np.ndarray, keep_robots: np.ndarray) -> float:
        return _quantile_of_robots(after[keep_sets][:, keep_robots], level) - _quantile_of_robots(
            before[keep_sets][:, keep_robots], level
        )

    of_sets, of_robots = np.arange(sets), np.arange(robots)
    pseudo = [
        _pseudo_values(
            value,
            [
                changed(of_sets, np.setdiff1d(of_robots, some))
                for some in np.array_split(of_robots, groups)
            ],
        )
    ]
    if sets > 1:
        pseudo.append(
            _pseudo_values(value, [changed(np.delete(of_sets, k), of_robots) for k in range(sets)])
        )
    variance, freedom = satterthwaite(
        [variance_of_mean(each) for each in pseudo], [len(each) - 1 for each in pseudo]
    )
    return _about(value, student(freedom) * math.sqrt(variance))


def root_mean_square_difference(before: Floats, after: Floats) -> Estimate:
    """Return the difference of the root mean square from mean squares (set of poses,) over
    independent sets, with its interval.

    The value is exact at the poses; the interval, by the delta method on the differences of the
    sets, is due to their choice. NaN ends for one set.
    """
    roots = [math.sqrt(float(squares.mean())) for squares in (before, after)]
    slopes = [
        squares / (2 * root) if root > 0 else np.zeros(len(squares))
        for squares, root in zip((before, after), roots, strict=True)
    ]
    return _of_sets(roots[1] - roots[0], slopes[1] - slopes[0])


def sets_difference(before: Floats, after: Floats) -> Estimate:
    """Return the difference of a mean over poses from means (set of poses,), with its interval,
    which is due to the choice of poses.
    """
    return _of_sets(float(after.mean()) - float(before.mean()), after - before)


def share_of_difference(changes: Floats, total_before: Floats, total_after: Floats) -> Estimate:
    """Return how much of the difference of the root mean square is due to one part, in its unit,
    with its interval.

    changes                    contributions of the part to the change of the mean square, over
                               independent sets of poses (set,)
    total_before, total_after  mean squares of the whole arm (set,)

    With the roots r and R of the total mean squares before and after, R - r = (R² - r²) / (R + r).
    So contributions of parts that add to the change of the mean square, divided by R + r, add to
    the difference of the roots, exactly. Interval as for `root_mean_square_difference`.
    """
    roots = [math.sqrt(float(squares.mean())) for squares in (total_before, total_after)]
    both = roots[0] + roots[1]
    if not both > 0:
        return ZERO
    value = float(changes.mean()) / both
    moved = sum(
        squares / (2 * root) if root > 0 else np.zeros(len(squares))
        for squares, root in zip((total_before, total_after), roots, strict=True)
    )
    return _of_sets(value, (changes - value * moved) / both)


def _quantile_of_robots(means: Floats, level: float) -> float:
    return float(robots_quantile(shrunk_means(means), level)[0])


def _pseudo_values(whole: float, without: Sequence[float]) -> Floats:
    """Return the jackknife pseudo-values (member,) from the value of all members, and those without
    each.
    """
    count = len(without)
    return count * whole - (count - 1) * np.array(without)


def _of_sets(value: float, members: Floats) -> Estimate:
    """Return an estimate with the interval that the differences between sets of poses (set,) show;
    NaN ends for a single set.
    """
    return _about(value, student(len(members) - 1) * math.sqrt(variance_of_mean(members)))


def _about(value: float, half: float) -> Estimate:
    return Estimate(value, value - half, value + half)
