"""Static loads of the joints: holding torques of the drives by cause, and loads of the bearings,
over poses and tilts of the base.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.load_causes import single_cause_arms
from lostmotion.mechanism.state import state_of, states_of
from lostmotion.spatial import mapped

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.state import State
    from lostmotion.spatial import Floats

_CHUNK: Final = 4096
# Torques within this ratio count as equal; the smaller tilt is reported.
_EQUAL: Final = 1 + 1e-9


@dataclass(frozen=True)
class HoldingTorque:
    """The largest holding torque (N m; force in N on a sliding joint) of one joint.

    worst, worst_index            torque of the largest magnitude with the base at its nominal tilt,
                                  signed, and the index of its pose over_tilts, over_tilts_index
                                  largest magnitude over all poses and all tilts of the base, and
                                  the index of its pose
    """

    joint: str
    unit: str
    worst: float
    worst_index: int
    over_tilts: float
    over_tilts_index: int


def holding_torques(arm: Arm, q: Floats) -> tuple[Floats, list[HoldingTorque]]:
    """Return the holding torques at these poses with the base at its nominal tilt (pose, joint), N
    m or N, and the largest of each joint.

    q (pose, joint) rad or m. Raises ValueError for q of another shape or not finite.
    """
    states = (state for _, state in states_of(arm, q, _CHUNK))
    both = [(state.torques, worst_torques_over_tilts(state)) for state in states]
    nominal, tilted = (np.concatenate(each) for each in zip(*both, strict=True))
    out = []
    for k, joint in enumerate(arm.driven):
        at, tilted_at = int(np.abs(nominal[:, k]).argmax()), int(tilted[:, k].argmax())
        out.append(
            HoldingTorque(
                joint.name,
                joint.load_unit,
                float(nominal[at, k]),
                at,
                float(tilted[tilted_at, k]),
                tilted_at,
            )
        )
    return nominal, out


@dataclass(frozen=True)
class DriveLoad:
    """The largest load of a drive.

    value     signed load, N m (N on a sliding joint)
    index     index of its pose
    gravity   (3,) acceleration of free fall under which it occurs, m/s^2, in the base's axes
    by_cause  contribution of each cause of load, in the unit of the value; they add up to it
    """

    value: float
    index: int
    gravity: Floats
    by_cause: dict[str, float]

    @property
    def tilt(self) -> float:
        """Return the tilt of the base, rad: the angle between gravity and the base's own downward
        axis.
        """
        return math.atan2(math.hypot(self.gravity[0], self.gravity[1]), -self.gravity[2])


@dataclass(frozen=True)
class JointLoad:
    """The largest loads of one moving joint over the poses.

    unit                            of the load of its drive, "N m", or "N" on a sliding joint
    nominal, within_tilt, any_tilt  load of its drive with the base at its nominal tilt, tilted by
                                    at most a stated angle (None without one), and at any tilt
    moment, force                   load of its bearing at the nominal tilt, N m and N: the moment
                                    across the axis (the whole moment on a sliding joint) and the
                                    force, each with the index of its pose
    moment_any_tilt                 the same moment at any tilt; an upper bound where a process
                                    force acts too
    """

    joint: str
    unit: str
    nominal: DriveLoad
    within_tilt: DriveLoad | None
    any_tilt: DriveLoad
    moment: float
    moment_index: int
    moment_any_tilt: float
    moment_any_tilt_index: int
    force: float
    force_index: int

    @property
    def required(self) -> DriveLoad:
        """Return the load that the drive must be rated for: within the stated tilt, or over all
        tilts without one.
        """
        return self.any_tilt if self.within_tilt is None else self.within_tilt


def static_loads(arm: Arm, q: Floats, tilt: float | None = None) -> list[JointLoad]:
    """Return the largest loads of every moving joint over these poses, q (pose, joint) in rad or m.

    tilt (rad): largest tilt of the base from level, in any direction; None for no such limit. The
    maximum over tilts is exact (see `worst_torques_over_tilts`), that over poses is the largest of
    the given ones. Raises ValueError for q of another shape or not finite.
    """
    blocks = [
        (
            state.torques,
            worst_torques_over_tilts(state),
            worst_torques_over_tilts(state, within=math.pi if tilt is None else tilt),
            _bearing_loads(state),
        )
        for _, state in states_of(arm, q, _CHUNK)
    ]
    nominal, any_tilt, within, carried = (
        np.concatenate(each) for each in zip(*blocks, strict=True)
    )
    causes = single_cause_arms(arm)
    out = []
    for k, joint in enumerate(arm.driven):
        moment, moment_any_tilt, force = (int(each) for each in carried[:, k].argmax(axis=0))
        out.append(
            JointLoad(
                joint.name,
                joint.load_unit,
                _drive_load(causes, q, k, int(np.abs(nominal[:, k]).argmax()), arm.gravity_in_base),
                None
                if tilt is None
                else _worst_within(arm, causes, q, k, int(within[:, k].argmax()), tilt),
                _worst_within(arm, causes, q, k, int(any_tilt[:, k].argmax()), math.pi),
                float(carried[moment, k, 0]),
                moment,
                float(carried[moment_any_tilt, k, 1]),
                moment_any_tilt,
                float(carried[force, k, 2]),
                force,
            )
        )
    return out


def _drive_load(
    causes: dict[str, Arm], q: Floats, joint: int, index: int, gravity: Floats
) -> DriveLoad:
    by_cause = {
        name: float(state_of(one, q[index], gravity=gravity).torques[0, joint])
        for name, one in causes.items()
    }
    return DriveLoad(sum(by_cause.values()), index, gravity, by_cause)


def _worst_within(
    arm: Arm, causes: dict[str, Arm], q: Floats, joint: int, index: int, tilt: float
) -> DriveLoad:
    """Return the load under the worst direction of gravity within a tilt: that nearest to the
    gradient of the torque, or to its opposite.
    """
    process, *along = (
        state_of(arm, q[index], gravity=gravity).torques[0, joint]
        for gravity in (np.zeros(3), *np.eye(3))
    )
    gradient = np.array(along) - process
    both = [
        _drive_load(causes, q, joint, index, arm.gravity * direction_within(side * gradient, tilt))
        for side in (1, -1)
    ]
    level, tilted = sorted(both, key=lambda load: load.tilt)
    return tilted if abs(tilted.value) > abs(level.value) * _EQUAL else level


def direction_within(wanted: Floats, tilt: float) -> Floats:
    """Return the unit direction (3,) nearest to `wanted` (3,) among those within an angle `tilt`
    (rad) of straight down.
    """
    horizontal = math.hypot(wanted[0], wanted[1])
    from_down = min(math.atan2(horizontal, -wanted[2]), tilt)
    side = wanted[:2] / horizontal if horizontal else np.array([1.0, 0.0])
    return np.array([*(math.sin(from_down) * side), -math.cos(from_down)])


def worst_torques_over_tilts(state: State, within: float = math.pi) -> Floats:
    """Return the largest magnitude of each joint's holding torque over tilts of the base (pose,
    joint), N m or N.

    within (rad): largest tilt of the base from level, in any direction; by default all tilts.

    Over all tilts the torque of a turning joint is the weight outboard times the distance of its
    centre of mass from the axis, and the force of a sliding joint is the whole weight. A process
    force on the tool turns with the arm.
    Exact, without a search: torque = gravity . v + torque of the process force. The direction
    within a cone that is nearest to v is v itself or lies on the edge of the cone. Source:
    generalises eq. (3) of S. Strutynskyi, R. Semenchuk 2021 to any joint.
    """
    arm, by_axis, process = state.arm, state.weights_by_axis, state.process_wrenches
    out = []
    for joint, place in zip(arm.driven, arm.tree.moved, strict=True):
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


def _bearing_loads(state: State) -> Floats:
    """Return (pose, joint, 3): the moment across the axis at the nominal tilt and its bound over
    all tilts (N m), and the force (N).
    """
    arm, nominal = state.arm, state.wrenches
    by_axis, process = state.weights_by_axis, state.process_wrenches
    out = np.empty((len(state), len(arm.driven), 3))
    for k, (joint, place) in enumerate(zip(arm.driven, arm.tree.moved, strict=True)):
        across = np.eye(3) - np.outer(joint.twist[:3], joint.twist[:3])
        gradient = arm.gravity * np.stack(
            [each[:, :3] @ across for each in by_axis[:, place]], axis=1
        )
        out[:, k, 0] = np.linalg.norm(nominal[place, :, :3] @ across, axis=1)
        out[:, k, 1] = np.linalg.norm(gradient, 2, axis=(1, 2)) + np.linalg.norm(
            process[place, :, :3] @ across, axis=1
        )
        out[:, k, 2] = np.linalg.norm(nominal[place, :, 3:], axis=1)
    return out
