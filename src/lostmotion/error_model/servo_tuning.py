"""What the tuning of position servos would change: more stiffness, gravity feed-forward, integral
action.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.budget import Tally
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.mechanism.standing import falls_at
from lostmotion.parts.joint import has_drive

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
    from lostmotion.spatial import Floats

# Poses at which the tunings are compared at most.
MOST_POSES: Final = 256
TUNINGS: Final = (
    "as described",
    "twice the stiffness",
    "gravity compensation of 100 %",
    "integral action",
)


def tuned_rms(arm: Arm, q: Floats, *, approach: float = 0.0) -> dict[str, float]:
    """Return the r.m.s. error (m) with each of `TUNINGS` of all servos that droop; empty for an arm
    without one.

    q  (pose, joint) rad or m, of which at most 256 in equal steps are visited

    Each tuning is settled again: the error is that of the tuned arm where it stands. Poses at which
    the arm falls with one of them are excluded from all; empty where none remains.
    """
    if not any(joint.servo is not None and joint.servo.droops for joint in arm.driven):
        return {}
    chosen = np.unique(np.linspace(0, len(q) - 1, min(len(q), MOST_POSES)).astype(int))
    arms = {
        tuning: arm.model_copy(
            update={
                "joints": tuple(
                    _tuned(joint, tuning) if has_drive(joint) else joint for joint in arm.joints
                )
            }
        )
        for tuning in TUNINGS
    }
    visited = q[chosen]
    for tuned in arms.values():
        visited = visited[falls_at(tuned, visited) < 0]
    if not len(visited):
        return {}
    tallies = {
        tuning: Tally.of(pose_matrix(tuned, visited, approach=approach))
        for tuning, tuned in arms.items()
    }
    return {tuning: math.sqrt(each.total / each.poses) for tuning, each in tallies.items()}


def _tuned(joint: RevoluteJoint | PrismaticJoint, tuning: str) -> RevoluteJoint | PrismaticJoint:
    """Return a joint with its servo tuned."""
    servo = joint.servo
    if servo is None or servo.stiffness is None or not servo.droops:
        return joint
    change: dict[str, dict[str, float | bool]] = {
        TUNINGS[1]: {"stiffness": 2 * servo.stiffness},
        TUNINGS[2]: {"gravity_compensation": 1.0},
        TUNINGS[3]: {"integral": True},
    }
    tuned = servo.model_copy(update=change.get(tuning, {}))
    return joint.model_copy(update={"servo": tuned})
