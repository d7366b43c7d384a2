"""The kernel behind the length of a vector: moments, quantiles and shares, vector by vector.

A vector is a mixture of parts that are nearly normal, most often of one. Means are integrals of the moment generating function along the negative
axis (`normal_length_means_kernel`), shares those along a contour (`normal_length_contour_kernel`). Compiled once by Numba and cached; no threads
in here.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from lostmotion.laws.normal_length_contour_kernel import CHUNK, STEEPER, TABLE, X, inlined, jit, lanes, lay, read, tilted
from lostmotion.laws.normal_length_forms_kernel import turn_forms
from lostmotion.laws.normal_length_means_kernel import MEAN, MEAN_ERROR, THIRD, mean_length

# Numba keeps compiled functions by the text of their own file: here stand the digests (BLAKE2b, 8 bytes) of the files whose functions are called
# here, so that no change of theirs is missed. A test compares them.
BEHIND: Final = {
    "normal_length_contour_kernel": "6c02c5beb987ad2c",
    "normal_length_forms_kernel": "1322458ccc23607c",
    "normal_length_means_kernel": "46ad3de2293a9f25",
}

_CERTAIN: Final = 1e-10  # a smaller share of the mean square that varies: the length is normal itself to 1e-10
_RIGHT: Final = 0.94  # from this share on the saddlepoint is far enough to the right of the pole
_NEAR: Final = 0.35  # a contour serves lengths so far below its own, in standard deviations of the squared length
_FAR_LEFT, _FAR_RIGHT = 1.5, 4.0  # and so far above, where it lies to the left of the pole or to the right
_GAIN: Final = 3.0  # and where its last node counts for at most so much more, as a logarithm
_LEAST: Final = 0.7  # and from this share of its own on
_LEAP: Final = 0.5  # longest of Newton's steps, in standard deviations
_ENOUGH: Final = 3e-7  # of the squared length: the last term of the series that a step solves
_SHORT: Final = 0.25  # of the deviation and of the squared length: steps that the series serves
_TRIES: Final = 60
_LANES: Final = 8  # matrices in one loop
_SWEEPS: Final = 6  # of rotations: after four, what is left of most matrices is rounding
_TINY: Final = 1e-300
_ROOT_TWO: Final = math.sqrt(2.0)


@inlined
def _rotation(one, two, across):
    """Give cosine and sine of the turn that takes away what two axes have in common, and by how much their variances move apart."""
    apart = two - one
    t = 2.0 * across / (abs(apart) + np.sqrt(apart * apart + 4.0 * across * across + _TINY))
    t = -t if apart < 0.0 else t
    c = 1.0 / np.sqrt(t * t + 1.0)
    return c, t * c, t * across


@lanes
def _sweep(work):
    """Turn some symmetric matrices towards their axes by one of Jacobi's sweeps: xx, yy, zz, xy, xz, yz, and nine of the axes, of every lane."""
    for n in range(_LANES):
        xx, yy, zz = work[n], work[_LANES + n], work[2 * _LANES + n]
        xy, xz, yz = work[3 * _LANES + n], work[4 * _LANES + n], work[5 * _LANES + n]
        c, s, by = _rotation(xx, yy, xy)
        xx, yy, xz, yz = xx - by, yy + by, c * xz - s * yz, s * xz + c * yz
        d, t, by = _rotation(xx, zz, xz)
        xx, zz, xy, yz = xx - by, zz + by, -t * yz, d * yz
        e, u, by = _rotation(yy, zz, yz)
        yy, zz, xy, xz = yy - by, zz + by, e * xy, u * xy
        work[n], work[_LANES + n], work[2 * _LANES + n] = xx, yy, zz
        work[3 * _LANES + n], work[4 * _LANES + n], work[5 * _LANES + n] = xy, xz, 0.0
        for r in range(3):
            row = (6 + 3 * r) * _LANES + n
            x, y, z = work[row], work[row + _LANES], work[row + 2 * _LANES]
            x, y = c * x - s * y, s * x + c * y
            x, z = d * x - t * z, t * x + d * z
            y, z = e * y - u * z, u * y + e * z
            work[row], work[row + _LANES], work[row + 2 * _LANES] = x, y, z


@jit
def _axes(covariance, turn, variance):
    """Find the axes of matrices (n, 3, 3), columns of `turn` (n, 3, 3), and the variances along them (n, 3).

    All are turned as often, so that none changes what becomes of its neighbours.
    """
    work = np.empty(15 * _LANES)
    for begin in range(0, len(covariance), _LANES):
        for n in range(_LANES):
            m = min(begin + n, len(covariance) - 1)
            trace = covariance[m, 0, 0] + covariance[m, 1, 1] + covariance[m, 2, 2]
            over = 1.0 / trace if trace > 0.0 else 0.0
            for i in range(3):
                work[i * _LANES + n] = over * covariance[m, i, i]
                work[(3 + i) * _LANES + n] = 0.5 * over * (covariance[m, i // 2, 1 + (i + 1) // 2] + covariance[m, 1 + (i + 1) // 2, i // 2])
                for k in range(3):
                    work[(6 + 3 * i + k) * _LANES + n] = 1.0 if i == k else 0.0
        for _ in range(_SWEEPS):
            _sweep(work)
        for n in range(min(_LANES, len(covariance) - begin)):
            m = begin + n
            trace = covariance[m, 0, 0] + covariance[m, 1, 1] + covariance[m, 2, 2]
            whole = 0.0
            for i in range(3):
                for k in range(3):
                    whole += abs(covariance[m, i, k])
                    turn[m, i, k] = work[(6 + 3 * i + k) * _LANES + n]
            for i in range(3):
                variance[m, i] = max(trace * work[i * _LANES + n], 0.0) if whole < np.inf else np.nan


@jit
def _prepare(start, weights, bias, turn, variance, third, fourth, work, weight, spreads, squares, means, cubic, quartic):
    """Copy the parts of one vector, from `start` on, along their own axes and scaled to mean square one.

    Gives the root mean square (0 where nothing is left, NaN) and how many parts vary.
    """
    size2 = 0.0
    for n in range(start, start + len(weight)):
        size2 += weights[n] * (variance[n, 0] + variance[n, 1] + variance[n, 2] + bias[n, 0] ** 2 + bias[n, 1] ** 2 + bias[n, 2] ** 2)
    if not size2 > 0:
        return size2, 0  # zero, or not a number
    size, varying = np.sqrt(size2), 0
    for j in range(len(weight)):
        n = start + j
        weight[j] = weights[n]
        for i in range(3):
            spreads[j, i] = variance[n, i] / size2
            means[j, i] = (turn[n, 0, i] * bias[n, 0] + turn[n, 1, i] * bias[n, 1] + turn[n, 2, i] * bias[n, 2]) / size
            squares[j, i] = means[j, i] ** 2
        if len(fourth) > 0:
            turn_forms(third[n], fourth[n], turn[n], size, work, cubic[j], quartic[j])
        varying += spreads[j, 0] + spreads[j, 1] + spreads[j, 2] >= _CERTAIN
    return size, varying


@jit
def _guess(z, first, second, third):
    """Guess the quantile of Q at the normal law's z: as of a chi-square with its first three cumulants (J. Imhof, Biometrika 48 (1961) 419)."""
    freedom = 8.0 * second * second * second / (third * third)
    root = 1.0 - 2.0 / (9.0 * freedom) + z * np.sqrt(2.0 / (9.0 * freedom))
    return max(first + np.sqrt(0.5 * second * freedom) * (max(root, 0.0) ** 3 - 1.0), 0.02 * first)


@jit
def _bent_cumulants(spread, square, mean, t, f):
    """Give what third and fourth cumulants of a vector add to the second and third cumulant of Q, as far as a guess needs them."""
    second = third = 0.0
    for i in range(3):
        whole = f[i, 0] + f[i, 1] + f[i, 2]
        second += whole + 4.0 / 3.0 * mean[i] * (3.0 * t[3 * i] + t[3 * i + 1] + t[3 * i + 2])
        along = f[i, 3] * mean[1] * mean[2] + f[i, 4] * mean[0] * mean[2] + f[i, 5] * mean[0] * mean[1]
        third += 12.0 * (whole * (spread[i] + square[i]) + 2.0 * along)
    return second, third


@jit
def _solve(left, density, first, second, third):
    """Which step by makes up for `left`? A series of four terms, and the size of the last."""
    by = left / density
    for _ in range(6):
        value = by * (density + by * (first / 2.0 + by * (second / 6.0 + by * third / 24.0))) - left
        slope = density + by * (first + by * (second / 2.0 + by * third / 6.0))
        if not slope > 0.1 * density:
            return left / density, np.inf
        value /= slope
        by -= value
        if abs(value) < 1e-12 * abs(by):
            break
    return by, abs(third * by**4 / (24.0 * density))


@jit
def _along(spread, mean):
    """Give the length of the mean, the deviation along it, and the mean that the variance across it adds: what a nearly certain length needs."""
    length2 = mean[0] ** 2 + mean[1] ** 2 + mean[2] ** 2
    length, variance = np.sqrt(length2), 0.0
    if length2 > 0:
        variance = (spread[0] * mean[0] ** 2 + spread[1] * mean[1] ** 2 + spread[2] * mean[2] ** 2) / length2
    return length, np.sqrt(variance), (spread[0] + spread[1] + spread[2] - variance) / (2.0 * length) if length2 > _CERTAIN else 0.0


@jit
def _certain(level, z, weights, spreads, means):
    """Give a quantile of a mixture of nearly certain lengths, and its error: NaN where the level falls between two of them."""
    found, scatter = np.inf, 0.0
    for j in range(len(weights)):
        length, deviation, more = _along(spreads[j], means[j])
        length += more
        scatter = max(scatter, 6.0 * deviation)
        if len(weights) == 1:
            return length + z * deviation, 0.0
        if length < found:
            share = 0.0
            for k in range(len(weights)):
                other, _, more = _along(spreads[k], means[k])
                if other + more <= length:
                    share += weights[k]
            if abs(share - level) < 1e-9:  # noqa: PLR2004 - of a share, as rounding leaves it
                return np.nan, np.nan
            if share > level:
                found = length
    return found, scatter


@jit
def _certain_share(limit, weights, spreads, means):
    """Give the share of a mixture of nearly certain lengths below a limit, and the density there."""
    below = density = 0.0
    for j in range(len(weights)):
        length, deviation, more = _along(spreads[j], means[j])
        x = limit - length - more
        if deviation == 0.0:
            below += weights[j] if x >= 0.0 else 0.0
        else:
            below += weights[j] * 0.5 * math.erfc(-x / (_ROOT_TWO * deviation))
            density += weights[j] * math.exp(-0.5 * (x / deviation) ** 2) / (deviation * math.sqrt(2.0 * math.pi))
    return below, density


@jit
def _certain_moments(weights, spreads, means, out):
    """Give what `_moments` does where no part scatters."""
    out[:] = 0.0
    for j in range(len(weights)):
        length, _, more = _along(spreads[j], means[j])
        out[MEAN] += weights[j] * (length + more)
        out[THIRD] += weights[j] * (length + more) ** 3


@jit
def lengths(bias, covariance, third, fourth, weights, starts, levels, z, limits, moments, quantiles, quantiles_left, shares, densities, shares_left):
    """Fill in, for every vector: moments (vector, 3), quantiles (vector, level), and shares below the limits with densities there (vector, limit).

    `_left` is what what is left out beyond Edgeworth's terms could move them by. Parts starts[v] to starts[v + 1] make up vector v: bias (part, 3),
    covariance (part, 3, 3), weights (part,); third (part, 10) and fourth (part, 15) forms or none for normal parts. `levels` rise; z are the normal
    quantiles of them; limits (vector, limit). Moments of no vector (0, 3) ask for none.
    """
    most = 1
    for v in range(len(starts) - 1):
        most = max(most, starts[v + 1] - starts[v])
    bent = most if len(fourth) > 0 else 0
    # Taking a slice costs as much as several nodes: one for vectors of as many parts.
    all_weight, all_spreads, all_squares, all_means = np.empty(most), np.empty((most, 3)), np.empty((most, 3)), np.empty((most, 3))
    all_cubic, all_quartic, work, table = np.zeros((bent, 10)), np.zeros((bent, 6, 6)), np.empty((2, 6, 6)), np.empty(TABLE)
    turn, variance = np.empty((len(bias), 3, 3)), np.empty((len(bias), 3))
    _axes(covariance, turn, variance)
    weight, spreads, squares, means, cubic, quartic = all_weight, all_spreads, all_squares, all_means, all_cubic, all_quartic
    for v in range(len(starts) - 1):
        n = starts[v + 1] - starts[v]
        if n != len(weight):
            weight, spreads, squares, means = all_weight[:n], all_spreads[:n], all_squares[:n], all_means[:n]
            cubic, quartic = all_cubic[:n], all_quartic[:n]
        size, varying = _prepare(starts[v], weights, bias, turn, variance, third, fourth, work, weight, spreads, squares, means, cubic, quartic)
        if not size > 0:
            for k in range(3 if len(moments) > 0 else 0):
                moments[v, k] = size
            for k in range(len(levels)):
                quantiles[v, k] = quantiles_left[v, k] = size
            for k in range(limits.shape[1]):
                shares[v, k] = size if size != 0 else (1.0 if limits[v, k] >= 0 else 0.0)
                densities[v, k] = shares_left[v, k] = size
            continue
        if len(moments) > 0:
            if varying == 0:
                _certain_moments(weight, spreads, means, moments[v])
            else:
                mean_length(weight, spreads, squares, means, cubic, quartic, moments[v])
            moments[v, MEAN] *= size
            moments[v, MEAN_ERROR] *= size
            moments[v, THIRD] *= size**3
        if varying == 0:
            for k in range(len(levels)):
                length, left = _certain(levels[k], z[k], weight, spreads, means)
                quantiles[v, k], quantiles_left[v, k] = size * length, size * left
            for k in range(limits.shape[1]):
                share, density = _certain_share(limits[v, k] / size, weight, spreads, means)
                shares[v, k], densities[v, k], shares_left[v, k] = share, density / size, 0.0
            continue
        mean, second, skew = tilted(0.0, weight, spreads, squares)
        deviation = np.sqrt(second)
        wide, skewed = second, skew
        if bent > 0 and n == 1:
            more, most = _bent_cumulants(spreads[0], squares[0], means[0], cubic[0], quartic[0])
            if second + more > 0.5 * second and skew + most > 0.2 * skew:
                wide, skewed = second + more, skew + most
        narrow = 0.0
        if n > 1:
            for j in range(n):
                narrow += weight[j] * np.sqrt(tilted(0.0, weight[j : j + 1], spreads[j : j + 1], squares[j : j + 1])[1])
        count, laid, right, here = -1, 0.0, False, deviation
        for k in range(len(levels) + limits.shape[1]):
            # A quantile is where the share is the level; a share asks for one look, at its limit.
            asked = k >= len(levels)
            n = k - len(levels) if asked else k
            level = 0.0 if asked else levels[n]
            q = limits[v, n] * limits[v, n] / (size * size) if asked else _guess(z[n], mean, wide, skewed)
            above = q > mean if asked else level > _RIGHT
            if asked:
                shares[v, n] = densities[v, n] = shares_left[v, n] = 0.0
                if not limits[v, n] > 0:
                    continue
                shares[v, n] = densities[v, n] = shares_left[v, n] = np.nan
            else:
                quantiles[v, n] = quantiles_left[v, n] = np.nan
            low, high = 0.0, np.inf
            for _ in range(_TRIES):
                by = q - laid
                far = by < -_NEAR * here or by > (_FAR_RIGHT if right else _FAR_LEFT) * here or q < _LEAST * laid
                # Nearer than its own length a contour's far nodes count for more.
                far |= count > 0 and -by * table[count - 1, X + CHUNK - 1] > _GAIN
                if count <= 0 or right != above or far:
                    count, here = lay(q, above, mean, second, weight, spreads, squares, means, cubic, quartic, table)
                    laid, right, by = q, above, 0.0
                    if count < 0:
                        break
                share, density, slope, bend, more, left = read(count, by, table)
                share = 1.0 - share if above else -share
                if count == 0:
                    share = 1.0 if q > mean else 0.0
                if asked:
                    shares[v, n] = share  # of nearly normal vectors it may leave 0 … 1: Edgeworth's terms do
                    densities[v, n] = density * 2.0 * np.sqrt(q) / size
                    shares_left[v, n] = left * (1.0 + STEEPER * max(by, 0.0) / here) if bent > 0 else 0.0
                    break
                if share < level:
                    low = q
                else:
                    high = q
                step = _LEAP * deviation if share < level else -_LEAP * deviation
                if density > 0:
                    step, last_term = _solve(level - share, density, slope, bend, more)
                    if abs(step) <= _SHORT * min(here, q) and last_term <= _ENOUGH * q:
                        if q + step > 0:
                            quantiles[v, n] = size * np.sqrt(q + step)
                            if bent > 0:
                                # Between parts the density may be a bump of Edgeworth's: the least nearby tells how far a share moves a length.
                                if narrow > 0.0:
                                    for side in (-narrow, narrow):
                                        density = min(density, read(count, by + side, table)[1])
                                left *= 1.0 + STEEPER * max(by, 0.0) / here
                                quantiles_left[v, n] = size * left / (2.0 * np.sqrt(q) * density) if density > 0 else np.nan
                            else:
                                quantiles_left[v, n] = 0.0
                        break
                    step = min(max(step, -_LEAP * deviation), _LEAP * deviation)
                q = q + step if low < q + step < high else 0.5 * (low + min(high, 2.0 * low + deviation))
