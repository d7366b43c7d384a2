"""Tables of figures side by side: predicted and measured ones, and an axis approached from both
sides by ISO 230-2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.iso9283.page.labels import LONGEST_SIDE, estimate_figure, load_label
from lostmotion.io.limits import cut
from lostmotion.laws.iso230 import APPROACHES, POSITIONS
from lostmotion.laws.iso9283 import PATH_FIGURES
from lostmotion.reporting.sheet import Card, length, several, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.sheet import Section
    from lostmotion.standards.axis_positioning import AxisPositioning
    from lostmotion.standards.comparison import ComparedFigure
    from lostmotion.standards.measured_robot import MeasuredRobot

# Figures in the tables, in reading order; result.json has all.
PARTS: Final = ("AP_x", "AP_y", "AP_z", "AP_a", "AP_b", "AP_c")
SHOWN: Final = (
    "AP_p",
    "AP_p fitted",
    "RP_l",
    "RP_a",
    "RP_b",
    "RP_c",
    "vAP_p",
    "AD_p",
    "RD",
    *PATH_FIGURES,
)
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


def comparison_sections(compared: Sequence[ComparedFigure]) -> list[Section]:
    """Return predicted and measured figures side by side for each load: characteristics, and the
    components of AP along and about the axes.
    """
    loads = sorted({each.load for each in compared}, reverse=True)
    out = []
    for load in loads:
        at = "" if load == loads[0] else f"-{100 * load:g}"
        for key, title, names, text in _TABLES:
            rows = [
                _side_by_side(each)
                for name in names
                for each in compared
                if each.load == load and each.name == name
            ]
            within = f"{sum(not note for *_, note in rows)} of {len(rows)}"
            if rows:
                out.append(
                    table(
                        f"{key}{at}",
                        load_label(title, load, loads),
                        ("5 %", "95 %", "measured"),
                        rows,
                        text.format(load=100 * load, within=within),
                    )
                )
    return out


# Key, title, figures and note of each table.
_TABLES: Final = (
    (
        "compared",
        "Predicted and measured",
        SHOWN,
        (
            "5 %, 95 %: percentiles over the simulated robots, at {load:g} % of the payload, with "
            "the measured number of visits and cycles and the stated instrument. High, low: "
            "outside the percentiles; {within} lie within, 90 % expected of this design"
        ),
    ),
    (
        "compared-axes",
        "Predicted and measured: AP by axis",
        PARTS,
        (
            "AP_x, AP_y, AP_z along, AP_a, AP_b, AP_c about the base's axes, signed, without a fit "
            "of frames: errors of the measured base or tool frame count in full; {within} lie "
            "within"
        ),
    ),
)


def _side_by_side(each: ComparedFigure) -> tuple[Any, ...]:
    """Return the row of a figure, marked where the measured robot lies outside the predicted
    range.
    """
    low, high, value = (
        estimate_figure(figure, angle=each.angle)
        for figure in (each.predicted.low, each.predicted.high, each.measured)
    )
    above = each.measured.value > each.predicted.high.value
    word = "" if each.within else "high" if above else "low"
    return f"{each.name}, {each.pose}", low.alone, high.alone, value, word


def positioning_sections(measured: MeasuredRobot) -> list[Section]:
    """Return a table of each axis."""
    lines = _lines(measured)
    out = []
    for number, line in enumerate(lines[:_MOST_LINES]):
        sides = [cut(side, LONGEST_SIDE) for side in line.sides]
        counted = f"{len(line.positions)} positions x {line.approaches} approaches"
        figures = line.figures
        rows = [(name.format(*sides), figures[symbol]) for symbol, name in _NAMES.items()]
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
            table(
                f"iso230-{line.axis}-{number + 1}",
                f"Measured: {_name(line, lines)} by ISO 230-2",
                ("value",),
                rows,
                note,
                unit="m",
                samples=counted,
            )
        )
    return out


def positioning_sentence(measured: MeasuredRobot) -> str:
    """Return the sentence of the headline: accuracy, repeatability and reversal value of each axis;
    empty without one.
    """
    lines = _lines(measured)
    each = (
        f"{_name(line, lines)}: "
        + ", ".join(
            f"{name} {length(line.figures[symbol])}" for symbol, name in _ON_FIRST_SCREEN.items()
        )
        for line in lines[:_MOST_LINES]
    )
    return f"By ISO 230-2, from both sides: {'; '.join(each)}." if lines else ""


def positioning_cards(measured: MeasuredRobot) -> list[Card]:
    """Return the cards of the first axis."""
    lines = _lines(measured)[:1]
    return [
        Card(
            f"{name} measured",
            str(length(line.figures[symbol])),
            f"ISO 230-2, {_name(line, lines)}",
        )
        for line in lines
        for symbol, name in _ON_FIRST_SCREEN.items()
    ]


def positioning_facts(measured: MeasuredRobot) -> list[dict[str, Any]]:
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
        for load in measured.loads
        for line in load.axes
    ]


def _lines(measured: MeasuredRobot) -> list[AxisPositioning]:
    return [line for load in measured.loads for line in load.axes]


def _at(line: AxisPositioning) -> str:
    return ", ".join(f"{axis} {value * 1e3:.6g} mm" for axis, value in line.at.items())


def _name(line: AxisPositioning, lines: list[AxisPositioning]) -> str:
    """Return the axis, with the place of the line where there are several along it."""
    many = sum(each.axis == line.axis for each in lines) > 1
    return f"{line.axis} axis at {_at(line)}" if many else f"{line.axis} axis"
