"""What must every drive hold still? At the worst pose as the base stands, and over all tilts of the base."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.arm import joint_torques, worst_torques_over_tilts
from lostmotion.parts.joint import RevoluteJoint

if TYPE_CHECKING:
    from lostmotion.arm import Arm
    from lostmotion.spatial import Floats

_CHUNK: Final = 4096


@dataclass(frozen=True)
class HoldingTorque:
    """The holding torque (N m; force in N on a sliding joint) of one joint.

    worst_index is the pose that asks most of it as the base stands, worst the signed torque there; over_tilts is the largest over all poses and all
    tilts of the base, at over_tilts_index.
    """

    joint: str
    unit: str
    worst: float
    worst_index: int
    over_tilts: float
    over_tilts_index: int


def holding_torques(arm: Arm, q: Floats) -> tuple[Floats, list[HoldingTorque]]:
    """What must each drive hold at these poses? All torques (pose, joint), and the worst of each joint."""
    parts = [q[k : k + _CHUNK] for k in range(0, len(q), _CHUNK)]
    level = np.concatenate([joint_torques(arm, part) for part in parts])
    tilted = np.concatenate([worst_torques_over_tilts(arm, part) for part in parts])
    out = []
    for k, joint in enumerate(arm.moving):
        at, tilted_at = int(np.abs(level[:, k]).argmax()), int(tilted[:, k].argmax())
        unit = "N m" if isinstance(joint, RevoluteJoint) else "N"
        out.append(HoldingTorque(joint.name, unit, float(level[at, k]), at, float(tilted[tilted_at, k]), tilted_at))
    return level, out
