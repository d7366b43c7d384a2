"""Passive joints of closed chains with more than one freedom: ball joints, universal joints, and
a body that legs alone carry.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Final, Literal, Self

import numpy as np
from pydantic import model_validator

from lostmotion.laws.distributions import Uniform
from lostmotion.parts.error_source import (
    HELD_SHARE,
    OF_HELD,
    Angle,
    ClearanceDim,
    ErrorSource,
    Friction,
    FrictionForce,
)
from lostmotion.parts.frame import Direction, Frame, unit
from lostmotion.parts.moving_joint import DRIVE_PARTS, JointUnit, refuse_joint
from lostmotion.parts.play import Seat
from lostmotion.parts.provenance import Sourced, with_friction
from lostmotion.parts.standard_terms import End, parameter, play_terms
from lostmotion.parts.term import Draw, Holding
from lostmotion.spatial import pose_of, turn
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.parts.term import Motion, Term
    from lostmotion.spatial import Floats

Cone = Annotated[float, Quantity("rad", "40 deg", above=0, high=math.pi)]
# Across this sine two axes of a universal joint count as one.
_PARALLEL: Final = 1e-6


class BallSocket(Sourced, ErrorSource):
    """The clearance of a ball in its socket: the ball rests half the clearance away, along the
    force that it carries.

    clearance      diametral; ± is its scatter over joints
    closing_force  under a load below it the ball rests anywhere in its clearance; default: 2 % of
                   the largest force at rest. ± is its scatter over joints; default: ±50 %
    """

    kind: Literal["ball"] = "ball"
    clearance: ClearanceDim = Toleranced(0.0)
    closing_force: FrictionForce | None = None

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the default
        friction.
        """
        return with_friction(super().assumptions, "closing_force", self.play_friction(Holding))

    def terms(self, motion: Motion) -> list[Term]:
        """Return the displacement of the ball within its clearance."""
        if not self.clearance.nominal:
            return []
        way = np.hstack([np.zeros((3, 3)), np.eye(3)])
        ends = [
            # each coordinate of a point on a sphere is uniformly distributed (Archimedes)
            End(f"position {axis}", row / math.sqrt(3), Draw(f"position {axis}", Uniform()))
            for axis, row in zip("xyz", way, strict=True)
        ]
        friction = self.play_friction(motion.holding)
        return play_terms(
            "clearance",
            self.clearance,
            Seat(way, friction.load),
            ends,
            "amount",
            parameter("clearance", self.clearance.nominal, "m"),
        )

    def play_friction(self, holding: Callable[[], Holding]) -> Friction:
        """Return the closing force that is stated, or else assumed."""
        if self.closing_force is not None:
            return self.closing_force
        return Friction.of_load(HELD_SHARE * holding().force, OF_HELD)


class UndrivenJoint(JointUnit):
    """Base class of joints without one axis: fixed ones, and passive ones in several directions."""

    @property
    def twist(self) -> Floats:
        """Return zero motion (6,): no single axis."""
        return np.zeros(6)

    @property
    def sources(self) -> dict[str, ErrorSource]:
        """Return the error sources by name."""
        return {}

    @property
    def drive_expands(self) -> bool | None:
        """Return that no clearance of a gearbox follows the temperature."""
        return False

    def at_temperature(self, rise: Toleranced | None) -> Self:  # noqa: ARG002 - as for joints that move
        """Return this joint, which has no gearbox."""
        return self


class PassiveUnit(UndrivenJoint):
    """Base class of joints that move in several directions, none of them by a drive."""

    passive: Literal[True] = True

    @model_validator(mode="before")
    @classmethod
    def _no_drive(cls, given: object) -> object:
        found = [name for name in DRIVE_PARTS if isinstance(given, dict) and given.get(name)]
        if found:
            raise refuse_joint(
                f"{' and '.join(found)} on a passive joint",
                "a bearing only, or a joint with a drive: revolute or prismatic",
                'type = "revolute"',
            )
        return given


class SphericalJoint(PassiveUnit):
    """A ball joint, with three freedoms.

    bearing  the ball in its socket
    axis     direction of the socket in the seat, from which the cone is measured
    cone     largest angle between the axis and the same direction of the moved side
    start    roll, pitch and yaw about where it stands at home
    """

    type: Literal["spherical"] = "spherical"
    bearing: BallSocket | None = None
    axis: Direction = "z"
    cone: Cone | None = None
    start: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)

    @property
    def freedoms(self) -> tuple[Floats, ...]:
        """Return the unit motions (6, n) of each step of the joint."""
        return (np.eye(6)[:, :3],)

    @property
    def at_start(self) -> tuple[Floats, ...]:
        """Return the pose (4, 4) of each step at home, roughly."""
        return (pose_of(rpy=self.start),)

    @property
    def sources(self) -> dict[str, ErrorSource]:
        """Return the ball in its socket."""
        return {} if self.bearing is None else {"bearing": self.bearing}


class UniversalJoint(PassiveUnit):
    """A universal joint: two revolute motions, one after the other, about axes through one point.

    axes    of the two motions: the first is fixed to the seat, the second to the link
    limits  of the two angles; default: all round
    start   the two angles about where it stands at home
    """

    type: Literal["universal"] = "universal"
    axes: tuple[Direction, Direction] = ("x", "y")
    limits: tuple[tuple[Angle, Angle], tuple[Angle, Angle]] = (
        (-math.pi, math.pi),
        (-math.pi, math.pi),
    )
    start: tuple[Angle, Angle] = (0.0, 0.0)

    @model_validator(mode="after")
    def _turns_about_two_axes(self) -> Self:
        first, second = map(unit, self.axes)
        if np.linalg.norm(np.cross(first, second)) < _PARALLEL:
            raise refuse_joint(
                "two parallel axes of a universal joint", "two directions", 'axes = ["x", "y"]'
            )
        return self

    @property
    def freedoms(self) -> tuple[Floats, ...]:
        """Return the unit motions (6, n) of each step of the joint."""
        return tuple(np.concatenate([unit(axis), np.zeros(3)])[:, None] for axis in self.axes)

    @property
    def at_start(self) -> tuple[Floats, ...]:
        """Return the pose (4, 4) of each step at home, roughly."""
        return tuple(
            turn(unit(axis), angle) for axis, angle in zip(self.axes, self.start, strict=True)
        )


class FreeJoint(PassiveUnit):
    """No joint at all: a body with six freedoms, which legs alone carry, as the platform of a
    hexapod or a delta.

    start  frame in the seat about where it stands at home
    """

    type: Literal["free"] = "free"
    start: Frame = Frame()

    @property
    def freedoms(self) -> tuple[Floats, ...]:
        """Return the unit motions (6, n) of each step of the joint."""
        return (np.eye(6),)

    @property
    def at_start(self) -> tuple[Floats, ...]:
        """Return the pose (4, 4) of each step at home, roughly."""
        return (self.start.pose,)
