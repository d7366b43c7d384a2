"""Any stretch of a long row of poses without the poses before it: the same as
`studies.poses.sample_poses` gives whole.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.draws import key, sobol
from lostmotion.error_model.poses import REPLICATES, in_ranges
from lostmotion.errors import LostmotionError, refuse_argument
from lostmotion.mechanism.assembly import drives_at, pose_ranges
from lostmotion.runs.job import MOST_POSES

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.runs.job import Law
    from lostmotion.spatial import Floats

_WORDS: Final = 4  # that Philox makes of one count
_sequence = functools.lru_cache(maxsize=32)(sobol)


def rounded(arm: Arm, poses: int, law: Law) -> tuple[int, int]:
    """Return how many poses a law makes of so many, and in how many independent sets. As
    `sample_poses`, up to eight times 2^30.
    """
    if not 1 <= poses <= MOST_POSES:
        raise refuse_argument("poses", poses, f"from 1 to {MOST_POSES}", poses=100000)
    if law == "grid":
        joints = len(pose_ranges(arm))
        steps = max(math.ceil(poses ** (1 / joints) - 1e-9), 1)
        if steps**joints > MOST_POSES:
            found = f"{steps} steps in each of {joints} joints, {steps**joints:.3g} poses"
            raise refuse_argument(
                "poses, pose_law", found, f"at most {MOST_POSES}", pose_law="sobol"
            )
        return steps**joints, 1
    each = math.ceil(poses / REPLICATES)
    return REPLICATES * (1 << (each - 1).bit_length() if law == "sobol" else each), REPLICATES


def steps_of(poses: int, joints: int) -> int:
    """Return the number of steps in each of so many joints of a grid of so many poses. Raises
    LostmotionError for a count that no such grid has.
    """
    steps: int = round(poses ** (1 / joints))
    if steps**joints != poses:
        raise LostmotionError(
            f"the order speaks of a grid of {poses} poses, and an arm with {joints} moving "
            "joints has none of that many: "
            f"{steps} steps in each joint are {steps**joints}\n  the run's order was changed "
            "or is damaged; run `lostmotion sweep` in another folder"
        )
    return steps


def poses_between(arm: Arm, law: Law, poses: int, seed: int, first: int, last: int) -> Floats:
    """Return the poses (pose, joint) from number `first` up to `last` in a row of `poses`, rounded
    already, rad or m; within one set. NaN where the box of the tool has no such pose.
    """
    values = _values_between(arm, law, poses, seed, first, last)
    if arm.workspace is None:
        return values
    q, inside = drives_at(arm, values)
    return np.where(inside[:, None], q, np.nan)


def _values_between(arm: Arm, law: Law, poses: int, seed: int, first: int, last: int) -> Floats:
    low, high = pose_ranges(arm).T
    joints = len(low)
    if law == "given":
        raise ValueError("poses that are given follow from no law")
    if law == "grid":
        steps = steps_of(poses, joints)
        axes = [
            np.linspace(a, b, steps) if steps > 1 else np.array([(a + b) / 2])
            for a, b in zip(low, high, strict=True)
        ]
        at = (
            np.unravel_index(np.arange(first, last), (steps,) * joints)
            if steps > 1
            else np.zeros((joints, last - first), int)
        )
        return np.column_stack([axis[index] for axis, index in zip(axes, at, strict=True)])
    each = poses // REPLICATES
    if law == "sobol":
        u = _sobol(joints, seed, first // each, first % each, first % each + last - first)
    else:
        u = np.array([_uniforms(seed, f"poses.{law}.{k}", first, last) for k in range(joints)])
    return in_ranges(u, low, high, law)


def _sobol(joints: int, seed: int, of_set: int, first: int, last: int) -> Floats:
    return _sequence(seed, f"poses.sobol.{of_set}", joints).stretch(first, last).T


def _uniforms(seed: int, name: str, first: int, last: int) -> Floats:
    generator = np.random.Philox(key=key(seed, name)).advance(first // _WORDS)
    raw = generator.random_raw(last - first // _WORDS * _WORDS)[first % _WORDS :]
    return np.asarray(((raw >> np.uint64(11)).astype(np.float64) + 0.5) * 2.0**-53)
