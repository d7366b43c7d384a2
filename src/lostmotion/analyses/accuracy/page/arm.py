"""Tables of the arm of a study: workspace, joints, bending of links, and tuning of servos; and the
sheet of an arm without any error source, which has workspace and static torques alone.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.accuracy.page.headline import (
    class_facts,
    class_section,
    class_sentence,
)
from lostmotion.error_model.provenance import NOT_DESCRIBED, states
from lostmotion.error_model.servo_tuning import MOST_POSES, tuned_rms
from lostmotion.mechanism.load_causes import OUTBOARD_CAUSES
from lostmotion.mechanism.wind_up import wind_ups
from lostmotion.reporting.arm_sheet import with_arm
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.sheet import (
    Card,
    Cell,
    Lines,
    Row,
    Section,
    Sheet,
    in_one_unit,
    in_words,
    length,
    several,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.accuracy.answer import Answer
    from lostmotion.accuracy.drive_classes import ClassFigures
    from lostmotion.accuracy.workspace import Workspace
    from lostmotion.error_model.poses import Poses
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.holding_torques import HoldingTorque

_LOADS: Final = ("as the base stands", "worst over base tilts")
# What a joint does not have, and an error that is not described.
_NONE: Final = "-"
_IDEAL: Final = "ideal"
_MISSING: Final = (
    "the backlash, stiffness, hysteresis or transmission error of gearboxes, the play or "
    "stiffness of bearings, the errors of encoders, "
    "the sections or length tolerances of links"
)


def joints_section(answer: Answer, known: States) -> Section:
    """Return the largest load of each drive, its share of the rated one, the largest wind-up, and
    the largest deflection of the joint's link.
    """
    arm, q = answer.arm, answer.poses.q
    counted = several(len(q), "pose")
    kinds = {each.joint: each.states for each in known.joints}
    wound = {each.joint: abs(each.value) for each in wind_ups(arm, q)}
    bent = {each.joint: each.deflection for each in answer.bending}
    deflections = dict(
        zip(
            bent,
            in_one_unit([length(size, samples=counted) for size in bent.values()]),
            strict=True,
        )
    )
    rows = []
    for joint, held in zip(arm.driven, answer.worst_torques, strict=True):
        rated = None if joint.gearbox is None else joint.gearbox.rated_torque
        share = (
            Cell(abs(held.worst) / rated, "%", samples=counted) if rated else in_words("not stated")
        )
        of = kinds.get(joint.name, {})
        size = wound.get(joint.name, 0.0)
        turned = (
            Cell(size, "arcmin", samples=counted)
            if joint.type == "revolute"
            else length(size, samples=counted)
        )
        winding = turned if joint.name in wound else _of_state(of, "stiffness", counted)
        bending = (
            deflections[joint.name]
            if joint.name in deflections
            else _of_state(of, "link bending", counted)
        )
        assumed = [kind for kind in ("stiffness", "link bending") if of.get(kind) == "assumed"]
        note = _at(arm, answer.poses, held) + (
            f"; assumed: {', '.join(assumed)}" if assumed else ""
        )
        rows.append(Row(held.joint, (*_loads(held, counted), share, winding, bending), note))
    return Section(
        "torques",
        "Joints: static load, wind-up and bending",
        (*_LOADS, "of rated", "wind-up", "bending"),
        tuple(rows),
        "each the largest of the visited poses. The sign of a load is the drive's. Of rated: "
        "as the base stands. Wind-up: of nominal "
        "stiffness, without backlash. Bending: of its link, at the tip. ideal: not described, "
        "taken as rigid",
    )


def torques_section(arm: Arm, poses: Poses, worst: Sequence[HoldingTorque]) -> Section:
    """Return the largest static load of each drive, for an arm without error sources."""
    counted = several(len(poses), "pose")
    rows = tuple(Row(held.joint, _loads(held, counted), _at(arm, poses, held)) for held in worst)
    return Section(
        "torques",
        "Static torque of each drive",
        _LOADS,
        rows,
        "largest of the visited poses; its sign is the drive's",
    )


def _loads(held: HoldingTorque, counted: str) -> tuple[Cell, Cell]:
    return Cell(held.worst, held.unit, samples=counted), Cell(
        held.over_tilts, held.unit, samples=counted
    )


def _at(arm: Arm, poses: Poses, held: HoldingTorque) -> str:
    return (
        f"pose {held.worst_index}: {joint_values(arm, poses.q[held.worst_index])}; over tilts pose "
        f"{held.over_tilts_index}"
    )


def _of_state(kinds: Mapping[str, str], kind: str, counted: str) -> Cell:
    """Return the cell of a deflection that there is none of: of an ideal part, of one that the
    joint does not have, or of one without a load.
    """
    state = kinds.get(kind)
    return (
        in_words(_NONE)
        if state is None
        else in_words(_IDEAL)
        if state == _IDEAL
        else length(0.0, samples=counted)
    )


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


def workspace_section(space: Workspace) -> Section:
    """Return the section of the workspace."""
    counted = f"{several(len(space.points), 'pose')}, {space.law}"
    rows = [
        Row(
            "reach from the base",
            (length(space.reach, samples=counted),),
            "largest of the sample; the true reach is not smaller",
        ),
        Row("reach seen from above", (length(space.reach_horizontal, samples=counted),)),
        Row(
            "nearest to the base",
            (length(space.nearest, samples=counted),),
            "smallest of the sample",
        ),
    ]
    for k, name in enumerate("XYZ"):
        rows.append(Row(f"least {name}", (length(float(space.low[k]), samples=counted),)))
        rows.append(Row(f"largest {name}", (length(float(space.high[k]), samples=counted),)))
    if space.volume_high > 0:
        volume = Cell(space.volume, "m³", space.volume_low, space.volume_high, counted, "bracket")
        rows.append(
            Row(
                "volume",
                (volume,),
                (
                    "between the cells well inside and all cells visited; cell "
                    f"{space.cell * 1e3:.0f} mm"
                ),
            )
        )
    else:
        rows.append(
            Row(
                "volume",
                (Cell(0.0, "m³", samples=counted),),
                "the workspace is a line or a surface",
            )
        )
    return Section(
        "workspace",
        "Workspace",
        ("value",),
        tuple(rows),
        "joint limits only: no obstacle, floor or self-collision",
    )


def bending_sections(answer: Answer) -> list[Section]:
    """Return the bending of links, in total and by cause; no section for rigid links."""
    if not answer.bending:
        return []
    counted, exact = (
        f"the worst of {several(len(answer.poses), 'pose')}",
        f"exact sum over {several(len(answer.poses), 'pose')}",
    )
    rows = []
    for bent in answer.bending:
        shares = sum(share for _, _, share in bent.by_cause.values())
        within = f", l/{Cell(bent.length / bent.deflection, '1')}" if bent.deflection else ""
        at = f"pose {bent.deflection_index}{within}" + (
            f"; slope at pose {bent.slope_index}"
            if bent.slope_index != bent.deflection_index
            else ""
        )
        lines = [(bent.joint, (bent.deflection, bent.slope, shares), at)]
        lines += [
            (f"{bent.joint}, {OUTBOARD_CAUSES.get(cause, cause)}", parts, "")
            for cause, parts in bent.by_cause.items()
            if any(parts)
        ]
        rows += [
            Row(
                label,
                (
                    Cell(deflection, "µm", samples=counted),
                    Cell(slope, "arcmin", samples=counted),
                    Cell(share, "%", samples=exact),
                ),
                note,
            )
            for label, (deflection, slope, share), note in lines
        ]
    note = (
        "deflection of each link, named after its joint, at its tip, l away; then the "
        "contribution of each cause along the total; "
        "a negative contribution reduces the bending. Share: of the tool's mean-square error "
        "over all poses"
    )
    return [
        Section("bending", "Bending by cause", ("deflection", "slope", "share"), tuple(rows), note)
    ]


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
