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
    """Which error (m) leaves this share of a histogram's samples below it? Straight line within a bin of 0.3 % width."""
    cumulative = np.cumsum(hist)
    rank = level * cumulative[-1]
    at = int(np.searchsorted(cumulative, rank))
    before = float(cumulative[at - 1]) if at else 0.0
    low, high = bin_edges()[at : at + 2]
    return float(low + (high - low) * max(rank - before, 0.0) / max(float(hist[at]), 1.0))


def pooled_quantile(group_hist: np.ndarray, replicate_hist: np.ndarray, level: float) -> Estimate:
    """Which error leaves this share of all samples below it, and how sure is that?

    The spread between groups of robots and between independent sets of poses each give a variance; the interval is Student's with the fewer
    degrees of freedom. Poses that were given or gridded are taken as they are.
    """
    value = quantile(group_hist.sum(axis=0), level)
    return _interval(value, [np.array([quantile(h, level) for h in hists]) for hists in (group_hist, replicate_hist)])


def pooled_mean(robot_means: Floats, replicate_means: Floats) -> Estimate:
    """What is the mean over robots and poses, and how sure is that? Robots and sets of poses counted as in `pooled_quantile`."""
    return _interval(float(robot_means.mean()), [robot_means, replicate_means])


def difference(first: Floats, second: Floats, value: float, resolution: float = 0.0) -> Estimate:
    """How sure is a difference that was formed group by group from the same draws? Never surer than the resolution it was read with."""
    found = _interval(value, [first - second])
    return Estimate(value, min(found.low, value - resolution), max(found.high, value + resolution))


def robots_quantile(values: Floats, level: float = 0.95) -> Estimate:
    """Which value do this share of the robots (robot,) stay below? Its interval by order statistics, free of any law (W. Conover 1999, 3.2)."""
    ordered = np.sort(values)
    count = len(ordered)
    half = 1.959963984540054 * math.sqrt(level * (1 - level) * count)
    low, high = math.floor(level * count - half) - 1, math.ceil(level * count + half) - 1
    return Estimate(
        float(ordered[max(math.ceil(level * count) - 1, 0)]),
        float(ordered[low]) if low >= 0 else math.nan,
        float(ordered[high]) if high < count else math.nan,
    )


def _interval(value: float, families: list[Floats]) -> Estimate:
    """Add the variances of the mean of each family of independent replications (those of one member add none)."""
    from scipy.special import stdtrit

    spread = [family for family in families if len(family) > 1]
    if len(families[0]) < 2:  # noqa: PLR2004 - one robot says nothing of others
        return Estimate(value, math.nan, math.nan)
    variance = sum(float(family.var(ddof=1)) / len(family) for family in spread)
    freedom = min(len(family) - 1 for family in spread)
    half = float(stdtrit(freedom, 0.975)) * math.sqrt(variance)
    return Estimate(value, value - half, value + half)
