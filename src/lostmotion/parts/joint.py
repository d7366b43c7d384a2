"""A joint unit: one motion, with its gearbox, bearing, encoder and link."""

from __future__ import annotations

import functools
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Generic, Literal, Self, TypeVar

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from lostmotion.errors import shown
from lostmotion.parts.bearing.crossed_roller import CrossedRoller
from lostmotion.parts.bearing.crossed_rollers import CrossedRollerBearing
from lostmotion.parts.bearing.pair import BallPair, RollerPair
from lostmotion.parts.bearing.rigid import RigidBearing, of_rigid_kind
from lostmotion.parts.bearing.rolling import RollingPair
from lostmotion.parts.bearing.rolling_contact import DrawnBearing
from lostmotion.parts.encoder import Encoder
from lostmotion.parts.error_source import (
    AngleAmount,
    ErrorSource,
    Grouped,
    LengthAmount,
    Mass,
    Part,
    Price,
)
from lostmotion.parts.gearbox.gearbox import AmountT
from lostmotion.parts.gearbox.kinds import SlidingDrive, TurningGearbox, is_drawn
from lostmotion.parts.gearbox.play_in_loop import play_left_open
from lostmotion.parts.gearbox.slide import SlideFigures
from lostmotion.parts.guideway import Guideway
from lostmotion.parts.link import Direction, ElasticLink, Frame, Link, Vector, unit
from lostmotion.parts.lumped import Lumped
from lostmotion.parts.mounting import Mounting
from lostmotion.parts.provenance import OfClass
from lostmotion.parts.servo import Servo
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.spatial import Floats
    from lostmotion.units import Toleranced

GearboxT = TypeVar("GearboxT", bound=TurningGearbox | SlidingDrive)
Bearing = Annotated[
    RollingPair | CrossedRoller | BallPair | RollerPair | CrossedRollerBearing | RigidBearing,
    Field(discriminator="kind"),
    BeforeValidator(of_rigid_kind),
]


# Fields of a bearing for turning joints only; along a slide the drive carries the load.
# Fields of a drive or an encoder for sliding joints only.
_SLIDING_ONLY: Final = ("lead", "lead_error", "scale_error")
_TURNING_ONLY: Final = ("axial_play", "axial_stiffness", "radial_runout", "axial_runout")


def _refuse(why: str, expected: str, example: str) -> PydanticCustomError:
    return PydanticCustomError(
        "limits", "{why}", {"why": why, "expected": expected, "example": example}
    )


def _rising(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] >= limits[1]:
        context = {
            "expected": "a lower limit below the upper one",
            "example": 'limits = ["-90 deg", "90 deg"]',
        }
        raise PydanticCustomError(
            "rising",
            "limits from {low} to {high} (rad or m)",
            {"low": limits[0], "high": limits[1], **context},
        )
    return limits


# Each end has its own example, so that the example of both is a range.
_Turning = tuple[
    Annotated[float, Quantity("rad", "-90 deg")], Annotated[float, Quantity("rad", "90 deg")]
]
_Sliding = tuple[Annotated[float, Quantity("m", "0 mm")], Annotated[float, Quantity("m", "300 mm")]]
TurningLimits = Annotated[_Turning, AfterValidator(_rising)]
SlidingLimits = Annotated[_Sliding, AfterValidator(_rising)]

LONGEST_JOINT_NAME: Final = 80


def _is_name(text: str) -> str:
    if not text.isprintable() or text != text.strip() or not text:
        context = {
            "why": shown(text),
            "expected": (
                "a name in one line of printable text, without blanks at its ends, at most "
                f"{LONGEST_JOINT_NAME} characters"
            ),
            "example": '"shoulder"',
        }
        raise PydanticCustomError("line", "{why}", context)
    return text


# Any name that a URDF may have: `joint_3.0`, `r2/fixed/waist`.
Name = Annotated[str, Field(max_length=LONGEST_JOINT_NAME), AfterValidator(_is_name)]

# The name of a place: "base", the name of a joint, or that with ".seat" or ".tip" appended.
PlaceName = Annotated[
    str,
    Field(
        max_length=LONGEST_JOINT_NAME + len(".seat"),
        description="an earlier place: base, or NAME.seat, NAME or NAME.tip of a joint",
    ),
    AfterValidator(_is_name),
]


class _Joint(OfClass):
    """Base class of joints, moving or fixed.

    after  name of the parent place: "base", or NAME.seat, NAME or NAME.tip of an earlier joint.
           Default: the tip of the previous joint, the base for the first joint
    mass   of the joint unit, its gearbox included; fixed to the seat, at centre_of_mass. Default:
           the gearbox's own mass, where stated
    price  of the joint unit, its gearbox included. Default: the gearbox's own price, where stated
    """

    shareable: ClassVar[bool] = False
    name: Name
    after: PlaceName | None = None
    origin: Frame = Frame()
    mounting: Mounting | None = None
    mass: Mass | None = None
    price: Price | None = None
    centre_of_mass: Vector = (0.0, 0.0, 0.0)
    link: Link = Link()

    @property
    def total_mass(self) -> float:
        """Return the mass (kg) at the joint: as stated, which includes the gearbox, or else the
        gearbox's own; zero where neither is stated.
        """
        if self.mass is not None:
            return self.mass
        gearbox = getattr(self, "gearbox", None)
        return 0.0 if gearbox is None or gearbox.mass is None else float(gearbox.mass)

    @property
    def total_price(self) -> float | None:
        """Return the price of the joint unit as stated, or else the gearbox's own; None where
        neither is stated.
        """
        gearbox = getattr(self, "gearbox", None)
        return self.price if self.price is not None or gearbox is None else gearbox.price

    @property
    @abstractmethod
    def twist(self) -> Floats:
        """Return the joint's unit motion (6,), zero where nothing moves."""

    @functools.cached_property
    def elastic_link(self) -> ElasticLink:
        """Return the link behind this joint, whose axis orients its section."""
        return self.link.with_joint_axis(self.twist[:3] if self.twist[:3].any() else self.twist[3:])


class FixedJoint(_Joint):
    """A joint that does not move."""

    type: Literal["fixed"] = "fixed"

    @property
    def twist(self) -> Floats:
        """Return zero motion (6,)."""
        return np.zeros(6)

    @property
    def sources(self) -> dict[str, ErrorSource]:
        """Return no error sources: nothing moves."""
        return {}

    @property
    def drive_expands(self) -> bool | None:
        """Return that no clearance of a gearbox follows the temperature."""
        return False

    def at_temperature(self, rise: Toleranced | None) -> Self:  # noqa: ARG002 - as for joints that move
        """Return this joint, which has no gearbox."""
        return self


def _lead_of(part: Part) -> float | None:
    """Return the travel per turn of a drive or encoder; None for kinds without it."""
    lead: float | None = getattr(part, "per_turn", getattr(part, "lead", None))
    return lead


class _MovingJoint(_Joint, Generic[AmountT, GearboxT]):
    axis: Direction = "z"
    bearing: Bearing | None = None
    lumped: Lumped | None = None
    gearbox: GearboxT | None = None
    encoder: Encoder[AmountT] | None = None
    servo: Servo[AmountT] | None = None

    @functools.cached_property
    def sources(self) -> dict[str, ErrorSource]:
        """Return the error sources by name, each member of a grouped part by itself.

        Of a gearbox with an output encoder only its open play remains, or none where the servo
        states a dead band: the output then rests within it.
        """
        gearbox, encoder = self.gearbox, self.encoder
        if encoder is not None and gearbox is not None:
            own = {
                "ratio": encoder.ratio or abs(gearbox.ratio),
                "lead": encoder.lead or _lead_of(gearbox),
            }
            encoder = encoder.model_copy(update=own)
        in_loop = encoder is not None and encoder.side == "output"
        servo = (
            None
            if self.servo is None
            else self.servo.behind(1.0 if encoder is None else encoder.turns)
        )
        found = {
            "gearbox": None if in_loop else gearbox,
            "bearing": self.bearing,
            **self._own_sources,
            "encoder": encoder,
            "servo": servo,
        }
        found["lumped"] = self.lumped
        out: dict[str, ErrorSource] = {}
        for name, source in found.items():
            if isinstance(source, Grouped):
                out |= {f"{name} {member}": one for member, one in source.members.items()}
            elif source is not None:
                out[name] = source
        if (
            not in_loop
            or encoder is None
            or (self.servo is not None and self.servo.dead_band is not None)
        ):
            return out
        return play_left_open(gearbox, encoder.dead_band) | out

    @property
    def _own_sources(self) -> dict[str, ErrorSource | None]:
        """Return the error sources that only this type of joint has."""
        return {}

    @property
    def drive_expands(self) -> bool | None:
        """Return whether the clearances of a drawn gearbox follow the temperature; None where its
        materials state no expansion.
        """
        if not is_drawn(self.gearbox):
            return False
        return None if self.gearbox.expansion_unknown else self.gearbox.follows_temperature

    @model_validator(mode="after")
    def _one_dead_band(self) -> Self:
        if (
            self.servo is not None
            and self.servo.dead_band is not None
            and self.encoder is not None
            and self.encoder.dead_band is not None
        ):
            raise _refuse(
                "a dead_band of the servo and one of the encoder",
                "one of the two",
                'servo = { dead_band = "10 arcsec" }',
            )
        return self

    def at_temperature(self, rise: Toleranced | None) -> Self:
        """Return this joint with its gearbox at the temperature rise of its arm, K; itself where
        that changes nothing.
        """
        warm = self.gearbox.warmed(rise) if is_drawn(self.gearbox) else self.gearbox
        return self if warm is self.gearbox else self.model_copy(update={"gearbox": warm})

    @property
    def corrected(self) -> bool:
        """Return whether an encoder on the output lets the controller correct the errors of the
        gearbox.
        """
        return (
            self.gearbox is not None and self.encoder is not None and self.encoder.side == "output"
        )


class RevoluteJoint(_MovingJoint[AngleAmount, TurningGearbox]):
    """A joint that turns about `axis` between `limits`."""

    type: Literal["revolute"] = "revolute"
    limits: TurningLimits

    @property
    def load_unit(self) -> str:
        """Return the unit of the load of the drive: of its torque."""
        return "N m"

    @field_validator("gearbox", "encoder")
    @classmethod
    def _has_no_lead(
        cls, part: TurningGearbox | Encoder[AngleAmount] | None
    ) -> TurningGearbox | Encoder[AngleAmount] | None:
        nowhere = [key for key in _SLIDING_ONLY if getattr(part, key, None) is not None]
        if nowhere:
            raise _refuse(
                f"a {nowhere[0]} on a turning joint",
                f"a {nowhere[0]} on sliding joints only",
                'type = "prismatic"',
            )
        return part

    @functools.cached_property
    def twist(self) -> Floats:
        """Return the unit rotation about the axis (6,)."""
        return np.concatenate([unit(self.axis), np.zeros(3)])


class PrismaticJoint(_MovingJoint[LengthAmount, SlidingDrive]):
    """A joint that slides along `axis` between `limits`; its drive's screw or pulley makes a turn
    per `lead`.

    guideway  error motions of the carriage
    """

    type: Literal["prismatic"] = "prismatic"
    limits: SlidingLimits
    guideway: Guideway | None = None

    @property
    def _own_sources(self) -> dict[str, ErrorSource | None]:
        return {"guideway": self.guideway}

    @property
    def load_unit(self) -> str:
        """Return the unit of the load of the drive: of its force."""
        return "N"

    @field_validator("bearing")
    @classmethod
    def _only_guides(cls, bearing: Bearing | None) -> Bearing | None:
        if isinstance(bearing, DrawnBearing):
            raise _refuse(
                f"a {bearing.kind} on a sliding joint",
                "a guide: this joint does not turn",
                'bearing = { kind = "rolling", span = "80 mm" }',
            )
        fields = type(bearing).model_fields if bearing is not None else {}
        nowhere = [
            name
            for name in _TURNING_ONLY
            if name in fields and getattr(bearing, name) != fields[name].default
        ]
        if nowhere:
            raise _refuse(
                f"{' and '.join(nowhere)} of a bearing on a sliding joint",
                (
                    "a guide without them: it does not turn, and along the slide the drive "
                    "carries the load"
                ),
                'gearbox = { backlash = "10 µm", stiffness = "200 N/µm" }',
            )
        return bearing

    @field_validator("gearbox")
    @classmethod
    def _harmonics_have_a_lead(cls, drive: SlidingDrive | None) -> SlidingDrive | None:
        if drive is not None and drive.transmission_error is not None and _lead_of(drive) is None:
            example = 'gearbox = { transmission_error = "20 µm", lead = "10 mm" }'
            raise _refuse(
                "transmission_error without a lead on a sliding joint",
                "lead, the travel per turn of the screw or pulley",
                example,
            )
        return drive

    @field_validator("encoder")
    @classmethod
    def _encoder_turns(
        cls, encoder: Encoder[LengthAmount] | None, info: ValidationInfo
    ) -> Encoder[LengthAmount] | None:
        if encoder is None or not encoder.eccentricity:
            return encoder
        if encoder.side == "output":
            example = 'encoder = { side = "output", zero = "20 µm" }'
            raise _refuse(
                "eccentricity of an encoder along the slide",
                "no eccentricity: a scale does not turn",
                example,
            )
        drive = info.data.get("gearbox")
        if (
            "gearbox" in info.data
            and encoder.lead is None
            and (drive is None or _lead_of(drive) is None)
        ):
            expected = (
                "lead, the travel per turn of the screw or pulley, of the gearbox or of the encoder"
            )
            raise _refuse(
                "eccentricity without a lead on a sliding joint",
                expected,
                'gearbox = { lead = "10 mm" }',
            )
        return encoder

    @model_validator(mode="after")
    def _guideway_has_a_direction_up(self) -> Self:
        try:
            _ = None if self.guideway is None else self.guideway.directions(unit(self.axis))
        except ValueError as error:
            raise _refuse(str(error), "a direction across the axis", 'up = "z"') from None
        return self

    @model_validator(mode="after")
    def _drive_covers_the_range(self) -> Self:
        problem = (
            self.gearbox.range_error(self.limits)
            if isinstance(self.gearbox, SlideFigures)
            else None
        )
        if problem:
            raise _refuse(*problem)
        return self

    @functools.cached_property
    def twist(self) -> Floats:
        """Return the unit shift along the axis (6,)."""
        return np.concatenate([np.zeros(3), unit(self.axis)])


Joint = Annotated[RevoluteJoint | PrismaticJoint | FixedJoint, Field(discriminator="type")]
