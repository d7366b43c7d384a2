"""Measured visits and paths as CSV: one row per reading, a header that names each column with its unit.

    pose, path,  cycle, load [%], x [mm], y [mm], z [mm], a [deg], b [deg], c [deg], xc [mm], yc [mm], zc [mm], ac [deg], bc [deg], cc [deg]
    P1,   ,      1,     100,      600.02, 0.01,  399.95, ...
    ,     P2-P4, 1,     100,      452.11, ...

x, y, z are attained positions of the tool point in the base frame, xc, yc, zc commanded ones; dx, dy, dz, instead of the former, attained less
commanded. a, b, c and ac, bc, cc are turns about the fixed x, y, z axes, in that order. `side` names from where a pose was approached, for vAP; it is
empty in the standard's cycle. `load` is a share of the payload; without it, and without one named for the whole file, it is the full one. Only
positions are needed. Without `pose`, rows with one commanded position are one pose. A cycle visits a pose once. Lines that begin with # are for the
reader. Cells stand between commas or semicolons; numbers have decimal points throughout, or decimal commas throughout. Columns of other names are
mapped: "xc = x_t [mm]", or "dx = -x_dif [mm]" where the file has commanded less attained.

A row with `path`, the names of the poses that a straight line joins, is a reading along it: in the order read, cycle by cycle; `pose` is then empty,
commands and turns may be.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
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
    find_columns,
    read_table,
)
from lostmotion.analyses.iso9283.predicted import MOST_LOAD
from lostmotion.analyses.iso9283.visits import ARRAYS, TUPLES, Visits
from lostmotion.errors import InputError, Problem, refuse_argument, shown
from lostmotion.io.limits import cut, refuse_all
from lostmotion.io.text import numbers, refuse
from lostmotion.spatial import pose_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.analyses.iso9283.measured_columns import Column
    from lostmotion.spatial import Floats

# m, rad: coordinates beyond it are slips, and their squares no numbers.
_FARTHEST: Final = 1e4
# How many loads one robot is measured under.
MOST_LOADS: Final = 5
_MOST_FILES: Final = 20
# Loads that differ by less, of the payload, are one.
_DECIMALS: Final = 6
# What may be left out of a reading along a path, all three at once.
_SPARED: Final = (COMMANDED, ORIENTATION, COMMANDED_ORIENTATION)


def read_measured(
    path: str | Path | Sequence[str | Path],
    mapping: Sequence[str] = (),
    commands: str | Path | None = None,
    instrument: float = 0.0,
    loads: Sequence[float] = (),
) -> Visits:
    """Return the visits and readings along paths of these CSVs. Rows that repeat another one in every column that is read are dropped and counted.

    path        one file, or several of one robot
    mapping     "role = column [unit]", several in one text with commas between them or in several; roles as in the first lines of this file
    commands    a CSV with a pose's name and its commanded position (and turns) in x, y, z (a, b, c), for where the files state none
    instrument  standard deviation of one reading of a coordinate, m
    loads       share of the payload, one for each file, for those without a `load` column
    Raises InputError with the first 20 mistakes and their lines.
    """
    files = [Path(path)] if isinstance(path, str | Path) else [Path(each) for each in path]
    if not 1 <= len(files) <= _MOST_FILES:
        raise refuse_argument("measured", f"{len(files)} files", f"1 to {_MOST_FILES}", measured="visits.csv")
    if len(loads) not in {0, len(files)}:
        raise refuse_argument("load", f"{len(loads)} for {len(files)} measured files", "one for each file, in their order", load="100 %")
    if not all(0 <= load <= MOST_LOAD for load in loads):
        raise refuse_argument("load", tuple(loads), f"shares of the payload, from 0 to {MOST_LOAD:g}", load="10 %")
    tables = [read_table(each) for each in files]
    names = {name for header, _, _ in tables for name in column_names(header)} if len(files) > 1 else set()
    named: Sequence[float | None] = loads or [None] * len(files)
    parts: list[Visits] = []
    mistakes: list[Problem] = []
    for each, table, load in zip(files, tables, named, strict=True):
        try:
            parts.append(_rows_of(str(each), table, mapping, names, load))
        except InputError as error:
            mistakes += error.problems
    if mistakes:
        refuse_all(mistakes, MOST_MISTAKES)
    found = parts[0] if len(parts) == 1 else combined(parts)
    if len(kinds := dict.fromkeys(found.load.tolist())) > MOST_LOADS:
        refuse(str(files[0]), "load", f"{len(kinds)} loads", f"at most {MOST_LOADS}", "10 % and 100 % of the payload")
    _refuse_two_commands(found)
    stated = {name: k for k, name in reversed(list(enumerate(found.pose))) if name and np.isfinite(found.command[k]).all()}
    known = {name: found.commanded_pose(k) for name, k in stated.items()}
    if commands is not None:
        known = _commands(Path(commands)) | known
    found = found.commanded(known)
    return replace(found, cycle=_counted(found), instrument=instrument)


def _rows_of(
    file: str, table: tuple[list[str], list[list[str]], list[int]], mapping: Sequence[str], elsewhere: set[str], load: float | None
) -> Visits:
    """Give the rows of one file."""
    header, rows, lines = table
    columns = find_columns(file, header, mapping, elsewhere)
    cells, duplicates, lines, unread = _without_repeats(header, rows, lines, columns[0])
    words, values = _values(file, header, cells, lines, columns)
    count = len(cells)
    nothing = np.full((count, 3), math.nan)
    path = words.get("path", [""] * count)
    command = _stacked(values, COMMANDED, nothing)
    pose = words.get("pose") or _by_command(command, path)
    shares = _loads(file, lines, values.get("load"), load, count)
    return Visits(
        pose=tuple(pose),
        path=tuple(path),
        cycle=np.array([float(word) for word in words["cycle"]]) if "cycle" in words else np.full(count, math.nan),
        side=tuple(words.get("side", [""] * count)),
        load=np.round(shares, _DECIMALS),
        attained=command + _stacked(values, DEVIATION, nothing) if DEVIATION[0] in values else _stacked(values, ATTAINED, nothing),
        command=command,
        orientation=_rotations(_stacked(values, ORIENTATION, nothing)),
        rotation=_rotations(_stacked(values, COMMANDED_ORIENTATION, nothing)),
        where=tuple((file, line) for line in lines),
        duplicates=duplicates,
        unread=unread,
        instrument=0.0,
        source=Path(file).name,
        known={},
        load_stated=load is not None or "load" in values,
    )


def combined(parts: Sequence[Visits]) -> Visits:
    """What do the rows of several files of one robot say as those of one? The instrument is that of the first."""
    rows: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAYS}
    rows |= {name: tuple(each for part in parts for each in getattr(part, name)) for name in TUPLES}
    told: dict[str, Any] = {"duplicates": sum(part.duplicates for part in parts), "source": ", ".join(part.source for part in parts)}
    told["unread"] = tuple(dict.fromkeys(name for part in parts for name in part.unread))
    return replace(parts[0], load_stated=all(part.load_stated for part in parts), **rows, **told)


def _loads(file: str, lines: Sequence[int], stated: Floats | None, named: float | None, count: int) -> Floats:
    """Give each row's share of the payload: its own, the file's, or the full one."""
    if stated is None:
        return np.full(count, 1.0 if named is None else named)
    mistakes = []
    for load, line in zip(stated.tolist(), lines, strict=True):
        if not 0 <= load <= MOST_LOAD:
            expected = f"a share of the payload, from 0 to {100 * MOST_LOAD:.0f} %"
            mistakes.append(Problem(file, f"line {line}, load", f"{100 * load:g} %", expected, "100, under the heading load [%]"))
            if len(mistakes) > MOST_MISTAKES:
                break
    others = np.flatnonzero(np.abs(stated - named) > 10**-_DECIMALS) if named is not None else np.empty(0, dtype=int)
    if not mistakes and others.size and named is not None:
        rows = f"{others.size} row{'s' * (others.size > 1)}, the first with {100 * stated[others[0]]:g} % of the payload"
        found = f"{rows}, where {100 * named:g} % is named for the whole file"
        mistakes.append(Problem(file, f"line {lines[others[0]]}, load", found, "one load, or no load stated beside the column"))
    if mistakes:
        refuse_all(mistakes, MOST_MISTAKES)
    return stated


def _without_repeats(
    header: list[str], rows: list[list[str]], lines: list[int], columns: Mapping[str, Column]
) -> tuple[list[list[str]], int, list[int], tuple[str, ...]]:
    """Drop the rows that repeat another one in every column that is read; a time stamp beside them makes no other visit.

    Returns the rows kept, how many were dropped, the lines of those kept, and the unread columns in which a dropped row differs from the one kept.
    """
    numeric = {column.index for role, column in columns.items() if role not in WORDS or role == "cycle"}
    read = sorted({column.index for column in columns.values()}) or list(range(len(header)))
    first: dict[tuple[Any, ...], int] = {}
    differ: set[int] = set()
    for k, row in enumerate(rows):
        # A row of the wrong length is compared whole, to be refused once.
        whole = len(row) == len(header)
        key = tuple(_compared(row[at], numeric=at in numeric) for at in read) if whole else (None, *row)
        if (before := first.setdefault(key, k)) != k and whole:
            differ.update(at for at in range(len(header)) if at not in read and row[at] != rows[before][at])
    names = column_names(header)
    kept = list(first.values())
    return [rows[k] for k in kept], len(rows) - len(kept), [lines[k] for k in kept], tuple(names[at] for at in sorted(differ))


def _compared(cell: str, *, numeric: bool) -> str | float:
    """Return what a cell is compared by: its number, 1.0 as 1.00, or its text."""
    number = _number(cell) if numeric else math.nan
    return number if math.isfinite(number) else cell


def _values(
    file: str, header: list[str], rows: list[list[str]], lines: list[int], found_columns: tuple[dict[str, Column], set[str], list[Problem]]
) -> tuple[dict[str, list[str]], dict[str, Floats]]:
    """Give the words and the numbers (in SI) of each role; all mistakes of header and rows at once."""
    columns, without_unit, mistakes = found_columns
    try:
        rows = decimal_points(file, rows, lines, columns)
    except InputError as error:
        refuse_all([*mistakes, *error.problems], MOST_MISTAKES)
    columns = {role: replace(column, factor=0.0) if role in without_unit else column for role, column in columns.items()}
    words: dict[str, list[str]] = {role: [] for role in columns if role in WORDS}
    values: dict[str, list[float]] = {role: [] for role in columns if role not in WORDS}
    for row, line in zip(rows, lines, strict=True):
        if wrong := _wrong(file, header, row, line, columns):
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


def _wrong(file: str, header: list[str], row: list[str], line: int, columns: Mapping[str, Column]) -> list[Problem]:
    """Find what is wrong with one row."""
    if len(row) != len(header):
        expected = f"{len(header)} cells, one per column of the header"
        return [Problem(file, f"line {line}", f"{len(row)} cells", expected, ",".join("0" * len(header)))]
    cells = {role: row[column.index] for role, column in columns.items()}
    if nameless := _named(file, line, cells):
        return nameless
    out = []
    spared = _spared(cells)
    for role, column in columns.items():
        if role in spared or (role in WORDS and role != "cycle"):
            continue
        if wrong := _no_number(cells[role], 0.0 if role == "cycle" else column.factor):
            out.append(Problem(file, f"line {line}, {cut(header[column.index], LONGEST)}", *wrong, "12.5"))
    return out


def _named(file: str, line: int, cells: Mapping[str, str]) -> list[Problem]:
    """A row is a visit to a pose, or a reading along a path."""
    pose, path = cells.get("pose", ""), cells.get("path", "")
    if path and (besides := [role for role in ("pose", "side") if cells.get(role)]):
        found = f"path {shown(path)} and {besides[0]} {shown(cells[besides[0]])}"
        return [Problem(file, f"line {line}", found, "a visit to a pose, or a reading along a path", ",P2-P4,1")]
    if not path and not pose and ("pose" in cells or ("path" in cells and COMMANDED[0] not in cells)):
        expected = "the name of the pose, or of the path" if "path" in cells else "the name of the pose; or that of a path, in a column path"
        return [Problem(file, f"line {line}, {'pose' if 'pose' in cells else 'path'}", "nothing", expected, "P1")]
    return []


def _spared(cells: Mapping[str, str]) -> set[str]:
    """Which cells of a reading along a path are left out?"""
    if not cells.get("path"):
        return set()
    groups = [group for group in _SPARED if not any(cells.get(role) for role in group)]
    return {role for group in groups for role in group if not (group is COMMANDED and DEVIATION[0] in cells)}


def _no_number(cell: str, factor: float) -> tuple[str, str] | None:
    """Say what is wrong with a cell that should be a coordinate or a count, and what belongs there; None for nothing."""
    number = _number(cell)
    if not math.isfinite(number):
        return shown(cell), "a finite number"
    return (f"{shown(cell)}, farther than a robot goes", "at most 10 km, or 10 000 rad") if abs(number * factor) > _FARTHEST else None


def _number(cell: str) -> float:
    try:
        return numbers([cell])[0]
    except (ValueError, IndexError):
        return math.nan


def _stacked(values: Mapping[str, Floats], roles: tuple[str, ...], otherwise: Floats) -> Floats:
    return np.stack([values[role] for role in roles], axis=-1) if roles[0] in values else otherwise


def _by_command(commanded: Floats, path: Sequence[str]) -> list[str]:
    """Name poses by number where rows share a commanded position."""
    numbered: dict[bytes, str] = {}
    return [
        "" if along else numbered.setdefault(row.tobytes(), str(len(numbered) + 1))
        for row, along in zip(np.ascontiguousarray(commanded), path, strict=True)
    ]


def _refuse_two_commands(visits: Visits) -> None:
    """One pose has one command."""
    first: dict[str, int] = {}
    mistakes = []
    for k, name in enumerate(visits.pose):
        if not name or not np.isfinite(visits.command[k]).all():
            continue
        at = first.setdefault(name, k)
        if np.abs(visits.command[k] - visits.command[at]).max() > _ROUNDING:
            (file, line), (other, before) = visits.where[k], visits.where[at]
            found = f"another commanded position of pose {name} than in {'' if file == other else other + ', '}line {before}"
            mistakes.append(Problem(file, f"line {line}", found, "one command per pose", "P1b as its name"))
            if len(mistakes) > MOST_MISTAKES:
                break
    if mistakes:
        refuse_all(mistakes, MOST_MISTAKES)


# m: commanded positions of one pose that differ by less are rounding in the file.
_ROUNDING: Final = 1e-6


def _commands(path: Path) -> dict[str, Floats]:
    """Read the commanded pose (4, 4) of every name."""
    header, rows, lines = read_table(path)
    found = find_columns(str(path), header, ())
    for role in ("pose", "x"):
        if role not in found[0]:
            refuse(str(path), "line 1", f"no column {role}", "the commanded poses: pose, x [mm], y [mm], z [mm]", "pose, x [mm], y [mm], z [mm]")
    words, values = _values(str(path), header, rows, lines, found)
    nothing = np.full((len(rows), 3), math.nan)
    at, rotation = _stacked(values, ATTAINED, nothing), _rotations(_stacked(values, ORIENTATION, nothing))
    out: dict[str, Floats] = {}
    for k, name in enumerate(words["pose"]):
        if name in out:
            refuse(str(path), f"line {lines[k]}", f"pose {name} once more", "each pose once", "P1, 600, 0, 400")
        out[name] = pose_of(at[k])
        out[name][:3, :3] = rotation[k]  # NaN where the file tells no turns
    return out


def _rotations(turns: Floats) -> Floats:
    """Give rotations (row, 3, 3) of turns (row, 3) about the fixed axes, NaN where there are none."""
    from scipy.spatial.transform import Rotation

    out = np.full((len(turns), 3, 3), math.nan)
    if (known := np.isfinite(turns).all(axis=1)).any():
        out[known] = Rotation.from_euler("xyz", turns[known]).as_matrix()
    return out


def _counted(visits: Visits) -> Floats:
    """Give cycle numbers, counted up within pose, side and load where none are stated."""
    seen: dict[tuple[str, str, float], int] = {}
    out = visits.cycle.copy()
    for k in np.flatnonzero(np.isnan(out)).tolist():
        each = visits.pose[k], visits.side[k], float(visits.load[k])
        seen[each] = seen.get(each, 0) + 1
        out[k] = seen[each]
    return out
