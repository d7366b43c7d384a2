"""The fused Monte Carlo kernel: error = screws @ draws, tile by tile, reduced on the spot; no
sample is kept.

Robots are the lanes of a tile; the draws of one tile fit in the first-level cache. Every sum over
terms runs in the order of the terms, in fused multiply-adds, so the bits of a sample depend neither
on the tiling, nor on which other terms are zero, nor on the processor. Compiled once by Numba and
cached; it uses no threads. For one visit per pose, `single_visit_kernel` computes the same figures
faster.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lostmotion.compiled import compiled
from lostmotion.error_model.draw_kernel import LANES, ROW, place_in_table
from lostmotion.error_model.error_bins import BINS, FIRST_BIN, SHIFT
from lostmotion.propagation.montecarlo.product_kernel import fma

# Bins of a pose's own histogram, from its smallest to its largest error.
FINE: Final = 1024

# Columns of the table per pose.
MEAN, MEAN_ERROR, MEAN_SQUARE, LARGEST, LARGEST_ROBOT, LARGEST_VISIT = range(6)
QUANTILES: Final = (0.5, 0.95, 0.99)
FIRST_QUANTILE: Final = 6  # value, low end, high end of each quantile
COLUMNS: Final = FIRST_QUANTILE + 3 * len(QUANTILES)
LEVELS: Final = np.array(QUANTILES)
_MOST: Final = np.iinfo(np.int64).max


@compiled
def _take(shift, columns, p, out):
    """Copy the screws (3, term) of these columns at one pose to `out`; a column below zero has no
    effect.
    """
    for t in range(len(columns)):
        for c in range(3):
            out[c, t] = shift[c, columns[t], p] if columns[t] >= 0 else 0.0


@compiled
def _add_terms(width, out, screws, draws, starts):
    """Add terms, in their order, to the three components of `width` errors: four at a time, so that
    draws are loaded once.

    The draws of a term begin at its position in `starts` (term,) of the flat array `draws`.
    """
    x, y, z = out[0], out[1], out[2]
    for t in range(0, len(starts), 4):
        x0, x1, x2, x3 = screws[0, t], screws[0, t + 1], screws[0, t + 2], screws[0, t + 3]
        y0, y1, y2, y3 = screws[1, t], screws[1, t + 1], screws[1, t + 2], screws[1, t + 3]
        z0, z1, z2, z3 = screws[2, t], screws[2, t + 1], screws[2, t + 2], screws[2, t + 3]
        d0, d1, d2, d3 = (
            draws[starts[t] :],
            draws[starts[t + 1] :],
            draws[starts[t + 2] :],
            draws[starts[t + 3] :],
        )
        for i in range(width):
            a, b, c, d = d0[i], d1[i], d2[i], d3[i]
            x[i] = fma(x3, d, fma(x2, c, fma(x1, b, fma(x0, a, x[i]))))
            y[i] = fma(y3, d, fma(y2, c, fma(y1, b, fma(y0, a, y[i]))))
            z[i] = fma(z3, d, fma(z2, c, fma(z1, b, fma(z0, a, z[i]))))


@compiled
def _sum_up_visit(width, e, sums, squares, sizes):
    """Add the errors of one visit (3, LANES) to the sums of each lane: of magnitudes, their
    squares, and the three components.
    """
    for i in range(width):
        x, y, z = e[0, i], e[1, i], e[2, i]
        square = fma(z, z, fma(y, y, x * x))
        size = np.sqrt(square)
        squares[i] = square
        sizes[i] = size
        sums[0, i] += size
        sums[1, i] += square
        sums[2, i] += x
        sums[3, i] += y
        sums[4, i] += z


@compiled
def _accuracy_and_repeatability(width, count, kept, sums, ap_rp):
    """Write each lane's AP and RP to ap_rp (2, lane), m, from its errors at every visit, kept
    (visit, 3, LANES), and their sums.
    """
    visits = len(kept)
    length, centre = sums[:2], sums[2:]
    length[:] = 0.0
    for c in range(3):
        for i in range(width):
            centre[c, i] /= visits
    for v in range(visits):
        for i in range(width):
            x, y, z = (
                kept[v, 0, i] - centre[0, i],
                kept[v, 1, i] - centre[1, i],
                kept[v, 2, i] - centre[2, i],
            )
            square = x * x + y * y + z * z
            length[0, i] += np.sqrt(square)
            length[1, i] += square
    for i in range(count):
        mean = length[0, i] / visits
        spread = max(length[1, i] - visits * mean * mean, 0.0) / (visits - 1)
        ap_rp[0, i] = np.sqrt(centre[0, i] ** 2 + centre[1, i] ** 2 + centre[2, i] ** 2)
        ap_rp[1, i] = mean + 3 * np.sqrt(spread)


@compiled
def bin_of(square):
    """Return the bin of the histogram of a squared error with these bits."""
    return min(max((square >> SHIFT) - FIRST_BIN, 0), BINS - 1)


@compiled
def _bin_of(ladder, rank):
    """Return the first bin whose cumulative count reaches `rank`, or the last bin. By bisection:
    NumPy's search takes a second to compile.
    """
    low, high = 0, len(ladder) - 1
    while low < high:
        middle = (low + high) // 2
        if ladder[middle] < rank:
            low = middle + 1
        else:
            high = middle
    return low


@compiled
def _quantile(ladder, rank, low, width):
    """Return the error with `rank` samples below it, linear within a bin; `ladder` counts up the
    bins, which begin at `low`.
    """
    b = _bin_of(ladder, rank)
    before = ladder[b - 1] if b > 0 else 0.0
    return low + width * (b + max(rank - before, 0.0) / max(ladder[b] - before, 1.0))


@compiled
def _pose_quantiles(sizes, robots, low, high, between, z, bins, hist, ladder, shares, out):
    """Write one pose's quantiles and their intervals to `out` (3 per quantile: value, low end, high
    end), m.

    sizes (tile, visit, LANES) hold the errors, between low and high; `between` is the share of
    their variance that lies between robots. Intervals count robots: Woodruff's method for clusters
    (J. Am. Stat. Assoc. 47 (1952) 635), and never narrower than the design effect
    1 + (visits - 1) between allows (L. Kish, Survey Sampling, 1965, 5.4). An end that the sample
    cannot determine is NaN.
    """
    tiles, visits = sizes.shape[0], sizes.shape[1]
    samples = robots * visits
    width = (high - low) / FINE
    low32, scale = np.float32(low), np.float32(1.0 / width if width > 0 else 0.0)
    hist[:] = 0
    for tile in range(tiles):
        count = min(LANES, robots - tile * LANES)
        for v in range(visits):
            for i in range(count):
                bins[tile, v, i] = np.uint16(
                    min(
                        max(np.int32((sizes[tile, v, i] - low32) * scale), np.int32(0)),
                        np.int32(FINE - 1),
                    )
                )
            for i in range(count):
                hist[bins[tile, v, i]] += 1
    counted = 0
    for b in range(FINE):
        counted += hist[b]
        ladder[b] = counted
    for k in range(len(LEVELS)):
        level = LEVELS[k]
        at = _bin_of(ladder, level * samples)
        below = ladder[at] / samples
        spread2 = below
        if visits > 1:
            counted2 = np.int64(0)
            limit = np.uint16(at)
            for tile in range(tiles):
                shares[:] = 0
                count = min(LANES, robots - tile * LANES)
                for v in range(visits):
                    for i in range(LANES):
                        shares[i] += bins[tile, v, i] <= limit
                for i in range(count):
                    counted2 += np.int64(shares[i]) * np.int64(shares[i])
            spread2 = counted2 / (float(visits) * visits * robots)
        clusters = max(spread2 - below * below, 0.0) / max(robots - 1, 1)
        at_least = level * (1 - level) * (1 + (visits - 1) * between) / samples
        error = z * np.sqrt(max(clusters, at_least))
        out[3 * k] = _quantile(ladder, level * samples, low, width)
        out[3 * k + 1] = (
            _quantile(ladder, (level - error) * samples, low, width)
            if level - error > 0
            else np.nan
        )
        out[3 * k + 2] = (
            _quantile(ladder, (level + error) * samples, low, width)
            if level + error < 1
            else np.nan
        )


@compiled
def counts(play):
    """Return whether a term counts in any robot: play (3,) holds the share with a closed play, and
    the factors of a closed and of an open one.
    """
    return (play[0] > 0.0 and play[1] != 0.0) or (play[0] < 1.0 and play[2] != 0.0)


@compiled
def weigh(width, factors, play, frictions, out):
    """Write each robot's factor on a term to out (lane,): its own factor times that of its play,
    closed where friction is at most the share.
    """
    for i in range(width):
        out[i] = factors[i] * (play[1] if frictions[i] <= play[0] else play[2])


@compiled
def run_block(
    first_pose,  # index of the first pose in the whole study
    bias,  # (pose, 3)
    shift,  # (3, column, pose) what every term does to the tool point per unit drawn
    # (pose, product term, 3) share of robots whose play is closed, and the factors of a closed and
    # of an open one
    plays,
    # (term,) columns of `shift`, a multiple of four; -1 for a term that does nothing
    robot_columns,
    robot_draws,  # (tile, term, LANES)
    visit_columns,  # (term,) likewise
    visit_tables,  # (term,) row in `tables`
    visit_keys,  # (term,) key of the stream
    product_columns,  # (term,)
    product_tables,
    product_keys,
    product_factors,  # (tile, term, LANES)
    frictions,  # (tile, product term, LANES)
    tables,  # (rows of ROW, one after another)
    robots,
    visits,
    groups,  # number of robot groups; robot r belongs to group r * groups // robots
    z,  # half-width of the interval in standard errors; NaN where there is none
    per_pose,  # out (pose, COLUMNS)
    ap_rp,  # out (pose, 2, robot), used where visits > 1
    robot_sums,  # out (robot,) sum over poses of the robot's mean error
    # out (group, ROW_OF_BINS), to which the errors of all poses in this block are added
    group_hist,
):
    """Form the errors of every pose, robot and visit of one block of poses, and reduce them; return
    the lowest and the highest bin they fell into.
    """
    tiles = robot_draws.shape[0]
    n_robot, n_visit, n_product = len(robot_columns), len(visit_columns), len(product_columns)
    robot_screws, visit_screws, product_screws = (
        np.empty((3, n_robot)),
        np.empty((3, n_visit)),
        np.empty((3, n_product)),
    )
    at_robot, at_visit, at_product = (
        np.empty(n_robot, np.int64),
        np.empty(n_visit, np.int64),
        np.empty(n_product, np.int64),
    )
    for t in range(n_robot):
        at_robot[t] = t * LANES
    fixed = np.empty((3, LANES))
    weight, weights = np.empty(LANES), np.empty((n_product, LANES))
    kept = np.empty((visits, 3, LANES))
    sums = np.empty((5, LANES))  # one array, so that the compiler knows its rows do not overlap
    words = np.empty(LANES, np.int64)
    squares = words.view(np.float64)
    places = np.empty((visits, LANES), np.uint16)
    total, total2, between2 = np.empty(LANES), np.empty(LANES), np.empty(LANES)
    group_of = np.empty(robots, np.int64)
    for r in range(robots):
        group_of[r] = r * groups // robots
    per_visit = 1.0 / visits
    sizes = np.empty((tiles, visits, LANES), np.float32)
    bins = np.empty((tiles, visits, LANES), np.uint16)
    hist, ladder = np.empty(FINE, np.int64), np.empty(FINE, np.int64)
    shares = np.empty(LANES, np.uint16)
    least_of_all, largest_of_all = _MOST, np.int64(-1)
    for p in range(bias.shape[0]):
        _take(shift, robot_columns, p, robot_screws)
        _take(shift, visit_columns, p, visit_screws)
        _take(shift, product_columns, p, product_screws)
        total[:] = total2[:] = between2[:] = 0.0
        # Squares are not negative, so their bits are in the order of their values.
        least, largest = _MOST, np.int64(-1)
        for tile in range(tiles):
            first = tile * LANES
            count = min(LANES, robots - first)
            width = (count + 15) & ~15
            for c in range(3):
                fixed[c] = bias[p, c]
            _add_terms(width, fixed, robot_screws, robot_draws[tile].ravel(), at_robot)
            sums[:, :] = 0.0
            for t in range(n_product):
                if counts(plays[p, t]):
                    weigh(
                        width, product_factors[tile, t], plays[p, t], frictions[tile, t], weights[t]
                    )
            for v in range(visits):
                for t in range(n_visit):
                    at_visit[t] = visit_tables[t] * ROW + place_in_table(
                        first_pose + p, tile, v, visit_keys[t]
                    )
                for t in range(n_product):
                    at_product[t] = product_tables[t] * ROW + place_in_table(
                        first_pose + p, tile, v, product_keys[t]
                    )
                e = kept[v]
                for c in range(3):
                    for i in range(LANES):
                        e[c, i] = fixed[c, i]
                _add_terms(width, e, visit_screws, tables, at_visit)
                for t in range(n_product):
                    if not counts(plays[p, t]):
                        continue
                    a0 = at_product[t]
                    d0 = tables[a0 : a0 + LANES]
                    for i in range(width):
                        weight[i] = weights[t, i] * d0[i]
                    for c in range(3):
                        s0 = product_screws[c, t]
                        for i in range(width):
                            e[c, i] = fma(s0, weight[i], e[c, i])
                _sum_up_visit(width, e, sums, squares, sizes[tile, v])
                for i in range(width):
                    places[v, i] = np.uint16(bin_of(words[i]))
                top = largest
                for i in range(count):
                    top = max(top, words[i])
                    least = min(least, words[i])
                if top > largest:
                    for i in range(count):
                        if words[i] > largest:
                            largest = words[i]
                            per_pose[p, LARGEST_ROBOT] = first + i
                            per_pose[p, LARGEST_VISIT] = v
            for i in range(count):
                group = group_hist[group_of[first + i]]
                for v in range(visits):
                    group[places[v, i]] += 1
                mean = sums[0, i] * per_visit
                robot_sums[first + i] += mean
                total[i] += mean
                total2[i] += sums[1, i]
                between2[i] += mean * mean
            if visits > 1:
                _accuracy_and_repeatability(width, count, kept, sums, ap_rp[p, :, first:])
        least_of_all, largest_of_all = min(least_of_all, least), max(largest_of_all, largest)
        words[0], words[1] = least, largest
        low, high = np.sqrt(squares[0]), np.sqrt(squares[1])
        samples = robots * visits
        mean = total.sum() / robots
        per_pose[p, MEAN] = mean
        per_pose[p, MEAN_ERROR] = z * np.sqrt(
            max(between2.sum() / robots - mean * mean, 0.0) / max(robots - 1, 1)
        )
        per_pose[p, MEAN_SQUARE] = total2.sum() / samples
        per_pose[p, LARGEST] = high
        # Sums of squares and of squared robot means give the variance of all sizes and of the
        # robots' means.
        variance = total2.sum() / samples - mean * mean
        of_means = between2.sum() / robots - mean * mean
        between = min(max(of_means / variance, 0.0), 1.0) if variance > 0 else 0.0
        _pose_quantiles(
            sizes,
            robots,
            low,
            high,
            between,
            z,
            bins,
            hist,
            ladder,
            shares,
            per_pose[p, FIRST_QUANTILE:],
        )
    return bin_of(least_of_all), bin_of(largest_of_all)
