"""Laws of chance, standardised: mean zero, mean square one, mapped from uniforms by the inverse CDF.

A limit "±t" becomes a term of size t / law.bound, so that no draw leaves the limit. Every law here but `Normal(cut=inf)`
is bounded, which is what makes a worst case finite. Source of the moments: JCGM 101:2008, 6.4.
"""

from __future__ import annotations

import functools
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats
    from lostmotion.units import ToleranceLaw


class Law(ABC):
    """How one draw falls: `quantile` maps uniforms in (0, 1), `bound` is the largest size a draw can have."""

    @property
    @abstractmethod
    def bound(self) -> float:
        """Give the largest |draw|; infinite for an uncut normal law."""

    @abstractmethod
    def quantile(self, u: Floats) -> Floats:
        """Which draws belong to these uniforms (any shape, strictly inside 0..1)?"""

    @property
    def excess(self) -> float:
        """Give the fourth cumulant of a law of mean zero: its mean fourth power less the normal law's three, below zero for a flat one."""
        return product_mean((self, self, self, self)) - 3.0


class Smooth(Law):
    """A law without steps, whose shares are known in closed form."""

    @abstractmethod
    def share(self, draws: Floats) -> Floats:
        """Which share of all draws lies below these (any shape)?"""


@dataclass(frozen=True, slots=True)
class Normal(Smooth):
    """A normal law cut at `cut` of its own sigmas and then scaled back to unit variance; cut = inf leaves it whole."""

    cut: float = 3.0

    @property
    def bound(self) -> float:
        """Give the cut in units of the deviation that is left after cutting."""
        return self.cut / _cut_deviation(self.cut) if math.isfinite(self.cut) else math.inf

    def quantile(self, u: Floats) -> Floats:
        """Map uniforms through the cut normal law's inverse."""
        from scipy.special import ndtr, ndtri

        if not math.isfinite(self.cut):
            return np.asarray(ndtri(u))
        low = ndtr(-self.cut)
        whole = np.asarray(ndtri(low + u * (1 - 2 * low)))
        return whole / _cut_deviation(self.cut)

    def share(self, draws: Floats) -> Floats:
        """Give the cut normal law's distribution function."""
        from scipy.special import ndtr

        if not math.isfinite(self.cut):
            return np.asarray(ndtr(draws))
        low, out = ndtr(-self.cut), (draws > 0).astype(float)
        inside = np.abs(draws) < self.bound
        out[inside] = (ndtr(draws[inside] * _cut_deviation(self.cut)) - low) / (1 - 2 * low)
        return out


@functools.cache
def _cut_deviation(cut: float) -> float:
    """Give the standard deviation of N(0, 1) cut at +-cut: sqrt(1 - 2 c phi(c) / (2 Phi(c) - 1))."""
    density = math.exp(-cut * cut / 2) / math.sqrt(2 * math.pi)
    return math.sqrt(1 - 2 * cut * density / math.erf(cut / math.sqrt(2)))


@dataclass(frozen=True, slots=True)
class Uniform(Smooth):
    """Any value between two limits alike."""

    @property
    def bound(self) -> float:
        """Give sqrt 3, the limit in units of the deviation."""
        return math.sqrt(3)

    def quantile(self, u: Floats) -> Floats:
        """Map uniforms to -sqrt 3 .. sqrt 3."""
        return (2 * u - 1) * math.sqrt(3)

    def share(self, draws: Floats) -> Floats:
        """Give the flat law's distribution function."""
        return np.asarray(np.clip(0.5 + draws / (2 * math.sqrt(3)), 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class TwoSided(Law):
    """One side or the other, never between: the state of an unloaded play."""

    @property
    def bound(self) -> float:
        """Give one: both sides are equally far."""
        return 1.0

    def quantile(self, u: Floats) -> Floats:
        """Map the lower half of the uniforms to -1 and the upper to +1."""
        return np.where(u < 0.5, -1.0, 1.0)  # noqa: PLR2004 - the middle of 0..1


@dataclass(frozen=True, slots=True)
class Cosine(Law):
    """sqrt 2 cos(2 pi u): one of the two parts of a harmonic with random phase; `Sine` of the same stream is the other."""

    @property
    def bound(self) -> float:
        """Give sqrt 2, the amplitude of a unit-variance cosine."""
        return math.sqrt(2)

    def quantile(self, u: Floats) -> Floats:
        """Map uniforms as phases."""
        return math.sqrt(2) * np.cos(2 * math.pi * u)


@dataclass(frozen=True, slots=True)
class Sine(Law):
    """sqrt 2 sin(2 pi u): the partner of `Cosine`."""

    @property
    def bound(self) -> float:
        """Give sqrt 2, the amplitude of a unit-variance sine."""
        return math.sqrt(2)

    def quantile(self, u: Floats) -> Floats:
        """Map uniforms as phases."""
        return math.sqrt(2) * np.sin(2 * math.pi * u)


@dataclass(frozen=True, slots=True)
class Amount(Law):
    """(1 + k x) / sqrt(1 + k^2) with x from another law: an amount that scatters around its mean by the share k.

    Not mean zero: it is only a robot's factor in a product with a visit draw that is.
    """

    scatter: float
    inner: Law

    @property
    def bound(self) -> float:
        """Give the largest amount in units of its root mean square."""
        return (1 + self.scatter * self.inner.bound) / math.hypot(1, self.scatter)

    def quantile(self, u: Floats) -> Floats:
        """Map uniforms to amounts."""
        return (1 + self.scatter * self.inner.quantile(u)) / math.hypot(1, self.scatter)


@functools.lru_cache(maxsize=4096)
def product_mean(laws: tuple[Law, ...]) -> float:
    """What is the mean of the product of these laws' draws, all from one and the same uniform?

    By tanh-sinh quadrature of each half of 0..1, so that neither the step of `TwoSided` nor the ends of an unbounded law do harm: within 1e-9
    (H. Takahasi, M. Mori, Publ. RIMS 9 (1974) 721).
    """
    lower, weights = _halves()
    product = np.ones((2, len(lower)))
    for law in laws:
        product *= np.stack([law.quantile(lower), law.quantile(1 - lower)])
    return float((product * weights).sum())


@functools.cache
def _halves() -> tuple[Floats, Floats]:
    """Give nodes and weights for the lower half of 0..1."""
    x = np.arange(-3.6, 3.6, 0.03)
    inner = 0.5 * math.pi * np.sinh(x)
    nodes = 0.5 / (1 + np.exp(-2 * inner))
    weights = 0.03 * 0.25 * (0.5 * math.pi * np.cosh(x)) / np.cosh(inner) ** 2
    kept = (nodes > 2.0**-53) & (nodes < 0.5)  # noqa: PLR2004 - the middle of 0..1
    return nodes[kept], weights[kept]


@functools.lru_cache(maxsize=256)
def gauss_rule(law: Law, count: int) -> tuple[Floats, Floats]:
    """Which so many values, and weights that add to one, have the law's moments up to 2 count - 1?

    Stieltjes' recurrence on the nodes of `product_mean`, then Golub and Welsch's eigenvalues (W. Gautschi, Orthogonal Polynomials, 2004, ch. 2, 3).
    A two-sided law has two values, and no more.
    """
    lower, weights = _halves()
    values, weights = np.concatenate([law.quantile(lower), law.quantile(1 - lower)]), np.concatenate([weights, weights])
    weights = weights / weights.sum()
    before, now, size = np.zeros_like(values), np.ones_like(values), 1.0
    middle, across = np.empty(count), np.empty(count)
    for k in range(count):
        own = weights @ now**2
        middle[k], across[k] = weights @ (values * now**2) / own, own / size
        before, now, size = now, (values - middle[k]) * now - (across[k] if k else 0.0) * before, own
    off = np.diag(np.sqrt(across[1:]), 1)
    nodes, vectors = np.linalg.eigh(np.diag(middle) + off + off.T)
    return nodes, vectors[0] ** 2


def of_tolerance(law: ToleranceLaw) -> Law:
    """Which law does the word behind a tolerance name?"""
    return Uniform() if law == "uniform" else Normal()
