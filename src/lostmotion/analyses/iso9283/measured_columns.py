"""Columns of a CSV of measured visits: header, roles, units and `--map`, with all mistakes at
once.
"""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import cut, listed, nearest
from lostmotion.io.text import read_text, refuse
from lostmotion.unit_registry import UnitError
from lostmotion.units import read_quantity

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence
    from pathlib import Path

MEGABYTES: Final = 50
_EXAMPLE: Final = "examples/measured/z-arm.csv"
_MOST_ROWS: Final = 200_000
_MOST_COLUMNS: Final = 200
MOST_MISTAKES: Final = 20
LONGEST: Final = 60
_HEADING: Final = re.compile(r"^\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]{0,20})\]\s*)?$")
_COMMA: Final = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
# A comma that may be a decimal comma or a separator of thousands.
_THOUSANDS: Final = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+")
_NUMBER: Final = re.compile(r"[+-]?[.,]?\d[\d.,]*(?:[eE][+-]?\d+)?")
_MAP: Final = re.compile(
    r"^\s*(?P<role>[a-z]{1,5})\s*=\s*(?P<sign>[+-]?)\s*(?P<column>[^\[\]]{1,100}?)\s*(?:\[(?P<unit>[^\[\]]{0,20})\]\s*)?$"
)
ATTAINED: Final = ("x", "y", "z")
DEVIATION: Final = ("dx", "dy", "dz")
COMMANDED: Final = ("xc", "yc", "zc")
ORIENTATION: Final = ("a", "b", "c")
COMMANDED_ORIENTATION: Final = ("ac", "bc", "cc")
WORDS: Final = ("pose", "path", "side", "cycle")
_LENGTHS: Final = (*ATTAINED, *DEVIATION, *COMMANDED)
# SI unit of each role, and a usual unit for the example of a message.
_UNITS: Final = {
    **dict.fromkeys(_LENGTHS, ("m", "mm")),
    **dict.fromkeys((*ORIENTATION, *COMMANDED_ORIENTATION), ("rad", "deg")),
    "load": ("1", "%"),
}
_ROLES: Final = (*WORDS, *_UNITS)
# Other usual headings of a role.
_ALIASES: Final = {"approach": "side", "direction": "side"}
HEADER: Final = "pose, cycle, x [mm], y [mm], z [mm], xc [mm], yc [mm], zc [mm]"


@dataclass(frozen=True)
class Column:
    """Index of a role's column, and the factor that converts its numbers to SI."""

    index: int
    factor: float = 1.0


def column_names(header: list[str]) -> list[str]:
    """Return the header's names without their units."""
    return [
        match["name"] if (match := _HEADING.match(heading[:_MOST_COLUMNS])) else heading
        for heading in header
    ]


def read_table(path: Path) -> tuple[list[str], list[list[str]], list[int]]:
    """Return header, rows, and the line number of each row."""
    file = str(path)
    text = read_text(path, MEGABYTES, _EXAMPLE).splitlines()
    kept = [
        (number, line)
        for number, line in enumerate(text, 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(kept) < 2:  # noqa: PLR2004 - a header and a row
        refuse(file, "", "no visit", "a header and at least one row", HEADER)
    if len(kept) > _MOST_ROWS:
        refuse(file, "", f"{len(kept)} rows", f"at most {_MOST_ROWS}", "one test per file")
    separator = ";" if kept[0][1].count(";") > kept[0][1].count(",") else ","
    try:
        rows = [
            [cell.strip() for cell in row]
            for row in csv.reader([line for _, line in kept], delimiter=separator)
        ]
    except csv.Error as error:
        refuse(file, "", str(error), "comma-separated values", HEADER)
    if len(rows) != len(kept):
        refuse(file, "", "a quoted cell over several lines", "one row per line", HEADER)
    if len(rows[0]) == 1 and (other := next((mark for mark in "\t|" if mark in rows[0][0]), "")):
        mark = "tabs" if other == "\t" else shown(other)
        refuse(
            file,
            f"line {kept[0][0]}",
            f"cells between {mark}",
            "commas or semicolons between cells",
            HEADER,
        )
    if sum(map(_is_number, rows[0])) > len(rows[0]) / 2:
        refuse(
            file,
            f"line {kept[0][0]}",
            f"numbers, {shown(kept[0][1])}",
            "a header that names each column with its unit",
            HEADER,
        )
    if len(rows[0]) > _MOST_COLUMNS:
        refuse(file, "line 1", f"{len(rows[0])} columns", f"at most {_MOST_COLUMNS}", HEADER)
    return rows[0], rows[1:], [number for number, _ in kept[1:]]


def _is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(cell.replace(",", ".")))
    except ValueError:
        return False


def _headings(file: str, header: list[str]) -> tuple[dict[str, int], dict[str, str], list[Problem]]:
    """Return the index and unit of each name, and the mistakes in the names."""
    mistakes: list[Problem] = []
    plain: dict[str, int] = {}
    units: dict[str, str] = {}
    for index, (name, heading) in enumerate(zip(column_names(header), header, strict=True)):
        match = _HEADING.match(heading[:_MOST_COLUMNS])
        if name in plain:
            mistakes.append(
                Problem(
                    file,
                    f"line 1, column {index + 1}",
                    f"{shown(name)} a second time",
                    "each name once",
                    HEADER,
                )
            )
        plain[name], units[name] = index, (match["unit"] if match else "") or ""
    return plain, units, mistakes


def find_columns(
    file: str, header: list[str], mapping: Sequence[str], elsewhere: Collection[str] = ()
) -> tuple[dict[str, Column], set[str], list[Problem]]:
    """Return the column of every role, the roles without a known unit, and all mistakes.

    Roles are found by the header's own names or by `mapping`; a mapped name may belong to another
    file's header, `elsewhere`.
    """
    plain, units, mistakes = _headings(file, header)
    found: dict[str, Column] = {}
    without_unit: set[str] = set()
    requested = [(name, name, "", "") for name in plain if name in _ROLES]
    requested += [
        (role, name, "", "")
        for name, role in _ALIASES.items()
        if name in plain and role not in plain
    ]
    for text in [part for entry in mapping for part in entry.split(",") if part.strip()]:
        match = _MAP.match(text)
        if match is None or match["role"] not in _ROLES:
            near = nearest(match["role"], _ROLES) if match else ""
            expected = f"ROLE = COLUMN [unit], where ROLE is one of {listed(_ROLES)}"
            mistakes.append(
                Problem(
                    "",
                    "mapping",
                    shown(text),
                    expected,
                    nearest=near,
                    passing=(("mapping", "xc = x_t [mm]"),),
                )
            )
            continue
        if match["column"] not in plain:
            if match["column"] in elsewhere:
                continue
            near = nearest(match["column"], plain)
            expected = f"a column of {cut(file, LONGEST)}: {listed(plain)}"
            mistakes.append(
                Problem(
                    "",
                    "mapping",
                    shown(match["column"]),
                    expected,
                    nearest=near,
                    passing=(("mapping", "xc = x_t [mm]"),),
                )
            )
            continue
        requested = [each for each in requested if each[0] != match["role"]]
        requested.append((match["role"], match["column"], match["unit"] or "", match["sign"]))
    for role, name, unit, sign in requested:
        factor = 1.0
        if role not in WORDS:
            si, example = _UNITS[role]
            try:
                factor = read_quantity(f"1 {unit or units[name] or 'without unit'}", si).nominal * (
                    -1 if sign == "-" else 1
                )
            except UnitError as error:
                without_unit.add(role)
                mistakes.append(
                    Problem(
                        file,
                        f"line 1, {cut(name, LONGEST)}",
                        str(error) if unit or units[name] else "no unit",
                        "a unit in brackets",
                        f"{role} [{example}]",
                    )
                )
        found[role] = Column(plain[name], factor)
    return found, without_unit, mistakes + _missing(file, found)


def _missing(file: str, found: Mapping[str, Column]) -> list[Problem]:
    """Return the mistakes of missing and contradictory columns."""
    out = []
    whole = {
        group: [role for role in group if role in found]
        for group in (ATTAINED, DEVIATION, COMMANDED, ORIENTATION, COMMANDED_ORIENTATION)
    }
    for group, there in whole.items():
        if there and len(there) < len(group):
            missing = [role for role in group if role not in found]
            out.append(
                Problem(
                    file,
                    "line 1",
                    f"{listed(there)} without {listed(missing)}",
                    "all three, or none",
                    ", ".join(f"{r} [mm]" for r in group),
                )
            )
    if not whole[ATTAINED] and not whole[DEVIATION]:
        out.append(
            Problem(
                file,
                "line 1",
                "no attained positions",
                "columns x, y, z, or dx, dy, dz beside xc, yc, zc; name others by --map",
                HEADER,
            )
        )
    if whole[ATTAINED] and whole[DEVIATION]:
        out.append(Problem(file, "line 1", "both x, y, z and dx, dy, dz", "one of the two", HEADER))
    if whole[DEVIATION] and not whole[COMMANDED]:
        out.append(
            Problem(
                file,
                "line 1",
                "dx, dy, dz without xc, yc, zc",
                "columns with the commanded positions",
                "dx [mm], dy [mm], dz [mm], xc [mm], yc [mm], zc [mm]",
            )
        )
    if not whole[COMMANDED] and not {"pose", "path"} & set(found):
        out.append(
            Problem(
                file,
                "line 1",
                "neither pose nor path nor xc, yc, zc",
                "columns that identify the pose",
                HEADER,
            )
        )
    if "path" in found and "cycle" not in found:
        out.append(
            Problem(
                file,
                "line 1",
                "path without cycle",
                "a column with the number of the cycle",
                "path, cycle, x [mm], y [mm], z [mm]",
            )
        )
    if whole[COMMANDED_ORIENTATION] and not whole[COMMANDED]:
        out.append(
            Problem(
                file, "line 1", "ac, bc, cc without xc, yc, zc", "the whole commanded pose", HEADER
            )
        )
    return out


def decimal_points(
    file: str, rows: list[list[str]], lines: Sequence[int], columns: Mapping[str, Column]
) -> list[list[str]]:
    """Return the rows with decimal points where the file's numbers use decimal commas, as many
    spreadsheets write them between semicolons.

    Raises InputError, once, where a comma is ambiguous: beside decimal points, or wherever it could
    separate thousands.
    """
    at = [column.index for role, column in columns.items() if role not in WORDS or role == "cycle"]
    numbered = [
        (row[k], line)
        for row, line in zip(rows, lines, strict=True)
        for k in at
        if k < len(row) and _NUMBER.fullmatch(row[k])
    ]
    commas = [(cell, line) for cell, line in numbered if "," in cell]
    if not commas:
        return rows
    points = [(cell, line) for cell, line in numbered if "." in cell and "," not in cell]
    odd = [(cell, line) for cell, line in commas if not _COMMA.fullmatch(cell)]
    if points or odd or all(_THOUSANDS.fullmatch(cell) for cell, _ in commas):
        cell, line = (odd or commas)[0]
        beside = f", and {shown(points[0][0])} in line {points[0][1]}" if points and not odd else ""
        many = f"{len(commas)} number{'s' * (len(commas) > 1)} with a comma, {shown(cell)}{beside}"
        expected = (
            "a decimal point in all numbers, or a decimal comma in all, and nothing between "
            "thousands"
        )
        refuse(
            file,
            f"line {line}",
            many,
            expected,
            "320.2129; export with the decimal point, or with more than three decimals",
        )
    changed = set(at)
    return [
        [
            cell.replace(",", ".") if k in changed and _COMMA.fullmatch(cell) else cell
            for k, cell in enumerate(row)
        ]
        for row in rows
    ]
