"""What must every joint carry still, and whose weight is it? As the base stands, within a tilt of the base, and whichever way it is tilted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.load_causes import alone
from lostmotion.mechanism.serial import joint_torques, worst_torques_over_tilts, wrenches
from lostmotion.parts.joint import RevoluteJoint

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_CHUNK: Final = 4096
# Of two tilts that ask the same, whatever rounding says, the smaller one is told.
_EQUAL: Final = 1 + 1e-9


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


@dataclass(frozen=True)
class Asked:
    """The most that is asked of a drive: value (N m, or N of a sliding joint; signed), at which pose, under which gravity (3,) in the base's axes.

    by_cause  of each cause its part; they add up to the value
    """

    value: float
    index: int
    gravity: Floats
    by_cause: dict[str, float]

    @property
    def tilt(self) -> float:
        """Give by how much the base leans then, rad: the angle of gravity against the base's own downward axis."""
        return math.atan2(math.hypot(self.gravity[0], self.gravity[1]), -self.gravity[2])


@dataclass(frozen=True)
class Node:
    """What one moving joint carries at worst over the poses.

    standing, tilted, anyhow  of its drive: as the base stands, with the base tilted from level by no more than the angle asked for (None where none
                              was), tilted any way
    moment, force             on its bearing as the base stands, N m and N: the moment across the axis (all of it on a sliding joint), and the poses
    moment_anyhow             tilted any way; where a process force acts too, no more than this
    """

    joint: str
    unit: str
    standing: Asked
    tilted: Asked | None
    anyhow: Asked
    moment: float
    moment_index: int
    moment_anyhow: float
    moment_anyhow_index: int
    force: float
    force_index: int

    @property
    def needed(self) -> Asked:
        """Give what the drive must be rated for: the worst within the tilt asked for, or over all tilts where none was."""
        return self.anyhow if self.tilted is None else self.tilted


def static_moments(arm: Arm, q: Floats, tilt: float | None = None) -> list[Node]:
    """What does every joint carry at these poses, q (pose, joint) in rad or m, at worst, and by whose weight?

    tilt (rad): by how much the base may lean from level, towards any side. Exact over tilts (see `worst_torques_over_tilts`); over poses the worst
    of those given. Raises ValueError for q of another shape or not finite.
    """
    blocks = [q[k : k + _CHUNK] for k in range(0, len(q), _CHUNK)]
    level = np.concatenate([joint_torques(arm, block) for block in blocks])
    anyhow = np.concatenate([worst_torques_over_tilts(arm, block) for block in blocks])
    leaning = None if tilt is None else np.concatenate([worst_torques_over_tilts(arm, block, within=tilt) for block in blocks])
    carried = np.concatenate([_on_bearings(arm, block) for block in blocks])
    causes = alone(arm)
    out = []
    for k, joint in enumerate(arm.moving):
        moment, moment_anyhow, force = (int(each) for each in carried[:, k].argmax(axis=0))
        out.append(
            Node(
                joint.name,
                "N m" if isinstance(joint, RevoluteJoint) else "N",
                _asked(causes, q, k, int(np.abs(level[:, k]).argmax()), arm.gravity_in_base),
                None if leaning is None or tilt is None else _worst_within(arm, causes, q, k, int(leaning[:, k].argmax()), tilt),
                _worst_within(arm, causes, q, k, int(anyhow[:, k].argmax()), math.pi),
                float(carried[moment, k, 0]),
                moment,
                float(carried[moment_anyhow, k, 1]),
                moment_anyhow,
                float(carried[force, k, 2]),
                force,
            )
        )
    return out


def _asked(causes: dict[str, Arm], q: Floats, joint: int, index: int, gravity: Floats) -> Asked:
    by_cause = {name: float(joint_torques(one, q[index], gravity=gravity)[0, joint]) for name, one in causes.items()}
    return Asked(sum(by_cause.values()), index, gravity, by_cause)


def _worst_within(arm: Arm, causes: dict[str, Arm], q: Floats, joint: int, index: int, tilt: float) -> Asked:
    """Give what is asked under the worst direction of gravity within a tilt: nearest to the torque's own gradient, or to its opposite."""
    process = joint_torques(arm, q[index], gravity=np.zeros(3))[0, joint]
    gradient = np.array([joint_torques(arm, q[index], gravity=axis)[0, joint] - process for axis in np.eye(3)])
    both = [_asked(causes, q, joint, index, arm.gravity * _nearest(side * gradient, tilt)) for side in (1, -1)]
    less, more = sorted(both, key=lambda asked: asked.tilt)
    return more if abs(more.value) > abs(less.value) * _EQUAL else less


def _nearest(wanted: Floats, tilt: float) -> Floats:
    """Give the unit direction (3,) that is nearest to a wanted one among those no further than `tilt` from straight down."""
    level = math.hypot(wanted[0], wanted[1])
    away = min(math.atan2(level, -wanted[2]), tilt)
    side = wanted[:2] / level if level else np.array([1.0, 0.0])
    return np.array([*(math.sin(away) * side), -math.cos(away)])


def _on_bearings(arm: Arm, q: Floats) -> Floats:
    """Give (pose, joint, 3): moment across the axis as the base stands and at most over all tilts (N m), and the force (N)."""
    standing, process = wrenches(arm, q), wrenches(arm, q, gravity=np.zeros(3))
    by_axis = [wrenches(arm, q, gravity=axis * arm.gravity) - process for axis in np.eye(3)]
    out = np.empty((len(q), len(arm.moving), 3))
    for k, (joint, place) in enumerate(zip(arm.moving, arm.tree.moved, strict=True)):
        across = np.eye(3) - np.outer(joint.twist[:3], joint.twist[:3])
        gradient = np.stack([each[place, :, :3] @ across for each in by_axis], axis=1)
        out[:, k, 0] = np.linalg.norm(standing[place, :, :3] @ across, axis=1)
        out[:, k, 1] = np.linalg.norm(gradient, 2, axis=(1, 2)) + np.linalg.norm(process[place, :, :3] @ across, axis=1)
        out[:, k, 2] = np.linalg.norm(standing[place, :, 3:], axis=1)
    return out
