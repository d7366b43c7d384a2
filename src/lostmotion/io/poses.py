"""Poses as CSV: one column per moving joint, named with its unit ("A [deg],B [deg],C [mm]"), one
row per pose.
"""

from __future__ import annotations

import csv
import io
import math
import re
from array import array
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import listed, nearest, refuse_all
from lostmotion.io.text import number, numbers, read_text, refuse
from lostmotion.parts.joint import PrismaticJoint
from lostmotion.parts.moving_joint import LONGEST_JOINT_NAME
from lostmotion.unit_registry import UnitError
from lostmotion.units import read_quantity

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

MEGABYTES: Final = 200
_MOST_MISTAKES: Final = 20
_EXPECTED: Final = "a finite number in plain decimal notation"
_HEADING: Final = re.compile(r"^\s*(?P<name>.*?)\s*\[(?P<unit>[^\[\]]*)\]\s*$")
_LONGEST_HEADING: Final = LONGEST_JOINT_NAME + 20
# Share of a joint's range by which a value may pass a limit: rounding in the file, not a wish.
_ROUNDING: Final = 1e-9


def read_poses(path: str | Path, arm: Arm) -> Floats:
    """Return the poses (pose, joint) of a CSV, in rad and m, columns in the arm's order.

    Columns may stand in any order. Raises InputError with the first 20 mistakes, and a count of the
    others: unknown, missing or
    doubled columns, units of another kind, cells that are no finite number, values outside a
    joint's limits.
    """
    file = str(path)
    rows = csv.reader(io.StringIO(read_text(Path(path), MEGABYTES)))
    try:
        header = next(rows, [])
        factors, order = _columns(header, arm, file)
        values, lines, mistakes = _cells(rows, header, file)
    except csv.Error as error:
        refuse(file, f"line {rows.line_num}", str(error), "comma-separated numbers", _header(arm))
    if mistakes:
        refuse_all(mistakes, _MOST_MISTAKES)
    if not values:
        refuse(file, "", "no pose", "a header and at least one row", _header(arm))
    q: Floats = (np.array(values).reshape(-1, len(header)) * factors)[:, order]
    mistakes = outside_limits(q, lines, arm, file)
    if mistakes:
        refuse_all(mistakes, _MOST_MISTAKES)
    return q


def poses_text(arm: Arm, q: Floats) -> str:
    """Return poses (pose, joint), rad and m, as the CSV that `read_poses` reads, in degrees and
    millimetres.
    """
    slides = [isinstance(joint, PrismaticJoint) for joint in arm.driven]
    values = np.where(slides, 1e3 * q, np.degrees(q))
    rows = [",".join(f"{each:.7f}" for each in row) for row in values]
    return "\n".join([_header(arm), *rows]) + "\n"


def _header(arm: Arm) -> str:
    line = io.StringIO()
    csv.writer(line, lineterminator="").writerow(
        f"{joint.name} [{'mm' if isinstance(joint, PrismaticJoint) else 'deg'}]"
        for joint in arm.driven
    )
    return line.getvalue()


def _columns(header: list[str], arm: Arm, file: str) -> tuple[Floats, list[int]]:
    """Return the SI value of each column's unit, and which column holds each joint."""
    joints = {joint.name: joint for joint in arm.driven}
    mistakes: list[Problem] = []
    found: dict[str, int] = {}
    factors = np.ones(len(header))
    for column, heading in enumerate(header):
        if len(mistakes) > _MOST_MISTAKES:
            break
        key = f"line 1, column {column + 1}"
        match = _HEADING.match(heading) if len(heading) < _LONGEST_HEADING else None
        name = match["name"] if match else heading.strip()
        if name not in joints:
            near = nearest(name, joints)
            mistakes.append(
                Problem(
                    file,
                    key,
                    shown(heading),
                    f"a joint with its unit, one of {listed(joints)}",
                    _header(arm),
                    near,
                )
            )
        elif name in found:
            mistakes.append(
                Problem(file, key, f"joint '{name}' twice", "one column per joint", _header(arm))
            )
        else:
            found[name] = column
            si, unit = ("m", "mm") if isinstance(joints[name], PrismaticJoint) else ("rad", "deg")
            try:
                factors[column] = read_quantity(f"1 {match['unit'] if match else ''}", si).nominal
            except UnitError as error:
                mistakes.append(
                    Problem(
                        file,
                        key,
                        f"{shown(heading)} ({error})",
                        "the unit of the column in brackets",
                        f"{name} [{unit}]",
                    )
                )
    missing = [name for name in joints if name not in found]
    if missing:
        mistakes.append(
            Problem(
                file,
                "line 1",
                f"no column for {listed(missing)}",
                "one column per moving joint",
                _header(arm),
            )
        )
    if mistakes:
        refuse_all(mistakes, _MOST_MISTAKES)
    return factors, [found[name] for name in joints]


def _cells(
    rows: Iterable[list[str]], header: list[str], file: str
) -> tuple[array[float], array[int], list[Problem]]:
    """Return all values row by row, the line of each row, and what is no finite number."""
    values, lines = array("d"), array("q")
    mistakes: list[Problem] = []
    for line, row in enumerate(rows, 2):
        if not row:
            continue
        try:
            found = numbers(row)
        except ValueError:
            found = []
        if len(found) == len(header) and all(map(math.isfinite, found)):
            values.extend(found)
            lines.append(line)
            continue
        if len(row) != len(header):
            mistakes.append(
                Problem(
                    file,
                    f"line {line}",
                    f"{len(row)} cells",
                    f"{len(header)} cells, one per column of the header",
                    ",".join("0" * len(header)),
                )
            )
        else:
            mistakes += [
                Problem(file, f"line {line}, {shown(name)[1:-1]}", shown(cell), _EXPECTED, "12.5")
                for name, cell in zip(header, row, strict=True)
                if not math.isfinite(number(cell))
            ]
        if len(mistakes) > _MOST_MISTAKES:
            break
    return values, lines, mistakes


def outside_limits(q: Floats, lines: Sequence[int], arm: Arm, file: str) -> list[Problem]:
    """Return a mistake for each joint value (pose, joint), rad or m, that the joint's limits do not
    allow; `lines` of the poses in the file.
    """
    low, high = arm.limits.T
    slack = _ROUNDING * (high - low)
    mistakes = []
    for row, column in np.argwhere((q < low - slack) | (q > high + slack))[: _MOST_MISTAKES + 1]:
        joint = arm.driven[column]
        found, *limits = (
            _value_text(value, sliding=isinstance(joint, PrismaticJoint))
            for value in (q[row, column], *joint.limits)
        )
        mistakes.append(
            Problem(
                file,
                f"line {lines[row]}, joint {joint.name}",
                found,
                f"a value within its limits, {limits[0]} to {limits[1]}",
                limits[0],
            )
        )
    return mistakes


def _value_text(value: float, *, sliding: bool) -> str:
    return f"{value * 1e3:.6g} mm" if sliding else f"{math.degrees(value):.6g} deg"
