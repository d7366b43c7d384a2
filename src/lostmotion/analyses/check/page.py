"""Sheets of a check: the joints with the static loads of their drives, and what is stated, assumed
and ideal.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.error_model.overload import overloaded
from lostmotion.error_model.provenance import NOT_DESCRIBED, part_states, states
from lostmotion.io.repairs import REPAIRED
from lostmotion.mechanism.even_poses import even_poses
from lostmotion.mechanism.loops import loops_of
from lostmotion.mechanism.state import state_of
from lostmotion.parts.joint import has_drive
from lostmotion.reporting.arm_summary import about_arm, passive_joints
from lostmotion.reporting.provenance import (
    caveats,
    provenance_facts,
    provenance_sections,
    with_inputs,
)
from lostmotion.reporting.sheet import Card, Cell, Sheet, length, several, table
from lostmotion.reporting.warnings import overload_warnings

if TYPE_CHECKING:
    from lostmotion.error_model.provenance import States
    from lostmotion.io.part_file import OnePart
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import Joint
    from lostmotion.reporting.sheet import Section
    from lostmotion.spatial import Floats

# Ranges from here on are printed in metres, m.
_LONG: Final = 10.0


def arm_sheet(arm: Arm, file: str, sidecar: str = "") -> Sheet:
    """Return what is known of an arm, with the largest static load of each drive spread evenly over
    the joint ranges.
    """
    known, passive = states(arm), passive_joints(arm)
    q = even_poses(arm)
    state = state_of(arm, q)
    held = np.abs(state.torques).max(axis=0)
    reach = float(np.linalg.norm(state.frames[-1, :, :3, 3], axis=1).max())
    poses = several(len(q), "pose")
    return Sheet(
        name=arm.name,
        subject="check of the description",
        about=about_arm(arm),
        verdict=_verdict(known, f"{file} --sidecar {sidecar}" if sidecar else file),
        cards=(
            Card("driven joints", str(len(arm.driven)), f"{passive} passive" if passive else ""),
            Card("mass", str(Cell(arm.mass, "kg"))),
            Card("reach from the base", str(length(reach)), f"largest of {poses}"),
            Card("assumed values", str(known.assumed_count)),
        ),
        sections=(
            _joints(arm, held, len(q)),
            *_loops(arm),
            *_centres(arm),
            *provenance_sections(known),
        ),
        brief=_brief(arm),
        warnings=(*arm.warnings, *overload_warnings(overloaded(arm, held, len(q)))),
        notes=arm.remarks,
        source=f"static loads at {_evenly(len(q))}",
        facts={
            "arm": arm.name,
            "file": file,
            "warnings": list(arm.warnings),
            **provenance_facts(known),
        },
    )


def part_sheet(read: OnePart[Any], kind: str) -> Sheet:
    """Return what is known of a gearbox or a bearing by itself."""
    known = part_states(read.part, kind)
    ideal = [name for name, state in known.items() if state == "ideal"]
    sheet = Sheet(
        name=read.name,
        subject="check of the description",
        verdict="No mistake was found in the file."
        + (f" Nothing describes its {', '.join(ideal)}, taken as perfect." if ideal else ""),
        sections=(
            table(
                "states",
                "What is known",
                [*known],
                [(read.name, *known.values())],
                "ideal: nothing is described, taken as perfect",
            ),
        ),
        notes=read.notes,
        facts={kind: read.name, "known": dict(known)},
    )
    return with_inputs(sheet, read.part, kind)


def _verdict(known: States, file: str) -> str:
    if not known.described:
        return (
            f"No mistake was found in the file, and {NOT_DESCRIBED}. What is missing: "
            "gearboxes, bearings, encoders, sections or tolerances. "
            f"`lostmotion study {file}` estimates it by class of drive, and prints lines to start "
            "from."
        )
    return " ".join(
        [
            "No mistake was found in the file.",
            *caveats(known),
            f"`lostmotion study {file}` predicts the accuracy.",
        ]
    )


def _evenly(poses: int) -> str:
    return (
        f"{several(poses, 'pose')} spread evenly over the joint ranges, with all combinations of "
        "their ends"
    )


def _joints(arm: Arm, held: Floats, poses: int) -> Section:
    load = dict(zip((joint.name for joint in arm.driven), held, strict=True))
    return table(
        "joints",
        "Joints",
        ["range", "link", "mass", "static load", "rated"],
        (_row(joint, load.get(joint.name)) for joint in arm.joints),
        f"range of motion; mass of joint and link; static load: largest of {_evenly(poses)}; base "
        "level as stated",
    )


def _loops(arm: Arm) -> tuple[Section, ...]:
    """Return the table of the loops of a closed chain; nothing for an arm without closures."""
    rows = [
        (
            " = ".join(loop.joins),
            f"over-constrained {several(loop.redundant, 'time')}"
            if loop.redundant
            else "exactly constrained",
            ", ".join(loop.passive),
        )
        for loop in loops_of(arm.tree)
    ]
    note = (
        "one for each closure, in their order; an over-constrained loop needs stiffness of its "
        "parts to share what they misfit"
    )
    title = "Loops"
    return (table("loops", title, ["constraints", "passive joints"], rows, note),) if rows else ()


def _brief(arm: Arm) -> tuple[tuple[str, str], ...]:
    """Return where the masses of tool and payload lie, and what a sidecar repaired."""
    lines = [
        (name, f"{mass} at {flange} from the flange, {tool} from the tool point{stated}.")
        for name, mass, stated, flange, tool in _masses(arm)
    ]
    return (*lines, *(("repaired", f"{note}.") for note in arm.notes if REPAIRED in note))


def _centres(arm: Arm) -> tuple[Section, ...]:
    """Return the table of the centres of mass of tool and payload; nothing where neither has a
    mass.
    """
    rows = [
        (f"{name}, {mass}{stated}", flange, tool)
        for name, mass, stated, flange, tool in _masses(arm)
    ]
    place = arm.tool.after or f"{arm.joints[-1].name}.tip"
    note = (
        f"x, y, z; from the flange ({place}) in its axes, and from the tool point in the axes of "
        "the tool frame"
    )
    title = "Centres of mass of tool and payload"
    columns = ["from the flange", "from the tool point"]
    return (table("centres", title, columns, rows, note),) if rows else ()


def _masses(arm: Arm) -> list[tuple[str, str, str, str, str]]:
    """Return name, mass, a remark, and the centre of mass from the flange and from the tool point,
    each in its own axes.
    """
    tool, payload = arm.tool, arm.payload
    pose = tool.frame.pose
    unstated = (
        "" if tool.centre_of_mass is not None else " (centre not stated: taken at the tool point)"
    )
    named = (
        ("tool", tool.mass, unstated, tool.mass_centre),
        ("payload", payload.mass, "", np.array(payload.centre_of_mass)),
    )
    return [
        (
            name,
            str(Cell(mass, "kg")),
            stated,
            _point(pose[:3, :3] @ centre + pose[:3, 3]),
            _point(centre),
        )
        for name, mass, stated, centre in named
        if mass
    ]


def _point(xyz: Floats) -> str:
    return f"({', '.join(f'{1e3 * value + 0.0:.4g}' for value in np.round(xyz, 9))}) mm"


def _row(joint: Joint, load: float | None) -> tuple[str, *tuple[Cell | str, ...]]:
    link = length(joint.link.reach, stated=True) if joint.link.reach else "-"
    mass = Cell(joint.total_mass + joint.link.total_mass, "kg")
    if not has_drive(joint) or load is None:
        return joint.name, "fixed" if joint.type == "fixed" else "passive", link, mass, "-", "-"
    low, high = joint.limits
    scale, unit = (180 / math.pi, "°") if joint.type == "revolute" else (1e3, " mm")
    if joint.type != "revolute" and max(abs(low), abs(high)) >= _LONG:
        scale, unit = 1.0, " m"
    rated = joint.gearbox.rated_torque if joint.gearbox is not None else None
    limit = "-" if rated is None else Cell(float(rated), joint.load_unit, stated=True)
    between = f"{scale * low:.4g} … {scale * high:.4g}{unit}"
    return joint.name, between, link, mass, Cell(load, joint.load_unit), limit
