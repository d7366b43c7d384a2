"""Plots of a measured robot by ISO 9283: accuracy over poses, along paths, and compared with
predicted robots.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.iso9283.page.labels import load_label, measured_label
from lostmotion.analyses.iso9283.page.side_by_side import SHOWN
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

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.standards.comparison import ComparedFigure
    from lostmotion.standards.measured_robot import MeasuredLoad, MeasuredRobot

_SMALLEST: Final = 1e-10
_COLOURS: Final = (LIGHT["robot"], LIGHT["design"], LIGHT["visit"], LIGHT["warn"])
# From so many poses on, their names stand upright.
_UPRIGHT_NAMES: Final = 9


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
