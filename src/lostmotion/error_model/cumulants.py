"""Joint cumulants of the draws of an arm's terms: second, third and fourth.

Terms that draw from different streams are independent. Within a group that shares streams (the two components of a harmonic, the amount of a play and
its side) every mean of a product is a product of means over the streams, each by quadrature.
"""

from __future__ import annotations

import functools
from collections import Counter
from dataclasses import dataclass
from itertools import combinations_with_replacement, product
from math import factorial, prod
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.distributions import product_mean

if TYPE_CHECKING:
    from collections.abc import Hashable, Mapping, Sequence

    from numpy.typing import NDArray

    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats

    # The streams that a term multiplies draws of, each with its distribution.
    Draws = Sequence[tuple[Hashable, Law]]

# What quadrature leaves of zero.
_NOTHING: Final = 1e-8


@dataclass(frozen=True)
class Cumulants:
    """The joint cumulants that are not zero: terms (n, 3), (n, 4) by number, rising, and their values times the number of their orders."""

    threes: NDArray[np.int64]
    three_values: Floats
    fours: NDArray[np.int64]
    four_values: Floats


def cumulants(terms: Sequence[Draws]) -> Cumulants:
    """Return the third and fourth joint cumulants of these terms' draws.

    Single terms whose distributions are symmetric have no third cumulant; an amount that enters by itself has one with the play that it scales.
    """
    found: dict[tuple[int, ...], float] = {}
    for group in groups_of(terms):
        numbers: dict[Hashable, int] = {}
        draws = tuple(tuple((numbers.setdefault(stream, len(numbers)), law) for stream, law in terms[k]) for k in group)
        found |= {tuple(group[n] for n in members): value for members, value in _of_group(draws).items()}
    out: list[np.ndarray] = []
    for order in (3, 4):
        kept = {members: value for members, value in found.items() if len(members) == order and abs(value) > _NOTHING}
        out.append(np.array(list(kept), np.int64).reshape(-1, order))
        out.append(np.array([value * _orders(members) for members, value in kept.items()], float))
    return Cumulants(*out)


@functools.lru_cache(maxsize=4096)
def _of_group(draws: tuple[tuple[tuple[int, Law], ...], ...]) -> Mapping[tuple[int, ...], float]:
    """Return the joint cumulants of terms that may depend on each other. Cached: joints with the same kinds of parts have the same ones."""
    first = [_mean(draws, (k,)) for k in range(len(draws))]

    def central(terms: tuple[int, ...]) -> float:
        # Terms without a mean, which are most, need no other moment.
        out = 0.0
        for kept in product(*((True, False) if first[k] != 0.0 else (True,) for k in terms)):
            inside = tuple(k for k, stays in zip(terms, kept, strict=True) if stays)
            out += prod(-first[k] for k, stays in zip(terms, kept, strict=True) if not stays) * (_mean(draws, inside) if inside else 1.0)
        return out

    found = {terms: central(terms) for order in (2, 3) for terms in combinations_with_replacement(range(len(draws)), order)}
    for i, j, k, m in combinations_with_replacement(range(len(draws)), 4):
        pairs = found[i, j] * found[k, m] + found[i, k] * found[j, m] + found[i, m] * found[j, k]
        found[i, j, k, m] = central((i, j, k, m)) - pairs
    return found


def groups_of(terms: Sequence[Draws]) -> list[list[int]]:
    """Return the numbers of the terms, grouped so that terms share streams, directly or by way of others, within a group alone."""
    groups: list[tuple[set[Hashable], list[int]]] = []
    for k, draws in enumerate(terms):
        streams, members = {stream for stream, _ in draws}, [k]
        apart = []
        for other in groups:
            if other[0] & streams:
                streams, members = streams | other[0], other[1] + members
            else:
                apart.append(other)
        groups = [*apart, (streams, members)]
    return [sorted(members) for _, members in groups]


def _mean(draws: tuple[tuple[tuple[int, Law], ...], ...], terms: tuple[int, ...]) -> float:
    """Return the mean of the product of these terms' draws, a product over independent streams. Means of nothing but rounding are zero."""
    laws: dict[int, list[Law]] = {}
    for k in terms:
        for stream, law in draws[k]:
            laws.setdefault(stream, []).append(law)
    out = prod(product_mean(tuple(sorted(members, key=repr))) for members in laws.values())
    return out if abs(out) > _NOTHING else 0.0


def _orders(terms: tuple[int, ...]) -> int:
    """Return in how many orders these numbers can be written."""
    return factorial(len(terms)) // prod(factorial(count) for count in Counter(terms).values())
