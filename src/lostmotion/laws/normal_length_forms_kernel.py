"""The third and fourth cumulants of a vector as forms in h, summed over terms and turned to other axes. Compiled once by Numba and cached."""

from __future__ import annotations

import math
from itertools import product
from typing import Final

import numpy as np

from lostmotion.laws.normal_length_contour_kernel import jit

# The third and fourth cumulants of a vector, by how often x, y and z stand in them: coefficients of k_ijk h_i h_j h_k and k_ijkl h_i h_j h_k h_l.
THIRDS: Final = ((3, 0, 0), (1, 2, 0), (1, 0, 2), (0, 3, 0), (2, 1, 0), (0, 1, 2), (0, 0, 3), (2, 0, 1), (0, 2, 1), (1, 1, 1))
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


def _third_table() -> tuple[np.ndarray, np.ndarray]:
    """Do so for the cubic form's tensor (3, 3, 3)."""
    at, shared = np.empty((3, 3, 3), np.int64), np.empty((3, 3, 3))
    for entry in product(range(3), repeat=3):
        powers = tuple(entry.count(axis) for axis in range(3))
        at[entry] = THIRDS.index(powers)
        shared[entry] = math.factorial(3) / math.prod(math.factorial(n) for n in powers)
    return at, shared


_AT, _SHARED = _fourth_table()
_PART = 1.0 / _SHARED
_AT_THIRD, _SHARED_THIRD = _third_table()


@jit
def turn_forms(third, fourth, turn, size, work, cubic, quartic):
    """Give the forms of a vector over `size` along other axes: the cubic one (10,), and the quartic one as a tensor by pairs of pairs (6, 6).

    work (2, 6, 6) is filled on the way.
    """
    # What each pair of old axes (first) is of each pair of new ones, and what is left to turn of the tensor's second pair.
    along, half = work[0], work[1]
    for a in range(3):
        i, j = (a + 1) % 3, (a + 2) % 3
        for b in range(3):
            k, m = (b + 1) % 3, (b + 2) % 3
            along[b, a], along[b, a + 3] = turn[b, a] * turn[b, a], turn[b, i] * turn[b, j]
            along[b + 3, a], along[b + 3, a + 3] = 2.0 * turn[k, a] * turn[m, a], turn[k, i] * turn[m, j] + turn[m, i] * turn[k, j]
    over = 1.0 / (size * size * size * size)
    for c in range(6):
        for a in range(6):
            half[c, a] = 0.0
        for b in range(6):
            entry = over * fourth[_AT[c, b]] * _PART[c, b]
            for a in range(6):
                half[c, a] += entry * along[b, a]
    for a in range(6):
        for b in range(6):
            quartic[a, b] = 0.0
        for c in range(6):
            for b in range(6):
                quartic[a, b] += along[c, a] * half[c, b]
    any_third = False
    for c in range(10):
        cubic[c] = 0.0
        any_third |= third[c] != 0.0
    if any_third:
        for a, b, c in np.ndindex((3, 3, 3)):
            entry = 0.0
            for i, j, k in np.ndindex((3, 3, 3)):
                entry += third[_AT_THIRD[i, j, k]] / _SHARED_THIRD[i, j, k] * turn[i, a] * turn[j, b] * turn[k, c]
            cubic[_AT_THIRD[a, b, c]] += entry / (size * size * size)


@jit
def add_up(shift, pairs, pair_values, threes, three_values, fours, four_values, covariance, third, fourth):
    """Sum terms up to covariances (6, pose) over pairs of axes, cubic forms of third and quartic forms of fourth cumulants (10 and 15, pose).

    These begin as zeros. shift (3, term, pose); pairs (n, 2), threes (n, 3) and fours (n, 4) the terms, with what their draws' cumulants are worth
    (multiplicities included).
    """
    poses = shift.shape[2]
    first, second = np.empty((6, poses)), np.empty((6, poses))
    for n in range(len(pairs)):
        _multiply(shift, pairs[n, 0], pairs[n, 1], pair_values[n], first)
        for c in range(6):
            half = 1.0 if c < 3 else 0.5  # noqa: PLR2004 - a mixed product counts twice in the form
            for p in range(poses):
                covariance[c, p] += half * first[c, p]
    for n in range(len(threes)):
        _multiply(shift, threes[n, 0], threes[n, 1], three_values[n], first)
        for a in range(6):
            i, j = _PAIRS[a]
            for k in range(3):
                c = _AT_THIRD[i, j, k]
                for p in range(poses):
                    third[c, p] += first[a, p] * shift[k, threes[n, 2], p]
    for n in range(len(fours)):
        _multiply(shift, fours[n, 0], fours[n, 1], 1.0, first)
        if fours[n, 0] == fours[n, 2] and fours[n, 1] == fours[n, 3]:
            for a in range(6):
                for b in range(a, 6):
                    c, value = _AT[a, b], four_values[n] if a == b else 2.0 * four_values[n]
                    for p in range(poses):
                        fourth[c, p] += value * first[a, p] * first[b, p]
        else:
            _multiply(shift, fours[n, 2], fours[n, 3], four_values[n], second)
            for a in range(6):
                for b in range(6):
                    c = _AT[a, b]
                    for p in range(poses):
                        fourth[c, p] += first[a, p] * second[b, p]


@jit
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
