"""Poses that a measured file commands, and the arm in them: where robots are predicted for
comparison when the poses are not those of a test cube.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.iso9283.cube import (
    FULL,
    SAMPLES,
    STARTS,
    candidate_rotations,
    orientation_clause,
)
from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import InputError, Problem
from lostmotion.io.limits import cut
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.mechanism.state import state_of, tool_points

if TYPE_CHECKING:
    from lostmotion.io.measured.visits import Visits
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Poses at which robots are predicted, evenly picked from those of the file.
MOST_POSES: Final = 50
_MOST_NAMED: Final = 5
_LONGEST_NAME: Final = 40


@dataclass(frozen=True)
class CommandedPoses:
    """Poses of a measured file, as `Cube` holds those of the standard.

    names               in the order in which a cycle visits them
    q (pose, joint)     joint values, rad or m
    poses (pose, 4, 4)  the arm's tool there
    rotation            orientation of the tool (3, 3) where it is the same at all poses; None where
                        each has its own
    left                number of commanded poses of the file that are not among them
    """

    names: tuple[str, ...]
    q: Floats
    poses: Floats
    rotation: Floats | None
    left: int


def commanded_poses(arm: Arm, visits: Visits) -> CommandedPoses | None:
    """Return the commanded poses of a file with joint values of the arm; None where the file
    commands none.

    With six joints or more the tool has the commanded orientation, or where none is commanded the
    first of downward, forward and that in the middle of the joint ranges that all poses allow.
    Joint values continue from pose to pose where they can. Raises InputError where a pose is out of
    reach.
    """
    first = {
        name: k
        for k, name in reversed(list(enumerate(visits.pose)))
        if name and np.isfinite(visits.command[k]).all()
    }
    names = [name for name in dict.fromkeys(visits.pose) if name in first]
    if not names:
        return None
    kept = (
        [
            names[k]
            for k in np.unique(np.linspace(0, len(names) - 1, MOST_POSES).round().astype(int))
        ]
        if len(names) > MOST_POSES
        else names
    )
    wanted = np.stack([visits.commanded_pose(first[name]) for name in kept])
    turned = bool(np.isfinite(wanted).all()) and len(arm.tree.tool_joints) >= FULL
    cloud = sample_poses(arm, SAMPLES).q
    places = tool_points(arm, cloud)
    missed: list[int] = []
    for rotation in [None] if turned else candidate_rotations(arm, None):
        if not turned:
            wanted[:, :3, :3] = np.eye(3) if rotation is None else rotation
        q, missed = _reached(
            arm, wanted, cloud, places, with_orientation=turned or rotation is not None
        )
        if not missed:
            return CommandedPoses(
                tuple(kept), q, state_of(arm, q).frames[-1], rotation, len(names) - len(kept)
            )
    k = first[kept[missed[0]]]
    named = ", ".join(
        (
            f"{cut(kept[k], _LONGEST_NAME)} at "
            f"({', '.join(f'{x * 1e3:.0f}' for x in wanted[k, :3, 3])}) mm"
        )
        for k in missed[:_MOST_NAMED]
    )
    more = f" and {len(missed) - _MOST_NAMED} more" if len(missed) > _MOST_NAMED else ""
    expected = f"commands in the arm's base frame, that it reaches{orientation_clause(arm)}"
    alone = (
        f"lostmotion iso9283 --measured {visits.where[k][0]}, to evaluate the measured robot alone"
    )
    raise InputError(
        [
            Problem(
                visits.where[k][0],
                "commanded positions",
                f"{named}{more}, out of reach of {arm.name}",
                expected,
                alone,
            )
        ]
    )


def _reached(
    arm: Arm, wanted: Floats, cloud: Floats, places: Floats, *, with_orientation: bool
) -> tuple[Floats, list[int]]:
    """Return joint values (pose, joint) that continue from pose to pose where they can, and the
    poses that were not reached.
    """
    q = np.empty((len(wanted), cloud.shape[1]))
    missed: list[int] = []
    before: Floats | None = None
    for k, pose in enumerate(wanted):
        starts = cloud[np.argsort(np.linalg.norm(places - pose[:3, 3], axis=1))[:STARTS]]
        if before is not None:
            starts = np.vstack([before, starts])
        found, reached = inverse_kinematics(
            arm, np.tile(pose, (len(starts), 1, 1)), starts, with_orientation=with_orientation
        )
        if not reached.any():
            missed.append(k)
            continue
        q[k] = before = found[int(np.argmax(reached))]
    return q, missed
