"""Effect of remedies on the 95th percentile: the same robots and visits, without the errors that
each remedy removes.

The remedies are those of `error_model.remedies`, each of them ideal.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from lostmotion.error_model.intervals import Estimate, pooled_quantile, quantile_drop
from lostmotion.error_model.remedies import (
    approach_at_stage,
    estimated_of,
    geometry_of,
    remaining,
    stages_of,
)
from lostmotion.error_model.robot_intervals import pooled_mean
from lostmotion.propagation.montecarlo.common_random_numbers import Paired, Sample, thinned

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm

LEVEL: Final = 0.95
_POSES: Final = 512
_ROBOTS: Final = 512


@dataclass(frozen=True)
class WaterfallStep:
    """The remaining position error at one stage, m: its mean, its 95th percentile, and the
    reduction of the latter from the first stage.
    """

    name: str
    mean: Estimate
    q95: Estimate
    reduction: Estimate


@dataclass(frozen=True)
class Waterfall:
    """The remaining position error at each stage, in the order of `stages_of`, from a run of
    `poses` x `robots` x `visits`.

    constant  names of the terms that an ideal calibration of the geometry finds, sorted
    """

    stages: tuple[WaterfallStep, ...]
    constant: tuple[str, ...]
    poses: int
    robots: int
    visits: int


def waterfall(  # noqa: PLR0913 - a study is these numbers
    arm: Arm,
    poses: Poses,
    robots: int,
    visits: int,
    seed: int,
    *,
    approach: float = 0.0,
    threads: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Waterfall:
    """Return the position error as manufactured, and with each of the remedies of
    `error_model.remedies`.

    Monte Carlo on at most 512 of the poses, 512 robots and 4 visits, the same ones at every stage.
    Intervals count robots and sets of poses. Arguments and errors as for `montecarlo.run`.
    """
    chosen = thinned(poses, _POSES)
    names = stages_of(arm)
    sides = {approach_at_stage(name, approach) for name in names}
    arriving = {
        side: Paired.of(arm, chosen, min(robots, _ROBOTS), visits, seed, side) for side in sides
    }
    geometry, estimated = geometry_of(arm), estimated_of(arm)

    def sample_at(name: str) -> Sample:
        paired = arriving[approach_at_stage(name, approach)]
        return paired.run(remaining(paired.matrix.infos, name, geometry, estimated))

    samples: list[Sample] = []
    with ThreadPoolExecutor(threads) as pool:
        for sample in pool.map(sample_at, names):
            samples.append(sample)
            if progress is not None:
                progress("calibrating and compensating", len(samples), len(names))
    stages = [_stage(name, sample, samples[0]) for name, sample in zip(names, samples, strict=True)]
    plan = arriving[approach].plan
    return Waterfall(tuple(stages), tuple(sorted(geometry)), len(chosen), plan.robots, plan.visits)


def _stage(name: str, sample: Sample, first: Sample) -> WaterfallStep:
    reduction = (
        Estimate(0.0, 0.0, 0.0)
        if sample is first
        else quantile_drop((first.groups, first.sets), (sample.groups, sample.sets), LEVEL)
    )
    return WaterfallStep(
        name,
        pooled_mean(sample.means),
        pooled_quantile(sample.groups, sample.sets, LEVEL, sample.largest),
        reduction,
    )
