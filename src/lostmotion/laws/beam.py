"""Elastic beams: cross-sections, and what the tip of a cantilever does under loads.

Beam axes: x along the beam from the clamped end, y and z across it. Twists and wrenches are (angular, linear) at the tip.
Source: S. Timoshenko, Strength of Materials, vol. 1 (deflection with shear); W. Young, R. Budynas, Roark's Formulas for Stress and
Strain, 7th ed., tables 8.1 (beams) and 10.1 (torsion); shear factors G. Cowper, J. Appl. Mech. 33 (1966) 335. Valid for small
deflections of straight beams, linear material; each section gives as that of a prismatic beam would, so a taper must be gentle, and warping is free.

Every beam is one thing here: what each of its sections gives per length, S (6, 6), from the load there to curvatures and strains. A wrench on
the tip loads the section s before it by A(s)' of it, that section's give moves the tip by A(s), and the tip's compliance is the integral of
A S A' along the beam.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.spatial import skew

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.spatial import Floats

# Of the series for a rectangle's torsion; the terms fall with the fifth power.
_TORSION_TERMS: Final = 12
# Of a sharp corner of a strip of width 1, beyond its arms: finite differences to 1/128, extrapolated; the first is exact.
_CORNER_CAPACITY: Final = 1 - 2 * math.log(2) / math.pi
_CORNER_SLOPE: Final = 0.14483
_CORNER_MEMBRANE: Final = 0.2029
_ALONG: Final = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True)
class SectionValues:
    """What a cross-section gives a beam: area m^2, second moments about y and z m^4, torsion constant m^4, shear factors.

    Of a section without symmetry also the product of inertia (integral of y z), what a force along z shears along y and the reverse (in units of
    1/(G A)), and where its shear centre lies, seen from the centroid, m. The beam's line runs through the centroid.
    """

    area: float
    i_y: float
    i_z: float
    torsion: float
    shear_y: float
    shear_z: float
    i_yz: float = 0.0
    shear_yz: float = 0.0
    centre_y: float = 0.0
    centre_z: float = 0.0


def round_section(outer: float, inner: float, nu: float) -> SectionValues:
    """What does a round bar (inner = 0) or tube of these diameters (m) give? Shear factor after Cowper, exact torsion."""
    area = math.pi / 4 * (outer**2 - inner**2)
    second = math.pi / 64 * (outer**4 - inner**4)
    m2 = (inner / outer) ** 2
    shear = 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)
    return SectionValues(area, second, second, 2 * second, shear, shear)


def rectangle_section(width: float, height: float, nu: float) -> SectionValues:
    """What does a solid bar, width along y and height along z (m), give? Torsion by Saint-Venant's series, to 1e-6."""
    area = width * height
    long, short = max(width, height), min(width, height)
    series = sum(math.tanh(n * math.pi * long / (2 * short)) / n**5 for n in range(1, 2 * _TORSION_TERMS, 2))
    torsion = long * short**3 / 3 * (1 - 192 / math.pi**5 * short / long * series)
    shear = 10 * (1 + nu) / (12 + 11 * nu)
    return SectionValues(area, width * height**3 / 12, height * width**3 / 12, torsion, shear, shear)


def box_section(width: float, height: float, wall: float, nu: float) -> SectionValues:
    """What does a rectangular tube, width along y and height along z (m), give?

    Torsion by Prandtl's membrane: straight walls and four sharp corners whose parts (capacity 1 - 2 ln 2/pi, volumes under the unit slope and under
    the wall's own membrane) are those of one corner with long arms; within 0.1 % of exact where the hole is at least as wide as the wall is
    thick, beyond that within 3 %. Shear factor for thin walls.
    """
    inner_w, inner_h = width - 2 * wall, height - 2 * wall
    area = width * height - inner_w * inner_h
    i_y = (width * height**3 - inner_w * inner_h**3) / 12
    i_z = (height * width**3 - inner_h * inner_w**3) / 12
    straight = 2 * (inner_w + inner_h)
    capacity = straight / wall + 4 * _CORNER_CAPACITY
    enclosed = inner_w * inner_h + straight * wall / 2 + 4 * _CORNER_SLOPE * wall**2
    torsion = 4 * enclosed**2 / capacity + straight * wall**3 / 3 + 8 * _CORNER_MEMBRANE * wall**4
    mid_w, mid_h = width - wall, height - wall
    # Cowper's thin-walled box; b is the flange across the force, h the web along it
    return SectionValues(area, i_y, i_z, torsion, _box_shear(mid_h, mid_w, nu), _box_shear(mid_w, mid_h, nu))


def _box_shear(flange: float, web: float, nu: float) -> float:
    m = flange / web  # equal walls all round
    upper = 10 * (1 + nu) * (1 + 3 * m) ** 2
    lower = 12 + 72 * m + 150 * m**2 + 90 * m**3 + nu * (11 + 66 * m + 135 * m**2 + 90 * m**3) + 10 * m**3 * (3 + nu + 3 * m)
    return upper / lower


def i_section(width: float, height: float, web: float, flange: float, nu: float) -> SectionValues:
    """What does an I-section give, its flanges as wide as `width` along y, its web standing along z, sharp corners (m)?

    Torsion after F. El Darwish and B. Johnston, J. Struct. Div. ASCE 91 (1965) 203, free to warp. Shear factor along the web after Cowper, thin
    walls; along the flanges that of the flanges as bars.
    """
    inside = height - 2 * flange
    area = 2 * width * flange + inside * web
    i_y = (width * height**3 - (width - web) * inside**3) / 12
    i_z = (2 * flange * width**3 + inside * web**3) / 12
    thin = web / flange
    junction = -0.042 + 0.2204 * thin - 0.0725 * thin**2
    circle = flange + web**2 / (4 * flange)  # the largest circle in the junction of web and flange, no fillet
    torsion = 2 / 3 * width * flange**3 + inside * web**3 / 3 + 2 * junction * circle**4 - 0.42 * flange**4
    mid = height - flange
    m, n = 2 * width * flange / (mid * web), width / mid
    lower = 12 + 72 * m + 150 * m**2 + 90 * m**3 + nu * (11 + 66 * m + 135 * m**2 + 90 * m**3)
    lower += 30 * n**2 * (m + m**2) + 5 * nu * n**2 * (8 * m + 9 * m**2)
    shear_z = 10 * (1 + nu) * (1 + 3 * m) ** 2 / lower
    shear_y = 10 * (1 + nu) / (12 + 11 * nu) * 2 * width * flange / area
    return SectionValues(area, i_y, i_z, torsion, shear_y, shear_z)


def compliance_per_length(young: float, shear_modulus: float, section: SectionValues) -> Floats:
    """How does a section give under a load on it? (6, 6) from (moment, force) there to (twist per length and curvatures, stretch and shears).

    A force beside the shear centre twists too.
    """
    out = np.zeros((6, 6))
    out[1:3, 1:3] = np.linalg.inv(young * np.array([[section.i_y, -section.i_yz], [-section.i_yz, section.i_z]]))
    out[3, 3] = 1 / (young * section.area)
    shears = np.array([[1 / section.shear_y, section.shear_yz], [section.shear_yz, 1 / section.shear_z]])
    out[4:, 4:] = shears / (shear_modulus * section.area)
    about_centre = np.array([1.0, 0, 0, 0, section.centre_z, -section.centre_y])
    return out + np.outer(about_centre, about_centre) / (shear_modulus * section.torsion)


def parallel_layers(compliances: Floats) -> Floats:
    """How does a section of several layers give, if each by itself gives so (layer, 6, 6)? Each layer's part (layer, 6, 6), whose sum is the whole.

    The layers bend, twist and stretch as one: their stiffnesses add (transformed section). Exact in bending and stretch of layers about one
    centroid and in the torsion of round ones. Part k is what the whole's give gains per share by which layer k is softer.
    """
    stiff = np.linalg.inv(compliances)
    whole = np.linalg.inv(stiff.sum(axis=0))
    return np.asarray(whole @ stiff @ whole)


@dataclass(frozen=True, slots=True)
class Segment:
    """A piece of a beam, from `start` to `end` (m from the clamp): what its sections give (cause, 6, 6), and its mass per length (kg/m), at x.

    `points` of Gauss's rule integrate it: two are exact where nothing changes along the piece.
    """

    start: float
    end: float
    compliance: Callable[[float], Floats]
    density: Callable[[float], float]
    points: int = 2

    def quadrature(self, low: float, high: float) -> tuple[Floats, Floats]:
        """Give Gauss's points and weights (m) between low and high, as far as they lie in the piece."""
        low, high = max(low, self.start), min(high, self.end)
        if high <= low:
            return np.zeros(0), np.zeros(0)
        few = max(2, self.points // 2)  # is as exact on a fifth of a piece as all points are on the whole
        at, weight = _gauss(few if high - low < (self.end - self.start) / 5 else self.points)
        return (low + high) / 2 + (high - low) / 2 * at, (high - low) / 2 * weight


@functools.cache
def _gauss(points: int) -> tuple[Floats, Floats]:
    at, weight = np.polynomial.legendre.leggauss(points)
    return at, weight


def uniform_segment(start: float, end: float, compliance: Floats, density: float) -> Segment:
    """Which piece has the same section all along?"""
    return Segment(start, end, lambda _: compliance, lambda _: density)


@dataclass(frozen=True, slots=True)
class Beam:
    """A straight beam, clamped at 0, as pieces one after the other.

    Whatever it gives is split by cause, the leading axis: what belongs to each of its materials. All of it is linear in the loads.
    """

    segments: tuple[Segment, ...]

    @property
    def length(self) -> float:
        """Give its length, m."""
        return self.segments[-1].end

    @property
    def mass(self) -> float:
        """Give its mass, kg."""
        return float(sum(mass for _, mass in self._masses()))

    @property
    def mass_centre(self) -> float:
        """Give how far its centre of mass lies from the clamp, m; half way where it weighs nothing."""
        mass = self.mass
        return float(sum(x * m for x, m in self._masses())) / mass if mass else self.length / 2

    def _masses(self) -> list[tuple[float, float]]:
        return [(x, w * piece.density(x)) for piece in self.segments for x, w in zip(*piece.quadrature(0, self.length), strict=True)]

    def compliance_at(self, place: float) -> Floats:
        """How does the beam turn and move at a place under a wrench there? (cause, 6, 6), symmetric and positive."""
        return self._compliances_at([place])[0]

    def _compliances_at(self, places: Sequence[float]) -> list[Floats]:
        """Give the same at several places, each farther along than the one before."""
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

    def tip_under_own_mass(self) -> Floats:
        """How does the tip turn and move under a wrench spread along the beam as its mass is? (cause, 6, 6) per whole wrench; evenly without mass."""
        return self._tip_under(self._masses()) if self.mass else self.tip_under_uniform_load(0.0, self.length)

    def tip_under_uniform_load(self, low: float, high: float) -> Floats:
        """How does the tip turn and move under a wrench spread evenly between two places (cause, 6, 6), per whole wrench? At one place, a point."""
        if high - low <= 1e-12 * self.length:
            return self._tip_under([((low + high) / 2, 1.0)])
        return self._tip_under([(x, w) for piece in self.segments for x, w in zip(*piece.quadrature(low, high), strict=True)])

    def _tip_under(self, weights: Sequence[tuple[float, float]]) -> Floats:
        """Give what the tip does under one wrench, shared out over places in these proportions."""
        found = self._compliances_at([x for x, _ in weights])
        out = sum(w * (carry_twist(self.length - x) @ c) for (x, w), c in zip(weights, found, strict=True))
        return np.asarray(out / sum(w for _, w in weights))


def carry_twist(lever: float) -> Floats:
    """Which matrix (6, 6) gives the twist of the beam so far on (m) from a twist here? A turn here swings the rest of the beam."""
    out = np.eye(6)
    out[4, 2], out[5, 1] = lever, -lever
    return out


def prism(length: float, compliances: Sequence[Floats], density: float = 0.0) -> Beam:
    """Which beam has one section all along? `compliances` (6, 6) by cause, mass per length in kg/m."""
    return Beam((uniform_segment(0.0, length, np.stack(compliances), density),))


def beam_of_compliance(compliance: Floats, length: float) -> Beam:
    """Which beam has this compliance (6, 6) at its tip? One whose give in bending runs evenly from end to end, all else the same all along.

    There is always one, and of a uniform beam it is that beam. Under loads on its tip it is exact; before the tip it stands for what the matrix does
    not say: a cone that narrows to 0.8, 0.7, 0.5 sags 3, 7, 30 % less under its own weight than it should.
    """
    lever = -skew(_ALONG)
    turns, mixed, moves = compliance[:3, :3], compliance[3:, :3], compliance[3:, 3:]
    first = turns * (length / 2)  # the bending give times the distance from the tip, summed along the beam
    first[1], first[2] = -mixed[2], mixed[1]
    first[0, 1:] = first[1:, 0]
    first[1, 2] = first[2, 1] = (first[1, 2] + first[2, 1]) / 2
    slope = 12 * (first - turns * (length / 2)) / length**3
    root = turns / length - slope * (length / 2)
    second = root * (length**3 / 3) + slope * (length**4 / 4)
    mixed = (mixed - lever @ first) / length
    moves = (moves - (lever @ mixed.T + mixed @ lever.T) * (length**2 / 2) - lever @ second @ lever.T) / length

    def per_length(x: float) -> Floats:
        return np.block([[root + slope * (length - x), mixed.T], [mixed, moves]])[None]

    return Beam((Segment(0.0, length, per_length, lambda _: 0.0, points=3),))


def tip_compliance(length: float, young: float, shear_modulus: float, section: SectionValues) -> Floats:
    """How does a cantilever's tip move under a wrench at the tip? Matrix (6, 6): twist = C wrench, in beam axes; rad, m per N m, N.

    l/(E I), l^2/(2 E I), l^3/(3 E I) + l/(k G A), l/(G J), l/(E A). Length 0 gives zero. Symmetric and positive (reciprocity).
    """
    return np.asarray(prism(length, [compliance_per_length(young, shear_modulus, section)]).compliance_at(length)[0])
