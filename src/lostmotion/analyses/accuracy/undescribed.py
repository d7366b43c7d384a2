"""An arm without any described error source: no accuracy, only workspace and holding torques."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.arguments import chosen_poses
from lostmotion.analyses.result import Result
from lostmotion.error_model.provenance import states

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from lostmotion.analyses.accuracy.drive_classes import ClassFigures
    from lostmotion.analyses.accuracy.workspace import Workspace
    from lostmotion.error_model.poses import PoseLaw, Poses
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.holding_torques import HoldingTorque
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Lines, Sheet


@dataclass(frozen=True, repr=False)
class Undescribed(Result):
    """The results for an arm without any error source: `summary()`, `report("out/")`,
    `result()`.
    """

    arm: Arm
    poses: Poses
    workspace: Workspace
    worst_torques: list[HoldingTorque]
    lines: Lines | None = None
    classes: tuple[ClassFigures, ...] = ()

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values."""
        return states(self.arm)

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.accuracy.tables.undescribed import (
            undescribed_sheet,
            with_first_answer,
        )

        return with_first_answer(
            undescribed_sheet(self.arm, self.poses, self.workspace, self.worst_torques, self.lines),
            self.classes,
        )

    @property
    def plots(self) -> Sequence[Plot]:
        """Return none: there is no error to draw."""
        return ()


def undescribed(
    arm: Arm,
    poses: int | Poses,
    pose_law: PoseLaw,
    seed: int,
    file: Path | None = None,
    sidecar: Path | None = None,
) -> Undescribed:
    """Return workspace and holding torques of an arm, with the lines that would describe it where
    it was read from a file.

    The figures by class of drive stand for the accuracy that the file cannot state: for drives by
    effort limits, else static loads, else the reach.
    """
    from lostmotion.analyses.accuracy.drive_classes import first_figures
    from lostmotion.analyses.accuracy.workspace import workspace
    from lostmotion.io.drive_loads import drive_loads
    from lostmotion.io.first_sidecar import first_sidecar
    from lostmotion.io.sidecar import sidecar_place
    from lostmotion.io.skeleton import Skeleton, skeleton
    from lostmotion.io.urdf import effort_limits
    from lostmotion.mechanism.holding_torques import holding_torques
    from lostmotion.reporting.sheet import Lines

    efforts = {} if file is None or file.suffix.lower() == ".toml" else effort_limits(file, sidecar)
    drives = drive_loads(arm, efforts)
    lines = None
    if file is not None:
        begun = (
            sidecar is not None or file.suffix.lower() == ".toml" or sidecar_place(file).exists()
        )
        found = (
            skeleton(arm, file, drives, sidecar)
            if begun
            else Skeleton(sidecar_place(file).name, first_sidecar(file))
        )
        begin = "" if begun else f"; `lostmotion new --from {file}` writes them"
        lines = Lines(f"Lines for {found.file}, to start from{begin}:", found.text)
    visited = chosen_poses(arm, poses, pose_law, seed)
    classes = first_figures(arm, drives.of, drives.loads, seed)
    return Undescribed(
        arm, visited, workspace(arm, seed=seed), holding_torques(arm, visited.q)[1], lines, classes
    )
