"""What several verbs are told alike: poses, seed, and from which side joints arrive."""

from __future__ import annotations

from numbers import Integral
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.studies.poses import PoseLaw, Poses, sample_poses

if TYPE_CHECKING:
    from lostmotion.arm import Arm
    from lostmotion.spatial import Floats

DEFAULT_POSES = 2048
DEFAULT_ROBOTS = 1000
DEFAULT_VISITS = 30
Approach = Literal["random", "up", "down"]
_SIGNS: Final = {"random": 0.0, "up": 1.0, "down": -1.0}


def sign_of(approach: str) -> float:
    """Which sign has every joint's last motion? Zero where it differs from visit to visit. Raises InputError for another word."""
    if approach not in _SIGNS:
        raise refuse_argument("approach", approach, "one of " + ", ".join(_SIGNS), 'approach = "random"')
    return _SIGNS[approach]


def whole_seed(seed: object) -> int:
    """Which seed is this? Raises InputError for anything but a whole number, zero or more."""
    if not isinstance(seed, Integral) or seed < 0:
        raise refuse_argument("seed", seed, "a whole number, zero or more", "seed = 1")
    return int(seed)


def chosen_poses(arm: Arm, poses: int | Floats | Poses, law: PoseLaw, seed: int) -> Poses:
    """Which poses are meant: so many by this law, or those given, as `Poses` or as q (pose, joint) in rad and m? Raises InputError."""
    if isinstance(poses, Integral):
        return sample_poses(arm, int(poses), law, seed)
    if isinstance(poses, Poses):
        return poses
    from lostmotion.arm import as_poses

    return Poses(as_poses(arm, np.asarray(poses)), "given")
