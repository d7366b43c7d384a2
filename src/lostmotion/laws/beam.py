"""Elastic beams: cross-sections, and what the tip of a cantilever does under loads.

Beam axes: x along the beam from the clamped end, y and z across it. Twists and wrenches are (angular, linear) at the tip.
Source: S. Timoshenko, Strength of Materials, vol. 1 (deflection with shear); W. Young, R. Budynas, Roark's Formulas for Stress and
Strain, 7th ed., tables 8.1 (beams) and 10.1 (torsion); shear factors G. Cowper, J. Appl. Mech. 33 (1966) 335. Valid for small
deflections of straight prismatic beams, linear material; closed thin or thick round tubes, rectangles and rectangular boxes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


@dataclass(frozen=True, slots=True)
class SectionValues:
    """What a cross-section gives a beam: area m^2, second moments about y and z m^4, torsion constant m^4, shear factors."""

    area: float
    i_y: float
    i_z: float
    torsion: float
    shear_y: float
    shear_z: float


def round_section(outer: float, inner: float, nu: float) -> SectionValues:
    """What does a round bar (inner = 0) or tube of these diameters (m) give? Shear factor after Cowper, exact torsion."""
    area = math.pi / 4 * (outer**2 - inner**2)
    second = math.pi / 64 * (outer**4 - inner**4)
    m2 = (inner / outer) ** 2
    shear = 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)
    return SectionValues(area, second, second, 2 * second, shear, shear)


def rectangle_section(width: float, height: float, nu: float) -> SectionValues:
    """What does a solid bar, width along y and height along z (m), give? Torsion by Roark's formula, within 0.5 % of exact."""
    area = width * height
    long, short = max(width, height) / 2, min(width, height) / 2
    torsion = long * short**3 * (16 / 3 - 3.36 * short / long * (1 - short**4 / (12 * long**4)))
    shear = 10 * (1 + nu) / (12 + 11 * nu)
    return SectionValues(area, width * height**3 / 12, height * width**3 / 12, torsion, shear, shear)


def box_section(width: float, height: float, wall: float, nu: float) -> SectionValues:
    """What does a rectangular tube, width along y and height along z (m), give?

    Torsion after Bredt with the wall's own part (EN 10210-2, annex A, sharp corners): within 7 % of exact whatever the wall. Shear
    factor for thin walls.
    """
    inner_w, inner_h = width - 2 * wall, height - 2 * wall
    area = width * height - inner_w * inner_h
    i_y = (width * height**3 - inner_w * inner_h**3) / 12
    i_z = (height * width**3 - inner_h * inner_w**3) / 12
    mid_w, mid_h = width - wall, height - wall
    torsion = 2 * wall * (mid_w * mid_h) ** 2 / (mid_w + mid_h) + 2 * (mid_w + mid_h) * wall**3 / 3
    # Cowper's thin-walled box; b is the flange across the force, h the web along it
    return SectionValues(area, i_y, i_z, torsion, _box_shear(mid_h, mid_w, nu), _box_shear(mid_w, mid_h, nu))


def _box_shear(flange: float, web: float, nu: float) -> float:
    m = flange / web  # equal walls all round
    upper = 10 * (1 + nu) * (1 + 3 * m) ** 2
    lower = 12 + 72 * m + 150 * m**2 + 90 * m**3 + nu * (11 + 66 * m + 135 * m**2 + 90 * m**3) + 10 * m**3 * (3 + nu + 3 * m)
    return upper / lower


def tip_compliance(length: float, young: float, shear_modulus: float, section: SectionValues) -> Floats:
    """How does a cantilever's tip move under a wrench at the tip? Matrix (6, 6): twist = C wrench, in beam axes; rad, m per N m, N.

    Timoshenko beam. Length 0 gives zero. Symmetric and positive (reciprocity).
    """
    bend_y, bend_z = young * section.i_y, young * section.i_z
    out = np.zeros((6, 6))
    out[0, 0] = length / (shear_modulus * section.torsion)
    out[3, 3] = length / (young * section.area)
    out[1, 1] = length / bend_y
    out[2, 2] = length / bend_z
    out[4, 4] = length**3 / (3 * bend_z) + length / (section.shear_y * shear_modulus * section.area)
    out[5, 5] = length**3 / (3 * bend_y) + length / (section.shear_z * shear_modulus * section.area)
    # A force along +z turns the tip about -y; a force along +y turns it about +z.
    out[1, 5] = out[5, 1] = -(length**2) / (2 * bend_y)
    out[2, 4] = out[4, 2] = length**2 / (2 * bend_z)
    return out


def tip_under_own_weight(length: float, young: float, shear_modulus: float, section: SectionValues) -> Floats:
    """How does the tip move under a uniform load? Matrix (6, 3): twist = C w, w the load per length (N/m) in beam axes.

    Slope w l^3/(6 E I), deflection w l^4/(8 E I) + w l^2/(2 k G A), stretch w l^2/(2 E A).
    """
    bend_y, bend_z = young * section.i_y, young * section.i_z
    out = np.zeros((6, 3))
    out[3, 0] = length**2 / (2 * young * section.area)
    out[4, 1] = length**4 / (8 * bend_z) + length**2 / (2 * section.shear_y * shear_modulus * section.area)
    out[5, 2] = length**4 / (8 * bend_y) + length**2 / (2 * section.shear_z * shear_modulus * section.area)
    out[2, 1] = length**3 / (6 * bend_z)
    out[1, 2] = -(length**3) / (6 * bend_y)
    return out
