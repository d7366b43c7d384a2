"""Which cumulants do the draws of an arm's terms have? Second, third and fourth, joint where terms share what is drawn.

Terms that draw from different streams are independent. Within a group that shares streams (the two parts of a wave, the amount of a play and its
side) every mean of a product is a product of means over the streams, each by quadrature.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import combinations_with_replacement
from math import factorial, prod
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.chance import product_mean

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.chance import Law
    from lostmotion.studies.screws import TermInfo

# What quadrature leaves of zero.
_NOTHING: Final = 1e-8


@dataclass(frozen=True)
class Cumulants:
    """Joint cumulants of the draws that are not zero: terms (n, 2), (n, 3), (n, 4) by number, rising, and their worth times how often they occur."""

    pairs: np.ndarray
    pair_values: np.ndarray
    threes: np.ndarray
    three_values: np.ndarray
    fours: np.ndarray
    four_values: np.ndarray


def cumulants(infos: Sequence[TermInfo], columns: np.ndarray) -> Cumulants:
    """Which second, third and fourth cumulants do the draws of these terms have?

    Every law here is symmetric, so single terms have no third cumulant; an amount that enters by itself has one with the play that it scales.
    """
    found: dict[int, tuple[list[tuple[int, ...]], list[float]]] = {order: ([], []) for order in (2, 3, 4)}
    for group in _groups(infos, columns):
        second = {two: _mean(infos, two) for two in combinations_with_replacement(group, 2)}
        for order, (terms, values) in found.items():
            for some in combinations_with_replacement(group, order):
                value = second[some] if order == 2 else _mean(infos, some)  # noqa: PLR2004 - all have mean zero: moments are cumulants below four
                if order == 4:  # noqa: PLR2004
                    i, j, k, m = some
                    value -= second[i, j] * second[k, m] + second[i, k] * second[j, m] + second[i, m] * second[j, k]
                if abs(value) > _NOTHING:
                    terms.append(some)
                    values.append(value * _arrangements(some))
    (pairs, two), (threes, three), (fours, four) = found.values()
    return Cumulants(*_arrays(pairs, two, 2), *_arrays(threes, three, 3), *_arrays(fours, four, 4))


def _arrays(terms: list[tuple[int, ...]], values: list[float], order: int) -> tuple[np.ndarray, np.ndarray]:
    return np.array(terms, np.int64).reshape(-1, order), np.array(values, float)


def _groups(infos: Sequence[TermInfo], columns: np.ndarray) -> list[list[int]]:
    """Put terms together that share a stream, directly or by way of others."""
    groups: list[tuple[set[tuple[str, str]], list[int]]] = []
    for k in (int(column) for column in columns):
        streams, members = {(level, name) for level, name, _ in _draws(infos[k])}, [k]
        apart = []
        for other in groups:
            if other[0] & streams:
                streams, members = streams | other[0], other[1] + members
            else:
                apart.append(other)
        groups = [*apart, (streams, members)]
    return [sorted(members) for _, members in groups]


def _draws(info: TermInfo) -> list[tuple[str, str, Law]]:
    both = (("robot", info.robot), ("visit", info.visit))
    return [(level, stream.name, stream.law) for level, stream in both if stream is not None]


def _mean(infos: Sequence[TermInfo], terms: tuple[int, ...]) -> float:
    """Give the mean of the product of these terms' draws: stream by stream, since streams are independent."""
    laws: dict[tuple[str, str], list[Law]] = {}
    for k in terms:
        for level, name, law in _draws(infos[k]):
            laws.setdefault((level, name), []).append(law)
    return prod(product_mean(tuple(sorted(members, key=repr))) for members in laws.values())


def _arrangements(terms: tuple[int, ...]) -> int:
    """In how many orders can these be written?"""
    return factorial(len(terms)) // prod(factorial(count) for count in Counter(terms).values())
