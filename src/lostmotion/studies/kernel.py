"""The fused Monte Carlo kernel: error = screws @ draws, tile by tile, reduced on the spot; no sample is kept.

Robots lie side by side in lanes of one tile; a tile's draws fit the first cache. Every sum over terms runs in the order of the terms, so
the bits of a sample depend neither on the tiling nor on which other terms are zero. Compiled once by Numba and cached; no threads in here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

LANES: Final = 128
TABLE: Final = 8192
ROW: Final = TABLE + LANES  # a table, and its beginning once more to run on into
# Histogram over the squared error in m^2: 128 bins per factor of two, from 2^-64 (0.2 nm) to 2^8 (16 m).
_LOWEST_EXPONENT: Final = -64
_HIGHEST_EXPONENT: Final = 8
_MANTISSA_BITS: Final = 7
BINS: Final = (_HIGHEST_EXPONENT - _LOWEST_EXPONENT) << _MANTISSA_BITS
_SHIFT: Final = 52 - _MANTISSA_BITS
_FIRST: Final = (1023 + _LOWEST_EXPONENT) << _MANTISSA_BITS
_BASE_BITS: Final = _FIRST << _SHIFT
_SMALLEST: Final = 2.0**_LOWEST_EXPONENT
_LARGEST: Final = 2.0**_HIGHEST_EXPONENT * (1 - 2.0**-53)

# Bins of a pose's own histogram, from its smallest to its largest error.
_FINE: Final = 1024

# Columns of the table per pose.
MEAN, MEAN_ERROR, MEAN_SQUARE, LARGEST, LARGEST_ROBOT, LARGEST_VISIT = range(6)
QUANTILES: Final = (0.5, 0.95, 0.99)
FIRST_QUANTILE: Final = 6  # value, low end, high end of each quantile
COLUMNS: Final = FIRST_QUANTILE + 3 * len(QUANTILES)
_LEVELS: Final = np.array(QUANTILES)

_jit = njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"}, boundscheck=False)


def bin_edges() -> Floats:
    """Where do the histogram's bins begin, in metres of error? (BINS + 1,), rising."""
    bits = (np.arange(BINS + 1, dtype=np.int64) << _SHIFT) + _BASE_BITS
    return np.sqrt(bits.view(np.float64))


@_jit
def mix(x):
    """Scatter the bits of a counter (the finaliser of SplitMix64; G. Steele et al., OOPSLA 2014)."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@_jit
def _add_four(out, screws, t, d0, d1, d2, d3):
    """Add four terms, in their order, to the three components of LANES errors; draws are loaded once."""
    x0, x1, x2, x3 = screws[0, t], screws[0, t + 1], screws[0, t + 2], screws[0, t + 3]
    y0, y1, y2, y3 = screws[1, t], screws[1, t + 1], screws[1, t + 2], screws[1, t + 3]
    z0, z1, z2, z3 = screws[2, t], screws[2, t + 1], screws[2, t + 2], screws[2, t + 3]
    x, y, z = out[0], out[1], out[2]
    for i in range(LANES):
        a, b, c, d = d0[i], d1[i], d2[i], d3[i]
        x[i] = x[i] + x0 * a + x1 * b + x2 * c + x3 * d
        y[i] = y[i] + y0 * a + y1 * b + y2 * c + y3 * d
        z[i] = z[i] + z0 * a + z1 * b + z2 * c + z3 * d


@_jit
def _quantile(ladder, rank, low, width):
    """Which error leaves `rank` samples below it? Straight line within a bin; `ladder` counts up the bins, which begin at `low`."""
    b = min(np.searchsorted(ladder, rank), len(ladder) - 1)
    before = ladder[b - 1] if b > 0 else 0.0
    return low + width * (b + max(rank - before, 0.0) / max(ladder[b] - before, 1.0))


@_jit
def _pose_quantiles(sizes, robots, low, high, between, z, bins, hist, shares, out):
    """Put one pose's quantiles and their intervals into `out` (3 per quantile: value, low end, high end).

    sizes (tile, visit, LANES) hold the errors, between low and high; `between` is the share of their variance that lies between robots.
    Intervals count robots: Woodruff's method for clusters (J. Am. Stat. Assoc. 47 (1952) 635), and never surer than the design effect
    1 + (visits - 1) between allows (L. Kish, Survey Sampling, 1965, 5.4). An end that the sample cannot tell is NaN.
    """
    tiles, visits = sizes.shape[0], sizes.shape[1]
    samples = robots * visits
    width = (high - low) / _FINE
    scale = 1.0 / width if width > 0 else 0.0
    hist[:] = 0
    for tile in range(tiles):
        count = min(LANES, robots - tile * LANES)
        for v in range(visits):
            for i in range(LANES):
                bins[tile, v, i] = np.uint16(min(max((sizes[tile, v, i] - low) * scale, 0.0), _FINE - 1.0))
            for i in range(count):
                hist[bins[tile, v, i]] += 1
    ladder = np.cumsum(hist)
    for k in range(len(_LEVELS)):
        level = _LEVELS[k]
        at = min(np.searchsorted(ladder, level * samples), _FINE - 1)
        below = ladder[at] / samples
        spread2 = below
        if visits > 1:
            spread2 = 0.0
            limit = np.uint16(at)
            for tile in range(tiles):
                shares[:] = 0
                for v in range(visits):
                    for i in range(LANES):
                        shares[i] += bins[tile, v, i] <= limit
                for i in range(min(LANES, robots - tile * LANES)):
                    spread2 += (shares[i] / visits) ** 2
            spread2 /= robots
        clusters = max(spread2 - below * below, 0.0) / max(robots - 1, 1)
        at_least = level * (1 - level) * (1 + (visits - 1) * between) / samples
        error = z * np.sqrt(max(clusters, at_least))
        out[3 * k] = _quantile(ladder, level * samples, low, width)
        out[3 * k + 1] = _quantile(ladder, (level - error) * samples, low, width) if level - error > 0 else np.nan
        out[3 * k + 2] = _quantile(ladder, (level + error) * samples, low, width) if level + error < 1 else np.nan


@_jit
def run_block(
    first_pose,  # index of the first pose in the whole study
    bias,  # (pose, 3)
    robot_screws,  # (pose, 3, term), count of terms a multiple of four
    robot_draws,  # (tile, term, LANES)
    visit_screws,  # (pose, 3, term), count a multiple of four
    visit_tables,  # (term,) row in `tables`
    visit_keys,  # (term,) key of the stream
    product_screws,  # (pose, 3, term)
    product_tables,
    product_keys,
    product_factors,  # (tile, term, LANES)
    tables,  # (rows of ROW, one after another)
    robots,
    visits,
    groups,  # number of robot groups; robot r belongs to group r * groups // robots
    z,  # half-width of the interval in standard errors; NaN where there is none
    per_pose,  # out (pose, COLUMNS)
    ap_rp,  # out (pose, 2, robot), used where visits > 1
    robot_sums,  # out (robot,) sum over poses of the robot's mean error
    group_hist,  # out (group, BINS) of all poses in this block
):
    """Form the errors of every pose, robot and visit of one block of poses, and reduce them."""
    tiles = robot_draws.shape[0]
    n_robot, n_visit, n_product = robot_screws.shape[2], visit_screws.shape[2], product_screws.shape[2]
    fixed = np.empty((3, LANES))
    e = np.empty((3, LANES))
    weight = np.empty(LANES)
    kept = np.empty((visits, 3, LANES))
    centre = np.empty((3, LANES))
    length, length2 = np.empty(LANES), np.empty(LANES)
    squares = np.empty(LANES)
    clamped = np.empty(LANES)
    words = clamped.view(np.int64)
    robot_sum, robot_sum2, smallest = np.empty(LANES), np.empty(LANES), np.empty(LANES)
    total, total2, between2, record_low = np.empty(LANES), np.empty(LANES), np.empty(LANES), np.empty(LANES)
    group_of = np.arange(robots) * groups // robots
    per_visit = 1.0 / visits
    at_visit = np.empty(max(n_visit, 1), np.int64)
    at_product = np.empty(max(n_product, 1), np.int64)
    sizes = np.empty((tiles, visits, LANES), np.float32)
    bins = np.empty((tiles, visits, LANES), np.uint16)
    hist = np.empty(_FINE, np.int64)
    shares = np.empty(LANES, np.int32)
    for p in range(bias.shape[0]):
        total[:] = total2[:] = between2[:] = 0.0
        record_low[:] = np.inf
        record = -1.0
        for tile in range(tiles):
            first = tile * LANES
            count = min(LANES, robots - first)
            for c in range(3):
                for i in range(LANES):
                    fixed[c, i] = bias[p, c]
            for t in range(0, n_robot, 4):
                _add_four(
                    fixed, robot_screws[p], t, robot_draws[tile, t], robot_draws[tile, t + 1], robot_draws[tile, t + 2], robot_draws[tile, t + 3]
                )
            robot_sum[:] = robot_sum2[:] = 0.0
            smallest[:] = np.inf
            centre[:, :] = 0.0
            counter = np.uint64(first_pose + p) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(tile) * np.uint64(0xD1B54A32D192ED03)
            for v in range(visits):
                here = counter + np.uint64(v) * np.uint64(0xABC98388FB8FAC03)
                for t in range(n_visit):
                    at_visit[t] = visit_tables[t] * ROW + np.int64(mix(here ^ visit_keys[t]) >> np.uint64(51))
                for t in range(n_product):
                    at_product[t] = product_tables[t] * ROW + np.int64(mix(here ^ product_keys[t]) >> np.uint64(51))
                for c in range(3):
                    for i in range(LANES):
                        e[c, i] = fixed[c, i]
                for t in range(0, n_visit, 4):
                    a0, a1, a2, a3 = at_visit[t], at_visit[t + 1], at_visit[t + 2], at_visit[t + 3]
                    d0, d1, d2, d3 = tables[a0 : a0 + LANES], tables[a1 : a1 + LANES], tables[a2 : a2 + LANES], tables[a3 : a3 + LANES]
                    _add_four(e, visit_screws[p], t, d0, d1, d2, d3)
                for t in range(n_product):
                    a0 = at_product[t]
                    d0 = tables[a0 : a0 + LANES]
                    for i in range(LANES):
                        weight[i] = product_factors[tile, t, i] * d0[i]
                    for c in range(3):
                        s0 = product_screws[p, c, t]
                        for i in range(LANES):
                            e[c, i] = e[c, i] + s0 * weight[i]
                for i in range(LANES):
                    squares[i] = e[0, i] * e[0, i] + e[1, i] * e[1, i] + e[2, i] * e[2, i]
                for i in range(LANES):
                    size = np.sqrt(squares[i])
                    sizes[tile, v, i] = size
                    robot_sum[i] += size
                    robot_sum2[i] += squares[i]
                    smallest[i] = min(smallest[i], squares[i])
                if visits > 1:
                    for c in range(3):
                        for i in range(LANES):
                            kept[v, c, i] = e[c, i]
                            centre[c, i] += e[c, i]
                for i in range(LANES):
                    clamped[i] = min(max(squares[i], _SMALLEST), _LARGEST)
                for i in range(count):
                    group_hist[group_of[first + i], (words[i] >> _SHIFT) - _FIRST] += 1
                    if squares[i] > record:
                        record = squares[i]
                        per_pose[p, LARGEST_ROBOT] = first + i
                        per_pose[p, LARGEST_VISIT] = v
            for i in range(count):
                robot_sum[i] *= per_visit
                robot_sums[first + i] += robot_sum[i]
            for i in range(count, LANES):
                robot_sum[i] = robot_sum2[i] = 0.0
                smallest[i] = np.inf
            for i in range(LANES):
                total[i] += robot_sum[i]
                total2[i] += robot_sum2[i]
                between2[i] += robot_sum[i] * robot_sum[i]
                record_low[i] = min(record_low[i], smallest[i])
            if visits > 1:
                for i in range(LANES):
                    length[i] = length2[i] = 0.0
                    for c in range(3):
                        centre[c, i] /= visits
                for v in range(visits):
                    for i in range(LANES):
                        x, y, w = kept[v, 0, i] - centre[0, i], kept[v, 1, i] - centre[1, i], kept[v, 2, i] - centre[2, i]
                        square = x * x + y * y + w * w
                        length[i] += np.sqrt(square)
                        length2[i] += square
                for i in range(count):
                    mean = length[i] / visits
                    spread = max(length2[i] - visits * mean * mean, 0.0) / (visits - 1)
                    ap_rp[p, 0, first + i] = np.sqrt(centre[0, i] ** 2 + centre[1, i] ** 2 + centre[2, i] ** 2)
                    ap_rp[p, 1, first + i] = mean + 3 * np.sqrt(spread)
        samples = robots * visits
        mean = total.sum() / robots
        per_pose[p, MEAN] = mean
        per_pose[p, MEAN_ERROR] = z * np.sqrt(max(between2.sum() / robots - mean * mean, 0.0) / max(robots - 1, 1))
        per_pose[p, MEAN_SQUARE] = total2.sum() / samples
        per_pose[p, LARGEST] = np.sqrt(record)
        # Sums of squares and of squared robot means give the variance of all sizes and of the robots' means.
        variance = total2.sum() / samples - mean * mean
        of_means = between2.sum() / robots - mean * mean
        between = min(max(of_means / variance, 0.0), 1.0) if variance > 0 else 0.0
        low, high = np.sqrt(record_low.min()), np.sqrt(record)
        _pose_quantiles(sizes, robots, low, high, between, z, bins, hist, shares, per_pose[p, FIRST_QUANTILE:])
