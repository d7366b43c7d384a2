"""Errors of an arm over its poses, from which figures are estimated: of drawn robots, or by sums
over terms.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Self

import numpy as np

from lostmotion.error_model.few_poses import Squares
from lostmotion.error_model.intervals import Estimate, pooled_quantile, standard_deviation
from lostmotion.error_model.robot_intervals import pooled_mean
from lostmotion.propagation.montecarlo import kernel

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.propagation.montecarlo.montecarlo import Sampled
    from lostmotion.propagation.pooled import Pooled
    from lostmotion.spatial import Floats

NOT_CHECKED: Final = Squares(np.zeros((0, 3)), np.zeros((0, 3)))


@dataclass(frozen=True)
class VisitFigures:
    """AP or RP of every robot, over poses that need not be those of the position error.

    robot_means  (set, robot) m, averaged over each independent set of poses
    of_poses     (pose,) m, averaged over robots; None where they are too many to keep
    squares      mean squares over its poses
    """

    robot_means: Floats
    of_poses: Floats | None
    squares: Squares


@dataclass(frozen=True, kw_only=True)
class Errors(ABC):
    """What figures of the error are estimated from, by samples or by sums over terms.

    squares   exact mean squares over the poses
    levels    of the percentiles
    rotation  (set, pose) mean square of the tool's rotation at the poses of each set, rad^2; None
              where it is not computed
    visits    of each robot to each pose
    accuracy  AP of every robot; None without samples, and for a single visit
    repeats   RP by the sign of the joints' last motion, 0 where it is drawn; empty likewise
    """

    squares: Squares
    levels: Sequence[float] = kernel.QUANTILES
    rotation: Floats | None = None
    visits: int = 1
    accuracy: VisitFigures | None = None
    repeats: Mapping[float, VisitFigures]

    @abstractmethod
    def mean(self) -> Estimate:
        """Return the mean over all positions of all robots, m."""

    @abstractmethod
    def deviation(self) -> Estimate:
        """Return the standard deviation about that mean, m."""

    @abstractmethod
    def quantile(self, level: float) -> Estimate:
        """Return the quantile at this level, m; NaN where it is not known."""


@dataclass(frozen=True, kw_only=True)
class Drawn(Errors):
    """Errors of drawn robots.

    robot_means  (set, robot) m, averaged over each independent set of poses
    of_poses     (pose,) m, averaged over robots; None where they are too many to keep
    groups, sets counts of all samples by length (group of robots, bin), (set, bin)
    largest      of all samples, m
    mean_square  of all samples, m^2
    """

    robot_means: Floats
    of_poses: Floats | None
    groups: np.ndarray
    sets: np.ndarray
    largest: float
    mean_square: float

    @classmethod
    def of(
        cls,
        sampled: Sampled,
        squares: Squares = NOT_CHECKED,
        approach: float = 0.0,
        repeats: Mapping[float, VisitFigures] | None = None,
    ) -> Self:
        """Return those of a run whose joints arrive with this sign; `repeats` where RP is known for
        other approaches, too.
        """
        ap, rp = (
            VisitFigures(sampled.robot_means[:, :, k], sampled.of_poses(k), squares) for k in (1, 2)
        )
        several = sampled.visits > 1
        return cls(
            squares=squares,
            rotation=sampled.rotation_ms.reshape(len(sampled.replicate_hist), -1),
            visits=sampled.visits,
            accuracy=ap if several else None,
            repeats=repeats if repeats is not None else {approach: rp} if several else {},
            robot_means=sampled.robot_means[:, :, 0],
            of_poses=sampled.of_poses(0),
            groups=sampled.group_hist,
            sets=sampled.replicate_hist,
            largest=float(sampled.per_pose[:, kernel.LARGEST].max()),
            mean_square=float(sampled.per_pose[:, kernel.MEAN_SQUARE].mean()),
        )

    @property
    def histograms(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the counts by group of robots and by set of poses."""
        return self.groups, self.sets

    def mean(self) -> Estimate:
        """Return the mean over all positions of all robots, m."""
        return pooled_mean(self.robot_means, self.of_poses)

    def deviation(self) -> Estimate:
        """Return the standard deviation about that mean, m."""
        return standard_deviation(*self.histograms, self.mean().value, self.mean_square)

    def quantile(self, level: float) -> Estimate:
        """Return the quantile at this level, m."""
        return pooled_quantile(*self.histograms, level, self.largest)


@dataclass(frozen=True, kw_only=True)
class Summed(Errors):
    """Errors without sampling: their figures over all poses together."""

    pooled: Pooled

    @classmethod
    def of(cls, pooled: Pooled, squares: Squares) -> Self:
        """Return those of a study without sampling."""
        return cls(squares=squares, levels=pooled.levels, repeats={}, pooled=pooled)

    def mean(self) -> Estimate:
        """Return the mean over all positions of all robots, m."""
        return self.pooled.mean

    def deviation(self) -> Estimate:
        """Return the standard deviation about that mean, m."""
        return self.pooled.deviation

    def quantile(self, level: float) -> Estimate:
        """Return the quantile at this level, m; NaN for one that was not computed."""
        found = dict(zip(self.pooled.levels, self.pooled.quantiles, strict=True))
        return found.get(level, Estimate(np.nan, np.nan, np.nan))
