"""Which cumulants do the draws of an arm's terms have? Second, third and fourth, joint where terms share what is drawn.

Terms that draw from different streams are independent. Within a group that shares streams (the two parts of a wave, the amount of a play and its
side) every mean of a product is a product of means over the streams, each by quadrature.
"""

from __future__ import annotations

import functools
from collections import Counter
from dataclasses import dataclass
from itertools import combinations_with_replacement, product
from math import factorial, prod
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.laws.distributions import product_mean

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Mapping, Sequence

    from lostmotion.error_model.pose_matrix import TermInfo
    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats

    # Of every term: from which streams it draws, and by which laws.
    Drawn = Mapping[int, Sequence[tuple[Hashable, Law]]] | Sequence[Sequence[tuple[Hashable, Law]]]

# What quadrature leaves of zero.
_NOTHING: Final = 1e-8
# Of a cell of a smooth law: exact to rounding.
_NODES: Final = 20


@dataclass(frozen=True)
class Cumulants:
    """Joint cumulants of the draws that are not zero: terms (n, 2), (n, 3), (n, 4) by number, rising, and their worth times how often they occur."""

    pairs: np.ndarray
    pair_values: np.ndarray
    threes: np.ndarray
    three_values: np.ndarray
    fours: np.ndarray
    four_values: np.ndarray

    def without(self, terms: Sequence[int]) -> Cumulants:
        """Leave out whatever these terms stand in."""
        out = []
        for some, values in ((self.pairs, self.pair_values), (self.threes, self.three_values), (self.fours, self.four_values)):
            kept = ~np.isin(some, list(terms)).any(axis=1)
            out += [some[kept], values[kept]]
        return Cumulants(*out)


def cumulants(infos: Sequence[TermInfo], columns: np.ndarray) -> Cumulants:
    """Which second, third and fourth cumulants do the draws of these terms have?

    Every law here is symmetric, so single terms have no third cumulant; an amount that enters by itself has one with the play that it scales.
    """
    found = []
    for group in groups_of(infos, columns):
        numbers: dict[tuple[str, str], int] = {}
        draws = tuple(tuple((numbers.setdefault(stream, len(numbers)), law) for stream, law in _streams_of(infos[k])) for k in group)
        found.append({tuple(group[n] for n in terms): value for terms, value in _of_draws(draws).items()})
    return _collected(found)


@functools.lru_cache(maxsize=4096)
def _of_draws(draws: tuple[tuple[tuple[Hashable, Law], ...], ...]) -> dict[tuple[int, ...], float]:
    """Give what `_of_group` does for terms that draw from these streams, by number: much the same for every joint, and for every block of poses."""
    return _of_group(range(len(draws)), functools.partial(_mean, draws))


def cumulants_within(
    infos: Sequence[TermInfo], group: Sequence[int], cell: Mapping[tuple[str, str], tuple[float, float]]
) -> tuple[Floats, Cumulants]:
    """Which mean draws (term,) and cumulants have the terms of one group while some streams (level, name) have uniforms between two bounds only?

    No bound may lie inside a law's smooth piece that ends there by a jump: cut a two-sided draw at 1/2.
    """
    draws = {k: _streams_of(infos[k]) for k in group}
    found = _of_group(group, functools.partial(_mean, draws, cell=cell))
    return np.array([found[(k,)] for k in group]), _collected([found])


def _of_group(group: Sequence[int], mean: Callable[[tuple[int, ...]], float]) -> dict[tuple[int, ...], float]:
    """Give means (of one term) and joint cumulants of terms that may depend on each other."""
    raw = functools.cache(mean)
    first = {k: raw((k,)) for k in group}

    def central(terms: tuple[int, ...]) -> float:
        # Terms without a mean, which are most, need no other moment.
        out = 0.0
        for kept in product(*((True, False) if first[k] != 0.0 else (True,) for k in terms)):
            inside = tuple(k for k, stays in zip(terms, kept, strict=True) if stays)
            out += prod(-first[k] for k, stays in zip(terms, kept, strict=True) if not stays) * (raw(inside) if inside else 1.0)
        return out

    found: dict[tuple[int, ...], float] = {(k,): value for k, value in first.items()}
    for order in (2, 3):
        found |= {terms: central(terms) for terms in combinations_with_replacement(group, order)}
    for i, j, k, m in combinations_with_replacement(group, 4):
        pairs = found[i, j] * found[k, m] + found[i, k] * found[j, m] + found[i, m] * found[j, k]
        found[i, j, k, m] = central((i, j, k, m)) - pairs
    return found


def _collected(groups: Sequence[dict[tuple[int, ...], float]]) -> Cumulants:
    out = []
    for order in (2, 3, 4):
        kept = {terms: value for found in groups for terms, value in found.items() if len(terms) == order and abs(value) > _NOTHING}
        out += [np.array(list(kept), np.int64).reshape(-1, order), np.array([value * _arrangements(terms) for terms, value in kept.items()], float)]
    return Cumulants(*out)


def groups_of(infos: Sequence[TermInfo], columns: np.ndarray) -> list[list[int]]:
    """Put terms together that share a stream, directly or by way of others."""
    groups: list[tuple[set[tuple[str, str]], list[int]]] = []
    for k in (int(column) for column in columns):
        streams, members = {(level, name) for level, name, _ in draws_of(infos[k])}, [k]
        apart = []
        for other in groups:
            if other[0] & streams:
                streams, members = streams | other[0], other[1] + members
            else:
                apart.append(other)
        groups = [*apart, (streams, members)]
    return [sorted(members) for _, members in groups]


def draws_of(info: TermInfo) -> list[tuple[str, str, Law]]:
    """Give the streams that a term draws from: level, name and law."""
    both = (("robot", info.robot), ("visit", info.visit))
    return [(level, stream.name, stream.law) for level, stream in both if stream is not None]


def _streams_of(info: TermInfo) -> tuple[tuple[tuple[str, str], Law], ...]:
    return tuple(((level, name), law) for level, name, law in draws_of(info))


def _mean(draws: Drawn, terms: tuple[int, ...], cell: Mapping[Any, tuple[float, float]] | None = None) -> float:
    """Give the mean of the product of these terms' draws: stream by stream, since streams are independent. Means of nothing but rounding are zero."""
    laws: dict[Hashable, list[Law]] = {}
    for k in terms:
        for stream, law in draws[k]:
            laws.setdefault(stream, []).append(law)
    out = 1.0
    for stream, members in laws.items():
        several = tuple(sorted(members, key=repr))
        out *= product_mean(several) if cell is None or stream not in cell else _mean_within(several, *cell[stream])
    return out if abs(out) > _NOTHING else 0.0


@functools.lru_cache(maxsize=4096)
def _mean_within(laws: tuple[Law, ...], low: float, high: float) -> float:
    """Give the mean of the product of these laws' draws while their uniform lies between two bounds, by Gauss and Legendre's rule."""
    nodes, weights = _gauss()
    u = low + (high - low) * (nodes + 1) / 2
    return float(np.prod([law.quantile(u) for law in laws], axis=0) @ weights / 2)


@functools.cache
def _gauss() -> tuple[Floats, Floats]:
    return np.polynomial.legendre.leggauss(_NODES)


def _arrangements(terms: tuple[int, ...]) -> int:
    """In how many orders can these be written?"""
    return factorial(len(terms)) // prod(factorial(count) for count in Counter(terms).values())
