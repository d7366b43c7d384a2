"""Production yield: the share of robots that meet a target, each judged by its own error, AP or RP,
with an exact interval that counts robots.

The robots are those of the Monte Carlo study with the same seed. The interval is that of C.
Clopper, E. Pearson, Biometrika 26 (1934) 404, which covers the true share with a probability of at
least 95 %.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from lostmotion.error_model import error_bins
from lostmotion.error_model.intervals import quantile
from lostmotion.error_model.pose_matrix import PoseMatrix, pose_matrices
from lostmotion.error_model.share_intervals import share_interval
from lostmotion.errors import refuse_argument
from lostmotion.propagation.montecarlo.blocks import BlockPlan, sample_block
from lostmotion.propagation.montecarlo.montecarlo import BLOCK

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

Criterion = Literal["error", "worst accuracy", "repeatability", "worst repeatability"]
CRITERIA: Final[tuple[Criterion, ...]] = get_args(Criterion)
# Each robot has a histogram of its own, of 74 kB.
MOST_ROBOTS: Final = 4000
_MOST_PAIRS: Final = 2_000_000


@dataclass(frozen=True)
class RobotFigures:
    """Figures of each robot, m (robot,).

    error                quantile `share` of its position error over all poses and visits
    worst_accuracy       AP at its worst pose
    repeatability        RP averaged over the poses
    worst_repeatability  RP at its worst pose
    """

    share: float
    poses: int
    visits: int
    error: Floats
    worst_accuracy: Floats
    repeatability: Floats
    worst_repeatability: Floats

    def judged_by(self, figure: Criterion) -> Floats:
        """Return the figure by which robots are judged (robot,)."""
        return np.asarray(getattr(self, figure.replace(" ", "_")))


@dataclass(frozen=True, repr=False)
class Yield:
    """Share of robots that meet a target: `figures` (robot,) m, ascending, of the `criterion`,
    compared with `target`, m.

    `approach` is the sign of the joints' last motion, 0 where it is drawn: it names the
    repeatability.
    """

    criterion: Criterion
    share_of_positions: float
    target: float
    figures: Floats
    poses: int
    visits: int
    approach: float = 0.0

    @property
    def robots(self) -> int:
        """Return the number of simulated robots."""
        return len(self.figures)

    @property
    def within(self) -> int:
        """Return the number of robots that meet the target."""
        return self.within_of(self.target)

    @property
    def share(self) -> float:
        """Return the share of robots that meet the target, 0..1."""
        return self.within / self.robots

    @property
    def interval(self) -> tuple[float, float]:
        """Return the ends of the exact 95 % confidence interval of the share."""
        return share_interval(self.within, self.robots, method="exact")

    def within_of(self, target: float) -> int:
        """Return the number of robots that would meet another target, m."""
        return int(np.searchsorted(self.figures, target, side="right"))

    def curve(self, points: int = 121) -> tuple[Floats, Floats, Floats]:
        """Return the yield against the target: targets (point,), m; shares (point,); ends of their
        intervals (point, 2).
        """
        low, high = float(self.figures[0]), float(self.figures[-1])
        margin = 0.1 * (high - low) or 0.1 * high
        targets = np.linspace(
            max(min(low - margin, 0.98 * self.target), 0.0),
            max(high + margin, 1.02 * self.target),
            points,
        )
        counts = [self.within_of(float(each)) for each in targets]
        return (
            targets,
            np.array(counts) / self.robots,
            np.array([share_interval(count, self.robots, method="exact") for count in counts]),
        )

    def robots_for(self, width: float) -> int:
        """Return the number of robots for an interval no wider than this (0..1), at this yield;
        errors as `robots_needed`.
        """
        return robots_needed(self.share, width)

    def __repr__(self) -> str:
        """Return the yield in one line."""
        low, high = self.interval
        count = (
            f"{self.within} of {self.robots} robots meet {self.target * 1e3:.4g} mm "
            f"({self.criterion})"
        )
        return f"<Yield {100 * self.share:.2f} % ({100 * low:.2f} … {100 * high:.2f} %): {count}>"


def robots_needed(share: float, width: float, confidence: float = 0.95) -> int:
    """Return the number of robots with which the exact interval is no wider than `width` (0..1), at
    about this share of robots within the target.

    Raises ValueError for a share outside 0..1 or a width outside 0..1.
    """
    if not 0 <= share <= 1 or not 0 < width < 1:
        raise ValueError(f"share {share}, width {width}: expected 0 to 1 each")

    def too_wide(count: int) -> bool:
        low, high = share_interval(round(share * count), count, confidence, "exact")
        return high - low > width

    most = 1
    while too_wide(most):
        most *= 2
    least = most // 2
    while most - least > 1:
        middle = (least + most) // 2
        least, most = (middle, most) if too_wide(middle) else (least, middle)
    return most


def robot_figures(
    plan: BlockPlan, blocks: Iterable[tuple[int, PoseMatrix]], share: float
) -> RobotFigures:
    """Return the figures of each robot of this plan; `blocks` are pose matrices, each with the
    index of its first pose.

    Raises InputError for more than MOST_ROBOTS robots. AP and RP are NaN for a single visit.
    """
    if plan.robots > MOST_ROBOTS:
        raise refuse_argument(
            "robots",
            plan.robots,
            f"at most {MOST_ROBOTS} where each is judged by itself",
            robots=1000,
        )
    own = replace(plan, groups=plan.robots)
    counts = np.zeros((plan.robots, error_bins.BINS), np.int32)
    worst = np.zeros((2, plan.robots))
    sums = np.zeros(plan.robots)
    poses = 0
    for first, matrix in blocks:
        sample = sample_block(own, matrix, first)
        counts[:, sample.bins] += sample.group_hist
        poses += len(matrix.tool)
        if plan.visits > 1:
            worst = np.maximum(worst, sample.ap_rp.max(axis=0))
            sums += sample.ap_rp[:, 1].sum(axis=0)
    if plan.visits == 1:
        worst, sums = np.full_like(worst, math.nan), np.full_like(sums, math.nan)
    error = np.array([quantile(hist, share) for hist in counts])
    return RobotFigures(share, poses, plan.visits, error, worst[0], sums / poses, worst[1])


def split_blocks(matrix: PoseMatrix, robots: int) -> Iterator[tuple[int, PoseMatrix]]:
    """Yield blocks of a pose matrix with the index of their first pose; memory stays bounded for
    any number of robots.
    """
    step = max(min(BLOCK, _MOST_PAIRS // robots), 1)
    for first in range(0, len(matrix.tool), step):
        yield first, matrix.stretch(first, first + step)


def computed_blocks(plan: BlockPlan) -> Iterator[tuple[int, PoseMatrix]]:
    """Yield the pose matrix of a plan in blocks, each with the index of its first pose."""
    step = max(min(BLOCK, _MOST_PAIRS // plan.robots), 1)
    for rows, matrix in pose_matrices(plan.arm, plan.poses.q, step, approach=plan.approach):
        yield rows.start, matrix


def compute_yield(  # noqa: PLR0913 - arguments of a production
    arm: Arm,
    poses: Poses,
    target: float,
    *,
    criterion: Criterion,
    share: float,
    robots: int,
    visits: int,
    seed: int,
    approach: float = 0.0,
) -> Yield:
    """Return the share of robots that meet a target (m), each judged by its own figure.

    Raises InputError for an unknown figure, counts out of range, and AP or RP of a single visit.
    """
    if criterion not in CRITERIA:
        raise refuse_argument(
            "criterion", criterion, "one of " + ", ".join(CRITERIA), criterion="error"
        )
    if criterion != "error" and visits < 2:  # noqa: PLR2004 - a scatter needs two
        raise refuse_argument("visits", visits, "at least 2 for AP and RP", visits=30)
    plan = BlockPlan.of(arm, poses, robots, visits, seed, approach)
    return yield_of(robot_figures(plan, computed_blocks(plan), share), criterion, target, approach)


def yield_of(figures: RobotFigures, criterion: Criterion, target: float, approach: float) -> Yield:
    """Return the yield of these figures for a target, m."""
    return Yield(
        criterion,
        figures.share,
        target,
        np.sort(figures.judged_by(criterion)),
        figures.poses,
        figures.visits,
        approach,
    )
