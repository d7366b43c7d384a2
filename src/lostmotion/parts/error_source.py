"""The one idea behind every part: it looks at what it feels where it sits, and answers with small screws in its own frame."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Final, Literal, Protocol, Self, runtime_checkable

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict
from pydantic_core import PydanticCustomError

from lostmotion.errors import shown
from lostmotion.laws.distributions import Amount, Cosine, Law, Sine, of_tolerance
from lostmotion.spatial import mapped
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from lostmotion.spatial import Floats

Level = Literal["design", "robot", "visit", "robot x visit"]


def _is_printable(text: str) -> str:
    if not text.isprintable():
        context = {"why": f"{shown(text)}, with a character that cannot be printed", "expected": "one line of printable text", "example": '"text"'}
        raise PydanticCustomError("line", "{why}", context)
    return text


# Text that is shown: one line of it, and nothing that a terminal would obey.
Line = Annotated[str, AfterValidator(_is_printable)]

# The quantities that parts are made of. From a file each takes text with a unit, from Python a number in SI as well.
Angle = Annotated[float, Quantity("rad", "0.5 arcmin")]
AngleAmount = Annotated[float, Quantity("rad", "0.5 arcmin", low=0)]
AngleDim = Annotated[Toleranced, Quantity("rad", "0.5 arcmin ± 0.2 arcmin", toleranced=True, any_law=True)]
PlayDim = Annotated[Toleranced, Quantity("rad", "0.5 arcmin ± 0.2 arcmin", low=0, toleranced=True)]
Length = Annotated[float, Quantity("m", "400 mm")]
LengthAmount = Annotated[float, Quantity("m", "20 µm", low=0)]
LengthPlus = Annotated[float, Quantity("m", "40 mm", above=0)]
Lead = Annotated[float, Quantity("m", "10 mm", above=0)]
LengthDim = Annotated[Toleranced, Quantity("m", "400 mm ± 50 µm", toleranced=True, any_law=True)]
ClearanceDim = Annotated[Toleranced, Quantity("m", "40 µm ± 20 µm", low=0, toleranced=True)]
Mass = Annotated[float, Quantity("kg", "2.5 kg", low=0)]
Inertia = Annotated[float, Quantity("kg m^2", "1.4e-5 kg m^2", low=0)]
Force = Annotated[float, Quantity("N", "50 N")]
ForceAmount = Annotated[float, Quantity("N", "5 N", low=0)]
Torque = Annotated[float, Quantity("N m", "12 N m")]
TorqueAmount = Annotated[float, Quantity("N m", "12 N m", low=0)]
AngularStiffness = Annotated[float, Quantity("N m/rad", "12 N m/arcmin", above=0)]
LinearStiffness = Annotated[float, Quantity("N/m", "200 N/µm", above=0)]
Share = Annotated[float, Quantity("", "10 %", low=0, high=0.33)]


class Part(BaseModel):
    """A description that cannot be changed once made and knows no field but its own."""

    model_config = ConfigDict(defer_build=True, frozen=True, extra="forbid")

    def __copy__(self) -> Self:
        """Copy the fields only: what was worked out from them once may not hold for a changed copy."""
        out = super().__copy__()
        for name in set(out.__dict__) - set(type(self).model_fields):
            del out.__dict__[name]
        return out

    def __repr__(self) -> str:
        """Show what was stated and leave out what was not."""
        stated = ", ".join(f"{name}={getattr(self, name)!r}" for name in sorted(self.model_fields_set))
        return f"{type(self).__name__.partition('[')[0]}({stated})"

    __str__ = __repr__


@dataclass(frozen=True, slots=True)
class Holding:
    """The most that a joint holds at rest, over its workspace and every tilt of the base: what friction is measured by where none is stated.

    load    along the joint's own motion: N m on a turning joint, N on a sliding one
    force, moment  sizes (N, N m) of the whole wrench at the joint's place
    """

    load: float = 0.0
    force: float = 0.0
    moment: float = 0.0


@dataclass(frozen=True, slots=True)
class Friction:
    """The load (N m or N) below which a play does not close; `reason` says why so much where it is assumed, and is empty where it is stated."""

    load: float
    reason: str = ""


# Friction that nobody states, as a share of what a reducer is rated for, or else of the most that the joint holds at rest.
RATED_SHARE: Final = 0.01
HELD_SHARE: Final = 0.02
OF_RATED: Final = "1 % of the rated torque"
OF_HELD: Final = "2 % of the most that it holds at rest"


@dataclass(frozen=True, slots=True)
class Condition:
    """What one place feels while the arm holds a pose; the leading axis is the pose.

    angle (pose,) is the joint's own value, rad or m; axis (6,) its unit twist in this frame (zeros where nothing moves); wrench
    (pose, 6) the load from the outboard side in this frame, N m and N; gravity (pose, 3) in this frame, m/s^2;
    approach (pose,) the sign of the joint's last motion, -1 or +1, 0 where it changes from visit to visit. holding() is the most that the joint
    holds at rest; asked for only by parts that state no friction.
    """

    angle: Floats
    axis: Floats
    wrench: Floats
    gravity: Floats
    approach: Floats
    holding: Callable[[], Holding] = Holding

    @property
    def load(self) -> Floats:
        """Give the load along the joint's own motion (pose,): torque in N m on a turning joint, force in N on a sliding one."""
        return mapped(self.axis, self.wrench)

    def turned(self, lead: float | None) -> Floats:
        """Give how far the output has turned (pose,), rad: the joint's own angle, or on a sliding joint that of its screw, with its lead in m."""
        if self.axis[:3].any():
            return self.angle
        if lead is None:
            raise ValueError("without a lead nothing turns on a sliding joint")
        return self.angle * (2 * math.pi / lead)

    @property
    def scale(self) -> Floats:
        """Give the size of the whole wrench (pose,), to tell a small load from rounding."""
        return np.asarray(np.sqrt(sum(part**2 for part in self.wrench.T)))


@dataclass(frozen=True, slots=True)
class Draw:
    """Where chance comes from: the name of a stream of uniforms within the part, and the law that maps it."""

    stream: str
    law: Law


@dataclass(frozen=True, slots=True)
class Term:
    """One elementary error: a screw (pose, 6) or (6,) in the part's frame per unit draw (rad, m), and what is drawn.

    Neither draw: it follows from the pose (design). `robot`: drawn once per robot built. `visit`: drawn every time a
    pose is reached. Both: a product, for example the amount of play times its side. Terms of one part that name the same stream
    share the draw. `seated`: it rests within a play, or a loop of friction, on the side where load or way of arriving hold it, and so is no
    spring; every other design term that follows the load is one.
    """

    name: str
    screw: Floats
    robot: Draw | None = None
    visit: Draw | None = None
    seated: bool = False

    @property
    def level(self) -> Level:
        """Name the level of chance."""
        if self.robot and self.visit:
            return "robot x visit"
        return "robot" if self.robot else "visit" if self.visit else "design"

    @property
    def bound(self) -> float:
        """Give the largest size of the draw (1 for a design term)."""
        return (self.robot.law.bound if self.robot else 1.0) * (self.visit.law.bound if self.visit else 1.0)


class ErrorSource(ABC):
    """Anything that moves the tool off its place."""

    @abstractmethod
    def terms(self, at: Condition) -> Sequence[Term]:
        """Which elementary errors does this part make under these conditions?"""

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:  # noqa: ARG002 - most parts have no play
        """Which friction keeps this part's play open against a small load? None for a part without play."""
        return None


@runtime_checkable
class Grouped(Protocol):
    """A part that offers several error sources by name, each to be counted by itself."""

    @property
    def members(self) -> Mapping[str, ErrorSource]:
        """Give the sources by name."""


def limit_term(name: str, direction: Floats, limit: float, law: Law, *, visit: bool = False) -> Term:
    """Return the term of a stated amount ±limit (rad or m) along a unit twist: drawn per robot, or per visit.

    A law with a mean needs the design term of `amount_terms` as well.
    """
    draw = Draw(name, law)
    screw = direction * (limit / law.stated)
    return Term(name, screw, visit=draw) if visit else Term(name, screw, robot=draw)


def amount_terms(name: str, direction: Floats, limit: float, law: Law, *, visit: bool = False) -> list[Term]:
    """Return the terms of a stated amount ±limit along a unit twist: what is drawn, and before it the mean of a law that has one."""
    mean = [Term(f"mean {name}", direction * (limit * law.mean))] if law.mean else []
    return [*mean, limit_term(name, direction, limit, law, visit=visit)]


def toleranced_terms(name: str, direction: Floats, dimension: Toleranced) -> list[Term]:
    """Return the terms that a dimension's tolerance makes along a twist per unit of it; none where it has no tolerance."""
    if not dimension.tolerance:
        return []
    return amount_terms(name, direction, dimension.tolerance, of_tolerance(dimension.law))


def wave_terms(name: str, twist: Floats, phase: Floats, amplitude: float, parts: tuple[str, str] = ("sine", "cosine")) -> list[Term]:
    """Which two terms make amplitude x sin(phase + a start drawn once per robot) along a twist (6,)? Phases (pose,), rad; amplitude in rad or m."""
    size = twist * (amplitude / math.sqrt(2))
    return [
        Term(f"{name} {parts[0]}", np.sin(phase)[:, None] * size, robot=Draw(name, Cosine())),
        Term(f"{name} {parts[1]}", np.cos(phase)[:, None] * size, robot=Draw(name, Sine())),
    ]


def play_terms(name: str, play: Toleranced, known: Floats, free: Sequence[Term], amount: str) -> list[Term]:
    """Which terms does a play of scattered size make: where it is `known` to be held, and what it is `free` to do?

    `known` (pose, 6) is the nominal play's part that the load or the way of arriving holds; `free` are visit terms of the nominal play for the
    rest. `amount` names the stream that says how much play this robot has.
    """
    held = Term(f"{name} side held by load", known, seated=True)
    if not play.tolerance:
        return [held, *free]
    law = of_tolerance(play.law)
    scatter = play.tolerance / law.bound / play.nominal
    robot = Draw(amount, Amount(scatter, law))
    root_mean_square = math.hypot(1, scatter)
    return [
        held,
        Term(f"{name} amount", known * scatter, robot=Draw(amount, law)),
        *(Term(term.name, term.screw * root_mean_square, robot=robot, visit=term.visit) for term in free),
    ]
