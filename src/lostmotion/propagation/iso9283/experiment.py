"""Draws of simulated robots at poses, with the noise of readings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.draws import key
from lostmotion.propagation import exact

if TYPE_CHECKING:
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.spatial import Floats

_AT_ONCE: Final = 500


@dataclass(frozen=True)
class Experiment:
    """How many robots are drawn from a seed, how often each visits a pose, and the standard
    deviation of the readings, m.
    """

    seed: int
    robots: int
    visits: int
    instrument: float

    def errors(self, matrix: PoseMatrix, row: int, number: int) -> Floats:
        """Return the tool's error (robot, visit, 6) at one pose, rad and m, with the study's draws
        for pose `number` and the noise of the readings.
        """
        out = np.empty((self.robots, self.visits, 6))
        for first in range(0, self.robots, _AT_ONCE):
            last = min(first + _AT_ONCE, self.robots)
            robot, visit = (
                axis.ravel()
                for axis in np.meshgrid(
                    np.arange(first, last), np.arange(self.visits), indexing="ij"
                )
            )
            draws = exact.draws_of(matrix, row, self.seed, number, robot, visit)
            out[first:last] = (matrix.tool[row] @ draws).T.reshape(last - first, self.visits, 6)
        if self.instrument:
            readings = np.random.Generator(
                np.random.Philox(key=key(self.seed, f"iso9283.readings.{number}"))
            )
            noise = readings.standard_normal((self.robots, self.visits, 3))
            out[..., 3:] += self.instrument * noise
        return out

    def at_all(self, matrix: PoseMatrix, first: int) -> Floats:
        """Return the errors (pose, robot, visit, 6) at every pose, numbered from `first`."""
        rows = range(len(matrix.tool))
        return np.stack([self.errors(matrix, row, first + row) for row in rows])
