"""Plots of a selection of parts: cost against target, effect of each choice, effect of halving a
part's errors.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.sizing.tables.selection import has_prices, objective_text
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.chart import (
    grid,
    label_axes,
    legend,
    named_rows,
    one,
    ringed,
    text,
    zero_line,
)
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.analyses.sizing.target_study import PartSelection

# The least accurate candidate may hide all differences: bars are cut at this multiple of the
# target.
_WIDEST: Final = 3.0


def selection_plots(result: PartSelection) -> list[Plot]:
    """Return the plots in reading order."""
    plots = [
        Plot(
            "trade",
            "trade",
            trade_off(result),
            "Curve of the 95 % error against the cost of the selected parts.",
        ),
        Plot(
            "halving",
            "halving",
            halving(result),
            "Bars of the reduction of the 95 % error by halving one part's errors.",
        ),
    ]
    if any(each.error_with_cheapest is not None for each in result.parts):
        plots.insert(
            0,
            Plot(
                "buys",
                "buys",
                savings(result),
                "Bars of the 95 % error with one part replaced by the cheapest.",
            ),
        )
    return plots


def trade_off(result: PartSelection) -> Figure:
    """Plot the 95 % error (mm) against the cost of the selection for each target."""
    made, on = one("Cost against accuracy", 86)
    grid(on, "both")
    points = sorted(result.trade_off, key=lambda each: each.cost)
    cost, error = [each.cost for each in points], [each.error.value * 1e3 for each in points]
    ends = [
        [1e3 * (each.error.value - each.error.low) for each in points],
        [1e3 * (each.error.high - each.error.value) for each in points],
    ]
    on.step(cost, error, where="post", color=LIGHT["robot"], linewidth=1.5)
    on.errorbar(
        cost,
        error,
        yerr=ends,
        fmt="o",
        markersize=4,
        color=LIGHT["robot"],
        ecolor=LIGHT["ink"],
        elinewidth=1.0,
        label="selections",
    )
    missed = [(each.cost, each.error.value * 1e3) for each in points if not each.meets_target]
    if missed:
        on.plot(
            *zip(*missed, strict=True),
            linestyle="none",
            marker="x",
            markersize=7,
            color=LIGHT["warn"],
            label="target not met",
        )
    ringed(
        on,
        result.objective.cost(result.mass, result.price),
        result.error.value * 1e3,
        "selected parts",
    )
    before = result.objective.cost(result.mass_before, result.price_before)
    if math.isfinite(before):
        on.plot(
            [before],
            [result.error_before.value * 1e3],
            linestyle="none",
            marker="D",
            markersize=5,
            color=LIGHT["ink"],
            label="as stated",
        )
    on.axhline(
        result.target * 1e3,
        color=LIGHT["warn"],
        linewidth=1.2,
        linestyle=(0, (1.5, 1.5)),
        label="target",
    )
    on.set_ylim(bottom=0)
    what = (
        f"{objective_text(result)} (mass in kg) [1]"
        if has_prices(result)
        else "mass of the selected parts [kg]"
    )
    label_axes(on, what, f"{result.quantity} [mm]")
    legend(made)
    return made


def savings(result: PartSelection) -> Figure:
    """Plot the 95 % error (mm) with one part replaced by the cheapest candidate."""
    rows = sorted(
        (
            (each.error_with_cheapest.value, each)
            for each in result.parts
            if each.error_with_cheapest is not None
        ),
        key=lambda row: -row[0],
    )
    made, on = one(f"{result.quantity} with one part replaced by the cheapest", 34 + 7 * len(rows))
    values = np.array([value * 1e3 for value, _ in rows])
    most = 1e3 * min(float(values.max()) / 1e3, _WIDEST * max(result.target, result.error.value))
    on.barh(
        range(len(rows)),
        np.minimum(values, 1.05 * most),
        height=0.62,
        color=LIGHT["design"],
        linewidth=0,
    )
    for row, (value, each) in enumerate(rows):
        found = each.error_with_cheapest
        words = "" if found is None else str(length(found.value, found.low, found.high))
        text(on, min(value * 1e3, 1.05 * most), row, words, xytext=(4, 0), va="center")
    for value, name, colour in (
        (result.target, "target", LIGHT["warn"]),
        (result.error.value, "as selected", LIGHT["robot"]),
    ):
        on.axvline(value * 1e3, color=colour, linewidth=1.4, linestyle=(0, (1.5, 1.5)), label=name)
    named_rows(on, [each.slot.label for _, each in rows])
    on.set_xlim(0, 1.22 * most)
    label_axes(
        on, f"{result.quantity} [mm]{', longer bars cut' if float(values.max()) > most else ''}"
    )
    legend(made)
    return made


def halving(result: PartSelection) -> Figure:
    """Plot the reduction of the 95 % error (µm) by halving the errors of each part."""
    gains = sorted(result.halving.gains.items(), key=lambda pair: -pair[1].value)[:10]
    made, on = one("Effect of halving one part's errors", 26 + 7 * len(gains))
    values = np.array([gain.value * 1e6 for _, gain in gains])
    ends = np.array(
        [
            [(gain.value - gain.low) * 1e6 for _, gain in gains],
            [(gain.high - gain.value) * 1e6 for _, gain in gains],
        ]
    )
    on.barh(range(len(gains)), values, height=0.62, color=LIGHT["robot"], linewidth=0)
    on.errorbar(
        values,
        range(len(gains)),
        xerr=np.nan_to_num(ends),
        fmt="none",
        color=LIGHT["ink"],
        elinewidth=1.0,
        capsize=2,
    )
    named_rows(on, [short_name(name) for name, _ in gains])
    if (values < 0).any():
        zero_line(on)
    label_axes(on, "reduction of the 95 % error [µm]")
    return made
