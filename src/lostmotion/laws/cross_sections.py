"""Cross-sections of beams: areas, second moments, torsion constants and shear factors, with their
compliance and thermal strain per length.

Source: W. Young, R. Budynas, Roark's Formulas for Stress and Strain, 7th ed., table 10.1 (torsion);
shear factors G. Cowper, J. Appl. Mech. 33 (1966) 335.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Number of terms of the series for the torsion of a rectangle; they decrease with the fifth power.
_TORSION_TERMS: Final = 12
# Contributions of a sharp corner of a strip of width 1, beyond its arms. The first is exact, the
# others are extrapolated from finite differences.
_CORNER_CAPACITY: Final = 1 - 2 * math.log(2) / math.pi
_CORNER_SLOPE: Final = 0.14483
_CORNER_MEMBRANE: Final = 0.2029


@dataclass(frozen=True, slots=True)
class SectionValues:
    """Properties of a cross-section. The axis of the beam runs through the centroid.

    area, i_y, i_z      m^2; second moments of area about y and z, m^4
    torsion             torsion constant, m^4
    shear_y, shear_z    shear factors k along y and z: effective shear area over area
    i_yz, shear_yz      product of inertia (integral of y z), m^4, and coupling of shear along z and
                        y, in units of 1/(G A); zero with symmetry
    centre_y, centre_z  position of the shear centre from the centroid, m
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
    """Return the properties of a round bar (inner = 0) or tube of these diameters (m). Shear factor
    from Cowper; the torsion constant is exact.
    """
    area = math.pi / 4 * (outer**2 - inner**2)
    second = math.pi / 64 * (outer**4 - inner**4)
    m2 = (inner / outer) ** 2
    shear = 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)
    return SectionValues(area, second, second, 2 * second, shear, shear)


def rectangle_section(width: float, height: float, nu: float) -> SectionValues:
    """Return the properties of a solid rectangular bar, width along y and height along z (m).
    Torsion by Saint-Venant's series, to 1e-6.
    """
    area = width * height
    long, short = max(width, height), min(width, height)
    series = sum(
        math.tanh(n * math.pi * long / (2 * short)) / n**5 for n in range(1, 2 * _TORSION_TERMS, 2)
    )
    torsion = long * short**3 / 3 * (1 - 192 / math.pi**5 * short / long * series)
    shear = 10 * (1 + nu) / (12 + 11 * nu)
    return SectionValues(
        area, width * height**3 / 12, height * width**3 / 12, torsion, shear, shear
    )


def box_section(width: float, height: float, wall: float, nu: float) -> SectionValues:
    """Return the properties of a rectangular tube, width along y, height along z and wall thickness
    (m).

    Torsion by Prandtl's membrane analogy, with straight walls and four sharp corners. The
    contributions of each corner (capacity 1 - 2 ln 2/pi, volumes under the unit slope and under the
    wall's own membrane) are those of a single corner with long arms. The error is below 0.1 % where
    the hole is at least as wide as the wall is thick, otherwise below 3 %. Shear factor for thin
    walls.
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
    return SectionValues(
        area, i_y, i_z, torsion, _box_shear(mid_h, mid_w, nu), _box_shear(mid_w, mid_h, nu)
    )


def _box_shear(flange: float, web: float, nu: float) -> float:
    m = flange / web  # all walls have the same thickness
    upper = 10 * (1 + nu) * (1 + 3 * m) ** 2
    lower = (
        12
        + 72 * m
        + 150 * m**2
        + 90 * m**3
        + nu * (11 + 66 * m + 135 * m**2 + 90 * m**3)
        + 10 * m**3 * (3 + nu + 3 * m)
    )
    return upper / lower


def i_section(width: float, height: float, web: float, flange: float, nu: float) -> SectionValues:
    """Return the properties of an I-section with sharp corners (m): flanges of `width` along y,
    `height` along z, thickness of `web` and `flange`.

    Torsion with free warping from F. El Darwish and B. Johnston, J. Struct. Div. ASCE 91 (1965)
    203. The shear factor along the web is Cowper's for thin walls; that along the flanges treats
    them as rectangular bars.
    """
    inside = height - 2 * flange
    area = 2 * width * flange + inside * web
    i_y = (width * height**3 - (width - web) * inside**3) / 12
    i_z = (2 * flange * width**3 + inside * web**3) / 12
    thin = web / flange
    junction = -0.042 + 0.2204 * thin - 0.0725 * thin**2
    # the largest circle in the junction of web and flange, no fillet
    circle = flange + web**2 / (4 * flange)
    torsion = (
        2 / 3 * width * flange**3
        + inside * web**3 / 3
        + 2 * junction * circle**4
        - 0.42 * flange**4
    )
    mid = height - flange
    m, n = 2 * width * flange / (mid * web), width / mid
    lower = 12 + 72 * m + 150 * m**2 + 90 * m**3 + nu * (11 + 66 * m + 135 * m**2 + 90 * m**3)
    lower += 30 * n**2 * (m + m**2) + 5 * nu * n**2 * (8 * m + 9 * m**2)
    shear_z = 10 * (1 + nu) * (1 + 3 * m) ** 2 / lower
    shear_y = 10 * (1 + nu) / (12 + 11 * nu) * 2 * width * flange / area
    return SectionValues(area, i_y, i_z, torsion, shear_y, shear_z)


def compliance_per_length(young: float, shear_modulus: float, section: SectionValues) -> Floats:
    """Return the compliance of a section (6, 6): from (moment, force), N m and N, to (twist per
    length, curvatures, axial and shear strains).

    young, shear_modulus (Pa). A force that does not pass through the shear centre also twists the
    section.
    """
    out = np.zeros((6, 6))
    out[1:3, 1:3] = np.linalg.inv(
        young * np.array([[section.i_y, -section.i_yz], [-section.i_yz, section.i_z]])
    )
    out[3, 3] = 1 / (young * section.area)
    shears = np.array(
        [[1 / section.shear_y, section.shear_yz], [section.shear_yz, 1 / section.shear_z]]
    )
    out[4:, 4:] = shears / (shear_modulus * section.area)
    about_centre = np.array([1.0, 0, 0, 0, section.centre_z, -section.centre_y])
    return out + np.outer(about_centre, about_centre) / (shear_modulus * section.torsion)


def parallel_layers(compliances: Floats) -> Floats:
    """Return the contribution of each layer (layer, 6, 6) to the compliance of a layered section,
    from the layers' own compliances (layer, 6, 6).

    The contributions add up to the compliance of the section. The layers bend, twist and stretch
    together, so their stiffnesses add (transformed section). Exact in bending and tension of
    concentric layers and in torsion of round ones. Contribution k is the derivative of the
    compliance of the section with respect to the relative compliance of layer k.
    """
    stiff = np.linalg.inv(compliances)
    whole = np.linalg.inv(stiff.sum(axis=0))
    return np.asarray(whole @ stiff @ whole)


def beside_axis(compliance: Floats, height: float) -> Floats:
    """Return the compliance (6, 6) about the axis of the beam of a layer whose centroid lies
    `height` (m, along z) above it; Steiner's theorem.
    """
    to_axis = np.eye(6)
    to_axis[3, 1], to_axis[4, 0] = -height, height
    return np.asarray(to_axis @ compliance @ to_axis.T)


def thermal_strain(expansion: float, height: float) -> Floats:
    """Return the free strain (6, 2) of a section: per kelvin of temperature rise, and per kelvin of
    difference over its `height` (m, along z).

    Expansion in 1/K. The difference is linear along z and zero on the axis: the section bends by
    the curvature expansion x difference / height, with the hot side outside, without stress.
    Source: B. Boley, J. Weiner, Theory of Thermal Stresses, 1960, ch. 10.
    """
    out = np.zeros((6, 2))
    out[3, 0], out[1, 1] = expansion, expansion / height
    return out


def layered_strain(compliances: Floats, strains: Floats) -> Floats:
    """Return the strain (6, case) of a section without load whose bonded layers would take
    `strains` (layer, 6, case) if they were free.

    compliances (layer, 6, 6) of the layers about the axis of the beam. Two layers on each other are
    S. Timoshenko's bimetal, J. Opt. Soc. Am. 11 (1925) 233.
    """
    stiff = np.linalg.inv(compliances)
    return np.asarray(np.linalg.solve(stiff.sum(axis=0), (stiff @ strains).sum(axis=0)))


def no_strain(_: float) -> Floats:
    """Return the thermal strain (6, 2) of a section whose expansion is not known: NaN."""
    return np.full((6, 2), np.nan)
