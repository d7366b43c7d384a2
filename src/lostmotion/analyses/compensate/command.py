"""Correct the joint values of poses, or of a program, for a machine."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from lostmotion.analyses.arguments import (
    ArmArgument,
    CalibrationArgument,
    SidecarArgument,
    out_argument,
    path_of,
)
from lostmotion.analyses.quantities import Amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from pathlib import Path

_NANOMETRE = 1e-9
_PROGRAMS = (".gcode", ".gco", ".g", ".nc", ".ngc", ".tap")


def _length(value: float) -> str:
    return f"{1e3 * value:.3g} mm" if value >= 1e-4 else f"{1e6 * value:.3g} µm"  # noqa: PLR2004 - µm below 0.1 mm


def _in_words(found: dict[str, Any]) -> str:
    """Return what was changed, and what is left."""
    from lostmotion.reporting.sheet import several

    def lengths(key: str) -> str:
        values = (found[key][name] for name in ("median", "worst"))
        return " and ".join("below 1 nm" if each < _NANOMETRE else _length(each) for each in values)

    def change(joint: str) -> str:
        size = found["changed"][joint]
        return _length(size) if joint in found["slides"] else f"{math.degrees(size):.3f} deg"

    changed = ", ".join(f"{joint} {change(joint)}" for joint in found["changed"])
    lines = [
        f"{several(found['rows'], 'pose')} corrected. Largest change: {changed}.",
        f"Expected error of the tool, median and worst pose: {lengths('without')}",
        f"  with the corrected values: {lengths('left')}",
        "What differs from robot to robot and from visit to visit stays.",
    ]
    if found["reduced"]:
        lines.append(
            f"note: {several(found['reduced'], 'pose')} at a joint limit or near a singular pose "
            "with less correction than elsewhere"
        )
    if found["unknown"]:
        lines.append(
            f"note: {several(found['unknown'], 'move')} before the position is known in all axes "
            "not corrected"
        )
    return "\n".join([*lines, f"File: {found['file']}"])


@question(folder=None, in_words=_in_words)
def compensate(
    arm: ArmArgument,
    *,
    poses: Annotated[
        "str | Path",
        Argument(
            "CSV of joint values or poses of the tool, or a program in G-code.",
            partial(path_of, example="poses.csv"),
            metavar="FILE",
        ),
    ],
    out: Annotated["str | Path", out_argument("The corrected file.", "corrected.csv", "FILE")],
    passes: Annotated[
        int,
        Argument(
            "1: exact where drives alone wind up; 2: links and bearings too.", least=1, most=2
        ),
    ] = 2,
    whole_pose: Annotated[bool, Argument("Correct the rotation of the tool as well.")] = False,
    largest_step: Annotated[
        Amount | None,
        Argument(
            "Largest step of a joint near singular poses, for what links and bearings move. "
            "Default: 10 mrad.",
            Quantity("rad", "0.5 deg", above=0),
        ),
    ] = None,
    path: Annotated[
        bool,
        Argument(
            "The rows of a CSV are a path: the side of every play follows from its order. A "
            "program always is one."
        ),
    ] = False,
    sidecar: SidecarArgument = None,
    calibration: CalibrationArgument = None,
    force: Annotated[bool, Argument("Replace an earlier file.")] = False,
) -> dict[str, Any]:
    """Write joint values with which the tool stands, under the loads of the arm, where the wanted
    ones have it without errors.

    A CSV has joint values ("A [deg]") or poses of the tool ("x [mm]", "roll [deg]"), and columns
    "approach" as a task; the corrected one has joint values. Of a program the ends of straight
    moves are corrected. A joint may be commanded beyond the wanted value, never beyond its limits.

    Raises
    ------
    InputError
        With every mistake in the arguments and the files, for a pose out of reach, and for a load
        that the parts do not bear.
    OutputExistsError
        Where the file exists, unless `force` is set.

    """
    asked = read_arguments(compensate, locals())
    from lostmotion.analyses.compensate.correction import corrected
    from lostmotion.error_model.provenance import refuse_undescribed
    from lostmotion.io.machine_files import MoveProgram, PoseTable
    from lostmotion.reporting.folder import write_file

    refuse_undescribed(asked.arm)
    program = asked.poses.suffix.lower() in _PROGRAMS
    given = (MoveProgram if program else PoseTable)(asked.poses, asked.arm)
    command, found = corrected(
        asked.arm,
        given,
        passes=asked.passes,
        whole_pose=asked.whole_pose,
        largest_step=asked.largest_step,
        along_path=asked.path or program,
    )
    file = write_file(given.text(command).encode(), asked.out, force=asked.force)
    unknown = given.unknown if isinstance(given, MoveProgram) else 0
    return {"file": str(file), **found, "unknown": unknown}
