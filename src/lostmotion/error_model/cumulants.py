"""Joint cumulants of the draws of an arm's terms: second, third and fourth.

Terms that draw from different streams are independent. Terms of one group share streams, as the two
phases of a harmonic do, or the size of a play and its side. Within a group the mean of a product is
the product of the means over the streams, each by quadrature.
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

# A smaller cumulant is the rounding error of quadrature, and counts as zero.
_ZERO: Final = 1e-8


@dataclass(frozen=True)
class CumulantsOfOrder:
    """The n joint cumulants of one order (3 or 4) that are not zero; dimensionless, since draws
    are.

    Where three or four of the terms depend on whether one play is closed, the value at a pose is
    `values` + `with_moment` x the third or fourth moment of that draw
    (`closing.third_and_fourth_moment`).

    terms        (n, order) numbers of the terms, in rising order, repeated where a term occurs more
                 than once
    values       (n,) cumulant times the number of different orders in which its terms can be
                 written
    with_moment  (n,) likewise, the part that is multiplied by the moment
    closing      (n,) number of the play
    moment       (n,) 0 for the third moment, 1 for the fourth
    """

    terms: NDArray[np.int64]
    values: Floats
    with_moment: Floats
    closing: NDArray[np.int64]
    moment: NDArray[np.int64]

    def at(self, closed: Floats | None) -> Floats:
        """Return the values (n,), or those at each pose (pose, 1, n); closed (pose, play) is the
        share of robots in which each play is closed.
        """
        if closed is None or not self.with_moment.any():
            return self.values
        return np.asarray(
            self.values
            + self.with_moment * third_and_fourth_moment(closed)[self.moment, :, self.closing].T
        )[:, None]


@dataclass(frozen=True)
class Cumulants:
    """The third and fourth joint cumulants. `closings` are the streams that decide whether plays
    are closed, by number of the play.
    """

    third: CumulantsOfOrder
    fourth: CumulantsOfOrder
    closings: tuple[Hashable, ...]


class _Value(NamedTuple):
    """A cumulant: `plain` + `with_moment` x the third (moment 0) or fourth (moment 1) moment of a
    play's draw; `stream` is the play's number.
    """

    plain: float
    with_moment: float = 0.0
    stream: int = -1
    moment: int = 0


def cumulants(terms: Sequence[Draws]) -> Cumulants:
    """Return the third and fourth joint cumulants of the draws of these terms.

    Terms with symmetric distributions have no third cumulant by themselves. The scattered size of a
    play has one together with the play's side.
    """
    found: dict[tuple[int, ...], _Value] = {}
    closings = {
        stream: k
        for k, stream in enumerate(
            dict.fromkeys(stream for term in terms for stream, law in term if law == COMPARED)
        )
    }
    for group in groups_of(terms):
        numbers: dict[Hashable, int] = {}
        draws = tuple(
            tuple((numbers.setdefault(stream, len(numbers)), law) for stream, law in terms[k])
            for k in group
        )
        named = {number: closings.get(stream, -1) for stream, number in numbers.items()}
        for members, value in _of_group(draws).items():
            found[tuple(group[n] for n in members)] = value._replace(
                stream=named.get(value.stream, -1)
            )
    return Cumulants(_of_order(found, 3), _of_order(found, 4), tuple(closings))


def _of_order(values: Mapping[tuple[int, ...], _Value], order: int) -> CumulantsOfOrder:
    chosen = {terms: value for terms, value in values.items() if len(terms) == order}
    orders = np.array([_orders(members) for members in chosen], float)
    plain, with_moment, stream, moment = (
        (np.array(column) for column in zip(*chosen.values(), strict=True))
        if chosen
        else np.zeros((4, 0))
    )
    return CumulantsOfOrder(
        np.array(list(chosen), np.int64).reshape(-1, order),
        plain * orders,
        with_moment * orders,
        stream.astype(np.int64),
        moment.astype(np.int64),
    )


@functools.lru_cache(maxsize=4096)
def _of_group(draws: tuple[tuple[tuple[int, Law], ...], ...]) -> Mapping[tuple[int, ...], _Value]:
    """Return the joint cumulants of terms that may depend on each other, without those that are
    zero.

    Cached, since joints with the same kinds of parts have the same ones.
    """
    first = [_mean(draws, (k,)) for k in range(len(draws))]

    def central(terms: tuple[int, ...]) -> float:
        # Most terms have mean zero: for them the central moment is the plain one.
        out = 0.0
        for choice in product(*((True, False) if first[k] != 0.0 else (True,) for k in terms)):
            inside = tuple(k for k, chosen in zip(terms, choice, strict=True) if chosen)
            out += prod(
                -first[k] for k, chosen in zip(terms, choice, strict=True) if not chosen
            ) * (_mean(draws, inside) if inside else 1.0)
        return out

    pairs = {terms: central(terms) for terms in combinations_with_replacement(range(len(draws)), 2)}
    found: dict[tuple[int, ...], _Value] = {}
    single, several = _streams(draws)
    for order in (3, 4):
        for terms in combinations_with_replacement(range(len(draws)), order):
            once = twice = 0
            for k in terms:
                twice |= (once & single[k]) | several[k]
                once |= single[k]
            if once & ~twice:
                continue
            of_pairs = 0.0
            if order == 4:  # noqa: PLR2004 - the order itself
                i, j, k, m = terms
                of_pairs = (
                    pairs[i, j] * pairs[k, m]
                    + pairs[i, k] * pairs[j, m]
                    + pairs[i, m] * pairs[j, k]
                )
            stream, power = _closing(draws, terms)
            moment = central(terms)
            value = (
                _Value(moment - of_pairs)
                if stream < 0
                else _Value(-of_pairs, moment, stream, power - 3)
            )
            if max(abs(value.plain), abs(value.with_moment)) > _ZERO:
                found[terms] = value
    return found


def _streams(draws: tuple[tuple[tuple[int, Law], ...], ...]) -> tuple[list[int], list[int]]:
    """Return the streams with mean zero that each term draws from once, and those that it draws
    from several times, each as the bits of a number.

    Where one of the former occurs in one term of a product only, the product has mean zero, and so
    has every product of pairs of its terms.
    """
    single, several = [], []
    for term in draws:
        counts = Counter(stream for stream, _ in term)
        centred = {stream for stream, law in term if _mean(((((stream, law),)),), (0,)) == 0.0}
        single.append(sum(1 << stream for stream in centred))
        several.append(sum(1 << stream for stream, count in counts.items() if count > 1))
    return single, several


def _closing(
    draws: tuple[tuple[tuple[int, Law], ...], ...], terms: tuple[int, ...]
) -> tuple[int, int]:
    """Return the stream of the play on which three or four of these terms depend, and how many of
    them do; (-1, 0) where there is none.
    """
    counts = Counter(stream for k in terms for stream, law in draws[k] if law == COMPARED)
    stream, count = max(counts.items(), key=lambda each: each[1], default=(-1, 0))
    return (stream, count) if count > 2 else (-1, 0)  # noqa: PLR2004 - moments one and two of the draw are known: 0 and 1


def groups_of(terms: Sequence[Draws]) -> list[list[int]]:
    """Return the numbers of the terms in groups: terms that share a stream, directly or through
    other terms, are in the same group.
    """
    groups: list[tuple[set[Hashable], list[int]]] = []
    for k, draws in enumerate(terms):
        streams, members = {stream for stream, _ in draws}, [k]
        unrelated = []
        for other in groups:
            if other[0] & streams:
                streams, members = streams | other[0], other[1] + members
            else:
                unrelated.append(other)
        groups = [*unrelated, (streams, members)]
    return [sorted(members) for _, members in groups]


def _mean(draws: tuple[tuple[tuple[int, Law], ...], ...], terms: tuple[int, ...]) -> float:
    """Return the mean of the product of these terms' draws, a product over independent streams;
    exactly zero where it is only rounding.

    Whether a play is closed is a draw of mean 0 and mean square 1. Its third and fourth moments
    differ from pose to pose; one stands for them here.
    """
    laws: dict[int, list[Law]] = {}
    for k in terms:
        for stream, law in draws[k]:
            laws.setdefault(stream, []).append(law)
    out = prod(_product_mean(tuple(sorted(members, key=repr))) for members in laws.values())
    return out if abs(out) > _ZERO else 0.0


def _product_mean(laws: tuple[Law, ...]) -> float:
    """Return the mean of a product of draws of one stream; for whether a play is closed, one
    instead of its third or fourth moment.
    """
    return float(len(laws) > 1) if laws[0] == COMPARED else product_mean(laws)


def _orders(terms: tuple[int, ...]) -> int:
    """Return the number of different orders in which these numbers can be written."""
    return factorial(len(terms)) // prod(factorial(count) for count in Counter(terms).values())
