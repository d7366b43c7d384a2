"""Figures of an arm in the view: error, budget and torques at one pose, and the error over the
workspace.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.budget import Tally, costs
from lostmotion.error_model.overload import rated_torques
from lostmotion.error_model.pose_matrix import Columns
from lostmotion.error_model.remedies import STAGES, geometry_of, remaining
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.analytic import Analytic, DrawnColumns, joined, of_screws
from lostmotion.propagation.error_magnitude import LEVELS, TILE
from lostmotion.propagation.pooled import PooledHistogram

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.error_model.budget import Cost
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_Q95: Final = LEVELS.index(0.95)


@dataclass(frozen=True)
class Figures:
    """What the view shows at one pose, in SI.

    q           (joint,) rad and m
    at          (place, 4, 4) frames of the arm, m
    error       figures of the error without sampling and without bounds, at this one pose
    costs       contribution of each part, the largest first
    torques     (joint,) torque or force that each drive holds, N m or N
    loads       (joint,) the same as a share of the rated torque; NaN where none is stated
    """

    q: Floats
    at: Floats
    error: Analytic
    costs: list[Cost]
    torques: Floats
    loads: Floats

    @property
    def q95(self) -> float:
        """Return the 95th percentile of the position error, m."""
        return float(self.error.quantiles[0, _Q95])

    @property
    def is_precise(self) -> bool:
        """Return whether the uncertainty of the figures is at most 5 % of them."""
        return bool(self.error.valid[0])


@dataclass(frozen=True)
class Workspace:
    """The error over the workspace.

    poses   joint values of the poses
    points  (pose, 3) tool points, m
    q95     (pose,) 95th percentile of the position error at each pose, m
    whole   the same over all poses together, m
    """

    poses: Poses
    points: Floats
    q95: Floats
    whole: Estimate


class LiveArm:
    """An arm at one stage of calibration and compensation, for figures at any pose.

    The draws are those of a study without sampling over `poses`. So each figure equals that of
    `propagation.analytic` at poses that begin with these.
    """

    def __init__(self, arm: Arm, poses: Poses, stage: str = STAGES[0]) -> None:
        """Prepare what does not depend on the pose."""
        self.arm, self.poses, self.stage = arm, poses, stage
        self._columns = Columns(arm)
        self._remaining = (
            None if stage == STAGES[0] else remaining(self._columns.infos, stage, geometry_of(arm))
        )
        self._drawn = DrawnColumns(self._screws(poses.q[:TILE]))

    def figures(self, q: Floats) -> Figures:
        """Return the figures at a pose q (joint,), rad and m."""
        pose = np.asarray(q, dtype=float)[None]
        matrix = self._screws(pose)
        torques = matrix.state.torques[0]
        return Figures(
            pose[0],
            matrix.state.frames[:, 0],
            of_screws(matrix, self._drawn, with_bounds=False),
            costs(Tally.of(matrix)),
            torques,
            np.abs(torques) / rated_torques(self.arm),
        )

    def workspace(self) -> Iterator[Workspace | None]:
        """Yield None after each part of the work, then the error over the workspace."""
        found, points, histogram = [], [], PooledHistogram(self.poses)
        for block in histogram.blocks(TILE):
            matrix = self._screws(self.poses.q[block])
            found.append(of_screws(matrix, self._drawn, with_bounds=False))
            points.append(matrix.state.frames[-1, :, :3, 3])
            histogram.add(block, self._drawn.pooled_counts(matrix, histogram.points))
            yield None
        error = joined(found)
        whole = histogram.figures(error).quantiles[_Q95]
        yield Workspace(self.poses, np.concatenate(points), error.quantiles[:, _Q95], whole)

    def _screws(self, q: Floats) -> PoseMatrix:
        """Return the pose matrix of the errors that remain, for q (pose, joint)."""
        matrix = self._columns.matrix(state_of(self.arm, q))
        return matrix if self._remaining is None else matrix.scaled(self._remaining)
