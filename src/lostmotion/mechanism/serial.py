"""Serial arms at poses: frames, wrenches, holding torques, and what each part feels. q has one value per moving joint."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.mechanism.frames import place_frames, tool_point
from lostmotion.mechanism.wrenches import place_wrenches, wrenches_by_axis
from lostmotion.parts.term import Condition
from lostmotion.spatial import into, mapped

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedPart, PlacedTerm
    from lostmotion.mechanism.tool import Payload
    from lostmotion.spatial import Floats


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
    sits on its seat with the housing, so it loads the link before and not its own bearing. `payload` by default the arm's own; `gravity` (3,) in the
    base's axes, m/s^2, by default the arm's, turned by the base's tilt. Raises ValueError for q of another shape or not finite. Equal to Pinocchio's
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
    tilts of the base by at most so much from level, towards any side; by default all of them.
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


class Conditions:
    """What every place of an arm feels at some poses: q (pose, joint) in rad or m, `at` the frames there."""

    def __init__(self, arm: Arm, q: Floats, at: Floats) -> None:
        """Compute the load at every place once."""
        self._arm, self._q, self._at = arm, q, at
        self._carried = place_wrenches(arm.tree, at, arm.payload, arm.gravity_in_base)
        self._known: dict[tuple[int, int | None], Condition] = {}

    def __call__(self, of: PlacedPart | PlacedTerm) -> Condition:
        """Return what a part, or the part of a term, feels (pose last); parts at one place share it."""
        key = of.place, of.joint
        if key not in self._known:
            angle = np.zeros(len(self._q)) if of.joint is None else np.ascontiguousarray(self._q[:, of.joint])
            gravity = into(self._at[of.place], self._arm.gravity_in_base)
            self._known[key] = Condition(angle, np.ascontiguousarray(self._carried[of.place].T), np.ascontiguousarray(gravity.T))
        return self._known[key]
