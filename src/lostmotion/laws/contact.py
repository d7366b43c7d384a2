"""Line contact of two elastic cylinders: half-width, pressure and approach under load; bending of
pins and lobes.

Half-width and pressure are Hertz's, exact for a/Req << 1. The approach of a line contact is not a
property of the contact alone: it depends on the depth of the bodies that is included. Two laws are
in use, Johnson's and Palmgren's, which differ by about +-15 % for steel lobes and rollers under
usual loads. Valid for dry, smooth, elastic bodies that are wide compared with the half-width of the
contact.

Source: K. Johnson, Contact Mechanics, 1985, sections 4.2 and 5.6; A. Palmgren, Grundlagen der
Wälzlagertechnik, 1957, as in T. Harris, Rolling Bearing Analysis, 4th ed., eq. (6.54).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

PALMGREN_EXPONENT: Final = 0.9
# 3.84e-5 mm per N^0.9 mm^-0.8, in metres and newtons
_PALMGREN: Final = 3.84e-5 * 1e-3 * 1e3**-0.8
# Smallest ln(B/F) of Johnson's law. There the half-width is 0.89 Req; beyond it the approach would
# decrease with the force.
LEAST_LOGARITHM: Final = 2.0


def equivalent_modulus(young: float, nu: float, other_young: float, other_nu: float) -> float:
    """Return the equivalent modulus E* (Pa) of two bodies: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2,
    plane strain. Infinite E means rigid.

    Raises ValueError where both are rigid or a value is impossible.
    """
    if not (young > 0 and other_young > 0 and -1 < nu <= 0.5 and -1 < other_nu <= 0.5):  # noqa: PLR2004 - incompressible
        raise ValueError(
            "Young's moduli must be positive and Poisson's ratios within -1..0.5, not "
            f"{young}, {nu} and {other_young}, {other_nu}"
        )
    soft = (1 - nu**2) / young + (1 - other_nu**2) / other_young
    if soft == 0:
        raise ValueError("one of the two bodies must be elastic: both moduli are infinite")
    return 1 / soft


def peak_pressure(load: Floats, radius: Floats, modulus: float) -> Floats:
    """Return the pressure p_H (Pa) at the centre of a line contact: sqrt(p E*/(pi Req)). Johnson
    (4.45).

    load p (N/m) per width and equivalent radius Req (m), of shapes that broadcast; modulus E* (Pa).
    """
    return np.asarray(np.sqrt(np.asarray(load) * modulus / (math.pi * np.asarray(radius))))


def johnson_scale(width: float, radius: Floats, modulus: float) -> Floats:
    """Return the force B (N) in Johnson's law of approach, delta = F/(pi E* b) ln(B/F): B = 4 pi E*
    b Req/exp(1).

    width b and equivalent radius Req (m), modulus E* (Pa). The approach is that of points at a
    depth of about 1.5 Req in each body. Valid for any material, up to a/Req = 0.89, where ln(B/F) =
    2.
    """
    return np.asarray(4 * math.pi * modulus * width * np.asarray(radius) / math.e)


def palmgren_factor(width: float) -> float:
    """Return the factor A (m/N^0.9) in Palmgren's law of approach, delta = A F^0.9, for a width b
    (m): 3.84e-5/b^0.8 in N and mm.

    Measured on steel rollers on raceways; it does not depend on radius and modulus.
    """
    return float(_PALMGREN * width**-0.8)


def round_bar_compliance(
    span: float,
    diameter: float,
    young: float,
    nu: float,
    ends: Literal["supported", "clamped"] = "supported",
) -> float:
    """Return the mean deflection (m/N) of a round pin over its span under a force distributed
    uniformly along it.

    span, diameter (m), young (Pa). Bending l^3/(120 E I) with supported ends or l^3/(720 E I) with
    clamped ends, plus shear l/(12 k G A) with Cowper's k. Not for a pin in a half-round seat over
    its whole length, which does not bend.
    """
    second, area = math.pi * diameter**4 / 64, math.pi * diameter**2 / 4
    shear = 6 * (1 + nu) / (7 + 6 * nu) * young / (2 + 2 * nu) * area
    return span**3 / ((120 if ends == "supported" else 720) * young * second) + span / (12 * shear)


def lobe_compliance(height: float, root: float, width: float, young: float, nu: float) -> float:
    """Return the deflection (m/N) of a lobe that is integral with the ring, as a short rectangular
    cantilever: h^3/(3 E I) + h/(k G A).

    `height` (m) of the force above the root, `root` (m) thickness there, `width` (m) along the
    axis, `young` (Pa). The compliance of the ring at the root is not included.
    """
    shear = 10 * (1 + nu) / (12 + 11 * nu) * young / (2 + 2 * nu) * root * width
    return height**3 / (3 * young * width * root**3 / 12) + height / shear
