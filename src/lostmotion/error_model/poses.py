"""Samples of poses within the joint limits, or with the tool in its box, by a distribution of the
user's choice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from lostmotion.error_model.draws import sobol, uniforms
from lostmotion.errors import refuse_argument
from lostmotion.laws.distributions import Normal
from lostmotion.mechanism.assembly import affordable, drives_at, hardly_assembled, pose_ranges
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

PoseLaw = Literal["sobol", "uniform", "normal", "grid", "given"]
POSE_LAWS: Final[tuple[str, ...]] = get_args(PoseLaw)[:-1]
# Number of independent sets of poses; the differences between them show the uncertainty due to the
# choice of poses.
REPLICATES: Final = 8
MOST_POSES: Final = 10_000_000
# Poses that show in a picture what the tool reaches.
_PICTURED: Final = 131_072
# Poses of a closed chain are sought among so many times their number, while at least half as many
# are found as that takes; so few are tried whatever is found.
_MOST_TRIED: Final = 64
_FEW: Final = 1024
# NumPy's largest number of dimensions. With more joints a grid has one step in each, or far too
# many poses.
_MOST_AXES: Final = 32


@dataclass(frozen=True, slots=True)
class Poses:
    """Poses of an arm.

    q           (pose, joint) joint values, rad or m
    law         how they were chosen; "given" for poses of the user
    replicates  number of independent sets of equal size, one after the other in q
    """

    q: Floats
    law: PoseLaw
    replicates: int = 1

    def __post_init__(self) -> None:
        """Refuse joint values that are not a table of finite numbers, and a number of sets that
        does not divide the number of poses.
        """
        if self.q.ndim != 2 or not len(self.q) or not np.isfinite(self.q).all():  # noqa: PLR2004 - pose and joint
            raise refuse_argument(
                "poses",
                f"joint values of shape {self.q.shape}",
                "at least one pose (pose, joint) of finite values in rad and m",
                poses=2048,
            )
        if self.replicates < 1 or len(self.q) % self.replicates:
            raise refuse_argument(
                "replicates",
                self.replicates,
                f"a number that divides the {len(self.q)} poses",
                replicates=1,
            )

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.q)


def sample_poses(arm: Arm, count: int, law: PoseLaw = "sobol", seed: int = 1) -> Poses:
    """Return at least `count` poses within the joint limits of this arm, or with the tool in the
    box that the file of a closed chain states.

    sobol    eight independently scrambled Sobol sequences, which cover the ranges evenly
    uniform  every value within the limits equally likely
    normal   normal about mid-range with a standard deviation of range/6, truncated at the limits,
             as in the paper
    grid     equal steps in every range, ends included

    The count is rounded up: to eight times a power of two (sobol), to a multiple of eight (uniform,
    normal), to a full grid. Of a closed chain only poses at which it is assembled are returned: so
    many of a longer row, or those of the grid.
    Raises InputError for an unknown law, a count below one or above ten million, or a closed chain
    that is assembled at hardly any pose.
    """
    sampled, tried = _within_ranges(arm, count, law, seed), count
    q, inside = drives_at(arm, sampled.q)
    if inside.all():
        return Poses(q, law, sampled.replicates)
    kept = inside
    while tried < count * _MOST_TRIED and law != "grid" and _promising(kept):
        tried *= 2
        longer, kept = drives_at(arm, _within_ranges(arm, tried, law, seed).q)
        sets = kept.reshape(REPLICATES, -1)
        each = len(sampled) // REPLICATES
        if sets.sum(axis=1).min() >= each:
            rows = [np.flatnonzero(row)[:each] + k * len(row) for k, row in enumerate(sets)]
            return Poses(longer[np.concatenate(rows)], law, REPLICATES)
    if law == "grid" and inside.any():
        return Poses(q[inside], law)
    raise hardly_assembled(arm, kept)


def _promising(assembled: NDArray[np.bool_]) -> bool:
    """Return whether enough poses will be found among more, by those tried (pose,)."""
    found, tried = np.count_nonzero(assembled), len(assembled)
    return bool(tried < _FEW or 2 * _MOST_TRIED * found >= tried)


def _within_ranges(arm: Arm, count: int, law: PoseLaw, seed: int) -> Poses:
    """Return the values of a law in the ranges of `pose_ranges`, rounded up as in
    `sample_poses`.
    """
    if law not in POSE_LAWS:
        raise refuse_argument("pose_law", law, "one of " + ", ".join(POSE_LAWS), pose_law="sobol")
    if not 1 <= count <= MOST_POSES:
        raise refuse_argument("poses", count, f"from 1 to {MOST_POSES}", poses=2048)
    low, high = pose_ranges(arm).T
    joints = len(low)
    if law == "grid":
        steps = max(math.ceil(count ** (1 / joints) - 1e-9), 1)
        if steps**joints > MOST_POSES:
            found = f"{steps} steps in each of {joints} joints, {steps**joints:.3g} poses"
            raise refuse_argument(
                "poses, pose_law", found, f"at most {MOST_POSES}", pose_law="sobol"
            )
        axes = [
            np.linspace(a, b, steps) if steps > 1 else np.array([(a + b) / 2])
            for a, b in zip(low, high, strict=True)
        ]
        at = (
            np.unravel_index(np.arange(steps**joints), (steps,) * joints)
            if joints <= _MOST_AXES
            else np.zeros((joints, 1), int)
        )
        return Poses(
            np.column_stack([axis[index] for axis, index in zip(axes, at, strict=True)]), "grid"
        )
    each = math.ceil(count / REPLICATES)
    if law == "sobol":
        u = _sobol(joints, each, seed)
    else:
        u = np.array([uniforms(seed, f"poses.{law}.{k}", each * REPLICATES) for k in range(joints)])
    return Poses(in_ranges(u, low, high, law), law, REPLICATES)


def in_ranges(u: Floats, low: Floats, high: Floats, law: PoseLaw) -> Floats:
    """Return values (pose, joint) from `low` to `high` (joint,) by these uniforms (joint, pose):
    normal about the middle for the law "normal", evenly for any other.
    """
    low, high = low[:, None], high[:, None]
    if law == "normal":
        shape = Normal(cut=3.0)
        q = (low + high) / 2 + (high - low) / 6 * shape.quantile(u) * (3.0 / shape.bound)
    else:
        q = low + u * (high - low)
    return np.ascontiguousarray(q.T)


def reachable_points(arm: Arm, seed: int = 1) -> Floats:
    """Return what the tool reaches within the joint limits, for a picture: the tool points (point,
    3), m, of many poses.
    """
    return tool_points(arm, sample_poses(arm, affordable(arm, _PICTURED), "sobol", seed).q)


def _sobol(joints: int, each: int, seed: int) -> Floats:
    """Return as many points (joint, point) of independent sequences, 0 to 1."""
    power = max(each - 1, 0).bit_length()
    return np.concatenate(
        [
            sobol(seed, f"poses.sobol.{replicate}", joints).columns(power)
            for replicate in range(REPLICATES)
        ],
        axis=1,
    )
