"""Which draws keep an error from being nearly normal, and what is it once they are known?

A large play stands on one side or the other: given the side, the rest is nearly normal. So the largest such draws are cut into cells of their own
law, exactly: a two-sided draw into its two values, a flat or wavy one into equal shares of probability, within which little of it is left. Every
combination of cells is a part of a mixture, with bias, covariance, third and fourth cumulants of its own, all exact sums. An amount times a side is
cut at the side, and keeps the amount.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.cumulants import Cumulants, cumulants_within, draws_of, groups_of
from lostmotion.laws.distributions import Cosine, Sine, TwoSided, Uniform
from lostmotion.laws.normal_length import Mixture
from lostmotion.propagation.analytic.sums import Sums, sums, variance

if TYPE_CHECKING:
    from lostmotion.error_model.pose_matrix import Screws, TermInfo
    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats

# Cells of equal probability that a draw is cut into: what is left of a flat one has a twelfth of its width, of a wave a twelfth of the turn.
_FLAT_CELLS: Final = 12
_WAVE_CELLS: Final = 12
# A draw whose share of the departure from normal is smaller is left whole.
_WORTH: Final = 2e-3
# Nothing is cut where that takes away less than this share of it.
_MOST: Final = 0.5


@dataclass(frozen=True)
class Cut:
    """A group of terms that share streams, cut into cells.

    terms   the group's, by number; excess: the largest fourth cumulant of any of them, by size
    shares  (cell,); cells: which part of its uniforms every stream that is cut has there
    """

    terms: tuple[int, ...]
    excess: float
    shares: Floats
    cells: tuple[dict[tuple[str, str], tuple[float, float]], ...]
    _infos: tuple[TermInfo, ...]

    @functools.cached_property
    def within(self) -> tuple[tuple[Floats, Cumulants], ...]:
        """Give mean draws (term,) and the cumulants left in every cell; seldom asked for, and slow."""
        return tuple(cumulants_within(self._infos, self.terms, cell) for cell in self.cells)


def cuts(infos: tuple[TermInfo, ...], columns: np.ndarray, known: Cumulants) -> tuple[Cut, ...]:
    """Into which cells can the draws of these terms be cut? One cut for every group that shares streams and has a law to cut."""
    out = []
    excess = {four[0]: abs(value) for four, value in zip(known.fours.tolist(), known.four_values, strict=True) if len(set(four)) == 1}
    for group in groups_of(infos, columns):
        laws: dict[tuple[str, str], list[Law]] = {}
        for k in group:
            for level, name, law in draws_of(infos[k]):
                laws.setdefault((level, name), []).append(law)
        counts = {stream: _cells(members) for stream, members in laws.items()}
        if prod(counts.values()) == 1:
            continue
        cells = tuple(
            {stream: (k / count, (k + 1) / count) for k, (stream, count) in zip(at, counts.items(), strict=True) if count > 1}
            for at in product(*(range(count) for count in counts.values()))
        )
        shares = np.array([prod(high - low for low, high in cell.values()) for cell in cells])
        out.append(Cut(tuple(group), max(excess.get(k, 0.0) for k in group), shares, cells, infos))
    return tuple(out)


def _cells(laws: list[Law]) -> int:
    if any(isinstance(law, Cosine | Sine) for law in laws):
        return _WAVE_CELLS
    if any(isinstance(law, Uniform) for law in laws):
        return _FLAT_CELLS
    # Pieces of a cut normal law are further from normal than the whole.
    return 2 if any(isinstance(law, TwoSided) for law in laws) else 1


def choose(matrix: Screws, known: Cumulants, possible: tuple[Cut, ...], poses: np.ndarray, most: int) -> np.ndarray:
    """Which groups are worth cutting at each of these poses, into at most so many parts? (pose, cut) of truth."""
    shift = matrix.along_poses[3:][:, :, poses]
    # The group's departure from normal counts with the square of its variance.
    departure = np.zeros((len(poses), len(possible)))
    for n, cut in enumerate(possible):
        departure[:, n] = cut.excess * variance(shift, known, cut.terms) ** 2
    cells = np.array([len(cut.shares) for cut in possible])
    order = np.argsort(-departure / np.log(cells), axis=1, kind="stable")
    taken = np.zeros(departure.shape, bool)
    parts = np.ones(len(poses), int)
    rows = np.arange(len(poses))
    enough = _WORTH * departure.sum(axis=1)
    for n in range(len(possible)):
        at = order[:, n]
        fits = (parts * cells[at] <= most) & (departure[rows, at] > enough)
        taken[rows, at] = fits
        parts = np.where(fits, parts * cells[at], parts)
    # What cannot be cut, such as cut normal draws, departs as before: where that is most of it, cutting the others is in vain.
    other = np.zeros(len(poses))
    for four, value in zip(known.fours.tolist(), known.four_values, strict=True):
        if len(set(four)) == 1 and not any(four[0] in cut.terms for cut in possible):
            other += abs(value) * (shift[:, four[0]] ** 2).sum(axis=0) ** 2
    taken[(departure * taken).sum(axis=1) < _MOST * (departure.sum(axis=1) + other)] = False
    return taken


def condition(matrix: Screws, known: Cumulants, taken: tuple[Cut, ...], poses: np.ndarray) -> tuple[Sums, Mixture]:
    """What is the error at these poses once every one of these groups is known to lie in a cell? Parts pose by pose, all cells in turn."""
    shift = np.ascontiguousarray(matrix.along_poses[3:][:, :, poses])
    gone = [k for cut in taken for k in cut.terms]
    rest = sums(shift, known.without(gone), np.asarray(matrix.bias[poses, 3:]))
    at = np.array(list(product(*(range(len(cut.shares)) for cut in taken))))
    weights = np.ones(len(at))
    total = [np.repeat(array[:, None], len(at), axis=1) for array in rest.arrays]
    for n, cut in enumerate(taken):
        weights *= cut.shares[at[:, n]]
        cells = []
        for mean, left in cut.within:
            cells.append(sums(shift, left, np.einsum("ctp,t->pc", shift[:, list(cut.terms)], mean)).arrays)
        for whole, each in zip(total, zip(*cells, strict=True), strict=True):
            np.add(whole, np.stack(each, axis=1)[:, at[:, n]], out=whole)
    parts = Sums(*(array.reshape(-1, *array.shape[2:]) for array in total))
    return parts, Mixture(np.arange(len(poses) + 1) * len(at), np.tile(weights, len(poses)))
