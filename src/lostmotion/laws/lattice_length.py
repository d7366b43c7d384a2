"""How long is a sum of independent draws, where it is too far from normal for Edgeworth's terms? By its characteristic function on a lattice.

The share of lengths below r is that of the nearly normal vector of the same third and fourth cumulants (`normal_length`) plus a correction. That is
exact up to what is told: the difference of both characteristic functions, a product over draws and a Gaussian one, is known on a lattice of wave
vectors; its Fourier sum is a density on a lattice of points; and the length's cosine series under it, which converges fast because little of the
share is left to it, can be summed up to any r. What the lattice's box, draws put together as nearly normal, and the series' end may leave out
is added up in every bound.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws import lattice_length_kernel as kernel
from lostmotion.laws.normal_length import normal_length, share_and_density

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from lostmotion.spatial import Floats

# How many steps of the lattice the length's waves are followed, one attempt after the other.
FINE: Final = (8, 12, 18)
# From this share of the series on its terms, all alike in sign, stand for those beyond its end.
_LAST: Final = 0.7
# What was estimated to be left out counts so often: a figure in three hundred was off by more than the plain sum.
_SAFETY: Final = 1.5
# A variance along an axis is none if it is a smaller share of the whole.
_FLAT: Final = 1e-12
# Error of a share of the nearly normal vector's lengths.
_SHARE: Final = 2e-6
# A lattice that may miss a larger share than this is so coarse that the next would not do.
_HOPELESS: Final = 0.08
_TRIES: Final = 40
_SHORT: Final = 1e-6
# How much further than to first order a bound is looked for.
_WIDER: Final = (1.2, 2.0, 5.0)


@dataclass(frozen=True)
class Draws:
    """Groups of draws that are independent of each other, each by finitely many values (Gauss's rules of the laws).

    values  (value, most) what the terms of a group draw together; terms (value, most) which they are, -1 for none
    even    (value,) weights before cosines: values that come with either sign stand here once; odd: before sines, zero for those
    first   (group + 1,) where each group's values begin; skew (group,) whether its odd weights count
    sixth   (group,) largest sixth cumulant of a term, over the cube of its variance
    """

    values: Floats
    terms: NDArray[np.int64]
    even: Floats
    odd: Floats
    first: NDArray[np.int64]
    skew: NDArray[np.bool_]
    sixth: Floats


@dataclass(frozen=True)
class Vectors:
    """The sums: shift (n, 3, term) per unit draw, bias (n, 3), covariance (n, 3, 3), third (n, 10) and fourth (n, 15) forms."""

    shift: Floats
    bias: Floats
    covariance: Floats
    third: Floats
    fourth: Floats

    def of(self, some: NDArray[np.int64]) -> Vectors:
        """Give some of them."""
        return Vectors(self.shift[some], self.bias[some], self.covariance[some], self.third[some], self.fourth[some])


@dataclass(frozen=True)
class Found:
    """Of each vector its mean length and quantiles, (n, 1 + level) the mean first, how far each may be off, and where its lengths stand.

    NaN where the lattice does not tell. `lengths`: which vectors, their laws, and which of those they are.
    """

    values: Floats
    bounds: Floats
    lengths: tuple[tuple[NDArray[np.int64], Lengths, NDArray[np.int64]], ...]


def lattice_length(draws: Callable[[int], Draws], vectors: Vectors, levels: Floats, guess: Floats, wanted: NDArray[np.bool_], enough: float) -> Found:
    """How long is each vector on average, which lengths do these shares of it stay below, and how far may each figure be off?

    `draws` by how many steps the length's waves are followed, one of FINE; `guess` (n, level) or NaN. Finer lattices are tried until every bound that
    is `wanted` (n, 1 + level) is at most the share `enough` of its figure, and no longer where they are far from that.
    """
    values, bounds = np.full(wanted.shape, np.nan), np.full(wanted.shape, np.nan)
    size = np.trace(vectors.covariance, axis1=1, axis2=2)
    short = np.flatnonzero((size > 0) & np.isfinite(size) & np.isfinite(vectors.bias).all(axis=1))
    tried: list[tuple[NDArray[np.int64], Lengths]] = []
    best, missed = np.full(len(size), -1), np.full(len(size), np.inf)
    for fine in FINE:
        if not len(short):
            break
        lengths = Lengths(draws(fine), vectors.of(short), fine)
        value, bound = _figures(lengths, levels, np.where(np.isfinite(values[short, 1:]), values[short, 1:], guess[short]))
        better = ~(bounds[short] <= bound) & np.isfinite(bound)
        values[short], bounds[short] = np.where(better, value, values[short]), np.where(better, bound, bounds[short])
        nearer = lengths.known & (lengths.missed < missed[short])
        best[short[nearer]], missed[short[nearer]] = len(tried), lengths.missed[nearer]
        tried.append((short, lengths))
        done = ~wanted[short] | (bounds[short] <= enough * values[short])
        short = short[~done.all(axis=1) & (lengths.missed < _HOPELESS)]
    kept = [(which, lengths, np.flatnonzero(best[which] == n)) for n, (which, lengths) in enumerate(tried)]
    return Found(values, bounds, tuple((which[own], lengths, own) for which, lengths, own in kept if len(own)))


def _figures(lengths: Lengths, levels: Floats, guess: Floats) -> tuple[Floats, Floats]:
    at, bound = _quantiles(lengths, levels, guess)
    # Shares that are off by so much wherever a length may be move the mean by so much of that range.
    mean, of_mean = (np.where(lengths.known, each, np.nan) for each in (lengths.mean(), lengths.missed * lengths.ends))
    return np.column_stack([mean, at]), np.column_stack([of_mean, bound])


def _quantiles(lengths: Lengths, levels: Floats, guess: Floats) -> tuple[Floats, Floats]:
    """Find these quantiles (n, level) by Newton's steps, kept between what is below and above, and their bounds."""
    size = np.sqrt(lengths.square)
    low, high = np.zeros(guess.shape), np.minimum(size[:, None] / np.sqrt(1 - levels), lengths.ends[:, None])
    at = np.where((guess > low) & (guess < high), guess, np.minimum(size[:, None], 0.5 * high))
    going = np.flatnonzero(lengths.known)
    for _ in range(_TRIES):
        here = at[going]
        share, density = lengths.share(going, here)
        low[going], high[going] = np.where(share < levels, here, low[going]), np.where(share < levels, high[going], here)
        with np.errstate(divide="ignore", invalid="ignore"):
            new = here + (levels - share) / density
        inside = (density > 0) & (new > low[going]) & (new < high[going])
        at[going] = np.where(inside, new, 0.5 * (low[going] + high[going]))
        going = going[(np.abs(at[going] - here) > _SHORT * here).any(axis=1)]
        if not len(going):
            break
    bound = np.full(at.shape, np.nan)
    sure = np.setdiff1d(np.flatnonzero(lengths.known), going)
    share, density = lengths.share(sure, at[sure])
    left = lengths.missed[sure, None] + np.abs(share - levels)
    for wider in _WIDER:
        with np.errstate(divide="ignore", invalid="ignore"):
            by = np.where(density > 0, wider * left / density, np.inf)
        by = np.minimum(np.minimum(by, at[sure]), lengths.ends[sure, None] - at[sure])
        below, above = (lengths.share(sure, at[sure] + sign * by)[0] for sign in (-1, 1))
        holds = np.isnan(bound[sure]) & (below <= levels - left) & (above >= levels + left)
        bound[sure] = np.where(holds, by, bound[sure])
    return at, bound


class Lengths:
    """Shares of the vectors' lengths: the nearly normal ones', and the series that correct them.

    known (n,) whether the lattice tells any; missed (n,) how far shares may be off; ends (n,) no length is beyond.
    """

    def __init__(self, draws: Draws, vectors: Vectors, fine: int) -> None:
        """Find the series of these vectors."""
        self._nearly = (vectors.bias, vectors.covariance, vectors.fourth, vectors.third)
        spread, turn = np.linalg.eigh(vectors.covariance)
        varying = spread > _FLAT * spread[:, -1:]
        root = np.sqrt(np.where(varying, spread, 0.0))
        bias = np.einsum("pji,pj->pi", turn, vectors.bias)
        white = np.einsum("pji,pjt->pit", turn, vectors.shift) * np.where(varying, 1 / np.where(varying, root, 1.0), 0.0)[:, :, None]
        self.square = np.asarray((root**2).sum(axis=1) + (bias**2).sum(axis=1))
        count = len(root)
        self._halves, self._waves, self.missed = np.empty(count), np.empty(count, np.int64), np.empty(count)
        self._series = np.zeros((count, kernel.MOST_WAVES + 1))
        kernel.series(
            *(bias, root, np.ascontiguousarray(white), np.sqrt(self.square), fine),
            *(draws.values, draws.terms, draws.even, draws.odd, draws.first, draws.skew, draws.sixth),
            *(self._halves, self._waves, self.missed, self._series),
        )
        waves = np.arange(1, kernel.MOST_WAVES + 1)
        last = (waves > _LAST * self._waves[:, None]) & (waves <= self._waves[:, None])
        self.missed = _SHARE + _SAFETY * (self.missed + (np.abs(self._series[:, 1:]) * last / (np.pi * waves)).sum(axis=1))
        self.known, self.ends = self._waves > 0, self._halves

    def share(self, some: NDArray[np.int64], lengths: Floats) -> tuple[Floats, Floats]:
        """Which share of each of some vectors' lengths lies below these (some, length), and how dense are they there? All of it beyond the ends."""
        beyond = lengths > self.ends[some, None]
        lengths = np.minimum(lengths, self.ends[some, None])
        bias, covariance, fourth, third = (array[some] for array in self._nearly)
        share, density, _ = share_and_density(bias, covariance, lengths, fourth, third=third)
        more, denser = np.empty(lengths.shape), np.empty(lengths.shape)
        kernel.read(self._halves[some], self._waves[some], self._series[some], lengths, more, denser)
        return np.where(beyond, 1.0, share + more), np.where(beyond, 0.0, density + denser)

    def mean(self) -> Floats:
        """How long are the vectors on average? The nearly normal ones' mean, and the moment of the series, term by term."""
        bias, covariance, fourth, third = self._nearly
        waves = np.arange(1, kernel.MOST_WAVES + 1, 2)  # those of even number are even about the middle of the range
        kept = np.where(waves <= self._waves[:, None], self._series[:, 1::2], 0.0)
        more = self._halves * (self._series[:, 0] / 2 - (kept * (2 / (np.pi * waves) ** 2)).sum(axis=1))
        return np.asarray(normal_length(bias, covariance, (), fourth, third=third).mean + more)
