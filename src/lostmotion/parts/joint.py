"""A joint unit: one motion, and the gearbox, bearing, encoder and link that belong to it."""

from __future__ import annotations

import functools
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Final, Literal

import numpy as np
from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from lostmotion.laws.chance import Normal
from lostmotion.parts.bearing.crossed_roller import CrossedRoller
from lostmotion.parts.bearing.rolling import RollingPair
from lostmotion.parts.encoder import Encoder
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.link import Direction, ElasticLink, Link, Place, Vector, unit
from lostmotion.parts.lumped import Lumped
from lostmotion.parts.source import (
    AngleAmount,
    AngularStiffness,
    ClearanceDim,
    Condition,
    ErrorSource,
    ForceAmount,
    LengthAmount,
    LinearStiffness,
    Mass,
    Part,
    PlayDim,
    Term,
    TorqueAmount,
    limit_term,
)
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

Bearing = Annotated[RollingPair | CrossedRoller, Field(discriminator="kind")]


def _rising(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] >= limits[1]:
        context = {
            "why": f"limits from {limits[0]:g} to {limits[1]:g} (rad or m)",
            "expected": "a lower limit below the upper one",
            "example": 'limits = ["-90 deg", "90 deg"]',
        }
        raise PydanticCustomError("limits", "{why}", context)
    return limits


# Each end with an example of its own, so that an example made of both is a range.
_Turning = tuple[Annotated[float, Quantity("rad", "-90 deg")], Annotated[float, Quantity("rad", "90 deg")]]
_Sliding = tuple[Annotated[float, Quantity("m", "0 mm")], Annotated[float, Quantity("m", "300 mm")]]
TurningLimits = Annotated[_Turning, AfterValidator(_rising)]
SlidingLimits = Annotated[_Sliding, AfterValidator(_rising)]

NAME_PATTERN: Final = r"^[A-Za-z0-9][A-Za-z0-9_ -]{0,39}$"
Name = Annotated[str, Field(pattern=NAME_PATTERN)]


class Mounting(Part, ErrorSource):
    """How exactly the joint's axis lies in the link before: ± tilt about, and ± offset along, the two directions across it."""

    tilt: AngleAmount = 0.0
    offset: LengthAmount = 0.0

    def terms(self, at: Condition) -> list[Term]:
        """The axis as made, in the seat's frame, which does not turn with the joint."""
        axis = at.axis[:3] if at.axis[:3].any() else at.axis[3:]
        law = Normal()
        out: list[Term] = []
        across = [np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])]
        across[0] /= np.linalg.norm(across[0])
        across.append(np.cross(axis, across[0]))
        for k, direction in enumerate(across, 1):
            if self.tilt:
                out.append(limit_term(f"axis tilt {k}", np.concatenate([direction, np.zeros(3)]), self.tilt, law))
            if self.offset:
                out.append(limit_term(f"axis offset {k}", np.concatenate([np.zeros(3), direction]), self.offset, law))
        return out


class _Joint(Part):
    """What every joint has, moving or not."""

    name: Name
    origin: Place = Place()
    mounting: Mounting | None = None
    mass: Mass = 0.0
    centre_of_mass: Vector = (0.0, 0.0, 0.0)
    link: Link = Link()

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


class _MovingJoint(_Joint):
    axis: Direction = "z"
    bearing: Bearing | None = None
    lumped: Lumped | None = None


class RevoluteJoint(_MovingJoint):
    """A joint that turns about `axis` between `limits`."""

    type: Literal["revolute"] = "revolute"
    limits: TurningLimits
    gearbox: CatalogueGearbox[AngleAmount, PlayDim, AngularStiffness, TorqueAmount] | None = None
    encoder: Encoder[AngleAmount] | None = None

    @functools.cached_property
    def twist(self) -> Floats:
        """Give the unit rotation about the axis (6,)."""
        return np.concatenate([unit(self.axis), np.zeros(3)])

    @functools.cached_property
    def sources(self) -> dict[str, ErrorSource]:
        """Give the parts that err, by name; a gearbox inside the loop of an encoder on its output errs no more."""
        return _sources(self.gearbox, self.bearing, self.encoder, self.lumped)


class PrismaticJoint(_MovingJoint):
    """A joint that slides along `axis` between `limits`."""

    type: Literal["prismatic"] = "prismatic"
    limits: SlidingLimits
    gearbox: CatalogueGearbox[LengthAmount, ClearanceDim, LinearStiffness, ForceAmount] | None = None
    encoder: Encoder[LengthAmount] | None = None

    @functools.cached_property
    def twist(self) -> Floats:
        """Give the unit shift along the axis (6,)."""
        return np.concatenate([np.zeros(3), unit(self.axis)])

    @functools.cached_property
    def sources(self) -> dict[str, ErrorSource]:
        """Give the parts that err, by name."""
        return _sources(self.gearbox, self.bearing, self.encoder, self.lumped)


Joint = Annotated[RevoluteJoint | PrismaticJoint | FixedJoint, Field(discriminator="type")]


def _sources(
    gearbox: CatalogueGearbox | None,  # type: ignore[type-arg] # either set of units
    bearing: ErrorSource | None,
    encoder: Encoder | None,  # type: ignore[type-arg]
    lumped: Lumped | None,
) -> dict[str, ErrorSource]:
    if encoder is not None and encoder.ratio is None and gearbox is not None:
        encoder = encoder.model_copy(update={"ratio": gearbox.ratio})
    closed_loop = encoder is not None and encoder.side == "output"
    found = {"gearbox": None if closed_loop else gearbox, "bearing": bearing, "encoder": encoder, "lumped": lumped}
    return {name: source for name, source in found.items() if source is not None}
