"""Motion of the joints in the tests of ISO 9283: approach directions, and joint values along a
straight path.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.arrival import STILL, last_motion
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.propagation.iso9283.cube import NAMES

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.iso9283.cube import Cube
    from lostmotion.spatial import Floats

# Distance from which a pose is approached along an axis, as a share of the cube's side.
_APPROACH: Final = 0.1


def cycle_approach(q: Floats) -> tuple[Floats, np.ndarray]:
    """Return the sign of each joint's motion on arrival at P1 to P5 (5, joint) in the cycle P5, P4,
    P3, P2, P1, and which joints never move (joint,).

    A joint at rest between two poses keeps the sign of its previous motion; one that never moves
    counts as +1. Joints move monotonically from pose to pose.
    """
    # Of two cycles one after the other, the second has no first motion.
    signs = last_motion(np.tile(q[::-1], (2, 1)))[0][len(q) :][::-1]
    still = np.asarray(~signs.any(axis=0))
    return np.where(still, 1.0, signs), still


def side_approach(arm: Arm, cube: Cube, pose: int, otherwise: Floats) -> Floats:
    """Return the sign of each joint's motion (3, joint) on arrival at one of the five poses along
    the base's x, y and z.

    The approach starts a tenth of the cube's side away, towards the cube's centre, so that it is
    within reach; at the centre itself it follows the axes' directions. Joints that do not move keep
    the sign of the cycle, `otherwise` (joint,).
    """
    here = cube.poses[pose]
    inward = np.sign(cube.centre - here[:3, 3])
    before = np.tile(here, (3, 1, 1))
    before[:, :3, 3] += np.diag(
        np.where(np.abs(cube.centre - here[:3, 3]) < STILL, -1.0, inward)
    ) * (_APPROACH * cube.side)
    q, reached = inverse_kinematics(
        arm, before, np.tile(cube.q[pose], (3, 1)), with_orientation=cube.rotation is not None
    )
    if not reached.all():
        raise refuse_argument(
            "cube", f"no way to {NAMES[pose]} along the base's axes", "a smaller cube, within reach"
        )
    moved = cube.q[pose] - q
    return np.asarray(np.where(np.abs(moved) < STILL, otherwise, np.sign(moved)))


def path_poses(arm: Arm, cube: Cube, ends: tuple[int, int], points: int) -> Floats:
    """Return the joint values (point, joint) along the straight line between two of the five poses.

    Raises InputError where the line leaves the arm's reach.
    """
    a, b = ends
    share = np.linspace(0.0, 1.0, points)[:, None]
    wanted = np.tile(cube.poses[a], (points, 1, 1))
    wanted[:, :3, 3] = (1 - share) * cube.poses[a, :3, 3] + share * cube.poses[b, :3, 3]
    q = np.empty((points, cube.q.shape[1]))
    here = cube.q[a]
    for k in range(points):
        found, reached = inverse_kinematics(
            arm, wanted[k : k + 1], here[None], with_orientation=cube.rotation is not None
        )
        if not reached[0]:
            raise refuse_argument(
                "path",
                f"{NAMES[a]} {NAMES[b]}",
                "a line that the arm can follow without a change of configuration",
                path="P3 P5",
            )
        q[k] = here = found[0]
    return q


def path_approach(q: Floats, otherwise: Floats) -> Floats:
    """Return the sign of each joint's last motion at the points q (point, joint) of a path.

    The run-up comes along the path too. Joints that do not move keep the sign of the cycle,
    `otherwise` (joint,).
    """
    return last_motion(np.vstack([2 * q[0] - q[1], q]), before=otherwise)[0][1:]
