"""Compliance of the output pins: a pin in elastic seats, a cage that ties the pins, needles around
a pin, and the pin in its hole.

The pin is a beam; each seat is a foundation along its depth, with the lateral stiffness of a plane
seat (`cycloid.seat`) and, where its sides adhere, a tilting stiffness. The far ends of the pins are
free, fixed, or tied by a cage: a rigid ring that turns freely about the axis and so transmits no
torque. Compared with three-dimensional finite elements of bonded seats the compliance is 2 % too
small to 18 % too large.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from lostmotion.laws.annulus import Annulus
from lostmotion.laws.cross_sections import round_section
from lostmotion.laws.cycloid.seat import (
    cosine_pressure_compliance,
    pin_in_bore,
    seat_compliance,
    tilt_stiffness_per_length,
)
from lostmotion.laws.rolling.radial import (
    ROLLER_EXPONENT,
    element_angles,
    radial_shift,
    roller_stiffness,
)
from lostmotion.laws.supported_beam import BeamPiece, Foundation, Support, SupportedBeam, respond

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.seat import Fit
    from lostmotion.spatial import Floats

Held = Literal["one end", "ring", "both flanges"]

# Half angle of the smallest contact in a hole that is solved for, rad; narrower ones follow Hertz's
# logarithm.
_RESOLVED: Final = math.radians(6)
# Gain of compliance by a floating ring below which its pins are stiff.
_STIFF: Final = 1e-6
# Outer radius of the material around a hole over the hole's radius: the difference of two pressures
# on the hole does not depend on it.
_AROUND: Final = 5.0


@dataclass(frozen=True, slots=True)
class ElasticPinSeat:
    """An elastic seat of a pin.

    depth         along the pin, m
    outer_radius  of the body around the pin, fixed there, m; the seat counts material up to one
                  depth from the bore
    young, nu     of the body, Pa
    fit           "bonded", "pressed" or "snug"
    adheres       whether the sides hold the pin axially, so that it cannot tilt freely; default:
                  unless snug

    Plane strain: the rest of the body hinders strain along the pin.
    """

    depth: float
    outer_radius: float
    young: float
    nu: float
    fit: Fit = "pressed"
    adheres: bool | None = None

    def foundation(self, pin_radius: float, start: float, *, floating: bool = False) -> Foundation:
        """Return the seat as springs along a pin of this radius (m), from `start` (m) on. Raises
        ValueError for a seat inside the pin.
        """
        if not self.outer_radius > pin_radius:
            raise ValueError(
                f"a seat of outer radius {self.outer_radius * 1e3:g} mm does not enclose a pin "
                f"of radius {pin_radius * 1e3:g} mm"
            )
        around = Annulus(
            pin_radius, min(self.outer_radius, pin_radius + self.depth), 1.0, self.young, self.nu
        )
        adheres = self.fit != "snug" if self.adheres is None else self.adheres
        tilt = tilt_stiffness_per_length(around) if adheres else 0.0
        return Foundation(
            start, start + self.depth, 1 / seat_compliance(around, self.fit), tilt, floating
        )


@dataclass(frozen=True, slots=True)
class HeldPin:
    """A round output pin and its seats.

    diameter, young, nu  of the pin, m and Pa
    free                 free length: from the flange to the free end, or between flange and ring, m
    load                 where the discs push, from the flange, m; equal places are a point load
    flange, ring         its seats; None for a rigid one
    held                 at "one end" by the flange; by the flange and by a floating "ring"; or by
                         "both flanges", which turn together

    Raises ValueError for a load beyond the free length.
    """

    diameter: float
    young: float
    nu: float
    free: float
    load: tuple[float, float]
    flange: ElasticPinSeat | None = None
    ring: ElasticPinSeat | None = None
    held: Held = "one end"

    def __post_init__(self) -> None:
        """Refuse loads on the seats."""
        if not 0 <= self.load[0] <= self.load[1] <= self.free * (1 + 1e-12):
            raise ValueError(
                f"the discs push from {self.load[0]:g} to {self.load[1]:g} m on a pin with a "
                f"free length of {self.free:g} m"
            )

    def _beam(self, *, floating: bool) -> SupportedBeam:
        radius, near = self.diameter / 2, self.flange.depth if self.flange else 0.0
        end = near + self.free
        far = self.ring.depth if self.ring and self.held != "one end" else 0.0
        section = round_section(self.diameter, 0.0, self.nu)
        shear = self.young / (2 + 2 * self.nu)
        piece = BeamPiece(
            0.0, end + far, self.young * section.i_y, shear * section.area * section.shear_y
        )
        clamps = [] if self.flange else [Support(0.0, math.inf, math.inf)]
        springs = [self.flange.foundation(radius, 0.0)] if self.flange else []
        if self.held != "one end":
            if self.ring:
                springs.append(self.ring.foundation(radius, end, floating=floating))
            else:
                clamps.append(Support(end, 0.0 if floating else math.inf, math.inf))
        return SupportedBeam((piece,), tuple(clamps), tuple(springs))

    def compliance(self, discs: int = 2) -> tuple[float, float]:
        """Return the displacement per force (m/N) of a loaded pin at the discs: the part of the pin
        itself, and that of its seats.

        With a floating ring that moves by a share s of its motion if all pins were loaded equally
        around the axis (`ring_share`), the compliance is linear in s, from that of a pin with a
        fixed ring (s = 0) to that with one of its own (s = 1).
        """
        return _compliance(self, discs)

    def parts(self, *, floating: bool) -> Floats:
        """Return the displacement per force (part,), m/N, of a pin at the discs due to itself, then
        its seats, with a fixed or a floating ring.
        """
        near = self.flange.depth if self.flange else 0.0
        load = (near + self.load[0], near + min(self.load[1], self.free))
        return respond(self._beam(floating=floating), [load]).by_part[:, 0, 0]


@functools.lru_cache(maxsize=256)
def _compliance(pin: HeldPin, discs: int) -> tuple[float, float]:
    parts = pin.parts(floating=False)
    if pin.held == "ring":
        floating = pin.parts(floating=True)
        share = ring_share(discs, float(floating.sum() / parts.sum()) - 1)
        parts = (1 - share) * parts + share * floating
    return float(parts[0]), float(parts[1:].sum())


def ring_share(discs: int, gained: float) -> float:
    """Return the motion of a floating ring at the loaded pins, over that if all pins pushed it
    around the axis with equal forces.

    gained  compliance of a pin by its own free ring, over that with a fixed ring, minus one: a^2/(k
            A) for the share a of the force at the ring, the stiffness k there, and the compliance A
            of the pin with a fixed ring

    The ring is rigid, turns and shifts freely, and takes no torque. Each disc pushes the pins along
    its line of centres, in proportion to their distance from it and on one half. Two opposite discs
    load all pins, without resultant: the ring only turns, by a half. Three or more load every pin
    around the axis: one. One disc also shifts the ring along the line: 1/4 + 4/pi^2 of a ring on
    stiff pins. With softer ones fewer pins carry: forces F ~ max(0, s - c) of pins at s = sin(psi),
    with the shift c = gained h0(c), h0 = [sqrt(1 - c^2) - c acos c]/pi, and the moment of the
    forces h1 = [acos c - c sqrt(1 - c^2)]/(2 pi), so that the share is 1/4 + [1/(4 h1) - 1]/gained.
    As for pins all around the circle.
    """
    if discs > 1:
        return 0.5 if discs == 2 else 1.0  # noqa: PLR2004 - a pair
    if gained < _STIFF:
        return 0.25 + 4 / math.pi**2
    low, high = 0.0, 1.0
    for _ in range(60):
        c = (low + high) / 2
        low, high = (
            (c, high)
            if gained * (math.sqrt(1 - c * c) - c * math.acos(c)) / math.pi > c
            else (low, c)
        )
    moment = (math.acos(low) - low * math.sqrt(1 - low * low)) / (2 * math.pi)
    return 0.25 + (1 / (4 * moment) - 1) / gained


def needle_compliance(force: float, rollers: int, length: float) -> float:
    """Return the displacement per force (m/N) of a rigid sleeve on needles around a pin, under a
    force (N): secant, without clearance.

    rollers, length  number of needles and their effective length, m
    """
    shift = radial_shift(
        force, 0.0, roller_stiffness(length), ROLLER_EXPONENT, element_angles(rollers)
    )
    return float(shift) / force


@dataclass(frozen=True, slots=True)
class Hole:
    """A pin, or a sleeve on it, in a hole of a disc.

    radius, pin_radius   of the hole and of the pin or sleeve, m
    width                of the disc, m
    young, nu            of the disc, Pa
    pin_young, pin_nu    of the pin or sleeve, Pa

    Plane strain. Raises ValueError for a pin that does not fit.
    """

    radius: float
    pin_radius: float
    width: float
    young: float
    nu: float
    pin_young: float
    pin_nu: float

    def __post_init__(self) -> None:
        """Refuse pins as large as their holes."""
        if not 0 < self.pin_radius < self.radius:
            raise ValueError(
                f"a pin of radius {self.pin_radius:g} m does not fit into a hole of radius "
                f"{self.radius:g} m"
            )

    def compliance(self, force: float) -> float:
        """Return the approach of pin and hole per force (m/N), beyond that of a cosine pressure on
        half of the hole: secant under a force (N).

        A disc's body with its holes includes the cosine pressure (`perforated_disc`). The rest is
        local: the contact is narrower, and the pin is compressed down to its centre (K. Johnson,
        Contact Mechanics, section 5.6). The width of the contact follows both bodies' moduli, as
        Hertz's does. Raises ValueError for a force that is not positive.
        """
        around = Annulus(self.radius, _AROUND * self.radius, self.width, self.young, self.nu)
        modulus, of_pin = around.plane_modulus, self.pin_young / (1 - self.pin_nu**2)
        together = 1 / (1 / modulus + 1 / of_pin)
        gap = self.radius - self.pin_radius
        # a rigid pin under this larger force makes a contact as wide, and displacements in
        # proportion
        equivalent = force * modulus / together
        relative = self.radius * self.pin_radius / gap
        resolved = (_RESOLVED * self.radius) ** 2 * math.pi * modulus * self.width / (4 * relative)
        solved = max(equivalent, resolved)
        bore = pin_in_bore(around, solved, gap)[0] / solved + math.log(solved / equivalent) / (
            math.pi * modulus * self.width
        )
        half = min(
            math.sqrt(4 * force * relative / (math.pi * together * self.width)), self.pin_radius
        )
        pin = max(2 * math.log(4 * self.pin_radius / half) - 1, 0.0) / (
            math.pi * of_pin * self.width
        )
        return max(bore + pin - cosine_pressure_compliance(around), 0.0)


def largest_pin_force(torque: float, circle: float, count: int, discs: int) -> float:
    """Return the largest force (N) of a disc on an output pin, 4 T/(n_d n_w Rw), under a torque (N
    m) on all discs.

    circle, count  radius Rw (m) of the circle of pins and their number n_w
    """
    return 4 * torque / (discs * count * circle)
