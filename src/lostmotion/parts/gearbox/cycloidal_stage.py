"""One cycloidal stage from its drawing, with tolerances: validation, and the arguments of the laws."""

from __future__ import annotations

import functools
import math
from typing import Annotated, Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from lostmotion.errors import DidNotConvergeError, shown
from lostmotion.laws.contact import equivalent_modulus, lobe_compliance, round_bar_compliance
from lostmotion.laws.cycloid import drive
from lostmotion.laws.cycloid.bodies import Body, flexibility, ring_reach
from lostmotion.laws.cycloid.contact import Flanks
from lostmotion.laws.cycloid.geometry import Stage
from lostmotion.laws.cycloid.output_pins import Hole
from lostmotion.laws.cycloid.seat import compliance_beyond
from lostmotion.laws.cycloid.tolerances import Scatter
from lostmotion.laws.perforated_disc import Holes
from lostmotion.laws.rolling.radial import roller_stiffness
from lostmotion.parts.error_source import ClearanceDim, LengthAmount, LengthPlus
from lostmotion.parts.gearbox.cycloidal_envelope import BranchMethod, branches, check_branches
from lostmotion.parts.gearbox.cycloidal_pins import STEEL, Disc, Fit, OutputPins
from lostmotion.parts.gearbox.cycloidal_shaft import BearingSeat, Eccentric, Named, Shaft, ShaftSprings
from lostmotion.parts.gearbox.cycloidal_temperature import Heated, output_clearance_at_work, relief_at_work
from lostmotion.parts.gearbox.gearbox import Whole, refuse
from lostmotion.parts.link import Material
from lostmotion.parts.provenance import Sourced
from lostmotion.units import Quantity, Toleranced

SizeDim = Annotated[Toleranced, Quantity("m", "77.5 mm ± 5 µm", above=0, toleranced=True, band="uniform")]
# A dimension of either sign.
EitherSign = Annotated[Toleranced, Quantity("m", "-3 µm ± 1 µm", toleranced=True, band="uniform")]
Coefficient = Annotated[float, Quantity("", "0.06", low=0, high=2)]
# Largest difference, m, between a stated size and that which follows from others.
_SAME_SIZE: Final = 1e-6
_LOBES = ("lobe arcs", "lobe envelope")


class Relief(Sourced):
    """Profile modification of the disc, beyond the profile that fits without play: see `laws.cycloid.Modification`.

    roller   by how much the generating roller is larger than the pin
    circle   by how much the generating pin circle is smaller than the real one; below zero: larger, which closes the gaps of `roller`
    """

    roller: ClearanceDim = Toleranced(0.0)
    circle: EitherSign = Toleranced(0.0)


class Friction(Sourced):
    """Coulomb coefficients; default: no friction.

    flank    between disc and pins or lobes: 0.05 to 0.1 sliding in grease, about 0.005 with rollers
    bearing  of the eccentric, at bearing_radius; about 0.002 with rolling elements
    output   of the output pins in their holes
    """

    flank: Coefficient = 0.0
    bearing: Coefficient = 0.0
    bearing_radius: LengthAmount = 0.0
    output: Coefficient = 0.0


class CycloidalStage(Heated):
    """One cycloidal stage from its drawing. Letters of the literature in brackets.

    form           "ring pins" (pins or rollers in the ring), "lobe arcs" and "lobe envelope" (no rolling bodies: lobes of one piece with the
                   ring), or "planet pins" (pins on the planet, lobes in the ring)
    pins           number of pins or lobes of the ring (N), or of pins of the planet
    ring_radius    of the circle of pin centres (R); ± over gearboxes, as for pin_radius (Rr) and eccentricity (e)
    pin_position   ± position of each pin or lobe, radially and tangentially; pin_size ± of its radius; flank_form ± of each disc's flank
    width          of one disc; discs: their number
    disc_bore_radius   inner radius of the elastic disc body; default: a rigid disc
    ring_outer_radius  outer radius of the elastic ring body with its lobes; default: a rigid ring, on which lobes bend
    pin_span       free length of a ring pin held at both ends; default: pins in full-length seats, which do not bend
                   (the model of the ring's body assumes such seats in either case)
    envelope       how the second branch of envelope lobes stiffens the contacts: "rule" or "exact"; default: the rule in its range, exact outside
    disc           holes of the discs
    seats          of the bearings of the eccentric's shaft, by name
    """

    form: Literal["ring pins", "lobe arcs", "lobe envelope", "planet pins"] = "ring pins"
    pins: Annotated[int, Whole("", "40", low=3, high=1000)]
    ring_radius: SizeDim
    pin_radius: SizeDim
    eccentricity: SizeDim
    width: LengthPlus
    discs: Annotated[int, Whole("", "2", low=1, high=4)] = 1
    relief: Relief = Relief()
    pin_position: LengthAmount = 0.0
    pin_size: LengthAmount = 0.0
    flank_form: LengthAmount = 0.0
    disc_material: Material = STEEL
    ring_material: Material = STEEL
    contact_law: Literal["johnson", "palmgren"] = "johnson"
    envelope: BranchMethod | None = None
    disc_bore_radius: LengthPlus | None = None
    ring_outer_radius: LengthPlus | None = None
    pin_span: LengthPlus | None = None
    eccentric: Eccentric = Eccentric()
    output_pins: OutputPins | None = None
    disc: Disc = Disc()
    seats: Annotated[dict[Named, BearingSeat], Field(max_length=16)] = Field(default={})
    friction: Friction | None = None

    @model_validator(mode="after")
    def _can_be_built(self) -> Self:
        try:
            stage = self.stage
        except ValueError as error:
            why = str(error).removeprefix("this cycloidal stage cannot exist: ")
            example = 'pins = 40, ring_radius = "77.5 mm", pin_radius = "4 mm", eccentricity = "1.5 mm"'
            raise refuse(why, "a possible stage", example) from None
        root = stage.tip_radius - 2 * stage.eccentricity
        if self.disc_bore_radius is not None and self.disc_bore_radius >= root:
            why = f"a bore of radius {self.disc_bore_radius * 1e3:g} mm in a disc with a root radius of {root * 1e3:.4g} mm"
            raise refuse(why, "a bore inside the root circle", f'disc_bore_radius = "{root * 500:.3g} mm"')
        if self.ring_outer_radius is not None and self.ring_outer_radius <= ring_reach(stage):
            outside = ring_reach(stage) * 1e3
            reaching = "pins that reach" if self.form == "ring pins" else "lobes with roots"
            why = f"a ring of outer radius {self.ring_outer_radius * 1e3:g} mm around {reaching} out to {outside:.4g} mm"
            raise refuse(why, "a ring around its pins or lobes", f'ring_outer_radius = "{1.2 * outside:.3g} mm"')
        made = self.relief.circle.nominal * (1 if stage.has_planet_pins else -1)
        if stage.eccentricity * stage.pins >= stage.ring_radius + made:
            why = f"a relief of {self.relief.circle.nominal * 1e3:g} mm on the pin circle, with which the profile loops"
            raise refuse(why, "a smaller circle", 'relief = { roller = "4 µm", circle = "-2 µm" }')
        if self.output_pins is not None and self.eccentric.cranks > 1:
            expected = "output pins behind one eccentric, or crankshafts, which carry the output themselves"
            raise refuse("both output pins and several cranks", expected, 'eccentric = { cranks = 3, circle_radius = "36 mm" }')
        if self.contact_law != "johnson" and (self.disc_bore_radius is not None or self.ring_outer_radius is not None):
            # the compliance of the bodies is defined by the depth to which Johnson's law includes them
            raise refuse(
                f'bodies of disc or ring beside contact_law = "{self.contact_law}"', "Johnson's law of contact with them", 'contact_law = "johnson"'
            )
        if self.pin_span is not None and self.form != "ring pins":
            raise refuse(f'pin_span with form = "{self.form}"', "a span of pins in the ring", 'form = "ring pins"')
        if self.disc.bore_fit is not None and (self.disc_bore_radius is None or self.eccentric.cranks > 1):
            raise refuse("bore_fit without the one bore of a central eccentric", "disc_bore_radius, with one crank", 'disc_bore_radius = "12 mm"')
        check_branches(stage, self.envelope)
        self._check_holes()
        self._check_shaft()
        self.check_temperature()
        return self

    def _check_shaft(self) -> None:
        shaft = self.eccentric.shaft
        if not isinstance(shaft, Shaft):
            return
        if len(shaft.disc_at) != self.discs:
            why = f"{len(shaft.disc_at)} places in disc_at for {self.discs} disc{'s' if self.discs > 1 else ''}"
            places = ", ".join(f'"{16 + 12 * k} mm"' for k in range(self.discs))
            raise refuse(why, "the place of every disc on the shaft", f"disc_at = [{places}]")
        strange = [each.seat for each in shaft.supports if each.seat is not None and each.seat not in self.seats]
        if strange:
            known = f"one of {', '.join(self.seats)}" if self.seats else "a seat under seats"
            example = 'seats = { housing = { material = "PETG", width = "5 mm", diameter = "26 mm", outer_diameter = "50 mm" } }'
            raise refuse(f"a support in the seat {shown(strange[0])}, which is not described", known, example)
        try:
            _ = self.shaft_springs
        except ValueError as error:
            raise refuse(f"a shaft for which {error}", "a shaft that its supports hold", 'supports = [{ at = "0 mm" }, { at = "43 mm" }]') from None

    def _check_holes(self) -> None:
        holes, pins = self.disc.holes, self.output_pins
        if holes is None:
            return
        if pins is None or pins.outer_diameter is None:
            raise refuse(
                "disc holes without output pins of a stated diameter", "output pins for the holes", 'diameter = "12 mm", free_length = "14 mm"'
            )
        differing = [name for name in ("count", "circle_radius") if getattr(holes, name) not in (None, getattr(pins, name))]
        if differing:
            raise refuse(f"holes with another {' and '.join(differing)} than the output pins", "the same, or only the diameter", 'diameter = "12 mm"')
        fitting = pins.outer_diameter + 2 * self.eccentricity.nominal + pins.clearance.nominal
        if abs(holes.diameter - fitting) > _SAME_SIZE:
            why = f"holes of {holes.diameter * 1e3:.6g} mm, where pin, twice the eccentricity and clearance make {fitting * 1e3:.6g} mm"
            raise refuse(why, "holes that fit the pins with their clearance", f'diameter = "{fitting * 1e3:.6g} mm"')
        body = self._disc_body
        if body is not None:
            try:
                flexibility(self.stage, body, self.width, np.zeros(1))
            except (ValueError, DidNotConvergeError) as error:
                raise refuse(f"disc holes for which {error}", "holes with webs around them", 'holes = { diameter = "12.1 mm" }') from None

    def __hash__(self) -> int:
        """Return a hash of all fields except the seats, which are a mapping; equal stages have the same."""
        return hash(tuple(getattr(self, name) for name in type(self).model_fields if name != "seats"))

    @functools.cached_property
    def stage(self) -> Stage:
        """Return the geometry."""
        return Stage(self.ring_radius.nominal, self.pin_radius.nominal, self.eccentricity.nominal, self.pins, self.form)

    @property
    def rigid_in_stage(self) -> tuple[str, ...]:
        """Return the members whose stiffness the drawing does not specify; they are assumed rigid."""
        eccentric, pins = self.eccentric, self.output_pins
        supports = eccentric.shaft.supports if isinstance(eccentric.shaft, Shaft) else ()
        specified = {
            "ring pins": self.pin_span is not None or self.form != "ring pins",
            "planet pins": self.form != "planet pins",
            "disc body": self.disc_bore_radius is not None,
            "ring body": self.ring_outer_radius is not None,
            "eccentric bearing": eccentric.bearing is not None or eccentric.rollers is not None,
            "eccentric shaft": eccentric.shaft is not None,
            "bearings of the eccentric shaft": all(each.bearing is not None for each in supports),
            "seats of the eccentric shaft": all(each.seat is not None for each in supports),
            "output pins": eccentric.cranks > 1 or (pins is not None and (pins.stiffness is not None or pins.diameter is not None)),
            # a stated stiffness includes them
            "seats of the output pins": pins is None or pins.diameter is None or pins.seat is not None,
            "holes of the output pins": pins is None or pins.diameter is None or self.disc.holes is not None,
        }
        return tuple(name for name, stated in specified.items() if not stated)

    @functools.cached_property
    def drive(self) -> drive.Drive:
        """Return the arguments of the laws of the loaded stage."""
        disc, ring = self.disc_material, self.ring_material
        modulus, both = equivalent_modulus(disc.young, disc.poisson, ring.young, ring.poisson), branches(self.stage, self.envelope)
        flanks = Flanks(self.width, modulus, self.contact_law, self._lobe_bending, branches=both.stiffening if both else 1.0)
        eccentric = self.eccentric
        rollers = eccentric.rollers or 0
        springs = drive.Eccentric(
            bearing=eccentric.bearing or math.inf,
            elements=rollers,
            element_stiffness=roller_stiffness(eccentric.roller_length) if eccentric.roller_length else math.inf,
            shaft=self._shaft_stiffness,
            cranks=eccentric.cranks,
            circle=eccentric.circle_radius or math.inf,
        )
        pins = self.output_pins
        output = None if pins is None else drive.OutputPins(pins.count, pins.circle_radius, self._pin_stiffness)
        return drive.Drive(self.stage, flanks, relief_at_work(self), self.discs, springs, output, self._disc_body, self._ring_body)

    @property
    def scatter(self) -> Scatter:
        """Return the tolerances of the dimensions over gearboxes."""
        return Scatter(
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

    @property
    def _lobe_bending(self) -> float:
        """Return the bending compliance of a pin or lobe (m/N); zero for pins in full-length seats."""
        material = self.ring_material
        if self.pin_span is not None:
            return round_bar_compliance(self.pin_span, 2 * self.pin_radius.nominal, material.young, material.poisson)
        if self.form in _LOBES and self.ring_outer_radius is None:  # the ring's body includes its lobes
            # From the root, reached by the disc's tips, to the crest; the forces act at half this height; thickness: that of the arc at its root.
            height, rr = 2 * self.eccentricity.nominal, self.pin_radius.nominal
            root = 2 * rr if height >= rr else 2 * math.sqrt(rr**2 - (rr - height) ** 2)
            return lobe_compliance(height / 2, root, self.width, material.young, material.poisson)
        return 0.0

    @property
    def _disc_body(self) -> Body | None:
        if self.disc_bore_radius is None:
            return None
        material, pins = self.disc_material, self.output_pins
        holes = None if self.disc.holes is None or pins is None else Holes(pins.count, pins.circle_radius, self.disc.holes.diameter / 2)
        return Body("planet", self.disc_bore_radius, material.young, material.poisson, holes)

    @functools.cached_property
    def shaft_springs(self) -> ShaftSprings | None:
        """Return the compliance of the eccentric's shaft by member; None where its dimensions are not stated."""
        shaft = self.eccentric.shaft
        if not isinstance(shaft, Shaft):
            return None
        phases = tuple(2 * math.pi * k / self.discs for k in range(self.discs))
        return shaft.response(self.seats, self.eccentric.roller_length or 0.0, phases, self.eccentricity.nominal)

    @functools.cached_property
    def bore_compliance(self) -> float:
        """Return the shift of the eccentric's bearing in the disc's bore per force (m/N), beyond that in the disc's body."""
        fit, radius, material = self.disc.bore_fit, self.disc_bore_radius, self.disc_material
        if fit is None or radius is None:
            return 0.0
        included: Fit = "bonded" if self.disc.holes is None else "pressed"
        # a disc bonded to its bearing with holes is a little stiffer than modelled
        return max(compliance_beyond(radius, self.width, material.young, material.poisson, fit, included), 0.0)

    @property
    def shaft_compliance(self) -> float:
        """Return the shift of a disc per force on it (m/N) by the eccentric's shaft with its bearings and seats; zero where not specified."""
        shaft, springs = self.eccentric.shaft, self.shaft_springs
        if springs is not None:
            return springs.total
        return 0.0 if shaft is None or isinstance(shaft, Shaft) else 1 / shaft

    @property
    def _shaft_stiffness(self) -> float:
        shaft = self.eccentric.shaft
        if not self.bore_compliance and isinstance(shaft, float):
            return shaft
        soft = self.shaft_compliance + self.bore_compliance
        return 1 / soft if soft else math.inf

    @property
    def _shaft_clearances(self) -> tuple[tuple[float, Toleranced], ...]:
        """Return the clearance of each bearing of the shaft, with the displacement of the discs along their forces per clearance."""
        shaft, springs = self.eccentric.shaft, self.shaft_springs
        if springs is None or not isinstance(shaft, Shaft):
            return ()
        return tuple((reaction / self.discs, each.clearance) for reaction, each in zip(springs.reactions, shaft.supports, strict=True))

    @property
    def _pin_stiffness(self) -> float:
        """Return the stiffness (N/m) of an output pin at the discs: stated, or of the pin with its seats."""
        pins = self.output_pins
        if pins is None or pins.stiffness is not None:
            return math.inf if pins is None or pins.stiffness is None else pins.stiffness
        soft = sum(pins.compliance(self.discs))
        return 1 / soft if soft else math.inf

    @property
    def hole(self) -> Hole | None:
        """Return the contact of an output pin in its hole; None where the drawing does not state the holes."""
        pins, holes, disc = self.output_pins, self.disc.holes, self.disc_material
        if pins is None or holes is None or pins.outer_diameter is None:
            return None
        touching = STEEL if pins.sleeve is not None else pins.pin_material
        return Hole(holes.diameter / 2, pins.outer_diameter / 2, self.width, disc.young, disc.poisson, touching.young, touching.poisson)

    @property
    def _ring_body(self) -> Body | None:
        if self.ring_outer_radius is None:
            return None
        return Body("ring", self.ring_outer_radius, self.ring_material.young, self.ring_material.poisson)
