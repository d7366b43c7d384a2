"""The eccentric with its bearings, and its shaft by its dimensions: sections, bearings and their seats, as a drawing states them."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from lostmotion.laws.annulus import Annulus, Plane
from lostmotion.laws.cycloid import shaft as laws
from lostmotion.laws.cycloid.seat import seat_compliance
from lostmotion.laws.supported_beam import Support, SupportedBeam
from lostmotion.parts.error_source import AngularStiffness, ClearanceDim, LengthAmount, LengthPlus, Line, LinearStiffness
from lostmotion.parts.gearbox.cycloidal_pins import STEEL, Fit
from lostmotion.parts.gearbox.gearbox import Whole, refuse
from lostmotion.parts.material import Material
from lostmotion.parts.provenance import DEFAULT, Sourced
from lostmotion.units import Toleranced

Named = Annotated[Line, Field(max_length=80)]


class BearingSeat(Sourced):
    """The seat of a bearing in a plate or housing.

    diameter        of the bore; outer_diameter of the material around it: material farther away counts as rigid
    width           of the bearing's ring
    fit             "bonded" (glued, moulded in), "pressed", or "snug" (without preload: the contact opens behind the bearing); default: pressed
    """

    material: Material
    diameter: LengthPlus
    outer_diameter: LengthPlus
    width: LengthPlus
    fit: Fit = "pressed"

    @model_validator(mode="after")
    def _encloses(self) -> Self:
        if self.outer_diameter <= self.diameter:
            why = f"an outer_diameter of {self.outer_diameter * 1e3:g} mm around a bore of {self.diameter * 1e3:g} mm"
            raise refuse(why, "material around the bore", f'outer_diameter = "{2e3 * self.diameter:.3g} mm"')
        return self

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the default fit."""
        out = super().assumptions
        return out if "fit" in self.model_fields_set else {**out, "fit": f"{DEFAULT}, pressed; bonded is stiffer, snug is softer"}

    @functools.cached_property
    def compliance(self) -> float:
        """Return the shift of the bearing per force (m/N): plane strain for a seat wider than its bore, else plane stress."""
        plane: Plane = "strain" if self.width > self.diameter else "stress"
        body = Annulus(self.diameter / 2, self.outer_diameter / 2, self.width, self.material.young, self.material.poisson, plane)
        return seat_compliance(body, self.fit)


class ShaftSection(Sourced):
    """A section of the shaft, from the end of the one before (the first: from 0) `to` a place.

    bore      inner diameter; default: solid
    material  default: steel
    core      material that fills the bore; default: empty
    """

    to: LengthPlus
    diameter: LengthPlus
    bore: LengthAmount = 0.0
    material: Material = STEEL
    core: Material | None = None

    @model_validator(mode="after")
    def _has_a_wall(self) -> Self:
        if self.bore >= self.diameter:
            why = f"a bore of {self.bore * 1e3:g} mm in a diameter of {self.diameter * 1e3:g} mm"
            raise refuse(why, "a bore smaller than the diameter", f'bore = "{500 * self.diameter:.3g} mm"')
        if self.core is not None and not self.bore:
            raise refuse("a core without a bore", "the bore that it fills", 'bore = "12 mm"')
        return self

    @property
    def layers(self) -> tuple[tuple[laws.Layer, Material], ...]:
        """Return the layers of the section, each with its material."""
        out = [(laws.Layer(self.diameter, self.bore, self.material.young, self.material.poisson), self.material)]
        if self.core is not None:
            out.append((laws.Layer(self.bore, 0.0, self.core.young, self.core.poisson), self.core))
        return tuple(out)


class ShaftSupport(Sourced):
    """A bearing that supports the shaft.

    at         its place along the shaft
    bearing    its radial stiffness; unspecified: assumed rigid
    tilt       its stiffness against tilting, for wide or paired bearings; default: none, as of a deep groove ball bearing
    seat       the name of its seat under `seats`; unspecified: assumed rigid
    clearance  diametral working clearance
    """

    at: LengthAmount
    bearing: LinearStiffness | None = None
    tilt: AngularStiffness | None = None
    seat: Named | None = None
    clearance: ClearanceDim = Toleranced(0.0)


class Shaft(Sourced):
    """The shaft of an eccentric, or of each crank, on its bearings. All places are measured from its driven end.

    supports  its bearings
    disc_at   the place of each disc
    sections  its sections, from the driven end on
    """

    supports: Annotated[tuple[ShaftSupport, ...], Field(min_length=1, max_length=8)]
    disc_at: Annotated[tuple[LengthAmount, ...], Field(min_length=1, max_length=4)]
    sections: Annotated[tuple[ShaftSection, ...], Field(min_length=1, max_length=40)]

    @model_validator(mode="after")
    def _is_held(self) -> Self:
        ends = [each.to for each in self.sections]
        if any(second <= first for first, second in itertools.pairwise(ends)):
            raise refuse("sections that do not follow one another", "each section ending beyond the one before", 'to = "27 mm"')
        beyond = [place for place in (*self.disc_at, *(each.at for each in self.supports)) if place > ends[-1]]
        if beyond:
            why = f"a disc or support at {max(beyond) * 1e3:g} mm on a shaft of {ends[-1] * 1e3:g} mm"
            raise refuse(why, "places on the shaft", f'to = "{1e3 * max(beyond):g} mm"')
        if len({each.at for each in self.supports}) < 2 and not any(each.tilt for each in self.supports):  # noqa: PLR2004 - one support is a hinge
            example = 'supports = [{ at = "0 mm", bearing = "30 N/µm" }, { at = "43 mm", bearing = "60 N/µm" }]'
            raise refuse("a shaft on a single support without tilt stiffness", "two supports or more", example)
        return self

    @property
    def stretches(self) -> tuple[laws.Stretch, ...]:
        """Return the sections as arguments of the law."""
        starts = [0.0, *(each.to for each in self.sections)]
        return tuple(
            laws.Stretch(start, each.to, tuple(layer for layer, _ in each.layers)) for start, each in zip(starts, self.sections, strict=False)
        )

    def response(self, seats: dict[str, BearingSeat], width: float, phases: tuple[float, ...], eccentricity: float) -> ShaftSprings:
        """Return the compliance by member, with forces spread over `width` (m) at each disc of these phases (rad)."""
        stretches = self.stretches
        springs = []
        for each in self.supports:
            soft = self._bearing(each) + self._seat(each, seats)
            springs.append(Support(each.at, 1 / soft if soft else math.inf, each.tilt or 0.0))
        beam = SupportedBeam(tuple(each.piece for each in stretches), tuple(springs))
        end = stretches[-1].end
        loads = [(max(place - width / 2, 0.0), min(place + width / 2, end)) for place in self.disc_at]
        found = laws.shaft_compliance(beam, stretches, loads, np.array(phases), eccentricity)
        of_supports = found.by_part[len(stretches) :]
        bearings, of_seats = 0.0, dict.fromkeys(seats, 0.0)
        for each, part in zip(self.supports, of_supports.tolist(), strict=True):
            bearing, seat = self._bearing(each), self._seat(each, seats)
            share = seat / (bearing + seat) if seat else 0.0
            bearings += part * (1 - share)
            if each.seat is not None:
                of_seats[each.seat] += part * share
        return ShaftSprings(tuple(found.by_part[: len(stretches)].tolist()), found.twist, bearings, of_seats, tuple(found.reactions.tolist()))

    @staticmethod
    def _bearing(support: ShaftSupport) -> float:
        return 1 / support.bearing if support.bearing is not None else 0.0

    @staticmethod
    def _seat(support: ShaftSupport, seats: dict[str, BearingSeat]) -> float:
        return seats[support.seat].compliance if support.seat is not None else 0.0


@dataclass(frozen=True, slots=True)
class ShaftSprings:
    """Displacement of a disc per force on every disc (m/N) by member: sections, torsion between discs, bearings, seats by name.

    reactions  force on each support per force on every disc
    """

    sections: tuple[float, ...]
    twist: float
    bearings: float
    seats: dict[str, float]
    reactions: tuple[float, ...]

    @property
    def shaft(self) -> float:
        """Return the part of bending, shear and torsion of the shaft itself, m/N."""
        return sum(self.sections) + self.twist

    @property
    def total(self) -> float:
        """Return the whole compliance, m/N."""
        return self.shaft + self.bearings + sum(self.seats.values())


class Eccentric(Sourced):
    """The eccentric with its bearings, one per disc and crankshaft.

    clearance       diametral working clearance of each bearing
    position        ± position of each disc's bore, in both directions: relative to the flank and, with several crankshafts, relative to these
    rollers, roller_length   its rolling elements, or:
    bearing         its radial stiffness
    shaft           stiffness of the shaft with its seats, at one disc; or a table of its sections, bearings and seats
    cranks, circle_radius    several crankshafts that carry the output, as in an RV reducer; default: one central eccentric
    """

    clearance: ClearanceDim = Toleranced(0.0)
    position: LengthAmount = 0.0
    rollers: Annotated[int, Whole("", "16", low=3, high=200)] | None = None
    roller_length: LengthPlus | None = None
    bearing: LinearStiffness | None = None
    shaft: LinearStiffness | Shaft | None = None
    cranks: Annotated[int, Whole("", "2", low=1, high=8)] = 1
    circle_radius: LengthPlus | None = None

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if (self.rollers is None) != (self.roller_length is None) or (self.rollers is not None and self.bearing is not None):
            expected = "rollers with roller_length, or the stiffness as bearing, or neither (rigid)"
            raise refuse("an incomplete or doubly stated bearing of the eccentric", expected, 'rollers = 16, roller_length = "10 mm"')
        if (self.cranks > 1) != (self.circle_radius is not None):
            raise refuse(
                f"{self.cranks} crank{'s' if self.cranks > 1 else ''} {'with' if self.circle_radius else 'without'} circle_radius",
                "two or more cranks with the radius of their circle, or one central crank without it",
                'cranks = 3, circle_radius = "36 mm"',
            )
        return self
