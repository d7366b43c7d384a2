"""Poses that need no random numbers: spread evenly over the joint ranges, or over the box of the
tool that a file states, for quick looks, and the corners of these ranges.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.assembly import drives_at, hardly_assembled, pose_ranges
from lostmotion.mechanism.holding import spread_evenly

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_POSES: Final = 4096
_MOST_CORNERS: Final = 10


def even_poses(arm: Arm) -> Floats:
    """Return poses (pose, joint), rad or m: 4096 spread evenly, and those with every joint at a
    limit, for the first ten joints; of a closed chain those at which it is assembled.

    Raises InputError where it is at none.
    """
    ranges = pose_ranges(arm)
    low, high = ranges.T
    joints = len(low)
    corners = min(joints, _MOST_CORNERS)
    ends = np.full((2**corners, joints), 0.5)
    ends[:, :corners] = np.arange(2**corners)[:, None] >> np.arange(corners) & 1
    return _some(arm, np.vstack([low + ends * (high - low), spread_evenly(ranges, _POSES)]))


def few_even_poses(arm: Arm) -> Floats:
    """Return 256 poses (pose, joint), rad or m, spread evenly between the joint limits; of a closed
    chain those at which it is assembled. Raises InputError where it is at none.
    """
    return _some(arm, spread_evenly(pose_ranges(arm)))


def corners(arm: Arm, most: int = 4096) -> Floats:
    """Return the corners of the joint ranges (pose, joint), rad or m; beyond `most` of them, the
    last joints are at mid-range. Of a closed chain those at which it is assembled.
    """
    ends = pose_ranges(arm)
    moving = min(len(ends), int(math.log2(most)))
    out = np.tile(ends.mean(axis=1), (2**moving, 1))
    for k in range(moving):
        out[:, k] = ends[k][(np.arange(2**moving) >> k) & 1]
    return _kept(arm, out)


def _some(arm: Arm, values: Floats) -> Floats:
    """Return the same as `_kept`. Raises InputError where the arm is assembled at none of them."""
    kept = _kept(arm, values)
    if not len(kept):
        raise hardly_assembled(arm, np.zeros(len(values), dtype=bool))
    return kept


def _kept(arm: Arm, values: Floats) -> Floats:
    """Return the joint values (pose, joint) of those values in the ranges (pose, value) at which
    the arm is assembled.
    """
    q, inside = drives_at(arm, values)
    return np.asarray(q[inside])
