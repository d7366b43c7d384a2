"""Drives whose static holding torque exceeds their rated torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.state import states_of

if TYPE_CHECKING:
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_POSES: Final = 2048
_CHUNK: Final = 4096
# Rounding in the last bits of a sum does not overload a drive that is sized to hold exactly its
# rated torque.
_ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Overload:
    """A drive whose static torque exceeds its rated torque.

    held   largest size of the static torque over the poses, of either sign, in `unit`: N m, or N on
           a sliding joint
    rated  rated torque of the gearbox, in the same unit
    poses  number of poses that were checked
    """

    joint: str
    unit: str
    held: float
    rated: float
    poses: int


def exceeds(held: float, rated: float) -> bool:
    """Return whether a static load is above the rated one by more than rounding; false where no
    load is rated (NaN).
    """
    return held > rated * (1 + _ROUNDING)


def overloads(arm: Arm, poses: Poses | None = None) -> tuple[Overload, ...]:
    """Return the drives whose static torque exceeds the rated torque of their gearbox, in the order
    of the joints, at the nominal tilt of the base.

    Poses that the user gave are checked themselves. For sampled poses, or none, 2 048 poses over
    the joint limits are checked, the same ones in every analysis of an arm. Valid for static load:
    acceleration, friction and shocks add to it. Joints without a rated torque are not listed.
    """
    # loaded with Numba, which a check of a file does without
    from lostmotion.error_model.poses import sample_poses

    if np.isnan(rated_torques(arm)).all():
        return ()
    q = poses.q if poses is not None and poses.law == "given" else sample_poses(arm, _POSES).q
    held = np.max(
        [np.abs(state.torques).max(axis=0) for _, state in states_of(arm, q, _CHUNK)], axis=0
    )
    return overloaded(arm, held, len(q))


def rated_torques(arm: Arm) -> Floats:
    """Return the rated torque (joint,) of the gearbox of every moving joint, N m, or N on a sliding
    joint; NaN where there is none.
    """
    return np.array(
        [
            np.nan
            if joint.gearbox is None or joint.gearbox.rated_torque is None
            else joint.gearbox.rated_torque
            for joint in arm.driven
        ]
    )


def overloaded(arm: Arm, held: Floats, poses: int) -> tuple[Overload, ...]:
    """Return the drives whose largest static torque over this many poses, held (joint,), exceeds
    the rated one, in the order of the joints.
    """
    return tuple(
        Overload(joint.name, joint.load_unit, float(most), float(limit), poses)
        for joint, most, limit in zip(arm.driven, held, rated_torques(arm), strict=True)
        if exceeds(most, limit)
    )
