"""Tables of predicted and measured figures side by side."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.analyses.iso9283.tables.labels import estimate_figure, load_label
from lostmotion.laws.iso9283 import PATH_FIGURES
from lostmotion.reporting.sheet import Row, Section

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.iso9283.comparison import ComparedFigure

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


def comparison_sections(compared: Sequence[ComparedFigure]) -> list[Section]:
    """Return predicted and measured figures side by side for each load: characteristics, and the
    components of AP along and about the axes.
    """
    columns = ("5 %", "95 %", "measured")
    loads = sorted({each.load for each in compared}, reverse=True)
    out = []
    for load in loads:
        key = "" if load == loads[0] else f"-{100 * load:g}"
        rows, parts = (
            _side_by_side([each for each in compared if each.load == load], names)
            for names in (SHOWN, PARTS)
        )
        if rows:
            note = (
                f"5 %, 95 %: percentiles over the simulated robots, at {100 * load:g} % of the "
                "payload, with the measured number of visits and "
                "cycles and the stated instrument. High, low: outside the percentiles; "
                f"{_within(rows)} lie within, 90 % expected of this design"
            )
            out.append(
                Section(
                    f"compared{key}",
                    load_label("Predicted and measured", load, loads),
                    columns,
                    rows,
                    note,
                )
            )
        if parts:
            note = (
                "AP_x, AP_y, AP_z along, AP_a, AP_b, AP_c about the base's axes, signed, "
                "without a fit of frames: errors of the measured base or "
                f"tool frame count in full; {_within(parts)} lie within"
            )
            out.append(
                Section(
                    f"compared-axes{key}",
                    load_label("Predicted and measured: AP by axis", load, loads),
                    columns,
                    parts,
                    note,
                )
            )
    return out


def _within(rows: tuple[Row, ...]) -> str:
    return f"{sum(not row.note for row in rows)} of {len(rows)}"


def _side_by_side(compared: Sequence[ComparedFigure], names: tuple[str, ...]) -> tuple[Row, ...]:
    """Return a row for each of these figures, marked where the measured robot lies outside the
    predicted range.
    """
    rows = []
    for each in (each for name in names for each in compared if each.name == name):
        low, high, value = (
            estimate_figure(figure, angle=each.angle)
            for figure in (each.predicted.low, each.predicted.high, each.measured)
        )
        plain = (figure.alone for figure in (low, high))
        word = (
            ""
            if each.within
            else "high"
            if each.measured.value > each.predicted.high.value
            else "low"
        )
        rows.append(Row(f"{each.name}, {each.pose}", (*plain, value), word))
    return tuple(rows)
