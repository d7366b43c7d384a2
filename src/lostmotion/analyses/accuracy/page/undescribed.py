"""The figures of an arm without any error source: workspace and static torques, and no accuracy."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.accuracy.page.arm import torques_section, workspace_section
from lostmotion.analyses.accuracy.page.drive_classes import (
    class_facts,
    class_section,
    class_sentence,
)
from lostmotion.error_model.provenance import NOT_DESCRIBED, states
from lostmotion.reporting.arm_sheet import with_arm
from lostmotion.reporting.sheet import Card, Lines, Sheet, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.accuracy.drive_classes import ClassFigures
    from lostmotion.accuracy.workspace import Workspace
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.holding_torques import HoldingTorque

_MISSING: Final = (
    "the backlash, stiffness, hysteresis or transmission error of gearboxes, the play or "
    "stiffness of bearings, the errors of encoders, "
    "the sections or length tolerances of links"
)


def undescribed_sheet(
    arm: Arm,
    poses: Poses,
    space: Workspace,
    worst: Sequence[HoldingTorque],
    lines: Lines | None = None,
) -> Sheet:
    """Return the sheet of an arm without any error source: workspace, holding torques, states of
    the joints, and `lines` to describe them by.
    """
    reach = workspace_section(space)
    return with_arm(
        Sheet(
            subject="workspace and statics",
            counts=several(len(poses), "pose"),
            verdict=f"{NOT_DESCRIBED[0].upper()}{NOT_DESCRIBED[1:]}. What is missing: {_MISSING}.",
            cards=(
                Card("reach from the base", str(reach.rows[0].cells[0]), "largest of the sample"),
            ),
            sections=(reach, torques_section(arm, poses, worst)),
            source=(
                f"{several(len(poses), 'pose')} ({poses.law}). The same arm and version give the "
                "same bytes."
            ),
            facts={"poses": {"count": len(poses), "law": poses.law}},
            lines=lines,
        ),
        arm,
        states(arm),
        poses=poses,
    )


def with_first_answer(sheet: Sheet, figures: Sequence[ClassFigures]) -> Sheet:
    """Return the sheet of an arm that describes no error source, with the figures by class of drive
    in place of a prediction.
    """
    if not figures:
        return sheet
    return replace(
        sheet,
        verdict=(
            f"{class_sentence(figures)} The file itself describes no error source. What is "
            f"missing: {_MISSING}."
        ),
        sections=(class_section(figures), *sheet.sections),
        facts={**sheet.facts, **class_facts(figures)},
    )
