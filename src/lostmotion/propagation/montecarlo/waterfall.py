"""Effect of calibration and compensation on the 95th percentile: the same robots and visits, without what each remedy removes.

Calibrated          every error drawn per robot is gone that is a constant screw in the frame it sits in: lengths, axis tilts and offsets, encoder
                    zeros, base tilt. That is what an ideal identification of the geometry finds. What it does not: harmonics (transmission error,
                    encoder eccentricity, runout), which a table per joint would have to map, and what follows the load (scatter of stiffness, the
                    amount of a play that a load holds to one side). What is the same in every robot is left to compensation, constant or not.
Load compensated    every design term is gone: the controller knows pose, load, nominal stiffness and nominal play exactly.
Mapped              all that is drawn per robot is gone, harmonics and what follows the load as well. What is left differs from visit to visit, the
                    amount of a free play included, and nothing takes it away.

Each remedy is ideal, so what is left is the least that a real one can leave.
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
    """What is left at one stage: mean and 95 % of the position error, and by how much the latter is below the first stage's; all in m."""

    name: str
    mean: Estimate
    q95: Estimate
    off: Estimate


@dataclass(frozen=True)
class Waterfall:
    """What is left stage by stage, in the order of `STAGES`, from a run of `poses` x `robots` x `visits`; `constant` names what geometry is."""

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

    By Monte Carlo on at most 512 of the poses, 512 robots and 4 visits, the same ones at every stage; intervals count robots and sets of poses.
    Arguments as `montecarlo.run`.
    """
    chosen = thinned(poses, _POSES)
    paired = Paired.of(arm, chosen, min(robots, _ROBOTS), visits, seed, approach)
    geometry = geometry_of(arm)
    kept = [left(paired.matrices[0].infos, name, geometry) for name in STAGES]
    samples: list[Sample] = []
    with ThreadPoolExecutor(threads) as pool:
        for sample in pool.map(paired.run, kept):
            samples.append(sample)
            if progress is not None:
                progress("calibrating and compensating", len(samples), len(STAGES))
    stages = [_stage(name, sample, samples[0]) for name, sample in zip(STAGES, samples, strict=True)]
    return Waterfall(tuple(stages), tuple(sorted(geometry)), len(chosen), paired.plan.robots, paired.plan.visits)


def _stage(name: str, sample: Sample, built: Sample) -> Stage:
    off = Estimate(0.0, 0.0, 0.0) if sample is built else quantile_drop((built.groups, built.sets), (sample.groups, sample.sets), LEVEL)
    return Stage(name, pooled_mean(sample.means), pooled_quantile(sample.groups, sample.sets, LEVEL, sample.largest), off)


def left(infos: Sequence[Column], stage: str, geometry: frozenset[str]) -> Floats:
    """Return which of these terms remain at a stage of `STAGES`: one or nothing (term,); `geometry` names those that an ideal calibration finds."""
    calibrated = stage in {"calibrated", "both"}
    compensated = stage in {"load compensated", "both", "both, and each robot mapped"}
    mapped = stage == "both, and each robot mapped"
    gone = [
        (calibrated and info.name in geometry) or (compensated and info.level == "design") or (mapped and info.level == "robot") for info in infos
    ]
    return 1.0 - np.array(gone, dtype=float)


def geometry_of(arm: Arm) -> frozenset[str]:
    """Return the names of the terms that an ideal calibration of the geometry finds: drawn per robot, and a screw that depends on nothing."""
    return frozenset(of.name for of in arm.terms if of.term.level == "robot" and not of.term.form.reads)
