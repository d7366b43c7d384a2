"""The Monte Carlo kernel for one error per robot and pose: one visit, or no error that changes from
visit to visit.

AP and RP then do not need the direction of the error, and a sample takes little more time than its
product. Sixteen poses are computed at a time, so that a tile of draws is loaded once for all of
them. Each step runs over these poses before the next step begins, to use the first-level cache
well.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lostmotion.compiled import compiled
from lostmotion.error_model.draw_kernel import LANES, ROW, place_in_table
from lostmotion.error_model.error_bins import BINS, FIRST_BIN, MANTISSA_BITS, ROW_OF_BINS
from lostmotion.propagation.montecarlo.kernel import (
    FINE,
    FIRST_QUANTILE,
    LARGEST,
    LARGEST_ROBOT,
    LARGEST_VISIT,
    LEVELS,
    MEAN,
    MEAN_ERROR,
    MEAN_SQUARE,
    bin_of,
    counts,
    weigh,
)
from lostmotion.propagation.montecarlo.product_kernel import AT_ONCE, squared_lengths

# Poses at a time, and how many lengths they may leave in memory until their quantiles are read.
_POSES: Final = 16
_MOST_KEPT: Final = 4_000_000
# How many bins of a pose's own histogram are summed up at a time.
_CHUNK: Final = 32
_MOST: Final = np.iinfo(np.int64).max
# A bin is read from the upper half of a number's 64 bits.
_SHIFT: Final = 20 - MANTISSA_BITS
_LOWEST: Final = FIRST_BIN << _SHIFT


@compiled
def _measure(count, squares, sizes, sums, robots):
    """Store each error's magnitude, and add it to the sums of its lane (magnitude, square) and of
    its robot.
    """
    for i in range(count):
        size = np.sqrt(squares[i])
        sizes[i] = np.float32(size)
        robots[i] += size
        sums[0, i] += size
        sums[1, i] += squares[i]


@compiled
def _smallest(count, words, value):
    """Return the smallest of these words and `value`. Bits of squares, which are not negative, are
    in the order of their values.
    """
    for i in range(count):
        value = min(value, words[i])
    return value


@compiled
def _largest(count, words, value):
    for i in range(count):
        value = max(value, words[i])
    return value


@compiled
def _bins_of(count, words, rows, out):
    """Return where each square is counted: its bin, in the row of its robot's group. All in 32
    bits, of which a register holds more.
    """
    for i in range(count):
        above = np.int32(np.int32(words[i] >> np.int64(32)) - np.int32(_LOWEST))
        out[i] = np.uint32(
            rows[i] + min(max(np.int32(above >> np.int32(_SHIFT)), np.int32(0)), np.int32(BINS - 1))
        )


@compiled
def _fine_bins_of(count, sizes, low, scale, out):
    for i in range(count):
        out[i] = np.uint32(
            min(max(np.int32((sizes[i] - low) * scale), np.int32(0)), np.int32(FINE - 1))
        )


@compiled
def _count(count, places, hist):
    for i in range(count):
        hist[places[i]] += 1


@compiled
def _sum_of(lanes):
    """Sum up LANES numbers by halves, which no compiler need reorder; leaves them changed."""
    half = len(lanes) // 2
    while half > 0:
        for i in range(half):
            lanes[i] += lanes[i + half]
        half //= 2
    return lanes[0]


@compiled
def _find(hist, before_chunk, rank):
    """Return the bin of the sample of this rank, the count below its end, and the position of the
    rank within the bin.
    """
    whole = np.int64(np.ceil(rank))
    chunk = 0
    while chunk + 1 < len(before_chunk) and before_chunk[chunk + 1] < whole:
        chunk += 1
    at, below = chunk * _CHUNK, before_chunk[chunk]
    while at + 1 < FINE and below + hist[at] < whole:
        below += hist[at]
        at += 1
    return at, below + hist[at], max(rank - below, 0.0) / max(float(hist[at]), 1.0)


@compiled
def _quantiles(hist, before_chunk, robots, low, width, z, out):
    """Put one pose's quantiles and their intervals into `out` (3 per quantile: value, low end, high
    end): straight line within a bin.

    hist (FINE,) counts robots in bins of this width from `low` on. Every robot is a sample: the
    interval is the binomial's, in ranks.
    """
    counted = np.int64(0)
    for chunk in range(len(before_chunk)):
        before_chunk[chunk] = counted
        part = np.int64(0)
        for i in range(_CHUNK):
            part += hist[chunk * _CHUNK + i]
        counted += part
    for k in range(len(LEVELS)):
        level = LEVELS[k]
        at, below, inside = _find(hist, before_chunk, level * robots)
        share = below / robots
        error = z * np.sqrt(
            max(share * (1 - share) / max(robots - 1, 1), level * (1 - level) / robots)
        )
        out[3 * k] = low + width * (at + inside)
        out[3 * k + 1] = out[3 * k + 2] = np.nan
        if level - error > 0:
            at, below, inside = _find(hist, before_chunk, (level - error) * robots)
            out[3 * k + 1] = low + width * (at + inside)
        if level + error < 1:
            at, below, inside = _find(hist, before_chunk, (level + error) * robots)
            out[3 * k + 2] = low + width * (at + inside)


@compiled
def _present(columns):
    """Return the number of terms before those that fill up to a multiple of four."""
    count = len(columns)
    while count > 0 and columns[count - 1] < 0:
        count -= 1
    return count


@compiled
def _take(shift, columns, count, p, out):
    """Take one pose's screws (term, 3) of the first `count` columns out of the matrix."""
    for t in range(count):
        for c in range(3):
            out[t, c] = shift[c, columns[t], p]


@compiled
def run_once(
    first_pose,
    bias,
    shift,
    plays,
    robot_columns,
    robot_draws,
    visit_columns,
    visit_tables,
    visit_keys,
    product_columns,
    product_tables,
    product_keys,
    product_factors,
    frictions,
    tables,
    robots,
    visits,  # more than one only where nothing is drawn per visit: each then brings the same error
    groups,
    z,
    per_pose,
    ap_rp,
    robot_sums,
    group_hist,
):
    """Form the one error of every robot at every pose of one block of poses, and reduce them.
    Arguments and answer as of `kernel.run_block`.
    """
    tiles = robot_draws.shape[0]
    n_robot, n_visit, n_product = (
        _present(robot_columns),
        _present(visit_columns),
        len(product_columns),
    )
    n_steady = n_robot + n_visit
    screws = np.empty((_POSES, n_steady + n_product, 3))
    at = np.empty((_POSES, n_steady + n_product), np.uintp)
    terms, product = np.empty(_POSES, np.int64), np.empty((_POSES, n_product), np.int64)
    weights = np.empty((_POSES, n_product, LANES))
    words = np.empty((_POSES, LANES), np.int64)
    squares = words.view(np.float64)
    places = np.empty((_POSES, LANES), np.uint32)
    sums = np.empty((_POSES, 2, LANES))
    together = min(max(_MOST_KEPT // (tiles * LANES), 1), _POSES)
    sizes = np.empty((together, tiles * LANES), np.float32)
    least, largest = np.empty(_POSES, np.int64), np.empty(_POSES, np.int64)
    fine, before_chunk = np.empty(FINE, np.int64), np.empty(FINE // _CHUNK, np.int64)
    rows = np.empty(robots, np.int32)
    for r in range(robots):
        rows[r] = r * groups // robots * ROW_OF_BINS
    counted = group_hist.ravel() if visits == 1 else np.zeros(group_hist.size, np.int64)
    least_of_all, largest_of_all = _MOST, np.int64(-1)
    draws_at, tables_at, weights_at = (
        robot_draws.ctypes.data,
        tables.ctypes.data,
        weights.ctypes.data,
    )
    for start in range(0, len(bias), together):
        some = min(together, len(bias) - start)
        for k in range(some):
            _take(shift, robot_columns, n_robot, start + k, screws[k])
            _take(shift, visit_columns, n_visit, start + k, screws[k, n_robot:])
            terms[k] = n_steady
            for t in range(n_product):
                if counts(plays[start + k, t]):
                    product[k, terms[k] - n_steady] = t
                    for c in range(3):
                        screws[k, terms[k], c] = shift[c, product_columns[t], start + k]
                    terms[k] += 1
            least[k], largest[k] = _MOST, -1
        sums[:] = 0.0
        for tile in range(tiles):
            first = tile * LANES
            count = min(LANES, robots - first)
            width = (count + AT_ONCE - 1) // AT_ONCE * AT_ONCE
            for k in range(some):
                for t in range(n_robot):
                    at[k, t] = draws_at + np.uintp(8 * LANES * (tile * robot_draws.shape[1] + t))
                for t in range(n_visit):
                    place = visit_tables[t] * ROW + place_in_table(
                        first_pose + start + k, tile, 0, visit_keys[t]
                    )
                    at[k, n_robot + t] = tables_at + np.uintp(8 * place)
                for j in range(terms[k] - n_steady):
                    t = product[k, j]
                    place = product_tables[t] * ROW + place_in_table(
                        first_pose + start + k, tile, 0, product_keys[t]
                    )
                    weigh(
                        width,
                        product_factors[tile, t],
                        plays[start + k, t],
                        frictions[tile, t],
                        weights[k, t],
                    )
                    for i in range(width):
                        weights[k, t, i] *= tables[place + i]
                    at[k, n_steady + j] = weights_at + np.uintp(8 * LANES * (k * n_product + t))
            squared_lengths(some, width, terms, screws, at, bias[start:], squares)
            for k in range(some):
                _measure(count, squares[k], sizes[k, first:], sums[k], robot_sums[first:])
            for k in range(some):
                least[k] = _smallest(count, words[k], least[k])
                top = _largest(count, words[k], largest[k])
                if top > largest[k]:
                    largest[k] = top
                    i = 0
                    while words[k, i] != top:
                        i += 1
                    per_pose[start + k, LARGEST_ROBOT] = first + i
                    per_pose[start + k, LARGEST_VISIT] = 0
            for k in range(some):
                _bins_of(count, words[k], rows[first:], places[k])
            for k in range(some):
                _count(count, places[k], counted)
            if visits > 1:
                for k in range(some):
                    for i in range(count):
                        ap_rp[start + k, 0, first + i] = np.sqrt(squares[k, i])
                        ap_rp[start + k, 1, first + i] = 0.0
        for k in range(some):
            found = per_pose[start + k]
            least_of_all, largest_of_all = (
                min(least_of_all, least[k]),
                max(largest_of_all, largest[k]),
            )
            words[0, 0], words[0, 1] = least[k], largest[k]
            low, high = np.sqrt(squares[0, 0]), np.sqrt(squares[0, 1])
            mean, mean_square = _sum_of(sums[k, 0]) / robots, _sum_of(sums[k, 1]) / robots
            found[MEAN] = mean
            found[MEAN_ERROR] = z * np.sqrt(
                max(mean_square - mean * mean, 0.0) / max(robots - 1, 1)
            )
            found[MEAN_SQUARE] = mean_square
            found[LARGEST] = high
            step = (high - low) / FINE
            scale = 1.0 / step if step > 0 else 0.0
            fine[:] = 0
            for tile in range(tiles):
                count = min(LANES, robots - tile * LANES)
                _fine_bins_of(
                    count, sizes[k, tile * LANES :], np.float32(low), np.float32(scale), places[0]
                )
                _count(count, places[0], fine)
            _quantiles(fine, before_chunk, robots, low, step, z, found[FIRST_QUANTILE:])
    if visits > 1:
        for group in range(groups):
            for i in range(ROW_OF_BINS):
                group_hist[group, i] += visits * counted[group * ROW_OF_BINS + i]
    return bin_of(least_of_all), bin_of(largest_of_all)
