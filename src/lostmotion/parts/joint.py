"""A joint unit: one motion, with its gearbox, bearing, encoder and link."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self, TypeGuard

import numpy as np
from pydantic import (
    AfterValidator,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from lostmotion.parts.bearing.rolling_contact import DrawnBearing
from lostmotion.parts.error_source import (
    Angle,
    AngleAmount,
    AngularStiffness,
    ErrorSource,
    Length,
    LengthAmount,
    LinearStiffness,
)
from lostmotion.parts.gearbox.kinds import SlidingDrive, TurningGearbox
from lostmotion.parts.gearbox.slide import SlideFigures
from lostmotion.parts.guideway import Guideway
from lostmotion.parts.link import unit
from lostmotion.parts.moving_joint import Bearing, JointUnit, MovingJoint, lead_of, refuse_joint
from lostmotion.parts.passive_joints import (
    FreeJoint,
    SphericalJoint,
    UndrivenJoint,
    UniversalJoint,
)
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.parts.encoder import Encoder
    from lostmotion.spatial import Floats


# Fields of a bearing for turning joints only; along a slide the drive carries the load.
# Fields of a drive or an encoder for sliding joints only.
_SLIDING_ONLY: Final = ("lead", "lead_error", "scale_error")
_TURNING_ONLY: Final = ("axial_play", "axial_stiffness", "radial_runout", "axial_runout")


def _rising(limits: tuple[float, float], example: str) -> tuple[float, float]:
    if limits[0] >= limits[1]:
        context = {"expected": "a lower limit below the upper one", "example": example}
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
TurningLimits = Annotated[
    _Turning, AfterValidator(functools.partial(_rising, example='limits = ["-90 deg", "90 deg"]'))
]
SlidingLimits = Annotated[
    _Sliding, AfterValidator(functools.partial(_rising, example='limits = ["0 mm", "300 mm"]'))
]


class FixedJoint(UndrivenJoint):
    """A joint that does not move."""

    type: Literal["fixed"] = "fixed"

    @property
    def freedoms(self) -> tuple[Floats, ...]:
        """Return no step."""
        return ()


class RevoluteJoint(MovingJoint[AngleAmount, TurningGearbox, AngularStiffness]):
    """A joint that turns about `axis` between `limits`.

    limits  default of a passive joint: all round
    start   value at home in a closed chain: chooses the assembly mode. Default: the middle of the
            limits; zero for a passive joint
    """

    type: Literal["revolute"] = "revolute"
    limits: TurningLimits
    start: Angle | None = None

    @model_validator(mode="before")
    @classmethod
    def _turns_all_round(cls, stated: Any) -> Any:  # noqa: ANN401 - whatever a file holds
        # whatever stands there that is no truth value is the one mistake
        if isinstance(stated, dict) and stated.get("passive", False) is not False:
            return {"limits": ["-180 deg", "180 deg"], **stated}
        return stated

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
            raise refuse_joint(
                f"a {nowhere[0]} on a turning joint",
                f"a {nowhere[0]} on sliding joints only",
                'type = "prismatic"',
            )
        return part

    @functools.cached_property
    def twist(self) -> Floats:
        """Return the unit rotation about the axis (6,)."""
        return np.concatenate([unit(self.axis), np.zeros(3)])


class PrismaticJoint(MovingJoint[LengthAmount, SlidingDrive, LinearStiffness]):
    """A joint that slides along `axis` between `limits`; its drive's screw or pulley makes a turn
    per `lead`.

    guideway  error motions of the carriage
    start     value at home in a closed chain. Default: the middle of the limits
    """

    type: Literal["prismatic"] = "prismatic"
    limits: SlidingLimits
    guideway: Guideway | None = None
    start: Length | None = None

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
            raise refuse_joint(
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
            raise refuse_joint(
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
        if drive is not None and drive.transmission_error is not None and lead_of(drive) is None:
            example = 'gearbox = { transmission_error = "20 µm", lead = "10 mm" }'
            raise refuse_joint(
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
            raise refuse_joint(
                "eccentricity of an encoder along the slide",
                "no eccentricity: a scale does not turn",
                example,
            )
        drive = info.data.get("gearbox")
        if (
            "gearbox" in info.data
            and encoder.lead is None
            and (drive is None or lead_of(drive) is None)
        ):
            expected = (
                "lead, the travel per turn of the screw or pulley, of the gearbox or of the encoder"
            )
            raise refuse_joint(
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
            raise refuse_joint(str(error), "a direction across the axis", 'up = "z"') from None
        return self

    @model_validator(mode="after")
    def _drive_covers_the_range(self) -> Self:
        problem = (
            self.gearbox.range_error(self.limits)
            if isinstance(self.gearbox, SlideFigures)
            else None
        )
        if problem:
            raise refuse_joint(*problem)
        return self

    @functools.cached_property
    def twist(self) -> Floats:
        """Return the unit shift along the axis (6,)."""
        return np.concatenate([np.zeros(3), unit(self.axis)])


def has_axis(joint: JointUnit) -> TypeGuard[RevoluteJoint | PrismaticJoint]:
    """Return whether the joint turns about or slides along one axis, with or without a drive."""
    return isinstance(joint, RevoluteJoint | PrismaticJoint)


def has_drive(joint: JointUnit) -> TypeGuard[RevoluteJoint | PrismaticJoint]:
    """Return whether a drive moves the joint."""
    return isinstance(joint, RevoluteJoint | PrismaticJoint) and not joint.passive


Joint = Annotated[
    RevoluteJoint | PrismaticJoint | FixedJoint | SphericalJoint | UniversalJoint | FreeJoint,
    Field(discriminator="type"),
]
