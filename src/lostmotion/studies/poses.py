"""Which poses does the arm visit? Within every joint's limits, by a law of the user's choice."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from lostmotion.laws.chance import Normal
from lostmotion.studies.draws import key, uniforms

if TYPE_CHECKING:
    from lostmotion.arm import Arm
    from lostmotion.spatial import Floats

PoseLaw = Literal["sobol", "uniform", "normal", "grid", "given"]
POSE_LAWS: Final[tuple[str, ...]] = get_args(PoseLaw)[:-1]
# Independent sets of poses: what the choice of poses leaves uncertain shows as the difference between them.
REPLICATES: Final = 8


@dataclass(frozen=True, slots=True)
class Poses:
    """Joint values q (pose, joint) in rad or m, how they were chosen, and in how many independent sets of equal size (in order)."""

    q: Floats
    law: PoseLaw
    replicates: int = 1

    def __len__(self) -> int:
        """Give the number of poses."""
        return len(self.q)


def sample_poses(arm: Arm, count: int, law: PoseLaw = "sobol", seed: int = 1) -> Poses:
    """Which `count` poses fill the joint ranges of this arm?

    sobol    eight independently scrambled Sobol sequences: even coverage, and an honest interval
    uniform  every value within the limits alike
    normal   the paper's: around mid-range with sigma = range/6, cut at the limits
    grid     equal steps in every joint, ends included; at least `count` poses
    The count is rounded up: to eight powers of two (sobol), to a multiple of eight (uniform, normal), to a full grid.
    Raises ValueError for a count below one.
    """
    if count < 1:
        raise ValueError(f"{count} poses; expected at least 1")
    low, high = arm.limits.T
    joints = len(low)
    if law == "grid":
        steps = max(math.ceil(count ** (1 / joints) - 1e-9), 1)
        axes = [np.linspace(a, b, steps) if steps > 1 else np.array([(a + b) / 2]) for a, b in zip(low, high, strict=True)]
        return Poses(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, joints), "grid")
    each = math.ceil(count / REPLICATES)
    if law == "sobol":
        u = _sobol(joints, each, seed)
    else:
        u = np.column_stack([uniforms(seed, f"poses.{law}.{k}", each * REPLICATES) for k in range(joints)])
    if law == "normal":
        middle, sigma = (low + high) / 2, (high - low) / 6
        shape = Normal(cut=3.0)
        return Poses(middle + sigma * shape.quantile(u) * (3.0 / shape.bound), "normal", REPLICATES)
    return Poses(low + u * (high - low), law, REPLICATES)


def _sobol(joints: int, each: int, seed: int) -> Floats:
    from scipy.stats import qmc

    sets = []
    for replicate in range(REPLICATES):
        rng = np.random.Generator(np.random.Philox(seed=key(seed, f"poses.sobol.{replicate}")))
        sets.append(qmc.Sobol(joints, scramble=True, rng=rng).random_base2(max(each - 1, 0).bit_length()))
    return np.concatenate(sets)
