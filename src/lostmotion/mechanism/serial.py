"""Serial arms at poses: frames, wrenches and holding torques, and the terms of all parts. q has one value per moving joint."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.mechanism.frames import place_frames, tool_point
from lostmotion.mechanism.wrenches import place_wrenches, wrenches_by_axis
from lostmotion.parts.error_source import Condition, Holding, Term
from lostmotion.parts.joint import FixedJoint
from lostmotion.spatial import into, mapped

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.tool import Payload
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.spatial import Floats


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
    """Return joint values as (pose, joint). Raises ValueError for another shape or a value that is not finite."""
    values = np.atleast_2d(np.asarray(q, dtype=float))
    if values.ndim != 2 or values.shape[1] != len(arm.moving):  # noqa: PLR2004 - pose and joint
        raise ValueError(f"q has shape {np.shape(q)}; expected (pose, {len(arm.moving)}): one value per moving joint of '{arm.name}'")
    if not np.isfinite(values).all():
        raise ValueError("q holds a value that is not finite")
    return values


def frames(arm: Arm, q: Floats) -> Floats:
    """Return the poses of all places (place, pose, 4, 4) in the base's frame, m, for q (pose, joint) in rad or m.

    Places are named by `arm.places`; no limit is applied to q. Raises ValueError for q of another shape or not finite. Equal to Pinocchio's frames
    (tests/validation).
    """
    return place_frames(arm.tree, as_poses(arm, q))


def tool_points(arm: Arm, q: Floats) -> Floats:
    """Return the tool point (pose, 3), m, in the base's frame: `frames(arm, q)[-1, :, :3, 3]` in a small part of the time, for clouds of poses."""
    return tool_point(arm.tree, as_poses(arm, q))


def wrenches(arm: Arm, q: Floats, payload: Payload | None = None, gravity: Floats | None = None) -> Floats:
    """Return what everything outboard of a place puts on it: wrenches (place, pose, 6) in the place's own frame, N m and N.

    Static: weights of links, joints, tool and payload, and the payload's process force. A joint's own mass, or its gearbox's where none is stated,
    sits on its seat with the housing, so it loads the link before and not its own bearing. `payload` left out: the arm's own; `gravity` (3,) in the
    base's axes, m/s^2, left out: the arm's, turned by the base's tilt. Raises ValueError for q of another shape or not finite. Equal to Pinocchio's
    static torques (tests/validation).
    """
    free_fall = arm.gravity_in_base if gravity is None else np.asarray(gravity, dtype=float)
    return place_wrenches(arm.tree, frames(arm, q), payload or arm.payload, free_fall)


def joint_torques(arm: Arm, q: Floats, payload: Payload | None = None, gravity: Floats | None = None) -> Floats:
    """Return the torque (force on a sliding joint) that each drive must hold (pose, joint), N m or N, positive along the joint's motion.

    Arguments and errors as `wrenches`. Equal to Pinocchio's generalised gravity.
    """
    carried = wrenches(arm, q, payload, gravity)
    return np.column_stack([-mapped(joint.twist, carried[place]) for joint, place in zip(arm.moving, arm.tree.moved, strict=True)])


def worst_torques_over_tilts(arm: Arm, q: Floats, payload: Payload | None = None, within: float = math.pi) -> Floats:
    """Return the largest holding torque of each joint over tilts of the base (pose, joint), N m or N, not negative.

    Eq. (3) of S. Strutynskyi, R. Semenchuk 2021 in its proper reading, for any joint: on a turning joint the weight outboard times the distance
    of its centre of mass from the axis, on a sliding one the whole weight; a process force on the tool turns with the arm. `within` (rad): only
    tilts of the base by at most so much from level, towards any side; left out, all of them.
    Exact, without a search over tilts: torque = gravity . v + the torque of the process force, and a direction within a cone that is nearest to v
    is v itself or lies on the cone's edge.
    """
    by_axis, process = wrenches_by_axis(arm.tree, frames(arm, q), payload or arm.payload)
    out = []
    for joint, place in zip(arm.moving, arm.tree.moved, strict=True):
        v = arm.gravity * np.stack([mapped(joint.twist, weight) for weight in by_axis[:, place]], axis=-1)
        away = np.arctan2(np.hypot(v[:, 0], v[:, 1]), -v[:, 2])  # from straight down
        most, least = (np.linalg.norm(v, axis=-1) * np.cos(np.maximum(angle - within, 0.0)) for angle in (away, math.pi - away))
        pushed = mapped(joint.twist, process[place])
        out.append(np.maximum(np.abs(pushed + most), np.abs(pushed - least)))
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
    carried = place_wrenches(arm.tree, at, arm.payload, arm.gravity_in_base)
    at_joints = {joint.moved: number for number, joint in enumerate(arm.tree.joints)}
    for owner, place, angle, arriving, axis, source in _sources(arm, q, np.broadcast_to(np.asarray(approach, dtype=float), q.shape)):
        gravity = into(at[place], arm.gravity_in_base)
        holding = functools.partial(arm.holding, at_joints[place]) if place in at_joints else Holding
        yield owner, place, source, Condition(angle, axis, carried[place], gravity, arriving, holding)


def _sources(arm: Arm, q: Floats, approach: Floats) -> Iterator[tuple[str, int, Floats, Floats, Floats, ErrorSource]]:
    """Walk the parts: owner, index of the place, joint value, sign of the joint's last motion, unit twist there, the part."""
    still, nothing = np.zeros(len(q)), np.zeros(6)
    for name, source in arm.base.sources.items():
        yield f"base {name}", 0, still, still, nothing, source
    column = iter(zip(q.T, approach.T, strict=True))
    for joint, (seat, moved, tip) in zip(arm.joints, arm.tree.joints, strict=True):
        owner = f"joints.{joint.name}"
        angle, arriving = (still, still) if isinstance(joint, FixedJoint) else next(column)
        if joint.mounting is not None:
            across_what = joint.twist if joint.twist.any() else np.eye(6)[2]
            yield f"{owner}.mounting", seat, angle, arriving, across_what, joint.mounting
        for name, source in joint.sources.items():
            yield f"{owner}.{name}", moved, angle, arriving, joint.twist, source
        yield f"{owner}.link", tip, angle, arriving, nothing, joint.elastic_link
