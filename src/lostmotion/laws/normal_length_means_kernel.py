"""The mean length of a nearly normal vector: integrals of the moment generating function along the negative axis, part by part.

Compiled once by Numba and cached; no threads in here.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from lostmotion.laws.normal_length_contour_kernel import BODY, even, inlined, jit, lanes, power

# As in `normal_length_kernel`.
BEHIND: Final = {"normal_length_contour_kernel": "6c02c5beb987ad2c"}

# Columns of what is known of a length besides its quantiles.
MEAN, MEAN_ERROR, THIRD = range(3)

_SPACING: Final = 0.24  # of the nodes of the means
_LANES: Final = 8  # nodes in one loop
_LAST: Final = 64
# u = sinh x, s = -u^2: the means' integrands are even in x, so that the plain sum over equal steps is exact to the last digits.
_U2: Final = np.sinh(_SPACING * np.arange(_LAST)) ** 2
_WIDE: Final = np.cosh(_SPACING * np.arange(_LAST)) * np.where(np.arange(_LAST) == 0, 0.5, 1.0) * 2.0 / math.sqrt(math.pi) * _SPACING


@inlined
def _shrunk(u, a, b, c):
    """Give the product of 1 / (1 + a u), 1 / (1 + b u) and 1 / (1 + c u), and these."""
    wa, wb, wc = 1.0 + a * u, 1.0 + b * u, 1.0 + c * u
    over = 1.0 / (wa * wb * wc)
    return over, over * wb * wc, over * wa * wc, over * wa * wb


@lanes
def _means(begin, a, b, c, p, q, r):
    """Add up some nodes of the mean length and the mean cubed length of one part."""
    more = cubes = 0.0
    for k in range(begin, begin + _LANES):
        u = _U2[k]
        over, va, vb, vc = _shrunk(u, a, b, c)
        m = power(-u * (p * va + q * vb + r * vc)) * np.sqrt(over) * _WIDE[k]
        one = va * (0.5 * a + p * va) + vb * (0.5 * b + q * vb) + vc * (0.5 * c + r * vc)
        two = va * va * a * (0.5 * a + 2.0 * p * va) + vb * vb * b * (0.5 * b + 2.0 * q * vb) + vc * vc * c * (0.5 * c + 2.0 * r * vc)
        more += m * one
        cubes += m * (one * one + two)
    return more, cubes


@jit
def mean_length(weights, spreads, squares, means, cubic, quartic, out):
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
        over, va, vb, vc = _shrunk(u, a, b, c)
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
        over, va, vb, vc = _shrunk(u, a, b, c)
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
