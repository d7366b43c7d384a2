"""Joint values along poses of the tool, continued from pose to pose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Number of sampled poses, and of the nearest ones from which the first pose is tried.
_SAMPLES: Final = 4096
_STARTS: Final = 32
# Joint values at one pose that differ by less (rad or m) are one configuration.
_SAME: Final = 0.2
# Configurations in which a whole path is tried.
_CONFIGURATIONS: Final = 6


class Starts(NamedTuple):
    """Sampled poses from which the first pose of a path is tried: joint values (pose, joint), rad
    or m, and where the tool is (pose, 3), m.
    """

    q: Floats
    points: Floats


def starts_of(arm: Arm) -> Starts:
    """Return the sampled poses of an arm, once for all of its paths."""
    q = sample_poses(arm, _SAMPLES).q
    return Starts(q, tool_points(arm, q))


def joint_path(
    arm: Arm, wanted: Floats, *, with_orientation: bool, starts: Starts | None = None
) -> tuple[Floats, int]:
    """Return the joint values (pose, joint), rad or m, at poses of the tool (pose, 4, 4), m, in
    their order, and how many of the first poses were reached.

    The configuration is the first of those found at the first pose in which the whole path is
    reached without a change of configuration; else the one that reaches furthest.

    starts  of this arm, where many paths are sought; by default they are sampled here
    """
    sampled = starts or starts_of(arm)
    distance = np.linalg.norm(sampled.points - wanted[0, :3, 3], axis=1)
    near = sampled.q[np.argsort(distance, kind="stable")[:_STARTS]]
    found, reached = inverse_kinematics(
        arm, np.tile(wanted[0], (len(near), 1, 1)), near, with_orientation=with_orientation
    )
    kept: list[Floats] = []
    for q in found[reached]:
        if all(np.abs(q - other).max() > _SAME for other in kept):
            kept.append(q)
    best, furthest = np.tile(arm.limits.mean(axis=1), (len(wanted), 1)), 0
    for first in kept[:_CONFIGURATIONS]:
        q, count = _followed(arm, wanted, first, with_orientation=with_orientation)
        if count > furthest:
            best, furthest = q, count
        if furthest == len(wanted):
            break
    return best, furthest


def _followed(
    arm: Arm, wanted: Floats, first: Floats, *, with_orientation: bool
) -> tuple[Floats, int]:
    """Return the joint values from pose to pose, and how many of the first poses were reached."""
    out = np.tile(first, (len(wanted), 1))
    for k in range(1, len(wanted)):
        found, reached = inverse_kinematics(
            arm, wanted[k : k + 1], out[k - 1 : k], with_orientation=with_orientation
        )
        if not reached[0]:
            return out, k
        out[k] = found[0]
    return out, len(wanted)
