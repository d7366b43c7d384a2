"""An arm at poses q (pose, joint): frames, wrenches, holding torques, and the condition of each
part (angle, wrench, gravity).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

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


# Horizontal part of a unit vector that is vertical but for rounding.
_UPRIGHT: Final = 1e-9


def as_poses(arm: Arm, q: Floats) -> Floats:
    """Return joint values as (pose, joint). Raises ValueError for another shape or a value that is
    not finite.
    """
    values = np.atleast_2d(np.asarray(q, dtype=float))
    if values.ndim != 2 or values.shape[1] != len(arm.moving):  # noqa: PLR2004 - pose and joint
        raise ValueError(
            f"q has shape {np.shape(q)}; expected (pose, {len(arm.moving)}): one value per "
            f"moving joint of '{arm.name}'"
        )
    if not np.isfinite(values).all():
        raise ValueError("q has a value that is not finite")
    return values


def frames(arm: Arm, q: Floats) -> Floats:
    """Return the poses of all places (place, pose, 4, 4) in the base's frame, m, for q (pose,
    joint) in rad or m.

    The places are in the order of `arm.places`. The joint limits are not applied. Raises ValueError
    for q of another shape or not finite. Equal to Pinocchio's frames (tests/validation).
    """
    return place_frames(arm.tree, as_poses(arm, q))


def tool_points(arm: Arm, q: Floats) -> Floats:
    """Return the tool point (pose, 3), m, in the base's frame. Equal to `frames(arm, q)[-1, :, :3,
    3]`, in a fraction of its time.
    """
    return tool_point(arm.tree, as_poses(arm, q))


def vertical_axis(arm: Arm) -> tuple[float, float] | None:
    """Return the position (x, y; m) of the first joint's axis in the base's axes if that joint
    turns about a vertical axis; else None.
    """
    place = arm.tree.moved[arm.tree.tool_joints[0]]
    at = frames(arm, arm.limits.mean(axis=1)[None])[place, 0]
    axis = at[:3, :3] @ arm.tree.places[place].twist[:3]  # zero for a joint that slides
    upright = axis.any() and math.hypot(axis[0], axis[1]) <= _UPRIGHT
    return (float(at[0, 3]), float(at[1, 3])) if upright else None


def wrenches(
    arm: Arm, q: Floats, payload: Payload | None = None, gravity: Floats | None = None
) -> Floats:
    """Return the static wrench on each place from everything outboard of it: (place, pose, 6) in
    the place's own frame, N m and N.

    q        (pose, joint) rad or m
    payload  by default the arm's own
    gravity  (3,) acceleration of free fall in the base's axes, m/s^2; by default the arm's, at the
             base's nominal tilt

    The loads are the weights of links, joints, tool and payload, and the process force and moment.
    The mass of a joint, or of its gearbox where none is stated, is on its seat with the housing. So
    it loads the previous link and not its own bearing.
    Raises ValueError for q of another shape or not finite. Equal to Pinocchio's static torques
    (tests/validation).
    """
    free_fall = arm.gravity_in_base if gravity is None else np.asarray(gravity, dtype=float)
    return place_wrenches(arm.tree, frames(arm, q), payload or arm.payload, free_fall)


def joint_torques(
    arm: Arm, q: Floats, payload: Payload | None = None, gravity: Floats | None = None
) -> Floats:
    """Return the torque (force on a sliding joint) that each drive must hold (pose, joint), N m or
    N, positive along the joint's motion.

    Arguments and errors as `wrenches`. Equal to Pinocchio's generalised gravity (tests/validation).
    """
    return torques_of(arm, wrenches(arm, q, payload, gravity))


def torques_of(arm: Arm, carried: Floats) -> Floats:
    """Return the holding torques or forces (pose, joint), N m or N, for the wrenches (place, pose,
    6) that `wrenches` returns.
    """
    return np.column_stack(
        [
            -mapped(joint.twist, carried[place])
            for joint, place in zip(arm.moving, arm.tree.moved, strict=True)
        ]
    )


def worst_torques_over_tilts(
    arm: Arm, q: Floats, payload: Payload | None = None, within: float = math.pi
) -> Floats:
    """Return the largest magnitude of each joint's holding torque over tilts of the base (pose,
    joint), N m or N.

    within (rad): largest tilt of the base from level, in any direction; by default all tilts. Other
    arguments and errors as `wrenches`.

    Over all tilts the torque of a turning joint is the weight outboard times the distance of its
    centre of mass from the axis, and the force of a sliding joint is the whole weight. A process
    force on the tool turns with the arm.
    Exact, without a search: torque = gravity . v + torque of the process force. The direction
    within a cone that is nearest to v is v itself or lies on the edge of the cone. Source:
    generalises eq. (3) of S. Strutynskyi, R. Semenchuk 2021 to any joint.
    """
    by_axis, process = wrenches_by_axis(arm.tree, frames(arm, q), payload or arm.payload)
    out = []
    for joint, place in zip(arm.moving, arm.tree.moved, strict=True):
        v = arm.gravity * np.stack(
            [mapped(joint.twist, weight) for weight in by_axis[:, place]], axis=-1
        )
        from_down = np.arctan2(np.hypot(v[:, 0], v[:, 1]), -v[:, 2])
        most, least = (
            np.linalg.norm(v, axis=-1) * np.cos(np.maximum(angle - within, 0.0))
            for angle in (from_down, math.pi - from_down)
        )
        of_process = mapped(joint.twist, process[place])
        out.append(np.maximum(np.abs(of_process + most), np.abs(of_process - least)))
    return np.column_stack(out)


class Conditions:
    """Angle, wrench and gravity at every place of an arm, at poses q (pose, joint; rad or m) with
    frames `at` (place, pose, 4, 4; m).
    """

    def __init__(self, arm: Arm, q: Floats, at: Floats) -> None:
        """Compute the wrench at every place."""
        self._arm, self._q, self._at = arm, q, at
        self._carried = place_wrenches(arm.tree, at, arm.payload, arm.gravity_in_base)
        self._known: dict[tuple[int, int | None], Condition] = {}

    def __call__(self, part: PlacedPart | PlacedTerm) -> Condition:
        """Return the condition of a part, or of the part of a term, with poses as the last axis.
        Parts at one place with one joint share it.
        """
        key = part.place, part.joint
        if key not in self._known:
            angle = (
                np.zeros(len(self._q))
                if part.joint is None
                else np.ascontiguousarray(self._q[:, part.joint])
            )
            gravity = into(self._at[part.place], self._arm.gravity_in_base)
            wrench, rise = (
                np.ascontiguousarray(self._carried[part.place].T),
                self._arm.environment.rise,
            )
            self._known[key] = Condition(
                angle,
                wrench,
                np.ascontiguousarray(gravity.T),
                0.0 if rise is None else rise.nominal,
            )
        return self._known[key]
