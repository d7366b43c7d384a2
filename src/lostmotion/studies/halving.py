"""What would halving one part's errors buy on the 95 % error? The same robots and visits, with that part halved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.studies.intervals import RESOLUTION, Estimate, difference, pseudo_values, quantile
from lostmotion.studies.montecarlo import Plan, sample_block
from lostmotion.studies.screws import Screws, screws

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.arm import Arm
    from lostmotion.studies.poses import Poses

_POSES: Final = 128
_ROBOTS: Final = 512
_VISITS: Final = 4
LEVEL: Final = 0.95


@dataclass(frozen=True)
class Halving:
    """By how much the 95 % error over the workspace falls (m) when a part's errors are halved, from a smaller paired run of `samples`."""

    gains: dict[str, Estimate]
    before: float
    samples: int


def halving(
    arm: Arm, poses: Poses, robots: int, visits: int, seed: int, *, approach: float = 0.0, progress: Callable[[str, int, int], None] | None = None
) -> Halving:
    """What does the 95 % error gain from halving each part, with every draw kept?

    Runs on at most 128 of the poses, 512 robots and 4 visits; the interval counts groups of robots. Arguments as `montecarlo.run`.
    """
    chosen = np.unique(np.linspace(0, len(poses) - 1, min(_POSES, len(poses))).astype(int))
    matrix = screws(arm, poses.q[chosen], approach=approach)
    plan = Plan.of(arm, poses, min(robots, _ROBOTS), min(visits, _VISITS), seed, approach)
    before, before_groups = _quantiles(plan, matrix)
    gains = {}
    for done, owner in enumerate(matrix.owners):
        if progress is not None:
            progress("halving each part", done, len(matrix.owners))
        factor = np.array([0.5 if info.owner == owner else 1.0 for info in matrix.infos])
        after, after_groups = _quantiles(plan, replace(matrix, tool=matrix.tool * factor))
        gains[owner] = difference(before_groups, after_groups, before - after, RESOLUTION * before)
    return Halving(gains, before, len(chosen) * plan.robots * plan.visits)


def _quantiles(plan: Plan, matrix: Screws) -> tuple[float, np.ndarray]:
    """Give the 95 % error of all samples and what each group of robots adds to it."""
    groups = sample_block(plan, matrix, 0).group_hist
    return quantile(groups.sum(axis=0), LEVEL), pseudo_values(groups, LEVEL)
