"""Distance between the commanded tool points of two arms at the same joint values: nominal
geometry, without any error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.differences import sets_difference
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# A distance below this share of the distance of the tool from the base is rounding.
_ROUNDING: Final = 1e-12


@dataclass(frozen=True)
class ToolDistance:
    """Distance between the tool points that two arms command at the same joint values.

    tool       (pose, 3) tool points of the first arm in the base's frame, m
    vectors    (pose, 3) from these to the tool points of the other arm, m
    distances  (pose,) their lengths, m
    mean, p95  mean and 95th percentile over the poses, m; the intervals are due to the choice of
               poses
    """

    tool: Floats
    vectors: Floats
    distances: Floats
    mean: Estimate
    p95: Estimate

    @property
    def largest_at(self) -> int:
        """Return the number of the pose with the largest distance."""
        return int(self.distances.argmax())

    @property
    def largest(self) -> float:
        """Return the largest distance over the poses, m."""
        return float(self.distances.max())

    @property
    def is_zero(self) -> bool:
        """Return whether both arms command the same tool point at every pose, but for rounding."""
        return self.largest <= _ROUNDING * float(np.linalg.norm(self.tool, axis=1).max())


def tool_distance(before: Arm, after: Arm, poses: Poses) -> ToolDistance:
    """Return the distance between the commanded tool points of two arms at the same poses. Valid
    for arms with as many driven joints.
    """
    tool = tool_points(before, poses.q)
    vectors = tool_points(after, poses.q) - tool
    distances = np.linalg.norm(vectors, axis=1)
    of_sets = distances.reshape(poses.replicates, -1)
    nothing = np.zeros(poses.replicates)
    mean, p95 = (
        sets_difference(nothing, each)
        for each in (of_sets.mean(axis=1), np.quantile(of_sets, 0.95, axis=1))
    )
    return ToolDistance(tool, vectors, distances, mean, p95)
