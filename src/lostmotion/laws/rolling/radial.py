"""Rolling bearings under radial load: every ball or roller is a spring that can only push, after half the clearance is closed.

The load on an element at the angle psi from the load's direction is K (dr cos psi - G/2)^n, zero where that is negative; n = 3/2 for balls (Hertz's
point contact), 10/9 for rollers (Palmgren's line contact). So a bearing is a dead band followed by a stiffening spring: never one number. Rings are
rigid, speeds low, contacts dry and elastic.

Source: T. Harris, Rolling Bearing Analysis, 4th ed., 2001, chapters 2, 6 and 7; elliptic integrals after H. Hertz, 1881.
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

    `curvature` the sum of the four curvatures of the two bodies (1/m, hollow ones negative), positive; `difference` F(rho), 0..1, the relative
    difference between the sums of the two planes; `modulus` E* (Pa), 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2. Exact for contacts small compared with
    the bodies. Source: Harris, eqs. (6.23)-(6.40). Raises ValueError for impossible curvatures.
    """
    if not (curvature > 0 and 0 <= difference < 1 and modulus > 0):
        raise ValueError("a point contact needs a sum of curvatures above zero, a difference within 0..1 and a modulus above zero")
    ratio, first, second = _ellipse(difference)
    shape = 2 * first / math.pi * (math.pi / (2 * ratio**2 * second)) ** (1 / 3)
    # delta = shape [3 Q/(2 sum E*)]^(2/3) sum/2
    return float((2 / (shape * curvature)) ** 1.5 * 2 * curvature * modulus / 3)


def _ellipse(difference: float) -> tuple[float, float, float]:
    """Return the ratio of the contact's axes and its complete elliptic integrals K and E."""
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


def point_pressure(load: Floats | float, curvature: float, difference: float, modulus: float) -> Floats:
    """Return the pressure (Pa) at the centre of an elliptic point contact under loads (any shape, N): 3 Q/(2 pi a b).

    Arguments and validity as `point_stiffness`, with b the shorter half axis, a = ratio b and a^3 = 3 ratio^2 E(ratio) Q/(pi E* sum). Source: H.
    Hertz, as in K. Johnson, Contact Mechanics, chapter 4; for a ball on a plane it is (6 Q E*^2/(pi^3 R^2))^(1/3).
    """
    ratio, _, second = _ellipse(difference)
    force = np.asarray(load, dtype=float)
    longer = np.cbrt(3 * ratio**2 * second * force / (math.pi * modulus * curvature))
    return np.asarray(np.divide(1.5 * force * ratio, math.pi * longer**2, out=np.zeros_like(force), where=longer > 0))


def ball_pressure(
    load: Floats | float, ball: float, pitch: float, inner_groove: float = 0.52, angle: float = 0.0, material: tuple[float, float] = BEARING_STEEL
) -> Floats:
    """Return the largest pressure (Pa) between balls under these loads (N) and the inner race. Arguments as `ball_stiffness`."""
    gamma = ball * math.cos(angle) / pitch
    across = 2 * gamma / (1 - gamma)
    total = 4 - 1 / inner_groove + across
    young, poisson = material
    return point_pressure(load, total / ball, abs(1 / inner_groove + across) / total, young / (2 * (1 - poisson**2)))


def roller_pressure(
    load: Floats | float, length: float, roller: float, pitch: float, angle: float = 0.0, material: tuple[float, float] = BEARING_STEEL
) -> Floats:
    """Return the pressure (Pa) between rollers under these loads (N) and the inner race, uniform over their effective length (m).

    Without the peaks at the ends of a tilted roller. `roller` and `pitch` diameter m, `angle` of contact rad.
    """
    gamma = roller * math.cos(angle) / pitch
    young, poisson = material
    return peak_pressure(np.asarray(load, dtype=float) / length, np.asarray(roller * (1 - gamma) / 2), young / (2 * (1 - poisson**2)))


def ball_stiffness(
    ball: float,
    pitch: float,
    inner_groove: float = 0.52,
    outer_groove: float = 0.52,
    angle: float = 0.0,
    material: tuple[float, float] = BEARING_STEEL,
) -> float:
    """Return K (N/m^1.5) of a ball between its two races, Q = K delta^1.5.

    `ball` and `pitch` diameter m; grooves as radius over ball diameter, above 0.5 (0.515-0.53 is usual); `angle` of contact rad; material (E, nu) of
    balls and rings. Source: Harris, eqs. (2.28)-(2.31), (7.4). Raises ValueError for a groove narrower than its ball, or balls larger than the pitch.
    """
    gamma = ball * math.cos(angle) / pitch
    if not (min(inner_groove, outer_groove) > 0.5 and 0 < gamma < 1):  # noqa: PLR2004 - the ball's own radius
        raise ValueError("groove radii above half the ball's diameter and a ball smaller than the pitch diameter are needed")
    young, poisson = material
    modulus = young / (2 * (1 - poisson**2))
    compliance = 0.0
    for groove, across in ((inner_groove, 2 * gamma / (1 - gamma)), (outer_groove, -2 * gamma / (1 + gamma))):
        total = 4 - 1 / groove + across
        compliance += point_stiffness(total / ball, abs(1 / groove + across) / total, modulus) ** (-1 / BALL_EXPONENT)
    return float(compliance**-BALL_EXPONENT)


def roller_stiffness(length: float) -> float:
    """Return K (N/m^(10/9)) of a steel roller of this effective length (m) between its two races, Q = K delta^(10/9).

    Palmgren's 3.84e-5 Q^0.9/l^0.8 (N, mm) at each race. 4 % stiffer than the 35 948 N/mm^(10/9) of ISO/TS 16281, which other makers use.
    """
    return float((2 * palmgren_factor(length)) ** -ROLLER_EXPONENT)


def element_angles(count: int, first: float = 0.0) -> Floats:
    """Return the angles (count,) of evenly spaced elements from the load's direction, the first of them at `first` (rad)."""
    return first + 2 * math.pi * np.arange(count) / count


def radial_shift(load: Floats | float, clearance: Floats | float, stiffness: float, exponent: float, angles: Floats) -> Floats:
    """Return the shift (m, shape of load and clearance together) of the inner ring from the centre of its clearance under a radial load (N, >= 0).

    Sum over elements of K (dr cos psi - G/2)^n cos psi = load. The ring crosses the clearance without resistance, so any load shifts it by more than
    G/2; without load it stays at the centre, zero. `stiffness` K, `exponent` n of one element (`ball_stiffness`, `roller_stiffness`); `angles`
    (element,) rad from the load. Lateral forces of elements that are unevenly placed about the load are ignored. Raises ValueError for a negative
    load or elements that cannot support it, DidNotConvergeError where balance to 1e-11 of the load is not found.
    """
    force, play = np.broadcast_arrays(np.asarray(load, dtype=float), np.asarray(clearance, dtype=float))
    cosine = np.cos(angles)
    if not (force >= 0).all() or not cosine.max(initial=-1.0) > 1e-6:  # noqa: PLR2004 - an element beside the load supports nothing
        raise ValueError("a load of zero or more is needed, and an element on its side")

    # Measured from the clearance's edge, or the centre of a preloaded bearing, so that small shifts keep their digits.
    edge = np.maximum(play, 0.0) / 2

    def held(beyond: Floats) -> tuple[Floats, Floats, Floats]:
        approach = np.maximum(beyond[..., None] * cosine - (edge[..., None] * (1 - cosine) + np.minimum(play, 0.0)[..., None] / 2), 0.0)
        each = stiffness * approach**exponent
        slope = np.divide(exponent * each, approach, out=np.zeros_like(each), where=approach > 0)
        # Balanced preload has rounding of its own, whatever the load.
        rounding = _ROUNDING * each.sum(axis=-1)
        return each @ cosine - force, slope @ cosine**2, rounding

    low = np.zeros_like(force)
    high = (force / stiffness) ** (1 / exponent) + np.abs(play) + 1e-12
    for _ in range(_ITERATIONS):
        short = held(high)[0] < 0
        if not short.any():
            break
        high = np.where(short, 2 * high, high)
    beyond = high
    for _ in range(_ITERATIONS):
        over, slope, rounding = held(beyond)
        settled = (np.abs(over) <= _CONVERGED * force + rounding) | (force == 0)
        if settled.all():
            return np.where(force > 0, beyond + edge, 0.0)
        low, high = np.where(over < 0, beyond, low), np.where(over >= 0, beyond, high)
        newton = beyond - over / np.where(slope > 0, slope, 1.0)
        beyond = np.where((slope > 0) & (newton > low) & (newton < high), newton, (low + high) / 2)
    raise DidNotConvergeError(f"no radial shift of the bearing balances its load ({np.count_nonzero(~settled)} of {settled.size} cases)")
