"""Stages of Monte Carlo with a stopping rule: the robots and poses that a given precision requires.

The method is that of JCGM 101:2008, 7.9, in the form of two stages (G. Wübbeler et al., Metrologia
47 (2010) 317). The first run estimates the scatter of its figures. From that follow the numbers of
robots, and of poses where they are sampled, that the requested half-width requires. A larger run
begins with the same robots and poses, so it extends the smaller one; every interval is that of the
last run. The second run may be too small, because its scatter is larger than that of the first run,
or because its size was limited while the variances were uncertain. Then further runs follow, up to
four in all. Each run tests nearly the same figures again, so the intervals cover the true values
slightly less often than those of a run of fixed size. tests/propagation/test_stopping.py measures
the coverage.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final, TypeVar

from lostmotion.errors import refuse_argument
from lostmotion.propagation.error_samples import Drawn
from lostmotion.propagation.figures import figures_of
from lostmotion.propagation.montecarlo.blocks import MOST_ROBOTS as ROBOTS_THERE_CAN_BE
from lostmotion.propagation.montecarlo.montecarlo import run

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from lostmotion.error_model.intervals import Estimate, Spread
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.montecarlo.blocks import Device
    from lostmotion.propagation.montecarlo.montecarlo import Sampled

STAGES: Final = 4
MOST_ROBOTS: Final = 10_000
MOST_POSES: Final = 65_536
# The second stage aims at this share of the requested half-width, since the scatter that the first
# stage estimates is uncertain.
_AIM: Final = 0.85
# The same for the last stage, after a stage that was not precise enough: no further stage can
# follow.
_AIM_LAST: Final = 0.6
_FOR_POSES: Final = 0.5
# Variances estimated from few robots or few independent sets of poses are themselves uncertain, and
# the variance over a Sobol sequence falls faster than with the number of poses. So a first growth
# that needs more poses, or starts from few robots, is limited to this factor of samples, if it
# would exceed the square of this factor. Below that square an intermediate stage saves too little
# time.
_MOST_GROWTH: Final = 8.0
_FEW_ROBOTS: Final = 30
# A stage that adds less than this is not worth its time.
_LEAST_GROWTH: Final = 1.2
_WANTED: Final = "a share of each figure from 0.3 % to 50 %, or '1 digit', '2 digits', '3 digits'"
# Quantiles are read from bins of 0.27 %: a share below that could not be resolved.
_LEAST: Final = 0.003


@dataclass(frozen=True, slots=True)
class Tolerance:
    """The largest allowed half-width of a 95 % interval (JCGM 101, 7.9.2).

    share   of the figure, 0.003 to 0.5; 0 where digits are requested
    digits  significant digits, 1 to 3: half a unit of the last one; 0 where a share is requested
    """

    share: float = 0.0
    digits: int = 0

    @classmethod
    def of(cls, until: float | str) -> Tolerance:
        """Return the tolerance for 0.01, "1 %" or "2 digits". Raises InputError for any other
        value.
        """
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
        if not _LEAST <= until <= 0.5:  # noqa: PLR2004 - as stated in `_WANTED`
            raise refuse_argument("until", given, _WANTED, until="1 %")
        return cls(float(until))

    def half(self, value: float) -> float:
        """Return the allowed half-width for a figure of this value, in its unit."""
        if self.digits:
            return (
                0.5 * 10.0 ** (math.floor(math.log10(abs(value))) - self.digits + 1)
                if value
                else 0.0
            )
        return self.share * abs(value)

    def __str__(self) -> str:
        """Return the requested precision as text."""
        return (
            f"{self.digits} significant digit{'s' if self.digits > 1 else ''}"
            if self.digits
            else f"{100 * self.share:g} %"
        )


@dataclass(frozen=True, slots=True)
class Watched:
    """A figure that the stopping rule tests.

    name         as printed
    value, half  the figure and the half-width of its 95 % interval, m
    of_poses     share of its variance that more poses would reduce, 0..1
    """

    name: str
    value: float
    half: float
    of_poses: float

    @property
    def relative(self) -> float:
        """Return the half-width as a share of the value; zero for an arm without errors."""
        return 0.0 if self.half == 0 else self.half / abs(self.value) if self.value else math.inf


@dataclass(frozen=True, slots=True)
class SamplingStage:
    """One run: its numbers of poses and robots, and its figures by key."""

    poses: int
    robots: int
    figures: dict[str, Watched]


@dataclass(frozen=True)
class Stopping:
    """The requested precision, every stage, and the upper limits of robots and poses."""

    tolerance: Tolerance
    stages: tuple[SamplingStage, ...]
    most_robots: int
    most_poses: int

    @property
    def reached(self) -> bool:
        """Return whether every half-width of the last stage meets the tolerance."""
        return not self.missed

    @property
    def missed(self) -> tuple[str, ...]:
        """Return the keys of the figures of the last stage that are not precise enough, the least
        precise first.
        """
        found = self.stages[-1].figures
        ratios = {name: _ratio(self.tolerance, each) for name, each in found.items()}
        return tuple(
            sorted((name for name in found if ratios[name] > 1), key=lambda name: -ratios[name])
        )

    @property
    def limited_by(self) -> str:
        """Return the limit that prevented the requested precision: "robots", "poses" or "stages";
        empty where it was reached.
        """
        if self.reached:
            return ""
        last = self.stages[-1]
        worst = last.figures[self.missed[0]]
        of_poses = not math.isfinite(worst.half) or worst.of_poses > 0.5  # noqa: PLR2004 - more than half
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
    """Return the poses of the last run, its result, and every stage, for the requested precision.

    poses, robots  of the first run
    tolerance      requested precision
    most_robots    largest number of robots, at least `robots`
    more           returns a given number of poses, which begin with the same ones; None: the poses
                   are fixed
    most_poses     largest number of poses; default: 65 536

    Other arguments and errors as for `montecarlo.run`. Raises InputError for `most_robots` below
    `robots` or above 1 000 000.
    """
    if not robots <= most_robots <= ROBOTS_THERE_CAN_BE:
        raise refuse_argument(
            "most_robots",
            most_robots,
            f"from {robots}, the robots of the first run, to {ROBOTS_THERE_CAN_BE}",
            most_robots=10000,
        )
    visited = {len(poses): poses}
    runs = 0

    def sample(count: int, robots: int) -> Sampled:
        nonlocal runs
        runs += 1
        if count not in visited and more is not None:
            visited[count] = more(count)
        staged = None if progress is None else _by_stage(progress, runs)
        return run(
            arm,
            visited[count],
            robots,
            visits,
            seed,
            approach=approach,
            threads=threads,
            tile=tile,
            device=device,
            progress=staged,
        )

    most_poses = len(poses) if more is None else max(most_poses or MOST_POSES, len(poses))
    found, stopping = settle(
        sample,
        partial(watched, approach=approach),
        len(poses),
        robots,
        tolerance,
        most_poses=most_poses,
        most_robots=most_robots,
    )
    return visited[stopping.stages[-1].poses], found, stopping


def _by_stage(
    progress: Callable[[str, int, int], None], stage: int
) -> Callable[[str, int, int], None]:
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
    """Return the last run and all stages of `sample(poses, robots)`, repeated until every figure of
    `watch` meets the tolerance.

    It also ends after four stages, or where no more robots and poses are allowed. The number of
    poses grows by factors of two up to `most_poses`; for fixed poses, pass their number.
    """
    stages: list[SamplingStage] = []
    was_capped = capped = False
    while True:
        found = sample(poses, robots)
        stages.append(SamplingStage(poses, robots, watch(found)))
        missed = [each for each in stages[-1].figures.values() if _ratio(tolerance, each) > 1]
        short = was_capped and not capped and len(stages) == STAGES - 1
        wanted = _larger(
            stages[-1], tolerance, most_poses, most_robots, _AIM_LAST if short else _AIM
        )
        if not missed or len(stages) == STAGES or wanted == (poses, robots):
            return found, Stopping(tolerance, tuple(stages), most_robots, most_poses)
        following = wanted if was_capped else _capped(stages[-1], *wanted)
        capped = following != wanted
        was_capped = was_capped or capped
        poses, robots = following


def _ratio(tolerance: Tolerance, figure: Watched) -> float:
    """Return the half-width divided by the allowed one: zero for an arm without errors, infinite
    where the sample cannot determine it.
    """
    if figure.half == 0:
        return 0.0
    allowed = tolerance.half(figure.value)
    return figure.half / allowed if allowed > 0 and math.isfinite(figure.half) else math.inf


def _larger(
    stage: SamplingStage, tolerance: Tolerance, most_poses: int, most_robots: int, aim: float
) -> tuple[int, int]:
    """Return the numbers of poses and robots with the fewest samples that suffice, since variances
    fall with them; the largest allowed if none do.
    """
    ratios = [(_ratio(tolerance, each) / aim, each.of_poses) for each in stage.figures.values()]
    if any(math.isinf(ratio) for ratio, _ in ratios):  # too few robots for any interval
        return stage.poses, min(4 * stage.robots, max(most_robots, stage.robots))
    choices: list[tuple[int, int]] = []
    for poses in _doubled(stage.poses, most_poses):
        left = [1 - ratio**2 * of_poses * stage.poses / poses for ratio, of_poses in ratios]
        if min(left) <= 0:
            continue
        factor = max(
            (
                ratio**2 * (1 - of_poses) / room
                for (ratio, of_poses), room in zip(ratios, left, strict=True)
            ),
            default=1.0,
        )
        if factor * stage.robots <= most_robots:
            choices.append((poses, math.ceil(stage.robots * max(factor, 1.0))))
    # the largest number of robots, and enough poses that half of the requested variance remains for
    # the robots
    if not choices:
        enough = (
            poses
            for poses in _doubled(stage.poses, most_poses)
            if all(
                ratio**2 * of_poses * stage.poses <= _FOR_POSES * poses
                for ratio, of_poses in ratios
            )
        )
        return next(enough, max(_doubled(stage.poses, most_poses))), max(most_robots, stage.robots)
    poses, robots = min(choices, key=lambda choice: choice[0] * choice[1])
    if poses == stage.poses:
        robots = min(
            max(robots, math.ceil(_LEAST_GROWTH * stage.robots)), max(most_robots, stage.robots)
        )
    return poses, robots


def _capped(stage: SamplingStage, poses: int, robots: int) -> tuple[int, int]:
    """Return these numbers with limited growth while the variances are uncertain; poses and robots
    grow in the same proportion (logarithmic).
    """
    growth = poses * robots / (stage.poses * stage.robots)
    if growth <= _MOST_GROWTH**2 or (poses == stage.poses and stage.robots >= _FEW_ROBOTS):
        return poses, robots
    share = math.log(_MOST_GROWTH) / math.log(growth)
    doublings = round(share * math.log2(poses / stage.poses))
    return stage.poses << doublings, max(
        min(math.ceil(stage.robots * _MOST_GROWTH / 2**doublings), robots), stage.robots
    )


def _doubled(count: int, most: int) -> Iterator[int]:
    yield count
    while 2 * count <= most:
        count *= 2
        yield count


def watched(sampled: Sampled, approach: float = 0.0) -> dict[str, Watched]:
    """Return the figures that the stopping rule tests by key: those that declare a spread.
    `approach` of the joints names RP.
    """
    errors = Drawn.of(sampled, approach=approach)
    out = {}
    for key, figure in figures_of(errors).items():
        if figure.spread is not None:
            estimate = figure.estimate(errors)
            out[key] = _watched(figure.name, estimate, figure.spread(errors, estimate))
    return out


def _watched(name: str, estimate: Estimate, spread: Spread) -> Watched:
    half = estimate.half
    whole = spread.of_poses + spread.of_robots
    return Watched(
        name,
        estimate.value,
        half if math.isfinite(half) else math.inf,
        spread.of_poses / whole if whole > 0 else 0.0,
    )
