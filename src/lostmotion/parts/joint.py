"""A joint unit: one motion, and the gearbox, bearing, encoder and link that belong to it."""

from __future__ import annotations

import functools
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Final, Generic, Literal, TypeVar

import numpy as np
from pydantic import AfterValidator, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from lostmotion.errors import shown
from lostmotion.laws.distributions import Normal
from lostmotion.parts.bearing.crossed_roller import CrossedRoller
from lostmotion.parts.bearing.crossed_rollers import CrossedRollerBearing
from lostmotion.parts.bearing.pair import BallPair, RollerPair
from lostmotion.parts.bearing.rolling import RollingPair
from lostmotion.parts.bearing.rolling_contact import DrawnBearing
from lostmotion.parts.encoder import Encoder
from lostmotion.parts.error_source import AngleAmount, ErrorSource, Grouped, LengthAmount, Mass, Part
from lostmotion.parts.forms import Constant
from lostmotion.parts.gearbox.gearbox import AmountT, Loose, PlayInLoop
from lostmotion.parts.gearbox.kinds import SlidingDrive, TurningGearbox
from lostmotion.parts.link import Direction, ElasticLink, Frame, Link, Vector, unit
from lostmotion.parts.lumped import Lumped
from lostmotion.parts.provenance import Sourced
from lostmotion.parts.standard_terms import limit_terms, parameter
from lostmotion.spatial import across
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion, Term
    from lostmotion.spatial import Floats

GearboxT = TypeVar("GearboxT", bound=TurningGearbox | SlidingDrive)
Bearing = Annotated[RollingPair | CrossedRoller | BallPair | RollerPair | CrossedRollerBearing, Field(discriminator="kind")]


# What a bearing has only where something turns in it, and where it is not the drive that holds the axis.
_TURNING_ONLY: Final = ("axial_play", "axial_stiffness", "radial_runout", "axial_runout")


def _refuse(why: str, expected: str, example: str) -> PydanticCustomError:
    return PydanticCustomError("limits", "{why}", {"why": why, "expected": expected, "example": example})


def _rising(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] >= limits[1]:
        why = f"limits from {limits[0]:g} to {limits[1]:g} (rad or m)"
        raise _refuse(why, "a lower limit below the upper one", 'limits = ["-90 deg", "90 deg"]')
    return limits


# Each end with an example of its own, so that an example made of both is a range.
_Turning = tuple[Annotated[float, Quantity("rad", "-90 deg")], Annotated[float, Quantity("rad", "90 deg")]]
_Sliding = tuple[Annotated[float, Quantity("m", "0 mm")], Annotated[float, Quantity("m", "300 mm")]]
TurningLimits = Annotated[_Turning, AfterValidator(_rising)]
SlidingLimits = Annotated[_Sliding, AfterValidator(_rising)]

LONGEST_JOINT_NAME: Final = 80


def _is_name(text: str) -> str:
    if not text.isprintable() or text != text.strip() or not text:
        context = {
            "why": shown(text),
            "expected": f"a name in one line of printable text, without blanks at its ends, at most {LONGEST_JOINT_NAME} characters",
            "example": '"shoulder"',
        }
        raise PydanticCustomError("line", "{why}", context)
    return text


# Any name that a URDF may have: `joint_3.0`, `r2/fixed/waist`.
Name = Annotated[str, Field(max_length=LONGEST_JOINT_NAME), AfterValidator(_is_name)]

# The name of a place: "base", a joint's own, or that with ".seat" or ".tip" behind it.
PlaceName = Annotated[
    str,
    Field(max_length=LONGEST_JOINT_NAME + len(".seat"), description="a place that comes before: base, or NAME.seat, NAME or NAME.tip of a joint"),
    AfterValidator(_is_name),
]


class Mounting(Sourced, ErrorSource):
    """How exactly the joint's axis lies in the link before: ± tilt about, and ± offset along, the two directions across it."""

    tilt: AngleAmount = 0.0
    offset: LengthAmount = 0.0

    def terms(self, motion: Motion) -> list[Term]:
        """Return the errors of the axis in the seat's frame, which does not turn with the joint."""
        tilt, offset = parameter("axis tilt", self.tilt, "rad"), parameter("axis offset", self.offset, "m")
        law = Normal()
        out: list[Term] = []
        for k, direction in enumerate(across(motion.axis), 1):
            if self.tilt:
                turn = Constant(np.concatenate([direction, np.zeros(3)]))
                out += limit_terms(f"axis tilt {k}", turn, self.tilt, law, tilt, cause="axis tilt")
            if self.offset:
                shift = Constant(np.concatenate([np.zeros(3), direction]))
                out += limit_terms(f"axis offset {k}", shift, self.offset, law, offset, cause="axis offset")
        return out


class _Joint(Sourced):
    """What every joint has, moving or not.

    after  name of the place that it stands on: "base", or NAME.seat, NAME or NAME.tip of a joint before. Left out: the tip of the joint before, the
           base for the first joint
    mass   of the joint unit, its gearbox included; it sits on the seat, at centre_of_mass. Left out: the gearbox's own mass, where it states one
    """

    name: Name
    after: PlaceName | None = None
    origin: Frame = Frame()
    mounting: Mounting | None = None
    mass: Mass | None = None
    centre_of_mass: Vector = (0.0, 0.0, 0.0)
    link: Link = Link()

    @property
    def total_mass(self) -> float:
        """Return the mass (kg) at the joint: as stated, which includes its gearbox, or else the gearbox's own; none where neither is stated."""
        if self.mass is not None:
            return self.mass
        gearbox = getattr(self, "gearbox", None)
        return 0.0 if gearbox is None or gearbox.mass is None else float(gearbox.mass)

    @property
    @abstractmethod
    def twist(self) -> Floats:
        """Give the joint's unit motion (6,), zero where nothing moves."""

    @functools.cached_property
    def elastic_link(self) -> ElasticLink:
        """Give the link as it stands behind this joint, whose axis says how its section lies."""
        return self.link.with_joint_axis(self.twist[:3] if self.twist[:3].any() else self.twist[3:])


class FixedJoint(_Joint):
    """A joint that does not move."""

    type: Literal["fixed"] = "fixed"

    @property
    def twist(self) -> Floats:
        """Give no motion (6,)."""
        return np.zeros(6)

    @property
    def sources(self) -> dict[str, ErrorSource]:
        """Give no sources: nothing moves."""
        return {}


def _lead_of(part: Part) -> float | None:
    """Give the lead of a drive or encoder; kinds that only turn have no such field."""
    lead: float | None = getattr(part, "lead", None)
    return lead


class _MovingJoint(_Joint, Generic[AmountT, GearboxT]):
    axis: Direction = "z"
    bearing: Bearing | None = None
    lumped: Lumped | None = None
    gearbox: GearboxT | None = None
    encoder: Encoder[AmountT] | None = None

    @functools.cached_property
    def sources(self) -> dict[str, ErrorSource]:
        """Return the parts that err, by name, one of several sources by each; of a gearbox with an encoder on its output only open play."""
        gearbox, encoder = self.gearbox, self.encoder
        if encoder is not None and gearbox is not None:
            own = {"ratio": encoder.ratio or abs(gearbox.ratio), "lead": encoder.lead or _lead_of(gearbox)}
            encoder = encoder.model_copy(update=own)
        in_loop = encoder is not None and encoder.side == "output"
        found = {"gearbox": None if in_loop else gearbox, "bearing": self.bearing, "encoder": encoder, "lumped": self.lumped}
        out: dict[str, ErrorSource] = {}
        for name, source in found.items():
            if isinstance(source, Grouped):
                out |= {f"{name} {member}": one for member, one in source.members.items()}
            elif source is not None:
                out[name] = source
        return out if not in_loop or gearbox is None or encoder is None else self._left_open(gearbox, encoder.dead_band) | out

    @staticmethod
    def _left_open(gearbox: TurningGearbox | SlidingDrive, dead_band: float | None) -> dict[str, ErrorSource]:
        """Return the play of a gearbox in the loop of an encoder on its output, where it has any, and nothing else of it."""
        loose = gearbox.members.get("play") if isinstance(gearbox, Grouped) else gearbox
        return {"gearbox": PlayInLoop(loose, dead_band)} if isinstance(loose, Loose) and loose.play.nominal else {}

    @property
    def corrected(self) -> bool:
        """Return whether an encoder on the output lets the controller correct what the gearbox does."""
        return self.gearbox is not None and self.encoder is not None and self.encoder.side == "output"


class RevoluteJoint(_MovingJoint[AngleAmount, TurningGearbox]):
    """A joint that turns about `axis` between `limits`."""

    type: Literal["revolute"] = "revolute"
    limits: TurningLimits

    @field_validator("gearbox", "encoder")
    @classmethod
    def _has_no_lead(cls, part: TurningGearbox | Encoder[AngleAmount] | None) -> TurningGearbox | Encoder[AngleAmount] | None:
        if part is not None and _lead_of(part) is not None:
            raise _refuse("a lead on a turning joint", "a lead on sliding joints only", 'type = "prismatic"')
        return part

    @functools.cached_property
    def twist(self) -> Floats:
        """Give the unit rotation about the axis (6,)."""
        return np.concatenate([unit(self.axis), np.zeros(3)])


class PrismaticJoint(_MovingJoint[LengthAmount, SlidingDrive]):
    """A joint that slides along `axis` between `limits`; its drive's screw or pulley makes a turn per `lead`."""

    type: Literal["prismatic"] = "prismatic"
    limits: SlidingLimits

    @field_validator("bearing")
    @classmethod
    def _only_guides(cls, bearing: Bearing | None) -> Bearing | None:
        if isinstance(bearing, DrawnBearing):
            raise _refuse(f"a {bearing.kind} on a sliding joint", "a guide: nothing turns there", 'bearing = { kind = "rolling", span = "80 mm" }')
        fields = type(bearing).model_fields if bearing is not None else {}
        nowhere = [name for name in _TURNING_ONLY if name in fields and getattr(bearing, name) != fields[name].default]
        if nowhere:
            raise _refuse(
                f"{' and '.join(nowhere)} of a bearing on a sliding joint",
                "a guide without them: it does not turn, and along the slide the drive holds and gives",
                'gearbox = { backlash = "10 µm", stiffness = "200 N/µm" }',
            )
        return bearing

    @field_validator("gearbox")
    @classmethod
    def _waves_have_a_lead(cls, drive: SlidingDrive | None) -> SlidingDrive | None:
        if drive is not None and drive.transmission_error is not None and drive.lead is None:
            example = 'gearbox = { transmission_error = "20 µm", lead = "10 mm" }'
            raise _refuse("transmission_error without a lead on a sliding joint", "lead, the travel per turn of the screw or pulley", example)
        return drive

    @field_validator("encoder")
    @classmethod
    def _encoder_turns(cls, encoder: Encoder[LengthAmount] | None, info: ValidationInfo) -> Encoder[LengthAmount] | None:
        if encoder is None or not encoder.eccentricity:
            return encoder
        if encoder.side == "output":
            example = 'encoder = { side = "output", zero = "20 µm" }'
            raise _refuse("eccentricity of an encoder along the slide", "no eccentricity: a scale does not turn", example)
        drive = info.data.get("gearbox")
        if "gearbox" in info.data and encoder.lead is None and (drive is None or drive.lead is None):
            expected = "lead, the travel per turn of the screw or pulley, of the gearbox or of the encoder"
            raise _refuse("eccentricity without a lead on a sliding joint", expected, 'gearbox = { lead = "10 mm" }')
        return encoder

    @functools.cached_property
    def twist(self) -> Floats:
        """Give the unit shift along the axis (6,)."""
        return np.concatenate([np.zeros(3), unit(self.axis)])


Joint = Annotated[RevoluteJoint | PrismaticJoint | FixedJoint, Field(discriminator="type")]
