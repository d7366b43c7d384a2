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
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

Kind = Literal["ring pins", "lobe arcs", "lobe envelope", "planet pins"]
Part = Literal["planet", "ring"]
_KINDS: Final = get_args(Kind)
_FEWEST: Final = 3

# Smallest arm, over the longest, of flanks that limit the play. Flanks with a shorter one push the
# planet aside rather than stop it.
_SHORT_ARM: Final = 0.1


@dataclass(frozen=True, slots=True)
class Stage:
    """A cycloidal stage.

    ring_radius   radius R of the pin circle, m
    pin_radius    radius Rr of the pins or lobes, m
    eccentricity  e, m
    pins          number N of pins
    kind          "ring pins": pins or rollers in the ring, z = N - 1 lobes on the disc. "lobe
                  arcs", "lobe envelope": integral lobes in the ring, of plain arcs or as the
                  envelope of the moving disc. "planet pins": hypocycloidal, N pins on the planet, z
                  = N + 1 lobes in the ring

    Raises ValueError with every reason why such a stage is impossible, and the nearest possible
    value.
    """

    ring_radius: float
    pin_radius: float
    eccentricity: float
    pins: int
    kind: Kind = "ring pins"

    def __post_init__(self) -> None:
        """Refuse an impossible stage, with all reasons at once."""
        wrong = list(_not_numbers(self)) or list(_impossible(self))
        if wrong:
            raise ValueError("this cycloidal stage cannot exist: " + "; ".join(wrong))

    @property
    def has_planet_pins(self) -> bool:
        """Return whether the pins are on the planet (hypocycloidal stage)."""
        return self.kind == "planet pins"

    @property
    def lobes(self) -> int:
        """Return the number of lobes of the toothed wheel: the disc, with planet pins the ring."""
        return self.pins + 1 if self.has_planet_pins else self.pins - 1

    @property
    def shortening(self) -> float:
        """Return K1 = e N/R, the shortening ratio of the trochoid."""
        return self.eccentricity * self.pins / self.ring_radius

    @property
    def planet_pitch_radius(self) -> float:
        """Return the distance (m) of the pitch point from the planet's centre: e z, with planet
        pins e N. It is also the largest contact arm.
        """
        return self.eccentricity * (self.pins if self.has_planet_pins else self.lobes)

    @property
    def ring_pitch_radius(self) -> float:
        """Return the distance (m) of the pitch point from the ring's centre: e N, with planet pins
        e z.
        """
        return self.planet_pitch_radius + self.eccentricity

    @property
    def tip_radius(self) -> float:
        """Return the outer radius (m) of the planet: R - Rr + e for a disc, R + Rr for planet
        pins.
        """
        return (
            self.ring_radius + self.pin_radius
            if self.has_planet_pins
            else self.ring_radius - self.pin_radius + self.eccentricity
        )

    @property
    def _m(self) -> int:
        # The locus is R exp(it) -+ e exp(imt). Formulas for planet pins are those of the disc with
        # -N for N.
        return -self.pins if self.has_planet_pins else self.pins


@dataclass(frozen=True, slots=True)
class Modification:
    """Profile modification of the toothed wheel. Positive values remove material.

    roller  dRr, m: a larger generating roller
    circle  dR, m: a smaller generating pin circle (with planet pins a larger one); negative for the
            opposite
    turn    dpsi, rad: both flanks of a tooth rotated about the wheel's centre towards the middle of
            the tooth
    """

    roller: float = 0.0
    circle: float = 0.0
    turn: float = 0.0


def _not_numbers(stage: Stage) -> list[str]:
    wrong = [
        f"the {name} is {value!r} m, but must be a positive length"
        for name, value in (
            ("pin circle radius", stage.ring_radius),
            ("pin radius", stage.pin_radius),
            ("eccentricity", stage.eccentricity),
        )
        if not (math.isfinite(value) and value > 0)
    ]
    if stage.pins != int(stage.pins) or stage.pins < _FEWEST:
        wrong.append(f"it has {stage.pins} pins, but needs a whole number of {_FEWEST} or more")
    if stage.kind not in _KINDS:
        wrong.append(
            f"its kind is {stage.kind!r}, but must be one of {', '.join(map(repr, _KINDS))}"
        )
    return wrong


def _mm(length: float, digits: int = 4) -> str:
    """Return a limit in mm, rounded down so that it is still possible."""
    return f"{math.floor(length * 1e3 * 10**digits) / 10**digits:.{digits}f} mm"


def _impossible(stage: Stage) -> list[str]:
    wrong = []
    k1 = stage.shortening
    if k1 >= 1:
        limit = stage.ring_radius / stage.pins
        wrong.append(
            f"the profile loops because K1 = e N/R is {k1:.4f}, not below 1: the eccentricity "
            f"must stay below {_mm(limit)}, "
            f"or the pin circle radius above {stage.eccentricity * stage.pins * 1e3:.4f} mm"
        )
    folded = 1 - 2 / stage.pins  # (z - 1)/(z + 1)
    if stage.kind == "lobe envelope" and folded <= k1 < 1:
        limit = stage.ring_radius * folded / stage.pins
        wrong.append(
            f"the second branch of the envelope folds because K1 = e N/R is {k1:.4f}, not "
            f"below (z - 1)/(z + 1) = {folded:.4f}: the eccentricity "
            f"must stay below {_mm(limit)}"
        )
    neighbours = stage.ring_radius * math.sin(math.pi / stage.pins)
    undercut = (
        math.inf
        if k1 >= 1
        else undercut_limit(
            stage.ring_radius, stage.eccentricity, stage.pins, planet_pins=stage.has_planet_pins
        )
    )
    if stage.pin_radius >= undercut:
        wrong.append(
            f"a pin radius of {stage.pin_radius * 1e3:.4f} mm undercuts the flank: the largest "
            f"possible is {_mm(min(undercut, neighbours))}"
        )
    if stage.pin_radius >= neighbours:
        wrong.append(
            "neighbouring pins overlap: the largest possible pin radius is "
            f"{_mm(min(undercut, neighbours))}"
        )
    return wrong


def undercut_limit(
    ring_radius: float, eccentricity: float, pins: int, *, planet_pins: bool = False
) -> float:
    """Return the largest pin radius (m) without undercut: the smallest radius of curvature of the
    locus on the side of the flank.

    ring_radius and eccentricity (m). Valid for K1 < 1. Closed form: with K1 > (N-2)/(2N-1) it is R
    sqrt(27 (1-K1^2)(N-1))/(N+1)^1.5, else R (1+K1)^2/(N K1 + 1); planet pins with -N for N.
    """
    k1, m = eccentricity * pins / ring_radius, -pins if planet_pins else pins
    a, b, c = 1 + m * k1**2, (m + 1) * k1, 1 + k1**2
    stationary = 3 * a / b - c / k1
    cosines = np.array([-1.0, 1.0] + ([stationary] if abs(stationary) < 1 else []))
    narrowing = (
        (-1 if planet_pins else 1)
        * (a - b * cosines)
        / (ring_radius * (c - 2 * k1 * cosines) ** 1.5)
    )
    sharpest = float(narrowing.max())
    return 1 / sharpest if sharpest > 0 else math.inf


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
