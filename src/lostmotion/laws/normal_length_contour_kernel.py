"""The contour behind the length of a vector: nodes in the complex plane, and what a mixture of nearly normal vectors weighs at them.

Q is the squared length, E exp(s Q) = M(s) its moment generating function, known in closed form: the sum over the mixture's parts of
weight exp(sum of square s / w) / sqrt(product of w), w = 1 - 2 s spread. Shares of Q above a limit are integrals of M(s) exp(-s q) / s along a
hyperbola that leaves the real axis near the saddlepoint and bends away from it. With known third and fourth cumulants a part has M (1 + d) in place
of M (Edgeworth's first terms, exact in s). Compiled once by Numba and cached; no threads in here.

Loops over nodes hold no branch and no call to the mathematical library, so that the compiler makes four or eight nodes of one.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numba import njit

_STEP: Final = 0.45  # between nodes, in standard deviations of the tilted law
_AWAY: Final = 1.4  # least way from the pole at s = 0, likewise
_NEVER: Final = -40.0  # the logarithm of a share that is none
_LEFTMOST: Final = -1e12  # below the least possible length there is no saddlepoint
_PER_POLE: Final = 3.1  # nodes within the way to the pole, at least
_GROW: Final = 0.16  # from node to node, the way between them in the end
_EVEN: Final = 1e-3  # of a mixture, whose parts far from q turn fast
_PER_END: Final = 1.8  # likewise to where M ends
_STEEP: Final = 2.0  # the contour's lean in the end; where that leads uphill because the normal part is large, the other
_FLAT: Final = 0.8
_SMALL: Final = 1e-7  # of the largest node: the rest adds nothing
_STEPS: Final = 60
CHUNK: Final = 16  # nodes laid at a time
NODES: Final = 480
# What Edgeworth's first terms d leave out is told as |d| times (a + |d|) times b, every node with its size: above the middle of the lengths with
# the first pair, below it and for the mean with the second. Lengths further out than the contour's own count as much more as STEEPER times the way
# to them in deviations. Chosen so that it covers sums of few flat, two-sided and wavy draws.
TAIL: Final = (1.0, 0.25)
BODY: Final = (1.0, 1.0)
STEEPER: Final = 0.65
# A row of the table of nodes holds CHUNK of them, and of each: its place, the lean of the contour there, the way to the next; weight, weight over
# place, about the size of M there, what is left out. One flat row with fixed distances, so that the compiler sees that nothing written is read again.
X, Y, LEAN, APART, WEIGHT_RE, WEIGHT_IM, POLE_RE, POLE_IM, SIZE, SPARE = (CHUNK * k for k in range(10))
TABLE: Final = (NODES // CHUNK, 10 * CHUNK)


def _ways(grow: float) -> np.ndarray:
    """Lay nodes (row, 2, CHUNK): how many steps up, and how many to the next. Far out, where less changes, they stand further apart."""
    at = grow * (np.arange(NODES) + 0.5)
    return np.ascontiguousarray(np.stack([np.sinh(at) / grow, np.cosh(at)]).reshape(2, -1, CHUNK).swapaxes(0, 1))


_WAYS, _EVEN_WAYS = _ways(_GROW), _ways(_EVEN)
_TURN: Final = 2.0 * math.pi

jit = njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"}, boundscheck=False)
# Without branches, and free to sum in any order: for loops over nodes, where nothing is infinite and no sign of zero counts.
_FREE: Final = {"contract", "reassoc", "nsz", "nnan", "ninf"}
lanes = njit(nogil=True, cache=True, error_model="numpy", fastmath=_FREE, boundscheck=False)
inlined = njit(nogil=True, cache=True, error_model="numpy", fastmath=_FREE, boundscheck=False, forceinline=True)


@inlined
def power(x):
    """Give exp x for x from -60 to 60, to 1e-13 within 20 and 2e-9 at the ends: a polynomial at x / 256, squared eight times."""
    r = min(max(x, -60.0), 60.0) * (1.0 / 256.0)
    p = 1.0 + r * (1.0 + r * (1 / 2 + r * (1 / 6 + r * (1 / 24 + r * (1 / 120 + r * (1 / 720 + r * (1 / 5040 + r * (1 / 40320))))))))
    p *= p
    p *= p
    p *= p
    p *= p
    p *= p
    p *= p
    p *= p
    return p * p


@inlined
def wheel(angle):
    """Give cosine and sine: polynomials at an eighth of the angle, doubled three times."""
    r = (angle - _TURN * np.floor(angle * (1.0 / _TURN) + 0.5)) * 0.125
    r2 = r * r
    c = 1.0 + r2 * (-1 / 2 + r2 * (1 / 24 + r2 * (-1 / 720 + r2 * (1 / 40320 + r2 * (-1 / 3628800)))))
    s = r * (1.0 + r2 * (-1 / 6 + r2 * (1 / 120 + r2 * (-1 / 5040 + r2 * (1 / 362880 + r2 * (-1 / 39916800))))))
    c, s = c * c - s * s, 2.0 * c * s
    c, s = c * c - s * s, 2.0 * c * s
    return c * c - s * s, 2.0 * c * s


@jit
def size_at(s, j, spreads, squares):
    """Give log M of one normal vector at a real s."""
    inside, product = 0.0, 1.0
    for i in range(3):
        w = 1.0 - 2.0 * spreads[j, i] * s
        inside += squares[j, i] * s / w
        product *= w
    return inside - 0.5 * math.log(product)


@jit
def tilted(s, weights, spreads, squares):
    """Give the first three derivatives of K = log M at a real s: mean, variance and third cumulant of Q under the law tilted by exp(s Q)."""
    whole = one = two = three = top = 0.0
    for j in range(len(weights)):
        first = second = third = 0.0
        for i in range(3):
            v = 1.0 / (1.0 - 2.0 * spreads[j, i] * s)
            l, b = spreads[j, i] * v, squares[j, i] * v * v  # noqa: E741 - lambda
            first += l + b
            second += 2.0 * l * (l + 2.0 * b)
            third += 8.0 * l * l * (l + 3.0 * b)
        if len(weights) == 1:
            return first, second, third
        # Sums relative to the largest part so far.
        size = size_at(s, j, spreads, squares)
        if j == 0 or size > top:
            less = math.exp(top - size) if j > 0 else 0.0
            whole, one, two, three, top = whole * less, one * less, two * less, three * less, size
        part = weights[j] * math.exp(size - top)
        whole += part
        one += part * first
        two += part * (second + first * first)
        three += part * (third + 3.0 * second * first + first * first * first)
    one, two, three = one / whole, two / whole, three / whole
    return one, two - one * one, three - 3.0 * one * two + 2.0 * one * one * one


@jit
def _saddle(q, end, first, second, weights, spreads, squares):
    """At which s < end does K' reach q > 0? Newton's steps from zero, where K' and K'' are given, kept between what is below and what above."""
    low, high = -np.inf, end
    s = 0.0
    for _ in range(_STEPS):
        if first < q:
            low = s
        else:
            high = s
        # K' grows without limit towards the end and falls to nothing far to the left, both like 1 / s: a step on 1 / K' is straight there.
        s_new = s + (q - first) / second * (first / q if first > 0 else 1.0)
        if not low < s_new < high:
            s_new = 0.5 * (low + high) if low > -np.inf else 2.0 * min(s, -1.0)
        if abs(s_new - s) <= 1e-2 * (abs(s_new) + 1.0 / np.sqrt(second)):
            return s_new
        s = s_new
        if s < _LEFTMOST:
            return s
        first, second, _third = tilted(s, weights, spreads, squares)
    return s


@jit
def lay(q, above, mean, variance, weights, spreads, squares, means, cubic, quartic, table):
    """Lay the contour for shares of Q near q and fill in its table; gives how many rows, and how widely Q scatters here.

    0 where all is on one side of q, -1 where no contour was found. To the right of the pole the integral is the share above, to the left less
    the share below. `mean` and `variance` are Q's own.
    """
    largest, deviation = 0.0, np.sqrt(variance)
    for j in range(len(spreads)):
        for i in range(3):
            largest = max(largest, spreads[j, i])
    end = 0.5 / largest
    c = _saddle(q, end, mean, variance, weights, spreads, squares)
    if c <= _LEFTMOST:
        return 0, deviation
    top = -np.inf
    for j in range(len(weights)):
        top = max(top, size_at(c, j, spreads, squares))
    if top - c * q < _NEVER:  # Chernoff's bound
        return 0, deviation
    away = _AWAY / deviation
    if above:
        if c < away:
            c = max(c, min(away, 0.6 * end))
    else:
        c = min(c, -away)
    _first, second, third = tilted(c, weights, spreads, squares)
    bend = third / (6.0 * second)
    # To its right the bent contour comes nearer to the pole, which lies where c + i y + bend y^2 = 0.
    pole = abs(c) if c < 0.0 else 2.0 * c / (1.0 + np.sqrt(1.0 + 4.0 * bend * c))
    step = min(_STEP / np.sqrt(second), pole / _PER_POLE)
    if len(quartic) > 0:  # d has further poles where M ends
        step = min(step, (end - c) / _PER_END)
    # The first way is the shortest; the last, straight up, leads downhill always, but far.
    count = -1
    for way in range(4):
        if count < 0:
            lean, rise = (_STEEP, 1.5) if way == 0 else (_FLAT, 20.0)
            bent = bend if way < 2 else 0.25 * bend * (3 - way)  # noqa: PLR2004
            count = _walk(q, c, step, bent, lean, rise, above, weights, spreads, squares, means, cubic, quartic, table)
    return count, min(deviation, np.sqrt(second))


@jit
def _walk(q, c, step, bend, lean, rise, above, weights, spreads, squares, means, cubic, quartic, table):
    """Lay one contour from c on, x = c + bend y^2 at first, along dx = lean dy in the end; gives how many rows, -1 where it leads uphill or far."""
    before, top = np.inf, 0.0
    ways = _WAYS if len(weights) == 1 else _EVEN_WAYS
    for n in range(len(table)):
        row = table[n]
        _place(c, step, bend, lean, ways[n], row)
        for j in range(len(weights)):
            if len(quartic) > 0 and even(j, means, cubic):
                _weigh_even(j, weights, spreads, quartic, q, TAIL if above else BODY, row)
            elif len(quartic) > 0:
                _weigh_bent(j, weights, spreads, squares, means, cubic, quartic, q, TAIL if above else BODY, row)
            else:
                _weigh(j, weights, spreads, squares, q, row)
        for k in range(CHUNK):
            size = row[SIZE + k]
            if not size <= rise * before:
                return -1
            before, top = size, max(top, size)
        bent = abs(row[WEIGHT_RE + CHUNK - 1]) + abs(row[WEIGHT_IM + CHUNK - 1]) if len(quartic) > 0 else 0.0
        _close(row)
        if before + bent < _SMALL * top:
            return n + 1
    return -1


@lanes
def _place(c, step, bend, lean, ways, row):
    """Place the next nodes."""
    over = 1.0 / lean
    for k in range(ways.shape[1]):  # CHUNK, but a short loop of known length would be taken apart instead of made wide
        at, row[APART + k] = ways[0, k] * step, ways[1, k] * step
        slope = 2.0 * bend * at
        root = np.sqrt(1.0 + (slope * over) * (slope * over))
        row[X + k] = c + slope * at / (1.0 + root)
        row[Y + k] = at
        row[LEAN + k] = slope / root
        row[WEIGHT_RE + k] = row[WEIGHT_IM + k] = row[SIZE + k] = row[SPARE + k] = 0.0


@inlined
def _value(x, y, a, b, c, p, q, r, limit):
    """Give M(s) exp(-s limit) of one normal vector; a, b, c are its spreads twice, p, q, r the squares."""
    a_re, b_re, c_re = 1.0 - a * x, 1.0 - b * x, 1.0 - c * x
    a_im, b_im, c_im = -a * y, -b * y, -c * y
    a_size, b_size, c_size = a_re * a_re + a_im * a_im, b_re * b_re + b_im * b_im, c_re * c_re + c_im * c_im
    ab = a_size * b_size
    over = 1.0 / (ab * c_size)
    p, q, r = p * over * b_size * c_size, q * over * a_size * c_size, r * over * ab
    grow = p * (x * a_re + y * a_im) + q * (x * b_re + y * b_im) + r * (x * c_re + y * c_im) - x * limit
    turn = (p + q + r - limit) * y
    # Each factor's angle lies between 0 and -pi: beyond -pi the product's is where two of them are, or where its own imaginary part is positive, and
    # beyond -2 pi where the first holds alone. The root has half of it; this is its conjugate.
    ab_re, ab_im = a_re * b_re - a_im * b_im, a_re * b_im + a_im * b_re
    w_re, w_im = ab_re * c_re - ab_im * c_im, ab_re * c_im + ab_im * c_re
    w_size = np.sqrt(ab * c_size)
    one = np.sqrt(0.5 * (w_size + abs(w_re)))
    other = 0.5 * abs(w_im) / one
    u_re, u_im = one if w_re >= 0.0 else other, other if w_re >= 0.0 else one
    u_re = -u_re if ab_im > 0.0 or w_im > 0.0 else u_re
    u_im = -u_im if ab_im > 0.0 and w_im <= 0.0 else u_im
    size = power(grow) * w_size * over
    cosine, sine = wheel(turn)
    return size * (cosine * u_re - sine * u_im), size * (cosine * u_im + sine * u_re)


@lanes
def _weigh(j, weights, spreads, squares, limit, row):
    """Add one part of the mixture to the weights."""
    share, a, b, c = weights[j], 2.0 * spreads[j, 0], 2.0 * spreads[j, 1], 2.0 * spreads[j, 2]
    p, q, r = squares[j, 0], squares[j, 1], squares[j, 2]
    for k in range(CHUNK):
        m_re, m_im = _value(row[X + k], row[Y + k], a, b, c, p, q, r, limit)
        row[WEIGHT_RE + k] += share * m_re
        row[WEIGHT_IM + k] += share * m_im
        row[SIZE + k] += share * (abs(m_re) + abs(m_im))


@lanes
def _weigh_bent(j, weights, spreads, squares, means, cubic, quartic, limit, left, row):
    """Add one part of the mixture with what its cumulants change, and what they leave out.

    d = t : (h h h + 3 G h) / 6 + k : (V V - 6 G G) / 24 with G = 2 s / (1 - 2 s spread), h = G mean, V = 3 G + h h along the part's axes.
    """
    share, a, b, c = weights[j], 2.0 * spreads[j, 0], 2.0 * spreads[j, 1], 2.0 * spreads[j, 2]
    p, q, r = squares[j, 0], squares[j, 1], squares[j, 2]
    m0, m1, m2 = means[j, 0], means[j, 1], means[j, 2]
    t0, t1, t2, t3, t4 = cubic[j, 0], cubic[j, 1], cubic[j, 2], cubic[j, 3], cubic[j, 4]
    t5, t6, t7, t8, t9 = cubic[j, 5], cubic[j, 6], cubic[j, 7], cubic[j, 8], cubic[j, 9]
    f = quartic
    f00, f01, f02, f03, f04, f05 = f[j, 0, 0], f[j, 0, 1], f[j, 0, 2], f[j, 0, 3], f[j, 0, 4], f[j, 0, 5]
    f11, f12, f13, f14, f15 = f[j, 1, 1], f[j, 1, 2], f[j, 1, 3], f[j, 1, 4], f[j, 1, 5]
    f22, f23, f24, f25 = f[j, 2, 2], f[j, 2, 3], f[j, 2, 4], f[j, 2, 5]
    f33, f34, f35, f44, f45, f55 = f[j, 3, 3], f[j, 3, 4], f[j, 3, 5], f[j, 4, 4], f[j, 4, 5], f[j, 5, 5]
    base, over = left
    for k in range(CHUNK):
        m_re, m_im = _value(row[X + k], row[Y + k], a, b, c, p, q, r, limit)
        s2 = complex(2.0 * row[X + k], 2.0 * row[Y + k])
        w_re, w_im = 1.0 - a * row[X + k], a * row[Y + k]
        v = 1.0 / (w_re * w_re + w_im * w_im)
        g0 = s2 * complex(w_re * v, w_im * v)
        w_re, w_im = 1.0 - b * row[X + k], b * row[Y + k]
        v = 1.0 / (w_re * w_re + w_im * w_im)
        g1 = s2 * complex(w_re * v, w_im * v)
        w_re, w_im = 1.0 - c * row[X + k], c * row[Y + k]
        v = 1.0 / (w_re * w_re + w_im * w_im)
        g2 = s2 * complex(w_re * v, w_im * v)
        h0, h1, h2 = g0 * m0, g1 * m1, g2 * m2
        e0, e1, e2 = h0 * h0, h1 * h1, h2 * h2
        three = h0 * (t0 * (e0 + 3.0 * g0) + t1 * (e1 + g1) + t2 * (e2 + g2))
        three += h1 * (t3 * (e1 + 3.0 * g1) + t4 * (e0 + g0) + t5 * (e2 + g2))
        three += h2 * (t6 * (e2 + 3.0 * g2) + t7 * (e0 + g0) + t8 * (e1 + g1)) + t9 * (h0 * h1 * h2)
        v0, v1, v2 = e0 + 3.0 * g0, e1 + 3.0 * g1, e2 + 3.0 * g2
        v3, v4, v5 = 2.0 * h1 * h2, 2.0 * h0 * h2, 2.0 * h0 * h1
        four = v0 * (f00 * v0 + 2.0 * (f01 * v1 + f02 * v2 + f03 * v3 + f04 * v4 + f05 * v5))
        four += v1 * (f11 * v1 + 2.0 * (f12 * v2 + f13 * v3 + f14 * v4 + f15 * v5))
        four += v2 * (f22 * v2 + 2.0 * (f23 * v3 + f24 * v4 + f25 * v5))
        four += v3 * (f33 * v3 + 2.0 * (f34 * v4 + f35 * v5)) + v4 * (f44 * v4 + 2.0 * f45 * v5) + f55 * v5 * v5
        less = g0 * (f00 * g0 + 2.0 * (f01 * g1 + f02 * g2)) + g1 * (f11 * g1 + 2.0 * f12 * g2) + f22 * g2 * g2
        d_re = three.real * (1 / 6) + (four.real - 6.0 * less.real) * (1 / 24)
        d_im = three.imag * (1 / 6) + (four.imag - 6.0 * less.imag) * (1 / 24)
        size = np.sqrt(d_re * d_re + d_im * d_im)
        row[WEIGHT_RE + k] += share * (m_re + m_re * d_re - m_im * d_im)
        row[WEIGHT_IM + k] += share * (m_im + m_re * d_im + m_im * d_re)
        row[SIZE + k] += share * (abs(m_re) + abs(m_im))
        row[SPARE + k] += share * np.sqrt(m_re * m_re + m_im * m_im) * size * (base + size) * over


@jit
def even(j, means, cubic):
    """Tell whether a part has neither mean nor third cumulants."""
    size = abs(means[j, 0]) + abs(means[j, 1]) + abs(means[j, 2])
    for i in range(10):
        size += abs(cubic[j, i])
    return size == 0.0


@lanes
def _weigh_even(j, weights, spreads, quartic, limit, left, row):
    """Do what `_weigh_bent` does for a part without mean and third cumulants: d = k : G G / 8."""
    share, a, b, c = weights[j], 2.0 * spreads[j, 0], 2.0 * spreads[j, 1], 2.0 * spreads[j, 2]
    f00, f11, f22 = 0.5 * quartic[j, 0, 0], 0.5 * quartic[j, 1, 1], 0.5 * quartic[j, 2, 2]
    f01, f02, f12 = quartic[j, 0, 1], quartic[j, 0, 2], quartic[j, 1, 2]
    base, over = left
    for k in range(CHUNK):
        x, y = row[X + k], row[Y + k]
        m_re, m_im = _value(x, y, a, b, c, 0.0, 0.0, 0.0, limit)
        # s over 1 - 2 s spread along each axis
        size2 = x * x + y * y
        w0, w1, w2 = 1.0 - a * x, 1.0 - b * x, 1.0 - c * x
        v0, v1, v2 = 1.0 / (w0 * w0 + a * a * y * y), 1.0 / (w1 * w1 + b * b * y * y), 1.0 / (w2 * w2 + c * c * y * y)
        x0, x1, x2 = (x - a * size2) * v0, (x - b * size2) * v1, (x - c * size2) * v2
        y0, y1, y2 = y * v0, y * v1, y * v2
        p_re, p_im = f00 * x0 + f01 * x1 + f02 * x2, f00 * y0 + f01 * y1 + f02 * y2
        q_re, q_im = f11 * x1 + f12 * x2, f11 * y1 + f12 * y2
        d_re = p_re * x0 - p_im * y0 + q_re * x1 - q_im * y1 + f22 * (x2 * x2 - y2 * y2)
        d_im = p_re * y0 + p_im * x0 + q_re * y1 + q_im * x1 + f22 * (2.0 * x2 * y2)
        size = np.sqrt(d_re * d_re + d_im * d_im)
        row[WEIGHT_RE + k] += share * (m_re + m_re * d_re - m_im * d_im)
        row[WEIGHT_IM + k] += share * (m_im + m_re * d_im + m_im * d_re)
        row[SIZE + k] += share * (abs(m_re) + abs(m_im))
        row[SPARE + k] += share * np.sqrt(m_re * m_re + m_im * m_im) * size * (base + size) * over


@lanes
def _close(row):
    """Make weights of an integral out of M exp(-s q) at the nodes."""
    for k in range(CHUNK):
        lean, scale = -row[LEAN + k], row[APART + k] * (1.0 / math.pi)
        w_re, w_im = scale * (row[WEIGHT_RE + k] - lean * row[WEIGHT_IM + k]), scale * (row[WEIGHT_IM + k] + lean * row[WEIGHT_RE + k])
        over = 1.0 / (row[X + k] * row[X + k] + row[Y + k] * row[Y + k])
        row[WEIGHT_RE + k], row[WEIGHT_IM + k] = w_re, w_im
        row[POLE_RE + k], row[POLE_IM + k] = (w_re * row[X + k] + w_im * row[Y + k]) * over, (w_im * row[X + k] - w_re * row[Y + k]) * over
        row[SPARE + k] *= scale * np.sqrt((1.0 + lean * lean) * over)


@jit
def read(count, by, table):
    """Give the integral at q + by (the share above, or less the share below), the density, and its first three derivatives.

    And the largest share that what is left out beyond Edgeworth's terms can move across q + by.
    """
    return _read_here(count, table) if by == 0.0 else _read_beside(count, by, table)


@inlined
def _rates(w_re, w_im, x, y):
    """Give what a node adds to the density and its first three derivatives."""
    one_re, one_im = w_re * x - w_im * y, w_re * y + w_im * x
    two_re, two_im = one_re * x - one_im * y, one_re * y + one_im * x
    return w_re, -one_re, two_re, two_im * y - two_re * x


@lanes
def _read_here(count, table):
    share = density = first = second = third = left = 0.0
    for n in range(count):
        row = table[n]
        for k in range(CHUNK):
            d0, d1, d2, d3 = _rates(row[WEIGHT_RE + k], row[WEIGHT_IM + k], row[X + k], row[Y + k])
            share, density, first, second, third = share + row[POLE_RE + k], density + d0, first + d1, second + d2, third + d3
            left += row[SPARE + k]
    return share, density, first, second, third, left


@lanes
def _read_beside(count, by, table):
    share = density = first = second = third = left = 0.0
    for n in range(count):
        row = table[n]
        for k in range(CHUNK):
            x, y = row[X + k], row[Y + k]
            size = power(-x * by)
            cosine, sine = wheel(-y * by)
            cosine, sine = size * cosine, size * sine
            share += row[POLE_RE + k] * cosine - row[POLE_IM + k] * sine
            w_re, w_im = row[WEIGHT_RE + k], row[WEIGHT_IM + k]
            d0, d1, d2, d3 = _rates(w_re * cosine - w_im * sine, w_re * sine + w_im * cosine, x, y)
            density, first, second, third, left = density + d0, first + d1, second + d2, third + d3, left + row[SPARE + k] * size
    return share, density, first, second, third, left
