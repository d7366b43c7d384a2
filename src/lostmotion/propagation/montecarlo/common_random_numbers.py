"""Studies with common random numbers: the same robots and visits with some errors scaled, so that
only those errors make a difference.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from lostmotion.error_model import error_bins
from lostmotion.error_model.pose_matrix import PoseMatrix, pose_matrix
from lostmotion.error_model.pose_sets import blocks_of_sets
from lostmotion.error_model.poses import Poses
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.blocks import BlockPlan, sample_blocks

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_VISITS = 4


@dataclass(frozen=True)
class Sample:
    """The result of one run.

    means    (set, robot) mean error of each robot over each independent set of poses, m
    groups   (group, bin) counts of samples by group of robots
    sets     (set, bin) counts of samples by set of poses
    largest  largest error, m
    """

    means: Floats
    groups: np.ndarray
    sets: np.ndarray
    largest: float


@dataclass(frozen=True)
class Paired:
    """A smaller study that can be run repeatedly with its errors scaled.

    matrix  pose matrix of all its poses
    spans   first and last (exclusive) pose of each independent set
    """

    plan: BlockPlan
    matrix: PoseMatrix
    spans: list[tuple[int, int]]

    @classmethod
    def of(
        cls, arm: Arm, poses: Poses, robots: int, visits: int, seed: int, approach: float
    ) -> Self:
        """Prepare a study of these robots and at most four visits. Arguments and errors as for
        `montecarlo.run`.
        """
        plan = BlockPlan.of(arm, poses, robots, min(visits, _VISITS), seed, approach)
        blocks = blocks_of_sets(len(poses), poses.replicates, len(poses))
        return cls(
            plan,
            pose_matrix(arm, poses.q, approach=approach),
            [(block.start, block.stop) for block in blocks],
        )

    @property
    def samples(self) -> int:
        """Return the number of samples of a run."""
        return len(self.plan.poses) * self.plan.robots * self.plan.visits

    def run(self, factors: Floats) -> Sample:
        """Return the errors of these robots with every column of the pose matrix scaled by its
        factor (column,).
        """
        groups, sets = (
            np.zeros((count, error_bins.BINS), np.int64)
            for count in (self.plan.groups, len(self.spans))
        )
        means, largest = [], 0.0
        blocks = sample_blocks(self.plan, self.matrix.scaled(factors), self.spans)
        for of_set, (first, last), block in zip(sets, self.spans, blocks, strict=True):
            means.append(block.robot_sums / (last - first))
            of_set[block.bins] = block.hist
            groups[:, block.bins] = block.group_hist
            largest = max(largest, float(block.per_pose[:, kernel.LARGEST].max()))
        return Sample(np.array(means), groups, sets, largest)


def thinned(poses: Poses, most: int) -> Poses:
    """Return at most `most` of the poses: the first ones of each independent set, or equally spaced
    ones where there is only one set.
    """
    if poses.replicates > 1:
        each = len(poses) // poses.replicates
        count = min(each, max(most // poses.replicates, 1))
        return Poses(
            poses.q.reshape(poses.replicates, each, -1)[:, :count].reshape(
                poses.replicates * count, -1
            ),
            poses.law,
            poses.replicates,
        )
    return Poses(
        poses.q[np.unique(np.linspace(0, len(poses) - 1, min(most, len(poses))).astype(int))],
        poses.law,
    )
