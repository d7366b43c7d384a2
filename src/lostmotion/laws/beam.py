"""Elastic beams: cross-sections, and the deflection of a cantilever's tip under loads.

Beam axes: x along the beam from the clamped end, y and z across it. Twists and wrenches are (angular, linear) at the tip. Source: S. Timoshenko,
Strength of Materials, vol. 1 (deflection with shear); W. Young, R. Budynas, Roark's Formulas for Stress and Strain, 7th ed., tables 8.1 (beams) and
10.1 (torsion); shear factors G. Cowper, J. Appl. Mech. 33 (1966) 335. Valid for small deflections of straight beams and linear material. Each section
has the compliance of a prismatic beam, so a taper must be slight; warping is free.

A beam is described by the compliance of each section per length, S (6, 6), from the load there to curvatures and strains. A wrench on the tip loads
the section at s by A(s)' of it, the deformation of that section moves the tip by A(s), and the compliance of the tip is the integral of A S A' along
the beam.
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

# Terms of the series for a rectangle's torsion; they fall with the fifth power.
_TORSION_TERMS: Final = 12
# Contributions of a sharp corner of a strip of width 1, beyond its arms. The first is exact, the others are extrapolated from finite differences.
_CORNER_CAPACITY: Final = 1 - 2 * math.log(2) / math.pi
_CORNER_SLOPE: Final = 0.14483
_CORNER_MEMBRANE: Final = 0.2029
_ALONG: Final = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True)
class SectionValues:
    """Properties of a cross-section: area m^2, second moments about y and z m^4, torsion constant m^4, shear factors.

    For a section without symmetry also the product of inertia (integral of y z), the coupling of shear along z and y (in units of 1/(G A)), and the
    position of the shear centre from the centroid, m. The beam's axis runs through the centroid.
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
    """Return the properties of a round bar (inner = 0) or tube of these diameters (m). Shear factor from Cowper, exact torsion."""
    area = math.pi / 4 * (outer**2 - inner**2)
    second = math.pi / 64 * (outer**4 - inner**4)
    m2 = (inner / outer) ** 2
    shear = 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)
    return SectionValues(area, second, second, 2 * second, shear, shear)


def rectangle_section(width: float, height: float, nu: float) -> SectionValues:
    """Return the properties of a solid bar, width along y and height along z (m). Torsion by Saint-Venant's series, to 1e-6."""
    area = width * height
    long, short = max(width, height), min(width, height)
    series = sum(math.tanh(n * math.pi * long / (2 * short)) / n**5 for n in range(1, 2 * _TORSION_TERMS, 2))
    torsion = long * short**3 / 3 * (1 - 192 / math.pi**5 * short / long * series)
    shear = 10 * (1 + nu) / (12 + 11 * nu)
    return SectionValues(area, width * height**3 / 12, height * width**3 / 12, torsion, shear, shear)


def box_section(width: float, height: float, wall: float, nu: float) -> SectionValues:
    """Return the properties of a rectangular tube, width along y and height along z (m).

    Torsion by Prandtl's membrane: straight walls and four sharp corners. Each corner's contributions (capacity 1 - 2 ln 2/pi, volumes under the unit
    slope and under the wall's own membrane) are those of a single corner with long arms. Within 0.1 % of exact where the hole is at least as wide as
    the wall is thick, otherwise within 3 %. Shear factor for thin walls.
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
    """Return the properties of an I-section with sharp corners: flanges of `width` along y, web along z (m).

    Torsion from F. El Darwish and B. Johnston, J. Struct. Div. ASCE 91 (1965) 203, free to warp. Shear factor along the web from Cowper, thin walls;
    along the flanges that of the flanges as rectangular bars.
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
    """Return the compliance of a section (6, 6): from (moment, force) to (twist per length and curvatures, stretch and shears).

    A force beside the shear centre also twists the section.
    """
    out = np.zeros((6, 6))
    out[1:3, 1:3] = np.linalg.inv(young * np.array([[section.i_y, -section.i_yz], [-section.i_yz, section.i_z]]))
    out[3, 3] = 1 / (young * section.area)
    shears = np.array([[1 / section.shear_y, section.shear_yz], [section.shear_yz, 1 / section.shear_z]])
    out[4:, 4:] = shears / (shear_modulus * section.area)
    about_centre = np.array([1.0, 0, 0, 0, section.centre_z, -section.centre_y])
    return out + np.outer(about_centre, about_centre) / (shear_modulus * section.torsion)


def parallel_layers(compliances: Floats) -> Floats:
    """Return each layer's part (layer, 6, 6) of the compliance of a layered section, from the layers' own compliances (layer, 6, 6).

    The parts add up to the compliance of the whole. The layers bend, twist and stretch together, so their stiffnesses add (transformed section).
    Exact in bending and stretch of concentric layers and in torsion of round ones. Part k is the derivative of the whole compliance with respect to
    the relative compliance of layer k.
    """
    stiff = np.linalg.inv(compliances)
    whole = np.linalg.inv(stiff.sum(axis=0))
    return np.asarray(whole @ stiff @ whole)


@dataclass(frozen=True, slots=True)
class Segment:
    """A piece of a beam from `start` to `end` (m from the clamp): compliance of its sections (cause, 6, 6) and mass per length (kg/m) at x.

    `points` of Gauss's rule integrate it: two are exact for a uniform segment.
    """

    start: float
    end: float
    compliance: Callable[[float], Floats]
    density: Callable[[float], float]
    points: int = 2

    def quadrature(self, low: float, high: float) -> tuple[Floats, Floats]:
        """Return Gauss's points and weights (m) between low and high, within the segment."""
        low, high = max(low, self.start), min(high, self.end)
        if high <= low:
            return np.zeros(0), np.zeros(0)
        few = max(2, self.points // 2)  # as accurate on a fifth of a segment as all points on the whole
        at, weight = _gauss(few if high - low < (self.end - self.start) / 5 else self.points)
        return (low + high) / 2 + (high - low) / 2 * at, (high - low) / 2 * weight


@functools.cache
def _gauss(points: int) -> tuple[Floats, Floats]:
    at, weight = np.polynomial.legendre.leggauss(points)
    return at, weight


def uniform_segment(start: float, end: float, compliance: Floats, density: float) -> Segment:
    """Return a segment with the same section along its whole length."""
    return Segment(start, end, lambda _: compliance, lambda _: density)


@dataclass(frozen=True, slots=True)
class Beam:
    """A straight beam, clamped at 0, as consecutive segments.

    Compliances are split by cause, the leading axis: one for each material. Everything is linear in the loads.
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
        """Return the distance of the centre of mass from the clamp, m; half the length of a massless beam."""
        mass = self.mass
        return float(sum(x * m for x, m in self._masses())) / mass if mass else self.length / 2

    def _masses(self) -> list[tuple[float, float]]:
        return [(x, w * piece.density(x)) for piece in self.segments for x, w in zip(*piece.quadrature(0, self.length), strict=True)]

    def compliance_at(self, place: float) -> Floats:
        """Return the twist of the beam at a place per wrench there: (cause, 6, 6), symmetric and positive."""
        return self._compliances_at([place])[0]

    def _compliances_at(self, places: Sequence[float]) -> list[Floats]:
        """Return the compliances at several places, in ascending order."""
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
        """Return the tip's twist per total wrench distributed as the beam's mass (uniformly without mass): (cause, 6, 6)."""
        return self._tip_under(self._masses()) if self.mass else self.tip_under_uniform_load(0.0, self.length)

    def tip_under_uniform_load(self, low: float, high: float) -> Floats:
        """Return the tip's twist per total wrench distributed uniformly between two places: (cause, 6, 6). Equal places: a point load."""
        if high - low <= 1e-12 * self.length:
            return self._tip_under([((low + high) / 2, 1.0)])
        return self._tip_under([(x, w) for piece in self.segments for x, w in zip(*piece.quadrature(low, high), strict=True)])

    def _tip_under(self, weights: Sequence[tuple[float, float]]) -> Floats:
        """Return the tip's twist per total wrench, distributed over places with these weights."""
        found = self._compliances_at([x for x, _ in weights])
        out = sum(w * (carry_twist(self.length - x) @ c) for (x, w), c in zip(weights, found, strict=True))
        return np.asarray(out / sum(w for _, w in weights))


def carry_twist(lever: float) -> Floats:
    """Return the matrix (6, 6) from a twist here to the twist of the rigid rest of the beam `lever` (m) further along."""
    out = np.eye(6)
    out[4, 2], out[5, 1] = lever, -lever
    return out


def prism(length: float, compliances: Sequence[Floats], density: float = 0.0) -> Beam:
    """Return a prismatic beam: compliances (6, 6) per length by cause, mass per length in kg/m."""
    return Beam((uniform_segment(0.0, length, np.stack(compliances), density),))


def beam_of_compliance(compliance: Floats, length: float) -> Beam:
    """Return a beam with this compliance (6, 6) at its tip: its bending compliance varies linearly along it, all else is constant.

    Such a beam always exists, and for the compliance of a uniform beam it is that beam. It is exact under loads on its tip. The matrix does not
    determine the compliance along the beam: for a cone that narrows to 0.8, 0.7, 0.5 the computed sag under its own weight is 3, 7, 30 % too small.
    """
    lever = -skew(_ALONG)
    turns, mixed, moves = compliance[:3, :3], compliance[3:, :3], compliance[3:, 3:]
    first = turns * (length / 2)  # integral along the beam of the bending compliance times the distance from the tip
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
    """Return the compliance matrix (6, 6) of a cantilever's tip: twist = C wrench, in beam axes; rad, m per N m, N.

    l/(E I), l^2/(2 E I), l^3/(3 E I) + l/(k G A), l/(G J), l/(E A). Length 0 returns zero. Symmetric and positive (reciprocity).
    """
    return np.asarray(prism(length, [compliance_per_length(young, shear_modulus, section)]).compliance_at(length)[0])
