"""Plots of an arm with sized links: masses, utilisation of the limits, and mass against tool
error.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.reporting.chart import grid, grouped, label_axes, legend, named_rows, one, ringed
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.analyses.sizing.sizing import Sizing


def sizing_plots(result: Sizing) -> list[Plot]:
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
            trade_off(result),
            "Curve of the r.m.s. tool error against the mass of the links for scaled limits.",
        ),
    ]


def masses(result: Sizing) -> Figure:
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


def utilisation(result: Sizing) -> Figure:
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


def trade_off(result: Sizing) -> Figure:
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
