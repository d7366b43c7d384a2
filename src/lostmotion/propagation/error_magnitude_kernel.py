"""Compiled loops of `error_magnitude`: integrals along rays, magnitudes at points, and figures from
histograms of these magnitudes.

The compiler may reorder sums, so the bits of a figure depend on the processor, but on nothing else.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numba import njit

from lostmotion.compiled import compiled, compiled_with
from lostmotion.error_model import error_bins

BINS: Final = 2048  # of the histogram of the magnitudes at one pose
CHUNK: Final = 512  # points at a time: their three sums stay in the first-level cache
# The bins over all errors begin here in the leading bits of a 32-bit float, whose exponent is
# biased by 127 instead of 1023.
_FIRST: Final = error_bins.FIRST_BIN - ((1023 - 127) << error_bins.MANTISSA_BITS)
_SHIFT: Final = 23 - error_bins.MANTISSA_BITS
_ALL: Final = error_bins.BINS
# factor in the density of the length of a standard normal vector in space
_CHI: Final = math.sqrt(2 / math.pi)
_FAR: Final = 12.0  # standard deviations beyond which the probability is negligible
_STEPS: Final = 60
_TAIL: Final = 0.5
# uncertainty of mean and deviation, as a share of the largest correction of a quantile: measured
# 0.06
_OF_MOMENTS: Final = 0.1
_INTEGRATED: Final = 1e-3  # uncertainty of integration along the rays, as a share of the deviation
# relative length of the last step of Newton's method, after which the error is negligible
_CLOSE: Final = 1e-4
_FREE: Final = {"contract", "reassoc", "nsz", "nnan", "ninf", "arcp"}
_lanes = compiled_with(fastmath=_FREE)


@njit(inline="always", error_model="numpy")
def _along_ray(x, w0, w1, w2, w3, w4):
    """Return the integral from 0 to x of the chi density times w0 + ... + w4 r^4 and the integrand
    at x, then both for a weight of one.

    The error function is Abramowitz and Stegun's 7.1.26 (absolute error 1.5e-7). The exponential is
    a polynomial, squared eight times, because a function call per ray would prevent the compiler
    from vectorising over rays.
    """
    x = min(x, _FAR)
    square = x * x
    small = square / 512
    power = 1.0 - small * (1.0 - small / 2 * (1.0 - small / 3 * (1.0 - small / 4)))
    for _ in range(8):
        power *= power
    t = 1.0 / (1.0 + 0.3275911 * math.sqrt(0.5) * x)
    complement = (
        power
        * t
        * (
            0.254829592
            + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429)))
        )
    )
    phi = _CHI * power
    m0 = 1.0 - complement - x * phi
    m2 = 3.0 * m0 - x * square * phi
    m4 = 5.0 * m2 - x * square * square * phi
    m1 = 2.0 * _CHI - (square + 2.0) * phi
    m3 = 8.0 * _CHI - (square * square + 4.0 * square + 8.0) * phi
    dense = square * phi
    return (
        w0 * m0 + w1 * m1 + w2 * m2 + w3 * m3 + w4 * m4,
        dense * (w0 + x * (w1 + x * (w2 + x * (w3 + x * w4)))),
        m0,
        dense,
    )


@_lanes
def _share_within(length, square, along, across, w0, w1, w2, w3, w4):
    """Return the share of magnitudes below a length (m) and the density there (1/m) for one pose,
    then both for the uncorrected normal vector.
    """
    share = density = normal = dense = 0.0
    for j in range(len(along)):
        root, over = (
            np.sqrt(max(along[j] * along[j] - across[j] * (square - length * length), 0.0)),
            1.0 / across[j],
        )
        far, far_density, far_normal, far_dense = _along_ray(
            max((root - along[j]) * over, 0.0), w0[j], w1[j], w2[j], w3[j], w4[j]
        )
        near, near_density, near_normal, near_dense = _along_ray(
            max((-root - along[j]) * over, 0.0), w0[j], w1[j], w2[j], w3[j], w4[j]
        )
        # A ray that misses the sphere of this radius contributes zero density.
        slope = length / root if root > 0 else 0.0
        share += far - near
        density += (far_density + near_density) * slope
        normal += far_normal - near_normal
        dense += (far_dense + near_dense) * slope
    return share, density, normal / len(along), dense / len(along)


@compiled
def shares_within(square, along, across, weights, limits, shares, densities):
    """Fill in the shares of magnitudes below limits (pose, limit), m, and the densities there
    (pose, limit), 1/m.
    """
    for p in range(len(square)):
        w = weights[min(p, len(weights) - 1)]
        for k in range(limits.shape[1]):
            found = _share_within(
                limits[p, k], square[p], along[p], across[p], w[0], w[1], w[2], w[3], w[4]
            )
            shares[p, k], densities[p, k] = found[0], found[1]


@_lanes
def moments_along_rays(square, along, across, weights, nodes, masses, values):
    """Fill in mean and standard deviation, columns 0 and 1 of (pose, figure), by Gauss's rule along
    every ray.

    Sums are over the length less |b|, so that a large bias does not cancel digits of the deviation.
    """
    for p in range(len(square)):
        w, a, b = weights[min(p, len(weights) - 1)], across[p], along[p]
        w0, w1, w2, w3, w4 = w[0], w[1], w[2], w[3], w[4]
        bias = np.sqrt(square[p])
        one = two = 0.0
        for k in range(len(nodes)):
            r, mass = nodes[k], masses[k]
            for j in range(len(a)):
                more = r * (2.0 * b[j] + r * a[j])
                by = more / (np.sqrt(max(square[p] + more, 0.0)) + bias + 1e-300)
                weighted = mass * (w0[j] + r * (w1[j] + r * (w2[j] + r * (w3[j] + r * w4[j])))) * by
                one += weighted
                two += weighted * by
        values[p, 0], values[p, 1] = bias + one, np.sqrt(max(two - one * one, 0.0))


@compiled
def quantiles_along_rays(
    square, along, across, weights, levels, deviates, limits, values, uncertainty, nearly_normal
):
    """Fill in quantiles after mean and deviation, by Newton's method within a bracket; the
    uncertainty of all figures; and whether rays apply.

    deviates  (level,) quantiles of the standard normal distribution
    limits    largest shares by which the correction for shape may move a quantile and change the
              density there

    The relative uncertainty of each quantile is the largest relative move of any quantile of the
    pose. The uncertainty of mean and deviation is a tenth of the largest move. No uncertainty is
    below that of the integration, a share of the deviation.
    """
    most_moved, most_denser = limits
    for p in range(len(square)):
        w, mean, deviation = weights[min(p, len(weights) - 1)], values[p, 0], values[p, 1]
        largest = largest_share = 0.0
        for k in range(len(levels)):
            level, low, high = levels[k], 0.0, mean + 60 * deviation
            at = max(mean + deviates[k] * deviation, 0.3 * mean)
            if k > 0:
                at = values[p, 1 + k] + (deviates[k] - deviates[k - 1]) * deviation
            share = density = normal = dense = 0.0
            for _ in range(_STEPS if deviation > 1e-12 * mean else 0):
                share, density, normal, dense = _share_within(
                    at, square[p], along[p], across[p], w[0], w[1], w[2], w[3], w[4]
                )
                if share < level:
                    low = at
                else:
                    high = at
                step = (level - share) / density if density > 0 else np.inf
                # the logarithm of the share above a length is nearly linear in the squared length
                if level > _TAIL and share < 1 and density > 0:
                    further = (
                        at * at
                        + 2 * at * math.log((1 - share) / (1 - level)) * (1 - share) / density
                    )
                    if further > 0:
                        step = math.sqrt(further) - at
                before = at
                at = (
                    at + step
                    if low < at + step < high
                    else 0.5 * (low + min(high, 2 * low + deviation))
                )
                if abs(at - before) < _CLOSE * at:
                    break
            values[p, 2 + k], move = at, abs(share - normal) / max(dense, 1e-300)
            largest, largest_share = max(largest, move), max(largest_share, move / max(at, 1e-300))
            if not (move <= most_moved * at and abs(density - dense) <= most_denser * dense):
                nearly_normal[p] = False
        uncertainty[p, :2] = max(_OF_MOMENTS * largest, _INTEGRATED * deviation)
        for k in range(len(levels)):
            uncertainty[p, 2 + k] = max(largest_share * values[p, 2 + k], _INTEGRATED * deviation)


@_lanes
def squared_lengths(shift, bias, draws, out):
    """Fill in |bias + shift @ draws|^2 (pose, point), m^2: bias (pose, 3), m; shift (pose, 3,
    term), m per unit draw; draws (term, point).

    The number of terms is a multiple of four, that of points a multiple of CHUNK. Four terms are
    added at a time, so that a
    sum is loaded and stored once for four products.
    """
    x, y, z = np.empty(CHUNK, np.float32), np.empty(CHUNK, np.float32), np.empty(CHUNK, np.float32)
    for first in range(0, draws.shape[1], CHUNK):
        for p in range(len(shift)):
            x[:], y[:], z[:] = bias[p, 0], bias[p, 1], bias[p, 2]
            a, b, c, to = shift[p, 0], shift[p, 1], shift[p, 2], out[p, first : first + CHUNK]
            for t in range(0, len(draws), 4):
                r0, r1 = draws[t, first : first + CHUNK], draws[t + 1, first : first + CHUNK]
                r2, r3 = draws[t + 2, first : first + CHUNK], draws[t + 3, first : first + CHUNK]
                a0, a1, a2, a3 = a[t], a[t + 1], a[t + 2], a[t + 3]
                b0, b1, b2, b3 = b[t], b[t + 1], b[t + 2], b[t + 3]
                c0, c1, c2, c3 = c[t], c[t + 1], c[t + 2], c[t + 3]
                for j in range(CHUNK):
                    x[j] += a0 * r0[j] + a1 * r1[j] + a2 * r2[j] + a3 * r3[j]
                    y[j] += b0 * r0[j] + b1 * r1[j] + b2 * r2[j] + b3 * r3[j]
                    z[j] += c0 * r0[j] + c1 * r1[j] + c2 * r2[j] + c3 * r3[j]
            for j in range(CHUNK):
                to[j] = x[j] * x[j] + y[j] * y[j] + z[j] * z[j]


@compiled
def count_lengths(squares, counts):
    """Add the numbers of squared magnitudes (pose, block, point), m^2, in each bin of `error_bins`
    to counts (block, bin).
    """
    bits = squares.view(np.int32)
    for p in range(squares.shape[0]):
        for m in range(squares.shape[1]):
            for j in range(squares.shape[2]):
                counts[m, min(max((bits[p, m, j] >> _SHIFT) - _FIRST, 0), _ALL - 1)] += 1


@compiled
def _edge(level, below):
    """Return the position, in bins from the lowest edge, at which the cumulative share `below`
    (edge,) reaches a level.
    """
    k = min(max(np.searchsorted(below, level), 1), BINS)
    return k - 1 + min(max((level - below[k - 1]) / max(below[k] - below[k - 1], 1e-300), 0.0), 1.0)


@_lanes
def _bins_of(squares, low, over, bins):
    """Fill in the bins of these magnitudes; return the sum of the magnitudes less `low`, and the
    sum of the squares of these differences.
    """
    one = two = 0.0
    for j in range(len(squares)):
        by = np.sqrt(squares[j]) - low
        bins[j] = np.int32(min(by * over, np.float32(BINS - 1)))
        one += by
        two += by * by
    return one, two


@compiled
def figures_of_lengths(squares, levels, errors, values, uncertainty):
    """Fill in mean, deviation, quantiles and their uncertainty (pose, figure), m, from squared
    magnitudes (pose, block, point), m^2.

    The uncertainty is `errors` standard errors, estimated from the differences between blocks. For
    a quantile it is that of the share below it, plus one point, which reveals gaps in the
    distribution; the histogram converts it to a length.
    """
    blocks, each = squares.shape[1:]
    wanted, point = errors / math.sqrt(blocks - 1.0), 1.0 / (blocks * each)
    ones, twos, shares, below = (
        np.empty(blocks),
        np.empty(blocks),
        np.empty(blocks),
        np.empty(BINS + 1),
    )
    counts, bins = np.empty((blocks, BINS), np.int32), np.empty(each, np.int32)
    for p in range(len(squares)):
        low, high = np.sqrt(squares[p].min()), np.sqrt(squares[p].max())
        wide = max((high - low) / BINS, 1e-7 * high + 1e-30)
        counts[:] = 0
        for m in range(blocks):
            one, two = _bins_of(squares[p, m], low, np.float32(1.0 / wide), bins)
            ones[m], twos[m] = one / each, two / each
            for j in range(each):
                counts[m, bins[j]] += 1
        below[0] = 0.0
        for k in range(BINS):
            below[k + 1] = below[k] + counts[:, k].sum() * point
        one = ones.mean()
        deviation = math.sqrt(max(twos.mean() - one * one, 0.0))
        values[p, 0], values[p, 1], uncertainty[p, 0] = low + one, deviation, wanted * ones.std()
        # from the blocks' mean squares about the common mean
        uncertainty[p, 1] = (
            wanted * (twos - 2 * one * ones).std() / (2 * deviation) if deviation > 0 else 0.0
        )
        for k in range(len(levels)):
            at = _edge(levels[k], below)
            n = min(int(at), BINS - 1)
            for m in range(blocks):
                shares[m] = (counts[m, :n].sum() + (at - n) * counts[m, n]) / each
            off = wanted * shares.std() + point
            further = max(
                _edge(levels[k] + off, below) - at, at - _edge(levels[k] - off, below), 0.5
            )
            values[p, 2 + k], uncertainty[p, 2 + k] = low + wide * at, wide * further
