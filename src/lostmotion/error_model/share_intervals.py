"""Confidence intervals of shares: of all samples up to a length, and of successes in independent
trials.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

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


def share_interval(hits: int, count: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a share, 0..1, after `hits` successes in `count`
    independent trials (E. Wilson 1927).
    """
    z = 1.959963984540054
    share, scale = hits / count, 1 + z * z / count
    middle = (share + z * z / (2 * count)) / scale
    half = z / scale * math.sqrt(share * (1 - share) / count + (z / (2 * count)) ** 2)
    return max(middle - half, 0.0), min(middle + half, 1.0)
