"""Probability distributions, standardised: mean zero, mean square one, mapped from uniforms by the
inverse CDF.

A stated amount "±t" becomes a term of size t / law.stated, so that no draw of a bounded law exceeds
the amount. Every law here but `Normal(cut=inf)` is bounded, which is what makes a worst case
finite. Source of the moments: JCGM 101:2008, 6.4.
"""

from __future__ import annotations

import functools
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from lostmotion.distribution_table import TableRows, ToleranceLaw
    from lostmotion.spatial import Floats


class Law(ABC):
    """A distribution of one draw: `quantile` maps uniforms in (0, 1), `bound` is the largest
    magnitude of a draw.
    """

    @property
    @abstractmethod
    def bound(self) -> float:
        """Return the largest |draw|; infinite for a normal law without limits."""

    @abstractmethod
    def quantile(self, u: Floats) -> Floats:
        """Return the draws of these uniforms (any shape, strictly inside 0..1)."""

    @property
    def stated(self) -> float:
        """Return the amount ±t that a file states for this law, in standard deviations: the bound,
        unless a law defines it differently.
        """
        return self.bound

    @property
    def limit(self) -> float:
        """Return the size that counts in a root-sum-square: the bound, or the stated amount where
        there is no bound.
        """
        return self.bound if math.isfinite(self.bound) else self.stated

    @property
    def mean(self) -> float:
        """Return the mean of what the file states, as a share of the stated amount. Draws have
        none: it becomes a design term.
        """
        return 0.0

    @property
    def breaks(self) -> tuple[float, ...]:
        """Return the uniforms, strictly inside 0..1, at which `quantile` has a kink: integrals are
        taken piece by piece.
        """
        return ()


class Scatter(Law):
    """A distribution of made parts, by which a file states an amount ±t."""

    @abstractmethod
    def share_below(self, amount: Floats) -> Floats:
        """Return the share of parts below an amount (any shape), a share of the stated one: -1 is
        its lower limit, 1 its upper.
        """


@dataclass(frozen=True, slots=True)
class Normal(Scatter):
    """A normal law truncated at `cut` of its own standard deviations and rescaled to unit variance;
    cut = inf: not truncated.
    """

    cut: float = 3.0

    @property
    def bound(self) -> float:
        """Return the truncation limit in standard deviations of the truncated law."""
        return self.cut / _cut_deviation(self.cut) if math.isfinite(self.cut) else math.inf

    @property
    def stated(self) -> float:
        """Return the stated amount in standard deviations: the truncation limit, or three where
        there is none.
        """
        return self.bound if math.isfinite(self.cut) else 3.0

    def quantile(self, u: Floats) -> Floats:
        """Map uniforms through the inverse CDF of the truncated normal law."""
        from scipy.special import ndtr, ndtri

        if not math.isfinite(self.cut):
            return np.asarray(ndtri(u))
        low = ndtr(-self.cut)
        whole = np.asarray(ndtri(low + u * (1 - 2 * low)))
        return whole / _cut_deviation(self.cut)

    def share_below(self, amount: Floats) -> Floats:
        """Return the truncated normal distribution function."""
        from scipy.special import ndtr

        if not math.isfinite(self.cut):
            return np.asarray(ndtr(self.stated * amount))
        low = ndtr(-self.cut)
        return np.asarray((ndtr(self.cut * np.clip(amount, -1.0, 1.0)) - low) / (1 - 2 * low))


@functools.cache
def _cut_deviation(cut: float) -> float:
    """Return the standard deviation of N(0, 1) truncated at +-cut: sqrt(1 - 2 c phi(c) / (2 Phi(c)
    - 1)).
    """
    density = math.exp(-cut * cut / 2) / math.sqrt(2 * math.pi)
    return math.sqrt(1 - 2 * cut * density / math.erf(cut / math.sqrt(2)))


@dataclass(frozen=True, slots=True)
class Uniform(Scatter):
    """Uniform distribution between two limits."""

    @property
    def bound(self) -> float:
        """Return sqrt 3, the limit in standard deviations."""
        return math.sqrt(3)

    def quantile(self, u: Floats) -> Floats:
        """Map uniforms to -sqrt 3 .. sqrt 3."""
        return (2 * u - 1) * math.sqrt(3)

    def share_below(self, amount: Floats) -> Floats:
        """Return a straight line between the limits."""
        return np.asarray((1 + np.clip(amount, -1.0, 1.0)) / 2)


@dataclass(frozen=True, slots=True)
class Table(Scatter):
    """A user's distribution: rows of (value, probability that a draw lies below it), uniform
    between neighbouring values.

    Values are shares of the stated amount, rising; probabilities rise from 0 to 1
    (`lostmotion.distribution_table.table_rows` checks both). Draws are standardised as those of
    every law:
    `mean` and 1 / `stated` are the mean and the standard deviation of the table.
    """

    rows: TableRows

    @property
    def mean(self) -> float:
        """Return the mean of the table, as a share of the stated amount."""
        return _table(self.rows).mean

    @property
    def stated(self) -> float:
        """Return the stated amount in standard deviations of the table."""
        return 1.0 / _table(self.rows).deviation

    @property
    def bound(self) -> float:
        """Return the distance of the farther end of the table from its mean, in standard
        deviations.
        """
        values = _table(self.rows).values
        return float(max(-values[0], values[-1]))

    @property
    def breaks(self) -> tuple[float, ...]:
        """Return the probabilities of the rows between the first and the last."""
        return tuple(probability for _, probability in self.rows[1:-1])

    def quantile(self, u: Floats) -> Floats:
        """Map uniforms along straight lines between the rows."""
        found = _table(self.rows)
        return np.asarray(np.interp(u, found.shares, found.values))

    def share_below(self, amount: Floats) -> Floats:
        """Return straight lines between the rows."""
        values, shares = np.array(self.rows, dtype=float).T
        return np.asarray(np.interp(amount, values, shares))


class _Standardised(NamedTuple):
    """A table's standardised values and their probabilities (row,), and its mean and standard
    deviation in shares of the stated amount.
    """

    values: Floats
    shares: Floats
    mean: float
    deviation: float


@functools.lru_cache(maxsize=256)
def _table(rows: TableRows) -> _Standardised:
    """Standardise a table: of a uniform piece from a to b the mean is (a + b) / 2 and the mean
    square (a^2 + a b + b^2) / 3.
    """
    stated, shares = np.array(rows, dtype=float).T
    wide, middle = stated[-1] - stated[0], (stated[-1] + stated[0]) / 2
    at = (stated - middle) / wide  # so that squares neither overflow nor vanish
    weights = np.diff(shares)
    mean = float(weights @ (at[:-1] + at[1:]) / 2)
    at = at - mean
    deviation = math.sqrt(float(weights @ (at[:-1] ** 2 + at[:-1] * at[1:] + at[1:] ** 2)) / 3)
    return _Standardised(
        at / deviation, shares, float(middle + wide * mean), float(wide * deviation)
    )


@dataclass(frozen=True, slots=True)
class TwoSided(Law):
    """Two equally probable values, -1 and 1: the sides of an unloaded play."""

    @property
    def bound(self) -> float:
        """Return one: both values have the same magnitude."""
        return 1.0

    def quantile(self, u: Floats) -> Floats:
        """Map the lower half of the uniforms to -1 and the upper to +1."""
        return np.where(u < 0.5, -1.0, 1.0)  # noqa: PLR2004 - the middle of 0..1


@dataclass(frozen=True, slots=True)
class Compared(Law):
    """A uniform in 0..1 that is compared with a share, which differs from pose to pose:
    `error_model.closing.standardised` makes a draw of it.
    """

    @property
    def bound(self) -> float:
        """Return one."""
        return 1.0

    def quantile(self, u: Floats) -> Floats:
        """Return the uniforms themselves."""
        return u


COMPARED: Final = Compared()


@dataclass(frozen=True, slots=True)
class Cosine(Law):
    """sqrt 2 cos(2 pi u): one of the two components of a harmonic with random phase; `Sine` of the
    same stream is the other.
    """

    @property
    def bound(self) -> float:
        """Return sqrt 2, the amplitude of a cosine of unit variance."""
        return math.sqrt(2)

    def quantile(self, u: Floats) -> Floats:
        """Map uniforms as phases."""
        return math.sqrt(2) * np.cos(2 * math.pi * u)


@dataclass(frozen=True, slots=True)
class Sine(Law):
    """sqrt 2 sin(2 pi u): the other component, see `Cosine`."""

    @property
    def bound(self) -> float:
        """Return sqrt 2, the amplitude of a sine of unit variance."""
        return math.sqrt(2)

    def quantile(self, u: Floats) -> Floats:
        """Map uniforms as phases."""
        return math.sqrt(2) * np.sin(2 * math.pi * u)


@functools.lru_cache(maxsize=4096)
def product_mean(laws: tuple[Law, ...]) -> float:
    """Return the mean of the product of these laws' draws from a shared uniform.

    By tanh-sinh quadrature of each half of 0..1, so that neither the step of `TwoSided` nor the
    ends of an unbounded law do harm: within 1e-9 (H. Takahasi, M. Mori, Publ. RIMS 9 (1974) 721).
    Where a law has kinks, by Gauss and Legendre's rule on every piece between them.
    """
    if breaks := _breaks(laws):
        u, of_pieces = _pieces(breaks)
        return float(np.prod([law.quantile(u) for law in laws], axis=0) @ of_pieces)
    lower, weights = _halves()
    product = np.ones((2, len(lower)))
    for law in laws:
        product *= np.stack([law.quantile(lower), law.quantile(1 - lower)])
    return float((product * weights).sum())


@functools.cache
def _halves() -> tuple[Floats, Floats]:
    """Return nodes and weights for the lower half of 0..1."""
    x = np.arange(-3.6, 3.6, 0.03)
    inner = 0.5 * math.pi * np.sinh(x)
    nodes = 0.5 / (1 + np.exp(-2 * inner))
    weights = 0.03 * 0.25 * (0.5 * math.pi * np.cosh(x)) / np.cosh(inner) ** 2
    kept = (nodes > 2.0**-53) & (nodes < 0.5)  # noqa: PLR2004 - the middle of 0..1
    return nodes[kept], weights[kept]


def _breaks(laws: tuple[Law, ...]) -> tuple[float, ...]:
    return tuple(sorted({at for law in laws for at in law.breaks}))


# On each piece: exact for products of straight lines, and to rounding for all others.
_NODES: Final = 32


@functools.lru_cache(maxsize=256)
def _pieces(breaks: tuple[float, ...]) -> tuple[Floats, Floats]:
    """Return nodes and weights for 0..1, piece by piece between these breaks."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    ends = np.array([0.0, *breaks, 1.0])
    half = np.diff(ends)[:, None] / 2
    return (ends[:-1, None] + half * (1 + nodes)).ravel(), (half * weights).ravel()


def of_tolerance(law: ToleranceLaw) -> Scatter:
    """Return the distribution that the word or the table of a tolerance names."""
    if not isinstance(law, str):
        return Table(law)
    return {"uniform": Uniform(), "normal without limits": Normal(math.inf)}.get(law, Normal())
