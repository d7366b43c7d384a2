"""An arm: joints and links from base to tool, walked out for where everything is and back for what it carries."""

from __future__ import annotations

import functools
import math
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Final, Self

import numpy as np
from pydantic import Field, PrivateAttr, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.mechanism.holding import holdings, spread_evenly
from lostmotion.mechanism.remarks import remarks_on
from lostmotion.parts.base import Base
from lostmotion.parts.error_source import Condition, Force, Holding, Line, Mass, Part, Term, Torque
from lostmotion.parts.joint import FixedJoint, Joint, PrismaticJoint, RevoluteJoint
from lostmotion.parts.link import Place, Vector
from lostmotion.parts.provenance import Sourced
from lostmotion.spatial import combined, cross, into, inverse, mapped, motion, out_of
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from lostmotion.parts.error_source import ErrorSource, Friction
    from lostmotion.spatial import Floats

STANDARD_GRAVITY = 9.80665
# What an arm counts as carrying at least where friction is assumed, kg.
_LEAST_HELD: Final = 0.1
LONGEST_NAME: Final = 80
LONGEST_NOTE: Final = 300
MOST_NOTES: Final = 200
MOST_JOINTS: Final = 64


class Payload(Sourced):
    """What hangs on the tool: a mass with its centre in the tool frame, and a process force and moment in the tool's axes."""

    mass: Mass = 0.0
    centre_of_mass: Vector = (0.0, 0.0, 0.0)
    force: tuple[Force, Force, Force] = (0.0, 0.0, 0.0)
    moment: tuple[Torque, Torque, Torque] = (0.0, 0.0, 0.0)


class Tool(Sourced):
    """The tool frame seen from the last link's tip, and what the tool itself weighs."""

    frame: Place = Place()
    mass: Mass = 0.0
    centre_of_mass: Vector = (0.0, 0.0, 0.0)


class Arm(Part):
    """A serial arm of any number of revolute, prismatic and fixed joints, from its base to its tool.

    Places stand in walking order: "base", then for each joint NAME its seat "NAME.seat" (before the motion), "NAME" (after it) and
    "NAME.tip" (the far end of its link), and last "tool". q holds the moving joints only, rad or m, in order.
    """

    name: Annotated[Line, Field(min_length=1, max_length=LONGEST_NAME)]
    joints: Annotated[tuple[Joint, ...], Field(min_length=1, max_length=MOST_JOINTS)]
    base: Base = Base()
    tool: Tool = Tool()
    payload: Payload = Payload()
    gravity: Annotated[float, Quantity("m/s^2", "9.81 m/s^2", low=0)] = STANDARD_GRAVITY
    notes: Annotated[tuple[Annotated[Line, Field(max_length=LONGEST_NOTE)], ...], Field(max_length=MOST_NOTES)] = ()

    _doubts: tuple[str, ...] = PrivateAttr(())

    @model_validator(mode="after")
    def _names_differ_and_something_moves(self) -> Self:
        twice = sorted(name for name, times in Counter(joint.name for joint in self.joints).items() if times > 1)
        if twice:
            context = {
                "why": f"the joint name '{twice[0]}' more than once",
                "expected": "a name of its own for every joint",
                "example": f'name = "{twice[0]}2"',
            }
            raise PydanticCustomError("names", "{why}", context)
        if not self.moving:
            context = {"why": "no joint that moves", "expected": "at least one revolute or prismatic joint", "example": 'type = "revolute"'}
            raise PydanticCustomError("names", "{why}", context)
        return self

    @functools.cached_property
    def moving(self) -> tuple[RevoluteJoint | PrismaticJoint, ...]:
        """Give the joints that q is made of."""
        return tuple(joint for joint in self.joints if not isinstance(joint, FixedJoint))

    @functools.cached_property
    def places(self) -> tuple[str, ...]:
        """Give the names of the places, in the order of `frames` and `wrenches`."""
        return ("base", *(f"{joint.name}{end}" for joint in self.joints for end in (".seat", "", ".tip")), "tool")

    @property
    def seats(self) -> tuple[Floats, ...]:
        """Return every joint's seat as a pose (4, 4) seen from the tip of the link before; the first one's from the base, on which the arm stands."""
        first, *others = (joint.origin.pose for joint in self.joints)
        return (self.base.foot @ first, *others)

    @functools.cached_property
    def limits(self) -> Floats:
        """Give the range of every moving joint (joint, 2), rad or m."""
        return np.array([joint.limits for joint in self.moving])

    @property
    def doubts(self) -> tuple[str, ...]:
        """Return what makes the arm's own description doubtful, as its reader found: shown as warnings with every figure."""
        return self._doubts

    def with_doubts(self, doubts: Iterable[str]) -> Self:
        """Return this arm with these doubts."""
        out = self.model_copy()
        out._doubts = tuple(doubts)  # noqa: SLF001 - of its own kind
        return out

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return the notes, and what is not stated: springs of drawn gearboxes, friction, masses of gearboxes."""
        return (*self.notes, *remarks_on(self))

    @functools.cached_property
    def assumed_friction(self) -> dict[tuple[str, str], Friction]:
        """Give the friction that parts with a play are taken to have where none is stated, and why so much: by names of joint and part, N m or N."""
        out = {}
        for k, joint in enumerate(self.joints):
            for name, source in joint.sources.items():
                friction = source.play_friction(functools.partial(self.holding, k))
                if friction is not None and friction.reason:
                    out[joint.name, name] = friction
        return out

    def holding(self, joint: int) -> Holding:
        """Return the most that a joint, by its number in `joints`, holds at rest, in any pose and on any slope: what assumed friction is measured by.

        Exact over slopes; over poses the largest of 256 that are spread evenly between the joints' limits. Never less than 0.1 kg at the arm's reach
        asks for, so that an axis through every centre of mass, or an arm whose file states no mass, has friction all the same: that of 2 g there,
        less than any drive that carries a tool. No study's poses or seed, and no tilt of the base, changes it.
        """
        return self._holdings[joint]

    @functools.cached_property
    def _holdings(self) -> tuple[Holding, ...]:
        at = frames(self, spread_evenly(self.limits))
        return holdings(self, at, _wrenches(self, at, self.payload, np.zeros(3)), _LEAST_HELD * STANDARD_GRAVITY)

    def carrying(self, payload: Payload) -> Self:
        """Return the arm with another payload and the drives that it has, so with the friction that is assumed of them under its own payload."""
        other = self.model_copy(update={"payload": payload})
        other.__dict__["_holdings"] = self._holdings
        return other

    @property
    def mass(self) -> float:
        """Return the mass (kg) of joints, gearboxes, links and tool as far as it is stated; the payload is not part of it."""
        return sum(joint.total_mass + joint.link.total_mass for joint in self.joints) + self.tool.mass

    @property
    def unweighed(self) -> tuple[str, ...]:
        """Return the models of gearboxes whose mass nobody states, neither of the gearbox nor of its joint: they weigh nothing."""
        found = [joint.gearbox for joint in self.moving if joint.gearbox is not None and joint.mass is None and joint.gearbox.mass is None]
        return tuple(dict.fromkeys(gearbox.model for gearbox in found if gearbox.model))

    @property
    def gravity_in_base(self) -> Floats:
        """Give the acceleration of free fall (3,) in the base's axes, its nominal tilt included."""
        return np.asarray(self.base.tilt.T @ np.array([0.0, 0.0, -self.gravity]))

    def __repr__(self) -> str:
        """Tell the arm in a line."""
        kinds = "".join("F" if isinstance(j, FixedJoint) else "P" if isinstance(j, PrismaticJoint) else "R" for j in self.joints)
        weighs = self.mass
        return f"<Arm '{self.name}': {kinds}, {weighs:.3g} kg, payload {self.payload.mass:g} kg>"

    __str__ = __repr__


@dataclass(frozen=True, slots=True)
class PlacedTerm:
    """A term, the index of the place whose frame its screw is in, and the part that owns it ("joints.A.gearbox")."""

    owner: str
    place: int
    term: Term

    @property
    def name(self) -> str:
        """Give the full name ("joints.A.gearbox.backlash")."""
        return f"{self.owner}.{self.term.name}"


def as_poses(arm: Arm, q: Floats) -> Floats:
    """Check joint values and give them as (pose, joint); raises ValueError for another shape or a value that is not finite."""
    values = np.atleast_2d(np.asarray(q, dtype=float))
    if values.ndim != 2 or values.shape[1] != len(arm.moving):  # noqa: PLR2004 - pose and joint
        raise ValueError(f"q has shape {np.shape(q)}; expected (pose, {len(arm.moving)}): one value per moving joint of '{arm.name}'")
    if not np.isfinite(values).all():
        raise ValueError("q holds a value that is not finite")
    return values


def frames(arm: Arm, q: Floats) -> Floats:
    """Where is every place of the arm? Poses (place, pose, 4, 4) in the base frame, m, for q (pose, joint) in rad or m.

    Places are named by `arm.places`; no limit is applied to q. Raises ValueError for q of another shape or not finite.
    Source: product of exponentials, Lynch and Park 2017, ch. 4; equal to Pinocchio's frames (tests/validation).
    """
    values = as_poses(arm, q)
    out = np.empty((len(arm.places), 4, 4, len(values)))  # poses lie innermost in memory: all steps run along them
    out[0] = np.eye(4)[..., None]
    out[1:, 3] = out[0, 3]
    rows, column = out[:, :3], iter(values.T)
    for k, (seat, joint) in enumerate(zip(arm.seats, arm.joints, strict=True)):
        combined(rows[3 * k], seat.tolist(), out=rows[3 * k + 1])
        moved = np.eye(4).tolist() if isinstance(joint, FixedJoint) else motion(joint.twist, next(column))
        combined(rows[3 * k + 1], moved, out=rows[3 * k + 2])
        combined(rows[3 * k + 2], joint.link.tip_pose.tolist(), out=rows[3 * k + 3])
    combined(rows[-2], arm.tool.frame.pose.tolist(), out=rows[-1])
    return out.transpose(0, 3, 1, 2)


def tool_points(arm: Arm, q: Floats) -> Floats:
    """Where is the tool point? (pose, 3), m, base frame: `frames(arm, q)[-1, :, :3, 3]` at a tenth of the time, for clouds of poses."""
    values = as_poses(arm, q)
    point = np.broadcast_to(arm.tool.frame.pose[:3, 3], (len(values), 3))
    column = values.shape[1]
    for seat, joint in zip(reversed(arm.seats), reversed(arm.joints), strict=True):
        point = _carry(joint.link.tip_pose, point)
        if not isinstance(joint, FixedJoint):
            column -= 1
            turning, sliding = joint.twist[:3], joint.twist[3:]
            angle = values[:, column, None]
            if turning.any():
                along = np.outer(point @ turning, turning)
                point = along + np.cos(angle) * (point - along) + np.sin(angle) * np.cross(turning, point)
            else:
                point = point + angle * sliding
        point = _carry(seat, point)
    return np.asarray(point)


def _carry(pose: Floats, point: Floats) -> Floats:
    return point @ pose[:3, :3].T + pose[:3, 3]


def wrenches(arm: Arm, q: Floats, payload: Payload | None = None, gravity: Floats | None = None) -> Floats:
    """What does everything outboard of a place put on it? Wrenches (place, pose, 6) in the place's own frame, N m and N.

    Static: weights of links, joints, tool and payload, and the payload's process force. A joint's own mass, or its gearbox's where none is stated,
    sits on its seat with the housing, so it loads the link before and not its own bearing. `payload` left out: the arm's own; `gravity` (3,) in the
    base's axes, m/s^2, left out: the arm's, turned by the base's tilt. Raises ValueError for q of another shape or not finite. Equal to Pinocchio's
    static torques (tests/validation).
    """
    values = as_poses(arm, q)
    return _wrenches(arm, frames(arm, values), payload or arm.payload, arm.gravity_in_base if gravity is None else np.asarray(gravity, dtype=float))


class _Carried:
    """Force and moment about the base's origin of all that was met on the way back from the tool."""

    def __init__(self, poses: int, gravity: Floats) -> None:
        self.force = np.zeros((3, poses)).T
        self.moment = np.zeros((3, poses)).T
        self.gravity = gravity

    def weigh(self, frame: Floats, mass: float, centre: Floats) -> None:
        if mass:
            self.push(frame[:, :3, 3] + out_of(frame, np.asarray(centre, dtype=float)), mass * self.gravity)

    def push(self, point: Floats, force: Floats) -> None:
        self.force = self.force + force
        self.moment = self.moment + cross(point, force)


def _wrenches(arm: Arm, at: Floats, payload: Payload, gravity: Floats) -> Floats:
    masses = [payload.mass, arm.tool.mass, *(mass for joint in arm.joints for mass in (joint.total_mass, joint.link.total_mass))]
    if not (any(masses) or any(payload.force) or any(payload.moment)):  # an arm of lumped errors
        return np.zeros((len(at), 6, at.shape[1])).transpose(0, 2, 1)
    carried = _Carried(at.shape[1], gravity)
    forces, moments = np.empty((2, len(at), 3, at.shape[1])).transpose(0, 1, 3, 2)

    def note(place: int) -> None:
        forces[place], moments[place] = carried.force, carried.moment

    tool = at[-1]
    carried.weigh(tool, payload.mass, np.array(payload.centre_of_mass))
    carried.weigh(tool, arm.tool.mass, np.array(arm.tool.centre_of_mass))
    if any(payload.force):
        carried.push(tool[:, :3, 3], out_of(tool, np.array(payload.force)))
    if any(payload.moment):
        carried.moment = carried.moment + out_of(tool, np.array(payload.moment))
    note(len(at) - 1)
    for k, joint in reversed(list(enumerate(arm.joints))):
        note(3 * k + 3)
        carried.weigh(at[3 * k + 2], joint.link.total_mass, joint.link.mass_centre)
        note(3 * k + 2)
        note(3 * k + 1)
        carried.weigh(at[3 * k + 1], joint.total_mass, np.array(joint.centre_of_mass))
    note(0)
    return _seen_from(at, forces, moments)


def _seen_from(at: Floats, forces: Floats, moments: Floats) -> Floats:
    """Give wrenches (place, pose, 6) about each place's origin, in its axes, for forces and moments about the base's origin in its axes."""
    out = np.zeros((len(at), 6, at.shape[1])).transpose(0, 2, 1)
    for vector, here in ((moments - cross(at[:, :, :3, 3], forces), out[..., :3]), (forces, out[..., 3:])):
        for j in range(3):
            here[..., j] = sum(vector[..., i] * at[..., i, j] for i in range(3))
    return out


def joint_torques(arm: Arm, q: Floats, payload: Payload | None = None, gravity: Floats | None = None) -> Floats:
    """Which torque (force on a sliding joint) must each drive hold? (pose, joint), N m or N, positive along the joint's motion.

    Arguments and errors as `wrenches`. Equal to Pinocchio's generalised gravity.
    """
    carried = wrenches(arm, q, payload, gravity)
    return np.column_stack([-mapped(joint.twist, carried[3 * k + 2]) for k, joint in enumerate(arm.joints) if not isinstance(joint, FixedJoint)])


def worst_torques_over_tilts(arm: Arm, q: Floats, payload: Payload | None = None, within: float = math.pi) -> Floats:
    """Which holding torque could gravity ask of each joint, whichever way the base is tilted? (pose, joint), N m or N, not negative.

    Eq. (3) of S. Strutynskyi, R. Semenchuk 2021 in its proper reading, for any joint: on a turning joint the weight outboard times the distance
    of its centre of mass from the axis, on a sliding one the whole weight; a process force on the tool turns with the arm. `within` (rad): only
    tilts of the base by at most so much from level, towards any side; left out, all of them.
    Exact, no search over tilts: torque = gravity . v + what the process force asks, and a direction within a cone that is nearest to v is v itself
    or lies on the cone's edge.
    """
    values = as_poses(arm, q)
    at = frames(arm, values)
    load = payload or arm.payload
    weightless = _wrenches(arm, at, load, np.zeros(3))
    by_axis = [_wrenches(arm, at, load, arm.gravity * np.eye(3)[k]) - weightless for k in range(3)]
    out = []
    for k, joint in enumerate(arm.joints):
        if not isinstance(joint, FixedJoint):
            v = np.stack([mapped(joint.twist, w[3 * k + 2]) for w in by_axis], axis=-1)
            away = np.arctan2(np.hypot(v[:, 0], v[:, 1]), -v[:, 2])  # from straight down
            most, least = (np.linalg.norm(v, axis=-1) * np.cos(np.maximum(angle - within, 0.0)) for angle in (away, math.pi - away))
            process = mapped(joint.twist, weightless[3 * k + 2])
            out.append(np.maximum(np.abs(process + most), np.abs(process - least)))
    return np.column_stack(out)


def terms(arm: Arm, q: Floats, *, approach: float | Floats = 0.0, at: Floats | None = None) -> list[PlacedTerm]:
    """Which elementary errors does every part of the arm make at these poses? In walking order.

    `approach` is the sign of the joints' last motion: -1, +1, or 0 where it differs from visit to visit; one for all, or (pose, joint). `at` are
    the arm's frames at q where they are known already.
    """
    values = as_poses(arm, q)
    here = frames(arm, values) if at is None else at
    return [PlacedTerm(owner, place, term) for owner, place, source, felt in conditions(arm, values, here, approach) for term in source.terms(felt)]


def conditions(arm: Arm, q: Floats, at: Floats, approach: float | Floats = 0.0) -> Iterator[tuple[str, int, ErrorSource, Condition]]:
    """What does every part feel at these poses? Its owner's name, the index of its place, the part, the condition there; `at` are the frames at q."""
    carried = _wrenches(arm, at, arm.payload, arm.gravity_in_base)
    for owner, place, angle, arriving, axis, source in _sources(arm, q, np.broadcast_to(np.asarray(approach, dtype=float), q.shape)):
        gravity = into(at[place], arm.gravity_in_base)
        joint, end = divmod(place - 1, 3)
        holding = functools.partial(arm.holding, joint) if end == 1 else Holding
        yield owner, place, source, Condition(angle, axis, carried[place], gravity, arriving, holding)


def _sources(arm: Arm, q: Floats, approach: Floats) -> Iterator[tuple[str, int, Floats, Floats, Floats, ErrorSource]]:
    """Walk the parts: owner, index of the place, joint value, sign of the joint's last motion, unit twist there, the part."""
    still, nothing = np.zeros(len(q)), np.zeros(6)
    for name, source in arm.base.sources.items():
        yield f"base {name}", 0, still, still, nothing, source
    column = iter(zip(q.T, approach.T, strict=True))
    for k, joint in enumerate(arm.joints):
        seat, tip = 3 * k + 1, 3 * k + 3
        owner = f"joints.{joint.name}"
        angle, arriving = (still, still) if isinstance(joint, FixedJoint) else next(column)
        if joint.mounting is not None:
            across_what = joint.twist if joint.twist.any() else np.eye(6)[2]
            yield f"{owner}.mounting", seat, angle, arriving, across_what, joint.mounting
        for name, source in joint.sources.items():
            yield f"{owner}.{name}", seat + 1, angle, arriving, joint.twist, source
        yield f"{owner}.link", tip, angle, arriving, nothing, joint.elastic_link


def steps_of(at: Floats) -> Floats:
    """Which pose leads from each place to the next? (place, pose, 4, 4), for composing errors exactly."""
    out = at.copy()
    out[1:] = inverse(at[:-1]) @ at[1:]
    return out
