"""Stages of Monte Carlo with a stopping rule: the robots and poses that a given precision requires.

After JCGM 101:2008, 7.9, in the form of two stages (G. Wübbeler et al., Metrologia 47 (2010) 317): a first run says how far its figures scatter,
and from that how many robots, and poses where they are sampled, the wanted half-width takes. More robots keep the first ones and a longer sequence of
poses its beginning, so a later run enlarges an earlier one; every interval is that of the last run alone. Where the second run falls short (its
scatter was larger than the first one's), or was kept small because the variances were uncertain, further ones follow, four in all: each looks again
at nearly the same figures, so that intervals hold the truth slightly less often than those of a run of a size fixed beforehand. The tests say how
often.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from lostmotion.error_model.intervals import Spread, pooled_mean, pooled_quantile, pooled_robots_quantile, quantile_spread, share_spread, two_way
from lostmotion.errors import refuse_argument
from lostmotion.propagation.montecarlo.blocks import MOST_ROBOTS as ROBOTS_THERE_CAN_BE
from lostmotion.propagation.montecarlo.montecarlo import run

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.montecarlo.blocks import Device
    from lostmotion.propagation.montecarlo.montecarlo import Sampled

STAGES: Final = 4
MOST_ROBOTS: Final = 10_000
MOST_POSES: Final = 65_536
# The second stage aims at this share of the wanted half-width, since the first one knows the scatter of its figures only so well.
_AIM: Final = 0.85
# The last stage, where a stage before it fell short: nothing after it can make good what it lacks.
_AIM_LAST: Final = 0.6
_FOR_POSES: Final = 0.5
# What few robots, or the few independent sets of poses, leave of uncertainty is itself hardly known, and a Sobol sequence's falls faster than with
# the number of poses. So the first stage that would take more poses, or begins with few robots, takes so many times the samples where it would take
# more than the square of that; where it would take less, a stage between spares too little, and is better kept for what falls short.
_MOST_GROWTH: Final = 8.0
_FEW_ROBOTS: Final = 30
# A stage that adds less than this is not worth its time.
_LEAST_GROWTH: Final = 1.2
_WANTED: Final = "a share of each figure from 0.3 % to 50 %, or '1 digit', '2 digits', '3 digits'"
# Quantiles are read from bins of 0.27 %: a share below that could not be resolved.
_LEAST: Final = 0.003


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far half of a 95 % interval may reach: a share of the figure, or half a unit of its last significant digit (JCGM 101, 7.9.2)."""

    share: float = 0.0
    digits: int = 0

    @classmethod
    def of(cls, until: float | str) -> Tolerance:
        """Read 0.01, "1 %" or "2 digits". Raises InputError for anything else."""
        given = until
        if isinstance(until, str):
            match = re.fullmatch(r"\s*(\d{1,6}(?:\.\d{1,6})?)\s*(%|digits?)\s*", until)
            if match is None:
                raise refuse_argument("until", until, _WANTED, until="1 %")
            amount = float(match[1])
            if match[2] != "%":
                if amount not in {1, 2, 3}:
                    raise refuse_argument("until", until, _WANTED, until="2 digits")
                return cls(digits=int(amount))
            until = amount / 100
        if not _LEAST <= until <= 0.5:  # noqa: PLR2004 - as `_WANTED` says
            raise refuse_argument("until", given, _WANTED, until="1 %")
        return cls(float(until))

    def half(self, value: float) -> float:
        """Return the half-width allowed for a figure of this value."""
        if self.digits:
            return 0.5 * 10.0 ** (math.floor(math.log10(abs(value))) - self.digits + 1) if value else 0.0
        return self.share * abs(value)

    def __str__(self) -> str:
        """Return the requested precision as text."""
        return f"{self.digits} significant digit{'s' if self.digits > 1 else ''}" if self.digits else f"{100 * self.share:g} %"


@dataclass(frozen=True, slots=True)
class Watched:
    """A figure whose interval is watched: its value, half of its interval, and the share of its variance that more poses would reduce."""

    value: float
    half: float
    of_poses: float

    @property
    def relative(self) -> float:
        """Return the half-width as a share of the value; none where nothing errs."""
        return 0.0 if self.half == 0 else self.half / abs(self.value) if self.value else math.inf


@dataclass(frozen=True, slots=True)
class Stage:
    """One run: numbers of poses and robots, and its figures by name."""

    poses: int
    robots: int
    figures: dict[str, Watched]


@dataclass(frozen=True)
class Stopping:
    """Requested precision, the figures of each stage, and whether the last one has it. `most_robots`, `most_poses` are upper limits."""

    tolerance: Tolerance
    stages: tuple[Stage, ...]
    most_robots: int
    most_poses: int

    @property
    def reached(self) -> bool:
        """Return whether every half-width of the last stage is within the tolerance."""
        return not self.missed

    @property
    def missed(self) -> tuple[str, ...]:
        """Return the figures of the last stage that are not precise enough, the least precise first."""
        found = self.stages[-1].figures
        off = {name: _off(self.tolerance, each) for name, each in found.items()}
        return tuple(sorted((name for name in found if off[name] > 1), key=lambda name: -off[name]))

    @property
    def limited_by(self) -> str:
        """Return what limited the precision: "robots", "poses" or "stages"; empty where it was reached."""
        if self.reached:
            return ""
        last = self.stages[-1]
        worst = last.figures[self.missed[0]]
        of_poses = not math.isfinite(worst.half) or worst.of_poses > 0.5  # noqa: PLR2004 - the larger part
        if of_poses and 2 * last.poses > self.most_poses and math.isfinite(worst.half):
            return "poses"
        return "robots" if last.robots >= self.most_robots else "stages"


_Found = TypeVar("_Found")


def run_until(  # noqa: PLR0913 - a study is these numbers
    arm: Arm,
    poses: Poses,
    robots: int,
    visits: int,
    seed: int,
    tolerance: Tolerance,
    *,
    most_robots: int = MOST_ROBOTS,
    more: Callable[[int], Poses] | None = None,
    most_poses: int | None = None,
    approach: float = 0.0,
    threads: int = 1,
    tile: int = 1,
    device: Device = "cpu",
    progress: Callable[[str, int, int], None] | None = None,
) -> tuple[Poses, Sampled, Stopping]:
    """Return the poses of the last run, its result, and every stage, for the precision asked for.

    Begins with these poses and robots. `more(count)` gives so many poses instead, up to `most_poses` (65 536); without it, poses are taken as they
    are. Other arguments and errors as `montecarlo.run`; raises InputError for `most_robots` below `robots`.
    """
    if not robots <= most_robots <= ROBOTS_THERE_CAN_BE:
        raise refuse_argument("most_robots", most_robots, f"from the {robots} robots it begins with to {ROBOTS_THERE_CAN_BE}", most_robots=10000)
    visited = {len(poses): poses}
    runs = 0

    def sample(count: int, robots: int) -> Sampled:
        nonlocal runs
        runs += 1
        if count not in visited and more is not None:
            visited[count] = more(count)
        staged = None if progress is None else _by_stage(progress, runs)
        return run(arm, visited[count], robots, visits, seed, approach=approach, threads=threads, tile=tile, device=device, progress=staged)

    most_poses = len(poses) if more is None else max(most_poses or MOST_POSES, len(poses))
    found, stopping = settle(sample, watched, len(poses), robots, tolerance, most_poses=most_poses, most_robots=most_robots)
    return visited[stopping.stages[-1].poses], found, stopping


def _by_stage(progress: Callable[[str, int, int], None], stage: int) -> Callable[[str, int, int], None]:
    return lambda what, done, whole: progress(f"{what}, stage {stage}", done, whole)


def settle(
    sample: Callable[[int, int], _Found],
    watch: Callable[[_Found], dict[str, Watched]],
    poses: int,
    robots: int,
    tolerance: Tolerance,
    *,
    most_poses: int,
    most_robots: int = MOST_ROBOTS,
) -> tuple[_Found, Stopping]:
    """Run `sample(poses, robots)` until every figure of `watch` is within the tolerance, or no more robots and poses are allowed.

    Poses go up by factors of two, up to `most_poses` (give the number itself where poses are fixed). Gives the last run, and what each stage found.
    """
    stages: list[Stage] = []
    spared = modest_now = False
    while True:
        found = sample(poses, robots)
        stages.append(Stage(poses, robots, watch(found)))
        off = [each for each in stages[-1].figures.values() if _off(tolerance, each) > 1]
        short = spared and not modest_now and len(stages) == STAGES - 1
        wanted = _larger(stages[-1], tolerance, most_poses, most_robots, _AIM_LAST if short else _AIM)
        if not off or len(stages) == STAGES or wanted == (poses, robots):
            return found, Stopping(tolerance, tuple(stages), most_robots, most_poses)
        modest = wanted if spared else _capped(stages[-1], *wanted)
        modest_now = modest != wanted
        spared = spared or modest_now
        poses, robots = modest


def _off(tolerance: Tolerance, figure: Watched) -> float:
    """Return this half-width over the wanted one. Nothing where nothing errs, infinite where the sample cannot determine it."""
    if figure.half == 0:
        return 0.0
    allowed = tolerance.half(figure.value)
    return figure.half / allowed if allowed > 0 and math.isfinite(figure.half) else math.inf


def _larger(stage: Stage, tolerance: Tolerance, most_poses: int, most_robots: int, aim: float) -> tuple[int, int]:
    """Return the least costly sufficient numbers of poses and robots. Variances fall with their number; the largest allowed if none suffice."""
    off = [(_off(tolerance, each) / aim, each.of_poses) for each in stage.figures.values()]
    if any(math.isinf(ratio) for ratio, _ in off):  # too few robots to know anything
        return stage.poses, min(4 * stage.robots, max(most_robots, stage.robots))
    choices: list[tuple[int, int]] = []
    for poses in _doubled(stage.poses, most_poses):
        left = [1 - ratio**2 * of_poses * stage.poses / poses for ratio, of_poses in off]
        if min(left) <= 0:
            continue
        factor = max((ratio**2 * (1 - of_poses) / room for (ratio, of_poses), room in zip(off, left, strict=True)), default=1.0)
        if factor * stage.robots <= most_robots:
            choices.append((poses, math.ceil(stage.robots * max(factor, 1.0))))
    if not choices:  # all robots that are allowed, and poses that leave half of the wanted variance to them
        enough = (
            poses
            for poses in _doubled(stage.poses, most_poses)
            if all(ratio**2 * of_poses * stage.poses <= _FOR_POSES * poses for ratio, of_poses in off)
        )
        return next(enough, max(_doubled(stage.poses, most_poses))), max(most_robots, stage.robots)
    poses, robots = min(choices, key=lambda choice: choice[0] * choice[1])
    if poses == stage.poses:
        robots = min(max(robots, math.ceil(_LEAST_GROWTH * stage.robots)), max(most_robots, stage.robots))
    return poses, robots


def _capped(stage: Stage, poses: int, robots: int) -> tuple[int, int]:
    """Return the part of this growth that is worth its time while the variances are uncertain. Poses and robots share it as they would the whole."""
    growth = poses * robots / (stage.poses * stage.robots)
    if growth <= _MOST_GROWTH**2 or (poses == stage.poses and stage.robots >= _FEW_ROBOTS):
        return poses, robots
    share = math.log(_MOST_GROWTH) / math.log(growth)
    doublings = round(share * math.log2(poses / stage.poses))
    return stage.poses << doublings, max(min(math.ceil(stage.robots * _MOST_GROWTH / 2**doublings), robots), stage.robots)


def _doubled(count: int, most: int) -> Iterator[int]:
    yield count
    while 2 * count <= most:
        count *= 2
        yield count


def watched(found: Sampled) -> dict[str, Watched]:
    """Return the watched figures of a study: mean and 95th percentile of all errors; AP and RP, mean and 95th percentile over robots."""
    out = {"mean": _watched(pooled_mean(found.robot_means[:, :, 0]), two_way(found.robot_means[:, :, 0]))}
    q95 = pooled_quantile(found.group_hist, found.replicate_hist, 0.95)
    out["95th percentile"] = _watched(q95, share_spread(found.group_hist, found.replicate_hist, q95.value))
    if np.isfinite(found.robot_means[:, :, 1:]).all():
        for column, name in ((1, "AP"), (2, "RP")):
            means = found.robot_means[:, :, column]
            out[f"{name}, mean over poses and robots"] = _watched(pooled_mean(means), two_way(means))
            highest = pooled_robots_quantile(means)
            half = highest.half
            variance = (half / 1.96) ** 2
            of_poses = quantile_spread(means)
            out[f"{name}, 95th percentile of robots"] = _watched(highest, Spread(max(variance - of_poses, 0.0), of_poses, half))
    return out


def _watched(estimate: Estimate, spread: Spread) -> Watched:
    half = estimate.half
    whole = spread.of_poses + spread.of_robots
    return Watched(estimate.value, half if math.isfinite(half) else math.inf, spread.of_poses / whole if whole > 0 else 0.0)
