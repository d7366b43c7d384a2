"""CSV files of measured visits and paths: one row per reading, a header that names each column with
its unit.

    pose, path,  cycle, load [%], x [mm], y [mm], z [mm], a [deg], b [deg], c [deg], xc [mm], yc
                 [mm], zc [mm], ac [deg], bc [deg], cc [deg] P1,   ,      1,     100,      600.02,
                 0.01,  399.95, ...
    ,     P2-P4, 1,     100,      452.11, ...

x, y, z are attained positions of the tool point in the base frame, xc, yc, zc commanded ones; dx,
dy, dz may replace the attained ones and are attained less commanded, or the reverse where a line
`# sign: commanded - attained` above the rows states so. a, b, c and ac, bc, cc are rotations about
the fixed x, y, z axes, in that order. `side` names the side from which a pose was approached, for
vAP; it is empty in the standard's cycle. `load` is a share of the payload; default: that of the
whole file, else the full payload. Only positions are required. Without `pose`, rows with the same
commanded position are one pose. A cycle visits a pose once. Other lines that begin with # are
comments. Cells are separated by commas or semicolons; numbers have decimal points throughout, or
decimal commas throughout. Header with other names are mapped: "xc = x_t [mm]", or "dx = -x_dif
[mm]" where the file has commanded less attained.

A row with `path`, the names of the poses that a straight line joins, is a reading along it, in the
order read, cycle by cycle; `pose` is then empty, commands and rotations may be.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.errors import InputError, Problem, refuse_argument, shown
from lostmotion.io.limits import refuse_all
from lostmotion.io.measured.difference_sign import stated_sign
from lostmotion.io.measured.table import (
    MOST_MISTAKES,
    find_columns,
    read_columns,
    read_table,
    role_values,
    without_repeats,
)
from lostmotion.io.measured.visit_rows import (
    ATTAINED,
    COMMANDED,
    COMMANDED_ORIENTATION,
    DEVIATION,
    HEADER,
    LOAD_DECIMALS,
    ORIENTATION,
    VISITS,
    payload_shares,
    without_lost,
)
from lostmotion.io.measured.visits import ARRAYS, TUPLES, Visits
from lostmotion.io.text import refuse
from lostmotion.mechanism.tool import MOST_LOAD
from lostmotion.spatial import pose_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.io.measured.table import TextTable
    from lostmotion.spatial import Floats

# Most loads for one robot.
MOST_LOADS: Final = 5
_MOST_FILES: Final = 20


def read_measured(
    path: str | Path | Sequence[str | Path],
    mapping: Sequence[str] = (),
    commands: str | Path | None = None,
    instrument: float = 0.0,
    loads: Sequence[float] = (),
) -> Visits:
    """Return the visits and readings of these CSV files, without rows that repeat another one in
    every column that is read.

    path        one file, or several of one robot
    mapping     "role = column [unit]", several in one text separated by commas, or several texts;
                roles as listed at the top of this file
    commands    CSV with the names of poses and their commanded positions (and rotations) in x, y, z
                (a, b, c), where the files state none
    instrument  standard deviation of one reading of a coordinate, m
    loads       share of the payload for each file without a `load` column
    Raises InputError with the first 20 mistakes and their lines.
    """
    files = [Path(path)] if isinstance(path, str | Path) else [Path(each) for each in path]
    if not 1 <= len(files) <= _MOST_FILES:
        raise refuse_argument(
            "measured", f"{len(files)} files", f"1 to {_MOST_FILES}", measured="visits.csv"
        )
    if len(loads) not in {0, len(files)}:
        raise refuse_argument(
            "load",
            f"{len(loads)} for {len(files)} measured files",
            "one for each file, in their order",
            load="100 %",
        )
    if not all(0 <= load <= MOST_LOAD for load in loads):
        raise refuse_argument(
            "load", tuple(loads), f"shares of the payload, from 0 to {MOST_LOAD:g}", load="10 %"
        )
    tables = [read_table(each, VISITS) for each in files]
    names = {name for table in tables for name in table.names} if len(files) > 1 else set()
    named: Sequence[float | None] = loads or [None] * len(files)
    parts: list[Visits] = []
    mistakes: list[Problem] = []
    for table, load in zip(tables, named, strict=True):
        try:
            parts.append(_rows_of(table, mapping, names, load))
        except InputError as error:
            mistakes += error.problems
    if mistakes:
        refuse_all(mistakes, MOST_MISTAKES)
    found = parts[0] if len(parts) == 1 else combined(parts)
    if len(kinds := dict.fromkeys(found.load.tolist())) > MOST_LOADS:
        refuse(
            str(files[0]),
            "load",
            f"{len(kinds)} loads",
            f"at most {MOST_LOADS}",
            "10 % and 100 % of the payload",
        )
    _refuse_two_commands(found)
    stated = {
        name: k
        for k, name in reversed(list(enumerate(found.pose)))
        if name and np.isfinite(found.command[k]).all()
    }
    known = {name: found.commanded_pose(k) for name, k in stated.items()}
    if commands is not None:
        known = _commands(Path(commands)) | known
    found = found.commanded(known)
    _refuse_other_unit(found)
    found = replace(found, cycle=_cycle_numbers(found), instrument=instrument)
    _refuse_repeated_cycles(found)
    return found


def _rows_of(
    table: TextTable, mapping: Sequence[str], elsewhere: set[str], load: float | None
) -> Visits:
    """Return the rows of one file."""
    columns = find_columns(table, mapping, VISITS, elsewhere)
    file, names = table.file, table.names
    table, lost = without_lost(table, columns.of)
    if not table.rows:
        refuse(
            file,
            f"line {lost[0]}",
            "no reading in any row",
            "attained positions, at least two visits to a pose",
            HEADER,
        )
    table, duplicates, unread = without_repeats(table, columns.of)
    used = {column.index for column in columns.of.values()}
    sign, columns = stated_sign(table, columns, DEVIATION)
    words, values = role_values(table, columns, VISITS)
    lines, count = table.lines, len(table.rows)
    nothing = np.full((count, 3), math.nan)
    path = words.get("path", [""] * count)
    command = _stacked(values, COMMANDED, nothing)
    pose = words.get("pose") or _by_command(command, path)
    shares = payload_shares(file, lines, values.get("load"), load, count)
    return Visits(
        pose=tuple(pose),
        path=tuple(path),
        cycle=values.get("cycle", np.full(count, math.nan)),
        side=tuple(words.get("side", [""] * count)),
        load=np.round(shares, LOAD_DECIMALS),
        attained=command + (sign or 1) * _stacked(values, DEVIATION, nothing)
        if DEVIATION[0] in values
        else _stacked(values, ATTAINED, nothing),
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
        unused=tuple(name for at, name in enumerate(names) if at not in used and name),
        lost=tuple((file, line) for line in lost),
    )


def combined(parts: Sequence[Visits]) -> Visits:
    """Return the rows of several files of one robot; the instrument is that of the first."""
    rows: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAYS
    }
    rows |= {name: tuple(each for part in parts for each in getattr(part, name)) for name in TUPLES}
    totals: dict[str, Any] = {
        "duplicates": sum(part.duplicates for part in parts),
        "source": ", ".join(part.source for part in parts),
    }
    totals |= {
        name: tuple(dict.fromkeys(each for part in parts for each in getattr(part, name)))
        for name in ("unread", "unused", "lost")
    }
    return replace(parts[0], load_stated=all(part.load_stated for part in parts), **rows, **totals)


def _stacked(values: Mapping[str, Floats], roles: tuple[str, ...], otherwise: Floats) -> Floats:
    return np.stack([values[role] for role in roles], axis=-1) if roles[0] in values else otherwise


def _by_command(commanded: Floats, path: Sequence[str]) -> list[str]:
    """Return numbers as names of poses, the same for rows with the same commanded position."""
    numbered: dict[bytes, str] = {}
    return [
        "" if along else numbered.setdefault(row.tobytes(), str(len(numbered) + 1))
        for row, along in zip(np.ascontiguousarray(commanded), path, strict=True)
    ]


def _refuse_two_commands(visits: Visits) -> None:
    """Raise InputError where rows of one pose state different commanded positions."""
    first: dict[str, int] = {}
    mistakes = []
    for k, name in enumerate(visits.pose):
        if not name or not np.isfinite(visits.command[k]).all():
            continue
        at = first.setdefault(name, k)
        if np.abs(visits.command[k] - visits.command[at]).max() > _ROUNDING:
            (file, line), (other, before) = visits.where[k], visits.where[at]
            found = (
                f"another commanded position of pose {name} than in "
                f"{'' if file == other else other + ', '}line {before}"
            )
            mistakes.append(
                Problem(
                    file,
                    f"line {line}",
                    found,
                    "one command per pose",
                    "P1b as the name of the second",
                )
            )
            if len(mistakes) > MOST_MISTAKES:
                break
    if mistakes:
        refuse_all(mistakes, MOST_MISTAKES)


def _refuse_repeated_cycles(visits: Visits) -> None:
    """Raise InputError where a cycle visits one pose twice: which one belongs to the other poses of
    that cycle is unknown.
    """
    first: dict[tuple[str, str, float, float], int] = {}
    mistakes: list[Problem] = []
    for k, visit in enumerate(
        zip(visits.pose, visits.side, visits.load.tolist(), visits.cycle.tolist(), strict=True)
    ):
        if visit[0] and len(mistakes) < MOST_MISTAKES and (at := first.setdefault(visit, k)) != k:
            (file, line), (other, before) = visits.where[k], visits.where[at]
            stands = f"line {before}" if file == other else f"{other}, line {before}"
            found = (
                f"pose {shown(visit[0])} of cycle {visit[3]:g} a second time: {stands} has another "
                f"{_differing_coordinates(visits, k, at)}"
            )
            mistakes.append(
                Problem(
                    file,
                    f"line {line}",
                    found,
                    "one visit per pose, side, load and cycle",
                    "delete the invalid row, or renumber it",
                )
            )
    if mistakes:
        raise InputError(mistakes)


def _differing_coordinates(visits: Visits, one: int, other: int) -> str:
    """Return the names of the coordinates in which two readings of one pose differ."""
    moved = visits.attained[one] != visits.attained[other]
    turned = (
        np.isfinite(visits.orientation[[one, other]]).all()
        and (visits.orientation[one] != visits.orientation[other]).any()
    )
    names = [axis for axis, different in zip("xyz", moved, strict=True) if different] + (
        ["orientation (a, b, c)"] if turned else []
    )
    return ", ".join(names) or "row"


def _refuse_other_unit(visits: Visits) -> None:
    """Raise InputError where the attained positions are the commanded ones times a ratio of units:
    one of the two headings is wrong.
    """
    known = np.isfinite(visits.command).all(axis=1) & np.isfinite(visits.attained).all(axis=1)
    command, attained = visits.command[known], visits.attained[known]
    if not (square := float((command**2).sum())):
        return
    ratio = float((attained * command).sum()) / square
    unit = next((each for each in _UNIT_RATIOS if abs(ratio / each - 1) < _UNIT_SAME), None)
    if unit is None or np.linalg.norm(attained - ratio * command) > _UNIT_SAME * np.linalg.norm(
        attained
    ):
        return
    k = int(np.flatnonzero(known)[0])
    (file, line), apart = (
        visits.where[k],
        (f"{each * 1e3:.6g} mm" for each in map(np.linalg.norm, (attained[0], command[0]))),
    )
    found = (
        "attained positions {} from the origin where {} is commanded: {:g} times as far in all rows"
    ).format(*apart, unit)
    refuse(
        file,
        f"line {line}, x, y, z",
        found,
        "the units of both in the header, as they are in the file",
        "x [m], y [m], z [m], xc [mm], yc [mm], zc [mm]",
    )


# Ratios of the units in which lengths are written, and how closely positions follow one, as a share
# of their distance from the origin.
_UNIT_RATIOS: Final = (1e-6, 1e-3, 1e-2, 0.1, 1 / 25.4, 25.4, 10.0, 1e2, 1e3, 1e6)
_UNIT_SAME: Final = 0.02
# Rounding of commanded positions of one pose in the file, m.
_ROUNDING: Final = 1e-6


def _commands(path: Path) -> dict[str, Floats]:
    """Return the commanded pose (4, 4) of every name in a file."""
    words, values, lines = read_columns(path, VISITS)
    for role in ("pose", "x"):
        if role not in {*words, *values}:
            refuse(
                str(path),
                "line 1",
                f"no column {role}",
                "the commanded poses: pose, x [mm], y [mm], z [mm]",
                "pose, x [mm], y [mm], z [mm]",
            )
    nothing = np.full((len(lines), 3), math.nan)
    at, rotation = (
        _stacked(values, ATTAINED, nothing),
        _rotations(_stacked(values, ORIENTATION, nothing)),
    )
    out: dict[str, Floats] = {}
    for k, name in enumerate(words["pose"]):
        if name in out:
            refuse(
                str(path),
                f"line {lines[k]}",
                f"pose {name} a second time",
                "each pose once",
                "P1, 600, 0, 400",
            )
        out[name] = pose_of(at[k])
        out[name][:3, :3] = rotation[k]  # NaN where the file states no rotations
    return out


def _rotations(turns: Floats) -> Floats:
    """Return rotation matrices (row, 3, 3) from rotations (row, 3) about the fixed axes; NaN where
    there are none.
    """
    from scipy.spatial.transform import Rotation

    out = np.full((len(turns), 3, 3), math.nan)
    if (known := np.isfinite(turns).all(axis=1)).any():
        out[known] = Rotation.from_euler("xyz", turns[known]).as_matrix()
    return out


def _cycle_numbers(visits: Visits) -> Floats:
    """Return cycle numbers, counted within pose, side and load where none are stated."""
    seen: dict[tuple[str, str, float], int] = {}
    out = visits.cycle.copy()
    for k in np.flatnonzero(np.isnan(out)).tolist():
        each = visits.pose[k], visits.side[k], float(visits.load[k])
        seen[each] = seen.get(each, 0) + 1
        out[k] = seen[each]
    return out
