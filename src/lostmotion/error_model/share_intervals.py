"""Confidence intervals of shares: of all samples up to a length, and of successes in independent
trials.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Literal

from lostmotion.error_model.intervals import Estimate, share_spread, shares_below

if TYPE_CHECKING:
    import numpy as np


def share_below(
    group_hist: np.ndarray, replicate_hist: np.ndarray, value: float, robots: int
) -> Estimate:
    """Return the share, 0..1, of all samples that are at most a length (m), with its confidence
    interval.

    group_hist, replicate_hist  (group of robots, bin), (set of poses, bin): counts of all samples
                                by length
    robots                      number of robots, for a share of none or all of the samples

    The spread of `share_spread` is added to the log odds, so both ends stay between 0 and 1. A
    share of 0 or 1 shows no differences: its interval is then that of as many independent trials as
    there are robots (`share_interval`). NaN ends for a single group of robots.
    """
    share = float(shares_below(group_hist.sum(axis=0)[None], value)[0])
    if len(group_hist) < 2:  # noqa: PLR2004 - a single one shows no differences
        return Estimate(share, math.nan, math.nan)
    half = share_spread(group_hist, replicate_hist, value).half
    if not 0 < share < 1 or not half > 0:
        return Estimate(share, *share_interval(round(share * robots), robots))
    odds, factor = share / (1 - share), math.exp(half / (share * (1 - share)))
    low, high = (odds * by / (1 + odds * by) for by in (1 / factor, factor))
    return Estimate(share, low, high)


@functools.lru_cache(maxsize=4096)  # SciPy searches the ends; a curve asks for many twice
def share_interval(
    hits: int,
    count: int,
    confidence: float = 0.95,
    method: Literal["wilson", "exact"] = "wilson",
) -> tuple[float, float]:
    """Return the confidence interval of a share, 0..1, after `hits` successes in `count`
    independent trials, by SciPy.

    method  "wilson": its coverage is nominal on average over shares (E. Wilson, J. American
            Statistical Association 22 (1927) 209); "exact": at least nominal for every share
            (C. Clopper, E. Pearson, Biometrika 26 (1934) 404)
    Raises ValueError for hits outside 0..count, no count, or a confidence outside 0..1.
    """
    from scipy.stats import binomtest

    low, high = binomtest(hits, count).proportion_ci(confidence, method)
    return float(low), float(high)
