"""Figures of a measured robot, in tables and plots: side by side with the predicted ones, over
poses, along paths, and of an axis approached from both sides by ISO 230-2.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.iso9283.page.labels import (
    LONGEST_SIDE,
    estimate_figure,
    load_label,
    measured_label,
)
from lostmotion.io.limits import cut
from lostmotion.laws.iso230 import APPROACHES, POSITIONS
from lostmotion.laws.iso9283 import PATH_FIGURES
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.reporting.chart import (
    axes,
    figure,
    grid,
    label,
    label_axes,
    legend,
    logarithmic,
    named_rows,
    one,
)
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.sheet import Card, length, several, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from lostmotion.reporting.sheet import Section
    from lostmotion.standards.axis_positioning import AxisPositioning
    from lostmotion.standards.comparison import ComparedFigure
    from lostmotion.standards.measured_robot import MeasuredLoad, MeasuredRobot

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
_SMALLEST: Final = 1e-10
_COLOURS: Final = (LIGHT["robot"], LIGHT["design"], LIGHT["visit"], LIGHT["warn"])
# From so many poses on, their names stand upright.
_UPRIGHT_NAMES: Final = 9


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


def side_by_side(compared: list[ComparedFigure]) -> Figure:
    """Return the measured lengths over the range from the 5th to the 95th percentile of the
    predicted robots.
    """
    shown = [
        each
        for name in SHOWN
        for each in compared
        if each.name == name and not each.angle and each.name != "AD_p" and each.measured.value > 0
    ]
    shown = [each for each in shown if each.predicted.high.value > _SMALLEST]
    order = {
        key: k for k, key in enumerate(dict.fromkeys((each.name, each.pose) for each in shown))
    }
    shown.sort(key=lambda each: (order[each.name, each.pose], -each.load))
    made, on = one("Predicted and measured", 44 + 6 * len(shown))
    grid(on, "x")
    for row, each in enumerate(shown):
        low, high = (
            max(end, _SMALLEST) * 1e6
            for end in (each.predicted.low.value, each.predicted.high.value)
        )
        # Lines instead of bars, which need a base that a logarithmic axis does not have.
        on.plot(
            [low, high],
            [row, row],
            color=LIGHT["c1"],
            linewidth=8,
            solid_capstyle="butt",
            label="predicted, 5th to 95th percentile",
        )
        how: dict[str, Any] = {
            "linestyle": "none",
            "marker": "|",
            "markersize": 9,
            "markeredgewidth": 1.6,
            "color": LIGHT["robot"],
        }
        on.plot([each.predicted.mean.value * 1e6], [row], label="mean over robots", **how)
        value = each.measured.value * 1e6
        ends = [
            [abs(end * 1e6 - value) if math.isfinite(end) else 0.0]
            for end in (each.measured.low, each.measured.high)
        ]
        inside = (
            ("measured, within", LIGHT["visit"])
            if each.within
            else ("measured, outside", LIGHT["warn"])
        )
        on.errorbar(
            [value],
            [row],
            xerr=ends,
            fmt="D",
            color=inside[1],
            markersize=4,
            ecolor=LIGHT["ink"],
            elinewidth=1.0,
            label=inside[0],
        )
    logarithmic(on)
    loads = {each.load for each in shown}
    named_rows(
        on, [load_label(f"{each.name}, {label(each.pose)}", each.load, loads) for each in shown]
    )
    label_axes(on, "length, logarithmic [µm]")
    legend(made)
    return made


def measured_accuracy(measured: MeasuredLoad, title: str = "Measured AP_p") -> Figure:
    """Return bars or a histogram of measured AP_p over the poses, with commanded and with best-fit
    frames.
    """
    raw = np.array([pose.accuracy.value for pose in measured.poses])
    fitted = np.array([pose.fitted for pose in measured.poses])
    unit = unit_of_length(float(raw.max()))
    factor = factor_of(unit)
    made, on = one(title, 76)
    many = len(raw) > 20  # noqa: PLR2004 - too many to label
    for k, (values, name, colour) in enumerate(
        ((raw, "commanded frames", LIGHT["robot"]), (fitted, "best-fit frames", LIGHT["visit"]))
    ):
        if many:
            counts, edges = np.histogram(
                values * factor, 40, (0.0, max(float(raw.max()), float(fitted.max())) * factor)
            )
            on.stairs(counts, edges, fill=True, color=colour, alpha=0.6, linewidth=0, label=name)
        else:
            on.bar(
                np.arange(len(values)) + (k - 0.5) * 0.38,
                values * factor,
                width=0.36,
                color=colour,
                linewidth=0,
                label=name,
            )
    if not many:
        on.set_xticks(
            range(len(raw)), [label(pose.name) for pose in measured.poses], color=LIGHT["ink"]
        )
        on.tick_params(axis="x", length=0, labelrotation=0 if len(raw) < _UPRIGHT_NAMES else 90)
    label_axes(on, f"AP_p [{unit}]" if many else "pose", "poses [1]" if many else f"AP_p [{unit}]")
    legend(made)
    return made


def measured_path(measured: MeasuredRobot) -> Figure:
    """Return measured AT and RT along each path under each load, with a point for each plane."""
    drawn = [(load, path) for load in measured.loads for path in load.paths]
    made = figure(96)
    panels = axes(made, "Measured along the path", rows=2, sharex=True)[:, 0]
    several = len({path.name for _, path in drawn}) > 1
    for row, (on, word) in enumerate(zip(panels, ("AT", "RT"), strict=True)):
        grid(on)
        unit = unit_of_length(max(float(path.profile[row].max()) for _, path in drawn))
        for k, (load, path) in enumerate(drawn):
            name = measured_label(
                f"measured{f', {label(path.name)}' if several else ''}", load, measured.loads
            )
            values = path.profile[row] * factor_of(unit)
            on.plot(
                path.places * 1e3,
                values,
                color=_COLOURS[k % len(_COLOURS)],
                linewidth=1.5,
                marker="o",
                markersize=3.5,
                label=name,
            )
        on.set_ylim(bottom=0)
        label_axes(on, y=f"{word} [{unit}]")
    start = "the start of the path" if several else f"the start of {label(drawn[0][1].name)}"
    label_axes(panels[1], f"distance from {start} [mm]")
    legend(made)
    return made
