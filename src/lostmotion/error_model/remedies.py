"""Remedies against errors, each as the columns of the pose matrix that it removes.

Calibrated          removes every error drawn per robot that is a constant screw in the frame of its
                    place: lengths, axis tilts and offsets, encoder zeros, base tilt. An ideal
                    identification of the geometry finds these. It does not find harmonics
                    (transmission error, encoder eccentricity, runout), which require a table per
                    joint, nor errors that depend on the load (scatter of stiffness, size of a play
                    that a load closes). Errors that are the same in every robot are removed by
                    compensation, also constant ones.
Load compensated    removes every design term: the controller knows pose, load, nominal stiffness
                    and nominal play exactly.
Mapped              removes every error drawn per robot, including harmonics and errors that depend
                    on the load.
Arriving from one   every joint arrives from the same side at every visit, as in the cycle of ISO
                    9283. Nothing is removed: the side of backlash that
side                no load closes, and of hysteresis, becomes a constant, which repeats.
Side known          the controller knows the side from which each joint arrives (or always arrives
                    from one), and compensates the nominal backlash and hysteresis of that side.
                    Their scatter over robots remains, and so does the scatter of friction.
Output encoders     remove every error of the gearboxes: backlash, wind-up, hysteresis, transmission
                    and lead error. Error of the encoder and dead band of the servo stay as large at
                    the output as they are. The encoder has no dead band of its own, which would
                    leave open a backlash that no load closes, up to its size.
Torque sensors      know the load of each drive: they remove its nominal wind-up and the side of
                    backlash that the load closes, a part of what load compensation removes. They do
                    not measure bending, the stiffness of a robot, or the last motion.

Calibrated with     removes the estimates of a calibrated robot: the controller corrects what was
the poses measured  measured of it. What remains uncertain of them stays.

What all of them together leave scatters from visit to visit: encoder, servo, friction, open
clearances. Only other parts reduce it.

Each remedy is ideal, so the remaining error is a lower limit for a real one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.few_poses import known_ends
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.robot_intervals import root_mean_square
from lostmotion.mechanism.state import blocks_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.columns import Column
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

STAGES: Final = (
    "as manufactured",
    "calibrated",
    "load compensated",
    "both",
    "both, and each robot mapped",
)
ONE_SIDE: Final = "arriving from one side"
SIDE_KNOWN: Final = "side known"
SIDE_AND_LOAD: Final = "side known, load compensated"
ALL_KNOWN: Final = "side known, both, and each robot mapped"
MEASURED: Final = "calibrated with the poses measured"
OUTPUT_ENCODERS: Final = "output encoders"
TORQUE_SENSORS: Final = "torque sensors"
# Remedies besides those that follow each other in `STAGES`.
OTHERS: Final = (ONE_SIDE, SIDE_KNOWN, SIDE_AND_LOAD, ALL_KNOWN, OUTPUT_ENCODERS, TORQUE_SENSORS)
EVERY_STAGE: Final = (*STAGES, *OTHERS)
_FROM_ONE_SIDE: Final = frozenset({ONE_SIDE, SIDE_KNOWN, SIDE_AND_LOAD, ALL_KNOWN})
_DRIVE: Final = "gearbox"


def stages_of(arm: Arm) -> tuple[str, ...]:
    """Return the stages of an arm: `EVERY_STAGE`, and `MEASURED` of a calibrated one."""
    return EVERY_STAGE if arm.calibration is None else (*EVERY_STAGE, MEASURED)


def remaining(
    infos: Sequence[Column],
    stage: str,
    geometry: frozenset[str],
    estimated: frozenset[str] = frozenset(),
) -> Floats:
    """Return 1 for each column that remains at a stage of `stages_of`, else 0 (column,);
    `geometry`: names of terms that ideal calibration finds; `estimated`: of those that were
    measured.

    The columns are those of joints that arrive as the stage requires (`approach_at_stage`).
    """
    calibrated = stage in {"calibrated", "both"}
    compensated = stage in {
        "load compensated",
        "both",
        "both, and each robot mapped",
        SIDE_AND_LOAD,
        ALL_KNOWN,
    }
    mapped = stage in {"both, and each robot mapped", ALL_KNOWN}
    removed = [
        (calibrated and info.name in geometry)
        or (stage == MEASURED and info.level == "design" and info.name in estimated)
        or (compensated and info.level == "design")
        or (mapped and info.level == "robot")
        or (stage == SIDE_KNOWN and info.level == "design" and info.of.term.sided)
        or (stage == OUTPUT_ENCODERS and info.of.kind == _DRIVE)
        or (
            stage == TORQUE_SENSORS
            and info.of.kind == _DRIVE
            and info.level == "design"
            and not info.of.term.sided
        )
        for info in infos
    ]
    return 1.0 - np.array(removed, dtype=float)


def approach_at_stage(stage: str, approach: float) -> float:
    """Return the sign of the joints' last motion at a stage of `EVERY_STAGE`: fixed where a remedy
    fixes or knows the side, else `approach`.
    """
    return approach or (1.0 if stage in _FROM_ONE_SIDE else 0.0)


def geometry_of(arm: Arm) -> frozenset[str]:
    """Return the names of the terms that an ideal calibration of the geometry finds: drawn per
    robot, with a constant screw.
    """
    return frozenset(
        of.name for of in arm.terms if of.term.level == "robot" and not of.term.form.reads
    )


def estimated_of(arm: Arm) -> frozenset[str]:
    """Return the names of the terms of which the robot of a calibrated arm was measured."""
    if arm.calibration is None:
        return frozenset()
    terms = (*arm.calibrated(None).terms, *arm.calibration.added)
    return frozenset(of.name for of in terms if arm.calibration.estimates(of))


def screws_at_stage(arm: Arm, q: Floats, stage: str, *, approach: float = 0.0) -> PoseMatrix:
    """Return the pose matrix of the errors that remain at a stage of `stages_of`; other arguments
    and errors as for `state_of` and `screws`.
    """
    matrix = pose_matrix(arm, q, approach=approach_at_stage(stage, approach))
    return (
        matrix
        if stage == STAGES[0]
        else matrix.scaled(remaining(matrix.infos, stage, geometry_of(arm), estimated_of(arm)))
    )


def remaining_rms(
    arm: Arm, poses: Poses, *, approach: float = 0.0, many: Poses | None = None
) -> dict[str, Estimate]:
    """Return the r.m.s. error (m) at each stage of `stages_of`, without sampling.

    The value is exact at the poses, to first order in the errors. The 95 % interval is the
    uncertainty due to their choice, as in `Budget.rms_interval`; `many`: poses by which to check
    whether these are too few (`many_poses`). Raises ValueError as `screws` does.
    """
    found = _root_mean_squares(arm, poses, approach)
    if many is None:
        return found
    beside = _root_mean_squares(arm, many, approach)
    return {stage: known_ends(here, here, beside[stage]) for stage, here in found.items()}


def _root_mean_squares(arm: Arm, poses: Poses, approach: float) -> dict[str, Estimate]:
    """Return the root mean square (m) over the poses by stage, with its interval."""
    geometry, estimated, stages = geometry_of(arm), estimated_of(arm), stages_of(arm)
    blocks: dict[str, list[Floats]] = {stage: [] for stage in stages}
    for _, here in blocks_of(poses.q):
        for stage, found in blocks.items():
            matrix = pose_matrix(arm, here, approach=approach_at_stage(stage, approach))
            left = remaining(matrix.infos, stage, geometry, estimated)
            found.append(matrix.mean_squares(left))
    at_poses = {stage: np.concatenate(found) for stage, found in blocks.items()}
    return {
        stage: root_mean_square(each.reshape(poses.replicates, -1).mean(axis=1), each)
        for stage, each in at_poses.items()
    }
