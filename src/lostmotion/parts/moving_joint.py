"""Fields of all joint units, and those of joints that move: bearing, gearbox, encoder, servo."""

from __future__ import annotations

import functools
from abc import abstractmethod
from typing import (
    TYPE_CHECKING,
    Annotated,
    ClassVar,
    Final,
    Generic,
    Self,
    TypeAlias,
    TypeVar,
    Union,
)

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    StrictBool,
    model_validator,
)
from pydantic_core import PydanticCustomError

from lostmotion.errors import shown
from lostmotion.parts.bearing.bearing import BearingFigures
from lostmotion.parts.bearing.crossed_roller import CrossedRoller
from lostmotion.parts.bearing.crossed_rollers import CrossedRollerBearing
from lostmotion.parts.bearing.pair import BallPair, RollerPair
from lostmotion.parts.bearing.rigid import RigidBearing, of_rigid_kind
from lostmotion.parts.bearing.rolling import RollingPair
from lostmotion.parts.elastic_link import ElasticLink
from lostmotion.parts.encoder import Encoder
from lostmotion.parts.error_source import (
    ErrorSource,
    Grouped,
    Mass,
    Part,
    Price,
)
from lostmotion.parts.gearbox.gearbox import AmountT, StiffnessT
from lostmotion.parts.gearbox.kinds import SlidingDrive, TurningGearbox, is_drawn
from lostmotion.parts.gearbox.play_in_loop import play_left_open
from lostmotion.parts.kinds import kinds_of_extensions
from lostmotion.parts.link import Direction, Frame, Link, Vector
from lostmotion.parts.lumped import Lumped
from lostmotion.parts.mounting import Mounting
from lostmotion.parts.provenance import OfClass
from lostmotion.parts.servo import Servo
from lostmotion.spatial import exp

if TYPE_CHECKING:
    from lostmotion.spatial import Floats
    from lostmotion.units import Toleranced

GearboxT = TypeVar("GearboxT", bound=TurningGearbox | SlidingDrive)
if TYPE_CHECKING:
    _AnyBearing: TypeAlias = (
        RollingPair | CrossedRoller | BallPair | RollerPair | CrossedRollerBearing | RigidBearing
    )
else:
    _OWN = (
        RollingPair,
        CrossedRoller,
        BallPair,
        RollerPair,
        CrossedRollerBearing,
        RigidBearing,
    )
    _AnyBearing = Union[(*_OWN, *kinds_of_extensions(_OWN, BearingFigures))]
Bearing = Annotated[
    _AnyBearing,
    Field(discriminator="kind"),
    BeforeValidator(of_rigid_kind),
]


def refuse_joint(why: str, expected: str, example: str) -> PydanticCustomError:
    """Return the error of a joint whose fields do not fit together."""
    return PydanticCustomError(
        "limits", "{why}", {"why": why, "expected": expected, "example": example}
    )


LONGEST_JOINT_NAME: Final = 80
DRIVE_PARTS: Final = ("gearbox", "encoder", "servo")


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


class JointUnit(OfClass):
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
        turns = self.twist[:3].any()
        return ElasticLink(self.link, self.twist[:3] if turns else self.twist[3:])


def lead_of(part: Part) -> float | None:
    """Return the travel per turn of a drive or encoder; None for kinds without it."""
    lead: float | None = getattr(part, "per_turn", getattr(part, "lead", None))
    return lead


class MovingJoint(JointUnit, Generic[AmountT, GearboxT, StiffnessT]):
    """Base class of joints that move, with their drive.

    passive  no drive moves the joint: closed loops do. q does not hold its value
    """

    axis: Direction = "z"
    passive: StrictBool = False
    bearing: Bearing | None = None
    lumped: Lumped | None = None
    gearbox: GearboxT | None = None
    encoder: Encoder[AmountT] | None = None
    servo: Servo[AmountT, StiffnessT] | None = None
    start: float | None = None

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
                "lead": encoder.lead or lead_of(gearbox),
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

    @property
    def freedoms(self) -> tuple[Floats, ...]:
        """Return the unit motion (6, 1) of the joint's only step."""
        return (self.twist[:, None],)

    @property
    def at_start(self) -> tuple[Floats, ...]:
        """Return the pose (4, 4) of the joint's motion at home, roughly."""
        return (exp(self.twist * (self.start or 0.0)),)

    @model_validator(mode="after")
    def _only_drives_have_gears(self) -> Self:
        found = [name for name in DRIVE_PARTS if getattr(self, name)]
        if self.passive and found:
            raise refuse_joint(
                f"{' and '.join(found)} on a passive joint",
                "a bearing only, or a joint with a drive",
                "passive = false",
            )
        return self

    @model_validator(mode="after")
    def _one_dead_band(self) -> Self:
        if (
            self.servo is not None
            and self.servo.dead_band is not None
            and self.encoder is not None
            and self.encoder.dead_band is not None
        ):
            raise refuse_joint(
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
