"""The robot that was measured, with its tables, plots and files."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.calibrate.answer import CalibrationAnswer, ImportedErrors, PlannedPoses
from lostmotion.analyses.result import Result

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.calibration.ladder import Rung
    from lostmotion.calibration.robot import EstimatedError
    from lostmotion.calibration.validation import HeldOut
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.calibration import Calibration
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.spatial import Floats


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
        from lostmotion.analyses.calibrate.page.plots import calibrated_plots

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
        from lostmotion.analyses.calibrate.page.planned import planned_sheet

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
        from lostmotion.analyses.calibrate.page.imported import imported_sheet

        return imported_sheet(self)

    def files(self) -> dict[str, bytes]:
        """Return robot.toml, which every command takes as `--calibration`."""
        from lostmotion.io.calibration_writer import calibration_text

        text = calibration_text(self.calibration, self.sizes, poses=0, digest=self.digest)
        return {"robot.toml": text.encode()}
