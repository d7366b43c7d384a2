"""Inverse kinematics by damped Newton steps within the joint limits, for many poses at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.closed_inverse import solved, tool_and_columns
from lostmotion.mechanism.inverse_kernel import write_tool_and_jacobian
from lostmotion.mechanism.state import as_poses

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# A pose counts as reached within this distance (m) and rotation (rad), far below the accuracy of
# any arm.
REACHED: Final = 1e-9
# Longest step of a turning joint, rad; for a sliding joint, as a share of the arm's size.
_LONGEST_STEP: Final = 0.4
_DAMPING: Final = 1e-4
# The same of plain steps, as a share of the trace: against singular poses alone.
_LEAST_DAMPING: Final = 1e-9
# A joint within this distance (rad or m) of a limit counts as at the limit.
_AT_LIMIT: Final = 1e-9


def tool_and_jacobian(arm: Arm, q: Floats) -> tuple[Floats, Floats]:
    """Return the pose of the tool (pose, 4, 4), m, in the base's frame, and its Jacobian (pose, 6,
    joint), for q (pose, joint) in rad or m.

    The pose equals the last of `State.frames` to rounding. The Jacobian is the twist of the tool
    about the tool point, in the base's axes, per motion of each joint: rad or m per rad or m.
    Of a closed chain, the passive joints follow the drives. Raises ValueError for q of another
    shape or not finite, InputError for a pose at which a closed chain is not assembled.
    Source: K. Lynch, F. Park, Modern Robotics, 2017, 5.1.
    """
    values = as_poses(arm, q)
    if arm.closures:
        return tool_and_columns(arm.tree, values)
    fixed, step = [], np.eye(4)
    for place in (arm.tree.places[number] for number in arm.tree.tool_path[1:]):
        if place.joint is None:
            step = step @ place.pose
        else:
            fixed.append(step)
            step = np.eye(4)
    fixed.append(step)
    drives = list(arm.tree.tool_joints)
    moving = [arm.tree.places[arm.tree.moved[drive]].twist[:, 0] for drive in drives]
    turning, sliding = (
        np.array([twist[half] for twist in moving]) for half in (slice(3), slice(3, 6))
    )
    frame, jacobian = np.empty((len(values), 4, 4)), np.empty((len(values), 6, len(drives)))
    all_move = len(drives) == values.shape[1]
    write_tool_and_jacobian(
        np.ascontiguousarray(values if all_move else values[:, drives]),
        np.array(fixed),
        turning,
        sliding,
        frame,
        jacobian,
    )
    if all_move:
        return frame, jacobian
    out = np.zeros((len(values), 6, values.shape[1]))  # joints on a branch do not move the tool
    out[:, :, drives] = jacobian
    return frame, out


def pose_difference(reached: Floats, wanted: Floats) -> Floats:
    """Return the motion (..., 6) from reached to wanted poses (..., 4, 4): rotation vector (rad)
    and displacement of the origin (m), base axes.
    """
    from scipy.spatial.transform import Rotation

    turned = wanted[..., :3, :3] @ np.swapaxes(reached[..., :3, :3], -1, -2)
    shape = turned.shape[:-2]
    rotation = Rotation.from_matrix(turned.reshape(-1, 3, 3)).as_rotvec().reshape(*shape, 3)
    return np.concatenate([rotation, wanted[..., :3, 3] - reached[..., :3, 3]], axis=-1)


def inverse_kinematics(
    arm: Arm, wanted: Floats, start: Floats, *, with_orientation: bool, steps: int = 40
) -> tuple[Floats, np.ndarray]:
    """Return joint values (pose, joint), rad or m, that bring the tool to the wanted poses, and a
    mask (pose,) of the poses that were reached.

    wanted            (pose, 4, 4) poses of the tool in the base's frame, m
    start             (pose, joint) joint values to start from, rad or m
    with_orientation  whether the orientation of the tool must be reached too, or only the tool
                      point
    steps             largest number of Newton steps

    A pose is reached if its error is below `REACHED` within the joint limits. A pose that is not
    reached from one start may be reached from another. A joint at its limit does not move beyond it
    (clamping of P. Baerlocher, R. Boulic, Visual Computer 20 (2004) 402). Joints on a branch keep
    their values. A closed chain stays in the assembly mode of its home, away from its parallel
    singularities, at values that are not reached too.
    Raises ValueError for a start of another shape or not finite.
    """
    low, high = arm.limits.T
    q = np.clip(as_poses(arm, start), low, high)
    rows = slice(0, 6) if with_orientation else slice(3, 6)
    if arm.closures:
        return solved(arm.tree, arm.limits, wanted, q, np.arange(6)[rows], REACHED, steps)
    done = np.zeros(len(q), bool)
    size = max(float(np.abs(wanted[:, :3, 3]).max(initial=0.0)), 0.1)
    weight = np.r_[np.full(3, size), np.ones(3)][rows]
    longest = _LONGEST_STEP * np.array(
        [1.0 if joint.type == "revolute" else size for joint in arm.driven]
    )
    active = np.arange(len(q))
    for _ in range(steps):
        here = q[active]
        at, jacobian = tool_and_jacobian(arm, here)
        error = (
            pose_difference(at, wanted[active])
            if with_orientation
            else wanted[active, :3, 3] - at[:, :3, 3]
        )
        near = (np.abs(error) < REACHED).all(axis=1)
        done[active[near]] = True
        active, error = active[~near], error[~near]
        if not len(active):
            break
        here, scaled = here[~near], jacobian[~near][:, rows] * weight[:, None] * longest
        move = _step(scaled, error * weight, size)
        blocked = ((here <= low + _AT_LIMIT) & (move < 0)) | (
            (here >= high - _AT_LIMIT) & (move > 0)
        )
        if blocked.any():
            move = _step(np.where(blocked[:, None, :], 0.0, scaled), error * weight, size)
        move /= np.maximum(np.abs(move).max(axis=1, keepdims=True), 1.0)
        q[active] = np.clip(here + move * longest, low, high)
    return q, done


def stepped_towards(arm: Arm, q: Floats, points: Floats, steps: int) -> Floats:
    """Return joint values (pose, joint) after plain Newton steps from q towards points (pose, 3),
    m, with least motion as a share of the joint ranges, within the limits.

    The tool is where the steps end, which need not be at the points. Of a closed chain the steps
    are the damped ones of `inverse_kinematics`, which keep it assembled.
    """
    low, high = arm.limits.T
    if arm.closures:
        wanted = np.tile(np.eye(4), (len(q), 1, 1))
        wanted[:, :3, 3] = points
        return inverse_kinematics(arm, wanted, q, with_orientation=False, steps=steps)[0]
    for _ in range(steps):
        at, levers = tool_and_jacobian(arm, q)
        push = levers[:, 3:] * (high - low)
        square = push @ np.swapaxes(push, 1, 2)
        square += (_LEAST_DAMPING * np.einsum("pii->p", square) + np.finfo(float).tiny)[
            :, None, None
        ] * np.eye(3)
        move = np.linalg.solve(square, (points - at[:, :3, 3])[..., None])
        q = np.clip(q + (np.swapaxes(push, 1, 2) @ move)[..., 0] * (high - low), low, high)
    return q


def _step(jacobian: Floats, error: Floats, size: float) -> Floats:
    """Return the smallest motion (pose, joint) that solves jacobian @ motion = error by damped
    least squares.
    """
    square = jacobian @ np.swapaxes(jacobian, 1, 2)
    # Strong damping far from the solution, almost none near it, where Newton's steps converge.
    far = np.minimum((error**2).sum(axis=1), (0.1 * size) ** 2)
    square += (_DAMPING * far + 1e-12 * size**2)[:, None, None] * np.eye(square.shape[1])
    return np.asarray(
        (np.swapaxes(jacobian, 1, 2) @ np.linalg.solve(square, error[..., None]))[..., 0]
    )
