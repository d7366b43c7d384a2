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
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.error_model.closing import third_and_fourth_moment
from lostmotion.laws.distributions import COMPARED, product_mean

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
class OfOrder:
    """The joint cumulants of one order that are not zero: terms (n, order) by number, rising, and values times the number of their orders.

    Where three or four of the terms depend on whether one play is closed, the value at a pose is `values` + `with_moment` x the third or fourth
    moment of that draw (`closing.third_and_fourth_moment`): moment (n,) is 0 or 1, closing (n,) the number of the play.
    """

    terms: NDArray[np.int64]
    values: Floats
    with_moment: Floats
    closing: NDArray[np.int64]
    moment: NDArray[np.int64]

    def at(self, closed: Floats | None) -> Floats:
        """Return the values (n,), or those at each pose (pose, 1, n) for the shares of robots whose plays are closed (pose, play)."""
        if closed is None or not self.with_moment.any():
            return self.values
        return np.asarray(self.values + self.with_moment * third_and_fourth_moment(closed)[self.moment, :, self.closing].T)[:, None]


@dataclass(frozen=True)
class Cumulants:
    """The third and fourth joint cumulants; `closings` the streams that decide whether plays are closed, in the order of their numbers."""

    third: OfOrder
    fourth: OfOrder
    closings: tuple[Hashable, ...]


class _Value(NamedTuple):
    """A cumulant: a number, and another that is multiplied by the third or fourth moment of a play's draw, by number of its stream."""

    plain: float
    with_moment: float = 0.0
    stream: int = -1
    moment: int = 0


def cumulants(terms: Sequence[Draws]) -> Cumulants:
    """Return the third and fourth joint cumulants of these terms' draws.

    Single terms whose distributions are symmetric have no third cumulant; an amount that enters by itself has one with the play that it scales.
    """
    found: dict[tuple[int, ...], _Value] = {}
    closings = {stream: k for k, stream in enumerate(dict.fromkeys(stream for term in terms for stream, law in term if law == COMPARED))}
    for group in groups_of(terms):
        numbers: dict[Hashable, int] = {}
        draws = tuple(tuple((numbers.setdefault(stream, len(numbers)), law) for stream, law in terms[k]) for k in group)
        named = {number: closings.get(stream, -1) for stream, number in numbers.items()}
        for members, value in _of_group(draws).items():
            found[tuple(group[n] for n in members)] = value._replace(stream=named.get(value.stream, -1))
    return Cumulants(_of_order(found, 3), _of_order(found, 4), tuple(closings))


def _of_order(found: Mapping[tuple[int, ...], _Value], order: int) -> OfOrder:
    chosen = {terms: value for terms, value in found.items() if len(terms) == order and max(abs(value.plain), abs(value.with_moment)) > _NOTHING}
    orders = np.array([_orders(members) for members in chosen], float)
    plain, with_moment, stream, moment = (np.array(column) for column in zip(*chosen.values(), strict=True)) if chosen else np.zeros((4, 0))
    return OfOrder(
        np.array(list(chosen), np.int64).reshape(-1, order), plain * orders, with_moment * orders, stream.astype(np.int64), moment.astype(np.int64)
    )


@functools.lru_cache(maxsize=4096)
def _of_group(draws: tuple[tuple[tuple[int, Law], ...], ...]) -> Mapping[tuple[int, ...], _Value]:
    """Return the joint cumulants of terms that may depend on each other. Cached: joints with the same kinds of parts have the same ones."""
    first = [_mean(draws, (k,)) for k in range(len(draws))]

    def central(terms: tuple[int, ...]) -> float:
        # Terms without a mean, which are most, need no other moment.
        out = 0.0
        for kept in product(*((True, False) if first[k] != 0.0 else (True,) for k in terms)):
            inside = tuple(k for k, stays in zip(terms, kept, strict=True) if stays)
            out += prod(-first[k] for k, stays in zip(terms, kept, strict=True) if not stays) * (_mean(draws, inside) if inside else 1.0)
        return out

    pairs = {terms: central(terms) for terms in combinations_with_replacement(range(len(draws)), 2)}
    found: dict[tuple[int, ...], _Value] = {}
    for order in (3, 4):
        for terms in combinations_with_replacement(range(len(draws)), order):
            of_pairs = 0.0
            if order == 4:  # noqa: PLR2004 - the order itself
                i, j, k, m = terms
                of_pairs = pairs[i, j] * pairs[k, m] + pairs[i, k] * pairs[j, m] + pairs[i, m] * pairs[j, k]
            stream, power = _closing(draws, terms)
            value = central(terms)
            found[terms] = _Value(value - of_pairs) if stream < 0 else _Value(-of_pairs, value, stream, power - 3)
    return found


def _closing(draws: tuple[tuple[tuple[int, Law], ...], ...], terms: tuple[int, ...]) -> tuple[int, int]:
    """Return the play on whose draw three or four of these terms depend, and how many; -1 where there is none."""
    counts = Counter(stream for k in terms for stream, law in draws[k] if law == COMPARED)
    stream, count = max(counts.items(), key=lambda each: each[1], default=(-1, 0))
    return (stream, count) if count > 2 else (-1, 0)  # noqa: PLR2004 - mean 0, mean square 1


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
    """Return the mean of the product of these terms' draws, a product over independent streams. Means of nothing but rounding are zero.

    Whether a play is closed is a draw of mean 0 and mean square 1; its third and fourth moment, which differ from pose to pose, are omitted.
    """
    laws: dict[int, list[Law]] = {}
    for k in terms:
        for stream, law in draws[k]:
            laws.setdefault(stream, []).append(law)
    out = prod(_product_mean(tuple(sorted(members, key=repr))) for members in laws.values())
    return out if abs(out) > _NOTHING else 0.0


def _product_mean(laws: tuple[Law, ...]) -> float:
    """Return the mean of a product of draws; of whether a play is closed, without its third or fourth moment."""
    return float(len(laws) > 1) if laws[0] == COMPARED else product_mean(laws)


def _orders(terms: tuple[int, ...]) -> int:
    """Return in how many orders these numbers can be written."""
    return factorial(len(terms)) // prod(factorial(count) for count in Counter(terms).values())
