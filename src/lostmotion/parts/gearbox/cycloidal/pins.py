"""Output pins of a cycloidal stage with their seats, sleeves and holes, as a drawing states
them.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import model_validator

from lostmotion.laws.cycloid import output_pins as laws
from lostmotion.parts.error_source import ClearanceDim, LengthAmount, LengthPlus, LinearStiffness
from lostmotion.parts.gearbox.counts import Whole
from lostmotion.parts.gearbox.cycloidal.names import PINS, SEATS
from lostmotion.parts.gearbox.gearbox import refuse
from lostmotion.parts.material import Material
from lostmotion.parts.provenance import DEFAULT, Sourced
from lostmotion.units import Toleranced

Fit = Literal["bonded", "pressed", "snug"]
# Between these lies a fit that is not stated.
EXTREME_FITS: Final[tuple[Fit, Fit]] = ("bonded", "snug")
UNKNOWN_FIT: Final = {"fit": f"{DEFAULT}, between bonded and snug"}
# Depths of the seat of a pin, over its diameter, between which lies one that is not stated: from a
# short press fit to a deep one.
_DEPTHS: Final = (2.0, 0.8)
# The material around such a seat reaches to the next pin, but to this multiple of the diameter at
# least.
_LEAST_REACH: Final = 1.5
# Lengths that a pin and its seats can have, over its diameter: beyond them a unit is wrong, and one
# part of the beam would be lost in the other's rounding.
_LENGTHS: Final = (0.001, 100.0)
# Default material of discs, rings and pins, marked as assumed.
STEEL = Material(
    young=210e9,
    poisson=0.3,
    density=7850.0,
    expansion=12e-6,
    assumed=("young", "poisson", "density", "expansion"),
    source="default, steel",
)
_CLAMPED: Final = (
    'held = "ring", seat = { depth = "10 mm", material = "PETG", outer_diameter = "16 mm" }'
)
# Number of output pins: three support the disc in every direction.
PinCount = Annotated[int, Whole("", "8", low=3, high=100)]


class PinSeat(Sourced):
    """The seat of an output pin in the carrier.

    depth           along the pin
    outer_diameter  of the material around the pin; material farther away counts as rigid
    fit             "bonded" (glued, moulded in), "pressed" or "snug" (without preload: the contact
                    opens behind the pin, and the pin can tilt); default: between bonded and snug,
                    the geometric mean of their compliances
    """

    assumed_unless_stated: ClassVar[dict[str, str]] = UNKNOWN_FIT
    depth: LengthPlus
    material: Material
    outer_diameter: LengthPlus
    fit: Fit | None = None

    def law(self, fit: Fit) -> laws.ElasticPinSeat:
        """Return the argument of the law, with this fit where none is stated."""
        return laws.ElasticPinSeat(
            self.depth,
            self.outer_diameter / 2,
            self.material.plate_modulus,
            self.material.poisson,
            self.fit or fit,
        )


class Sleeve(Sourced):
    """A steel sleeve around each output pin, on needles; without `rollers` it slides on the pin.

    diameter  outer diameter, which touches the hole
    rollers   number of needles per sleeve
    length    of sleeve and needles: the load is distributed over it
    """

    diameter: LengthPlus
    length: LengthPlus
    rollers: Annotated[int, Whole("", "8", low=3, high=200)] | None = None


class OutputPins(Sourced):
    """The pins that transmit the torque from the holes of the discs.

    clearance               of a pin in its hole, diametral, beyond the eccentricity
    position                ± position of each pin relative to its hole, in both directions
    stiffness               of one pin at the discs, with its seat and its hole, or:
    diameter, free_length   of a round pin, from its seat to the middle of the discs
    material                of the pins; default: steel
    held                    at "one end", the default; by the flange and a "ring" that ties the pins
                            and turns freely; or by "both flanges", which turn together
    span                    free length of a pin between its two seats; default: twice the free
                            length
    seat, far_seat          in the flange, and in the ring or second flange (default: the same);
                            unspecified: 0.8 to 2 diameters deep in the material of the ring
    sleeve                  around each pin; default: the pin itself touches the hole
    """

    count: PinCount
    circle_radius: LengthPlus
    clearance: ClearanceDim = Toleranced(0.0)
    position: LengthAmount = 0.0
    stiffness: LinearStiffness | None = None
    diameter: LengthPlus | None = None
    free_length: LengthPlus | None = None
    material: Material | None = None
    held: Literal["one end", "ring", "both flanges"] = "one end"
    span: LengthPlus | None = None
    seat: PinSeat | None = None
    far_seat: PinSeat | None = None
    sleeve: Sleeve | None = None

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if (self.diameter is None) != (self.free_length is None) or (
            self.diameter is not None and self.stiffness is not None
        ):
            expected = "diameter with free_length, or stiffness, or neither (bounded)"
            raise refuse(
                "an incomplete or doubly stated stiffness of the output pins",
                expected,
                'diameter = "12 mm", free_length = "14 mm"',
            )
        detailed = [
            name
            for name in ("material", "held", "span", "seat", "far_seat", "sleeve")
            if name in self.model_fields_set
        ]
        if detailed and self.diameter is None:
            expected = f"{' and '.join(detailed)} of pins with a diameter and a free_length"
            raise refuse(
                f"{' and '.join(detailed)} without diameter",
                expected,
                'diameter = "12 mm", free_length = "14 mm"',
            )
        if self.held == "one end" and (self.span is not None or self.far_seat is not None):
            raise refuse(
                'a span or far_seat of pins held at "one end"',
                'pins held by a "ring" or by "both flanges"',
                _CLAMPED,
            )
        if self.far_seat is not None and self.seat is None:
            raise refuse(
                "far_seat without seat",
                "the seat in the flange, with far_seat where the other differs",
                _CLAMPED,
            )
        if self.diameter is not None:
            self._check_sizes(self.diameter)
        return self

    def _check_sizes(self, diameter: float) -> None:
        for seat in (self.seat, self.far_seat):
            if seat is not None and seat.outer_diameter <= diameter:
                why = (
                    f"a seat of outer_diameter {seat.outer_diameter * 1e3:g} mm around a pin of "
                    f"{diameter * 1e3:g} mm"
                )
                raise refuse(
                    why,
                    "a seat that encloses its pin",
                    f'outer_diameter = "{3e3 * diameter:.3g} mm"',
                )
        if self.sleeve is not None and self.sleeve.diameter <= diameter:
            why = (
                f"a sleeve of diameter {self.sleeve.diameter * 1e3:g} mm around a pin of "
                f"{diameter * 1e3:g} mm"
            )
            raise refuse(
                why,
                "a sleeve that encloses its pin",
                f'sleeve = {{ diameter = "{1.5e3 * diameter:.3g} mm", length = "10 mm" }}',
            )
        if self.free_length is not None:
            low, high = self._load
            if low < 0 or high > self._free * (1 + 1e-9):
                why = (
                    f"discs that push from {low * 1e3:.4g} to {high * 1e3:.4g} mm on a pin with "
                    f"{self._free * 1e3:.4g} mm between its seats"
                )
                raise refuse(
                    why,
                    "a load between the seats",
                    f'span = "{2.2e3 * max(high, self.free_length):.3g} mm"',
                )
        lengths = {
            "a free length": self._free,
            "a seat depth": None if self.seat is None else self.seat.depth,
            "a depth of the far seat": None if self.far_seat is None else self.far_seat.depth,
        }
        low, high = _LENGTHS
        for name, length in lengths.items():
            if length is not None and not low * diameter <= length <= high * diameter:
                raise refuse(
                    f"{name} of {length * 1e3:g} mm of pins of {diameter * 1e3:g} mm",
                    f"lengths from {low:g} to {high:g} diameters",
                    'diameter = "12 mm", free_length = "14 mm"',
                )

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the default
        material.
        """
        out = super().assumptions
        return (
            {**out, "material": f"{DEFAULT}, steel"}
            if self.diameter is not None and self.material is None
            else out
        )

    @property
    def pin_material(self) -> Material:
        """Return the material of the pins, stated or the default."""
        return self.material or STEEL

    @property
    def outer_diameter(self) -> float | None:
        """Return the diameter (m) that touches the hole: of the sleeve, or else of the pin; None
        where not stated.
        """
        return self.sleeve.diameter if self.sleeve is not None else self.diameter

    @property
    def _load(self) -> tuple[float, float]:
        middle, half = (
            self.free_length or 0.0,
            self.sleeve.length / 2 if self.sleeve is not None else 0.0,
        )
        return middle - half, middle + half

    @property
    def _free(self) -> float:
        if self.held == "one end":
            return self._load[1]
        return self.span if self.span is not None else 2 * (self.free_length or 0.0)

    @property
    def unknown_seats(self) -> str:
        """Return what is not known of the seats of pins with a diameter, in words; empty where
        nothing is open.
        """
        if self.diameter is None:
            return ""
        if self.seat is None:
            return (
                f"{_DEPTHS[1]:g} to {_DEPTHS[0]:g} diameters deep, in the material of the ring out "
                "to the next pin, fit between bonded and snug"
            )
        return (
            "fit between bonded and snug"
            if any(each is not None and each.fit is None for each in (self.seat, self.far_seat))
            else ""
        )

    def limits(self, around: Material) -> tuple[OutputPins, OutputPins]:
        """Return these pins with the stiffest and with the softest seats that the drawing allows:
        twice the same where all is known.

        around  material of seats that are not stated
        """
        if self.diameter is None or not self.unknown_seats:
            return self, self
        reach = max(
            2 * self.circle_radius * math.sin(math.pi / self.count), _LEAST_REACH * self.diameter
        )
        out = []
        for depth, fit in zip(_DEPTHS, EXTREME_FITS, strict=True):
            seat = self.seat or PinSeat(
                depth=depth * self.diameter, material=around, outer_diameter=reach
            )
            seats = {"seat": seat, "far_seat": self.far_seat or seat}
            known = {
                key: each if each.fit is not None else each.model_copy(update={"fit": fit})
                for key, each in seats.items()
            }
            out.append(self.model_copy(update=known))
        return out[0], out[1]

    def compliance(self, discs: int, *, rigid: tuple[str, ...] = ()) -> tuple[float, float]:
        """Return the compliance (m/N) of one pin at the discs, and that of its known seats; zeros
        where it is not specified by its diameter.

        A ring that ties the pins moves less with fewer `discs`. `rigid` are members declared rigid.
        """
        if self.diameter is None:
            return 0.0, 0.0
        far = self.far_seat or self.seat
        flange, ring = (
            None if seat is None or seat.fit is None or SEATS in rigid else seat.law(seat.fit)
            for seat in (self.seat, far)
        )
        pin = laws.HeldPin(
            self.diameter,
            self.pin_material.standing_modulus,
            self.pin_material.poisson,
            self._free,
            self._load,
            flange,
            ring,
            self.held,
        )
        of_pin, of_seats = pin.compliance(discs)
        return (0.0 if PINS in rigid else of_pin), of_seats


def middle_compliance(
    limits: tuple[OutputPins, OutputPins], discs: int, rigid: tuple[str, ...]
) -> tuple[float, float]:
    """Return the geometric mean of the compliances of the stiffest and of the softest pins, as
    `OutputPins.compliance`.
    """
    stiff, soft = (each.compliance(discs, rigid=rigid) for each in limits)
    return (
        stiff if stiff == soft else (math.sqrt(stiff[0] * soft[0]), math.sqrt(stiff[1] * soft[1]))
    )


class DiscHoles(Sourced):
    """Holes of a disc for the output pins, or for the bearings of several cranks; `count` and
    `circle_radius` are those of these, unless stated.
    """

    diameter: LengthPlus
    count: PinCount | None = None
    circle_radius: LengthPlus | None = None


class Disc(Sourced):
    """Details of the discs.

    holes     for the output pins; default: as wide as a pin or its sleeve, twice the eccentricity
              and the clearance. With several cranks for their bearings; default: as wide as a
              bearing by its size, else 0.6 times the room around them
    bore_fit  of the eccentric's bearing in the bore: "bonded", "pressed", or "snug" (without
              preload: the contact opens behind the bearing); default: between pressed and snug
    """

    holes: DiscHoles | None = None
    bore_fit: Fit | None = None
