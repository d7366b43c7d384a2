"""One cycloidal stage from its drawing: checks of its members, and the arguments of the laws."""

from __future__ import annotations

import functools
import math
from typing import Final, Self

from pydantic import model_validator

from lostmotion.errors import shown
from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid import drive
from lostmotion.laws.cycloid.bodies import check_body
from lostmotion.laws.cycloid.contact import Flanks
from lostmotion.laws.cycloid.tolerances import DimensionScatter
from lostmotion.parts.gearbox.cycloidal.envelope import branches
from lostmotion.parts.gearbox.cycloidal.process import with_process
from lostmotion.parts.gearbox.cycloidal.seats import BearingSize
from lostmotion.parts.gearbox.cycloidal.shaft import Shaft
from lostmotion.parts.gearbox.cycloidal.springs import StageSprings
from lostmotion.parts.gearbox.cycloidal.temperature import (
    check_temperature,
    output_clearance_at_work,
    relief_at_work,
)
from lostmotion.parts.gearbox.gearbox import refuse
from lostmotion.units import Toleranced

# Largest difference, m, between a stated size and that which follows from others.
_SAME_SIZE: Final = 1e-6


class CycloidalStage(StageSprings):
    """One cycloidal stage from its drawing, with the compliance of its members."""

    @model_validator(mode="after")
    def _members_can_be_built(self) -> Self:
        if self.disc.bore_fit not in (None, "pressed") and self.eccentric.cup is not None:
            why = (
                f"bore_fit = {shown(self.disc.bore_fit)} beside a cup, which is pressed into its "
                "bore"
            )
            raise refuse(why, "one of the two, or a pressed fit", 'bore_fit = "pressed"')
        self._check_holes()
        self._check_shaft()
        check_temperature(self)
        return self

    def _check_shaft(self) -> None:
        shaft = self.eccentric.shaft
        if not isinstance(shaft, Shaft):
            return
        if len(shaft.disc_at) != self.discs:
            why = (
                f"{len(shaft.disc_at)} places in disc_at for {self.discs} "
                f"disc{'s' if self.discs > 1 else ''}"
            )
            places = ", ".join(f'"{16 + 12 * k} mm"' for k in range(self.discs))
            raise refuse(why, "the place of every disc on the shaft", f"disc_at = [{places}]")
        strange = [
            each.seat
            for each in shaft.supports
            if each.seat is not None and each.seat not in self.seats
        ]
        if strange:
            known = f"one of {', '.join(self.seats)}" if self.seats else "a seat under seats"
            example = (
                'seats = { housing = { material = "PETG", width = "5 mm", diameter = "26 mm", '
                'outer_diameter = "50 mm" } }'
            )
            raise refuse(
                f"a support in the seat {shown(strange[0])}, which is not described", known, example
            )
        try:
            _ = self.shaft_springs
        except ValueError as error:
            example = (
                'supports = [{ at = "0 mm" }, { at = "43 mm" }], screws = { count = 2, diameter = '
                '"4 mm", offset = "3.5 mm" }'
            )
            raise refuse(
                f"a shaft for which {error}",
                "a shaft that its supports hold, with screws inside its sections",
                example,
            ) from None

    def _check_holes(self) -> None:
        holes, pins, eccentric = self.disc.holes, self.output_pins, self.eccentric
        if eccentric.circle_radius is not None:
            self._check_crank_holes(eccentric.circle_radius)
        elif holes is not None and (pins is None or pins.outer_diameter is None):
            raise refuse(
                "disc holes without output pins of a stated diameter",
                "output pins for the holes",
                'diameter = "12 mm", free_length = "14 mm"',
            )
        if holes is not None and pins is not None and pins.outer_diameter is not None:
            differing = [
                name
                for name in ("count", "circle_radius")
                if getattr(holes, name) not in (None, getattr(pins, name))
            ]
            if differing:
                why = f"holes with another {' and '.join(differing)} than the output pins"
                raise refuse(why, "the same, or only the diameter", 'diameter = "12 mm"')
            fitting = (
                pins.outer_diameter + 2 * self.eccentricity.nominal + self.pin_clearance.nominal
            )
            within = self.pin_clearance.tolerance + 2 * self.eccentricity.tolerance
            if abs(holes.diameter - fitting) > within + _SAME_SIZE:
                why = (
                    f"holes of {holes.diameter * 1e3:.6g} mm, where pin, twice the eccentricity "
                    f"and clearance make {fitting * 1e3:.6g} mm"
                )
                raise refuse(
                    why,
                    "holes that fit the pins with their clearance",
                    f'diameter = "{fitting * 1e3:.6g} mm"',
                )
        if self.hole_diameter is None:
            return
        try:
            # by geometry alone: nothing is solved while a file is read
            if self._disc_body is not None:
                check_body(self.stage, self._disc_body)
        except ValueError as error:
            found = f"disc holes of {self.hole_diameter * 1e3:.4g} mm for which {error}"
            raise refuse(
                found, "holes with webs around them", 'holes = { diameter = "12.1 mm" }'
            ) from None

    def _check_crank_holes(self, circle: float) -> None:
        holes, size, inner = self.disc.holes, self.eccentric.bearing, self.disc_bore_radius or 0.0
        if not inner < circle < self.root_radius:
            why = (
                f"cranks on a circle of radius {circle * 1e3:g} mm in a disc between "
                f"{inner * 1e3:g} and {self.root_radius * 1e3:.4g} mm"
            )
            raise refuse(
                why,
                "cranks in the disc",
                f'circle_radius = "{(inner + self.root_radius) * 500:.3g} mm"',
            )
        if holes is None:
            return
        if holes.count not in (None, self.eccentric.cranks) or holes.circle_radius not in (
            None,
            circle,
        ):
            raise refuse(
                "holes with another count or circle_radius than the cranks",
                "the same, or only the diameter",
                'diameter = "30 mm"',
            )
        if (
            isinstance(size, BearingSize)
            and abs(holes.diameter - size.outside_diameter) > _SAME_SIZE
        ):
            why = (
                f"holes of {holes.diameter * 1e3:.6g} mm for bearings with an outside_diameter of "
                f"{size.outside_diameter * 1e3:.6g} mm"
            )
            raise refuse(
                why,
                "holes that fit the bearings",
                f'diameter = "{size.outside_diameter * 1e3:.6g} mm"',
            )

    @functools.cached_property
    def drive(self) -> drive.Drive:
        """Return the arguments of the laws of the loaded stage."""
        disc, ring = self.disc_material, self.ring_material
        modulus, both = (
            equivalent_modulus(disc.modulus, disc.poisson, ring.modulus, ring.poisson),
            branches(self.stage, self.envelope),
        )
        flanks = Flanks(
            self.width,
            modulus,
            self.contact_law,
            self._lobe_bending,
            branches=both.stiffening if both else 1.0,
        )
        eccentric = self.eccentric
        soft = self.shaft_compliance + self.bore_compliance
        springs = drive.EccentricSprings(
            **self._bearing,
            shaft=1 / soft if soft else math.inf,
            cranks=eccentric.cranks,
            circle=eccentric.circle_radius or math.inf,
        )
        pins = self.output_pins
        output = (
            None
            if pins is None
            else drive.OutputPinSprings(pins.count, pins.circle_radius, self._pin_stiffness)
        )
        return drive.Drive(
            self.stage,
            flanks,
            relief_at_work(self),
            self.discs,
            springs,
            output,
            self._disc_body,
            self._ring_body,
        )

    @property
    def scatter(self) -> DimensionScatter:
        """Return the tolerances of the dimensions over gearboxes."""
        stated = DimensionScatter(
            ring_radius=self.ring_radius,
            pin_radius=self.pin_radius,
            eccentricity=self.eccentricity,
            roller=self.relief.roller,
            circle=self.relief.circle,
            crank_clearance=self.eccentric.clearance,
            shaft_clearances=self._shaft_clearances,
            output_clearance=output_clearance_at_work(self) or Toleranced(0.0),
            output_position=self.output_pins.position if self.output_pins else 0.0,
            crank_position=self.eccentric.position,
            pin_position=self.pin_position,
            pin_size=self.pin_size,
            flank_form=self.flank_form,
        )
        return with_process(stated, self.process_tolerances)
