"""Correct the joint values of poses, or of a program, for a machine: the corrected values, and what
they leave where the arm then stands.
"""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Protocol

from lostmotion.analyses.arguments import (
    ArmArgument,
    CalibrationArgument,
    SidecarArgument,
    out_argument,
    path_of,
)
from lostmotion.analyses.quantities import Amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import Problem
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_NANOMETRE = 1e-9
_PROGRAMS = (".gcode", ".gco", ".g", ".nc", ".ngc", ".tap")


def _length(value: float) -> str:
    return f"{1e3 * value:.3g} mm" if value >= 1e-4 else f"{1e6 * value:.3g} µm"  # noqa: PLR2004 - µm below 0.1 mm


def _in_words(done: dict[str, Any]) -> str:
    """Return what was changed, and what is left."""
    from lostmotion.reporting.sheet import several

    def lengths(key: str) -> str:
        values = (done[key][name] for name in ("median", "worst"))
        return " and ".join("below 1 nm" if each < _NANOMETRE else _length(each) for each in values)

    def change(joint: str) -> str:
        size = done["changed"][joint]
        return _length(size) if joint in done["slides"] else f"{math.degrees(size):.3f} deg"

    changed = ", ".join(f"{joint} {change(joint)}" for joint in done["changed"])
    lines = [
        f"{several(done['rows'], 'pose')} corrected. Largest change: {changed}.",
        f"Expected error of the tool, median and worst pose: {lengths('without')}",
        f"  with the corrected values: {lengths('left')}",
        "What differs from robot to robot and from visit to visit stays.",
    ]
    if done["reduced"]:
        lines.append(
            f"note: {several(done['reduced'], 'pose')} at a joint limit or near a singular pose "
            "with less correction than elsewhere"
        )
    if done["unknown"]:
        lines.append(
            f"note: {several(done['unknown'], 'move')} before the position is known in all axes "
            "not corrected"
        )
    return "\n".join([*lines, f"File: {done['file']}"])


class _Wanted(Protocol):
    """Wanted poses: joint values (pose, joint), signs of the last motions (pose, joint; NaN where
    not stated), and file and line of each.
    """

    q: Floats
    side: Floats
    where: tuple[tuple[str, str], ...]


def _corrected(
    arm: Arm,
    given: _Wanted,
    *,
    passes: int,
    whole_pose: bool,
    largest_step: float | None,
    along_path: bool,
) -> tuple[Floats, dict[str, Any]]:
    """Return the joint values to send (pose, joint), rad or m, and what was changed and what is
    left, in SI.

    along_path  whether the last motions that are not stated follow from the order of the poses

    Raises InputError for loads that the parts do not bear.
    """
    import numpy as np

    from lostmotion.controller_model.compensation import LARGEST_STEP
    from lostmotion.controller_model.controller import OK, SINGULAR, Controller
    from lostmotion.controller_model.lowering import tables_of
    from lostmotion.controller_model.remainder import reached
    from lostmotion.controller_model.validity import validity_of
    from lostmotion.error_model.arrival import last_motion
    from lostmotion.io.limits import MOST_MISTAKES, refuse_all

    unstated = np.nan if along_path else 0.0
    side, _ = last_motion(given.q, np.where(np.isnan(given.side), unstated, given.side))
    model = Controller(tables_of(arm, validity_of(arm)))
    found = model.compensate(
        given.q,
        side=side,
        passes=2 if passes > 1 else 1,
        whole_pose=whole_pose,
        largest_step=LARGEST_STEP if largest_step is None else largest_step,
    )
    refused = np.flatnonzero(~np.isin(found.status, [OK, SINGULAR]))
    if len(refused):
        expected = "a load within the tables of its parts; a smaller payload"
        refuse_all(
            [
                Problem(
                    file, line, "a load that a bearing does not bear", expected, 'mass = "2 kg"'
                )
                for file, line in (given.where[row] for row in refused[: MOST_MISTAKES + 1])
            ]
        )
    wanted = found.prediction.point
    if side.any():  # the equilibrium of the parts knows no last motions, that of the tables does
        without, left = (
            np.linalg.norm(each[:, 3:], axis=1) for each in (found.prediction.screw, found.left)
        )
    else:
        without, left = (
            np.linalg.norm(reached(arm, each) - wanted, axis=1) for each in (given.q, found.command)
        )
    changes = np.abs(found.command - given.q).max(axis=0)
    return found.command, {
        "rows": len(wanted),
        "changed": {
            joint.name: float(change) for joint, change in zip(arm.driven, changes, strict=True)
        },
        "slides": [each.name for each in arm.driven if not each.twist[:3].any()],
        "without": _summary(without),
        "left": _summary(left),
        "reduced": int(np.count_nonzero(found.status == SINGULAR)),
    }


def _summary(errors: Floats) -> dict[str, float]:
    import numpy as np

    return {"median": float(np.median(errors)), "worst": float(errors.max())}


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
    from lostmotion.error_model.provenance import refuse_undescribed
    from lostmotion.io.machine_files import MoveProgram, PoseTable
    from lostmotion.reporting.folder import write_file

    refuse_undescribed(asked.arm)
    program = asked.poses.suffix.lower() in _PROGRAMS
    given = (MoveProgram if program else PoseTable)(asked.poses, asked.arm)
    command, found = _corrected(
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
