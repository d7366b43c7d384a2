"""Table, cards and sentence of the positioning of an axis by ISO 230-2."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.iso9283.axis_positioning import APPROACHES, POSITIONS
from lostmotion.analyses.iso9283.tables.labels import LONGEST_SIDE
from lostmotion.io.limits import cut
from lostmotion.reporting.sheet import Card, Row, Section, length, several

if TYPE_CHECKING:
    from lostmotion.analyses.iso9283.axis_positioning import AxisPositioning
    from lostmotion.analyses.iso9283.measured import MeasuredRobot

# Symbols of ISO 230-2 in the order of the table; {0} and {1} are the sides of approach.
_NAMES: Final = {
    "A": "A, accuracy, bidirectional",
    "R": "R, repeatability, bidirectional",
    "B": "B, reversal value",
    "mean B": "mean reversal, {0} less {1}",
    "E": "E, systematic deviation, bidirectional",
    "M": "M, mean bidirectional deviation",
    "A1": "A, accuracy from {0}",
    "A2": "A, accuracy from {1}",
    "R1": "R, repeatability from {0}",
    "R2": "R, repeatability from {1}",
    "E1": "E, systematic deviation from {0}",
    "E2": "E, systematic deviation from {1}",
}
_ON_FIRST_SCREEN: Final = {"A": "accuracy A", "R": "repeatability R", "B": "reversal B"}
# Lines that have a table each; of more the note says how many.
_MOST_LINES: Final = 6


def positioning_sections(found: MeasuredRobot) -> list[Section]:
    """Return a table of each axis."""
    lines = _lines(found)
    out = []
    for number, line in enumerate(lines[:_MOST_LINES]):
        sides = [cut(side, LONGEST_SIDE) for side in line.sides]
        counted = f"{len(line.positions)} positions x {line.approaches} approaches"
        rows = tuple(
            Row(name.format(*sides), (length(value, samples=counted),))
            for symbol, name in _NAMES.items()
            for value in (line.figures[symbol],)
        )
        note = (
            f"ISO 230-2:2014, clause 3, from {_at(line)}: {len(line.positions)} positions from "
            f"{line.positions[0] * 1e3:.6g} to "
            f"{line.positions[-1] * 1e3:.6g} mm, each approached "
            f"{several(line.approaches, 'time')} or more from either side"
        )
        if len(line.positions) < POSITIONS or line.approaches < APPROACHES:
            note += (
                f"; the standard asks for {POSITIONS} positions and {APPROACHES} approaches from "
                "either side"
            )
        if number + 1 == _MOST_LINES < len(lines):
            note += f"; {len(lines) - _MOST_LINES} more lines of poses are in result.json"
        out.append(
            Section(
                f"iso230-{line.axis}-{number + 1}",
                f"Measured: {_name(line, lines)} by ISO 230-2",
                ("value",),
                rows,
                note,
            )
        )
    return out


def positioning_sentence(found: MeasuredRobot) -> str:
    """Return the sentence of the headline: accuracy, repeatability and reversal value of each axis;
    empty without one.
    """
    lines = _lines(found)
    each = (
        f"{_name(line, lines)}: "
        + ", ".join(
            f"{name} {length(line.figures[symbol])}" for symbol, name in _ON_FIRST_SCREEN.items()
        )
        for line in lines[:_MOST_LINES]
    )
    return f"By ISO 230-2, from both sides: {'; '.join(each)}." if lines else ""


def positioning_cards(found: MeasuredRobot) -> list[Card]:
    """Return the cards of the first axis."""
    lines = _lines(found)[:1]
    return [
        Card(
            f"{name} measured",
            str(length(line.figures[symbol])),
            f"ISO 230-2, {_name(line, lines)}",
        )
        for line in lines
        for symbol, name in _ON_FIRST_SCREEN.items()
    ]


def positioning_facts(found: MeasuredRobot) -> list[dict[str, Any]]:
    """Return the figures of each axis for result.json, m."""
    return [
        {
            "axis": line.axis,
            "at_m": line.at,
            "load": load.load,
            "sides": list(line.sides),
            "positions_m": line.positions.tolist(),
            "approaches": line.approaches,
            "mean_m": line.mean.tolist(),
            "deviation_m": line.deviation.tolist(),
            "figures_m": line.figures,
        }
        for load in found.loads
        for line in load.axes
    ]


def _lines(found: MeasuredRobot) -> list[AxisPositioning]:
    return [line for load in found.loads for line in load.axes]


def _at(line: AxisPositioning) -> str:
    return ", ".join(f"{axis} {value * 1e3:.6g} mm" for axis, value in line.at.items())


def _name(line: AxisPositioning, lines: list[AxisPositioning]) -> str:
    """Return the axis, with the place of the line where there are several along it."""
    many = sum(each.axis == line.axis for each in lines) > 1
    return f"{line.axis} axis at {_at(line)}" if many else f"{line.axis} axis"
