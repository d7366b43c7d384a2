"""One cycloidal stage as its drawing states it: dimensions with tolerances, and usual values of
those that it does not state.
"""

from __future__ import annotations

import functools
import math
from typing import Annotated, Any, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from lostmotion.errors import nearest, shown
from lostmotion.laws.cycloid.bodies import ring_reach
from lostmotion.laws.cycloid.stage import Stage
from lostmotion.laws.process_tolerance import Process
from lostmotion.parts.error_source import ClearanceDim, Expansion, LengthAmount, LengthPlus
from lostmotion.parts.gearbox.counts import Whole
from lostmotion.parts.gearbox.cycloidal.eccentric import Eccentric
from lostmotion.parts.gearbox.cycloidal.envelope import BranchMethod, check_branches
from lostmotion.parts.gearbox.cycloidal.names import FRAME, STAGE_MEMBERS
from lostmotion.parts.gearbox.cycloidal.pins import STEEL, Disc, OutputPins
from lostmotion.parts.gearbox.cycloidal.process import reasons, tolerances_by_process
from lostmotion.parts.gearbox.cycloidal.seats import BearingSeat, BearingSize, Named
from lostmotion.parts.gearbox.gearbox import refuse
from lostmotion.parts.link import Material
from lostmotion.parts.provenance import Sourced
from lostmotion.units import Quantity, Toleranced

SizeDim = Annotated[
    Toleranced, Quantity("m", "77.5 mm ± 5 µm", above=0, toleranced=True, band="uniform")
]
# A dimension of either sign.
EitherSign = Annotated[Toleranced, Quantity("m", "-3 µm ± 1 µm", toleranced=True, band="uniform")]
Coefficient = Annotated[float, Quantity("", "0.06", low=0, high=2)]
# Bore of a disc over its ring's radius, outer radius of a ring over the reach of its teeth, and
# radius of the hole of a crank's bearing over the room around it, where the drawing does not state
# them; and the share of the room inside the holes or roots that the bore takes at most.
_USUAL_BORE: Final = 0.35
_USUAL_RING: Final = 1.25
_USUAL_HOLE: Final = 0.6
_ROOM: Final = 0.8
# What is expected in place of a number of lobes.
_ONE_TOOTH: Final = (
    (
        "pins alone: the disc in a ring of N pins has N - 1 lobes, the ring around a planet of N "
        "pins N + 1. A difference of two or more is not modelled"
    ),
    "pins = 24",
)


class Relief(Sourced):
    """Profile modification of the disc, beyond the profile that fits without play: see
    `laws.cycloid.Modification`.

    roller   by how much the generating roller is larger than the pin
    circle   by how much the generating pin circle is smaller than the real one; below zero: larger,
             which closes the gaps of `roller`
    """

    roller: ClearanceDim = Toleranced(0.0)
    circle: EitherSign = Toleranced(0.0)


class StageFriction(Sourced):
    """Coulomb coefficients; default: no friction.

    flank    between disc and pins or lobes: 0.05 to 0.1 sliding in grease, about 0.005 with rollers
    bearing  of the eccentric, at bearing_radius; about 0.002 with rolling elements
    output   of the output pins in their holes
    """

    flank: Coefficient = 0.0
    bearing: Coefficient = 0.0
    bearing_radius: LengthAmount = 0.0
    output: Coefficient = 0.0


class Heated(Sourced):
    """The temperature of a stage.

    ring_expansion    thermal expansion of the body of the ring, 1/K; default: that of
                      ring_material, which is that of ring pins too
    temperature_rise  of the stage above the temperature of its drawing; default: that of the arm
    """

    ring_expansion: Expansion | None = None
    temperature_rise: Annotated[float, Quantity("K", "15 K", low=-200, high=200)] | None = None


class StageDimensions(Heated):
    """One cycloidal stage from its drawing. Letters of the literature in brackets.

    form           "ring pins" (pins or rollers in the ring), "lobe arcs" and "lobe envelope" (no
                   rolling bodies: lobes of one piece with the ring), or "planet pins" (pins on the
                   planet, lobes in the ring)
    pins           number of pins or lobes of the ring (N), or of pins of the planet
    ring_radius    of the circle of pin centres (R); ± over gearboxes, as for pin_radius (Rr) and
                   eccentricity (e)
    pin_position   ± position of each pin or lobe, radially and tangentially; pin_size ± of its
                   radius; flank_form ± of each disc's flank
    width          of one disc; discs: their number
    disc_bore_radius   inner radius of the disc; default: that of the central eccentric's bearing by
                       size, else 0.35 times the ring radius
    ring_outer_radius  outer radius of the ring, held there; default: 1.25 times the reach of its
                       teeth or of the seats of its pins
    pin_span       free length of a ring pin held at both ends; default: pins in full-length seats,
                   which do not bend
                   (the model of the ring's body assumes such seats in either case)
    envelope       how the second branch of envelope lobes stiffens the contacts: "rule" or "exact";
                   default: the rule in its range, exact outside
    disc           holes and bore of the discs
    seats          of the bearings of the eccentric's shaft, by name
    rigid          names of members declared rigid, as the results list them
    process        that makes disc and ring: its tolerances count where none are stated ("IT7", "ISO
                   2768 m", "FFF")
    """

    not_modelled: ClassVar[dict[str, tuple[str, str]]] = dict.fromkeys(
        ("lobes", "tooth_difference", "teeth_difference"), _ONE_TOOTH
    )
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
    friction: StageFriction | None = None
    rigid: Annotated[tuple[Named, ...], Field(max_length=40)] = ()
    process: Process | None = None
    # Names that `rigid` may list.
    may_be_rigid: ClassVar[tuple[str, ...]] = STAGE_MEMBERS

    @model_validator(mode="before")
    @classmethod
    def _pins_of_holes(cls, stated: Any) -> Any:  # noqa: ANN401 - whatever a file holds
        """Take number and circle of the output pins from the holes of the disc, where only these
        state them.
        """
        pins, disc = (
            (stated.get(key) for key in ("output_pins", "disc"))
            if isinstance(stated, dict)
            else (None, None)
        )
        holes = disc.get("holes") if isinstance(disc, dict) else None
        if not isinstance(pins, dict) or not isinstance(holes, dict):
            return stated
        return {
            **stated,
            "output_pins": {
                **{key: holes[key] for key in ("count", "circle_radius") if key in holes},
                **pins,
            },
        }

    @model_validator(mode="after")
    def _can_be_built(self) -> Self:
        try:
            stage = self.stage
        except ValueError as error:
            why = str(error).removeprefix("this cycloidal stage cannot exist: ")
            example = (
                'pins = 40, ring_radius = "77.5 mm", pin_radius = "4 mm", eccentricity = "1.5 mm"'
            )
            raise refuse(why, "a possible stage", example) from None
        root = self.root_radius
        if self.disc_bore_radius is not None and self.disc_bore_radius >= root:
            why = (
                f"a bore of radius {self.disc_bore_radius * 1e3:g} mm in a disc with a root radius "
                f"of {root * 1e3:.4g} mm"
            )
            raise refuse(
                why, "a bore inside the root circle", f'disc_bore_radius = "{root * 500:.3g} mm"'
            )
        if self.ring_outer_radius is not None and self.ring_outer_radius <= ring_reach(stage):
            outside = ring_reach(stage) * 1e3
            reaching = "pins that reach" if self.form == "ring pins" else "lobes with roots"
            why = (
                f"a ring of outer radius {self.ring_outer_radius * 1e3:g} mm around {reaching} out "
                f"to {outside:.4g} mm"
            )
            raise refuse(
                why,
                "a ring around its pins or lobes",
                f'ring_outer_radius = "{1.2 * outside:.3g} mm"',
            )
        made = self.relief.circle.nominal * (1 if stage.has_planet_pins else -1)
        if stage.eccentricity * stage.pins >= stage.ring_radius + made:
            why = (
                f"a relief of {self.relief.circle.nominal * 1e3:g} mm on the pin circle, with "
                "which the profile loops"
            )
            raise refuse(why, "a smaller circle", 'relief = { roller = "4 µm", circle = "-2 µm" }')
        if self.output_pins is not None and self.eccentric.cranks > 1:
            expected = (
                "output pins behind one eccentric, or crankshafts, which carry the output "
                "themselves"
            )
            raise refuse(
                "both output pins and several cranks",
                expected,
                'eccentric = { cranks = 3, circle_radius = "36 mm" }',
            )
        if self.contact_law != "johnson" and (
            self.disc_bore_radius is not None or self.ring_outer_radius is not None
        ):
            # the compliance of the bodies is defined by the depth to which Johnson's law includes
            # them
            raise refuse(
                f'bodies of disc or ring beside contact_law = "{self.contact_law}"',
                "Johnson's law of contact with them",
                'contact_law = "johnson"',
            )
        if self.pin_span is not None and self.form != "ring pins":
            raise refuse(
                f'pin_span with form = "{self.form}"',
                "a span of pins in the ring",
                'form = "ring pins"',
            )
        if self.disc.bore_fit is not None and self.eccentric.cranks > 1:
            raise refuse(
                "bore_fit with several cranks",
                "the one bore of a central eccentric",
                'eccentric = { bearing = "40 N/µm" }',
            )
        check_branches(stage, self.envelope)
        strange = [name for name in self.rigid if name not in self.may_be_rigid]
        if strange:
            near = nearest(strange[0], self.may_be_rigid)
            raise refuse(
                f"{shown(strange[0])} in rigid",
                f"names of members: {', '.join(self.may_be_rigid)}",
                f'rigid = ["{near or FRAME}"]',
            )
        return self

    @model_validator(mode="after")
    def _process_makes_its_sizes(self) -> Self:
        try:
            _ = self.process_tolerances
        except ValueError as error:
            raise refuse(
                str(error), "a process with tolerances for these sizes", 'process = "IT7"'
            ) from None
        return self

    @property
    def process_tolerances(self) -> dict[str, float]:
        """Return the tolerances (m) that the process sets where the drawing states none, by key."""
        return {} if self.process is None else tolerances_by_process(self.process, self)

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the tolerances of the
        process.
        """
        return {
            **super().assumptions,
            **({} if self.process is None else reasons(self.process, self.process_tolerances)),
        }

    def __hash__(self) -> int:
        """Return a hash of all fields except mappings; equal stages have the same."""
        return hash(
            tuple(
                value
                for name in type(self).model_fields
                if not isinstance(value := getattr(self, name), dict)
            )
        )

    @functools.cached_property
    def stage(self) -> Stage:
        """Return the geometry."""
        return Stage(
            self.ring_radius.nominal,
            self.pin_radius.nominal,
            self.eccentricity.nominal,
            self.pins,
            self.form,
        )

    @property
    def elastic_bodies(self) -> bool:
        """Return whether the bodies of disc and ring are modelled: with Johnson's law of contact,
        which defines where they begin.
        """
        return self.contact_law == "johnson"

    @property
    def pin_clearance(self) -> Toleranced:
        """Return the clearance of the output pins, stated, or else the room that stated holes
        leave.
        """
        pins, holes = self.output_pins, self.disc.holes
        if (
            pins is None
            or holes is None
            or pins.outer_diameter is None
            or "clearance" in pins.model_fields_set
        ):
            return Toleranced(0.0) if pins is None else pins.clearance
        return Toleranced(
            max(holes.diameter - pins.outer_diameter - 2 * self.eccentricity.nominal, 0.0)
        )

    @property
    def hole_diameter(self) -> float | None:
        """Return the diameter (m) of the holes for the output pins, stated or as it follows from
        the pins; None without their diameter.

        With several cranks that of the holes for their bearings: stated, that of a bearing by its
        size, or a usual one.
        """
        pins, bearing, circle = (
            self.output_pins,
            self.eccentric.bearing,
            self.eccentric.circle_radius,
        )
        if self.disc.holes is not None:
            return self.disc.holes.diameter
        if circle is not None:
            if isinstance(bearing, BearingSize):
                return bearing.outside_diameter
            around = min(
                self.root_radius - circle,
                circle * math.sin(math.pi / self.eccentric.cranks),
                circle - (self.disc_bore_radius or 0.0),
            )
            return 2 * _USUAL_HOLE * around
        if pins is None or pins.outer_diameter is None:
            return None
        return pins.outer_diameter + 2 * self.eccentricity.nominal + pins.clearance.nominal

    @property
    def root_radius(self) -> float:
        """Return the radius (m) of the root circle of the disc, or of the pins of a planet, inside
        which a disc is whole.
        """
        return self.stage.tip_radius - 2 * self.stage.eccentricity

    @property
    def bore_radius(self) -> float:
        """Return the radius (m) of the disc's bore, stated, that of the eccentric's bearing, or a
        usual one.
        """
        if self.disc_bore_radius is not None:
            return self.disc_bore_radius
        room, hole = self.root_radius, self.hole_diameter
        circle = self.eccentric.circle_radius or (
            self.output_pins.circle_radius if self.output_pins is not None else None
        )
        if circle is not None and hole is not None:
            room = min(room, circle - hole / 2)
        bearing = self.eccentric.bearing
        if (
            isinstance(bearing, BearingSize)
            and self.eccentric.cranks == 1
            and bearing.outside_diameter / 2 < room
        ):
            return bearing.outside_diameter / 2
        return min(_USUAL_BORE * self.stage.ring_radius, _ROOM * room)

    @property
    def outer_radius(self) -> float:
        """Return the outer radius (m) of the ring, stated or a usual one."""
        return (
            self.ring_outer_radius
            if self.ring_outer_radius is not None
            else _USUAL_RING * ring_reach(self.stage)
        )
