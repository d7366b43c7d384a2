"""The draws of an arm's terms by finitely many values each: what `lattice_length` takes.

A draw of one law becomes Gauss's rule of it, which has the law's moments up to twice the number of values less one; a wave's phase as many phases
equally far apart. Terms that share what is drawn take their values together.
"""

from __future__ import annotations

from itertools import product
from math import hypot, prod
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.cumulants import draws_of, groups_of
from lostmotion.laws.distributions import Amount, Cosine, Sine, TwoSided, gauss_rule
from lostmotion.laws.lattice_length import Draws

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.pose_matrix import TermInfo
    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats

# How many values stand for a draw, and how many phases for a wave, where the length is followed so finely: enough for a draw that makes up a whole
# axis (Gauss's rule of a law within +-c serves cos x up to x = 2 (count - 6) / c). An amount that scales a wave takes fewer.
_COUNTS: Final = {8: (18, 16), 12: (22, 20), 18: (28, 26)}
_SCALED: Final = {8: (5, 12), 12: (6, 16), 18: (8, 20)}
# Values that differ by less are the same.
_SAME: Final = 1e-9


def values_of(infos: Sequence[TermInfo], columns: np.ndarray, fine: int) -> Draws | None:
    """Which values can the draws of these terms take, and how often? None where laws of one stream are no multiples of each other."""
    found = []
    for group in groups_of(infos, columns):
        laws: dict[tuple[str, str], list[Law]] = {}
        for k in group:
            for level, name, law in draws_of(infos[k]):
                laws.setdefault((level, name), []).append(law)
        alone, phases = _COUNTS[fine]
        if len(laws) > 1 and any(isinstance(law, Cosine | Sine) for members in laws.values() for law in members):
            alone, phases = _SCALED[fine]
        rules = {stream: _rule(members, alone, phases) for stream, members in laws.items()}
        if any(rule is None for rule in rules.values()):
            return None
        found.append((group, *_of_group(infos, group, {stream: rule for stream, rule in rules.items() if rule is not None})))
    most = max((len(group) for group, *_ in found), default=1)
    counts = [len(values) for _, values, *_ in found]
    values, terms = np.zeros((sum(counts), most)), np.full((sum(counts), most), -1)
    first = np.append(0, np.cumsum(counts)).astype(np.int64)
    for (group, own, *_), begin, end in zip(found, first[:-1], first[1:], strict=True):
        values[begin:end, : len(group)], terms[begin:end, : len(group)] = own, group
    even, odd = (np.concatenate([one[k] for one in found] or [np.empty(0)]) for k in (2, 3))
    return Draws(values, terms, even, odd, first, np.array([bool(one[3].any()) for one in found], bool), np.array([one[4] for one in found], float))


def _rule(laws: list[Law], count: int, phases: int) -> tuple[dict[Law, Floats], Floats] | None:
    """Give the values of each of the laws that draw from one stream, and their weights."""
    if all(isinstance(law, Cosine | Sine) for law in laws):
        u = (np.arange(phases) + 0.5) / phases
        return {law: law.quantile(u) for law in laws}, np.full(phases, 1 / phases)
    inner = {law.inner if isinstance(law, Amount) else law for law in laws}
    if len(inner) > 1 or any(isinstance(law, Cosine | Sine) for law in laws):
        return None
    base = inner.pop()
    values, weights = gauss_rule(base, 2 if isinstance(base, TwoSided) else count)
    return {law: (1 + law.scatter * values) / hypot(1, law.scatter) if isinstance(law, Amount) else values for law in laws}, weights


def _of_group(
    infos: Sequence[TermInfo], group: Sequence[int], rules: dict[tuple[str, str], tuple[dict[Law, Floats], Floats]]
) -> tuple[Floats, Floats, Floats, float]:
    """Give the group's values (value, term), even and odd weights, and its largest sixth cumulant."""
    rows, shares = [], []
    for at in product(*(range(len(weights)) for _, weights in rules.values())):
        here = dict(zip(rules, at, strict=True))
        shares.append(prod(rules[stream][1][k] for stream, k in here.items()))
        rows.append([prod(rules[level, name][0][law][here[level, name]] for level, name, law in draws_of(infos[term])) for term in group])
    values, weights = np.array(rows), np.array(shares)
    two, three, four, six = (weights @ values**power for power in (2, 3, 4, 6))
    sixth = float(np.max(np.abs(six / two**3 - 15 * four / two**2 + 30 - 10 * three**2 / two**3)))
    once = None if np.abs(three).max() > _SAME else _once(values, weights)
    if once is None:
        return values, weights, weights, sixth
    kept, doubled = once
    return values[kept], doubled, np.zeros(len(kept)), sixth


def _once(values: Floats, weights: Floats) -> tuple[list[int], Floats] | None:
    """Keep one of every two values that differ in sign alone, with the weight of both; None where one has no such partner."""
    free, kept, doubled = np.ones(len(values), bool), [], []
    for j in range(len(values)):
        if not free[j]:
            continue
        apart = np.where(free, np.abs(values + values[j]).max(axis=1) + np.abs(weights - weights[j]), np.inf)
        k = int(np.argmin(apart))
        if apart[k] > _SAME:
            return None
        free[[j, k]] = False
        kept.append(j)
        doubled.append(weights[j] if k == j else weights[j] + weights[k])
    return kept, np.array(doubled)
