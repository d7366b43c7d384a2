"""Rows of a task as CSV: joint values ("A [deg]", ...) or poses of the tool ("x [mm]", "y [mm]", "z
[mm]", and "roll [deg]", "pitch [deg]", "yaw [deg]" about the fixed axes).

Further columns: "feature" names what a place belongs to; "approach" is up, down or random for all
joints, "approach A" for one, empty where the path decides; "force x [N]", "force y [N]", "force z
[N]" and "force along [N]" act on the tool.
"""

from __future__ import annotations

import csv
import io
import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import listed, nearest, refuse_all
from lostmotion.io.poses import outside_limits
from lostmotion.io.text import number, read_text, refuse
from lostmotion.parts.joint import PrismaticJoint
from lostmotion.unit_registry import UnitError
from lostmotion.units import read_quantity

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_MEGABYTES: Final = 20
_MOST_MISTAKES: Final = 20
_HEADING: Final = re.compile(r"^\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?\s*$")
_POSITION: Final = ("x", "y", "z")
_ANGLES: Final = ("roll", "pitch", "yaw")
_FORCES: Final = ("force x", "force y", "force z", "force along")
_SIGNS: Final = {"up": 1.0, "down": -1.0, "random": 0.0, "": math.nan}
_APPROACH: Final = "approach"
_FEATURE: Final = "feature"


@dataclass(frozen=True)
class PathRows:
    """Rows of a CSV, in SI.

    q         (row, joint), None where poses are stated
    xyz, rpy  (row, 3) pose of the tool; None where joint values are stated, or no orientation
    feature   name of what each row belongs to; empty where the file has no such column
    approach  (row, joint) as `Task.approach`
    force     (row, 4) N, along x, y, z and along the path; None without such columns
    where     file and line of each row
    """

    q: Floats | None
    xyz: Floats | None
    rpy: Floats | None
    feature: tuple[str, ...]
    approach: Floats
    force: Floats | None
    where: tuple[tuple[str, str], ...]


def read_tool_path(path: Path, arm: Arm) -> PathRows:
    """Return the rows of a CSV. Raises InputError with the first 20 mistakes, each with its line:
    unknown, missing or doubled columns, units of another kind, cells that are no finite number,
    and values outside a joint's limits.
    """
    file = str(path)
    rows = csv.reader(io.StringIO(read_text(path, _MEGABYTES)))
    try:
        header, body = next(rows, []), [(rows.line_num, row) for row in rows if row]
    except csv.Error as error:
        refuse(file, f"line {rows.line_num}", str(error), "comma-separated numbers", "x [mm]")
    joints, units = _units(arm)
    columns, factors = _columns(header, joints, units, file)
    if not body:
        refuse(file, "", "no row", "a header and at least one row", ",".join(header))
    values, texts = _cells(body, columns, factors, file)
    where = tuple((file, f"line {line}") for line, _ in body)
    q = None
    if all(name in values for name in joints):
        q = np.column_stack([values[name] for name in joints])
        mistakes = outside_limits(q, [line for line, _ in body], arm, file)
        if mistakes:
            refuse_all(mistakes, _MOST_MISTAKES)
    approach = np.full((len(body), len(joints)), math.nan)
    for name, signs in texts.items():
        if name.startswith(_APPROACH):
            at = [joints.index(name[len(_APPROACH) + 1 :])] if name != _APPROACH else slice(None)
            of_rows = np.array([_SIGNS[each] for each in signs])[:, None]
            approach[:, at] = np.where(np.isnan(of_rows), approach[:, at], of_rows)
    forces = [np.array(values.get(name, [0.0] * len(body))) for name in _FORCES]
    turned = q is None and _ANGLES[0] in values
    return PathRows(
        q,
        None if q is not None else np.column_stack([values[name] for name in _POSITION]),
        np.column_stack([values[name] for name in _ANGLES]) if turned else None,
        tuple(texts.get(_FEATURE, [""] * len(body))),
        approach,
        np.column_stack(forces) if any(name in values for name in _FORCES) else None,
        where,
    )


def _cells(
    body: list[tuple[int, list[str]]],
    columns: Mapping[str, int],
    factors: Mapping[str, float],
    file: str,
) -> tuple[dict[str, list[float]], dict[str, list[str]]]:
    """Return the columns of numbers, in SI, and those of text. Raises InputError with the mistakes
    in cells.
    """
    values: dict[str, list[float]] = {name: [] for name in factors}
    texts: dict[str, list[str]] = {name: [] for name in columns if name not in factors}
    mistakes: list[Problem] = []
    count = max(columns.values()) + 1
    for line, row in body:
        if len(row) != count:
            expected = f"{count} cells, one per column of the header"
            mistakes.append(Problem(file, f"line {line}", f"{len(row)} cells", expected))
            continue
        for name, at in columns.items():
            cell, key = row[at].strip(), f"line {line}, {name}"
            if name in texts:
                texts[name].append(cell)
                if name.startswith(_APPROACH) and cell not in _SIGNS:
                    mistakes.append(Problem(file, key, shown(cell), "up, down or random", "up"))
                continue
            value = number(cell)
            values[name].append(value * factors[name])
            if not math.isfinite(value):
                mistakes.append(Problem(file, key, shown(cell), "a finite number", "12.5"))
        if len(mistakes) > _MOST_MISTAKES:
            break
    if mistakes:
        refuse_all(mistakes, _MOST_MISTAKES)
    return values, texts


def _units(arm: Arm) -> tuple[list[str], dict[str, str]]:
    """Return the names of the joints, and the SI unit of each column that holds numbers."""
    units = (
        dict.fromkeys(_POSITION, "m") | dict.fromkeys(_ANGLES, "rad") | dict.fromkeys(_FORCES, "N")
    )
    units |= {
        joint.name: "m" if isinstance(joint, PrismaticJoint) else "rad" for joint in arm.driven
    }
    return [joint.name for joint in arm.driven], units


def _columns(
    header: list[str], joints: list[str], units: Mapping[str, str], file: str
) -> tuple[dict[str, int], dict[str, float]]:
    """Return the number of each column by its name, and the size of its unit in SI for numbers."""
    known = [*units, _FEATURE, _APPROACH, *(f"{_APPROACH} {name}" for name in joints)]
    columns: dict[str, int] = {}
    found: dict[str, str | None] = {}
    mistakes: list[Problem] = []
    for at, heading in enumerate(header[:200]):
        match = _HEADING.match(heading) if len(heading) <= 200 else None  # noqa: PLR2004 - no heading is longer
        name, key = match["name"] if match else heading.strip(), f"line 1, column {at + 1}"
        if name not in known:
            expected = f"a column of {listed(known)}"
            mistakes.append(
                Problem(file, key, shown(heading), expected, "x [mm]", nearest(name, known))
            )
        elif name in columns:
            mistakes.append(Problem(file, key, f"column '{name}' twice", "each column once"))
        else:
            columns[name] = at
            if name in units:
                found[name] = match["unit"] if match else None
    factors = _factors(found, columns, units, file, mistakes)
    # A joint may be named as an angle of the tool.
    of_tool = {*_POSITION, *_ANGLES}
    of_joints = set(joints) <= set(columns) or set(joints) & (set(columns) - of_tool)
    wanted = joints if of_joints else list(_POSITION)
    if set(_ANGLES) & (set(columns) - (set(joints) if of_joints else set())):
        wanted = [*wanted, *_ANGLES]
    missing = [name for name in wanted if name not in columns]
    if missing and not mistakes:
        expected = "one column per joint, or x, y and z of the tool (with all of roll, pitch, yaw)"
        mistakes.append(
            Problem(
                file, "line 1", f"no column for {listed(missing)}", expected, "x [mm],y [mm],z [mm]"
            )
        )
    if mistakes:
        refuse_all(mistakes, _MOST_MISTAKES)
    return columns, factors


def _factors(
    named: Mapping[str, str | None],
    columns: Mapping[str, int],
    units: Mapping[str, str],
    file: str,
    mistakes: list[Problem],
) -> dict[str, float]:
    """Return the size in SI of the unit of each column that holds numbers; mistakes are noted."""
    factors, usual = {}, {"m": "mm", "rad": "deg", "N": "N"}
    headings = {name: f"{name} [{usual[units[name]]}]" for name in named}
    for name, unit in named.items():
        if unit is None:
            continue
        try:
            factors[name] = read_quantity(f"1 {unit}", units[name]).nominal
        except UnitError as error:
            key, stated = f"line 1, column {columns[name] + 1}", shown(f"{name} [{unit}]")
            expected = "the unit of the column in brackets"
            mistakes.append(Problem(file, key, f"{stated} ({error})", expected, headings[name]))
    without = [name for name, unit in named.items() if unit is None]
    if without:
        expected = "the unit of each column in brackets"
        header = ",".join(headings[name] for name in without)
        mistakes.append(Problem(file, "line 1", f"no unit of {listed(without)}", expected, header))
    return factors
