"""Inverse kinematics by damped Newton steps within the joint limits, for many poses at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.inverse_kernel import tool_and_levers
from lostmotion.mechanism.serial import as_poses

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# A pose is reached within this distance (m) and rotation (rad), far below any accuracy of an arm.
REACHED: Final = 1e-9
# Longest step of a turning joint, rad; a sliding joint takes this share of the arm's size.
_LONGEST_STEP: Final = 0.4
_DAMPING: Final = 1e-4
_BARELY: Final = 1e-9


def tool_and_jacobian(arm: Arm, q: Floats) -> tuple[Floats, Floats]:
    """Return the tool's pose (pose, 4, 4), which is `frames(arm, q)[-1]` to rounding, and its twist per motion of each joint (pose, 6, joint).

    The twist is about the tool point in the base's axes, rad or m per rad or m. Raises ValueError for q of another shape or not finite.
    Source: K. Lynch, F. Park, Modern Robotics, 2017, 5.1.
    """
    values = as_poses(arm, q)
    fixed, step = [], np.eye(4)
    for place in (arm.tree.places[number] for number in arm.tree.way[1:]):
        if place.joint is None:
            step = step @ place.pose
        else:
            fixed.append(step)
            step = np.eye(4)
    fixed.append(step)
    drives = list(arm.tree.drives)
    moving = [arm.tree.places[arm.tree.moved[drive]].twist for drive in drives]
    turning, sliding = (np.array([twist[half] for twist in moving]) for half in (slice(3), slice(3, 6)))
    frame, levers = np.empty((len(values), 4, 4)), np.empty((len(values), 6, len(drives)))
    every = len(drives) == values.shape[1]
    tool_and_levers(np.ascontiguousarray(values if every else values[:, drives]), np.array(fixed), turning, sliding, frame, levers)
    if every:
        return frame, levers
    out = np.zeros((len(values), 6, values.shape[1]))  # joints on a branch do not move the tool
    out[:, :, drives] = levers
    return frame, out


def pose_difference(reached: Floats, wanted: Floats) -> Floats:
    """Return the motion (..., 6) that leads from poses to others (..., 4, 4): rotation vector (rad) and shift of the origin (m), base axes."""
    from scipy.spatial.transform import Rotation

    turned = wanted[..., :3, :3] @ np.swapaxes(reached[..., :3, :3], -1, -2)
    shape = turned.shape[:-2]
    rotation = Rotation.from_matrix(turned.reshape(-1, 3, 3)).as_rotvec().reshape(*shape, 3)
    return np.concatenate([rotation, wanted[..., :3, 3] - reached[..., :3, 3]], axis=-1)


def inverse_kinematics(arm: Arm, wanted: Floats, start: Floats, *, turned: bool, steps: int = 40) -> tuple[Floats, np.ndarray]:
    """Return joint values (pose, joint) that bring the tool to the wanted poses (pose, 4, 4), and a mask of the poses that were reached.

    start   (pose, joint) joint values to start from, rad or m
    turned  whether the orientation of the tool counts, or only the tool point

    A pose is reached within `REACHED` and the joint limits; one that is not reached from one start may be reached from another. A joint on its limit
    that would go beyond does not move (clamping of P. Baerlocher, R. Boulic, Visual Computer 20 (2004) 402). Joints on a branch keep their values.
    """
    low, high = arm.limits.T
    q = np.clip(as_poses(arm, start), low, high)
    rows = slice(0, 6) if turned else slice(3, 6)
    done = np.zeros(len(q), bool)
    size = max(float(np.abs(wanted[:, :3, 3]).max(initial=0.0)), 0.1)
    weight = np.r_[np.full(3, size), np.ones(3)][rows]
    longest = _LONGEST_STEP * np.array([1.0 if joint.type == "revolute" else size for joint in arm.moving])
    active = np.arange(len(q))
    for _ in range(steps):
        here = q[active]
        at, push = tool_and_jacobian(arm, here)
        miss = pose_difference(at, wanted[active]) if turned else wanted[active, :3, 3] - at[:, :3, 3]
        near = (np.abs(miss) < REACHED).all(axis=1)
        done[active[near]] = True
        active, miss = active[~near], miss[~near]
        if not len(active):
            break
        here, push = here[~near], push[~near][:, rows] * weight[:, None] * longest
        move = _step(push, miss * weight, size)
        blocked = ((here <= low + _BARELY) & (move < 0)) | ((here >= high - _BARELY) & (move > 0))
        if blocked.any():
            move = _step(np.where(blocked[:, None, :], 0.0, push), miss * weight, size)
        move /= np.maximum(np.abs(move).max(axis=1, keepdims=True), 1.0)
        q[active] = np.clip(here + move * longest, low, high)
    return q, done


def _step(push: Floats, miss: Floats, size: float) -> Floats:
    """Solve push @ move = miss by damped least squares for the smallest motion (pose, joint)."""
    square = push @ np.swapaxes(push, 1, 2)
    # Strong damping far from the solution, almost none near it, where Newton's steps converge.
    far = np.minimum((miss**2).sum(axis=1), (0.1 * size) ** 2)
    square += (_DAMPING * far + 1e-12 * size**2)[:, None, None] * np.eye(square.shape[1])
    return np.asarray((np.swapaxes(push, 1, 2) @ np.linalg.solve(square, miss[..., None]))[..., 0])
