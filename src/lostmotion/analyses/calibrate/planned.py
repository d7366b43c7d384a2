"""Poses to measure next, with the accuracy that they will lead to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.fit import Asked, fit
from lostmotion.calibration.model import model_of
from lostmotion.calibration.plan import plan
from lostmotion.calibration.robot import measured_in_base
from lostmotion.calibration.terms import Deviations, added_terms, is_frame
from lostmotion.controller_model.percentile import percentile95
from lostmotion.error_model.pose_selection import poses_in_zone
from lostmotion.error_model.poses import sample_poses
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.sheet import Card, Sheet, length, several, table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.calibration.model import RobotModel
    from lostmotion.calibration.plan import PosePlan
    from lostmotion.calibration.robot import Robot
    from lostmotion.io.measured.calibration_visits import CalibrationVisits
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_CANDIDATES: Final = 2000
_WORKING: Final = 256
# Poses that a calibration proposes to measure next, and the candidates for them.
NEXT_POSES: Final = 5
_NEXT: Final = 400
# Prior variances by which poses are chosen, over those of the estimates: a wide prior is robust.
_WIDE: Final = 4.0
_WORDS: Final = (
    (
        "predicted radius",
        (
            "95 % of the mean tool points are within it of where the calibrated model puts them, "
            "mean over the working poses; scatter between visits is not included."
        ),
    ),
    (
        "O1 to O5",
        (
            "observability indices: geometric mean of the singular values, smallest over largest, "
            "smallest, its square over the largest, one over the sum of inverses."
        ),
    ),
)


@dataclass(frozen=True, repr=False)
class PlannedPoses:
    """Poses to measure next.

    q         (pose, joint) joint values, rad or m
    plan      predicted radius after each number of poses, and observability
    measured  number of poses that were measured already
    """

    arm: Arm
    q: Floats
    plan: PosePlan
    measured: int
    noise: float
    seed: int


def planned_poses(
    arm: Arm,
    count: int,
    zone: Mapping[str, tuple[float, float]] | None,
    visits: CalibrationVisits | None,
    noise: float,
    seed: int,
) -> PlannedPoses:
    """Return the poses that most reduce the mean predicted variance over the working poses.

    zone    limits of the tool point, by axis; None: the whole workspace
    visits  what was measured already, with the deviations that its file states; None: nothing
    noise   standard deviation of a measured coordinate, m
    """
    bare = arm.calibrated(None)
    sizes = (None if visits is None else visits.sizes) or Deviations()
    added = added_terms(bare, sizes)
    every = sample_poses(bare, _CANDIDATES, "sobol", seed).q[:_CANDIDATES]
    working = every[:_WORKING]
    if zone is not None:
        working = poses_in_zone(bare, _WORKING, zone, seed).poses.q[:_WORKING]
    candidates, wanted = model_of(bare, every, added), model_of(bare, working, added)
    before = np.diag([1.0 if is_frame(owner) else _WIDE for owner in wanted.owners])
    if visits is not None:
        before = _measured(bare, visits, sizes, noise, wanted)
    found = plan(candidates, wanted, count, before, noise=noise)
    done = 0 if visits is None else len(visits)
    return PlannedPoses(arm, every[found.chosen], found, done, noise, seed)


def _measured(
    arm: Arm, visits: CalibrationVisits, sizes: Deviations, noise: float, wanted: RobotModel
) -> Floats:
    """Return the covariance of the estimates after what was measured, with a wide prior."""
    instrument = measured_in_base(arm, visits, sizes, noise).instrument
    model = model_of(arm, visits.q, added_terms(arm, sizes))
    wide = np.array([1.0 if is_frame(owner) else _WIDE for owner in model.owners])
    own = len(instrument.unknowns)
    asked = Asked(np.concatenate([wide, np.ones(own)]), noise)
    covariance = fit(model, instrument, asked).covariance
    rows = model.numbers(wanted.streams)
    return np.asarray(covariance[np.ix_(rows, rows)])


def next_poses(robot: Robot, q: Floats, seed: int) -> tuple[Floats, Floats]:
    """Return the poses (pose, joint) within the measured joint ranges that would most improve a
    calibration, and the mean 95 % radius of the tool, m, after each number of them.

    q  (pose, joint) the measured poses
    """
    low, high = q.min(axis=0), q.max(axis=0)
    every = low + np.random.default_rng(seed).random((_NEXT, q.shape[1])) * (high - low)
    best, streams = robot.climb.kept.fit, robot.climb.model.streams
    kept = np.flatnonzero(best.variances[: len(streams)])
    model = model_of(robot.arm, every, robot.calibration.added)
    model = model.keeping(model.numbers([streams[k] for k in kept]))
    covariance = robot.inflation * best.covariance[np.ix_(kept, kept)]
    found = plan(model, model.rows(np.arange(_NEXT // 4)), NEXT_POSES, covariance, noise=best.noise)
    return every[found.chosen], found.radius


def corrected_radius(robot: Robot, q: Floats) -> Floats:
    """Return the 95 % radius of the tool (pose,), m, at q (pose, joint) where the estimates are
    corrected: what remains uncertain of them, and the scatter between visits.
    """
    best, streams = robot.climb.kept.fit, robot.climb.model.streams
    model = model_of(robot.arm, q, robot.calibration.added)
    kept = np.flatnonzero(best.variances[: len(streams)])
    columns = model.columns[:, 3:, model.numbers([streams[k] for k in kept])]
    covariance = robot.inflation * best.covariance[np.ix_(kept, kept)]
    spread = columns @ covariance @ columns.transpose(0, 2, 1) + model.scatter[:, 3:, 3:]
    return percentile95(np.zeros((len(q), 3)), spread)


def planned_sheet(found: PlannedPoses) -> Sheet:
    """Return the sheet of a plan."""
    radius, enough = found.plan.radius, found.plan.enough
    counted = several(len(found.q), "pose")
    text = (
        f"After {counted} 95 % of the mean tool points are predicted within "
        f"{length(float(radius[-1]))} of the calibrated model, before within "
        f"{length(float(radius[0]))}."
    )
    if enough is not None:
        text += f" From {several(enough, 'pose')} on five more reduce it by less than 2 % each."
    shown = sorted({0, *np.unique(np.geomspace(1, len(radius) - 1, 12).round().astype(int))})
    return Sheet(
        name=found.arm.name,
        subject="poses to measure",
        verdict=text,
        cards=(
            Card("predicted radius", str(length(float(radius[-1]))), f"after {counted}"),
            Card("before", str(length(float(radius[0]))), several(found.measured, "pose")),
        ),
        sections=(
            table(
                "radius",
                "Predicted radius by the number of poses",
                ("95 % radius",),
                [(several(int(k), "pose"), length(float(radius[k]))) for k in shown],
            ),
            table(
                "observability",
                "Observability of the chosen poses",
                ("value",),
                [(f"O{k}", value) for k, value in enumerate(found.plan.indices, 1)],
                "columns in prior deviations",
            ),
            table(
                "poses",
                "Poses in the order of a tour",
                (),
                [(f"pose {k}", joint_values(found.arm, q)) for k, q in enumerate(found.q, 1)],
            ),
        ),
        counts=f"{counted} of {_CANDIDATES} candidates, noise {length(found.noise)}",
        words=_WORDS,
        source=f"{counted}, seed {found.seed}. The same file, version and seed give the same "
        "bytes.",
        seed=found.seed,
        facts={"arm": found.arm.name},
    )
