"""The results of a calibration: the robot that was measured, with its tables, plots and files;
poses to measure next, and a maker's calibration, each with its sheet.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.calibrate.answer import (
    CANDIDATES,
    CalibrationAnswer,
    ImportedErrors,
    PlannedPoses,
    size,
)
from lostmotion.analyses.result import Result
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.sheet import Card, Cell, Sheet, length, several, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.calibration.ladder import Rung
    from lostmotion.calibration.robot import EstimatedError
    from lostmotion.calibration.validation import HeldOut
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.calibration import Calibration
    from lostmotion.reporting.plot import Plot
    from lostmotion.spatial import Floats

_PLAN_WORDS: Final = (
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
_SHOWN_ERRORS: Final = 60


@dataclass(frozen=True, repr=False)
class Calibrated(CalibrationAnswer, Result):
    """The robot that was measured: every attribute of `CalibrationAnswer`."""

    @property
    def calibration(self) -> Calibration:
        """Return the estimates, as every question takes them."""
        return self.robot.calibration

    @property
    def arm(self) -> Arm:
        """Return the arm of this robot."""
        return self.robot.calibrated

    @property
    def terms(self) -> tuple[EstimatedError, ...]:
        """Return the estimated errors, the largest effect on the tool first."""
        return self.robot.errors

    @property
    def rungs(self) -> tuple[Rung, ...]:
        """Return the families of errors that were tried."""
        return self.robot.climb.rungs

    @property
    def held_out(self) -> HeldOut:
        """Return the measurements of excluded regions against predictions."""
        return self.robot.climb.kept.blocked

    @functools.cached_property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.calibrate.page import calibrated_sheet

        return calibrated_sheet(self)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.calibrate.page.remaining import calibrated_plots

        return calibrated_plots(self)

    def corrected(self, q: Floats) -> Floats:
        """Return commands (pose, joint), rad and m, by which this robot reaches the poses of the
        nominal arm at q (pose, joint), in the base frame as it was measured.
        """
        from lostmotion.calibration.correction import corrected

        robot = self.robot
        return corrected(robot.arm.calibrated(robot.calibrations.as_measured), q)[0]

    def files(self) -> dict[str, bytes]:
        """Return robot.toml, which every command takes as `--calibration`, joints.csv with the
        corrected commands of the measured poses, and of a serial chain its geometry:
        calibrated.urdf, and mdh.csv where the axes allow it.
        """
        from lostmotion.calibration.geometry import exact_chain, is_serial, mdh_of
        from lostmotion.io.calibration_writer import calibration_text
        from lostmotion.io.kinematics_writer import mdh_text, urdf_text_of
        from lostmotion.io.poses import poses_text

        text = calibration_text(
            self.calibration, self.robot.sizes, poses=len(self.visits), digest=self.visits.digest
        )
        joints = poses_text(self.arm, self.corrections[0])
        out = {"robot.toml": text.encode(), "joints.csv": joints.encode()}
        measured = self.robot.arm.calibrated(self.robot.calibrations.as_measured)
        if is_serial(measured):
            chain = exact_chain(measured)
            out["calibrated.urdf"] = urdf_text_of(measured.name, chain, measured.limits).encode()
            table = mdh_of(chain)
            if table is not None:
                out["mdh.csv"] = mdh_text(chain, table).encode()
        return out


@dataclass(frozen=True, repr=False)
class CalibrationPlan(PlannedPoses, Result):
    """Poses to measure next: every attribute of `PlannedPoses`."""

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        return planned_sheet(self)

    def files(self) -> dict[str, bytes]:
        """Return poses.csv, the joint values of the poses in the order of a tour."""
        from lostmotion.io.poses import poses_text

        return {"poses.csv": poses_text(self.arm, self.q).encode()}


@dataclass(frozen=True, repr=False)
class MakerCalibration(Result, ImportedErrors):
    """A maker's calibration: every attribute of `ImportedErrors`."""

    @property
    def arm(self) -> Arm:
        """Return the arm of this robot."""
        return self.robot.calibrated(self.calibration)

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        return imported_sheet(self)

    def files(self) -> dict[str, bytes]:
        """Return robot.toml, which every command takes as `--calibration`."""
        from lostmotion.io.calibration_writer import calibration_text

        text = calibration_text(self.calibration, self.sizes, poses=0, digest=self.digest)
        return {"robot.toml": text.encode()}


def planned_sheet(planned: PlannedPoses) -> Sheet:
    """Return the sheet of a plan."""
    radius, enough = planned.plan.radius, planned.plan.enough
    counted = several(len(planned.q), "pose")
    text = (
        f"After {counted} 95 % of the mean tool points are predicted within "
        f"{length(float(radius[-1]))} of the calibrated model, before within "
        f"{length(float(radius[0]))}."
    )
    if enough is not None:
        text += f" From {several(enough, 'pose')} on five more reduce it by less than 2 % each."
    shown = sorted({0, *np.unique(np.geomspace(1, len(radius) - 1, 12).round().astype(int))})
    return Sheet(
        name=planned.arm.name,
        subject="poses to measure",
        verdict=text,
        cards=(
            Card("predicted radius", str(length(float(radius[-1]))), f"after {counted}"),
            Card("before", str(length(float(radius[0]))), several(planned.measured, "pose")),
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
                [(f"O{k}", value) for k, value in enumerate(planned.plan.indices, 1)],
                "columns in prior deviations",
            ),
            table(
                "poses",
                "Poses in the order of a tour",
                (),
                [(f"pose {k}", joint_values(planned.arm, q)) for k, q in enumerate(planned.q, 1)],
            ),
        ),
        counts=f"{counted} of {CANDIDATES} candidates, noise {length(planned.noise)}",
        words=_PLAN_WORDS,
        source=f"{counted}, seed {planned.seed}. The same file, version and seed give the same "
        "bytes.",
        seed=planned.seed,
        facts={"arm": planned.arm.name},
    )


def imported_sheet(imported: ImportedErrors) -> Sheet:
    """Return the sheet of a maker's calibration."""
    robot = [each for each in imported.errors if not each.frame]
    turns = [abs(each.value) for each in robot if each.unit == "rad"]
    shifts = [abs(each.value) for each in robot if each.unit == "m"]
    most = Cell(max(turns, default=0.0), "mrad"), length(max(shifts, default=0.0))
    return Sheet(
        name=imported.robot.name,
        subject="maker's calibration",
        verdict=(
            f"The maker's calibration moves the tool by {length(imported.before)} on average: "
            "tilts "
            f"and zeros of at most {most[0]}, offsets of at most {most[1]}."
        ),
        cards=(
            Card("largest turn", str(most[0]), "of a seat"),
            Card("largest offset", str(most[1]), "of a seat"),
            Card("difference", str(length(imported.left)), "largest, to the maker's chain"),
        ),
        sections=(
            table(
                "estimates",
                "Errors by the maker's calibration, largest effect first",
                ("value", "effect at the tool"),
                [
                    (
                        short_name(each.name),
                        size(each, each.value),
                        length(each.effect),
                        "frame" if each.frame else "",
                    )
                    for each in imported.errors[:_SHOWN_ERRORS]
                ],
                "the smallest errors that lead to the maker's chain; r.m.s. motion of the tool",
            ),
        ),
        source=f"{imported.file.name}, {imported.digest}",
        facts={"arm": imported.robot.name},
    )
