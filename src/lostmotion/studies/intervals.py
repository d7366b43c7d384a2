"""How sure are the pooled figures? Intervals that count robots and sets of poses, never samples.

A robot's errors resemble each other, so a thousand robots returning thirty times are a thousand things known, not thirty thousand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.studies.kernel import bin_edges

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value and the ends of its 95 % interval; NaN ends where the sample cannot tell (one robot, for example)."""

    value: float
    low: float
    high: float


def quantile(hist: np.ndarray, level: float) -> float:
    """Which error (m) leaves this share of a histogram's samples below it? Straight line within a bin of 0.3 % width.

    Zero below a nanometre, infinite from 16 m: the histogram's ends.
    """
    cumulative = np.cumsum(hist)
    rank = level * cumulative[-1]
    at = int(np.searchsorted(cumulative, rank))
    if at == 0:
        return 0.0
    if at == len(hist) - 1:
        return math.inf  # the last bin holds all that is larger
    before = float(cumulative[at - 1])
    low, high = bin_edges()[at : at + 2]
    return float(low + (high - low) * max(rank - before, 0.0) / max(float(hist[at]), 1.0))


def pooled_quantile(group_hist: np.ndarray, replicate_hist: np.ndarray, level: float, largest: float = math.inf) -> Estimate:
    """Which error leaves this share of all samples below it, and how sure is that?

    Leaving out one group of robots, or one independent set of poses, at a time gives a variance each (jackknife, B. Efron 1982, ch. 3); the
    interval is Student's with the fewer degrees of freedom, and never inside the bin that the value was read in. Poses that were given or
    gridded are taken as they are. `largest` is the largest sample, m: no quantile lies above it.
    """
    hist = group_hist.sum(axis=0)
    value = min(quantile(hist, level), largest)
    found = _interval(value, [pseudo_values(hists, level) for hists in (group_hist, replicate_hist)])
    at = int(np.searchsorted(bin_edges(), value, side="right"))
    bin_low, bin_high = (0.0, 0.0) if value == 0 else bin_edges()[[max(at - 1, 0), min(at, len(hist))]]
    return Estimate(value, max(min(found.low, bin_low), 0.0), max(found.high, bin_high))


def pseudo_values(hists: np.ndarray, level: float) -> Floats:
    """What does each histogram (member, bin) add to the quantile of all? Jackknife pseudo-values (member,)."""
    whole = hists.sum(axis=0)
    count = len(hists)
    if count == 1:
        return np.array([quantile(whole, level)])
    return np.array([count * quantile(whole, level) - (count - 1) * quantile(whole - one, level) for one in hists])


def pooled_mean(robot_means: Floats) -> Estimate:
    """What is the mean over robots and poses of these means (set of poses, robot), and how sure is that?"""
    return _interval(float(robot_means.mean()), [robot_means.mean(axis=0), robot_means.mean(axis=1)])


def difference(first: Floats, second: Floats, value: float, resolution: float = 0.0) -> Estimate:
    """How sure is a difference of which each member's part is known, from the same draws? Never surer than the resolution it was read with."""
    found = _interval(value, [first - second])
    return Estimate(value, min(found.low, value - resolution), max(found.high, value + resolution))


def robots_quantile(values: Floats, level: float = 0.95) -> Floats:
    """Which value do this share of the robots (..., robot) stay below? (..., 3): the value and the ends of its interval.

    Order statistics, free of any law (W. Conover, Practical Nonparametric Statistics, 1999, 3.2); an end that lies outside the robots built is NaN.
    """
    ordered = np.sort(values, axis=-1)
    count = values.shape[-1]
    half = 1.959963984540054 * math.sqrt(level * (1 - level) * count)
    out = np.full((*values.shape[:-1], 3), math.nan)
    ranks = (math.ceil(level * count), math.floor(level * count - half), math.ceil(level * count + half))
    for k, rank in enumerate(ranks):
        if 1 <= rank <= count:
            out[..., k] = ordered[..., rank - 1]
    return out


def pooled_robots_quantile(robot_means: Floats, level: float = 0.95) -> Estimate:
    """Which value do this share of the robots stay below on the average over the poses, and how sure is that?

    robot_means (set of poses, robot). The order statistics' interval, widened by what the choice of poses leaves.
    """
    value, low, high = (float(x) for x in robots_quantile(robot_means.mean(axis=0), level))
    sets = len(robot_means)
    of_poses = 0.0
    if sets > 1:
        of_poses = student(sets - 1) * float(robots_quantile(robot_means, level)[:, 0].std(ddof=1)) / math.sqrt(sets)
    return Estimate(value, value - math.hypot(value - low, of_poses), value + math.hypot(high - value, of_poses))


def share_interval(hits: int, count: int) -> tuple[float, float]:
    """Between which shares, 0..1, does the true one lie with 95 %, after so many hits among `count`? E. Wilson's interval (1927)."""
    z = 1.959963984540054
    share, wide = hits / count, 1 + z * z / count
    middle = (share + z * z / (2 * count)) / wide
    half = z / wide * math.sqrt(share * (1 - share) / count + (z / (2 * count)) ** 2)
    return max(middle - half, 0.0), min(middle + half, 1.0)


def _interval(value: float, families: list[Floats]) -> Estimate:
    """Add the variances of the mean of each family of independent replications (those of one member add none)."""
    if len(families[0]) < 2:  # noqa: PLR2004 - one robot says nothing of others
        return Estimate(value, math.nan, math.nan)
    spread = [family for family in families if len(family) > 1]
    variance = sum(float(family.var(ddof=1)) / len(family) for family in spread)
    half = student(min(len(family) - 1 for family in spread)) * math.sqrt(variance)
    return Estimate(value, value - half, value + half)


def student(freedom: int) -> float:
    """How many standard errors is half of a 95 % interval, with so many degrees of freedom? NaN for none."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.975)) if freedom > 0 else math.nan
