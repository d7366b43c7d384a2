"""Elastic beams: the deflection of a cantilever's tip under loads.

Beam axes: x along the beam from the clamped end, y and z across it. Twists and wrenches are
(angular, linear) at the tip. Source: S. Timoshenko, Strength of Materials, vol. 1 (deflection with
shear); W. Young, R. Budynas, Roark's Formulas for Stress and Strain, 7th ed., table 8.1.
Valid for small deflections of straight beams and linear material. Each section has the compliance
of a prismatic beam, so a taper must be slight; warping is free.

A beam is described by the compliance of each section per length, S (6, 6), from the load there to
curvatures and strains. A(s) carries a twist of the section at s to the tip, and its transpose A(s)'
a wrench on the tip to that section. So the compliance of the tip is the integral of A S A' along
the beam.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cross_sections import no_strain
from lostmotion.spatial import skew

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.spatial import Floats

_ALONG: Final = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True)
class Segment:
    """A piece of a beam.

    start, end  distances from the clamp, m
    compliance  compliance per length (cause, 6, 6) of the section at x (m from the clamp)
    density     mass per length (kg/m) at x
    points      number of Gauss points for integrals along it; two are exact for a uniform segment
    strain      free strain (6, 2) of the section at x, per kelvin of temperature rise and of
                difference across it; NaN where it is not known
    """

    start: float
    end: float
    compliance: Callable[[float], Floats]
    density: Callable[[float], float]
    points: int = 2
    strain: Callable[[float], Floats] = no_strain

    def quadrature(self, low: float, high: float) -> tuple[Floats, Floats]:
        """Return Gauss points and weights (m) for the part of the segment between low and high (m
        from the clamp).
        """
        low, high = max(low, self.start), min(high, self.end)
        if high <= low:
            return np.zeros(0), np.zeros(0)
        # on a fifth of the segment as accurate as all points on the whole
        few = max(2, self.points // 2)
        at, weight = _gauss(few if high - low < (self.end - self.start) / 5 else self.points)
        return (low + high) / 2 + (high - low) / 2 * at, (high - low) / 2 * weight


@functools.cache
def _gauss(points: int) -> tuple[Floats, Floats]:
    at, weight = np.polynomial.legendre.leggauss(points)
    return at, weight


def uniform_segment(
    start: float, end: float, compliance: Floats, density: float, strain: Floats | None = None
) -> Segment:
    """Return a segment with the same section along its whole length."""
    free = no_strain if strain is None else lambda _: strain
    return Segment(start, end, lambda _: compliance, lambda _: density, strain=free)


@dataclass(frozen=True, slots=True)
class Beam:
    """A straight beam, clamped at 0, as consecutive segments.

    The first axis of all compliances is the cause: one for each material. Deflections are linear in
    the loads.
    """

    segments: tuple[Segment, ...]

    @property
    def length(self) -> float:
        """Return the length, m."""
        return self.segments[-1].end

    @property
    def mass(self) -> float:
        """Return the mass, kg."""
        return float(sum(mass for _, mass in self._masses()))

    @property
    def mass_centre(self) -> float:
        """Return the distance of the centre of mass from the clamp, m; half the length of a
        massless beam.
        """
        mass = self.mass
        return float(sum(x * m for x, m in self._masses())) / mass if mass else self.length / 2

    def _masses(self) -> list[tuple[float, float]]:
        return [
            (x, w * piece.density(x))
            for piece in self.segments
            for x, w in zip(*piece.quadrature(0, self.length), strict=True)
        ]

    def compliance_at(self, place: float) -> Floats:
        """Return the twist of the beam per wrench at a place (m from the clamp): (cause, 6, 6),
        symmetric and positive definite.
        """
        return self._compliances_at([place])[0]

    def _compliances_at(self, places: Sequence[float]) -> list[Floats]:
        """Return the compliances at several places (m from the clamp), in ascending order."""
        total, here, out = np.zeros((len(self.segments[0].compliance(0.0)), 6, 6)), 0.0, []
        for place in places:
            carry = carry_twist(place - here)
            total = carry @ total @ carry.T
            for piece in self.segments:
                for x, weight in zip(*piece.quadrature(here, place), strict=True):
                    carry = carry_twist(place - x)
                    total = total + weight * (carry @ piece.compliance(x) @ carry.T)
            here = place
            out.append(total)
        return out

    def tip_expansion(self) -> Floats:
        """Return the twist of the tip (6, 2) per kelvin of temperature rise, and per kelvin of
        difference across the sections; NaN: not known.
        """
        return np.asarray(
            sum(
                weight * (carry_twist(self.length - x) @ piece.strain(x))
                for piece in self.segments
                for x, weight in zip(*piece.quadrature(0.0, self.length), strict=True)
            )
        )

    def tip_under_own_mass(self) -> Floats:
        """Return the twist of the tip per resultant of a load distributed as the beam's mass, or
        uniformly without mass: (cause, 6, 6).
        """
        return (
            self._tip_under(self._masses())
            if self.mass
            else self.tip_under_uniform_load(0.0, self.length)
        )

    def tip_under_uniform_load(self, low: float, high: float) -> Floats:
        """Return the twist of the tip per resultant of a load distributed uniformly from low to
        high (m from the clamp): (cause, 6, 6).

        Equal ends are a point load.
        """
        if high - low <= 1e-12 * self.length:
            return self._tip_under([((low + high) / 2, 1.0)])
        return self._tip_under(
            [
                (x, w)
                for piece in self.segments
                for x, w in zip(*piece.quadrature(low, high), strict=True)
            ]
        )

    def _tip_under(self, weights: Sequence[tuple[float, float]]) -> Floats:
        """Return the twist of the tip per resultant of a load distributed over places (m from the
        clamp) with these weights.
        """
        found = self._compliances_at([x for x, _ in weights])
        out = sum(
            w * (carry_twist(self.length - x) @ c) for (x, w), c in zip(weights, found, strict=True)
        )
        return np.asarray(out / sum(w for _, w in weights))


def carry_twist(lever: float) -> Floats:
    """Return the matrix (6, 6) that carries a twist to a point `lever` (m) further along the beam,
    as if rigid in between.
    """
    out = np.eye(6)
    out[4, 2], out[5, 1] = lever, -lever
    return out


def prism(length: float, compliances: Sequence[Floats], density: float = 0.0) -> Beam:
    """Return a prismatic beam of this length (m): compliances per length (6, 6) by cause, and mass
    per length `density` (kg/m).
    """
    return Beam((uniform_segment(0.0, length, np.stack(compliances), density),))


def beam_of_compliance(compliance: Floats, length: float) -> Beam:
    """Return a beam with this compliance (6, 6) at its tip: its bending compliance varies linearly
    along it, all else is constant.

    Such a beam always exists; for the compliance of a uniform beam it is that beam. It is exact
    under loads on its tip. Under distributed loads it is approximate, because the compliance of the
    tip does not determine that along the beam. For a cone whose tip has 0.8, 0.7 and 0.5 of the
    diameter at the clamp, the deflection under its own weight is 3, 7 and 30 % too small.
    """
    lever = -skew(_ALONG)
    turns, mixed, moves = compliance[:3, :3], compliance[3:, :3], compliance[3:, 3:]
    # integral along the beam of the bending compliance times the distance from the tip
    first = turns * (length / 2)
    first[1], first[2] = -mixed[2], mixed[1]
    first[0, 1:] = first[1:, 0]
    first[1, 2] = first[2, 1] = (first[1, 2] + first[2, 1]) / 2
    slope = 12 * (first - turns * (length / 2)) / length**3
    root = turns / length - slope * (length / 2)
    second = root * (length**3 / 3) + slope * (length**4 / 4)
    mixed = (mixed - lever @ first) / length
    moves = (
        moves - (lever @ mixed.T + mixed @ lever.T) * (length**2 / 2) - lever @ second @ lever.T
    ) / length

    def per_length(x: float) -> Floats:
        return np.block([[root + slope * (length - x), mixed.T], [mixed, moves]])[None]

    return Beam((Segment(0.0, length, per_length, lambda _: 0.0, points=3),))
