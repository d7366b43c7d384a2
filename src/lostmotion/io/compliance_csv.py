"""A compliance or stiffness matrix as CSV, rows and columns named with their units, in any order.

    compliance, Fx [N], Fy [N], Fz [N], Mx [N m], My [N m], Mz [N m]
    x [mm],     2.1e-6, 0,      0,      0,        0,        0
    rx [rad],   ...

Loads are Mx, My, Mz about and Fx, Fy, Fz along the axes, motions rx, ry, rz and x, y, z. A
compliance has a column per load and a row per motion, a stiffness (first word) a column per motion
and a row per load. A link's compliance may have three columns more, gx, gy, gz [m/s^2]: what its
far end does under its own weight, per gravity along the axes. All of it at the far end of the link
and in its axes; of the base, at its own origin. Commas or semicolons; lines that begin with # are
for the reader.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import nearest, refuse_all
from lostmotion.io.text import numbers, read_text, refuse
from lostmotion.parts.compliance import compliance_error
from lostmotion.unit_registry import UnitError
from lostmotion.units import read_quantity

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.spatial import Floats

MEGABYTES: Final = 1
_SIZE: Final = 6
_LOADS: Final = {"Mx": "N m", "My": "N m", "Mz": "N m", "Fx": "N", "Fy": "N", "Fz": "N"}
_MOTIONS: Final = {"rx": "rad", "ry": "rad", "rz": "rad", "x": "m", "y": "m", "z": "m"}
_GRAVITY: Final = {"gx": "m/s^2", "gy": "m/s^2", "gz": "m/s^2"}
_ROWS_AND_COLUMNS: Final = {"compliance": (_MOTIONS, _LOADS), "stiffness": (_LOADS, _MOTIONS)}
_LABEL: Final = re.compile(r"^(?P<name>[A-Za-z]{1,3})\s*\[(?P<unit>[^\[\]]{1,20})\]$")
_HEADER: Final = "compliance, Mx [N m], My [N m], Mz [N m], Fx [N], Fy [N], Fz [N]"


def read_compliance(path: Path) -> dict[str, tuple[tuple[float, ...], ...]]:
    """Return the fields of a `Compliance` from a CSV: matrix and own_weight, in SI; a stiffness is
    inverted.

    Raises InputError with every mistake in the file, and for a matrix that is not symmetric or not
    positive definite.
    """
    file = str(path)
    lines = [
        (number, [cell.strip() for cell in re.split("[,;]", line)])
        for number, line in enumerate(read_text(path, MEGABYTES).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    kind = lines[0][1][0].lower() if lines else ""
    if kind not in _ROWS_AND_COLUMNS:
        near = nearest(kind, _ROWS_AND_COLUMNS)
        refuse(
            file,
            "line 1",
            shown(kind) if lines else "nothing",
            "compliance or stiffness as the first word",
            _HEADER,
            near,
        )
    rows, columns = _ROWS_AND_COLUMNS[kind]
    (top, header), body = lines[0], lines[1:]
    if kind == "compliance" and len(header) > 1 + _SIZE:
        columns = {**columns, **_GRAVITY}
    mistakes: list[Problem] = []
    across = _labels(file, [(top, cell) for cell in header[1:]], columns, mistakes)
    down = _labels(
        file, [(number, cells[0]) for number, cells in body[: _SIZE + 1]], rows, mistakes
    )
    entries = _entries(file, body[:_SIZE], len(columns), mistakes)
    if mistakes:
        refuse_all(mistakes)
    whole = np.zeros((_SIZE, len(columns)))
    for (row, row_unit), values in zip(down, entries, strict=True):
        for (column, column_unit), value in zip(across, values, strict=True):
            whole[row, column] = value * row_unit / column_unit
    matrix = whole[:, :_SIZE]
    problem = compliance_error(matrix)
    if problem or (kind == "stiffness" and not np.diag(matrix).all()):
        refuse(
            file, "", *(problem or ("a stiffness of zero", "a positive definite matrix")), _HEADER
        )
    found = {"matrix": _inverse(matrix) if kind == "stiffness" else matrix}
    if len(columns) > _SIZE:
        found["own_weight"] = whole[:, _SIZE:]
    return {name: tuple(map(tuple, values.tolist())) for name, values in found.items()}


def _labels(
    file: str, labels: list[tuple[int, str]], known: dict[str, str], mistakes: list[Problem]
) -> list[tuple[int, float]]:
    """Return the position and the unit in SI of every row or column; note what is none, missing or
    there twice.
    """
    order = {name.lower(): k for k, name in enumerate(known)}
    example = ", ".join(f"{name} [{unit}]" for name, unit in known.items())
    out: list[tuple[int, float]] = []
    for number, label in labels[: len(known) + 1]:
        match = _LABEL.match(label)
        if match is None or match["name"].lower() not in order:
            mistakes.append(
                Problem(
                    file,
                    f"line {number}",
                    shown(label),
                    f"one of {', '.join(known)}, with its unit",
                    example,
                )
            )
            continue
        place = order[match["name"].lower()]
        try:
            out.append(
                (place, read_quantity(f"1 {match['unit']}", list(known.values())[place]).nominal)
            )
        except UnitError as error:
            mistakes.append(
                Problem(
                    file,
                    f"line {number}",
                    f"{shown(label)}: {error}",
                    f"a unit like {list(known.values())[place]}",
                    example,
                )
            )
    if not mistakes and sorted(place for place, _ in out) != list(range(len(known))):
        found = ", ".join(list(known)[place] for place, _ in out) or "none"
        mistakes.append(Problem(file, "", found, f"each of {', '.join(known)} once", example))
    return out


def _entries(
    file: str, body: list[tuple[int, list[str]]], count: int, mistakes: list[Problem]
) -> list[list[float]]:
    out = []
    for number, cells in body:
        try:
            values = numbers(cells[1:])
        except ValueError:
            values = []
        if len(values) != count or not all(map(math.isfinite, values)):
            mistakes.append(
                Problem(
                    file,
                    f"line {number}",
                    shown(", ".join(cells)),
                    f"a name and {count} finite numbers",
                    "x [mm], 1e-6, 0, 0, 0, 0, 0",
                )
            )
        out.append(values)
    return out


def _inverse(stiffness: Floats) -> Floats:
    """Invert a matrix whose rows have different units: scaled to ones on the diagonal first."""
    stiffness = (stiffness + stiffness.T) / 2
    scale = 1 / np.sqrt(np.diag(stiffness))
    inverted = np.linalg.inv(stiffness * np.outer(scale, scale)) * np.outer(scale, scale)
    return np.asarray((inverted + inverted.T) / 2)
