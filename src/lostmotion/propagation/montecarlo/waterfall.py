"""Effect of calibration and compensation on the 95th percentile: the same robots and visits, without the errors that each remedy removes.

Calibrated          removes every error drawn per robot that is a constant screw in the frame of its place: lengths, axis tilts and offsets, encoder
                    zeros, base tilt. An ideal identification of the geometry finds these. It does not find harmonics (transmission error, encoder
                    eccentricity, runout), which require a table per joint, nor errors that depend on the load (scatter of stiffness, size of a play
                    that a load closes). Errors that are the same in every robot are removed by compensation, also constant ones.
Load compensated    removes every design term: the controller knows pose, load, nominal stiffness and nominal play exactly.
Mapped              removes every error drawn per robot, including harmonics and errors that depend on the load. The remaining errors differ from
                    visit to visit, including the size of a free play. No remedy removes them.

Each remedy is ideal, so the remaining error is a lower limit for a real one.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.intervals import Estimate, pooled_mean, pooled_quantile, quantile_drop
from lostmotion.propagation.montecarlo.common_random_numbers import Paired, Sample, thinned

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.error_model.pose_matrix import Column
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

STAGES: Final = ("as manufactured", "calibrated", "load compensated", "both", "both, and each robot mapped")
LEVEL: Final = 0.95
_POSES: Final = 512
_ROBOTS: Final = 512


@dataclass(frozen=True)
class Stage:
    """The remaining position error at one stage, m: its mean, its 95th percentile, and the reduction of the latter from the first stage."""

    name: str
    mean: Estimate
    q95: Estimate
    reduction: Estimate


@dataclass(frozen=True)
class Waterfall:
    """The remaining position error at each stage, in the order of `STAGES`, from a run of `poses` x `robots` x `visits`.

    constant  names of the terms that an ideal calibration of the geometry finds, sorted
    """

    stages: tuple[Stage, ...]
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
    """Return the position error as manufactured, calibrated, load compensated, both, and with each robot mapped as well.

    Monte Carlo on at most 512 of the poses, 512 robots and 4 visits, the same ones at every stage. Intervals count robots and sets of poses.
    Arguments and errors as for `montecarlo.run`.
    """
    chosen = thinned(poses, _POSES)
    paired = Paired.of(arm, chosen, min(robots, _ROBOTS), visits, seed, approach)
    geometry = geometry_of(arm)
    factors = [remaining(paired.matrices[0].infos, name, geometry) for name in STAGES]
    samples: list[Sample] = []
    with ThreadPoolExecutor(threads) as pool:
        for sample in pool.map(paired.run, factors):
            samples.append(sample)
            if progress is not None:
                progress("calibrating and compensating", len(samples), len(STAGES))
    stages = [_stage(name, sample, samples[0]) for name, sample in zip(STAGES, samples, strict=True)]
    return Waterfall(tuple(stages), tuple(sorted(geometry)), len(chosen), paired.plan.robots, paired.plan.visits)


def _stage(name: str, sample: Sample, first: Sample) -> Stage:
    reduction = Estimate(0.0, 0.0, 0.0) if sample is first else quantile_drop((first.groups, first.sets), (sample.groups, sample.sets), LEVEL)
    return Stage(name, pooled_mean(sample.means), pooled_quantile(sample.groups, sample.sets, LEVEL, sample.largest), reduction)


def remaining(infos: Sequence[Column], stage: str, geometry: frozenset[str]) -> Floats:
    """Return 1 for each column that remains at a stage of `STAGES`, else 0 (column,); `geometry`: names of terms that ideal calibration finds."""
    calibrated = stage in {"calibrated", "both"}
    compensated = stage in {"load compensated", "both", "both, and each robot mapped"}
    mapped = stage == "both, and each robot mapped"
    removed = [
        (calibrated and info.name in geometry) or (compensated and info.level == "design") or (mapped and info.level == "robot") for info in infos
    ]
    return 1.0 - np.array(removed, dtype=float)


def geometry_of(arm: Arm) -> frozenset[str]:
    """Return the names of the terms that an ideal calibration of the geometry finds: drawn per robot, with a constant screw."""
    return frozenset(of.name for of in arm.terms if of.term.level == "robot" and not of.term.form.reads)
