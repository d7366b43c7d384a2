"""Path of the tool in G-code (RS-274): G0, G1, G2 and G3 in mm or inch, absolute or relative, arcs
by centre or radius in any of the three planes.

Feeds, spindles, coolants, tool numbers and extruders move no axis and are skipped. What would move
the tool otherwise (canned cycles, radius and length compensation, splines, rotary axes) is refused.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import MOST_MISTAKES, refuse_all
from lostmotion.io.text import read_text

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.spatial import Floats

_MEGABYTES: Final = 5
COMMENT: Final = re.compile(r"\([^()]*\)|;.*")
# "X1e3" is refused: it is not known whether it is X 1000, or X 1 and 3 of an extruder.
_WORD: Final = re.compile(r"\s*([A-Za-z])\s*([+-]?(?:\d+\.?\d*|\.\d+))(?![eE][0-9+-])")
# m, by the code that chooses them: inches, millimetres.
UNITS: Final = {20.0: 0.0254, 21.0: 0.001}
_MOTIONS: Final = (0.0, 1.0, 2.0, 3.0)
_PLANES: Final = {17.0: (0, 1, 2), 18.0: (2, 0, 1), 19.0: (1, 2, 0)}
# Codes that move no axis: dwell, modes of feed, of stops and of coordinates without an offset.
_STILL: Final = frozenset({4.0, 40.0, 49.0, 54.0, 61.0, 64.0, 80.0, 93.0, 94.0, 95.0, 98.0, 99.0})
_SKIPPED: Final = frozenset("NFSTMHDPEOLQ")
# Difference of the two radii of an arc, as a share of it.
_OFF: Final = 1e-3
# rad; an arc that ends where it begins is a full circle.
_CLOSED: Final = 1e-9
# Steps along one move.
_LONGEST: Final = 100_000
_EXAMPLE: Final = "G1 X10 Y20"


@dataclass(frozen=True)
class ToolMoves:
    """Points that the tool visits, sampled.

    points   (row, 3) m
    visited  (row,) whether the tool works there: False at the end of a rapid move
    path     number of the cutting path that each row belongs to, from 1; 0 for rapid moves
    lines    number of the line of each row
    """

    points: Floats
    visited: np.ndarray
    path: tuple[int, ...]
    lines: tuple[int, ...]


@dataclass
class _Machine:
    """Modes and position while a program is read."""

    position: Floats = field(default_factory=lambda: np.zeros(3))
    unit: float = UNITS[21.0]
    relative: bool = False
    centre_absolute: bool = False
    motion: float | None = None
    plane: tuple[int, int, int] = (0, 1, 2)
    cutting: bool = False
    path: int = 0
    points: list[Floats] = field(default_factory=list)
    visited: list[bool] = field(default_factory=list)
    paths: list[int] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)

    def visit(self, point: Floats, line: int, *, works: bool) -> None:
        """Add a row."""
        self.points.append(np.array(point))
        self.visited.append(works)
        self.paths.append(self.path if works else 0)
        self.lines.append(line)


def read_gcode(path: Path, step: float, most: int) -> ToolMoves:
    """Return the points of a program, cutting moves sampled by `step` (m). Raises InputError with
    every mistake and its line, and where there are more than `most` points.
    """
    file, machine, mistakes = str(path), _Machine(), list[Problem]()
    for number, text in enumerate(read_text(path, _MEGABYTES, "part.gcode").splitlines(), 1):
        bare = COMMENT.sub("", text).strip()
        if not bare or bare.startswith(("%", "/")):
            continue
        try:
            _obey(machine, _words(bare), number, step)
        except ValueError as error:
            found, _, expected = str(error).partition("; ")
            mistakes.append(Problem(file, f"line {number}", found, expected, _EXAMPLE))
        if len(machine.points) > most:
            found, expected = f"more than {most} points", f"at most {most}"
            mistakes.append(Problem(file, f"line {number}", found, expected, 'step = "20 mm"'))
        if len(mistakes) > MOST_MISTAKES or len(machine.points) > most:
            break
    if not mistakes and not any(machine.visited):
        mistakes.append(Problem(file, "", "no cutting move", "G1, G2 or G3", _EXAMPLE))
    if mistakes:
        refuse_all(mistakes)
    return ToolMoves(
        np.array(machine.points),
        np.array(machine.visited),
        tuple(machine.paths),
        tuple(machine.lines),
    )


def _words(text: str) -> list[tuple[str, float]]:
    out, at = [], 0
    while at < len(text.rstrip()):
        match = _WORD.match(text, at)
        if match is None:
            raise ValueError(f"{shown(text[at:])}; letters, each with a number")
        out.append((match[1].upper(), float(match[2])))
        at = match.end()
    return out


def _obey(machine: _Machine, words: list[tuple[str, float]], line: int, step: float) -> None:
    """Change the modes, then carry out the move of a line. Raises ValueError for what it lacks."""
    values: dict[str, float] = {}
    for letter, number in words:
        if letter == "G":
            _mode(machine, number)
        elif letter in "XYZIJKR":
            if letter in values:
                raise ValueError(f"{letter} twice; each axis once")
            values[letter] = number * machine.unit
        elif letter not in _SKIPPED:
            raise ValueError(f"{letter}{number:g}; X, Y, Z only: no other axis")
    arc = machine.motion in {2.0, 3.0}
    if values.keys() & set("XYZ") or (values and arc):
        _move(machine, values, line, step)


def _move(machine: _Machine, values: dict[str, float], line: int, step: float) -> None:
    """Carry out a move, and add the rows that it visits."""
    if machine.motion is None:
        raise ValueError("a position before any motion; G0 or G1 before it")
    end = machine.position.copy()
    for k, axis in enumerate("XYZ"):
        if axis in values:
            end[k] = values[axis] + (machine.position[k] if machine.relative else 0.0)
    works = machine.motion != 0.0
    if works and not machine.cutting:
        machine.path += 1
        machine.visit(machine.position, line, works=True)
    machine.cutting = works
    if not works:
        way = end[None]
    elif machine.motion == 1.0:
        way = _straight(machine.position, end, step)
    else:
        way = _arc(machine, end, values, step)
    for point in way:
        machine.visit(point, line, works=works)
    machine.position = end


def _mode(machine: _Machine, number: float) -> None:
    """Change a mode. Raises ValueError for a code that is not known."""
    if number in _MOTIONS:
        machine.motion = number
    elif number in _PLANES:
        machine.plane = _PLANES[number]
    elif number in UNITS:
        machine.unit = UNITS[number]
    elif number in {90.0, 91.0}:
        machine.relative = number == 91.0  # noqa: PLR2004 - G91, relative
    elif number in {90.1, 91.1}:
        machine.centre_absolute = number == 90.1  # noqa: PLR2004 - G90.1, absolute
    elif number not in _STILL:
        raise ValueError(f"G{number:g}; G0 to G3, G17 to G21, G90, G91 and codes without motion")


def _count(length: float, step: float) -> int:
    """Return the number of steps along a move. Raises ValueError where it is beyond any task."""
    if not length <= _LONGEST * step:
        raise ValueError(f"a move of {length:.3g} m; at most {_LONGEST} steps")
    return max(math.ceil(length / step - 1e-9), 1)


def _straight(start: Floats, end: Floats, step: float) -> Floats:
    count = _count(float(np.linalg.norm(end - start)), step)
    return np.asarray(start + np.arange(1, count + 1)[:, None] / count * (end - start))


def _arc(machine: _Machine, end: Floats, values: dict[str, float], step: float) -> Floats:
    """Return the points of an arc or a helix. Raises ValueError for one without a centre, or whose
    ends are not at one distance from it.
    """
    a, b, c = machine.plane
    start, clockwise = machine.position, machine.motion == 2.0  # noqa: PLR2004 - G2, clockwise
    here, there = start[[a, b]], end[[a, b]]
    if "R" in values:
        centre = _by_radius(here, there, values["R"], clockwise=clockwise)
    elif values.keys() & {"IJK"[a], "IJK"[b]}:
        off = np.array([values.get("IJK"[k], 0.0) for k in (a, b)])
        centre = off if machine.centre_absolute else here + off
    else:
        raise ValueError("an arc without a centre; I, J or K of its plane, or R")
    first, last = here - centre, there - centre
    radius = float(np.linalg.norm(first))
    if abs(float(np.linalg.norm(last)) - radius) > _OFF * radius or not radius:
        raise ValueError("an arc whose ends are not at one distance from its centre; another I, J")
    begin, close = math.atan2(first[1], first[0]), math.atan2(last[1], last[0])
    turn = (begin - close if clockwise else close - begin) % (2 * math.pi)
    turn = turn if turn > _CLOSED else 2 * math.pi
    count = max(_count(math.hypot(radius * turn, float(end[c] - start[c])), step), 3)
    share = np.arange(1, count + 1) / count
    angle = begin + (-turn if clockwise else turn) * share
    out = np.empty((count, 3))
    out[:, a], out[:, b] = centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
    out[:, c] = start[c] + share * (end[c] - start[c])
    out[-1] = end
    return out


def _by_radius(here: Floats, there: Floats, radius: float, *, clockwise: bool) -> Floats:
    """Return the centre (2,) of an arc of this radius; a negative one is the longer way round."""
    chord = there - here
    far = float(np.linalg.norm(chord))
    if not far or far > 2 * abs(radius) * (1 + _OFF):
        raise ValueError("a radius that joins no such ends; at least half of their distance")
    height = math.sqrt(max(radius**2 - far**2 / 4, 0.0))
    left = np.array([-chord[1], chord[0]]) / far
    return np.asarray(here + chord / 2 + left * height * (-1 if clockwise == (radius > 0) else 1))
