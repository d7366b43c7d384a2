"""Error and repeatability of an arm as functions of factors on its error terms, for solving which
factor meets a target.

`ErrorMetric`          quantile of the error over poses, from samples that each have their own robot
                       and visit
`RepeatabilityMetric`  quantile over robots of RP averaged over the poses, from the Monte Carlo
                       study, because RP needs repeated visits `by_montecarlo`        both for all
                       robots, poses and visits with independent draws, to verify a solution

A factor scales the term's column of the pose matrix, so the arm's kinematics and loads are
evaluated once.
"""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from lostmotion.error_model import error_bins
from lostmotion.error_model.calibrated import streams_of
from lostmotion.error_model.closing import standardised
from lostmotion.error_model.draws import Stream, uniforms
from lostmotion.error_model.intervals import Estimate, pooled_quantile, student
from lostmotion.error_model.robot_intervals import pooled_robots_quantile
from lostmotion.propagation.excess_roots import Excess, root_interval
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.blocks import BlockPlan, sample_block
from lostmotion.propagation.production_yield import split_blocks

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.spatial import Floats

_SAMPLES: Final = 1 << 18
_FEWEST_REPEATS: Final = 16
# Bytes of draws that a metric keeps: those of 64 streams, of an arm of five joints all.
_KEPT: Final = 1 << 27
# Samples whose draws are mixed at a time.
_MIXED: Final = 1 << 12
# RP is recomputed for every factor: at this many poses, for this many robots.
_RP_POSES: Final = 256
_RP_ROBOTS: Final = 400


class Metric(Protocol):
    """A figure compared with a target, as a function of factors on the terms."""

    @property
    def poses(self) -> int:
        """Return the number of poses."""

    @property
    def samples(self) -> int:
        """Return the number of samples."""

    def along(self, columns: tuple[int, ...]) -> Callable[[float], Excess]:
        """Return the excess over the target as a function of the factor on these terms, all others
        unchanged.
        """

    def without(self, columns: tuple[int, ...]) -> Estimate:
        """Return the figure, m, where these terms are zero."""

    def value(self, factors: Floats) -> Estimate:
        """Return the figure, m, for a factor on each term (term,)."""


class ErrorMetric:
    """Quantile of the position error over independent samples: the same number at every pose, each
    with its own robot and visit.

    No two samples share a draw, so the uncertainty of a share is that of the poses. With one item's
    contribution to every sample known, the squared error is quadratic in its factor f: a + 2 b f +
    c f^2.
    """

    def __init__(
        self, matrix: PoseMatrix, replicates: int, share: float, target: float, seed: int
    ) -> None:
        """Set the number of samples; draws beyond the first ones are repeated when needed, because
        storing all of them would take too much memory.
        """
        self._draws: dict[tuple[str, Stream], Floats] = {}
        self.matrix, self.share, self.target, self.seed = matrix, share, target, seed
        poses = len(matrix.tool)
        repeats = max(_FEWEST_REPEATS, -(-_SAMPLES // poses))
        self.repeats = repeats + -repeats % _FEWEST_REPEATS
        # The interval comes from the variance between sets of poses; for given poses, from that
        # between sets of samples.
        self._sets = (replicates, -1, 1) if replicates > 1 else (poses, _FEWEST_REPEATS, -1)

    @property
    def samples(self) -> int:
        """Return the number of samples."""
        return self.poses * self.repeats

    @property
    def poses(self) -> int:
        """Return the number of poses."""
        return len(self.matrix.tool)

    def along(self, columns: tuple[int, ...]) -> Callable[[float], Excess]:
        """Return the shortfall of the share within the target against the factor, with common
        random numbers.
        """
        own = self._errors(dict.fromkeys(columns, 1.0))
        rest = self._all - own
        a, b, c = (
            np.einsum("prc,prc->pr", one, other)
            for one, other in ((rest, rest), (rest, own), (own, own))
        )
        return lambda factor: self._excess(a + factor * (2 * b + factor * c), self.target)

    def without(self, columns: tuple[int, ...]) -> Estimate:
        """Return the error quantile, m, where these terms are zero."""
        return self._quantile(self._all - self._errors(dict.fromkeys(columns, 1.0)))

    def value(self, factors: Floats) -> Estimate:
        """Return the error quantile, m, for a factor on each term (term,)."""
        return self._quantile(
            self._all
            if (factors == 1).all()
            else self._errors(dict(enumerate(map(float, factors))))
        )

    def _quantile(self, errors: Floats) -> Estimate:
        squares = np.einsum("prc,prc->pr", errors, errors)
        at = float(np.sqrt(np.quantile(squares, self.share)))
        return root_interval(lambda limit: self._excess(squares, limit), at)

    @functools.cached_property
    def _all(self) -> Floats:
        return self._errors(dict.fromkeys(range(len(self.matrix.infos)), 1.0))

    def _errors(self, factors: dict[int, float]) -> Floats:
        """Return the position errors (pose, repeat, 3), m, due to these terms with their
        factors.
        """
        matrix = self.matrix
        out = np.zeros((3, len(matrix.tool), self.repeats))
        added = np.empty(out.shape[1:])
        for column, factor in factors.items():
            shift = matrix.tool[:, 3:, column] * factor
            if shift.any():
                info = matrix.infos[column]
                size = np.ones((1, 1))
                for level, stream in (("robot", info.robot), ("visit", info.visit)):
                    if stream is not None:
                        drawn = self._drawn(level, stream)
                        size = drawn if size.size == 1 else size * drawn
                if info.closing is not None:
                    size = size * standardised(
                        self._uniforms("robot", info.closing.stream),
                        matrix.closed[info.closing.row, :, None],
                    )
                for axis in np.flatnonzero(shift.any(axis=0)):
                    out[axis] += np.multiply(size, shift[:, axis, None], out=added)
        return out.transpose(1, 2, 0)

    def _drawn(self, level: str, stream: Stream) -> Floats:
        """Return the draws of a stream (pose, repeat)."""
        correlated = self._correlated.get(stream.name) if level == "robot" else None
        if correlated is not None:
            return correlated
        drawn = self._draws.get((level, stream))
        if drawn is None:
            drawn = np.asarray(stream.law.quantile(self._uniforms(level, stream)))
            if (len(self._draws) + 1) * drawn.nbytes <= _KEPT:
                self._draws[level, stream] = drawn
        return drawn

    @functools.cached_property
    def _correlated(self) -> dict[str, Floats]:
        """Return the draws (pose, repeat) that a calibration leaves correlated, by stream."""
        correlations = self.matrix.correlations
        if correlations is None:
            return {}
        streams = streams_of(correlations)
        drawn = np.empty((len(streams), self.samples))
        for out, stream in zip(drawn, streams, strict=True):
            out[:] = stream.law.quantile(self._uniforms("robot", stream)).ravel()
        # in place, some samples at a time: all of 400 draws take 800 MB
        for first in range(0, self.samples, _MIXED):
            some = drawn[:, first : first + _MIXED]
            some[:] = correlations.factor @ some
        each = drawn.reshape(len(streams), self.poses, self.repeats)
        return dict(zip(correlations.streams, each, strict=True))

    def _uniforms(self, level: str, stream: Stream) -> Floats:
        return uniforms(self.seed, f"targets.{level}.{stream.name}", self.samples).reshape(
            -1, self.repeats
        )

    def _excess(self, squares: Floats, limit: float) -> Excess:
        sets = (
            (squares <= limit * limit)
            .reshape(self._sets)
            .mean(axis=(1, 2) if self._sets[2] == 1 else (0, 2))
        )
        return Excess(
            self.share - float(sets.mean()),
            student(len(sets) - 1) * float(sets.std(ddof=1)) / math.sqrt(len(sets)),
        )


class RepeatabilityMetric:
    """Quantile over robots of the repeatability RP, averaged over the poses: mean + 3 s of each
    robot's visits.
    """

    def __init__(
        self, matrix: PoseMatrix, replicates: int, share: float, target: float, plan: BlockPlan
    ) -> None:
        """Keep the terms that differ between visits, at the first poses of every set."""
        each = len(matrix.tool) // replicates
        chosen = min(each, max(_RP_POSES // replicates, 1))
        self.rows = (np.arange(replicates)[:, None] * each + np.arange(chosen)).ravel()
        self.replicates, self.share, self.target = replicates, share, target
        self.plan = replace(plan, robots=min(plan.robots, _RP_ROBOTS), groups=1)
        of_visit = np.zeros(len(matrix.infos))
        of_visit[matrix.columns("visit", "robot x visit")] = 1
        self.matrix = matrix.rows(self.rows).scaled(of_visit)

    @property
    def poses(self) -> int:
        """Return the number of poses."""
        return len(self.rows)

    @property
    def samples(self) -> int:
        """Return the number of visits of all robots to all poses."""
        return self.poses * self.plan.robots * self.plan.visits

    def along(self, columns: tuple[int, ...]) -> Callable[[float], Excess]:
        """Return the excess of RP relative to the target against the factor, with common random
        numbers.
        """
        factors = np.ones(len(self.matrix.infos))

        def excess(factor: float) -> Excess:
            changed = factors.copy()
            changed[list(columns)] = factor
            repeatability = self.value(changed)
            return Excess(repeatability.value / self.target - 1, repeatability.half / self.target)

        return excess

    def without(self, columns: tuple[int, ...]) -> Estimate:
        """Return the quantile of RP, m, where these terms are zero."""
        factors = np.ones(len(self.matrix.infos))
        factors[list(columns)] = 0
        return self.value(factors)

    def value(self, factors: Floats) -> Estimate:
        """Return the quantile of RP, m, for a factor on each term (term,)."""
        matrix = self.matrix.scaled(factors)
        each = len(self.rows) // self.replicates
        means, at_poses = (
            np.empty((self.replicates, self.plan.robots)),
            np.empty((self.replicates, each)),
        )
        for k in range(self.replicates):
            sample = sample_block(
                self.plan, matrix.stretch(k * each, (k + 1) * each), int(self.rows[k * each])
            )
            means[k], at_poses[k] = sample.ap_rp[:, 1].mean(axis=0), sample.ap_rp[:, 1].mean(axis=1)
        return pooled_robots_quantile(means, self.share, at_poses.ravel())


def by_montecarlo(plan: BlockPlan, matrix: PoseMatrix, share: float) -> tuple[Estimate, Estimate]:
    """Return by Monte Carlo the quantile of the position error and that of RP over robots, m, at
    this share.

    RP is averaged over the poses; it is NaN for a single visit.
    """
    sets = plan.poses.replicates
    each = len(plan.poses) // sets
    of_groups, of_sets = (
        np.zeros((count, error_bins.BINS), np.int64) for count in (plan.groups, sets)
    )
    means, at_poses = np.zeros((sets, plan.robots)), []
    largest = 0.0
    for k in range(sets):
        for first, block in split_blocks(matrix.stretch(k * each, (k + 1) * each), plan.robots):
            sample = sample_block(plan, block, k * each + first)
            of_groups[:, sample.bins] += sample.group_hist
            of_sets[k, sample.bins] += sample.hist
            largest = max(largest, float(sample.per_pose[:, kernel.LARGEST].max()))
            means[k] += sample.ap_rp[:, 1].sum(axis=0) / each if plan.visits > 1 else math.nan
            at_poses.append(
                sample.ap_rp[:, 1].mean(axis=1)
                if plan.visits > 1
                else np.full(len(sample.ap_rp), math.nan)
            )
    return pooled_quantile(of_groups, of_sets, share, largest), pooled_robots_quantile(
        means, share, np.concatenate(at_poses)
    )
