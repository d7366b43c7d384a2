"""Confidence intervals of pooled figures. They count robots and sets of poses, never samples.

A robot's errors resemble each other, so a thousand robots returning thirty times are a thousand things known, not thirty thousand.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.error_bins import bin_edges

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# A quantile from the histogram is precise to a tenth of a bin's width of 0.27 %.
RESOLUTION: Final = 2.7e-4
# The level of every interval that does not state another.
_CONFIDENCE: Final = 0.95
# Groups of robots that separate the choice of robots from that of poses: at most so many, of at least so many robots.
_GROUPS: Final = 16
_IN_GROUP: Final = 20
# A variance with a smaller share of the mean square is rounding; and the bins must resolve the variance to this share of itself.
_ROUNDING: Final = 1e-12
_RESOLVED: Final = 0.05


# Called thousands of times when one group of robots is omitted at a time.
_edges = functools.cache(bin_edges)


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value and the ends of its 95 % interval; NaN ends where the sample cannot determine them (one robot, for example)."""

    value: float
    low: float
    high: float

    @property
    def half(self) -> float:
        """Return half of the interval's width; of one that ends at zero, where a length ends, no less than its upper half."""
        half = (self.high - self.low) / 2
        return half if self.low > 0 else max(half, self.high - self.value)


def of_length(value: float, low: float, high: float) -> Estimate:
    """Return an estimate of a length, or of any size that cannot be below zero, with the interval from `low` to `high` as far as it lies above zero.

    The true value is not negative, so the omitted part never contained it: the coverage is unchanged. NaN ends stay.
    """
    return Estimate(value, max(low, 0.0), high)


@dataclass(frozen=True, slots=True)
class Spread:
    """What is left of uncertainty: the variance that more robots take down, the one that more poses take down, and half of the 95 % interval."""

    of_robots: float
    of_poses: float
    half: float


def quantile(hist: np.ndarray, level: float) -> float:
    """Return the quantile of a histogram, m, linear within a bin of 0.3 % width.

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
    low, high = (float(edge) for edge in _edges()[at : at + 2])
    return float(low + (high - low) * max(rank - before, 0.0) / max(float(hist[at]), 1.0))


def pooled_quantile(group_hist: np.ndarray, replicate_hist: np.ndarray, level: float, largest: float = math.inf) -> Estimate:
    """Return a quantile of all samples with its confidence interval.

    The share below differs from group to group of robots and from set to set of poses; what that leaves of the share's own uncertainty is read
    back as errors (R. Woodruff, J. Am. Stat. Assoc. 47 (1952) 635), so that the longer tail has the longer half. Never inside the bin that the
    value was read in; NaN for an end beyond all samples. Poses that were given or gridded are taken as they are. `largest` is the largest sample, m:
    no quantile lies above it. Infinite, with no interval, from 16 m, where the histogram no longer resolves errors.
    """
    hist = group_hist.sum(axis=0)
    value = quantile(hist, level)
    if math.isinf(value):
        return Estimate(value, math.nan, math.nan)
    if len(group_hist) < 2:  # noqa: PLR2004 - one robot does not show how others differ
        return Estimate(min(value, largest), math.nan, math.nan)
    half = share_spread(group_hist, replicate_hist, value).half
    value = min(value, largest)
    at = int(np.searchsorted(_edges(), value, side="right"))
    bin_low, bin_high = (0.0, 0.0) if value == 0 else (float(_edges()[k]) for k in (max(at - 1, 0), min(at, len(hist))))
    # Added to the log odds, so that both ends stay shares: those of 99 % stay below 100 %.
    odds, wide = level / (1 - level), math.exp(half / (level * (1 - level)))
    ends = [quantile(hist, odds * by / (1 + odds * by)) for by in (1 / wide, wide)]
    return Estimate(value, min(ends[0], bin_low, value), max(min(ends[1], largest), bin_high, value))


def standard_deviation(group_hist: np.ndarray, replicate_hist: np.ndarray, mean: float, mean_square: float) -> Estimate:
    """Return the standard deviation of all errors' lengths, m, with its interval, which counts groups of robots and sets of poses.

    mean, mean_square  of all samples, m and m^2: they give the value; the counts by length (group or set, bin) give the interval, by the delta
                       method on mean squares about the common mean, as in `share_spread`

    NaN ends for a single robot, and where lengths differ by so little that the bins of 0.3 % do not resolve it.
    """
    variance = mean_square - mean * mean
    if variance <= _ROUNDING * mean_square:
        return Estimate(0.0, 0.0, 0.0)
    value = math.sqrt(variance)
    centres = np.sqrt(_edges()[:-1] * _edges()[1:])
    off = (centres - mean) ** 2
    members = [hists @ off / np.maximum(hists.sum(axis=1), 1) for hists in (group_hist, replicate_hist)]
    counted = float(group_hist.sum(axis=0) @ off / group_hist.sum())
    if len(group_hist) < 2 or abs(counted / variance - 1) > _RESOLVED:  # noqa: PLR2004 - one robot does not show how others differ
        return Estimate(value, math.nan, math.nan)
    of_variance, freedom = _satterthwaite([_mean_square(each) for each in members], [len(each) - 1 for each in members])
    # On the logarithm, so that no end lies below zero.
    wide = math.exp(student(freedom) * math.sqrt(of_variance) / (2 * variance))
    return Estimate(value, value / wide, value * wide)


def share_spread(group_hist: np.ndarray, replicate_hist: np.ndarray, value: float) -> Spread:
    """Return the uncertainty of the share of all samples below a value (m).

    The contribution of one cell of group and set counts in both families: never too narrow, at most by a root of two too wide.
    """
    squares = [_mean_square(_shares_below(hists, value)) for hists in (group_hist, replicate_hist)]
    variance, freedom = _satterthwaite(squares, [len(group_hist) - 1, len(replicate_hist) - 1])
    return Spread(squares[0], squares[1], student(freedom) * math.sqrt(variance))


def _shares_below(hists: np.ndarray, value: float) -> Floats:
    """Return the share of each histogram's samples (member, bin) below the value: (member,), linear within a bin."""
    edges = _edges()
    at = int(np.clip(np.searchsorted(edges, value, side="right") - 1, 0, hists.shape[1] - 1))
    part = min(max((value - edges[at]) / (edges[at + 1] - edges[at]), 0.0), 1.0)
    return np.asarray((hists[:, :at].sum(axis=1) + part * hists[:, at]) / np.maximum(hists.sum(axis=1), 1))


def pseudo_values(hists: np.ndarray, level: float) -> Floats:
    """Return the jackknife pseudo-values (member,) of a quantile from histograms (member, bin)."""
    whole = hists.sum(axis=0)
    count = len(hists)
    if count == 1:
        return np.array([quantile(whole, level)])
    return np.array([count * quantile(whole, level) - (count - 1) * quantile(whole - one, level) for one in hists])


def pooled_mean(robot_means: Floats) -> Estimate:
    """Return the mean over robots and poses of these means (set of poses, robot) with its confidence interval.

    Robots and sets of poses are two ways of drawing that cross: each set is visited by all robots (`two_way`). Of lengths: no end is below zero.
    """
    value = float(robot_means.mean())
    if robot_means.shape[1] < 2:  # noqa: PLR2004 - one robot does not show how others differ
        return Estimate(value, math.nan, math.nan)
    half = two_way(robot_means).half
    return of_length(value, value - half, value + half)


def root_mean_square(of_sets: Floats) -> Estimate:
    """Return the root of the mean of these mean squares, exact over each independent set of poses (set,), with its interval.

    Student's interval of their mean, its ends' roots; NaN ends of one set, whose poses are taken as they are.
    """
    mean = float(of_sets.mean())
    half = student(len(of_sets) - 1) * math.sqrt(_mean_square(of_sets))
    return Estimate(math.sqrt(mean), float(np.sqrt(np.maximum(mean - half, 0.0))), math.sqrt(mean + half))


def root_mean_square_of_samples(squares: Floats) -> Estimate:
    """Return the root of the mean of positive squares (sample,) of independent samples, with its 95 % interval.

    Their sum is taken as a scaled chi-square law of the same mean and variance, with 2 n mean^2/variance degrees of freedom (F. Satterthwaite,
    Biometrics Bulletin 2 (1946) 110), which suits their long upper tail; exact for a normal error and for a harmonic of random phase.
    """
    from scipy.special import gammaincinv

    mean, variance = float(squares.mean()), float(squares.var(ddof=1)) if len(squares) > 1 else math.nan
    if not variance > 0:
        return Estimate(math.sqrt(mean), *((math.sqrt(mean),) * 2 if variance == 0 else (math.nan, math.nan)))
    half = len(squares) * mean**2 / variance  # of the degrees of freedom
    low, high = (float(gammaincinv(half, share)) / half for share in ((1 + _CONFIDENCE) / 2, (1 - _CONFIDENCE) / 2))
    return Estimate(math.sqrt(mean), math.sqrt(mean / low), math.sqrt(mean / high))


def two_way(values: Floats) -> Spread:
    """Return the uncertainty of the mean of these values (set of poses, robot or group of robots).

    Mean squares of both less the residual of each cell give the variance of the grand mean (S. Searle et al., Variance Components, 1992, ch. 4),
    F. Satterthwaite's formula (Biometrics Bulletin 2 (1946) 110) its degrees of freedom. A negative component counts as zero.
    """
    sets, robots = values.shape
    squares = [_mean_square(values.mean(axis=0)), _mean_square(values.mean(axis=1))]
    freedoms = [robots - 1, sets - 1]
    cells = _mean_square_of_cells(values)
    # The cells' part is in both; a family with less than that has no variance of its own.
    real = [k for k in (0, 1) if squares[k] > cells]
    if len(real) > 1:
        variance, freedom = _satterthwaite([*squares, -cells], [*freedoms, (sets - 1) * (robots - 1)])
    else:
        k = real[0] if real else 0
        variance, freedom = max(squares[k], cells), float(freedoms[k])
    of_poses = min(max(squares[1] - cells, 0.0), variance)
    return Spread(variance - of_poses, of_poses, student(freedom) * math.sqrt(variance))


def quantile_drop(before: tuple[np.ndarray, np.ndarray], after: tuple[np.ndarray, np.ndarray], level: float) -> Estimate:
    """Return the reduction of a quantile of all samples from before to after, each as counts by group of robots and by set of poses.

    Groups and sets are omitted one at a time, before and after together (jackknife, B. Efron 1982, ch. 3). Never narrower than the bins' width.
    """
    values = [quantile(hists[0].sum(axis=0), level) for hists in (before, after)]
    value = values[0] - values[1]
    if len(before[0]) < 2:  # noqa: PLR2004 - one robot does not show how others differ
        return Estimate(value, math.nan, math.nan)
    squares = [_mean_square(pseudo_values(first, level) - pseudo_values(second, level)) for first, second in zip(before, after, strict=True)]
    variance, freedom = _satterthwaite(squares, [len(hists) - 1 for hists in before])
    half = student(freedom) * math.sqrt(variance)
    half = max(half, RESOLUTION * values[0])
    return Estimate(value, value - half, value + half)


def robots_quantile(values: Floats, level: float = 0.95) -> Floats:
    """Return the quantile over robots (..., robot): (..., 3), the value and the ends of its interval.

    The ends are order statistics, interpolated between two robots where the binomial distribution requires it, so that the interval
    covers about its nominal level (A. Hutson, J. Applied Statistics 26 (1999) 343): each end is missed in 1.5 to 3 % from 128 robots on,
    whether tails are short or long, with fewer up to 5.5 %. An end outside the sample is NaN. For finite values.
    """
    from scipy.special import bdtr, bdtrik

    ordered = np.sort(values, axis=-1)
    count = values.shape[-1]
    out = np.full((*values.shape[:-1], 3), math.nan)
    out[..., 0] = ordered[..., math.ceil(level * count) - 1]
    for k, tail in enumerate(((1 - _CONFIDENCE) / 2, (1 + _CONFIDENCE) / 2), start=1):
        place = float(bdtrik(tail, count, level))  # robots before it, not a whole number
        if bdtr(0, count, level) <= tail and place <= count - 1:
            before = min(int(place), count - 2)
            out[..., k] = ordered[..., before] + (place - before) * (ordered[..., before + 1] - ordered[..., before])
    return out


def pooled_robots_quantile(robot_means: Floats, level: float = 0.95) -> Estimate:
    """Return the quantile over robots of their mean over the poses, with its confidence interval.

    robot_means (set of poses, robot). The means are shrunk by the variance due to few poses and visits, estimated from the sets; otherwise
    the value would be biased upwards. The order statistics' interval, widened by the uncertainty due to the choice of poses (`quantile_spread`).
    """
    value, low, high = (float(x) for x in robots_quantile(_shrunk_means(robot_means), level))
    of_poses = student(len(robot_means) - 1) * math.sqrt(quantile_spread(robot_means, level)) if len(robot_means) > 1 else 0.0
    return of_length(value, value - math.hypot(value - low, of_poses), value + math.hypot(high - value, of_poses))


def _shrunk_means(robot_means: Floats) -> Floats:
    """Return each robot's mean (robot,), shrunk to the variance between robots, from means over each set of poses (set of poses, robot).

    After T. Louis, J. Am. Stat. Assoc. 79 (1984) 393. One set alone gives no estimate of it.
    """
    found = robot_means.mean(axis=0)
    if min(robot_means.shape) < 2:  # noqa: PLR2004 - nothing differs
        return np.asarray(found)
    whole, seen = found.mean(), _mean_square(found)
    real = max(1 - _mean_square_of_cells(robot_means) / seen, 0.0) if seen > 0 else 0.0
    return np.asarray(whole + math.sqrt(real) * (found - whole))


def quantile_spread(robot_means: Floats, level: float = 0.95) -> float:
    """Return the variance that the choice of poses leaves in a quantile over robots (set of poses, robot).

    From the quantiles of groups of robots over each set, which separates the effect of the choice of robots (`two_way`).
    """
    sets, robots = robot_means.shape
    if sets < 2:  # noqa: PLR2004 - nothing differs
        return 0.0
    groups = min(max(robots // _IN_GROUP, 1), _GROUPS)
    of_groups = [np.quantile(part, level, axis=1) for part in np.array_split(robot_means, groups, axis=1)]
    return _mean_square(of_groups[0]) if groups < 2 else two_way(np.stack(of_groups, axis=1)).of_poses  # noqa: PLR2004 - too few robots to separate


def share_interval(hits: int, count: int) -> tuple[float, float]:
    """Return E. Wilson's 95 % interval (1927) of a share, 0..1, after so many hits among `count`."""
    z = 1.959963984540054
    share, wide = hits / count, 1 + z * z / count
    middle = (share + z * z / (2 * count)) / wide
    half = z / wide * math.sqrt(share * (1 - share) / count + (z / (2 * count)) ** 2)
    return max(middle - half, 0.0), min(middle + half, 1.0)


def _mean_square(members: Floats) -> float:
    """Return the squared standard error of the mean of independent members; none of a single one."""
    return float(members.var(ddof=1)) / len(members) if len(members) > 1 else 0.0


def _mean_square_of_cells(values: Floats) -> float:
    """Return what cells (set of poses, robot) differ by once sets and robots are taken out: its part in the squared error of the grand mean."""
    sets, robots = values.shape
    if sets < 2:  # noqa: PLR2004 - one set leaves nothing
        return 0.0
    rest = values - values.mean(axis=0) - values.mean(axis=1)[:, None] + values.mean()
    return float((rest**2).sum() / ((sets - 1) * (robots - 1)) / (sets * robots))


def _satterthwaite(squares: list[float], freedoms: list[int]) -> tuple[float, float]:
    """Add variances up: the sum, and how many degrees of freedom it has."""
    total = sum(squares)
    if not total > 0:
        return 0.0, float(max(freedoms))
    return total, total**2 / sum(square**2 / freedom for square, freedom in zip(squares, freedoms, strict=True) if freedom > 0)


def student(freedom: float, level: float | None = None) -> float:
    """Return half of an interval of this level in standard errors, with so many degrees of freedom; NaN for none."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, (1 + (level or _CONFIDENCE)) / 2)) if freedom > 0 else math.nan
