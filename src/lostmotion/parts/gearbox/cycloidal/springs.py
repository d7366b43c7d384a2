"""Springs of one cycloidal stage from its drawing: lobes or pins, bodies, eccentric with its shaft,
output pins.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any, Final

from lostmotion.laws.annulus import Annulus
from lostmotion.laws.contact import lobe_compliance, round_bar_compliance
from lostmotion.laws.cycloid.bodies import ElasticBody
from lostmotion.laws.cycloid.cup import cup_in_bore
from lostmotion.laws.cycloid.output_pins import Hole, needle_compliance
from lostmotion.laws.cycloid.seat import LARGE, compliance_beyond, seat_compliance
from lostmotion.laws.perforated_disc import LEAST_WEB
from lostmotion.laws.perforated_disc_series import Holes
from lostmotion.laws.rolling.by_size import balls_of_size, stiffness_of_size
from lostmotion.laws.rolling.radial import BALL_EXPONENT, ROLLER_EXPONENT, roller_stiffness
from lostmotion.parts.gearbox.cycloidal.dimensions import StageDimensions
from lostmotion.parts.gearbox.cycloidal.names import (
    BEARING,
    BORE,
    DISC_BODY,
    HOLES,
    PINS,
    RING_BODY,
    RING_LOBES,
    RING_PINS,
    SHAFT,
    TILT,
)
from lostmotion.parts.gearbox.cycloidal.pins import STEEL, Fit, OutputPins, middle_compliance
from lostmotion.parts.gearbox.cycloidal.shaft import Shaft, ShaftCase, ShaftSprings
from lostmotion.parts.material import Material, with_material

if TYPE_CHECKING:
    from lostmotion.parts.gearbox.cycloidal.seats import BearingSeat
    from lostmotion.units import Toleranced

_LOBES: Final = ("lobe arcs", "lobe envelope")
# Compliance of a member that the drawing only bounds, over that of all computed members together;
# and of a bearing in a bore of unknown fit, over that of a snug one.
BOUNDS: Final = (0.05, 1.0)
# Wind-up of a disc with holes of unknown size over that of a solid one: by `perforated_disc` 5 to
# 95 % of usual discs, of 10 to 45 pins.
HOLES_OF_UNKNOWN_SIZE: Final = (1.25, 3.0)
# Wind-up of a disc with holes of unknown size for the bearings of cranks, over that with usual
# ones.
CRANK_HOLES_OF_UNKNOWN_SIZE: Final = (0.6, 1 / 0.6)
# Force, N, for springs that stiffen with their load, in a stage without a rated torque of its own.
FORCE_WITHOUT_RATING: Final = 100.0


class StageSprings(StageDimensions):
    """Compliance of the members of one cycloidal stage, from its drawing."""

    @property
    def _hole_circle(self) -> tuple[int, float]:
        """Return the number of holes of a disc and the radius (m) of their circle; without any (0,
        0).
        """
        if self.output_pins is not None:
            return self.output_pins.count, self.output_pins.circle_radius
        circle = self.eccentric.circle_radius
        return (0, 0.0) if circle is None else (self.eccentric.cranks, circle)

    def _thinnest_web(self, diameter: float) -> float:
        """Return the thickness (m) of the thinnest web between holes of this diameter (m), bore and
        root circle.
        """
        count, circle = self._hole_circle
        room = min(circle - self.bore_radius, self.root_radius - circle) - diameter / 2
        return min(room, 2 * circle * math.sin(math.pi / count) - diameter)

    def _holes(self, diameter: float) -> Holes:
        """Return the holes of a disc. Raises ValueError for holes that overlap, or cut the bore or
        the teeth.
        """
        count, circle = self._hole_circle
        root = self.root_radius
        if not self.bore_radius + diameter / 2 < circle < root - diameter / 2:
            raise ValueError(
                f"there is no room between a bore of {2e3 * self.bore_radius:.4g} mm and a "
                f"root circle of {2e3 * root:.4g} mm"
            )
        if circle * math.sin(math.pi / count) <= diameter / 2:
            raise ValueError("there is no room between neighbours")
        if self._thinnest_web(diameter) < LEAST_WEB * diameter:
            raise ValueError("the webs are thinner than a hundredth of a hole")
        return Holes(count, circle, diameter / 2, bearings=self.eccentric.cranks > 1)

    @property
    def _lobe_bending(self) -> float:
        """Return the bending compliance of a pin or lobe (m/N); zero for pins in full-length
        seats.
        """
        material = self.ring_material
        if self.pin_span is not None and RING_PINS not in self.rigid:
            return round_bar_compliance(
                self.pin_span, 2 * self.pin_radius.nominal, material.modulus, material.poisson
            )
        # the ring's body includes its lobes
        if self.form in _LOBES and not self._ring_body and RING_LOBES not in self.rigid:
            # From the root, reached by the disc's tips, to the crest; the forces act at half this
            # height; thickness: that of the arc at its root.
            height, rr = 2 * self.eccentricity.nominal, self.pin_radius.nominal
            root = 2 * rr if height >= rr else 2 * math.sqrt(rr**2 - (rr - height) ** 2)
            return lobe_compliance(height / 2, root, self.width, material.modulus, material.poisson)
        return 0.0

    @property
    def _bearing(self) -> dict[str, Any]:
        """Return the bearing of the eccentric as arguments of the law; with rollers that carry a
        disc off their middle, it includes the tilt.
        """
        eccentric = self.eccentric
        if BEARING in self.rigid or (eccentric.bearing is None and eccentric.rollers is None):
            return {}
        if isinstance(eccentric.bearing, float):
            return {"bearing": eccentric.bearing / (1 + self.tilt_share)}
        if eccentric.bearing is not None:
            size = eccentric.bearing
            number, each = balls_of_size(size.bore, size.outside_diameter)
            exponent = BALL_EXPONENT
        else:
            number, each, exponent = (
                eccentric.rollers or 0,
                roller_stiffness(eccentric.roller_length or 0.0),
                ROLLER_EXPONENT,
            )
        return {
            "elements": number,
            "element_stiffness": each / (1 + self.tilt_share) ** exponent,
            "exponent": exponent,
        }

    @property
    def tilt_share(self) -> float:
        """Return the shift of a disc due to its tilt, over that of its bearing, for a disc off the
        middle of its bearing by u.

        12 u^2/b^2 for rollers of a length b, which resist the tilt with k b^2/12; else u^2 k over
        the stated tilting stiffness.
        """
        eccentric = self.eccentric
        if not eccentric.offset or TILT in self.rigid:
            return 0.0
        if eccentric.tilt is None:
            return 12 * (eccentric.offset / (eccentric.roller_length or math.inf)) ** 2
        return eccentric.offset**2 * self._bearing_stiffness / eccentric.tilt

    @property
    def _bearing_stiffness(self) -> float:
        """Return the stiffness (N/m) of an eccentric bearing under the force at which bearings by
        their size are taken.
        """
        eccentric = self.eccentric
        if isinstance(eccentric.bearing, float):
            return eccentric.bearing
        if eccentric.bearing is not None:
            return stiffness_of_size(
                eccentric.bearing.bore, eccentric.bearing.outside_diameter, self.design_force
            )
        if eccentric.rollers is None or eccentric.roller_length is None:
            return 0.0
        return 1 / needle_compliance(self.design_force, eccentric.rollers, eccentric.roller_length)

    @property
    def design_force(self) -> float:
        """Return the force (N) on a disc's bearing at which springs that stiffen with their load
        are taken as linear.
        """
        return FORCE_WITHOUT_RATING

    @functools.cached_property
    def _disc_body(self) -> ElasticBody | None:
        material, pins, hole = self.disc_material, self.output_pins, self.hole_diameter
        if not self.elastic_bodies or DISC_BODY in self.rigid:
            return None
        if hole is None:
            # holes of unknown size soften a solid disc by a usual factor
            softer = 1.0 if pins is None else math.sqrt(math.prod(HOLES_OF_UNKNOWN_SIZE))
            return ElasticBody(
                "planet", self.bore_radius, material.plate_modulus / softer, material.poisson
            )
        return ElasticBody(
            "planet", self.bore_radius, material.plate_modulus, material.poisson, self._holes(hole)
        )

    @functools.cached_property
    def shaft_springs(self) -> ShaftSprings | None:
        """Return the compliance of the eccentric's shaft by member; None where its dimensions are
        not stated.
        """
        return self._response(self.eccentric.shaft, self.seats)

    def _response(self, shaft: object, seats: dict[str, BearingSeat]) -> ShaftSprings | None:
        if not isinstance(shaft, Shaft) or SHAFT in self.rigid:
            return None
        phases = tuple(2 * math.pi * k / self.discs for k in range(self.discs))
        width, force = self.eccentric.roller_length or 0.0, self.design_force
        return shaft.response(
            ShaftCase(
                tuple(seats.items()), width, phases, self.eccentricity.nominal, force, self.rigid
            )
        )

    def shaft_springs_with(self, old: Material, new: Material) -> ShaftSprings | None:
        """Return the compliance of the eccentric's shaft with another material in the place of
        one.
        """
        shaft = self.eccentric.shaft
        return (
            self._response(with_material(shaft, old, new), with_material(self.seats, old, new))
            if isinstance(shaft, Shaft)
            else None
        )

    @functools.cached_property
    def bore_compliance(self) -> float:
        """Return the shift of the eccentric's bearing in the disc's bore per force (m/N), beyond
        that in the disc's body.
        """
        if self.eccentric.cranks > 1 or BORE in self.rigid or not self._disc_body:
            return 0.0
        fit, radius, material = self.disc.bore_fit, self.bore_radius, self.disc_material
        included: Fit = "bonded" if self.hole_diameter is None else "pressed"
        if self.eccentric.cup is not None:
            return self._cup_compliance(self.eccentric.cup, included)
        # a disc bonded to its bearing with holes is a little stiffer than modelled
        more = max(
            compliance_beyond(
                radius,
                self.width,
                material.plate_modulus,
                material.poisson,
                fit or "snug",
                included,
            ),
            0.0,
        )
        return more if fit is not None else more * math.sqrt(math.prod(BOUNDS))

    def _cup_compliance(self, thickness: float, included: Fit) -> float:
        """Return the shift per force (m/N) that a soft bore and a thin cup in it add to a needle
        bearing, beyond that in the disc's body.
        """
        material, eccentric, force = self.disc_material, self.eccentric, self.design_force
        around = LARGE * self.bore_radius
        bore = Annulus(
            self.bore_radius, around, self.width, material.plate_modulus, material.poisson
        )
        each = roller_stiffness(eccentric.roller_length or 0.0)
        shift, _ = cup_in_bore(
            bore, thickness, eccentric.rollers or 0, each, ROLLER_EXPONENT, force
        )
        return max(
            shift / force - 1 / self._bearing_stiffness - seat_compliance(bore, included), 0.0
        )

    @property
    def shaft_compliance(self) -> float:
        """Return the shift of a disc per force on it (m/N) by the eccentric's shaft with its
        bearings and seats; zero where not specified.
        """
        shaft, springs = self.eccentric.shaft, self.shaft_springs
        if springs is not None:
            return springs.total
        return 1 / shaft if isinstance(shaft, float) and SHAFT not in self.rigid else 0.0

    @property
    def _shaft_clearances(self) -> tuple[tuple[float, Toleranced], ...]:
        """Return the clearance of each bearing of the shaft, with the displacement of the discs
        along their forces per clearance.
        """
        shaft, springs = self.eccentric.shaft, self.shaft_springs
        if springs is None or not isinstance(shaft, Shaft):
            return ()
        return tuple(
            (reaction / self.discs, each.clearance)
            for reaction, each in zip(springs.reactions, shaft.supports, strict=True)
        )

    @property
    def _pin_stiffness(self) -> float:
        """Return the stiffness (N/m) of an output pin at the discs: stated, or of the pin with its
        seats.
        """
        pins = self.output_pins
        if pins is None or pins.stiffness is not None:
            return (
                math.inf
                if pins is None or pins.stiffness is None or PINS in self.rigid
                else pins.stiffness
            )
        soft = sum(middle_compliance(self.pin_limits, self.discs, self.rigid))
        return 1 / soft if soft else math.inf

    @functools.cached_property
    def pin_limits(self) -> tuple[OutputPins, OutputPins]:
        """Return the output pins with the stiffest and with the softest seats that the drawing
        allows. Raises ValueError without output pins.
        """
        if self.output_pins is None:
            raise ValueError("a stage without output pins")
        return self.output_pins.limits(self.ring_material)

    @property
    def hole(self) -> Hole | None:
        """Return the contact of an output pin in its hole; None where the drawing does not state
        the diameter of the pins.
        """
        pins, diameter, disc = self.output_pins, self.hole_diameter, self.disc_material
        if pins is None or diameter is None or pins.outer_diameter is None or HOLES in self.rigid:
            return None
        touching = STEEL if pins.sleeve is not None else pins.pin_material
        return Hole(
            diameter / 2,
            pins.outer_diameter / 2,
            self.width,
            disc.modulus,
            disc.poisson,
            touching.modulus,
            touching.poisson,
        )

    @functools.cached_property
    def _ring_body(self) -> ElasticBody | None:
        if not self.elastic_bodies or RING_BODY in self.rigid:
            return None
        return ElasticBody(
            "ring", self.outer_radius, self.ring_material.plate_modulus, self.ring_material.poisson
        )
