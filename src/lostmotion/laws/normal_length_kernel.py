"""The kernel behind the length of a vector: moments, quantiles and shares, vector by vector.

A vector is a mixture of parts that are nearly normal, most often of one. Means are integrals of the moment generating function along the negative
axis, shares those along a contour (`normal_length_contour_kernel`). Compiled once by Numba and cached; no threads in here.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from lostmotion.laws.normal_length_contour_kernel import BODY, CHUNK, STEEPER, TABLE, X, even, inlined, jit, lanes, lay, power, read, tilted
from lostmotion.laws.normal_length_forms_kernel import turn_forms

# Numba keeps compiled functions by the text of their own file: here stand the digests (BLAKE2b, 8 bytes) of the files whose functions are called
# here, so that no change of theirs is missed. A test compares them.
BEHIND: Final = {"normal_length_contour_kernel": "6c02c5beb987ad2c", "normal_length_forms_kernel": "1322458ccc23607c"}

# Columns of what is known of a length besides its quantiles.
MEAN, MEAN_ERROR, THIRD = range(3)

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
_SPACING: Final = 0.24  # of the nodes of the means
_LANES: Final = 8  # nodes, or matrices, in one loop
_SWEEPS: Final = 6  # of rotations: after four, what is left of most matrices is rounding
_TINY: Final = 1e-300
_LAST: Final = 64
# u = sinh x, s = -u^2: the means' integrands are even in x, so that the plain sum over equal steps is exact to the last digits.
_U2: Final = np.sinh(_SPACING * np.arange(_LAST)) ** 2
_WIDE: Final = np.cosh(_SPACING * np.arange(_LAST)) * np.where(np.arange(_LAST) == 0, 0.5, 1.0) * 2.0 / math.sqrt(math.pi) * _SPACING
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


@lanes
def _means(begin, a, b, c, p, q, r):
    """Add up some nodes of the mean length and the mean cubed length of one part."""
    more = cubes = 0.0
    for k in range(begin, begin + _LANES):
        u = _U2[k]
        wa, wb, wc = 1.0 + a * u, 1.0 + b * u, 1.0 + c * u
        over = 1.0 / (wa * wb * wc)
        va, vb, vc = over * wb * wc, over * wa * wc, over * wa * wb
        m = power(-u * (p * va + q * vb + r * vc)) * np.sqrt(over) * _WIDE[k]
        one = va * (0.5 * a + p * va) + vb * (0.5 * b + q * vb) + vc * (0.5 * c + r * vc)
        two = va * va * a * (0.5 * a + 2.0 * p * va) + vb * vb * b * (0.5 * b + 2.0 * q * vb) + vc * vc * c * (0.5 * c + 2.0 * r * vc)
        more += m * one
        cubes += m * (one * one + two)
    return more, cubes


@jit
def _moments(weights, spreads, squares, means, cubic, quartic, out):
    """Give the mean length, what what is left out beyond Edgeworth's terms could add to it, and the mean cubed length (without those terms)."""
    out[:] = 0.0
    for j in range(len(weights)):
        a, b, c = 2.0 * spreads[j, 0], 2.0 * spreads[j, 1], 2.0 * spreads[j, 2]
        p, q, r = squares[j, 0], squares[j, 1], squares[j, 2]
        first = cube = 0.0
        for begin in range(0, _LAST, _LANES):
            more, cubes = _means(begin, a, b, c, p, q, r)
            first += more
            cube += cubes
            if more < 1e-8 * first:
                break
        out[MEAN] += weights[j] * first
        out[THIRD] += weights[j] * cube
        straight = len(quartic) > 0 and even(j, means, cubic)
        # Where u is 0 nothing changes.
        for begin in range(1, _LAST - _LANES + 1 if len(quartic) > 0 else 1, _LANES):
            more, left = _even_means(begin, a, b, c, j, quartic) if straight else _bent_means(begin, a, b, c, j, means, cubic, quartic)
            out[MEAN] += weights[j] * more
            out[MEAN_ERROR] += weights[j] * left
            if left < 1e-8 * first:
                break


@lanes
def _even_means(begin, a, b, c, j, quartic):
    """Do what `_bent_means` does for a part without mean and third cumulants."""
    f00, f11, f22 = 0.5 * quartic[j, 0, 0], 0.5 * quartic[j, 1, 1], 0.5 * quartic[j, 2, 2]
    f01, f02, f12 = quartic[j, 0, 1], quartic[j, 0, 2], quartic[j, 1, 2]
    more = left = 0.0
    for k in range(begin, begin + _LANES):
        u = _U2[k]
        wa, wb, wc = 1.0 + a * u, 1.0 + b * u, 1.0 + c * u
        over = 1.0 / (wa * wb * wc)
        va, vb, vc = over * wb * wc, over * wa * wc, over * wa * wb
        m = np.sqrt(over) * _WIDE[k] * u
        d = va * (f00 * va + f01 * vb + f02 * vc) + vb * (f11 * vb + f12 * vc) + f22 * vc * vc
        more -= 0.5 * m * d
        left += 0.5 * m * abs(d) * (BODY[0] + u * u * abs(d)) * BODY[1]
    return more, left


@lanes
def _bent_means(begin, a, b, c, j, means, cubic, quartic):
    """Add up some nodes of what one part's third and fourth cumulants change in the mean (as in the contour's `_weigh_bent`), and leave out."""
    m0, m1, m2 = means[j, 0], means[j, 1], means[j, 2]
    t, f = cubic[j], quartic[j]
    more = left = 0.0
    for k in range(begin, begin + _LANES):
        u = _U2[k]
        wa, wb, wc = 1.0 + a * u, 1.0 + b * u, 1.0 + c * u
        over = 1.0 / (wa * wb * wc)
        va, vb, vc = over * wb * wc, over * wa * wc, over * wa * wb
        m = power(-u * (m0 * m0 * va + m1 * m1 * vb + m2 * m2 * vc)) * np.sqrt(over) * _WIDE[k] / u
        g0, g1, g2 = -2.0 * u * va, -2.0 * u * vb, -2.0 * u * vc
        h0, h1, h2 = g0 * m0, g1 * m1, g2 * m2
        e0, e1, e2 = h0 * h0, h1 * h1, h2 * h2
        three = h0 * (t[0] * (e0 + 3.0 * g0) + t[1] * (e1 + g1) + t[2] * (e2 + g2))
        three += h1 * (t[3] * (e1 + 3.0 * g1) + t[4] * (e0 + g0) + t[5] * (e2 + g2))
        three += h2 * (t[6] * (e2 + 3.0 * g2) + t[7] * (e0 + g0) + t[8] * (e1 + g1)) + t[9] * (h0 * h1 * h2)
        v0, v1, v2 = e0 + 3.0 * g0, e1 + 3.0 * g1, e2 + 3.0 * g2
        v3, v4, v5 = 2.0 * h1 * h2, 2.0 * h0 * h2, 2.0 * h0 * h1
        four = v0 * (f[0, 0] * v0 + 2.0 * (f[0, 1] * v1 + f[0, 2] * v2 + f[0, 3] * v3 + f[0, 4] * v4 + f[0, 5] * v5))
        four += v1 * (f[1, 1] * v1 + 2.0 * (f[1, 2] * v2 + f[1, 3] * v3 + f[1, 4] * v4 + f[1, 5] * v5))
        four += v2 * (f[2, 2] * v2 + 2.0 * (f[2, 3] * v3 + f[2, 4] * v4 + f[2, 5] * v5))
        four += v3 * (f[3, 3] * v3 + 2.0 * (f[3, 4] * v4 + f[3, 5] * v5)) + v4 * (f[4, 4] * v4 + 2.0 * f[4, 5] * v5) + f[5, 5] * v5 * v5
        less = g0 * (f[0, 0] * g0 + 2.0 * (f[0, 1] * g1 + f[0, 2] * g2)) + g1 * (f[1, 1] * g1 + 2.0 * f[1, 2] * g2) + f[2, 2] * g2 * g2
        d = three / 6.0 + (four - 6.0 * less) / 24.0
        more -= 0.5 * m * d
        left += 0.5 * m * abs(d) * (BODY[0] + abs(d)) * BODY[1]
    return more, left


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
                _moments(weight, spreads, squares, means, cubic, quartic, moments[v])
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
