"""Poses that need no random numbers: spread evenly over the joint ranges, for quick looks, and the
corners of the ranges.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.assembly import assembled
from lostmotion.mechanism.holding import spread_evenly

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_POSES: Final = 4096
_MOST_CORNERS: Final = 10


def even_poses(arm: Arm) -> Floats:
    """Return poses (pose, joint), rad or m: 4096 spread evenly, and those with every joint at a
    limit, for the first ten joints; of a closed chain those at which it is assembled.
    """
    low, high = arm.limits.T
    joints = len(low)
    corners = min(joints, _MOST_CORNERS)
    ends = np.full((2**corners, joints), 0.5)
    ends[:, :corners] = np.arange(2**corners)[:, None] >> np.arange(corners) & 1
    q = np.vstack([low + ends * (high - low), spread_evenly(arm.limits, _POSES)])
    return np.asarray(q[assembled(arm, q)])


def few_even_poses(arm: Arm) -> Floats:
    """Return 256 poses (pose, joint), rad or m, spread evenly between the joint limits; of a closed
    chain those at which it is assembled.
    """
    q = spread_evenly(arm.limits)
    return np.asarray(q[assembled(arm, q)])


def corners(arm: Arm, most: int = 4096) -> Floats:
    """Return the corners of the joint ranges (pose, joint), rad or m; beyond `most` of them, the
    last joints are at mid-range. Of a closed chain those at which it is assembled.
    """
    ends = arm.limits
    moving = min(len(ends), int(math.log2(most)))
    out = np.tile(ends.mean(axis=1), (2**moving, 1))
    for k in range(moving):
        out[:, k] = ends[k][(np.arange(2**moving) >> k) & 1]
    return np.asarray(out[assembled(arm, out)])
