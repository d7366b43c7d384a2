"""Rows of a CSV of measured visits: duplicates, numbers in SI, and the mistakes of every row."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.iso9283.measured_columns import (
    ATTAINED,
    COMMANDED,
    COMMANDED_ORIENTATION,
    DEVIATION,
    LONGEST,
    MOST_MISTAKES,
    ORIENTATION,
    WORDS,
    column_names,
    decimal_points,
)
from lostmotion.analyses.iso9283.predicted import MOST_LOAD
from lostmotion.errors import InputError, Problem, shown
from lostmotion.io.limits import cut, refuse_all
from lostmotion.io.text import numbers

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.analyses.iso9283.measured_columns import Column
    from lostmotion.spatial import Floats

# Largest coordinate (m, rad); larger ones are mistakes.
_FARTHEST: Final = 1e4
# Decimals of the share of the payload that distinguish loads.
LOAD_DECIMALS: Final = 6
# Columns that may be empty in a reading along a path, all three at once.
_OPTIONAL: Final = (COMMANDED, ORIENTATION, COMMANDED_ORIENTATION)
# Cells of a reading that was not taken.
_NO_READING: Final = frozenset({"", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "---"})


def payload_shares(
    file: str, lines: Sequence[int], stated: Floats | None, named: float | None, count: int
) -> Floats:
    """Return each row's share of the payload: its own, the file's, or the full payload."""
    if stated is None:
        return np.full(count, 1.0 if named is None else named)
    mistakes = []
    for load, line in zip(stated.tolist(), lines, strict=True):
        if not 0 <= load <= MOST_LOAD:
            expected = f"a share of the payload, from 0 to {100 * MOST_LOAD:.0f} %"
            mistakes.append(
                Problem(
                    file,
                    f"line {line}, load",
                    f"{100 * load:g} %",
                    expected,
                    "100, under the heading load [%]",
                )
            )
            if len(mistakes) > MOST_MISTAKES:
                break
    others = (
        np.flatnonzero(np.abs(stated - named) > 10**-LOAD_DECIMALS)
        if named is not None
        else np.empty(0, dtype=int)
    )
    if not mistakes and others.size and named is not None:
        rows = (
            f"{others.size} row{'s' * (others.size > 1)}, the first with "
            f"{100 * stated[others[0]]:g} % of the payload"
        )
        found = f"{rows}, where {100 * named:g} % is named for the whole file"
        mistakes.append(
            Problem(
                file,
                f"line {lines[others[0]]}, load",
                found,
                "a load in the column, or one for the file, not both",
            )
        )
    if mistakes:
        refuse_all(mistakes, MOST_MISTAKES)
    return stated


def without_repeats(
    header: list[str], rows: list[list[str]], lines: list[int], columns: Mapping[str, Column]
) -> tuple[list[list[str]], int, list[int], tuple[str, ...]]:
    """Return the rows without those that repeat another one in every column that is read.

    Unread columns, such as time stamps, do not count. Returns the rows kept, the number dropped,
    the lines of those kept, and the unread columns in which a dropped row differs from the one
    kept.
    """
    numeric = {
        column.index for role, column in columns.items() if role not in WORDS or role == "cycle"
    }
    read = sorted({column.index for column in columns.values()}) or list(range(len(header)))
    first: dict[tuple[Any, ...], int] = {}
    differ: set[int] = set()
    for k, row in enumerate(rows):
        # A row of the wrong length is compared as a whole and refused once.
        whole = len(row) == len(header)
        key = (
            tuple(_comparable(row[at], numeric=at in numeric) for at in read)
            if whole
            else (None, *row)
        )
        if (before := first.setdefault(key, k)) != k and whole:
            differ.update(
                at for at in range(len(header)) if at not in read and row[at] != rows[before][at]
            )
    names = column_names(header)
    kept = list(first.values())
    return (
        [rows[k] for k in kept],
        len(rows) - len(kept),
        [lines[k] for k in kept],
        tuple(names[at] for at in sorted(differ)),
    )


def without_lost(
    header: list[str], rows: list[list[str]], lines: list[int], columns: Mapping[str, Column]
) -> tuple[list[list[str]], list[int], list[int]]:
    """Return the rows that have a reading with their lines, and the lines of the others: an
    instrument that loses its target leaves cells empty.

    A row without any of its attained coordinates has no reading; a whole column without one is no
    lost target, and refused later.
    """
    at = [columns[role].index for role in (*ATTAINED, *DEVIATION, *ORIENTATION) if role in columns]
    whole = [len(row) == len(header) for row in rows]
    at = [
        k
        for k in at
        if any(
            ok and row[k].casefold() not in _NO_READING for row, ok in zip(rows, whole, strict=True)
        )
    ]
    optional = (
        {columns[role].index for role in ORIENTATION if role in columns}
        if "path" in columns
        else set()
    )
    lost = [
        ok and any(row[k].casefold() in _NO_READING for k in at if k not in optional)
        for row, ok in zip(rows, whole, strict=True)
    ]
    kept = [k for k, missing in enumerate(lost) if not missing]
    return (
        [rows[k] for k in kept],
        [lines[k] for k in kept],
        [line for line, missing in zip(lines, lost, strict=True) if missing],
    )


def _comparable(cell: str, *, numeric: bool) -> str | float:
    """Return the value by which a cell is compared: its number (1.0 equals 1.00), or its text."""
    number = _number(cell) if numeric else math.nan
    return number if math.isfinite(number) else cell


def role_values(
    file: str,
    header: list[str],
    rows: list[list[str]],
    lines: list[int],
    found_columns: tuple[dict[str, Column], set[str], list[Problem]],
) -> tuple[dict[str, list[str]], dict[str, Floats]]:
    """Return the words and the numbers (SI) of each role; raises InputError with all mistakes of
    header and rows.
    """
    columns, without_unit, mistakes = found_columns
    try:
        rows = decimal_points(file, rows, lines, columns)
    except InputError as error:
        refuse_all([*mistakes, *error.problems], MOST_MISTAKES)
    columns = {
        role: replace(column, factor=0.0) if role in without_unit else column
        for role, column in columns.items()
    }
    words: dict[str, list[str]] = {role: [] for role in columns if role in WORDS}
    values: dict[str, list[float]] = {role: [] for role in columns if role not in WORDS}
    for row, line in zip(rows, lines, strict=True):
        if wrong := _row_mistakes(file, header, row, line, columns):
            mistakes += wrong
            if len(mistakes) > MOST_MISTAKES:
                break
            continue
        for role, column in columns.items():
            cell = row[column.index]
            if role in values:
                values[role].append(_number(cell) * column.factor)
            else:
                words[role].append(str(_number(cell)) if role == "cycle" else cut(cell, LONGEST))
    if mistakes:
        refuse_all(mistakes, MOST_MISTAKES)
    return words, {role: np.array(found) for role, found in values.items()}


def _row_mistakes(
    file: str, header: list[str], row: list[str], line: int, columns: Mapping[str, Column]
) -> list[Problem]:
    """Return the mistakes in one row."""
    if len(row) != len(header):
        expected = f"{len(header)} cells, one per column of the header"
        return [
            Problem(
                file, f"line {line}", f"{len(row)} cells", expected, ",".join("0" * len(header))
            )
        ]
    cells = {role: row[column.index] for role, column in columns.items()}
    if nameless := _naming_mistakes(file, line, cells):
        return nameless
    out = []
    empty = _empty_roles(cells)
    for role, column in columns.items():
        if role in empty or (role in WORDS and role != "cycle"):
            continue
        if wrong := _number_mistake(cells[role], 0.0 if role == "cycle" else column.factor):
            out.append(
                Problem(file, f"line {line}, {cut(header[column.index], LONGEST)}", *wrong, "12.5")
            )
    return out


def _naming_mistakes(file: str, line: int, cells: Mapping[str, str]) -> list[Problem]:
    """Return the mistake of a row that is neither a visit to a pose nor a reading along a path."""
    pose, path = cells.get("pose", ""), cells.get("path", "")
    if path and (besides := [role for role in ("pose", "side") if cells.get(role)]):
        found = f"path {shown(path)} and {besides[0]} {shown(cells[besides[0]])}"
        return [
            Problem(
                file,
                f"line {line}",
                found,
                "a visit to a pose, or a reading along a path",
                ",P2-P4,1",
            )
        ]
    if (
        not path
        and not pose
        and ("pose" in cells or ("path" in cells and COMMANDED[0] not in cells))
    ):
        expected = (
            "the name of the pose or of the path"
            if "path" in cells
            else "the name of the pose, or of a path in a column path"
        )
        return [
            Problem(
                file,
                f"line {line}, {'pose' if 'pose' in cells else 'path'}",
                "nothing",
                expected,
                "P1",
            )
        ]
    return []


def _empty_roles(cells: Mapping[str, str]) -> set[str]:
    """Return the roles that a reading along a path leaves empty."""
    if not cells.get("path"):
        return set()
    groups = [group for group in _OPTIONAL if not any(cells.get(role) for role in group)]
    return {
        role
        for group in groups
        for role in group
        if not (group is COMMANDED and DEVIATION[0] in cells)
    }


def _number_mistake(cell: str, factor: float) -> tuple[str, str] | None:
    """Return what was found and expected in a cell that is no valid coordinate or count; None for a
    valid one.
    """
    number = _number(cell)
    if not math.isfinite(number):
        return shown(cell), "a finite number"
    return (
        (f"{shown(cell)}, beyond any robot", "at most 10 km, or 10 000 rad")
        if abs(number * factor) > _FARTHEST
        else None
    )


def _number(cell: str) -> float:
    try:
        return numbers([cell])[0]
    except (ValueError, IndexError):
        return math.nan
