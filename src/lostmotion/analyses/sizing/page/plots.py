"""Plots of an arm with sized links (masses, utilisation of the limits, mass against error), and of
selected parts (cost against target, effect of each choice and of halving errors).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.chart import (
    grid,
    grouped,
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

    from lostmotion.analyses.sizing.selection import Selection
    from lostmotion.analyses.sizing.sizing import Size

# The least accurate candidate may hide all differences: bars are cut at this multiple of the
# target.
_WIDEST: Final = 3.0


def selection_plots(result: Selection) -> list[Plot]:
    """Return the plots in reading order."""
    plots = [
        Plot(
            "trade",
            "trade",
            cost_trade_off(result),
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


def cost_trade_off(result: Selection) -> Figure:
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
        f"{result.objective.text} (mass in kg) [1]"
        if result.objective.has_price
        else "mass of the selected parts [kg]"
    )
    label_axes(on, what, f"{result.quantity} [mm]")
    legend(made)
    return made


def savings(result: Selection) -> Figure:
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


def halving(result: Selection) -> Figure:
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


def sizing_plots(result: Size) -> list[Plot]:
    """Return the plots in reading order."""
    return [
        Plot(
            "masses",
            "sections",
            masses(result),
            "Bars of each link's mass, as stated and as sized.",
        ),
        Plot(
            "shares",
            "bending",
            utilisation(result),
            "Bars of slope and deflection of each sized link over their limits.",
        ),
        Plot(
            "trade",
            "trade",
            mass_trade_off(result),
            "Curve of the r.m.s. tool error against the mass of the links for scaled limits.",
        ),
    ]


def masses(result: Size) -> Figure:
    """Plot the mass of each link, as stated and as sized (kg)."""
    made, on = one("Mass of each link", 34 + 9 * len(result.links))
    before, after = (
        np.array([getattr(link, name) for link in result.links]) for name in ("mass_before", "mass")
    )
    grouped(on, [("as stated", LIGHT["design"], before), ("sized", LIGHT["robot"], after)])
    named_rows(on, [link.joint for link in result.links])
    label_axes(on, "mass [kg]")
    legend(made)
    return made


def utilisation(result: Size) -> Figure:
    """Plot slope and deflection of each sized link at the worst pose over their limits (%)."""
    made, on = one("Utilisation of the limits at the worst pose", 34 + 9 * len(result.links))
    slope, deflection = (
        np.array([100 * link.utilisation[k] for link in result.links]) for k in range(2)
    )
    grouped(on, [("slope", LIGHT["robot"], slope), ("deflection", LIGHT["design"], deflection)])
    on.axvline(100, color=LIGHT["warn"], linewidth=1.2, linestyle=(0, (1.5, 1.5)), label="limit")
    named_rows(on, [link.joint for link in result.links])
    label_axes(on, "utilisation [%]")
    legend(made)
    return made


def mass_trade_off(result: Size) -> Figure:
    """Plot the r.m.s. tool error (mm) against the mass of the links (kg) for scaled limits."""
    made, on = one("Mass of the links against tool error", 84)
    grid(on, "both")
    points = sorted(
        (each.mass, each.rms_error * 1e3, each.meets_limits) for each in result.trade_off
    )
    on.plot(
        [x for x, _, _ in points],
        [y for _, y, _ in points],
        color=LIGHT["robot"],
        linewidth=1.5,
        marker="o",
        markersize=4,
        label="scaled limits",
    )
    missed = [(x, y) for x, y, meets in points if not meets]
    if missed:
        on.plot(
            *zip(*missed, strict=True),
            linestyle="none",
            marker="x",
            color=LIGHT["warn"],
            markersize=7,
            label="limits not met",
        )
    here = next(each for each in result.trade_off if each.scale == 1)
    ringed(on, here.mass, here.rms_error * 1e3, "stated limits")
    before = sum(link.mass_before for link in result.links)
    on.plot(
        [before],
        [result.rms_error_before * 1e3],
        linestyle="none",
        marker="D",
        markersize=5,
        color=LIGHT["ink"],
        label="as stated",
    )
    label_axes(on, "mass of the links [kg]", "r.m.s. tool error [mm]")
    legend(made)
    return made
