"""Check whether few poses represent the workspace: exact mean squares over them are compared with
those over many poses.

The interval of a figure rests on the differences between independent sets of poses. An error in
rare poses alone, such as a play that opens where the load is near the friction, leaves no
difference if no set visits it. No formula can recover it from these sets: the interval is narrow,
and wrong. Mean squares need no sampling, so 2 048 more poses cost little and show such an error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Self

import numpy as np

from lostmotion.error_model.arrival import rp_name
from lostmotion.error_model.robot_intervals import root_mean_square

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Number of poses from which nothing is checked. With 95 % confidence they visit what occurs in
# 3/2048 = 0.15 % of poses.
MANY: Final = 2048
# Differences below this share of the root mean square are rounding.
_ROUNDING: Final = 1e-9
# Weights of the mean squares by design, by robot and by visit in the position error, and in RP.
ERROR: Final = (1.0, 1.0, 1.0)
RP: Final = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Squares:  # noqa: PLW1641 - arrays have no hash
    """Exact mean squares by design, by robot and by visit, m^2.

    visited   (set, 3) over each independent set of poses
    many      (set, 3) over each set of many poses to check them; no sets where nothing is checked
    at_poses  (pose, 3) at each pose, set after set, for the floor of intervals; None where they are
              too many to keep
    """

    visited: Floats
    many: Floats
    at_poses: Floats | None = None

    def __eq__(self, other: object) -> bool:
        """Return whether all numbers are equal, as budgets are compared."""
        return isinstance(other, Squares) and all(
            np.array_equal(one, another)
            for one, another in (
                (self.visited, other.visited),
                (self.many, other.many),
                (np.asarray(self.at_poses), np.asarray(other.at_poses)),
            )
        )

    @classmethod
    def of(cls, visited: Sequence[Floats], many: Sequence[Floats] = ()) -> Self:
        """Return those of sets of poses from the mean squares at their poses (pose, 3)."""
        means = [np.array([each.mean(axis=0) for each in sets]) for sets in (visited, many)]
        return cls(means[0], means[1].reshape(-1, 3), np.concatenate(visited))

    def root_mean_square(self, weights: Sequence[float] | Floats) -> Estimate:
        """Return the root mean square (m) of the levels with these weights over the poses."""
        at_poses = None if self.at_poses is None else self.at_poses @ weights
        return root_mean_square(self.visited @ weights, at_poses)

    def root_mean_squares(self, weights: Sequence[float] | Floats) -> tuple[Estimate, Estimate]:
        """Return the root mean square (m) of the levels with these weights over the poses, and over
        the many. Valid where there are any.
        """
        return self.root_mean_square(weights), root_mean_square(self.many @ weights)

    def known_ends(self, estimate: Estimate, weights: Sequence[float] | Floats) -> Estimate:
        """Return a figure over these poses, its upper or lower end NaN where they lack rare poses
        with larger or smaller errors (`known_ends`); weights of the levels in the figure.
        """
        return (
            known_ends(estimate, *self.root_mean_squares(weights)) if len(self.many) else estimate
        )


def ap_weights(visits: int) -> tuple[float, float, float]:
    """Return the weights of the mean squares by design, by robot and by visit in AP, the length of
    the mean error of this number of visits.
    """
    return 1.0, 1.0, 1 / visits


def weights_of(visits: int, approach: float = 0.0) -> dict[str, tuple[float, float, float]]:
    """Return the weights of every figure that is checked, by its name; AP needs two visits.
    `approach` of the joints names RP.
    """
    return (
        {"position error": ERROR}
        | ({"AP": ap_weights(visits)} if visits > 1 else {})
        | {f"{rp_name(approach)}, between visits": RP}
    )


def many_poses(arm: Arm, poses: Poses) -> Poses | None:
    """Return 2 048 poses of the same law to compare with these; None for as many, and for poses
    whose choice has no interval (given, or on a grid).

    They are the same in every study of an arm. Valid for poses over the whole joint limits, not for
    those in a zone.
    """
    if poses.replicates == 1 or len(poses) >= MANY or poses.law in {"given", "grid"}:
        return None
    # brings Numba, which what only warns does not need
    from lostmotion.error_model.poses import sample_poses
    from lostmotion.error_model.trust import with_figures

    return with_figures(arm, sample_poses(arm, MANY, poses.law), most=1.0)


def known_ends(
    estimate: Estimate, visited: Estimate, many: Estimate, size: float | None = None
) -> Estimate:
    """Return an estimate whose upper (lower) end is NaN if the visited poses lack poses with larger
    (smaller) errors.

    estimate       figure over the visited poses, or its difference between two arms
    visited, many  root mean square of the errors in it over the visited and over many poses, or its
                   difference, m
    size           root mean square to which rounding is relative, m; default: that of `many`

    Poses are lacking where the whole interval of `many` lies beyond that of `visited`. How far they
    move other figures is not known.
    """
    rounding = _ROUNDING * (many.value if size is None else size)
    if many.low > visited.high + rounding:
        return replace(estimate, high=math.nan)
    return replace(estimate, low=math.nan) if many.high < visited.low - rounding else estimate
