"""Rolling bearings under radial load: every ball or roller is a unilateral spring behind half of
the clearance.

The load on an element at the angle psi from the load's direction is K (dr cos psi - G/2)^n, zero
where that is negative; n = 3/2 for balls (Hertz's point contact), 10/9 for rollers (Palmgren's line
contact). So a bearing has a dead band followed by a hardening spring, and no single stiffness.
Valid for rigid rings, low speed, and dry, elastic contacts.

Source: T. Harris, Rolling Bearing Analysis, 4th ed., 2001, chapters 2, 6 and 7; elliptic integrals
after H. Hertz, 1881.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.contact import PALMGREN_EXPONENT, palmgren_factor, peak_pressure

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

BALL_EXPONENT: Final = 3 / 2
ROLLER_EXPONENT: Final = 1 / PALMGREN_EXPONENT
BEARING_STEEL: Final = (207.5e9, 0.3)  # Pa, -

_ITERATIONS: Final = 200
_CONVERGED: Final = 1e-11
_ROUNDING: Final = 1e-14


def point_stiffness(curvature: float, difference: float, modulus: float) -> float:
    """Return K (N/m^1.5) of an elliptic point contact, Q = K delta^1.5.

    curvature   sum of the four principal curvatures of the two bodies, 1/m, concave ones negative;
                positive
    difference  F(rho), 0..1: relative difference between the sums of curvatures in the two
                principal planes
    modulus     E*, Pa: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2

    Exact for contacts small compared with the bodies. Source: Harris, eqs. (6.23)-(6.40). Raises
    ValueError for impossible curvatures.
    """
    if not (curvature > 0 and 0 <= difference < 1 and modulus > 0):
        raise ValueError(
            "a point contact needs a sum of curvatures above zero, a difference within 0..1 "
            "and a modulus above zero"
        )
    ratio, first, second = _ellipse(difference)
    shape = 2 * first / math.pi * (math.pi / (2 * ratio**2 * second)) ** (1 / 3)
    # delta = shape [3 Q/(2 sum E*)]^(2/3) sum/2
    return float((2 / (shape * curvature)) ** 1.5 * 2 * curvature * modulus / 3)


def _ellipse(difference: float) -> tuple[float, float, float]:
    """Return the ratio of the axes of an elliptic contact, and the complete elliptic integrals K
    and E of that ratio.
    """
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipk

    def excess(ratio: float) -> float:
        first, second = ellipk(1 - ratio**-2), ellipe(1 - ratio**-2)
        return float(((ratio**2 + 1) * second - 2 * first) - difference * (ratio**2 - 1) * second)

    ratio = 1.0
    if difference > 1e-9:  # noqa: PLR2004 - a circular contact, within rounding
        high = 2.0
        while excess(high) < 0:
            high *= 2
        low = 1 + 0.5 * difference  # the ratio starts as 1 + 2/3 F and rises faster
        ratio = float(brentq(excess, low, high, xtol=1e-13, rtol=1e-13))
    return ratio, float(ellipk(1 - ratio**-2)), float(ellipe(1 - ratio**-2))


def point_pressure(
    load: Floats | float, curvature: float, difference: float, modulus: float
) -> Floats:
    """Return the pressure (Pa) at the centre of an elliptic point contact under loads (any shape,
    N): 3 Q/(2 pi a b).

    Arguments and validity as `point_stiffness`, with b the shorter half axis, a = ratio b and a^3 =
    3 ratio^2 E(ratio) Q/(pi E* sum). Source: H. Hertz, as in K. Johnson, Contact Mechanics, chapter
    4; for a ball on a plane it is (6 Q E*^2/(pi^3 R^2))^(1/3).
    """
    ratio, _, second = _ellipse(difference)
    force = np.asarray(load, dtype=float)
    longer = np.cbrt(3 * ratio**2 * second * force / (math.pi * modulus * curvature))
    return np.asarray(
        np.divide(
            1.5 * force * ratio, math.pi * longer**2, out=np.zeros_like(force), where=longer > 0
        )
    )


def ball_pressure(
    load: Floats | float,
    ball: float,
    pitch: float,
    inner_groove: float = 0.52,
    angle: float = 0.0,
    material: tuple[float, float] = BEARING_STEEL,
) -> Floats:
    """Return the largest pressure (Pa) between balls under these loads (N) and the inner race.
    Arguments as `ball_stiffness`.
    """
    gamma = ball * math.cos(angle) / pitch
    across = 2 * gamma / (1 - gamma)
    total = 4 - 1 / inner_groove + across
    young, poisson = material
    return point_pressure(
        load, total / ball, abs(1 / inner_groove + across) / total, young / (2 * (1 - poisson**2))
    )


def roller_pressure(
    load: Floats | float,
    length: float,
    roller: float,
    pitch: float,
    angle: float = 0.0,
    material: tuple[float, float] = BEARING_STEEL,
) -> Floats:
    """Return the pressure (Pa) between rollers under these loads (N) and the inner race, uniform
    over their effective length (m).

    The stress concentration at the ends of a tilted roller is not included. `roller` and `pitch`
    diameter m, `angle` of contact rad, `material` (E, nu).
    """
    gamma = roller * math.cos(angle) / pitch
    young, poisson = material
    return peak_pressure(
        np.asarray(load, dtype=float) / length,
        np.asarray(roller * (1 - gamma) / 2),
        young / (2 * (1 - poisson**2)),
    )


def ball_stiffness(
    ball: float,
    pitch: float,
    inner_groove: float = 0.52,
    outer_groove: float = 0.52,
    angle: float = 0.0,
    material: tuple[float, float] = BEARING_STEEL,
) -> float:
    """Return K (N/m^1.5) of a ball between its two races, Q = K delta^1.5.

    ball, pitch                 diameters, m
    inner_groove, outer_groove  groove radius over ball diameter, above 0.5; usually 0.515 to 0.53
    angle                       contact angle, rad
    material                    Young's modulus, Pa, and Poisson's ratio of balls and rings

    Source: Harris, eqs. (2.28)-(2.31), (7.4). Raises ValueError for a groove narrower than its
    ball, or balls larger than the pitch diameter.
    """
    gamma = ball * math.cos(angle) / pitch
    if not (min(inner_groove, outer_groove) > 0.5 and 0 < gamma < 1):  # noqa: PLR2004 - the ball's own radius
        raise ValueError(
            "groove radii above half the ball's diameter and a ball smaller than the pitch "
            "diameter are needed"
        )
    young, poisson = material
    modulus = young / (2 * (1 - poisson**2))
    compliance = 0.0
    for groove, across in (
        (inner_groove, 2 * gamma / (1 - gamma)),
        (outer_groove, -2 * gamma / (1 + gamma)),
    ):
        total = 4 - 1 / groove + across
        compliance += point_stiffness(total / ball, abs(1 / groove + across) / total, modulus) ** (
            -1 / BALL_EXPONENT
        )
    return float(compliance**-BALL_EXPONENT)


def roller_stiffness(length: float) -> float:
    """Return K (N/m^(10/9)) of a steel roller of this effective length (m) between its two races, Q
    = K delta^(10/9).

    Palmgren's approach of 3.84e-5 Q^0.9/l^0.8 (N, mm) at each race. It is 4 % stiffer than by the
    35 948 N/mm^(10/9) of ISO/TS 16281, which other makers use.
    """
    return float((2 * palmgren_factor(length)) ** -ROLLER_EXPONENT)


def element_angles(count: int, first: float = 0.0) -> Floats:
    """Return the angles (count,), rad, of evenly spaced elements, the first of them at `first`."""
    return first + 2 * math.pi * np.arange(count) / count


def radial_shift(
    load: Floats | float,
    clearance: Floats | float,
    stiffness: float,
    exponent: float,
    angles: Floats,
) -> Floats:
    """Return the displacement dr (m) of the inner ring from the centre of its clearance under a
    radial load.

    load       N, zero or more, any shape
    clearance  G, diametral, m, of a shape that broadcasts with the load; negative for preload
    stiffness  K of one element (`ball_stiffness`, `roller_stiffness`), with its exponent n
    angles     (element,) from the direction of the load, rad

    Solves: sum over elements of K (dr cos psi - G/2)^n cos psi = load. The ring moves through the
    clearance without resistance, so any load displaces it by more than G/2; without load it is at
    the centre, dr = 0. Lateral forces of elements that are not symmetric about the load are
    neglected. Raises ValueError for a negative load or elements that cannot support it,
    DidNotConvergeError where no balance to 1e-11 of the load is found.
    """
    force, play = np.broadcast_arrays(
        np.asarray(load, dtype=float), np.asarray(clearance, dtype=float)
    )
    cosine = np.cos(angles)
    if not (force >= 0).all() or not cosine.max(initial=-1.0) > 1e-6:  # noqa: PLR2004 - an element at a right angle to the load supports none of it
        raise ValueError("a load of zero or more is needed, and an element on its side")

    # Displacements are measured from the edge of the clearance, or from the centre of a preloaded
    # bearing, for accuracy where they are small.
    edge = np.maximum(play, 0.0) / 2

    def imbalance(beyond: Floats) -> tuple[Floats, Floats, Floats]:
        approach = np.maximum(
            beyond[..., None] * cosine
            - (edge[..., None] * (1 - cosine) + np.minimum(play, 0.0)[..., None] / 2),
            0.0,
        )
        each = stiffness * approach**exponent
        slope = np.divide(exponent * each, approach, out=np.zeros_like(each), where=approach > 0)
        # Preload forces that balance each other leave rounding that does not depend on the load.
        rounding = _ROUNDING * each.sum(axis=-1)
        return each @ cosine - force, slope @ cosine**2, rounding

    low = np.zeros_like(force)
    high = (force / stiffness) ** (1 / exponent) + np.abs(play) + 1e-12
    for _ in range(_ITERATIONS):
        short = imbalance(high)[0] < 0
        if not short.any():
            break
        high = np.where(short, 2 * high, high)
    beyond = high
    for _ in range(_ITERATIONS):
        over, slope, rounding = imbalance(beyond)
        settled = (np.abs(over) <= _CONVERGED * force + rounding) | (force == 0)
        if settled.all():
            return np.where(force > 0, beyond + edge, 0.0)
        low, high = np.where(over < 0, beyond, low), np.where(over >= 0, beyond, high)
        newton = beyond - over / np.where(slope > 0, slope, 1.0)
        beyond = np.where((slope > 0) & (newton > low) & (newton < high), newton, (low + high) / 2)
    raise DidNotConvergeError(
        f"no radial shift of the bearing balances its load ({np.count_nonzero(~settled)} of "
        f"{settled.size} cases)"
    )
