"""Error terms as data: the name of a term, its draws, and the form by which its screw depends on
angle, load and gravity at its place.

A part lists its terms once, before any pose is known. The forms (`parts.forms`) then return the
screw of each term at any poses.
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
    from lostmotion.units import Toleranced

Level = Literal["design", "robot", "visit", "robot x visit"]
# What a form reads where loads change its screw.
LOADS: Final = frozenset({"wrench", "weight", "gravity"})
_Value = TypeVar("_Value")


@dataclass(frozen=True, slots=True)
class Holding:
    """The largest static load of a joint over its workspace and every tilt of the base. Friction
    that is not stated is a share of it.

    load           load along the joint's own motion: N m on a turning joint, N on a sliding one
    force, moment  sizes (N, N m) of the whole wrench at the joint's place
    """

    load: float = 0.0
    force: float = 0.0
    moment: float = 0.0


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of the joint to which a part belongs, and the temperature of the arm, independent
    of the pose.

    twist    unit twist (6,) of the joint in the part's frame; zeros where nothing moves
    holding  returns the largest static load of the joint; called only by parts whose friction is
             not stated
    rise     temperature of the whole arm above that of its drawings, K, with its ± variation; None
             where no temperature is stated
    varies   whether temperatures vary from robot to robot, or from visit to visit
    limits   range of the joint, rad or m; None for a part by itself
    """

    twist: Floats
    holding: Callable[[], Holding] = Holding
    rise: Toleranced | None = None
    varies: Literal["robot", "visit"] = "robot"
    limits: tuple[float, float] | None = None

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
        """Return the rotation (rad) of a drive screw per metre of travel of a sliding joint, from
        its lead (m); None for a turning joint.

        Raises ValueError for a sliding joint without a lead.
        """
        if self.turning:
            return None
        if lead is None:
            raise ValueError("without a lead nothing turns on a sliding joint")
        return 2 * math.pi / lead


@dataclass(frozen=True, eq=False)
class Condition:
    """Joint value, load and gravity at one place of the arm, at some poses; the pose is the last
    axis.

    angle    (pose,) value of the joint, rad or m
    wrench   (6, pose) load from the outboard side, in the frame of the place, N m and N
    gravity  (3, pose) in this frame, m/s^2
    temperature_rise  temperature of the arm above that of its drawings, K
    process  (6, pose) part of the load by the process force and moment; None where there is none
    """

    angle: Floats
    wrench: Floats
    gravity: Floats
    temperature_rise: float = 0.0
    process: Floats | None = None
    _known: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    def once(self, key: Hashable, compute: Callable[[], _Value]) -> _Value:
        """Return the result of `compute`, which is called once per key. A key is a form or a value,
        not an id, which may be reused.
        """
        if key not in self._known:
            self._known[key] = compute()
        found: _Value = self._known[key]
        return found

    @property
    def weight(self) -> Floats:
        """Return the load by weights alone (6, pose), N m and N."""
        return self.wrench if self.process is None else self.wrench - self.process

    @property
    def load_size(self) -> Floats:
        """Return the norm of the whole wrench (pose,), by which a small load is distinguished from
        rounding.
        """
        return self.once("load size", lambda: np.sqrt((self.wrench**2).sum(axis=0)))

    def along(self, way: Floats) -> Floats:
        """Return the load (pose,) along one motion (6,), N m or N per unit of it."""
        return self.once(("along", way.tobytes()), lambda: rows_times(way[None], self.wrench)[0])


def rows_times(matrix: Floats, vectors: Floats) -> Floats:
    """Return matrix @ vectors (row, pose) for vectors (column, pose), summed in one order.

    A BLAS product may round a single pose differently from the same pose among many. Columns of
    zeros are skipped, which changes no bit.
    """
    out = np.zeros((len(matrix), vectors.shape[1]))
    for k in np.flatnonzero(matrix.any(axis=0)):
        out += matrix[:, k, None] * vectors[k]
    return out


class Threshold(ABC):
    """Dry friction that a load overcomes in some robots and not in others. Thresholds are compared
    by identity.

    stream  name of the draw within the part, one uniform per robot: the load overcomes the friction
            in robots whose draw is at most the share
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
    """How a screw depends on the condition at its place. Forms are compared by identity: terms that
    differ only in size share one form.
    """

    @property
    def reads(self) -> tuple[str, ...]:
        """Return the names of the fields of `Condition` on which the screw depends: "wrench" by
        default, none for a constant screw.
        """
        return ("wrench",)

    @property
    def elastic(self) -> bool:
        """Return whether it is a spring, which counts in the arm's compliance."""
        return False

    @property
    def jumps(self) -> bool:
        """Return whether a load moves it within a play: it depends on the load and is no spring."""
        return not self.elastic and "wrench" in self.reads

    @property
    def threshold(self) -> Threshold | None:
        """Return the friction that decides in each robot whether it has the screw; None where all
        robots have it.
        """
        return None

    @property
    def above(self) -> bool:
        """Return True if the screw exists where a load overcomes the threshold, False if it exists
        where it does not.
        """
        return True

    @abstractmethod
    def screw(self, at: Condition) -> Floats:
        """Return the screw (6, pose), rad and m, for a term of scale one."""

    def compliance(self, at: Condition) -> Floats:
        """Return the derivative of the screw by the wrench (pose, 6, 6), rad and m per N m and N;
        zeros for a form that is not elastic.
        """
        return np.zeros((len(at.angle), 6, 6))

    def write(self, at: Condition, scales: Floats, out: Floats) -> None:
        """Write the screw times each of `scales` (term,) into `out` (6, term, pose)."""
        np.multiply(at.once(self, lambda: self.screw(at))[:, None], scales[:, None], out=out)


@dataclass(frozen=True, slots=True)
class Draw:
    """A random factor of mean zero and mean square one: the name of a stream of uniforms, and the
    distribution that maps them.

    shared  owner of a stream that parts of several joints share; empty for a stream of the part's
            own
    """

    stream: str
    law: Law
    shared: str = ""

    def name(self, owner: str) -> str:
        """Return the full name of the stream for a term of this part ("joints.A.encoder.zero")."""
        return f"{self.shared or owner}.{self.stream}"


# The sign of the joint's last motion: one draw per joint and visit, shared by all its parts that
# depend on direction.
LAST_MOTION: Final = Draw("last motion", TwoSided())


@dataclass(frozen=True, slots=True)
class Parameter:
    """The size that a designer chooses and that a term depends on.

    key    name of the field
    value  in SI; None where no single field states it, so that only a factor on it can be reported
    unit   SI unit
    zones  number of zones of a stiffness
    """

    key: str
    value: float | None = None
    unit: str = ""
    zones: int = 1


@dataclass(frozen=True, slots=True)
class Term:
    """One elementary error of a part: scale x form is its screw per unit draw.

    name       unique within the part
    cause      kind of error that a budget adds up: "backlash", "wind-up", "clearance"; without the
               number, row or phase of a single term
    form       how the screw depends on the condition at the place
    scale      size of the term, in the unit of the form's screw
    robot      draw per robot; None: no such factor
    visit      draw per visit to a pose; None: no such factor. With both, the factor is their
               product, such as the size of a play times its side. With neither it is a design term
    parameter  size that a designer chooses; the error is proportional to its value to the power
               `exponent`, -1 for a stiffness
    effect     name of the error of which this term is a part, such as the two phases of a harmonic,
               or a play and its scatter; default: `name`
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
        """Return whether the visit draw is the sign of the joint's last motion, which is known
        where the approach is known.
        """
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
    """Return the level of chance of a term or a column with these draws; None stands for no
    draw.
    """
    if robot is not None and visit is not None:
        return "robot x visit"
    return "robot" if robot is not None else "visit" if visit is not None else "design"
