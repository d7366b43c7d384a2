"""The kernel behind `lattice_length`: characteristic function on a lattice, density by its Fourier sum, and the length's own cosine series.

Coordinates t and u lie along the vector's axes and are scaled so that its variance along each is one; an axis along which nothing varies has one
point. Compiled once by Numba and cached; no threads in here. Loops over lattice points hold no call to the mathematical library where that matters.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numba import njit

# The density's lattice is periodic: half of its side in deviations. What lies further out is bounded by Chernoff's inequality.
BOX: Final = 5.5
_STEP: Final = math.pi / BOX
# Groups of draws are put together as nearly normal until what that leaves out may move a share by the first number, at so much for every sixth
# cumulant over 720 (the largest of the fifth Hermite polynomial times the normal density is 2.3).
_LUMPED: Final = 3e-5
_PER_SIXTH: Final = 2 * 2.3 / 720
# The characteristic function ends softly: by exp(-36) where it is cut off, by nothing well inside. The series likewise.
_END: Final = 36.0
_SOFT: Final = 6
_SOFT_SERIES: Final = 30
_MARGIN: Final = 1.2
_MORE: Final = 2
# Waves of the length at a point pull on the lattice's axes by how steep the length is along them: at lengths from this share of the mean on, within
# so many deviations.
_NEAR: Final = 0.8
_SPAN: Final = 4.0
# Larger lattices, and longer series, are not worth their time.
MOST_POINTS: Final = 200_000
MOST_WAVES: Final = 160

# Where the vector may be, in deviations along each axis; and how far from the end of the series on the characteristic
# function is asked for its size: often, since that of flat draws is nothing here and there. Each counts for four times
# 2 / pi of the logarithm of its range: at two flat draws and nothing else errors came to 0.85 of the bound.
_AT: Final = (-1.0, 1.0)
_FURTHER: Final = (1.3, 1.5, 1.75, 2.0, 2.3)
_COUNTED: Final = 0.3

_FREE: Final = {"contract", "reassoc", "nsz", "nnan", "ninf"}
_jit = njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"}, boundscheck=False)
_lanes = njit(nogil=True, cache=True, error_model="numpy", fastmath=_FREE, boundscheck=False)
# How often x^i y^j z^k stands in (x + y + z)^(i + j + k).
_COUNTS = np.array(
    [
        [[math.factorial(i + j + k) / (math.factorial(i) * math.factorial(j) * math.factorial(k)) for k in range(5)] for j in range(5)]
        for i in range(5)
    ]
)


@_jit
def _place(draws, terms, white, out):
    """Put the values that the draws can take where they displace the vector (value, 3)."""
    for j in range(len(draws)):
        for i in range(3):
            add = 0.0
            for t in range(draws.shape[1]):
                if terms[j, t] >= 0:
                    add += draws[j, t] * white[i, terms[j, t]]
            out[j, i] = add


@_jit
def _cumulants(places, even, odd, first, last, skew, two, three, four):
    """Add the second (3, 3), third (4, 4) and fourth (5, 5) cumulants of one group as forms: [i, j] before x^i y^j and what is left of z."""
    own = np.zeros((3, 3))
    for n in range(first, last):
        x, y, z = places[n]
        for i in range(3):
            for j in range(3 - i):
                own[i, j] += even[n] * _COUNTS[i, j, 2 - i - j] * x**i * y**j * z ** (2 - i - j)
        if skew:
            for i in range(4):
                for j in range(4 - i):
                    three[i, j] += odd[n] * _COUNTS[i, j, 3 - i - j] * x**i * y**j * z ** (3 - i - j)
        x2, y2, z2 = x * x, y * y, z * z
        w = even[n]
        four[4, 0] += w * x2 * x2
        four[0, 4] += w * y2 * y2
        four[0, 0] += w * z2 * z2
        four[2, 2] += 6.0 * w * x2 * y2
        four[2, 0] += 6.0 * w * x2 * z2
        four[0, 2] += 6.0 * w * y2 * z2
        four[3, 1] += 4.0 * w * x2 * x * y
        four[3, 0] += 4.0 * w * x2 * x * z
        four[1, 3] += 4.0 * w * y2 * y * x
        four[0, 3] += 4.0 * w * y2 * y * z
        four[1, 0] += 4.0 * w * z2 * z * x
        four[0, 1] += 4.0 * w * z2 * z * y
        four[2, 1] += 12.0 * w * x2 * y * z
        four[1, 2] += 12.0 * w * y2 * x * z
        four[1, 1] += 12.0 * w * z2 * x * y
    for i in range(3):
        for j in range(3 - i):
            two[i, j] += own[i, j]
            for k in range(3):
                for m in range(3 - k):
                    four[i + k, j + m] -= 3.0 * own[i, j] * own[k, m]


@_jit
def _along(form, degree, x, y, out):
    """Give a form's coefficients (power of z,) where x and y are known."""
    for k in range(degree + 1):
        add = 0.0
        for i in range(degree - k + 1):
            add += form[i, degree - k - i] * x**i * y ** (degree - k - i)
        out[k] = add


@_jit
def _beyond(axis, at, two, three, four, places, even, odd, first, large):
    """Bound the chance of lying beyond the box at one of its ends: Chernoff's inequality, exp(K(at) - at BOX)."""
    end = 2 * (axis == 0), 2 * (axis == 1)
    size = 0.5 * two[end] * at * at
    size += three[3 * end[0] // 2, 3 * end[1] // 2] * at**3 / 6.0 + four[2 * end[0], 2 * end[1]] * at**4 / 24.0
    for g in large:
        add = 0.0
        for j in range(first[g], first[g + 1]):
            add += even[j] * math.cosh(at * places[j, axis]) + odd[j] * math.sinh(at * places[j, axis])
        size += math.log(add)
    return math.exp(size - abs(at) * BOX)


@_jit
def _unended(highest, bias, root, two, four, places, even, odd, first, large):
    """Say how large the characteristic function still is where the waves end and beyond: the mean over where the vector may be.

    There a wave of the length, exp(i k |e|), is locally one with its wave vector along e.
    """
    quadratic, quartic = np.zeros(3), np.zeros(5)
    out = 0.0
    for a, b, c in np.ndindex((2, 2, 2)):
        x, y, z = bias[0] + root[0] * _AT[a], bias[1] + root[1] * _AT[b], bias[2] + root[2] * _AT[c]
        length = math.sqrt(x * x + y * y + z * z)
        for far in _FURTHER:
            scale = far * highest / max(length, 1e-300)
            u, v, w = scale * x * root[0], scale * y * root[1], scale * z * root[2]
            _along(two, 2, u, v, quadratic)
            _along(four, 4, u, v, quartic)
            grow = (quartic[0] + w * (quartic[1] + w * (quartic[2] + w * (quartic[3] + w * quartic[4])))) / 24.0
            size = math.exp(min(grow - 0.5 * (quadratic[0] + w * (quadratic[1] + w * quadratic[2])), 0.0))
            for g in large:
                re = im = 0.0
                for j in range(first[g], first[g + 1]):
                    turn = u * places[j, 0] + v * places[j, 1] + w * places[j, 2]
                    re += even[j] * math.cos(turn)
                    im += odd[j] * math.sin(turn)
                size *= math.sqrt(re * re + im * im)
            out += size / 8.0
    return out


@_jit
def _turns(step, most, out):
    """Fill in cosines and sines (2, 2 most + 1) of -most to most steps."""
    c, s = math.cos(step), math.sin(step)
    out[0, most], out[1, most] = 1.0, 0.0
    for k in range(1, most + 1):
        x, y = out[0, most + k - 1], out[1, most + k - 1]
        x, y = x * c - y * s, x * s + y * c
        out[0, most + k], out[1, most + k] = x, y
        out[0, most - k], out[1, most - k] = x, -y


@_lanes
def _multiply(first, last, a, b, begin, count, turns, even, odd, skew, re, im, out_re, out_im):
    """Multiply one group's characteristic function into a row of the lattice."""
    for c in range(count):
        re[c] = im[c] = 0.0
    for j in range(first, last):
        u_re = turns[j, 0, 0, a] * turns[j, 1, 0, b] - turns[j, 0, 1, a] * turns[j, 1, 1, b]
        u_im = turns[j, 0, 0, a] * turns[j, 1, 1, b] + turns[j, 0, 1, a] * turns[j, 1, 0, b]
        x, y = even[j] * u_re, even[j] * u_im
        for c in range(count):
            re[c] += x * turns[j, 2, 0, begin + c] - y * turns[j, 2, 1, begin + c]
        if skew:
            x, y = odd[j] * u_re, odd[j] * u_im
            for c in range(count):
                im[c] += x * turns[j, 2, 1, begin + c] + y * turns[j, 2, 0, begin + c]
    for c in range(count):
        x = out_re[c] * re[c] - out_im[c] * im[c]
        out_im[c] = out_re[c] * im[c] + out_im[c] * re[c]
        out_re[c] = x


@_lanes
def _add(count, c, s, re, im, out_re, out_im):
    for k in range(count):
        out_re[k] += c * re[k] - s * im[k]
        out_im[k] += c * im[k] + s * re[k]


@_lanes
def _add_real(count, c, s, re, im, out):
    for k in range(count):
        out[k] += c * re[k] - s * im[k]


@_lanes
def _harvest(count, density, cosine, before, now, waves, out):
    """Add sums of density times cos(m angle) to out, m from 0 to waves, by Chebyshev's recurrence."""
    zero = one = 0.0
    for k in range(count):
        before[k], now[k] = 1.0, cosine[k]
        zero += density[k]
        one += density[k] * cosine[k]
    out[0] += zero
    out[1] += one
    for m in range(2, waves + 1):
        add = 0.0
        for k in range(count):
            new = 2.0 * cosine[k] * now[k] - before[k]
            before[k] = now[k]
            now[k] = new
            add += density[k] * new
        out[m] += add


@_jit
def _series(bias, root, white, mean, fine, draws, terms, even, odd, first, skew, sixth, out):
    """Fill in one vector's series; gives its half period, how many waves (0 where the lattice would be too large), and the share it may miss."""
    groups = len(first) - 1
    places = np.empty((len(draws), 3))
    _place(draws, terms, white, places)
    weight = np.zeros(groups)
    for n in range(groups):
        for j in range(first[n], first[n + 1]):
            weight[n] += even[j] * (places[j, 0] ** 2 + places[j, 1] ** 2 + places[j, 2] ** 2)
        weight[n] = _PER_SIXTH * sixth[n] * weight[n] ** 3
    two, three, four = np.zeros((3, 3)), np.zeros((4, 4)), np.zeros((5, 5))
    large = np.empty(groups, np.int64)
    kept, missed = 0, 0.0
    for g in np.argsort(weight):
        if missed + weight[g] <= _LUMPED:
            missed += weight[g]
            _cumulants(places, even, odd, first[g], first[g + 1], skew[g], two, three, four)
        else:
            large[kept] = g
            kept += 1
    large = large[:kept]
    all_three, all_four = three.copy(), four.copy()
    for g in large:
        _cumulants(places, even, odd, first[g], first[g + 1], skew[g], np.zeros((3, 3)), all_three, all_four)
    size = math.sqrt(bias[0] ** 2 + bias[1] ** 2 + bias[2] ** 2)
    pull = np.zeros(3)
    for i in range(3):
        if root[i] > 0:
            pull[i] = root[i] * min(1.0, (abs(bias[i]) + _SPAN * root[i]) / (_NEAR * mean))
            for sign in (-1.0, 1.0):
                missed += _beyond(i, sign * BOX, two, three, four, places, even, odd, first, large)
    highest = fine * _STEP / pull.max()
    half = size + BOX * root.max()
    waves = math.ceil(highest * half / math.pi)
    missed += _COUNTED * _unended(highest, bias, root, two, four, places, even, odd, first, large)
    far, points = np.zeros(3, np.int64), np.ones(3, np.int64)
    for i in range(3):
        if root[i] > 0:
            far[i] = math.ceil(_MARGIN * highest * pull[i] / _STEP) + _MORE
            points[i] = math.ceil(BOX * (far[i] * _STEP + highest * pull[i]) / math.pi) + 1
    if waves > MOST_WAVES or points[0] * points[1] * points[2] > MOST_POINTS:
        return half, 0, missed
    longest = 2 * far.max() + 1
    turns = np.empty((len(draws), 3, 2, longest))
    for g in large:
        for j in range(first[g], first[g + 1]):
            for i in range(3):
                _turns(_STEP * places[j, i], far[i], turns[j, i])
    back = np.empty((3, points.max(), 2, longest))
    for i in range(3):
        for u in range(points[i]):
            _turns(-math.pi * (2 * u + 1 - points[i]) / points[i], far[i], back[i, u])
    plane = points[1] * points[2]
    spectrum = np.zeros((far[0] + 1, 2, plane))
    row = np.empty((2, points[2]))
    re, im, phi_re, phi_im = np.empty((4, longest))
    quadratic, cubic, quartic, all_cubic, all_quartic = np.zeros(3), np.zeros(4), np.zeros(5), np.zeros(4), np.zeros(5)
    inverse = np.array([1.0 / max(far[i], 1) for i in range(3)])
    for a in range(far[0] + 1):
        for b in range(-far[1], far[1] + 1):
            x, y = a * _STEP, b * _STEP
            across = (a * inverse[0]) ** 2 + (b * inverse[1]) ** 2
            if across > 1.0:
                continue
            reach = int(math.sqrt(1.0 - across) * far[2])
            count, begin = 2 * reach + 1, far[2] - reach
            _along(two, 2, x, y, quadratic)
            _along(three, 3, x, y, cubic)
            _along(four, 4, x, y, quartic)
            for c in range(count):
                z = (c - reach) * _STEP
                grow = (quartic[0] + z * (quartic[1] + z * (quartic[2] + z * (quartic[3] + z * quartic[4])))) / 24.0
                grow = math.exp(min(grow - 0.5 * (quadratic[0] + z * (quadratic[1] + z * quadratic[2])), 0.0))
                angle = (cubic[0] + z * (cubic[1] + z * (cubic[2] + z * cubic[3]))) / 6.0
                phi_re[c], phi_im[c] = (grow, 0.0) if angle == 0.0 else (grow * math.cos(angle), -grow * math.sin(angle))
            for g in large:
                _multiply(first[g], first[g + 1], a + far[0], b + far[1], begin, count, turns, even, odd, skew[g], re, im, phi_re, phi_im)
            _along(all_three, 3, x, y, all_cubic)
            _along(all_four, 4, x, y, all_quartic)
            row[:] = 0.0
            for c in range(count):
                z = (c - reach) * _STEP
                normal = math.exp(-0.5 * (x * x + y * y + z * z))
                q = (all_quartic[0] + z * (all_quartic[1] + z * (all_quartic[2] + z * (all_quartic[3] + z * all_quartic[4])))) / 24.0
                k = (all_cubic[0] + z * (all_cubic[1] + z * (all_cubic[2] + z * all_cubic[3]))) / 6.0
                soft = (2.0 if a > 0 else 1.0) * math.exp(-_END * (across + ((c - reach) * inverse[2]) ** 2) ** _SOFT)
                phi_re[c], phi_im[c] = soft * (phi_re[c] - normal * (1.0 + q)), soft * (phi_im[c] + normal * k)
            for u in range(points[2]):
                c_re = c_im = 0.0
                for c in range(count):
                    c_re += phi_re[c] * back[2, u, 0, begin + c] - phi_im[c] * back[2, u, 1, begin + c]
                    c_im += phi_re[c] * back[2, u, 1, begin + c] + phi_im[c] * back[2, u, 0, begin + c]
                row[0, u], row[1, u] = c_re, c_im
            for u in range(points[1]):
                own = slice(u * points[2], (u + 1) * points[2])
                _add(points[2], back[1, u, 0, b + far[1]], back[1, u, 1, b + far[1]], row[0], row[1], spectrum[a, 0, own], spectrum[a, 1, own])
    square, density, cosine, before, now = np.empty((5, plane))
    for u in range(points[1]):
        for v in range(points[2]):
            y = bias[1] + root[1] * BOX * (2 * u + 1 - points[1]) / points[1]
            z = bias[2] + root[2] * BOX * (2 * v + 1 - points[2]) / points[2]
            square[u * points[2] + v] = y * y + z * z
    out[:] = 0.0
    for u in range(points[0]):
        x = bias[0] + root[0] * BOX * (2 * u + 1 - points[0]) / points[0]
        density[:] = 0.0
        for a in range(far[0] + 1):
            _add_real(plane, back[0, u, 0, a + far[0]], back[0, u, 1, a + far[0]], spectrum[a, 0], spectrum[a, 1], density)
        for k in range(plane):
            cosine[k] = math.cos(min(math.sqrt(square[k] + x * x) * (math.pi / half), math.pi))
        _harvest(plane, density, cosine, before, now, waves, out)
    for m in range(waves + 1):
        out[m] *= (2.0 if m > 0 else 1.0) * math.exp(-_END * (m / (waves + 1)) ** _SOFT_SERIES) / (points[0] * points[1] * points[2])
    return half, waves, missed


@_jit
def series(bias, root, white, mean, fine, draws, terms, even, odd, first, skew, sixth, halves, counts, missed, out):
    """Fill in, for every vector: half period, number of waves, the share missed (vector,), and the series' coefficients (vector, MOST_WAVES + 1)."""
    for v in range(len(bias)):
        halves[v], counts[v], missed[v] = _series(bias[v], root[v], white[v], mean[v], fine, draws, terms, even, odd, first, skew, sixth, out[v])


@_jit
def read(halves, counts, coefficients, lengths, shares, densities):
    """Fill in what the series add to the shares below these lengths (vector, length), and to the densities there."""
    for v in range(len(lengths)):
        for n in range(lengths.shape[1]):
            turn = math.pi * lengths[v, n] / halves[v]
            c, s, cm, sm = math.cos(turn), math.sin(turn), 1.0, 0.0
            share, density = coefficients[v, 0] * lengths[v, n], coefficients[v, 0]
            for m in range(1, counts[v] + 1):
                cm, sm = cm * c - sm * s, sm * c + cm * s
                share += coefficients[v, m] * sm * halves[v] / (math.pi * m)
                density += coefficients[v, m] * cm
            shares[v, n], densities[v, n] = share / halves[v], density / halves[v]
