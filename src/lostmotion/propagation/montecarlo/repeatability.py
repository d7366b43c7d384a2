"""Repeatability RP of joints that arrive in the standard's cycle, and of joints that arrive from
either side.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.budget import Budget, budget
from lostmotion.propagation.montecarlo.common_random_numbers import thinned
from lostmotion.propagation.montecarlo.montecarlo import run

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.montecarlo.montecarlo import Sampled
    from lostmotion.spatial import Floats

_POSES: Final = 512
_ROBOTS: Final = 512


@dataclass(frozen=True)
class Repeatability:
    """RP of joints that arrive one way, m.

    approach    sign of their last motion, 0 where it is drawn at every visit
    poses       the poses
    robots      number of robots
    visits      number of visits of each robot to each pose
    robot_means (replicate, robot) RP of each robot, averaged over each independent set of poses
    per_pose    (pose, 4) RP over robots: mean, 95th percentile, and the interval of the latter
    budget      error budget of joints that arrive this way
    """

    approach: float
    poses: Poses
    robots: int
    visits: int
    robot_means: Floats
    per_pose: Floats
    budget: Budget

    @property
    def none(self) -> bool:
        """Return whether no described error differs between visits."""
        return not self.per_pose.any()

    @property
    def causes(self) -> tuple[tuple[str, float], ...]:
        """Return each kind of error with its share of the mean square between visits, the largest
        first; exact, and empty without scatter.
        """
        whole = self.budget.levels[2]
        if self.none or not whole > 0:
            return ()
        shares = sorted(
            ((cost.part, cost.levels[2] / whole) for cost in self.budget.causes),
            key=lambda each: -each[1],
        )
        return tuple((name, share) for name, share in shares if share)


def both_repeatabilities(  # noqa: PLR0913 - a study is these numbers
    arm: Arm,
    poses: Poses,
    sampled: Sampled,
    blame: Budget,
    seed: int,
    *,
    approach: float,
    many: Poses | None = None,
    threads: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> tuple[Repeatability, ...]:
    """Return the RP of the standard's cycle, then that of any approach; none for a single visit.

    The one that `sampled` has is its own. The other has the same draws, on at most 512 of the poses
    and 512 robots, with the side of every joint's last motion fixed or drawn. The fixed sign does
    not matter: every scatter between visits is independent of it.

    sampled  the run of these poses, with error budget `blame`
    many     poses by which to check whether these are too few (`few_poses.many_poses`)

    Other arguments and errors as for `montecarlo.run`.
    """
    if sampled.visits < 2:  # noqa: PLR2004 - a scatter needs two
        return ()
    own = _repeatability(approach, poses, sampled, blame)
    other, chosen = 0.0 if approach else 1.0, thinned(poses, _POSES)
    run_of_other = run(
        arm,
        chosen,
        min(sampled.robots, _ROBOTS),
        sampled.visits,
        seed,
        approach=other,
        threads=threads,
        compared=0,
    )
    budget_of_other = budget(
        arm,
        chosen.q,
        f"over {len(chosen)} poses",
        approach=other,
        replicates=chosen.replicates,
        many=many,
    )
    if progress is not None:
        progress("arriving from one side" if other else "arriving from either side", 1, 1)
    found = (own, _repeatability(other, chosen, run_of_other, budget_of_other))
    return tuple(sorted(found, key=lambda each: each.approach == 0))


def _repeatability(approach: float, poses: Poses, sampled: Sampled, blame: Budget) -> Repeatability:
    """Return the RP of a run; exactly zero where no error differs between visits, and not what
    rounding leaves.
    """
    means, per_pose = sampled.robot_means[:, :, 2], sampled.repeatability
    if not blame.levels[2] > 0:
        means, per_pose = np.zeros_like(means), np.zeros_like(per_pose)
    return Repeatability(approach, poses, sampled.robots, sampled.visits, means, per_pose, blame)
