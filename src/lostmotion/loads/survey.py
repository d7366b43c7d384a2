"""Holding torques, bearing loads and compliance of an arm at rest, over a set of poses.
Deterministic: nothing is drawn at random.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.mechanism.elastostatics import Ellipsoid, ellipsoid
from lostmotion.mechanism.holding_torques import JointLoad, static_loads
from lostmotion.mechanism.standing import standing
from lostmotion.mechanism.state import state_of, states_of
from lostmotion.spatial import cross

if TYPE_CHECKING:
    from typing import Self

    from numpy.typing import NDArray

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.state import State
    from lostmotion.spatial import Floats

_BLOCK: Final = 4096


@dataclass(frozen=True, repr=False)
class Survey:
    """Loads and compliance of an arm at rest; arrays follow the order of the poses.

    tilt               rad, largest tilt of the base from level; None where none was stated
    joint_loads        largest static load of each moving joint
    tool_positions     (pose, 3) m
    max_compliance     (pose,) m/N, along the most compliant direction, tool free to rotate
    mean_compliance    (pose,) m/N, mean over all directions of the force
    axis_compliance    (pose, axis) m/N, displacement along x, y and z of the base per force along
                       the same axis, tool free to rotate
    axis_worst         (axis,) index of the pose with the largest of each, and axis_parts (axis,
                       part) m/N what each part adds to it there
    asymmetry          (pose,) as `Compliances.asymmetry`
    payload_deflection  (pose,) m, tool deflection due to the payload's weight; None without payload
    parts              names of the compliant parts
    shares             (part,) share of `mean_compliance`, mean over poses
    softest_pose       index of the pose with the largest `max_compliance`; the remaining fields
                       refer to it
    compliance         (6, 6), rotation before displacement, moment before force
    softest_shares     (part,) share of `mean_compliance`
    translational      ellipsoid of the tool point under a force, tool free to rotate
    guided             the same with rotation constrained
    rotational         ellipsoid of the tool's rotation under a moment, rad/(N m)
    """

    arm: Arm
    poses: Poses
    tilt: float | None
    joint_loads: list[JointLoad]
    tool_positions: Floats
    max_compliance: Floats
    mean_compliance: Floats
    axis_compliance: Floats
    axis_worst: NDArray[np.int64]
    axis_parts: Floats
    asymmetry: Floats
    payload_deflection: Floats | None
    parts: tuple[str, ...]
    shares: Floats
    softest_pose: int
    compliance: Floats
    softest_shares: Floats
    translational: Ellipsoid
    guided: Ellipsoid
    rotational: Ellipsoid

    @classmethod
    def of(cls, arm: Arm, poses: Poses, tilt: float | None = None, **beside: Any) -> Self:  # noqa: ANN401 - further fields of a subclass
        """Return the static loads and the compliance of an arm over these poses; `tilt` (rad) as
        for `static_loads`, `beside` the fields that a subclass has besides.
        """
        q = poses.q
        blocks = [
            (state.compliances, _payload_deflection(state))
            for state in (standing(each) for _, each in states_of(arm, q, _BLOCK))
        ]
        by_block = [compliances for compliances, _ in blocks]
        largest = np.concatenate([ellipsoid(each.whole).values[:, 0] for each in by_block])
        by_part = np.concatenate([each.mean_compliance for each in by_block], axis=1)
        mean = by_part.sum(axis=0)
        with np.errstate(invalid="ignore"):
            shares = by_part / mean
        softest = int(largest.argmax())
        along = np.concatenate([np.einsum("pii->pi", each.whole[:, 3:, 3:]) for each in by_block])
        of_each = standing(state_of(arm, q[along.argmax(axis=0)])).compliances
        of_axes = np.einsum("tpii->ipt", of_each.by_part[:, :, 3:, 3:])
        matrix = standing(state_of(arm, q[[softest]])).compliances.whole
        swapped = np.roll(matrix, 3, axis=(1, 2))  # rotation and displacement exchanged
        return cls(
            arm,
            poses,
            tilt,
            static_loads(arm, q, tilt),
            np.concatenate([each.tool for each in by_block]),
            largest,
            mean,
            along,
            along.argmax(axis=0),
            of_axes[np.arange(3), np.arange(3)],
            np.concatenate([each.asymmetry for each in by_block]),
            np.concatenate([deflection for _, deflection in blocks]) if arm.payload.mass else None,
            by_block[0].parts,
            shares.mean(axis=1),
            softest,
            matrix[0],
            shares[:, softest],
            ellipsoid(matrix),
            ellipsoid(matrix, rotation_fixed=True),
            ellipsoid(swapped),
            **beside,
        )


def _payload_deflection(state: State) -> Floats:
    """Return the tool displacement (pose,), m, when the payload's weight is removed."""
    payload = state.arm.payload
    weight = np.broadcast_to(payload.mass * state.gravity, (len(state), 3))
    lever = state.frames[-1, :, :3, :3] @ np.array(payload.centre_of_mass)
    moved = state.deflection(-np.hstack([cross(lever, weight), weight]))
    return np.asarray(np.linalg.norm(moved[:, 3:], axis=1))
