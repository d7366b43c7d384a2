"""The table of what tuning the position servos would change."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.error_model.servo_tuning import MOST_POSES, tuned_rms
from lostmotion.reporting.sheet import Row, Section, in_one_unit, length, several

if TYPE_CHECKING:
    from lostmotion.analyses.accuracy.answer import Answer


def servo_sections(answer: Answer) -> tuple[Section, ...]:
    """Return the r.m.s. error that each tuning of the servos leaves; nothing for an arm whose
    servos do not droop.
    """
    found = tuned_rms(answer.arm, answer.poses.q, approach=answer.approach)
    if not found:
        return ()
    visited = several(min(len(answer.poses), MOST_POSES), "pose")
    cells = in_one_unit([length(each, samples=visited) for each in found.values()])
    return (
        Section(
            "servos",
            "Tuning of the position servos",
            ("r.m.s. error",),
            tuple(Row(name, (cell,)) for name, cell in zip(found, cells, strict=True)),
            "of all servos with a stiffness, each tuning by itself, at up to 256 of the poses; "
            "wind-up and play behind the servos stay",
        ),
    )
