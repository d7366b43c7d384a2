"""Error terms as data: what a term is called, what is drawn for it, and by which form its screw follows from what its place feels.

A part lists its terms once, before any pose is known. Forms (`parts.forms`) then give the screw of each term at any poses.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, Literal, TypeVar

import numpy as np

from lostmotion.laws.distributions import TwoSided

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats

Level = Literal["design", "robot", "visit", "robot x visit"]
_Value = TypeVar("_Value")


@dataclass(frozen=True, slots=True)
class Holding:
    """The largest load that a joint holds at rest, over its workspace and every tilt of the base: the measure of friction that is not stated.

    load    along the joint's own motion: N m on a turning joint, N on a sliding one
    force, moment  sizes (N, N m) of the whole wrench at the joint's place
    """

    load: float = 0.0
    force: float = 0.0
    moment: float = 0.0


@dataclass(frozen=True, eq=False)
class Motion:
    """What a part knows of its joint before any pose.

    twist    unit twist (6,) of the joint in the part's frame; zeros where nothing moves
    holding  returns the largest load that the joint holds at rest; called only by parts whose friction is not stated
    """

    twist: Floats
    holding: Callable[[], Holding] = Holding

    @property
    def turning(self) -> bool:
        """Return whether the joint turns."""
        return bool(self.twist[:3].any())

    @property
    def axis(self) -> Floats:
        """Return the unit direction (3,) of the motion."""
        return self.twist[:3] if self.turning else self.twist[3:]

    @property
    def unit(self) -> str:
        """Return the SI unit of the joint's value."""
        return "rad" if self.turning else "m"

    @property
    def stiffness_unit(self) -> str:
        """Return the SI unit of a stiffness against the motion."""
        return "N m/rad" if self.turning else "N/m"

    def turns(self, lead: float | None) -> float | None:
        """Return the turning (rad) of a screw per metre of a sliding joint, from its lead (m); None where the joint itself turns.

        Raises ValueError for a sliding joint without a lead.
        """
        if self.turning:
            return None
        if lead is None:
            raise ValueError("without a lead nothing turns on a sliding joint")
        return 2 * math.pi / lead


@dataclass(frozen=True, eq=False)
class Condition:
    """What one place feels at some poses; the pose is the last axis.

    angle (pose,) is the joint's own value, rad or m; wrench (6, pose) the load from the outboard side in the place's frame, N m and N;
    gravity (3, pose) in this frame, m/s^2.
    """

    angle: Floats
    wrench: Floats
    gravity: Floats
    _known: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    def once(self, key: Hashable, compute: Callable[[], _Value]) -> _Value:
        """Return what `compute` returns, computed once per key. A key is a form or a value, never the id of an object that may be gone."""
        if key not in self._known:
            self._known[key] = compute()
        found: _Value = self._known[key]
        return found

    @property
    def load_size(self) -> Floats:
        """Return the size of the whole wrench (pose,), by which a small load is distinguished from rounding."""
        return self.once("load size", lambda: np.sqrt((self.wrench**2).sum(axis=0)))

    def along(self, way: Floats) -> Floats:
        """Return the load (pose,) along one motion (6,), N m or N per unit of it."""
        return self.once(("along", way.tobytes()), lambda: rows_times(way[None], self.wrench)[0])


def rows_times(matrix: Floats, vectors: Floats) -> Floats:
    """Return matrix @ vectors (row, pose) for vectors (column, pose), summed in one order.

    A BLAS product rounds one pose alone otherwise than the same pose among many. Columns of zeros are skipped, which changes no bit.
    """
    out = np.zeros((len(matrix), vectors.shape[1]))
    for k in np.flatnonzero(matrix.any(axis=0)):
        out += matrix[:, k, None] * vectors[k]
    return out


class Threshold(ABC):
    """Dry friction that a load overcomes in some robots and not in others. Compared by identity: one draw per robot decides.

    stream  name within the part of what is drawn, one uniform per robot: the load overcomes the friction where it is at most the share
    """

    stream: str

    @property
    @abstractmethod
    def scatters(self) -> bool:
        """Return whether the friction differs from robot to robot."""

    @abstractmethod
    def share(self, at: Condition) -> Floats:
        """Return the share of robots (pose,) in which the load overcomes the friction, 0..1."""


class Form(ABC):
    """How a screw follows from what its place feels. Forms are compared by identity: terms that differ only in size share one."""

    @property
    def reads(self) -> tuple[str, ...]:
        """Return the fields of `Condition` on which the screw depends: the load, unless a form says otherwise; none for a constant screw."""
        return ("wrench",)

    @property
    def elastic(self) -> bool:
        """Return whether it is a spring, which counts in the arm's compliance."""
        return False

    @property
    def threshold(self) -> Threshold | None:
        """Return the friction that decides in each robot whether the screw is there; None where all robots have it."""
        return None

    @property
    def above(self) -> bool:
        """Return whether the screw is there where a load overcomes the threshold, or else where it does not."""
        return True

    @abstractmethod
    def screw(self, at: Condition) -> Floats:
        """Return the screw (6, pose), rad and m, for a term of scale one."""

    def compliance(self, at: Condition) -> Floats:
        """Return the tangent of the screw over the wrench (pose, 6, 6), rad and m per N m and N; zeros where it is no spring."""
        return np.zeros((len(at.angle), 6, 6))

    def write(self, at: Condition, scale: float, out: Floats) -> None:
        """Write the screw times `scale` into `out` (6, pose)."""
        np.multiply(at.once(self, lambda: self.screw(at)), scale, out=out)


@dataclass(frozen=True, slots=True)
class Draw:
    """What is drawn: the name of a stream of uniforms within the part, and the distribution that maps them. Mean zero, mean square one."""

    stream: str
    law: Law


# The sign of the joint's last motion: one draw per joint and visit, shared by all its parts that depend on direction.
LAST_MOTION: Final = Draw("last motion", TwoSided())


@dataclass(frozen=True, slots=True)
class Parameter:
    """The size that a designer chooses: its key, its value in SI, its unit, and the number of zones of a stiffness.

    `value` is None where no single field states it; then only a factor on it can be reported.
    """

    key: str
    value: float | None = None
    unit: str = ""
    zones: int = 1


@dataclass(frozen=True, slots=True)
class Term:
    """One elementary error of a part: scale x form is its screw per unit draw.

    name       unique within the part
    cause      the kind of error that a budget adds up: "backlash", "wind-up", "clearance"; never with a number, a row or a phase in it
    robot      drawn once per robot built; `visit` drawn every time a pose is reached; both: a product, such as the amount of play times its side;
               neither: a design term, which follows from the pose
    parameter  the size that a designer chooses; the error is proportional to its value to the power `exponent`, -1 for a stiffness
    effect     the error of which this term is one part: the two phases of a harmonic, a play and its scatter; default: the term's own name
    """

    name: str
    cause: str
    form: Form
    scale: float = 1.0
    robot: Draw | None = None
    visit: Draw | None = None
    parameter: Parameter | None = None
    exponent: int = 1
    effect: str = ""

    @property
    def sided(self) -> bool:
        """Return whether the visit draw is the sign of the joint's last motion, which is known where the approach is known."""
        return self.visit == LAST_MOTION

    @property
    def level(self) -> Level:
        """Return the level of chance."""
        return level_of(self.robot, self.visit)

    @property
    def bound(self) -> float:
        """Return the largest size of the draw; 1 for a design term."""
        return math.prod(draw.law.bound for draw in (self.robot, self.visit) if draw is not None)


def level_of(robot: object | None, visit: object | None) -> Level:
    """Return the level of chance of what has these draws."""
    if robot is not None and visit is not None:
        return "robot x visit"
    return "robot" if robot is not None else "visit" if visit is not None else "design"
