"""Contacts of the second branch of an envelope ring, which the tips of the disc cut.

The normal through a point t of the disc's flank crosses the disc's pitch circle twice. So the point
touches the ring at two crank angles: once at the arc of the pin (first branch, N contacts at any
time), and, where cos(z t) < K1, again at the second branch. Arms and gaps of a second contact are
those of a pin at the angle theta = -z t: `arms(stage, theta)`, `gaps(stage, theta, relief)`. Second
contacts stiffen the stage. Near the junction both contacts of a flank merge, so they are not
separate springs.

Valid while the second branch does not fold, K1 < (z - 1)/(z + 1), which `Stage` checks.

Source: F. Litvin, P. Feng, Mech. Mach. Theory 31 (1996) 891 (envelope with two branches). Checked
against the area swept by the disc.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.geometry import contact_radius, flank

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.spatial import Floats

    _Complexes = npt.NDArray[np.complex128]

# Range of stages on which the rule for the stiffness is within 4 % of the contact along the whole
# flank.
RULE_SHORTENING: Final = (0.40, 0.81)
RULE_PINS: Final = (14, 40)
_HALVINGS: Final = 60
_POINTS: Final = 4001


def junction(stage: Stage) -> float:
    """Return the parameter t (rad) of the second branch's beginning: cos(z t) = K1, the longest
    arm, a normal tangent to the pitch circle.
    """
    return math.acos(stage.shortening) / stage.lobes


def second_contacts(stage: Stage, crank: Floats | Sequence[float]) -> Floats:
    """Return the parameters t (crank, z), rad, of the disc's flank at the second contact of each
    lobe at crank angles (crank,), rad; NaN: none.

    A lobe has at most one second contact.
    """
    z, n = stage.lobes, stage.pins
    tip = (2 * np.arange(z) + 1) * math.pi / z
    wanted = np.asarray(crank, dtype=float)[:, None] * n / z - (math.pi - (n - 2) * tip)
    wanted -= 2 * math.pi * np.round(wanted / (2 * math.pi))
    end = math.pi / z - junction(stage)
    low, high = np.full_like(wanted, -end), np.full_like(wanted, end)
    outside = np.abs(wanted) > abs(_crossing(stage, end))
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        before = _crossing(stage, middle) > wanted  # it falls steadily
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.where(outside, np.nan, tip + (low + high) / 2)


def _crossing(stage: Stage, beyond: Floats | float) -> Floats:
    """Return the angle (rad) of the normal's second crossing of the pitch circle, relative to that
    of the tip, at a parameter beyond the tip.
    """
    return np.asarray(
        -(stage.pins - 2) * beyond
        + 2 * np.angle(1 + stage.shortening * np.exp(1j * stage.lobes * np.asarray(beyond)))
    )


def second_contact_places(stage: Stage, crank: float) -> Floats:
    """Return the points (contact, 2), m, of the ring at all second contacts at a crank angle
    (rad).
    """
    t = second_contacts(stage, [crank])[0]
    at = place_on_ring(stage, t[np.isfinite(t)], crank)
    return np.stack([at.real, at.imag], axis=-1)


def place_on_ring(stage: Stage, t: Floats, crank: Floats | float) -> _Complexes:
    """Return the places (complex, m), about the ring's centre, of points of the disc's flank at
    parameters t (rad) at crank angles (rad).
    """
    return np.asarray(
        stage.eccentricity * np.exp(1j * crank)
        + flank(stage, t)[0] @ np.array([1, 1j]) * np.exp(-1j * crank / stage.lobes)
    )


def mean_contacts(stage: Stage) -> tuple[float, float]:
    """Return the number of contacts of the first and of the second branch, averaged over a turn of
    the crank: N and N arccos(K1)/pi - 1.
    """
    return float(stage.pins), stage.pins * math.acos(stage.shortening) / math.pi - 1


def squared_arms(stage: Stage) -> tuple[float, float]:
    """Return the sum of the squared arms of the contacts that turn one way, over (e z)^2: of the
    first branch, N/4, and of the second one.

    Averaged over a turn of the crank. The second one is the integral of (sin f/D)^2 [N - 2 - 2 z K1
    (K1 - cos f)/D^2]/(2 pi) from arccos(K1) to pi.
    """
    k1, n, z = stage.shortening, stage.pins, stage.lobes
    f = np.linspace(math.acos(k1), math.pi, _POINTS)
    root = 1 + k1**2 - 2 * k1 * np.cos(f)
    density = np.sin(f) ** 2 / root * (n - 2 - 2 * z * k1 * (k1 - np.cos(f)) / root)
    return n / 4, float(np.trapezoid(density, f)) / (2 * math.pi)


def in_range_of_rule(stage: Stage) -> bool:
    """Return whether `stiffening_by_rule` is valid for this stage: K1 from 0.40 to 0.81 and 14 to
    40 lobes.
    """
    return (
        RULE_SHORTENING[0] <= round(stage.shortening, 2) <= RULE_SHORTENING[1]
        and RULE_PINS[0] <= stage.pins <= RULE_PINS[1]
    )


def stiffening_by_rule(stage: Stage) -> float:
    """Return by how many times the second branch stiffens the contacts of the first one: 1 + c
    S2/S1 with c = 1.57 - 1.3 K1.

    S1 and S2 are the `squared_arms`. The constants are fitted to the contact along the whole flank
    (`envelope_contact`, to a depth of 3 mm) of nine stages of R 34 to 100 mm, without gaps; within
    4 % of it, mostly 2 %. Raises ValueError outside of their range.
    """
    if not in_range_of_rule(stage):
        raise ValueError(
            f"K1 = {stage.shortening:.3g} with {stage.pins} lobes is outside the range of the "
            "rule for both branches, "
            f"K1 from {RULE_SHORTENING[0]:g} to {RULE_SHORTENING[1]:g} and {RULE_PINS[0]} to "
            f"{RULE_PINS[1]} lobes"
        )
    first, second = squared_arms(stage)
    return 1 + (1.57 - 1.3 * stage.shortening) * second / first


def _second_crossing(stage: Stage, t: Floats) -> tuple[_Complexes, _Complexes, _Complexes]:
    """Return points of the disc's flank at t (rad), outward normals, and where these cross the
    pitch circle a second time, in the disc's axes, m.
    """
    place, towards = (each @ np.array([1, 1j]) for each in flank(stage, t))
    first = stage.planet_pitch_radius * np.exp(1j * stage.pins * t)
    foot = place - (place * towards.conj()).real * towards  # of the chord
    return place, towards, np.asarray(2 * foot - first)


def second_radius(stage: Stage, t: Floats) -> Floats:
    """Return the equivalent radii (t,), m, of second contacts at parameters t (rad) of the disc's
    flank: large, for a hollow that nearly fits.

    After Euler and Savary 1/O2 = 1/O1 + 1/(e z N s) for the centres of curvature O1 of the disc and
    O2 of the ring, from the pitch point along the inward normal, with the cosine s between that
    normal and the line of centres. At the junction the radius is infinite.
    """
    place, towards, pitch = _second_crossing(stage, t)
    lever = stage.planet_pitch_radius
    off = ((pitch - place) * towards.conj()).real
    of_disc = 1 / contact_radius(stage, -stage.lobes * t) - 1 / stage.pin_radius
    cosine = -(towards * pitch.conj()).real / lever
    inverse = of_disc / (1 + of_disc * off) + 1 / (lever * stage.pins * cosine)
    return np.asarray(1 / (of_disc - inverse / (1 - inverse * off)))


def ring_of_second_branch(stage: Stage, t: Floats) -> Floats:
    """Return the points (t, 2), m, of the ring at the second contact of the disc's flank at t
    (rad), whose normal meets the pitch circle again.
    """
    z, n = stage.lobes, stage.pins
    other = _second_crossing(stage, t)[2]
    # other = e z exp(i psi N/z); the tip's own is pi/N
    crank = np.angle(other * np.exp(-1j * math.pi / z)) * z / n + math.pi / n
    at = place_on_ring(stage, t, crank)
    return np.stack([at.real, at.imag], axis=-1)
