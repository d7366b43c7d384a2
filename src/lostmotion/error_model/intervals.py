"""Estimates, and confidence intervals of quantiles and shares over robots, poses and visits. The
sample size is that of robots and of sets of poses.

The errors of one robot are correlated, so a thousand robots that visit a pose thirty times are a
thousand independent samples, not thirty thousand. All intervals have a confidence of 95 %. Errors
are lengths in m, counted in histograms with the bins of `error_bins`.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.error_model.error_bins import BINS, bin_edges
from lostmotion.error_model.small_counts import (
    freedom_of_variance,
    order_statistics,
    satterthwaite,
)
from lostmotion.printed import BOUND_SIGNS, estimate_text

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Relative error of a quantile from the histogram: a tenth of a bin's width of 0.27 %.
RESOLUTION: Final = 2.7e-4
# Confidence of every interval for which no other is stated.
CONFIDENCE: Final = 0.95
# A variance below this share of the mean square is rounding.
_ROUNDING: Final = 1e-12
# Largest relative error of the variance that the bins may cause.
_RESOLVED: Final = 0.05

# Called thousands of times by the jackknife.
_edges = functools.cache(bin_edges)


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value and the ends of its 95 % confidence interval in SI; NaN ends where the sample cannot
    determine them (one robot, for example). `unit` is the SI unit where it is known.

    bound  the true value is no smaller ("lower"), or no larger ("upper"), because of what nobody
           stated
    """

    value: float
    low: float
    high: float
    unit: str = field(default="", compare=False, kw_only=True)
    bound: Literal["", "upper", "lower"] = field(default="", compare=False, kw_only=True)

    def __repr__(self) -> str:
        """Return the value with its unit and interval as people read them, a bound with its sign;
        without a known unit the bare numbers.
        """
        if self.unit:
            text = estimate_text(self.value, self.low, self.high, self.unit)
            return BOUND_SIGNS[self.bound] + text
        return f"Estimate({self.value!r}, {self.low!r}, {self.high!r})"

    @property
    def half(self) -> float:
        """Return half of the interval's width; for an interval cut off at zero, at least the
        distance from the value to the upper end.
        """
        half = (self.high - self.low) / 2
        return half if self.low > 0 else max(half, self.high - self.value)


def of_length(value: float, low: float, high: float) -> Estimate:
    """Return an estimate of a length, or of another quantity that cannot be negative; the part of
    its interval below zero is cut off.

    The true value is never in that part, so the coverage is unchanged. NaN ends stay NaN.
    """
    return Estimate(value, max(low, 0.0), high)


@dataclass(frozen=True, slots=True)
class Spread:
    """Uncertainty of a figure, by origin.

    of_robots  variance due to the number of robots
    of_poses   variance due to the number of poses
    half       half-width of the 95 % interval
    """

    of_robots: float
    of_poses: float
    half: float


def quantile(hist: np.ndarray, level: float) -> float:
    """Return the quantile (m) at `level`, 0..1, of a histogram of lengths, by linear interpolation
    in bins of 0.3 % width.

    Zero below a nanometre and infinite from 16 m, where the histogram ends.
    """
    return float(_quantiles(hist[None], level)[0])


def _quantiles(hists: np.ndarray, level: float, first: int = 0) -> Floats:
    """Return the `quantile` (member,), m, of each histogram (member, bin).

    first  bin with which they begin; where that is not the first of all, it is empty
    """
    cumulative = np.cumsum(hists, axis=1)
    rank = level * cumulative[:, -1]
    at = np.count_nonzero(cumulative < rank[:, None], axis=1)
    member = np.arange(len(hists))
    before = cumulative[member, np.maximum(at - 1, 0)]
    low, high = (_edges()[first + at + n] for n in (0, 1))
    out = low + (high - low) * np.maximum(rank - before, 0.0) / np.maximum(hists[member, at], 1)
    out[at == 0] = 0.0
    out[first + at == BINS - 1] = math.inf  # the last bin counts all larger errors
    return np.asarray(out)


def pooled_quantile(
    group_hist: np.ndarray, replicate_hist: np.ndarray, level: float, largest: float = math.inf
) -> Estimate:
    """Return a quantile (m) of all samples at `level`, 0..1, with its confidence interval.

    group_hist, replicate_hist  (group of robots, bin), (set of poses, bin): counts of all samples
                                by length
    largest                     largest sample, m; no quantile is above it

    The share of samples below the quantile differs between groups of robots and between sets of
    poses. The interval is that of as many independent samples as have the same variance of this
    share, by order statistics (R. Woodruff, J. Am. Stat. Assoc. 47 (1952) 635; E. Korn, B.
    Graubard, Survey Methodology 24 (1998) 193). Where all of so few may lie below the quantile, as
    with 200 robots where the worst of them alone make the 99th percentile, its upper end is the
    largest sample. The interval is at least the bin of the value. A quantile from 16 m is infinite
    and has no interval, because the histogram ends there. With one set of poses, given or on a
    grid, the interval does not include the choice of poses. NaN ends for a single group of robots.
    """
    hist = group_hist.sum(axis=0)
    value = quantile(hist, level)
    if math.isinf(value):
        return Estimate(value, math.nan, math.nan)
    if len(group_hist) < 2:  # noqa: PLR2004 - a single one shows no differences
        return Estimate(min(value, largest), math.nan, math.nan)
    half = share_spread(group_hist, replicate_hist, value).half
    value = min(value, largest)
    at = int(np.searchsorted(_edges(), value, side="right"))
    bin_low, bin_high = (
        (0.0, 0.0)
        if value == 0
        else (float(_edges()[k]) for k in (max(at - 1, 0), min(at, len(hist))))
    )
    # of independent samples with the same variance
    count = level * (1 - level) * (student(math.inf) / half) ** 2 if half > 0 else math.inf
    ends = [quantile(hist, share) for share in order_statistics(level, count, CONFIDENCE)]
    return Estimate(
        value, min(ends[0], bin_low, value), max(min(ends[1], largest), bin_high, value)
    )


def standard_deviation(
    group_hist: np.ndarray, replicate_hist: np.ndarray, mean: float, mean_square: float
) -> Estimate:
    """Return the standard deviation (m) of the lengths of all errors, with its confidence interval.

    group_hist, replicate_hist  (group of robots, bin), (set of poses, bin): counts of all samples
                                by length, for the interval
    mean, mean_square           of all samples, m and m^2, for the value

    The interval is found by the delta method from mean squares about the common mean, with
    variances as in `share_spread`. NaN ends for a single group of robots, and where the lengths
    differ by too little for the bins of 0.3 %.
    """
    variance = mean_square - mean * mean
    if variance <= _ROUNDING * mean_square:
        return Estimate(0.0, 0.0, 0.0)
    value = math.sqrt(variance)
    members = [squares_about(mean, hists) for hists in (group_hist, replicate_hist)]
    counted = float(squares_about(mean, group_hist.sum(axis=0, keepdims=True))[0])
    if len(group_hist) < 2 or abs(counted / variance - 1) > _RESOLVED:  # noqa: PLR2004 - a single one shows no differences
        return Estimate(value, math.nan, math.nan)
    of_variance, freedom = satterthwaite(
        [variance_of_mean(each) for each in members], [len(each) - 1 for each in members]
    )
    # Symmetric on the logarithm, so that no end is below zero.
    factor = math.exp(student(freedom) * math.sqrt(of_variance) / (2 * variance))
    return Estimate(value, value / factor, value * factor)


def squares_about(mean: float, hists: np.ndarray) -> Floats:
    """Return the mean square (m^2) about a mean (m) of the samples in each histogram (member,
    bin).
    """
    off = (np.sqrt(_edges()[:-1] * _edges()[1:]) - mean) ** 2
    return np.asarray(hists @ off / np.maximum(hists.sum(axis=1), 1))


def share_spread(group_hist: np.ndarray, replicate_hist: np.ndarray, value: float) -> Spread:
    """Return the uncertainty of the share of all samples below a value (m).

    The variance between groups of robots and that between sets of poses both contain the variance
    of single cells (group, set). So the interval is never too narrow, and at most too wide by a
    factor of sqrt(2). Where few robots have most of the samples above the value, their variance is
    itself uncertain, which leaves fewer degrees of freedom.
    """
    members = [shares_below(hists, value) for hists in (group_hist, replicate_hist)]
    squares = [variance_of_mean(each) for each in members]
    variance, freedom = satterthwaite(squares, [freedom_of_variance(each) for each in members])
    return Spread(squares[0], squares[1], student(freedom) * math.sqrt(variance))


def shares_below(hists: np.ndarray, value: float) -> Floats:
    """Return the share (member,) of the samples of each histogram (member, bin) below the value
    (m), linear within a bin.
    """
    edges = _edges()
    at = int(np.clip(np.searchsorted(edges, value, side="right") - 1, 0, hists.shape[1] - 1))
    part = min(max((value - edges[at]) / (edges[at + 1] - edges[at]), 0.0), 1.0)
    return np.asarray(
        (hists[:, :at].sum(axis=1) + part * hists[:, at]) / np.maximum(hists.sum(axis=1), 1)
    )


def pseudo_values(hists: np.ndarray, level: float) -> Floats:
    """Return the jackknife pseudo-values (member,), m, of the quantile at `level` of histograms
    (member, bin).
    """
    whole = hists.sum(axis=0)
    count, of_all = len(hists), quantile(whole, level)
    if count == 1:
        return np.array([of_all])
    # Of thousands of bins the errors of an arm fill some hundreds: those, and an empty one before;
    # all where there are no errors.
    filled = whole > 0
    first, end = max(int(filled.argmax()) - 1, 0), len(filled) - int(filled[::-1].argmax())
    rest = _quantiles(whole[first:end] - hists[:, first:end], level, first)
    with np.errstate(invalid="ignore"):  # infinite with and without a member: unknown
        return np.asarray(count * of_all - (count - 1) * rest)


def quantile_drop(
    before: tuple[np.ndarray, np.ndarray], after: tuple[np.ndarray, np.ndarray], level: float
) -> Estimate:
    """Return the reduction (m) of the quantile at `level` of all samples from before to after, with
    its confidence interval.

    before, after  histograms by group of robots (group, bin) and by set of poses (set, bin), of the
                   same robots and poses

    One group or set is omitted at a time, before and after together (jackknife, B. Efron 1982, ch.
    3). The interval is at least as wide as the error of a quantile from the bins. NaN ends for a
    single group of robots.
    """
    values = [quantile(hists[0].sum(axis=0), level) for hists in (before, after)]
    value = values[0] - values[1]
    if len(before[0]) < 2:  # noqa: PLR2004 - a single one shows no differences
        return Estimate(value, math.nan, math.nan)
    squares = [
        variance_of_mean(pseudo_values(first, level) - pseudo_values(second, level))
        for first, second in zip(before, after, strict=True)
    ]
    variance, freedom = satterthwaite(squares, [len(hists) - 1 for hists in before])
    half = student(freedom) * math.sqrt(variance)
    half = max(half, RESOLUTION * values[0])
    return Estimate(value, value - half, value + half)


def student(freedom: float, level: float | None = None) -> float:
    """Return the half-width, in standard errors, of Student's interval of confidence `level`
    (0..1), by default 95 %; NaN without freedom.
    """
    from scipy.special import stdtrit

    return float(stdtrit(freedom, (1 + (level or CONFIDENCE)) / 2)) if freedom > 0 else math.nan


def variance_of_mean(members: Floats) -> float:
    """Return the squared standard error of the mean of independent members (member,); zero for a
    single one.
    """
    return float(members.var(ddof=1)) / len(members) if len(members) > 1 else 0.0
