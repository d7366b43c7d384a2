"""Geometry of a cycloidal stage: profile, curvature, contact arms, gaps, play and the first-order
effect of every error.

Symbols of the literature: R radius of the pin circle, Rr of a pin (or lobe), e eccentricity, N
number of pins, z = N - 1 lobes of the disc, K1 = e N/R. The angle theta of a pin is measured from
the line of centres about the centre of the pin circle. All wheels are rigid and centred here; for
their deformation see `cycloid.contact`. "Planet" is the wheel on the eccentric: the disc, or the
wheel with the pins in a stage with planet pins.

Source: F. Litvin, P. Feng, Computerized design and generation of cycloidal gearings, Mech. Mach.
Theory 31 (1996) 891; M. Lehmann, Berechnung und Messung der Kräfte in einem
Zykloiden-Kurvenscheiben-Getriebe, TU München 1976 (arms, forces); modified profiles and play from
the same arms.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.laws.cycloid.stage import Modification, Stage, undercut_limit

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


# Smallest arm, over the longest, of flanks that limit the play. Flanks with a shorter one push the
# planet aside rather than stop it.
_SHORT_ARM: Final = 0.1


def smallest_convex_radius(stage: Stage) -> float:
    """Return the smallest convex radius of curvature (m) of the toothed wheel's flank: that of the
    locus less Rr. Positive without undercut.
    """
    return (
        undercut_limit(
            stage.ring_radius, stage.eccentricity, stage.pins, planet_pins=stage.has_planet_pins
        )
        - stage.pin_radius
    )


def valley_radius(stage: Stage) -> float:
    """Return the radius of curvature (m) of the locus in the valley: R (1-K1)^2/(N K1 - 1), planet
    pins N K1 + 1; infinite if not concave.
    """
    k1 = stage.shortening
    bend = stage.pins * k1 + (1 if stage.has_planet_pins else -1)
    return stage.ring_radius * (1 - k1) ** 2 / bend if bend > 0 else math.inf


def pitch_distance(stage: Stage, theta: Floats) -> Floats:
    """Return the distance of the pin centre at theta (rad) from the pitch point, over R: D = sqrt(1
    + K1^2 - 2 K1 cos theta).
    """
    k1 = stage.shortening
    # As a sum of squares, for accuracy near theta = 0.
    return np.asarray(np.sqrt((1 - k1) ** 2 + 4 * k1 * np.sin(np.asarray(theta) / 2) ** 2))


def curvature(stage: Stage, theta: Floats) -> Floats:
    """Return the curvature (1/m) of the locus of pin centres at theta (rad); positive where it is
    curved towards the wheel's centre.
    """
    k1, m = stage.shortening, stage._m  # noqa: SLF001 - this module's own class
    return np.asarray(
        (1 + m * k1**2 - (m + 1) * k1 * np.cos(theta))
        / (stage.ring_radius * pitch_distance(stage, theta) ** 3)
    )


def contact_radius(stage: Stage, theta: Floats) -> Floats:
    """Return the equivalent radius (m) of the contact at theta (rad), 1/Req = 1/Rr +- 1/rho: Rr (1
    - Rr kappa), planet pins Rr (1 + Rr kappa).
    """
    sign = 1 if stage.has_planet_pins else -1
    return np.asarray(stage.pin_radius * (1 + sign * stage.pin_radius * curvature(stage, theta)))


def flank(stage: Stage, t: Floats, relief: Modification | None = None) -> tuple[Floats, Floats]:
    """Return points and unit normals of the toothed wheel's flank at parameters t (any shape, rad;
    2 pi is once round the wheel).

    Points (..., 2), m, and unit normals (..., 2) towards the centres of the touching pins, in the
    wheel's own frame; a valley is at t = 0. The normals are those before any `turn`, which moves
    the two flanks of a tooth towards each other: they intersect before the tip and leave a step at
    the bottom of the valley. The profile is the offset curve of a trochoid, Litvin and Feng (1996).
    """
    relief = relief or Modification()
    t = np.asarray(t, dtype=float)
    out = 1 if stage.has_planet_pins else -1
    m, radius = stage._m, stage.ring_radius + out * relief.circle  # noqa: SLF001
    k1 = stage.eccentricity * stage.pins / radius
    direction = np.exp(1j * t) - k1 * np.exp(1j * m * t)
    normal = direction / np.abs(direction)
    locus = radius * np.exp(1j * t) + out * stage.eccentricity * np.exp(1j * m * t)
    points = locus + out * (stage.pin_radius + relief.roller) * normal
    points = points * np.exp(1j * relief.turn * np.sign(np.sin(stage.lobes * t)))
    return _plane(points), _plane(-out * normal)


def _plane(values: np.ndarray[tuple[int, ...], np.dtype[np.complex128]]) -> Floats:
    return np.stack([values.real, values.imag], axis=-1)


def pin_angles(stage: Stage, crank: Floats) -> Floats:
    """Return the angles theta (crank, N), rad, of the pins from the line of centres, in -pi..pi,
    for crank angles psi (crank,), rad.

    Pins in the ring are fixed: theta = 2 pi k/N - psi. Planet pins turn with the planet: theta = 2
    pi k/N - psi (N + 1)/N.
    """
    sweep = np.asarray(crank, dtype=float) * (
        stage.lobes / stage.pins if stage.has_planet_pins else 1.0
    )
    theta = 2 * math.pi / stage.pins * np.arange(stage.pins) - sweep[..., None]
    return np.asarray(theta - 2 * math.pi * np.round(theta / (2 * math.pi)))


def planet_pose(stage: Stage, crank: Floats) -> tuple[Floats, Floats]:
    """Return the centre (..., 2), m, and the rotation (...,), rad, of the planet at crank angles
    psi (...,), rad, with the ring fixed.

    The centre is at e (cos psi, sin psi), and the rotation is -psi over its own number of teeth:
    -psi/z, with planet pins -psi/N.
    """
    crank = np.asarray(crank, dtype=float)
    return _plane(stage.eccentricity * np.exp(1j * crank)), -crank / (
        stage.pins if stage.has_planet_pins else stage.lobes
    )


def normals(stage: Stage, theta: Floats) -> Floats:
    """Return the direction (..., 2), along and across the line of centres, of the force of the
    planet on the ring at theta (rad).

    It is (cos theta - K1, sin theta)/D: all lines of action pass through the pitch point.
    """
    root = pitch_distance(stage, theta)
    return np.stack([(np.cos(theta) - stage.shortening) / root, np.sin(theta) / root], axis=-1)


def arms(stage: Stage, theta: Floats) -> Floats:
    """Return the arm (m) of the contact at theta (rad) about the planet's centre: l = e z
    sin(theta)/D; its maximum e z is at cos theta = K1.
    """
    return np.asarray(stage.planet_pitch_radius * np.sin(theta) / pitch_distance(stage, theta))


def pressure_angles(stage: Stage, theta: Floats) -> Floats:
    """Return the pressure angle (rad), 0..pi/2: between the contact's normal and the velocity of
    the pin's centre about the planet's centre.

    cos alpha = |l|/(distance of the pin's centre from the planet's centre).
    """
    r, e = stage.ring_radius, 0.0 if stage.has_planet_pins else stage.eccentricity
    distance = np.sqrt(r**2 + e**2 - 2 * r * e * np.cos(theta))
    return np.asarray(np.arccos(np.minimum(np.abs(arms(stage, theta)) / distance, 1.0)))


def gaps(stage: Stage, theta: Floats, relief: Modification) -> Floats:
    """Return the gap (m) along the normal at the pin at theta (rad): g = dRr + dR (1 - K1 cos
    theta)/D + dpsi |l|.

    The arm of dpsi is about the centre of the toothed wheel: with planet pins (N + 1)/N of that
    about the planet's. Valid to first order in the modification. Where the flank is concave with a
    radius of 0.1 mm, a displacement of 10 µm is too large for that.
    """
    along = (1 - stage.shortening * np.cos(theta)) / pitch_distance(stage, theta)
    return np.asarray(
        relief.roller
        + relief.circle * along
        + relief.turn * _wheel_share(stage) * np.abs(arms(stage, theta))
    )


def _wheel_share(stage: Stage) -> float:
    """Return the ratio of arms about the toothed wheel's centre to arms about the planet's."""
    return stage.lobes / stage.pins if stage.has_planet_pins else 1.0


def gaps_from_pins(
    stage: Stage, theta: Floats, radius: Floats, radial: Floats, tangential: Floats
) -> Floats:
    """Return the change of the gaps (m) due to errors of the pins (m), as arrays that broadcast
    against theta (..., N; rad).

    radius      error of the pin radius; a larger pin narrows the gap
    radial      displacement of the pin outwards
    tangential  displacement of the pin towards larger theta

    g = -d_radius + [d_radial (1 - K1 cos theta) + d_tangential K1 sin theta]/D, with the opposite
    sign of both displacements for planet pins.
    """
    k1, root = stage.shortening, pitch_distance(stage, theta)
    shift = (radial * (1 - k1 * np.cos(theta)) + tangential * k1 * np.sin(theta)) / root
    return np.asarray((-shift if stage.has_planet_pins else shift) - radius)


def play(stage: Stage, relief: Modification) -> float:
    """Return the play (rad): the free rotation of the planet from one end to the other; negative
    where its flanks interfere.

    To first order it is 2 [dRr + dR sqrt(1-K1^2)]/(e z) + 2 dpsi, if no term adds material. With a
    larger generating pin circle, dR < 0, the flanks touch elsewhere: then it is twice the smallest
    g/l of all pin angles with an arm above a tenth of the longest. The result is the minimum over a
    turn of the crank; between pin positions the true play is 0 to 3.5 % larger for N of 14 to 16,
    less with more pins.
    """
    if relief.circle < 0:
        theta = np.linspace(0.0, math.pi, 20_001)[1:-1]
        arm = arms(stage, theta)
        far = arm > _SHORT_ARM * stage.planet_pitch_radius
        return float(2 * (gaps(stage, theta, relief)[far] / arm[far]).min())
    deepest = relief.roller + relief.circle * math.sqrt(1 - stage.shortening**2)
    return 2 * deepest / stage.planet_pitch_radius + 2 * relief.turn * _wheel_share(stage)


def first_contact_angle(stage: Stage, theta: Floats, gap: Floats, least: float = 1e-9) -> Floats:
    """Return the rotation (rad) of the unloaded planet, with its centre fixed, to the first contact
    of a flank with l > 0: min(g/l).

    theta (..., N), rad; gap (..., N), m. Flanks with arms below `least` times the largest are
    ignored: where they interfere they push the planet aside rather than stop it.
    """
    arm = arms(stage, theta)
    driving = arm > least * stage.planet_pitch_radius
    return np.asarray(np.where(driving, gap / np.where(driving, arm, 1.0), np.inf).min(axis=-1))


def ratio(stage: Stage, fixed: Literal["ring", "carrier"] = "ring") -> int:
    """Return the turns of the crank per turn of the output: -z with the ring fixed, +N with the
    carrier fixed. Planet pins: -N and N + 1.
    """
    planet, ring = (stage.pins, stage.lobes) if stage.has_planet_pins else (stage.lobes, stage.pins)
    return -planet if fixed == "ring" else ring
