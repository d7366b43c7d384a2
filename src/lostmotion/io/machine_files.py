"""Wanted poses as a machine has them, and the same file with corrected ones.

A CSV of joint values, or of poses of the tool, becomes one of joint values. Of a program in G-code
the ends of straight moves change, and everything else stays: comments, feeds, extruders, spindles.
Its words are joint values where the joints of the arm are named as axes (X, Y, Z, A, ...), as on a
mill or a printer with one drive per axis. Else X, Y and Z are the tool point in the base's frame,
for a machine whose firmware computes the joint values.
"""

from __future__ import annotations

import csv
import io
import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.joint_path import joint_path
from lostmotion.errors import Problem, shown
from lostmotion.io.gcode import COMMENT, UNITS
from lostmotion.io.limits import MOST_MISTAKES, refuse_all
from lostmotion.io.text import read_text
from lostmotion.io.tool_path import read_tool_path
from lostmotion.mechanism.state import tool_points
from lostmotion.spatial import pose_of

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence
    from pathlib import Path

    from lostmotion.io.tool_path import PathRows
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_MEGABYTES: Final = 20
_OF_POSES: Final = frozenset({"x", "y", "z", "roll", "pitch", "yaw"})
_WORD: Final = re.compile(r"([A-Za-z])\s*([+-]?(?:\d+\.?\d*|\.\d+))")
_AXES: Final = "XYZABCUVW"
_DEGREE: Final = math.pi / 180
_ARCS: Final = {2.0: "G2", 3.0: "G3", 5.0: "G5"}
# Codes that shift the origin, and those behind which the position is not known: homing, and a move
# in machine coordinates.
_SHIFTS: Final = frozenset({10.0, 52.0, 92.0})
_LOST: Final = frozenset({28.0, 30.0, 53.0})


def _followed(
    arm: Arm, wanted: Floats, where: Sequence[tuple[str, str]], *, with_orientation: bool
) -> Floats:
    """Return the joint values along poses of the tool. Raises InputError with the line of the first
    one that is not reached.
    """
    q, count = joint_path(arm, wanted, with_orientation=with_orientation)
    if count < len(wanted):
        file, line = where[count]
        at = ", ".join(f"{1e3 * each:g} mm" for each in wanted[count, :3, 3].tolist())
        expected = "a pose that the arm reaches from the one before it, within its limits"
        refuse_all([Problem(file, line, f"a tool at {at}", expected, "300 mm, 0 mm, 200 mm")])
    return q


class PoseTable:
    """A CSV of joint values or of poses of the tool.

    q      (row, joint) wanted joint values, rad or m
    side   (row, joint) sign of each joint's last motion where the file states it; NaN elsewhere
    where  file and line of each row
    """

    def __init__(self, path: Path, arm: Arm) -> None:
        """Read the file. Raises InputError with every mistake, and the line of the first pose that
        is out of reach.
        """
        self._arm = arm
        stated = read_tool_path(path, arm)
        self.side, self.where = stated.approach, stated.where
        self.q = self._joints(stated) if stated.q is None else stated.q
        table = csv.reader(io.StringIO(read_text(path, _MEGABYTES)))
        header, *self._body = [row for row in table if row]
        self._names = [heading.partition("[")[0].strip() for heading in header]
        self._header = header

    def _joints(self, stated: PathRows) -> Floats:
        turned = [(0.0, 0.0, 0.0)] * len(self.where) if stated.rpy is None else stated.rpy
        wanted = np.array(
            [pose_of(at, turn) for at, turn in zip(stated.xyz, turned, strict=True)]  # type: ignore[arg-type]
        )
        return _followed(self._arm, wanted, self.where, with_orientation=stated.rpy is not None)

    def text(self, command: Floats) -> str:
        """Return the CSV with the joint values to send, in degrees and mm; columns that are neither
        joints nor poses of the tool stay as they are.
        """
        joints = self._arm.driven
        units = [("deg", 180 / math.pi) if each.twist[:3].any() else ("mm", 1e3) for each in joints]
        gone = _OF_POSES | {each.name for each in joints}
        kept = [k for k, name in enumerate(self._names) if name not in gone]
        out = io.StringIO()
        write = csv.writer(out, lineterminator="\n").writerow
        write(
            [f"{each.name} [{unit}]" for each, (unit, _) in zip(joints, units, strict=True)]
            + [self._header[k] for k in kept]
        )
        for row, values in zip(self._body, command, strict=True):
            cells = [
                f"{round(value * size, 7) + 0.0:.7f}"
                for value, (_, size) in zip(values, units, strict=True)
            ]
            write(cells + [row[k] for k in kept])
        return out.getvalue()


@dataclass
class _Modes:
    """What the words of a program mean: the unit of lengths in m, and the kind of motion."""

    unit: float = UNITS[21.0]
    relative: bool = False
    straight: bool = False

    def refused(self, codes: Sequence[float], axes: Collection[str], known: Sequence[str]) -> str:
        """Follow the codes of a line with these axes, and return what cannot be corrected."""
        for code in codes:
            if code in {0.0, 1.0}:
                self.straight = True
            elif code in _ARCS:
                self.straight = False
                return f"an arc, {_ARCS[code]}"
            elif code in UNITS:
                self.unit = UNITS[code]
            elif code in {90.0, 91.0}:
                self.relative = code == 91.0  # noqa: PLR2004 - G91, relative
            elif code in _SHIFTS and axes:
                return f"a shifted origin, G{code:g}"
        if not axes or not self.straight or _LOST & set(codes):
            return ""
        other = sorted(set(axes) - set(known))
        if other:
            return f"{', '.join(other)} of a machine with {', '.join(known)}"
        return ""


class MoveProgram:
    """A program whose straight moves are corrected at their ends.

    q        (move, joint) wanted joint values, rad or m, of the moves whose position is known in
             all axes
    side     (move, joint) sign of each joint's last motion, NaN
    where    file and line of each move
    unknown  number of moves before the position is known in all axes, which stay as they are
    """

    def __init__(self, path: Path, arm: Arm) -> None:
        """Read the file. Raises InputError with every mistake and its line: arcs, shifted origins,
        and positions outside the limits or out of reach.
        """
        self._arm, self._file, self.unknown = arm, str(path), 0
        names = [each.name.upper() for each in arm.driven]
        self._direct = set(names) <= set(_AXES)
        self._letters = names if self._direct else list("XYZ")
        self._lines = read_text(path, _MEGABYTES).splitlines()
        self._moves: list[tuple[int, float, bool]] = []
        targets: list[list[float]] = []
        mistakes = self._read(targets)
        if not targets and not mistakes:
            mistakes = [
                Problem(
                    self._file,
                    "",
                    "no straight move to a position in all axes",
                    "G0 or G1 in absolute positions, G90",
                    "G1 X10 Y20 Z5",
                )
            ]
        if mistakes:
            refuse_all(mistakes)
        at = np.array(targets)
        self.where = tuple((self._file, f"line {line + 1}") for line, *_ in self._moves)
        self.q = at if self._direct else self._joints(at)
        self._refuse_outside()
        self.side = np.full(self.q.shape, math.nan)

    def _read(self, targets: list[list[float]]) -> list[Problem]:
        mistakes: list[Problem] = []
        position: dict[str, float] = {}
        modes = _Modes()
        for number, text in enumerate(self._lines):
            words = [
                (letter.upper(), float(value))
                for letter, value in _WORD.findall(COMMENT.sub("", text))
            ]
            axes = {letter: value for letter, value in words if letter in _AXES}
            codes = [value for letter, value in words if letter == "G"]
            found = modes.refused(codes, axes, self._letters)
            if found:
                expected = "straight moves to absolute positions (have arcs written as lines)"
                mistakes.append(
                    Problem(self._file, f"line {number + 1}", found, expected, "G1 X10 Y20 Z5")
                )
                if len(mistakes) > MOST_MISTAKES:
                    break
            elif _LOST & set(codes):
                position = {}
            elif axes and modes.straight:
                for letter, value in axes.items():
                    size = value * self._factor(letter, modes.unit)
                    if not modes.relative:
                        position[letter] = size
                    elif letter in position:
                        position[letter] += size
                if len(position) == len(self._letters):
                    self._moves.append((number, modes.unit, modes.relative))
                    targets.append([position[letter] for letter in self._letters])
                else:
                    self.unknown += 1
        return mistakes

    def _factor(self, letter: str, unit: float) -> float:
        """Return the SI value of an axis' unit."""
        if not self._direct:
            return unit
        joint = self._arm.driven[self._letters.index(letter)]
        return _DEGREE if joint.twist[:3].any() else unit

    def _joints(self, points: Floats) -> Floats:
        wanted = np.tile(np.eye(4), (len(points), 1, 1))
        wanted[:, :3, 3] = points
        return _followed(self._arm, wanted, self.where, with_orientation=False)

    def _refuse_outside(self) -> None:
        low, high = self._arm.limits.T
        rows = np.flatnonzero(((self.q < low - 1e-9) | (self.q > high + 1e-9)).any(axis=1))
        self.q = np.clip(self.q, low, high)
        mistakes = []
        for row in rows[: MOST_MISTAKES + 1]:
            (file, line), text = self.where[row], self._lines[self._moves[row][0]]
            expected = "axes within the limits of the arm file"
            mistakes.append(Problem(file, line, shown(text), expected, "G1 X10 Y20 Z5"))
        if mistakes:
            refuse_all(mistakes)

    def text(self, command: Floats) -> str:
        """Return the program for the joint values to send: every corrected move states all axes."""
        to = command if self._direct else tool_points(self._arm, command)
        lines, sent = list(self._lines), np.zeros(len(self._letters))
        for (number, unit, relative), values in zip(self._moves, to, strict=True):
            start = sent if relative else np.zeros(len(sent))
            factors = np.array([self._factor(letter, unit) for letter in self._letters])
            printed = np.round((values - start) / factors, 5) + 0.0
            sent = start + printed * factors  # so that rounding does not add up over relative moves
            new = {
                letter: f"{letter}{value:.5f}"
                for letter, value in zip(self._letters, printed.tolist(), strict=True)
            }
            code = COMMENT.split(lines[number])[0].rstrip()
            rest = lines[number][len(code) :]
            stated = {match[1].upper() for match in _WORD.finditer(code)}
            code = _WORD.sub(lambda match, new=new: new.get(match[1].upper(), match[0]), code)
            missing = [word for letter, word in new.items() if letter not in stated]
            lines[number] = " ".join([code, *missing]) + rest
        return "\n".join(lines) + "\n"
