"""By how much does an arm miss its target once its terms are scaled? On poses that are walked once.

`BySamples`      the share of positions within the target, among samples of which each is a robot of its own
`ByVisits`       the repeatability RP that a share of the robots keeps, by the Monte Carlo of the study, for RP counts visits
`by_montecarlo`  both for all robots, poses and visits, by draws of their own: what verifies an answer
A scaled term is a factor on its column: the arm is not walked again.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from lostmotion.analyses.targets.yield_ import in_blocks
from lostmotion.error_model import error_bins
from lostmotion.error_model.draws import Stream, uniforms
from lostmotion.error_model.intervals import Estimate, pooled_quantile, pooled_robots_quantile, student
from lostmotion.errors import DidNotConvergeError
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.blocks import Plan, sample_block
from lostmotion.propagation.montecarlo.common_random_numbers import scaled

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.pose_matrix import Screws
    from lostmotion.spatial import Floats

_SAMPLES: Final = 1 << 18
_FEWEST_REPEATS: Final = 16
# RP is worked out again for every factor tried: at so many of the poses, for so many robots.
_RP_POSES: Final = 256
_RP_ROBOTS: Final = 400
# A root is looked for this closely, and its slope taken over this share of it.
_CLOSE: Final = 1e-7
_STEP: Final = 0.02
# The ends of an interval, this closely.
_END: Final = 1e-2


@dataclass(frozen=True, slots=True)
class Missed:
    """By how much a target is missed (above zero) or kept: value, and half of its 95 % interval; NaN where the sample cannot tell."""

    value: float
    half: float


class Gauge(Protocol):
    """One way to tell, from so many samples at so many poses."""

    @property
    def poses(self) -> int:
        """Give the number of poses."""

    @property
    def samples(self) -> int:
        """Give the number of samples."""

    def along(self, columns: tuple[int, ...]) -> Callable[[float], Missed]:
        """Give by how much the target is missed as a function of the factor on these terms, all others as they are."""

    def without(self, columns: tuple[int, ...]) -> Estimate:
        """Give what is compared with the target, m, where these terms are zero."""

    def value(self, factors: Floats) -> Estimate:
        """Give what is compared with the target, m, for a factor on each term (term,)."""


def root(missed: Callable[[float], Missed], low: float, high: float) -> float:
    """Where between two ends, one kept and one missed, is a target just met? Raises DidNotConvergeError where the ends do not differ."""
    from scipy.optimize import brentq

    try:
        return float(brentq(lambda x: missed(x).value, low, high, xtol=_CLOSE * max(abs(low), abs(high)), rtol=_CLOSE))
    except ValueError as error:
        raise DidNotConvergeError(f"the target is not crossed between {low:g} and {high:g}: {error}") from error


def around(missed: Callable[[float], Missed], at: float) -> Estimate:
    """How sure is a root? Between the ends at which what is missed, or kept, is just as large as half of its own interval.

    By inversion, for the slope may change within the interval (R. Woodruff, J. Am. Stat. Assoc. 47 (1952) 635, of quantiles). An end below zero is
    zero, one that is not found within sixteen times the first guess of its way NaN.
    """
    step = _STEP * at
    slope = (missed(at + step).value - missed(at - step).value) / (2 * step) if step else 0.0
    half = missed(at).half
    if not half > 0 or not slope:
        return Estimate(at, at if half == 0 else math.nan, at if half == 0 else math.nan)
    sign = math.copysign(1.0, slope)

    def beyond(x: float, side: float) -> float:
        found = missed(x)
        return side * sign * found.value - found.half

    return Estimate(at, _end(lambda x: beyond(x, -1.0), at, -half / abs(slope)), _end(lambda x: beyond(x, 1.0), at, half / abs(slope)))


def _end(beyond: Callable[[float], float], at: float, way: float) -> float:
    """Where on this way from the root is the end passed? Zero where it lies below."""
    from scipy.optimize import brentq

    for k in range(5):
        far = max(at + 2.0**k * way, 0.0)
        if beyond(far) > 0:
            return float(brentq(beyond, at, far, xtol=_END * abs(way), rtol=_CLOSE))
        if far == 0:
            return 0.0
    return math.nan


class BySamples:
    """The share of all positions within the target among samples: as many at every pose, each with a robot and a visit of its own.

    So no two samples share a draw, and a share of them is as sure as the poses are. All laws count as what they are. With an item's part of every
    sample known, a squared error is a quadratic in the factor: a + 2 b f + c f^2.
    """

    def __init__(self, matrix: Screws, replicates: int, share: float, target: float, seed: int) -> None:
        """Say how many samples there are; draws are made again when they are needed, for all of them together would fill the memory."""
        self.matrix, self.share, self.target, self.seed = matrix, share, target, seed
        poses = len(matrix.tool)
        repeats = max(_FEWEST_REPEATS, -(-_SAMPLES // poses))
        self.repeats = repeats + -repeats % _FEWEST_REPEATS
        # Sets of poses tell how sure a share is; poses that were given are taken as they are: then sets of samples do.
        self._sets = (replicates, -1, 1) if replicates > 1 else (poses, _FEWEST_REPEATS, -1)

    @property
    def samples(self) -> int:
        """Give the number of samples."""
        return self.poses * self.repeats

    @property
    def poses(self) -> int:
        """Give the number of poses."""
        return len(self.matrix.tool)

    def along(self, columns: tuple[int, ...]) -> Callable[[float], Missed]:
        """Give by how much the share falls short, against the factor: samples and draws stay the same."""
        own = self._errors(dict.fromkeys(columns, 1.0))
        rest = self._all - own
        a, b, c = (np.einsum("prc,prc->pr", one, other) for one, other in ((rest, rest), (rest, own), (own, own)))
        return lambda factor: self._missed(a + factor * (2 * b + factor * c), self.target)

    def without(self, columns: tuple[int, ...]) -> Estimate:
        """Give the distance that the share of all positions stays within where these terms are zero."""
        return self._distance(self._all - self._errors(dict.fromkeys(columns, 1.0)))

    def value(self, factors: Floats) -> Estimate:
        """Give the distance that the share of all positions stays within."""
        return self._distance(self._all if (factors == 1).all() else self._errors(dict(enumerate(map(float, factors)))))

    def _distance(self, errors: Floats) -> Estimate:
        squares = np.einsum("prc,prc->pr", errors, errors)
        at = float(np.sqrt(np.quantile(squares, self.share)))
        return around(lambda limit: self._missed(squares, limit), at)

    @functools.cached_property
    def _all(self) -> Floats:
        return self._errors(dict.fromkeys(range(len(self.matrix.infos)), 1.0))

    def _errors(self, factors: dict[int, float]) -> Floats:
        """Give the errors (pose, repeat, 3) that these terms make."""
        matrix = self.matrix
        out = np.zeros((len(matrix.tool), self.repeats, 3))
        for column, factor in factors.items():
            shift = matrix.tool[:, 3:, column] * factor
            if shift.any():
                info = matrix.infos[column]
                size = np.ones((len(matrix.tool), self.repeats))
                for level, stream in (("robot", info.robot), ("visit", info.visit)):
                    if stream is not None:
                        size = size * self._drawn(level, stream)
                for axis in range(3):
                    out[..., axis] += size * shift[:, axis, None]
        return out

    def _drawn(self, level: str, stream: Stream) -> Floats:
        u = uniforms(self.seed, f"targets.{level}.{stream.name}", self.samples)
        return np.asarray(stream.law.quantile(u)).reshape(-1, self.repeats)

    def _missed(self, squares: Floats, limit: float) -> Missed:
        sets = (squares <= limit * limit).reshape(self._sets).mean(axis=(1, 2) if self._sets[2] == 1 else (0, 2))
        return Missed(self.share - float(sets.mean()), student(len(sets) - 1) * float(sets.std(ddof=1)) / math.sqrt(len(sets)))


class ByVisits:
    """The repeatability RP, averaged over the poses, that a share of the robots keeps: mean + 3 s of each robot's own visits."""

    def __init__(self, matrix: Screws, replicates: int, share: float, target: float, plan: Plan) -> None:
        """Keep what is drawn at a visit, of some poses of every set alike: all else moves every visit of a robot in the same way."""
        each = len(matrix.tool) // replicates
        chosen = min(each, max(_RP_POSES // replicates, 1))
        self.rows = (np.arange(replicates)[:, None] * each + np.arange(chosen)).ravel()
        self.replicates, self.share, self.target = replicates, share, target
        self.plan = replace(plan, robots=min(plan.robots, _RP_ROBOTS), groups=1)
        kept = np.zeros(len(matrix.infos))
        kept[matrix.columns("visit", "robot x visit")] = 1
        rows = {"local": matrix.local[self.rows], "tool": matrix.tool[self.rows], "at": matrix.at[:, self.rows]}
        self.matrix = scaled(replace(matrix, **rows), kept)

    @property
    def poses(self) -> int:
        """Give the number of poses."""
        return len(self.rows)

    @property
    def samples(self) -> int:
        """Give the number of visits of all robots to all poses."""
        return self.poses * self.plan.robots * self.plan.visits

    def along(self, columns: tuple[int, ...]) -> Callable[[float], Missed]:
        """Give by which share of the target RP exceeds it, against the factor: robots and draws stay the same."""
        factors = np.ones(len(self.matrix.infos))

        def missed(factor: float) -> Missed:
            here = factors.copy()
            here[list(columns)] = factor
            found = self.value(here)
            return Missed(found.value / self.target - 1, found.half / self.target)

        return missed

    def without(self, columns: tuple[int, ...]) -> Estimate:
        """Give the RP that the share of the robots stays below where these terms are zero."""
        factors = np.ones(len(self.matrix.infos))
        factors[list(columns)] = 0
        return self.value(factors)

    def value(self, factors: Floats) -> Estimate:
        """Give the RP that the share of the robots stays below, each robot's RP averaged over the poses."""
        found = scaled(self.matrix, factors)
        each = len(self.rows) // self.replicates
        means = np.empty((self.replicates, self.plan.robots))
        for k in range(self.replicates):
            sample = sample_block(self.plan, found.stretch(k * each, (k + 1) * each), int(self.rows[k * each]))
            means[k] = sample.ap_rp[:, 1].mean(axis=0)
        return pooled_robots_quantile(means, self.share)


def by_montecarlo(plan: Plan, matrix: Screws, share: float) -> tuple[Estimate, Estimate]:
    """What does the study's own Monte Carlo say of these screws, m: the distance that a share of all positions stays within, and the RP of robots?

    RP is the one that the share of the robots stays below, averaged over the poses; NaN for a single visit.
    """
    sets = plan.poses.replicates
    each = len(plan.poses) // sets
    of_groups, of_sets = (np.zeros((count, error_bins.BINS), np.int64) for count in (plan.groups, sets))
    means = np.zeros((sets, plan.robots))
    largest = 0.0
    for k in range(sets):
        for first, block in in_blocks(matrix.stretch(k * each, (k + 1) * each), plan.robots):
            sample = sample_block(plan, block, k * each + first)
            of_groups[:, sample.bins] += sample.group_hist
            of_sets[k, sample.bins] += sample.hist
            largest = max(largest, float(sample.per_pose[:, kernel.LARGEST].max()))
            means[k] += sample.ap_rp[:, 1].sum(axis=0) / each if plan.visits > 1 else math.nan
    return pooled_quantile(of_groups, of_sets, share, largest), pooled_robots_quantile(means, share)
