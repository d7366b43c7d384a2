"""The kernel behind the length of a normal vector: its moments, its distribution and its quantiles, vector by vector.

Q is the squared length, E exp(s Q) = M(s) its moment generating function, known in closed form. Means are integrals of M along the negative axis,
shares of Q above a limit are integrals of M(s) exp(-s q) / s along a parabola that leaves the real axis near the saddlepoint and bends away from it.
A vector that is not quite normal, with known fourth cumulants, has M (1 + d) in place of M (Edgeworth's first term, exact in s).
Compiled once by Numba and cached; no threads in here.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numba import njit

# The fourth cumulants of a vector, by how often x, y and z stand in them: the coefficients of the quartic form k_ijkl h_i h_j h_k h_l.
FOURTHS: Final = tuple((i, j, 4 - i - j) for i in range(5) for j in range(5 - i))
_PAIRS: Final = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


def _fourth_table() -> tuple[np.ndarray, np.ndarray]:
    """Which coefficient of the quartic form is an entry of the tensor part of, and how many entries share it? For pairs of pairs (6, 6)."""
    at, shared = np.empty((6, 6), np.int64), np.empty((6, 6))
    for a, first in enumerate(_PAIRS):
        for b, second in enumerate(_PAIRS):
            powers = tuple((first + second).count(axis) for axis in range(3))
            at[a, b] = FOURTHS.index(powers)
            shared[a, b] = math.factorial(4) / math.prod(math.factorial(n) for n in powers)
    return at, shared


_AT, _SHARED = _fourth_table()

# Columns of what is known of a length besides its quantiles.
MEAN, MEAN_ERROR, THIRD = range(3)

_CERTAIN: Final = 1e-10  # a smaller share of the mean square that varies: the length is normal itself to 1e-10
_STEP: Final = 0.45  # between nodes, in standard deviations of the tilted law
_AWAY: Final = 1.4  # least way from the pole at s = 0, likewise
_NEVER: Final = -40.0  # the logarithm of a share that is none
_LEFTMOST: Final = -1e12  # below the least possible length there is no saddlepoint
_PER_POLE: Final = 2.6  # nodes within the way to the pole, at least
_STEEP: Final = 2.0  # the contour's lean in the end; where that leads uphill because the normal part is large, the other
_FLAT: Final = 0.8
_NODES: Final = 256
_SMALL: Final = 1e-8  # of the first node: the rest adds nothing
_FAR: Final = 0.35  # a quantile so far from the guess, in standard deviations, asks for a contour of its own
_CLOSE: Final = 5e-3  # of the reach of a contour: the next of Halley's steps, which is of its cube, is not worth taking
_STEPS: Final = 60
_CONTOURS: Final = 20
_RIGHT: Final = 0.94  # from this share on the saddlepoint is far enough to the right of the pole
# What Edgeworth's first term d leaves out is told as |d| times (a + |d|) times b, every node with its size: above the middle of the lengths with
# the first pair, below it and for the mean with the second. Chosen so that it covers sums of few flat, two-sided and wavy draws.
_TAIL: Final = (1.0, 0.25)
_BODY: Final = (1.0, 1.0)
_SPACING: Final = 0.24  # of the nodes of the means

_ROOT_TWO: Final = math.sqrt(2.0)

_jit = njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"}, boundscheck=False)


@_jit
def _axes(cov, turn, spread):
    """Turn a symmetric matrix (3, 3), which is overwritten, into its axes (columns of `turn`) and its variances along them (Jacobi's rotations)."""
    turn[:, :] = 0.0
    for i in range(3):
        turn[i, i] = 1.0
    for _ in range(12):
        off = cov[0, 1] ** 2 + cov[0, 2] ** 2 + cov[1, 2] ** 2
        if off <= 1e-36 * (cov[0, 0] ** 2 + cov[1, 1] ** 2 + cov[2, 2] ** 2):
            break
        for i, j in ((0, 1), (0, 2), (1, 2)):
            if cov[i, j] == 0.0:
                continue
            k = 3 - i - j
            slope = (cov[j, j] - cov[i, i]) / (2.0 * cov[i, j])
            t = 1.0 / (abs(slope) + np.sqrt(slope * slope + 1.0))
            t = -t if slope < 0 else t
            c = 1.0 / np.sqrt(t * t + 1.0)
            s = t * c
            cov[i, i], cov[j, j] = cov[i, i] - t * cov[i, j], cov[j, j] + t * cov[i, j]
            cov[i, j] = cov[j, i] = 0.0
            first, second = cov[i, k], cov[j, k]
            cov[i, k] = cov[k, i] = c * first - s * second
            cov[j, k] = cov[k, j] = s * first + c * second
            for r in range(3):
                first, second = turn[r, i], turn[r, j]
                turn[r, i], turn[r, j] = c * first - s * second, s * first + c * second
    for i in range(3):
        spread[i] = max(cov[i, i], 0.0)


@_jit
def _turned(form, turn, out, work):
    """Give the fourth cumulants of the vector's parts along other axes: the tensor by pairs of pairs (6, 6), from its quartic form (15,)."""
    # The tensor as a matrix over pairs, and what each pair becomes along the new axes.
    for a in range(6):
        i, j = _PAIRS[a]
        for b in range(6):
            k, m = _PAIRS[b]
            work[a, b] = turn[k, i] * turn[m, j] if k == m else turn[k, i] * turn[m, j] + turn[m, i] * turn[k, j]
    for a in range(6):
        for b in range(6):
            add = 0.0
            for c in range(6):
                add += work[a, c] * form[_AT[c, b]] / _SHARED[c, b]
            out[a, b + 6] = add
    for a in range(6):
        for b in range(6):
            add = 0.0
            for c in range(6):
                add += out[a, c + 6] * work[b, c]
            out[a, b] = add


@_jit
def _edgeworth(s, spread, mean, tensor):
    """Give d(s): what fourth cumulants add to M, as its share. k : (V V - 6 G G) / 24, G = 2 s / (1 - 2 s spread), V = 3 G + (G mean)(G mean)."""
    g0, g1, g2 = 2.0 * s / (1.0 - 2.0 * s * spread[0]), 2.0 * s / (1.0 - 2.0 * s * spread[1]), 2.0 * s / (1.0 - 2.0 * s * spread[2])
    h0, h1, h2 = g0 * mean[0], g1 * mean[1], g2 * mean[2]
    v0, v1, v2 = h0 * h0 + 3.0 * g0, h1 * h1 + 3.0 * g1, h2 * h2 + 3.0 * g2
    v3, v4, v5 = 2.0 * h1 * h2, 2.0 * h0 * h2, 2.0 * h0 * h1
    t = tensor
    add = v0 * (t[0, 0] * v0 + 2.0 * (t[0, 1] * v1 + t[0, 2] * v2 + t[0, 3] * v3 + t[0, 4] * v4 + t[0, 5] * v5))
    add += v1 * (t[1, 1] * v1 + 2.0 * (t[1, 2] * v2 + t[1, 3] * v3 + t[1, 4] * v4 + t[1, 5] * v5))
    add += v2 * (t[2, 2] * v2 + 2.0 * (t[2, 3] * v3 + t[2, 4] * v4 + t[2, 5] * v5))
    add += v3 * (t[3, 3] * v3 + 2.0 * (t[3, 4] * v4 + t[3, 5] * v5)) + v4 * (t[4, 4] * v4 + 2.0 * t[4, 5] * v5) + t[5, 5] * v5 * v5
    less = g0 * (t[0, 0] * g0 + 2.0 * (t[0, 1] * g1 + t[0, 2] * g2)) + g1 * (t[1, 1] * g1 + 2.0 * t[1, 2] * g2) + t[2, 2] * g2 * g2
    return (add - 6.0 * less) / 24.0


@_jit
def _slopes(s, spread, square):
    """Give the first three derivatives of K = log M at a real s."""
    first = second = third = 0.0
    for i in range(3):
        v = 1.0 / (1.0 - 2.0 * spread[i] * s)
        l, b = spread[i] * v, square[i] * v * v  # noqa: E741 - lambda
        first += l + b
        second += 2.0 * l * l + 4.0 * b * l
        third += 8.0 * l * l * l + 24.0 * b * l * l
    return first, second, third


@_jit
def _saddle(q, spread, square, end):
    """At which s < end does K' reach q > 0? Newton's steps, kept between what is known to be below and above."""
    low, high = -np.inf, end
    s = 0.0
    for _ in range(_STEPS):
        first, second, _third = _slopes(s, spread, square)
        if first < q:
            low = s
        else:
            high = s
        # K' grows without limit towards the end and falls to nothing far to the left, both like 1 / s: a step on 1 / K' is straight there.
        s_new = s + (q - first) / second * (first / q if first > 0 else 1.0)
        if not low < s_new < high:
            s_new = 0.5 * (low + high) if low > -np.inf else 2.0 * min(s, -1.0)
        if abs(s_new - s) <= 1e-4 * (abs(s_new) + 1.0 / np.sqrt(second)):
            return s_new
        s = s_new
        if s < _LEFTMOST:
            return s
    return s


@_jit
def _contour(q, above, spread, square, mean, tensor, bent, nodes, weights, spare):
    """Lay the contour for shares of Q near q: nodes s, weights M (1 + d) ds exp(-s q) / pi, and what is left out alike; gives how many.

    0 where all is on one side of q, -1 where no contour was found. To the right of the pole the integral is the share above, to the left less
    the share below.
    """
    end = 1.0 / (2.0 * max(spread[0], spread[1], spread[2]))
    c = _saddle(q, spread, square, end)
    certain = -c * q
    for i in range(3):
        w = 1.0 - 2.0 * spread[i] * c
        certain += square[i] * c / w - 0.5 * np.log(w)
    if certain < _NEVER or c <= _LEFTMOST:  # Chernoff's bound
        return 0
    away = _AWAY / np.sqrt(_slopes(0.0, spread, square)[1])
    if above:
        if c < away:
            c = max(c, min(away, 0.6 * end))
    else:
        c = min(c, -away)
    _first, second, third = _slopes(c, spread, square)
    bend = third / (6.0 * second)
    step = min(_STEP / np.sqrt(second), abs(c) / _PER_POLE)
    left = _TAIL if above else _BODY
    count = _walk(q, c, step, bend, _STEEP, 1.05, left, spread, square, mean, tensor, bent, nodes, weights, spare)
    if count < 0:
        count = _walk(q, c, step, bend, _FLAT, 20.0, left, spread, square, mean, tensor, bent, nodes, weights, spare)
    return count


@_jit
def _walk(q, c, step, bend, lean, rise, left, spread, square, mean, tensor, bent, nodes, weights, spare):
    """Lay one contour from c on, x = c + bend y^2 at first, along dx = lean dy in the end; gives how many nodes, -1 where it leads uphill or far."""
    before_re, before_im = 1.0, 0.0
    top, uphill = 0.0, np.inf
    for k in range(_NODES):
        y = (k + 0.5) * step
        root = np.sqrt(1.0 + (2.0 * bend * y / lean) ** 2)
        x = c + 2.0 * bend * y * y / (1.0 + root)
        grow, turn = -x * q, -y * q
        z_re, z_im = 1.0, 0.0
        for i in range(3):
            p, m = 1.0 - 2.0 * spread[i] * x, -2.0 * spread[i] * y
            size = p * p + m * m
            grow += square[i] * (x * p + m * y) / size
            turn += square[i] * y / size
            z_re, z_im = z_re * p - z_im * m, z_re * m + z_im * p
        # The root of the product of three: the branch that goes on from the node before.
        size = np.sqrt(z_re * z_re + z_im * z_im)
        r_re = np.sqrt(0.5 * (size + abs(z_re)))
        r_im = 0.5 * z_im / r_re
        if z_re < 0:
            r_re, r_im = abs(r_im), (r_re if z_im >= 0 else -r_re)
        if r_re * before_re + r_im * before_im < 0:
            r_re, r_im = -r_re, -r_im
        before_re, before_im = r_re, r_im
        large = np.exp(min(grow, 600.0)) * step / (np.pi * size)
        e = complex(large * np.cos(turn), large * np.sin(turn)) * complex(r_re, -r_im) * complex(1.0, -2.0 * bend * y / root)
        s = complex(x, y)
        nodes[k] = s
        spare[k] = 0.0
        normal = abs(e)
        if bent:
            d = _edgeworth(s, spread, mean, tensor)
            size = abs(d)
            spare[k] = normal * size * (left[0] + size) * left[1]
            e = e * (1.0 + d)
        weights[k] = e
        there = abs(e)
        top = max(top, there)
        if not normal <= uphill:
            return -1
        uphill = min(uphill, rise * normal)
        if there < _SMALL * top:
            return k + 1
    return -1


@_jit
def _share(count, nodes, weights, by, above):
    """Give the share of Q below q + by, its density there and the density's slope."""
    share = density = slope = 0.0
    for k in range(count):
        s = nodes[k]
        e = weights[k] * np.exp(-s * by) if by != 0.0 else weights[k]
        share += (e / s).real
        density += e.real
        slope -= (e * s).real
    return (1.0 - share if above else -share), density, slope


@_jit
def _left_out(count, nodes, spare):
    """Give the largest share that what is left out beyond Edgeworth's term can move across q."""
    out = 0.0
    for k in range(count):
        out += spare[k] / abs(nodes[k])
    return out


@_jit
def _guess(z, spread, square):
    """Guess the quantile of Q at the normal law's z: as of a chi-square with its first three moments (J. Imhof, Biometrika 48 (1961) 419)."""
    first, second, third = _slopes(0.0, spread, square)
    freedom = 8.0 * second * second * second / (third * third)
    root = 1.0 - 2.0 / (9.0 * freedom) + z * np.sqrt(2.0 / (9.0 * freedom))
    return max(first + np.sqrt(0.5 * second * freedom) * (max(root, 0.0) ** 3 - 1.0), 0.02 * first)


@_jit
def _moments(spread, square, mean, tensor, bent, out):
    """Give the mean length, what what is left out beyond Edgeworth's term could add to it, and the mean cubed length (of the normal vector)."""
    first = third = correction = left = 0.0
    k = 0
    while True:
        # u = sinh x, s = -u^2: the integrands are even in x, so that the plain sum over equal steps is exact to the last digits.
        x = k * _SPACING
        u = np.sinh(x)
        s = -u * u
        m, inside = 1.0, 0.0
        for i in range(3):
            w = 1.0 - 2.0 * spread[i] * s
            m *= w
            inside += square[i] * s / w
        m = np.exp(inside) / np.sqrt(m)
        one, two, _three = _slopes(s, spread, square)
        wide = np.cosh(x) * (0.5 if k == 0 else 1.0)
        add = m * one * wide
        first += add
        third += m * (one * one + two) * wide
        if bent and k > 0:
            d = _edgeworth(s, spread, mean, tensor)
            correction -= 0.5 * m * d / (-s) * wide
            left += 0.5 * m * abs(d) * (_BODY[0] + abs(d)) * _BODY[1] / (-s) * wide
        k += 1
        if k > 1 and add < 1e-10 * first:
            break
    scale = 2.0 / np.sqrt(np.pi) * _SPACING
    out[MEAN] = scale * (first + correction)
    out[MEAN_ERROR] = scale * left
    out[THIRD] = scale * third


@_jit
def _prepare(bias, cov, fourth, bent, mean, spread, square, turn, tensor, work):
    """Turn one vector to its own axes and scale it to mean square one; gives the root mean square, or 0 where nothing is left."""
    trace = cov[0, 0] + cov[1, 1] + cov[2, 2]
    size2 = trace + bias[0] ** 2 + bias[1] ** 2 + bias[2] ** 2
    if not size2 > 0:
        return size2  # zero, or not a number
    for i in range(3):
        for j in range(3):
            work[i, j] = 0.5 * (cov[i, j] + cov[j, i]) / size2
    _axes(work, turn, spread)
    size = np.sqrt(size2)
    for i in range(3):
        add = 0.0
        for j in range(3):
            add += turn[j, i] * bias[j]
        mean[i] = add / size
        square[i] = mean[i] ** 2
    if bent:
        _turned(fourth, turn, tensor, work)
        tensor /= size2 * size2
    return size


@_jit
def _along(spread, mean):
    """Give the length of the mean, the deviation along it, and the mean that the variance across it adds: what a nearly certain length needs."""
    length2 = mean[0] ** 2 + mean[1] ** 2 + mean[2] ** 2
    variance = (spread[0] * mean[0] ** 2 + spread[1] * mean[1] ** 2 + spread[2] * mean[2] ** 2) / length2
    length = np.sqrt(length2)
    return length, np.sqrt(variance), (spread[0] + spread[1] + spread[2] - variance) / (2.0 * length)


@_jit
def lengths(bias, covariance, fourth, levels, z, moments, quantiles, errors):
    """Fill in, for every vector: moments (vector, 3), quantiles (vector, level) and what what is left out beyond Edgeworth's term could move them by.

    bias (vector, 3), covariance (vector, 3, 3), fourth (vector, 15) quartic forms or (0, 15) for normal vectors; z the normal quantiles of `levels`.
    """
    bent = len(fourth) > 0
    mean, spread, square = np.empty(3), np.empty(3), np.empty(3)
    turn, tensor, work = np.empty((3, 3)), np.zeros((6, 12)), np.empty((6, 6))
    nodes, weights, spare = np.empty(_NODES, np.complex128), np.empty(_NODES, np.complex128), np.empty(_NODES)
    for v in range(len(bias)):
        form = fourth[v] if bent else bias[v]
        size = _prepare(bias[v], covariance[v], form, bent, mean, spread, square, turn, tensor, work)
        if not size > 0:
            moments[v], quantiles[v], errors[v] = size, size, size
            continue
        if spread[0] + spread[1] + spread[2] < _CERTAIN:
            length, deviation, more = _along(spread, mean)
            moments[v, MEAN], moments[v, MEAN_ERROR], moments[v, THIRD] = size * (length + more), 0.0, size**3
            for k in range(len(levels)):
                quantiles[v, k] = size * (length + more + z[k] * deviation)
                errors[v, k] = 0.0
            continue
        _moments(spread, square, mean, tensor, bent, moments[v])
        moments[v, MEAN] *= size
        moments[v, MEAN_ERROR] *= size
        moments[v, THIRD] *= size**3
        for k in range(len(levels)):
            q, error = _quantile(levels[k], z[k], spread, square, mean, tensor, bent, nodes, weights, spare)
            quantiles[v, k] = size * np.sqrt(q)
            errors[v, k] = size * error


@_jit
def _quantile(level, z, spread, square, mean, tensor, bent, nodes, weights, spare):
    """Give the quantile of Q, and the error of its root that comes from what is left out beyond Edgeworth's term; NaN where there is none."""
    above = level > _RIGHT
    q = _guess(z, spread, square)
    near = _FAR * np.sqrt(_slopes(0.0, spread, square)[1])
    low, high = 0.0, np.inf
    for _ in range(_CONTOURS):
        count = _contour(q, above, spread, square, mean, tensor, bent, nodes, weights, spare)
        if count < 0:
            return np.nan, np.nan
        by = 0.0
        for step in range(_STEPS):
            share, density, slope = _share(count, nodes, weights, by, above)
            if count == 0:
                share = 1.0 if q > 1.0 else 0.0
            if step == 0:
                low, high = (q, high) if share < level else (low, q)
            if not density > 0:
                break
            move = (level - share) / density
            move /= max(1.0 + 0.5 * move * slope / density, 0.5)  # Halley's step
            by += move
            if abs(by) > near or q + by <= 0:
                break
            if abs(move) < _CLOSE * near:
                q += by
                return q, _left_out(count, nodes, spare) / (2.0 * np.sqrt(q) * density)
        # The root is too far for this contour: lay another one where the step leads, or between what is below and what is above.
        by = min(max(by, -3.0 * near), 3.0 * near)
        q = q + by if low < q + by < high else 0.5 * (low + min(high, 2.0 * low + near))
    return np.nan, np.nan


@_jit
def shares(bias, covariance, fourth, limits, out, errors):
    """Fill in the share of every vector's lengths below each limit (vector, limit), and how much what is left out could change it."""
    bent = len(fourth) > 0
    mean, spread, square = np.empty(3), np.empty(3), np.empty(3)
    turn, tensor, work = np.empty((3, 3)), np.zeros((6, 12)), np.empty((6, 6))
    nodes, weights, spare = np.empty(_NODES, np.complex128), np.empty(_NODES, np.complex128), np.empty(_NODES)
    for v in range(len(bias)):
        form = fourth[v] if bent else bias[v]
        size = _prepare(bias[v], covariance[v], form, bent, mean, spread, square, turn, tensor, work)
        for k in range(len(limits)):
            errors[v, k] = 0.0
            if not size > 0:
                out[v, k] = 1.0 if size == 0 else np.nan
                continue
            r = limits[k] / size
            if spread[0] + spread[1] + spread[2] < _CERTAIN:
                length, deviation, more = _along(spread, mean)
                out[v, k] = _normal_share(r - length - more, deviation)
                continue
            if r <= 0:
                out[v, k] = 0.0
                continue
            above = _slopes(0.0, spread, square)[0] < r * r
            count = _contour(r * r, above, spread, square, mean, tensor, bent, nodes, weights, spare)
            if count < 0:
                out[v, k] = errors[v, k] = np.nan
                continue
            out[v, k] = min(max(_share(count, nodes, weights, 0.0, above)[0], 0.0), 1.0)
            errors[v, k] = _left_out(count, nodes, spare)


@_jit
def _normal_share(x, deviation):
    if deviation == 0.0:
        return 1.0 if x >= 0 else 0.0
    return 0.5 * math.erfc(-x / (deviation * _ROOT_TWO))


@_jit
def add_up(shift, pairs, pair_values, fours, four_values, covariance, fourth):
    """Sum terms up to the covariance (6, pose) over pairs of axes and the quartic forms of fourth cumulants (15, pose), which begin as zeros.

    shift (3, term, pose); pairs (n, 2) and fours (n, 4) the terms, with what their draws' cumulants are worth (multiplicities included).
    """
    poses = shift.shape[2]
    first, second = np.empty((6, poses)), np.empty((6, poses))
    for n in range(len(pairs)):
        _multiply(shift, pairs[n, 0], pairs[n, 1], pair_values[n], first)
        for c in range(6):
            half = 1.0 if c < 3 else 0.5  # noqa: PLR2004 - a mixed product counts twice in the form
            for p in range(poses):
                covariance[c, p] += half * first[c, p]
    for n in range(len(fours)):
        _multiply(shift, fours[n, 0], fours[n, 1], four_values[n], first)
        if fours[n, 0] == fours[n, 2] and fours[n, 1] == fours[n, 3]:
            for c in range(6):
                for p in range(poses):
                    second[c, p] = first[c, p] / four_values[n]
        else:
            _multiply(shift, fours[n, 2], fours[n, 3], 1.0, second)
        for a in range(6):
            for b in range(6):
                c = _AT[a, b]
                for p in range(poses):
                    fourth[c, p] += first[a, p] * second[b, p]


@_jit
def _multiply(shift, first, second, value, out):
    """Give the product of two linear forms as a quadratic form (6, pose)."""
    for c in range(6):
        i, j = _PAIRS[c]
        if i == j:
            for p in range(out.shape[1]):
                out[c, p] = value * shift[i, first, p] * shift[i, second, p]
        else:
            for p in range(out.shape[1]):
                out[c, p] = value * (shift[i, first, p] * shift[j, second, p] + shift[j, first, p] * shift[i, second, p])
