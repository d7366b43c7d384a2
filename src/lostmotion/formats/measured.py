"""Measured visits as CSV: one row per visit, a header that names each column with its unit.

    pose, cycle, x [mm], y [mm], z [mm], a [deg], b [deg], c [deg], xc [mm], yc [mm], zc [mm], ac [deg], bc [deg], cc [deg]
    P1,   1,     600.02, 0.01,  399.95, ...

x, y, z are attained positions of the tool point in the base frame, xc, yc, zc commanded ones; dx, dy, dz, instead of the former, attained less
commanded. a, b, c and ac, bc, cc are turns about the fixed x, y, z axes, in that order. `side` names from where a pose was approached, for vAP; it is
empty in the standard's cycle. Only positions are needed. Without `pose`, rows with one commanded position are one pose. Lines that begin with # are
for the reader. Columns of other names are mapped: "xc = x_t [mm]", or "dx = -x_dif [mm]" where the file has commanded less attained.
"""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import Problem, shown
from lostmotion.formats.bounds import cut, listed, nearest, refuse_all
from lostmotion.formats.text import numbers, read_text, refuse
from lostmotion.spatial import pose_of
from lostmotion.studies.iso9283.measured import Visits
from lostmotion.units import UnitError, read_quantity

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.spatial import Floats

MEGABYTES: Final = 50
_MOST_ROWS: Final = 200_000
_MOST_COLUMNS: Final = 200
_MOST_MISTAKES: Final = 20
_LONGEST: Final = 60
_HEADING: Final = re.compile(r"^\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]{0,20})\]\s*)?$")
_MAP: Final = re.compile(r"^\s*(?P<role>[a-z]{1,5})\s*=\s*(?P<sign>[+-]?)\s*(?P<column>[^\[\]]{1,100}?)\s*(?:\[(?P<unit>[^\[\]]{0,20})\]\s*)?$")
_ATTAINED: Final = ("x", "y", "z")
_OFF: Final = ("dx", "dy", "dz")
_COMMANDED: Final = ("xc", "yc", "zc")
_TURNED: Final = ("a", "b", "c")
_COMMANDED_TURN: Final = ("ac", "bc", "cc")
_WORDS: Final = ("pose", "side", "cycle")
_LENGTHS: Final = (*_ATTAINED, *_OFF, *_COMMANDED)
_ROLES: Final = (*_WORDS, *_LENGTHS, *_TURNED, *_COMMANDED_TURN)
_HEADER: Final = "pose, cycle, x [mm], y [mm], z [mm], xc [mm], yc [mm], zc [mm]"


@dataclass(frozen=True)
class _Column:
    """Where a role stands in the file: its index, and what its numbers are multiplied with to be in SI."""

    index: int
    factor: float = 1.0


def read_measured(
    path: str | Path,
    mapping: Sequence[str] = (),
    commands: str | Path | None = None,
    known: Mapping[str, Floats] | None = None,
    instrument: float = 0.0,
) -> Visits:
    """Which visits does this CSV hold? Rows that repeat another one exactly are left out and counted.

    mapping     "role = column [unit]", several in one text with commas between them or in several; roles as in the first lines of this file
    commands    a second CSV with a pose's name and its commanded position (and turns) in x, y, z (a, b, c)
    known       commanded poses (4, 4) by name, m, for where the files name none: the test cube's
    instrument  standard deviation of one reading of a coordinate, m
    Raises InputError with the first 20 mistakes and their lines.
    """
    file = str(path)
    header, rows, lines = _table(Path(path))
    columns = _columns(file, header, mapping)
    cells, duplicates, lines = _without_repeats(rows, lines)
    words, values = _values(file, header, cells, lines, columns)
    count = len(cells)
    commanded = _stacked(values, _COMMANDED)
    command_turn = _stacked(values, _COMMANDED_TURN)
    pose = words.get("pose") or _by_command(commanded, count)
    if commanded is None:
        stated = dict(known or {}) if commands is None else _commands(Path(commands))
        found = [stated.get(name) for name in pose]
        commanded = np.array([np.full(3, math.nan) if at is None else at[:3, 3] for at in found]).reshape(-1, 3)
        rotation = np.array([at[:3, :3] for at in found if at is not None]) if found and all(at is not None for at in found) else None
    else:
        _refuse_two_commands(file, pose, commanded, lines)
        rotation = None if command_turn is None else _rotations(command_turn)
    off = _stacked(values, _OFF)
    attained = _stacked(values, _ATTAINED) if off is None else commanded + off
    assert attained is not None  # noqa: S101 - `_columns` has seen to it
    turned = _stacked(values, _TURNED)
    turn = None if turned is None or rotation is None else _between(rotation, _rotations(turned))
    side = words.get("side") or [""] * count
    cycle = np.array([float(word) for word in words["cycle"]]) if "cycle" in words else _counted(pose, side)
    return Visits(tuple(pose), cycle, tuple(side), attained, commanded, turn, rotation, duplicates, instrument, Path(file).name)


def _table(path: Path) -> tuple[list[str], list[list[str]], list[int]]:
    """Read header, rows and the line that each row stands in."""
    file = str(path)
    text = read_text(path, MEGABYTES).splitlines()
    kept = [(number, line) for number, line in enumerate(text, 1) if line.strip() and not line.lstrip().startswith("#")]
    if len(kept) < 2:  # noqa: PLR2004 - a header and a row
        refuse(file, "", "no visit", "a header and at least one row", _HEADER)
    if len(kept) > _MOST_ROWS:
        refuse(file, "", f"{len(kept)} rows", f"at most {_MOST_ROWS}", "one test per file")
    separator = ";" if kept[0][1].count(";") > kept[0][1].count(",") else ","
    try:
        rows = [[cell.strip() for cell in row] for row in csv.reader([line for _, line in kept], delimiter=separator)]
    except csv.Error as error:
        refuse(file, "", str(error), "comma-separated values", _HEADER)
    if len(rows) != len(kept):
        refuse(file, "", "a quoted cell over several lines", "one row per line", _HEADER)
    if len(rows[0]) > _MOST_COLUMNS:
        refuse(file, "line 1", f"{len(rows[0])} columns", f"at most {_MOST_COLUMNS}", _HEADER)
    return rows[0], rows[1:], [number for number, _ in kept[1:]]


def _columns(file: str, header: list[str], mapping: Sequence[str]) -> dict[str, _Column]:
    """Find the column of every role, by the header's own names or as mapped."""
    mistakes: list[Problem] = []
    found: dict[str, _Column] = {}
    plain: dict[str, int] = {}
    units: dict[str, str] = {}
    for index, heading in enumerate(header):
        match = _HEADING.match(heading[:_MOST_COLUMNS])
        name = match["name"] if match else heading
        if name in plain:
            mistakes.append(Problem(file, f"line 1, column {index + 1}", f"{shown(name)} once more", "each name once", _HEADER))
        plain[name], units[name] = index, (match["unit"] if match else "") or ""
    asked = [(role, name, "", "") for name in plain for role in [name] if role in _ROLES]
    for text in [part for entry in mapping for part in entry.split(",") if part.strip()]:
        match = _MAP.match(text)
        if match is None or match["role"] not in _ROLES:
            near = nearest(match["role"], _ROLES) if match else ""
            mistakes.append(Problem("", "--map", shown(text), f"ROLE = COLUMN [unit], where ROLE is one of {listed(_ROLES)}", "xc = x_t [mm]", near))
            continue
        if match["column"] not in plain:
            near = nearest(match["column"], plain)
            mistakes.append(
                Problem("", "--map", shown(match["column"]), f"a column of {cut(file, _LONGEST)}: {listed(plain)}", "xc = x_t [mm]", near)
            )
            continue
        asked = [each for each in asked if each[0] != match["role"]]
        asked.append((match["role"], match["column"], match["unit"] or "", match["sign"]))
    for role, name, unit, sign in asked:
        factor = 1.0
        if role not in _WORDS:
            si, example = ("m", "mm") if role in _LENGTHS else ("rad", "deg")
            try:
                factor = read_quantity(f"1 {unit or units[name]}", si).nominal * (-1 if sign == "-" else 1)
            except UnitError as error:
                mistakes.append(Problem(file, f"line 1, {cut(name, _LONGEST)}", str(error), "a unit in brackets", f"{role} [{example}]"))
        found[role] = _Column(plain[name], factor)
    mistakes += _missing(file, found)
    if mistakes:
        refuse_all(mistakes, _MOST_MISTAKES)
    return found


def _missing(file: str, found: Mapping[str, _Column]) -> list[Problem]:
    out = []
    whole = {group: [role for role in group if role in found] for group in (_ATTAINED, _OFF, _COMMANDED, _TURNED, _COMMANDED_TURN)}
    for group, there in whole.items():
        if there and len(there) < len(group):
            missing = [role for role in group if role not in found]
            out.append(
                Problem(file, "line 1", f"{listed(there)} without {listed(missing)}", "all three, or none", ", ".join(f"{r} [mm]" for r in group))
            )
    if not whole[_ATTAINED] and not whole[_OFF]:
        out.append(
            Problem(file, "line 1", "no attained positions", "columns x, y, z, or dx, dy, dz beside xc, yc, zc; name others by --map", _HEADER)
        )
    if whole[_ATTAINED] and whole[_OFF]:
        out.append(Problem(file, "line 1", "both x, y, z and dx, dy, dz", "one of the two", _HEADER))
    if whole[_OFF] and not whole[_COMMANDED]:
        out.append(
            Problem(
                file,
                "line 1",
                "dx, dy, dz without xc, yc, zc",
                "the commanded positions beside them",
                "dx [mm], dy [mm], dz [mm], xc [mm], yc [mm], zc [mm]",
            )
        )
    if not whole[_COMMANDED] and "pose" not in found:
        out.append(Problem(file, "line 1", "neither pose nor xc, yc, zc", "what tells poses apart", _HEADER))
    if whole[_COMMANDED_TURN] and not whole[_COMMANDED]:
        out.append(Problem(file, "line 1", "ac, bc, cc without xc, yc, zc", "the whole commanded pose", _HEADER))
    return out


def _without_repeats(rows: list[list[str]], lines: list[int]) -> tuple[list[list[str]], int, list[int]]:
    first: dict[tuple[str, ...], int] = {}
    for row, line in zip(rows, lines, strict=True):
        first.setdefault(tuple(row), line)
    return [list(row) for row in first], len(rows) - len(first), list(first.values())


def _values(
    file: str, header: list[str], rows: list[list[str]], lines: list[int], columns: Mapping[str, _Column]
) -> tuple[dict[str, list[str]], dict[str, Floats]]:
    """Give the words and the numbers (in SI) of each role; all bad rows at once."""
    mistakes: list[Problem] = []
    words: dict[str, list[str]] = {role: [] for role in columns if role in _WORDS}
    values: dict[str, list[float]] = {role: [] for role in columns if role not in _WORDS}
    for row, line in zip(rows, lines, strict=True):
        if len(row) != len(header):
            mistakes.append(
                Problem(file, f"line {line}", f"{len(row)} cells", f"{len(header)} cells, one per column of the header", ",".join("0" * len(header)))
            )
        else:
            for role, column in columns.items():
                cell = row[column.index]
                if role in values or role == "cycle":
                    number = _number(cell)
                    if not math.isfinite(number):
                        mistakes.append(Problem(file, f"line {line}, {cut(header[column.index], _LONGEST)}", shown(cell), "a finite number", "12.5"))
                    if role in values:
                        values[role].append(number * column.factor)
                        continue
                elif role == "pose" and not cell:
                    mistakes.append(Problem(file, f"line {line}, {cut(header[column.index], _LONGEST)}", "nothing", "the name of the pose", "P1"))
                words[role].append(cut(cell, _LONGEST))
        if len(mistakes) > _MOST_MISTAKES:
            break
    if mistakes:
        refuse_all(mistakes, _MOST_MISTAKES)
    return words, {role: np.array(found) for role, found in values.items()}


def _number(cell: str) -> float:
    try:
        return numbers([cell])[0]
    except (ValueError, IndexError):
        return math.nan


def _stacked(values: Mapping[str, Floats], roles: tuple[str, ...]) -> Floats | None:
    return np.stack([values[role] for role in roles], axis=-1) if roles[0] in values else None


def _by_command(commanded: Floats | None, count: int) -> list[str]:
    """Name poses by number where rows share a commanded position."""
    if commanded is None:
        return ["1"] * count
    numbered: dict[bytes, str] = {}
    return [numbered.setdefault(row.tobytes(), str(len(numbered) + 1)) for row in np.ascontiguousarray(commanded)]


def _refuse_two_commands(file: str, pose: Sequence[str], commanded: Floats, lines: Sequence[int]) -> None:
    """One pose has one command."""
    first: dict[str, int] = {}
    mistakes = []
    for k, name in enumerate(pose):
        at = first.setdefault(name, k)
        if np.abs(commanded[k] - commanded[at]).max() > _ROUNDING:
            mistakes.append(
                Problem(
                    file,
                    f"line {lines[k]}",
                    f"another commanded position of pose {name} than in line {lines[at]}",
                    "one command per pose",
                    "P1b as its name",
                )
            )
            if len(mistakes) > _MOST_MISTAKES:
                break
    if mistakes:
        refuse_all(mistakes, _MOST_MISTAKES)


# m: commanded positions of one pose that differ by less are rounding in the file.
_ROUNDING: Final = 1e-6


def _commands(path: Path) -> dict[str, Floats]:
    """Read the commanded pose (4, 4) of every name."""
    header, rows, lines = _table(path)
    columns = _columns(str(path), header, ())
    for role in ("pose", "x"):
        if role not in columns:
            refuse(str(path), "line 1", f"no column {role}", "the commanded poses: pose, x [mm], y [mm], z [mm]", "pose, x [mm], y [mm], z [mm]")
    words, values = _values(str(path), header, rows, lines, columns)
    at, turns = _stacked(values, _ATTAINED), _stacked(values, _TURNED)
    out: dict[str, Floats] = {}
    for k, name in enumerate(words["pose"]):
        assert at is not None  # noqa: S101 - looked at above
        if name in out:
            refuse(str(path), f"line {lines[k]}", f"pose {name} once more", "each pose once", "P1, 600, 0, 400")
        out[name] = pose_of(at[k], (0, 0, 0) if turns is None else turns[k])
    return out


def _rotations(turns: Floats) -> Floats:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_euler("xyz", turns).as_matrix()).reshape(-1, 3, 3)


def _between(command: Floats, attained: Floats) -> Floats:
    """Give the rotation vector (visit, 3), base axes, from commanded orientations to attained ones."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(attained @ np.swapaxes(command, 1, 2)).as_rotvec()).reshape(-1, 3)


def _counted(pose: Sequence[str], side: Sequence[str]) -> Floats:
    seen: dict[tuple[str, str], int] = {}
    out = []
    for each in zip(pose, side, strict=True):
        seen[each] = seen.get(each, 0) + 1
        out.append(seen[each])
    return np.array(out, dtype=float)
