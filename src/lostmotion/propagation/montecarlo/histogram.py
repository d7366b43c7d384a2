"""Histograms of errors with bins of a round width, and the uncertainty of their heights."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.error_bins import bin_edges
from lostmotion.error_model.intervals import student

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

_ABOUT_BINS: Final = 60
_NICE: Final = (1.0, 2.0, 2.5, 5.0, 10.0)


def linear_bins(hist: np.ndarray) -> tuple[Floats, np.ndarray]:
    """Return `hist` (error_bins.BINS,) in equal bins of a round width: edges (bin + 1,), m, and
    counts (bin,), which add up to all samples.
    """
    fine = bin_edges()
    occupied = np.flatnonzero(hist)
    edges = round_edges(float(fine[occupied[0]]), float(fine[occupied[-1] + 1]), _ABOUT_BINS)
    return edges, counts_between(hist, edges)


def counts_between(hist: np.ndarray, edges: Floats) -> np.ndarray:
    """Return the counts (bin,) of `hist` (error_bins.BINS,) between these edges (bin + 1,), m,
    linearly interpolated within its bins.
    """
    below = np.rint(np.interp(edges, bin_edges(), np.concatenate([[0.0], np.cumsum(hist)])))
    return np.asarray(np.diff(below), dtype=np.int64)


def binned(values: Floats, about: int) -> tuple[Floats, np.ndarray]:
    """Return edges (bin + 1,) and counts (bin,) of these values (value,) in about `about` equal
    bins of a round width.
    """
    edges = round_edges(float(values.min()), float(values.max()), about)
    return edges, np.histogram(np.clip(values, edges[0], edges[-1]), edges)[0]


def round_edges(low: float, high: float, about: int) -> Floats:
    """Return edges of about `about` bins of a round width that cover low … high, m. A span of zero
    counts as 1 % of its value, and at least 1 nm.
    """
    width = max(high - low, 0.01 * abs(high), 1e-9) / about
    power = 10.0 ** math.floor(math.log10(width))
    width = power * min(_NICE, key=lambda nice: abs(math.log(nice * power / width)))
    first, last = math.floor(low / width), math.ceil(high / width)
    return np.asarray(np.arange(first, max(last, first + 1) + 1) * width, dtype=np.float64)


def share_intervals(group_hist: np.ndarray, edges: Floats) -> Floats:
    """Return the share of all samples in each bin with its 95 % interval: (bin, 3).

    group_hist (group, error_bins.BINS), edges (bin + 1,), m. The interval counts groups of robots;
    its ends are NaN where there is only one group.
    """
    fine = bin_edges()
    below = np.array(
        [
            np.interp(edges, fine, np.concatenate([[0.0], np.cumsum(hist)])) / hist.sum()
            for hist in group_hist
        ]
    )
    shares = np.diff(below, axis=1)
    weights = group_hist.sum(axis=1) / group_hist.sum()
    share = weights @ shares
    count = len(group_hist)
    half = (
        student(count - 1) * shares.std(axis=0, ddof=1) / math.sqrt(count)
        if count > 1
        else np.full(len(share), math.nan)
    )
    return np.column_stack([share, np.maximum(share - half, 0.0), share + half])
