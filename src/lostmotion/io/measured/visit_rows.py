"""Rows of a CSV of measured visits: their columns, readings that were not taken, shares of the
payload.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import listed, refuse_all
from lostmotion.io.measured.table import MOST_MISTAKES, Layout
from lostmotion.mechanism.tool import MOST_LOAD

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from lostmotion.io.measured.table import RoleColumn, TextTable
    from lostmotion.spatial import Floats

ATTAINED: Final = ("x", "y", "z")
DEVIATION: Final = ("dx", "dy", "dz")
COMMANDED: Final = ("xc", "yc", "zc")
ORIENTATION: Final = ("a", "b", "c")
COMMANDED_ORIENTATION: Final = ("ac", "bc", "cc")
HEADER: Final = "pose, cycle, x [mm], y [mm], z [mm], xc [mm], yc [mm], zc [mm]"
# Decimals of the share of the payload that distinguish loads.
LOAD_DECIMALS: Final = 6
# Header that may be empty in a reading along a path, all three at once.
_OPTIONAL: Final = (COMMANDED, ORIENTATION, COMMANDED_ORIENTATION)
# Cells of a reading that was not taken.
_NO_READING: Final = frozenset({"", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "---"})


def _missing(file: str, names: Collection[str]) -> list[Problem]:
    """Return the mistakes of missing and contradictory columns."""
    out = []
    whole = {
        group: [role for role in group if role in names]
        for group in (ATTAINED, DEVIATION, COMMANDED, ORIENTATION, COMMANDED_ORIENTATION)
    }
    for group, there in whole.items():
        if there and len(there) < len(group):
            missing = [role for role in group if role not in names]
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
    if not whole[COMMANDED] and not {"pose", "path"} & {*names}:
        out.append(
            Problem(
                file,
                "line 1",
                "neither pose nor path nor xc, yc, zc",
                "columns that identify the pose",
                HEADER,
            )
        )
    if "path" in names and "cycle" not in names:
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


VISITS: Final = Layout(
    words=("pose", "path", "side"),
    counts=("cycle",),
    units={
        **dict.fromkeys((*ATTAINED, *DEVIATION, *COMMANDED), ("m", "mm")),
        **dict.fromkeys((*ORIENTATION, *COMMANDED_ORIENTATION), ("rad", "deg")),
        "load": ("1", "%"),
    },
    header=HEADER,
    example="examples/measured/z-arm.csv",
    mapping="xc = x_t [mm]",
    aliases={"approach": "side", "direction": "side"},
    missing=_missing,
    naming=_naming_mistakes,
    empty=_empty_roles,
)


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


def without_lost(
    table: TextTable, columns: Mapping[str, RoleColumn]
) -> tuple[TextTable, list[int]]:
    """Return a table without the rows that have no reading, and the lines of these: an instrument
    that loses its target leaves cells empty.

    A row without any of its attained coordinates has no reading; a whole column without one is no
    lost target, and refused later.
    """
    whole = [len(row) == len(table.header) for row in table.rows]
    optional = ORIENTATION if "path" in columns else ()
    at = [
        columns[role].index
        for role in (*ATTAINED, *DEVIATION, *ORIENTATION)
        if role in columns and role not in optional
    ]
    at = [
        k
        for k in at
        if any(
            ok and row[k].casefold() not in _NO_READING
            for row, ok in zip(table.rows, whole, strict=True)
        )
    ]
    lost = [
        ok and any(row[k].casefold() in _NO_READING for k in at)
        for row, ok in zip(table.rows, whole, strict=True)
    ]
    kept = table.picked([k for k, missing in enumerate(lost) if not missing])
    return kept, [line for line, missing in zip(table.lines, lost, strict=True) if missing]
