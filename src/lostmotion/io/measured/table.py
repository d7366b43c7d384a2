"""Tables of measurements as CSV: one row per reading, a header that names each column and its unit.

    # lines that begin with # are comments
    pose, x [mm], A [deg]
    P1,   600.02, 12.5

Cells are separated by commas or semicolons. Numbers have decimal points throughout, or decimal
commas throughout. Header may stand in any order; a mapping names those with other headings: "x =
x_t [mm]", or "x = -x_t [mm]" for the other sign. All mistakes are reported at once.
"""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from lostmotion.errors import InputError, Problem, shown
from lostmotion.io.limits import cut, listed, nearest, refuse_all
from lostmotion.io.text import number, read_text, refuse
from lostmotion.unit_registry import UnitError
from lostmotion.units import read_quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence
    from pathlib import Path

    from lostmotion.spatial import Floats

MEGABYTES: Final = 50
_MOST_ROWS: Final = 200_000
_MOST_COLUMNS: Final = 200
MOST_MISTAKES: Final = 20
LONGEST: Final = 60
# Largest quantity (m, rad); larger ones are mistakes.
_FARTHEST: Final = 1e4
_HEADING: Final = re.compile(r"^\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]{0,20})\]\s*)?$")
_COMMA: Final = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
# A comma that may be a decimal comma or a separator of thousands.
_THOUSANDS: Final = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+")
_NUMBER: Final = re.compile(r"[+-]?[.,]?\d[\d.,]*(?:[eE][+-]?\d+)?")
_MAP: Final = re.compile(
    r"^\s*(?P<role>[^=\[\]]{1,60}?)\s*=\s*(?P<sign>[+-]?)\s*(?P<column>[^\[\]]{1,100}?)\s*(?:\[(?P<unit>[^\[\]]{0,20})\]\s*)?$"
)


def _nothing(*_: object) -> list[Any]:
    return []


@dataclass(frozen=True)
class Layout:
    """What a kind of file may hold.

    words    roles of columns whose cells are names
    counts   roles whose cells are numbers without a unit
    units    SI unit of every other role, and a usual unit for the example of a message
    header   a header of such a file, `mapping` a column with another name, and `example` the path
             of a file, for messages
    aliases  other usual headings of a role
    missing  mistakes of missing and contradictory columns, from the file and the roles found
    naming   mistakes of a row by itself, from the file, the line, and the cell of each role
    empty    roles that a row may leave empty, from the cell of each role
    """

    words: tuple[str, ...]
    units: Mapping[str, tuple[str, str]]
    header: str
    example: str
    mapping: str = ""
    counts: tuple[str, ...] = ()
    aliases: Mapping[str, str] = field(default_factory=dict)
    missing: Callable[[str, Collection[str]], list[Problem]] = _nothing
    naming: Callable[[str, int, Mapping[str, str]], list[Problem]] = _nothing
    empty: Callable[[Mapping[str, str]], Collection[str]] = _nothing

    @property
    def roles(self) -> tuple[str, ...]:
        """Return all roles."""
        return (*self.words, *self.counts, *self.units)


class TextTable(NamedTuple):
    """Header and rows of a file as text, the line number of each row, and comments with theirs."""

    file: str
    header: list[str]
    rows: list[list[str]]
    lines: list[int]
    comments: tuple[tuple[int, str], ...] = ()

    @property
    def names(self) -> list[str]:
        """Return the header's names without their units."""
        return [
            match["name"] if (match := _HEADING.match(heading[:_MOST_COLUMNS])) else heading
            for heading in self.header
        ]

    def picked(self, rows: Sequence[int]) -> TextTable:
        """Return some of the rows, by number."""
        return self._replace(rows=[self.rows[k] for k in rows], lines=[self.lines[k] for k in rows])


@dataclass(frozen=True, slots=True)
class RoleColumn:
    """Index of a role's column, and the factor that converts its numbers to SI: None for words,
    zero where the unit is not known, which is a mistake already.
    """

    index: int
    factor: float | None = None


class Header(NamedTuple):
    """The column of every role that a file has, and the mistakes of its header."""

    of: dict[str, RoleColumn]
    mistakes: list[Problem]


def read_columns(
    path: Path, layout: Layout, mapping: Sequence[str] = ()
) -> tuple[dict[str, list[str]], dict[str, Floats], list[int]]:
    """Return the words of each role of a file, the numbers in SI, and the line of each row.

    Raises InputError with the first 20 mistakes and their lines.
    """
    table = read_table(path, layout)
    return (*role_values(table, find_columns(table, mapping, layout), layout), table.lines)


def read_table(path: Path, layout: Layout) -> TextTable:
    """Return the header and the rows of a file; raises InputError for what is no such table."""
    file = str(path)
    text = read_text(path, MEGABYTES, layout.example).splitlines()
    kept = [
        (number, line)
        for number, line in enumerate(text, 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(kept) < 2:  # noqa: PLR2004 - a header and a row
        refuse(file, "", "no reading", "a header and at least one row", layout.header)
    if len(kept) > _MOST_ROWS:
        refuse(file, "", f"{len(kept)} rows", f"at most {_MOST_ROWS}", "one test per file")
    first, top = kept[0]
    at, separator = f"line {first}", ";" if top.count(";") > top.count(",") else ","
    try:
        rows = [
            [cell.strip() for cell in row]
            for row in csv.reader([line for _, line in kept], delimiter=separator)
        ]
    except csv.Error as error:
        refuse(file, "", str(error), "comma-separated values", layout.header)
    if len(rows) != len(kept):
        refuse(file, "", "a quoted cell over several lines", "one row per line", layout.header)
    if len(rows[0]) == 1 and (other := next((mark for mark in "\t|" if mark in rows[0][0]), "")):
        found = f"cells between {'tabs' if other == chr(9) else shown(other)}"
        refuse(file, at, found, "commas or semicolons between cells", layout.header)
    if sum(math.isfinite(number(cell.replace(",", "."))) for cell in rows[0]) > len(rows[0]) / 2:
        expected = "a header that names each column with its unit"
        refuse(file, at, f"numbers, {shown(top)}", expected, layout.header)
    if len(rows[0]) > _MOST_COLUMNS:
        refuse(file, at, f"{len(rows[0])} columns", f"at most {_MOST_COLUMNS}", layout.header)
    comments = tuple((k, line) for k, line in enumerate(text, 1) if line.lstrip().startswith("#"))
    return TextTable(file, rows[0], rows[1:], [number for number, _ in kept[1:]], comments)


def _headings(
    table: TextTable, layout: Layout
) -> tuple[dict[str, int], dict[str, str], list[Problem]]:
    """Return the index and unit of each name, and the mistakes in the names."""
    mistakes: list[Problem] = []
    plain: dict[str, int] = {}
    units: dict[str, str] = {}
    for index, (name, heading) in enumerate(zip(table.names, table.header, strict=True)):
        match = _HEADING.match(heading[:_MOST_COLUMNS])
        if name in plain:
            key, found = f"line 1, column {index + 1}", f"{shown(name)} a second time"
            mistakes.append(Problem(table.file, key, found, "each name once", layout.header))
        plain[name], units[name] = index, (match["unit"] if match else "") or ""
    return plain, units, mistakes


def find_columns(
    table: TextTable, mapping: Sequence[str], layout: Layout, elsewhere: Collection[str] = ()
) -> Header:
    """Return the column of every role, and all mistakes of the header.

    Roles are found by the header's own names or by `mapping`; a mapped name may belong to another
    file's header, `elsewhere`.
    """
    file, roles = table.file, layout.roles
    plain, units, mistakes = _headings(table, layout)
    requested = {
        role: (name, "", "")
        for name, role in layout.aliases.items()
        if name in plain and role not in plain
    }
    requested |= {name: (name, "", "") for name in plain if name in roles}

    def refused(found: str, expected: str, near: str) -> None:
        passing = (("mapping", layout.mapping),)
        mistakes.append(
            Problem("", "mapping", shown(found), expected, nearest=near, passing=passing)
        )

    for text in [part for entry in mapping for part in entry.split(",") if part.strip()]:
        match = _MAP.match(text)
        if match is None or match["role"] not in roles:
            expected = f"ROLE = COLUMN [unit], where ROLE is one of {listed(roles)}"
            refused(text, expected, nearest(match["role"], roles) if match else "")
        elif match["column"] in plain:
            requested[match["role"]] = match["column"], match["unit"] or "", match["sign"]
        elif match["column"] not in elsewhere:
            expected = f"a column of {cut(file, LONGEST)}: {listed(plain)}"
            refused(match["column"], expected, nearest(match["column"], plain))
    found: dict[str, RoleColumn] = {}
    for role, (name, unit, sign) in requested.items():
        factor = None if role in layout.words else 1.0
        if role in layout.units:
            si, example = layout.units[role]
            stated = unit or units[name]
            try:
                factor = read_quantity(f"1 {stated or 'without unit'}", si).nominal
            except UnitError as error:
                factor = 0.0
                mistakes.append(
                    Problem(
                        file,
                        f"line 1, {cut(name, LONGEST)}",
                        str(error) if stated else "no unit",
                        "a unit in brackets",
                        f"{role} [{example}]",
                    )
                )
            factor *= -1 if sign == "-" else 1
        found[role] = RoleColumn(plain[name], factor)
    return Header(found, mistakes + layout.missing(file, found))


def _numeric(columns: Mapping[str, RoleColumn]) -> set[int]:
    """Return the indices of columns whose cells are numbers."""
    return {column.index for column in columns.values() if column.factor is not None}


def _decimal_points(table: TextTable, columns: Mapping[str, RoleColumn]) -> TextTable:
    """Return a table with decimal points where the file's numbers use decimal commas, as many
    spreadsheets write them between semicolons.

    Raises InputError, once, where a comma is ambiguous: beside decimal points, or wherever it could
    separate thousands.
    """
    at = _numeric(columns)
    numbered = [
        (row[k], line)
        for row, line in zip(table.rows, table.lines, strict=True)
        for k in at
        if k < len(row) and _NUMBER.fullmatch(row[k])
    ]
    commas = [(cell, line) for cell, line in numbered if "," in cell]
    if not commas:
        return table
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
            table.file,
            f"line {line}",
            many,
            expected,
            "320.2129; export with the decimal point, or with more than three decimals",
        )
    rows = [
        [
            cell.replace(",", ".") if k in at and _COMMA.fullmatch(cell) else cell
            for k, cell in enumerate(row)
        ]
        for row in table.rows
    ]
    return table._replace(rows=rows)


def without_repeats(
    table: TextTable, columns: Mapping[str, RoleColumn]
) -> tuple[TextTable, int, tuple[str, ...]]:
    """Return a table without the rows that repeat another one in every column that is read.

    Unread columns, such as time stamps, do not count. Returns also the number of rows dropped, and
    the unread columns in which a dropped row differs from the one kept.
    """
    numeric, width = _numeric(columns), len(table.header)
    read = sorted({column.index for column in columns.values()}) or list(range(width))
    first: dict[tuple[Any, ...], int] = {}
    differ: set[int] = set()
    for k, row in enumerate(table.rows):
        # A row of the wrong length is compared as a whole and refused once.
        whole = len(row) == width
        key = (
            tuple(_comparable(row[at], numeric=at in numeric) for at in read)
            if whole
            else (None, *row)
        )
        if (before := first.setdefault(key, k)) != k and whole:
            differ.update(
                at for at in range(width) if at not in read and row[at] != table.rows[before][at]
            )
    kept = table.picked(list(first.values()))
    names = table.names
    return kept, len(table.rows) - len(kept.rows), tuple(names[at] for at in sorted(differ))


def _comparable(cell: str, *, numeric: bool) -> str | float:
    """Return the value by which a cell is compared: its number (1.0 equals 1.00), or its text."""
    value = number(cell) if numeric else math.nan
    return value if math.isfinite(value) else cell


def role_values(
    table: TextTable, columns: Header, layout: Layout
) -> tuple[dict[str, list[str]], dict[str, Floats]]:
    """Return the words and the numbers (SI) of each role; raises InputError with all mistakes of
    header and rows.
    """
    found, mistakes = columns.of, [*columns.mistakes]
    try:
        table = _decimal_points(table, found)
    except InputError as error:
        refuse_all([*mistakes, *error.problems], MOST_MISTAKES)
    words: dict[str, list[str]] = {role: [] for role in found if role in layout.words}
    values: dict[str, list[float]] = {role: [] for role in found if role not in layout.words}
    for row, line in zip(table.rows, table.lines, strict=True):
        if wrong := _row_mistakes(table, row, line, found, layout):
            mistakes += wrong
            if len(mistakes) > MOST_MISTAKES:
                break
            continue
        for role, column in found.items():
            cell = row[column.index]
            if column.factor is None:
                words[role].append(cut(cell, LONGEST))
            else:
                values[role].append(number(cell) * column.factor)
    if mistakes:
        refuse_all(mistakes, MOST_MISTAKES)
    return words, {role: np.array(each) for role, each in values.items()}


def _row_mistakes(
    table: TextTable, row: list[str], line: int, columns: Mapping[str, RoleColumn], layout: Layout
) -> list[Problem]:
    """Return the mistakes in one row."""
    file, header = table.file, table.header
    if len(row) != len(header):
        expected = f"{len(header)} cells, one per column of the header"
        example = ",".join("0" * len(header))
        return [Problem(file, f"line {line}", f"{len(row)} cells", expected, example)]
    cells = {role: row[column.index] for role, column in columns.items()}
    if nameless := layout.naming(file, line, cells):
        return nameless
    out = []
    empty = layout.empty(cells)
    for role, column in columns.items():
        if role in empty or column.factor is None:
            continue
        free = role in layout.counts or layout.units[role][0] == "s"  # no length and no angle
        factor = 0.0 if free else column.factor
        if wrong := _number_mistake(cells[role], factor):
            heading = cut(header[column.index], LONGEST)
            out.append(Problem(file, f"line {line}, {heading}", *wrong, "12.5"))
    return out


def _number_mistake(cell: str, factor: float) -> tuple[str, str] | None:
    """Return what was found and expected in a cell that is no valid coordinate or count; None for a
    valid one.
    """
    value = number(cell)
    if not math.isfinite(value):
        return shown(cell), "a finite number"
    return (
        (f"{shown(cell)}, beyond any robot", "at most 10 km, or 10 000 rad")
        if abs(value * factor) > _FARTHEST
        else None
    )
