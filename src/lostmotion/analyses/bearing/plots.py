"""The plots of a bearing: how clearances come out, what each element carries, how far the shaft
gives.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.propagation.montecarlo.histogram import binned
from lostmotion.reporting.chart import (
    axes,
    figure,
    grid,
    histogram,
    label_axes,
    legend,
    mark_at,
    one,
)
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Cell

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.loads.bearing import Examined, ShiftCurve

_CASES = (
    ("lowest clearance", LIGHT["visit"]),
    ("mean", LIGHT["robot"]),
    ("highest", LIGHT["design"]),
)


def bearing_plots(examined: Examined) -> list[Plot]:
    """Return the plots of a bearing from its drawing. In reading order."""
    drawn = [
        Plot(
            "clearance-histogram",
            "built",
            clearance_histogram(examined),
            "Histogram of the working clearance of simulated bearings, with its limits.",
        ),
        Plot(
            "radial-curve",
            "shift",
            radial_curve(examined),
            "Shift across over the radial load, at three working clearances.",
        ),
    ]
    if examined.axial is not None:
        drawn.append(
            Plot(
                "axial-curve",
                "shift",
                axial_curve(examined),
                "Shift along the axis over the axial load, at three working clearances.",
            )
        )
    drawn.append(
        Plot(
            "element-loads",
            "elements",
            element_loads(examined),
            "Polar bars of the load on each rolling element at the mean clearance.",
        )
    )
    return drawn


def clearance_histogram(examined: Examined) -> Figure:
    """Draw the working clearance of simulated bearings. All of them are counted, between the limits
    of their dimensions.
    """
    working = examined.samples["working"] * 1e6
    spread = examined.bearing.spreads["working"]
    # A clearance whose dimensions have no tolerance is the same in every bearing.
    edges, counts = (
        binned(working, about=30)
        if np.ptp(working) > 1e-6  # noqa: PLR2004
        else (working[0] + np.array([-0.5, 0.5]), np.array([len(working)]))
    )
    made, on = one(f"Working clearance of {examined.count} simulated bearings", 80)
    histogram(on, edges, counts)
    for row, (value, name) in enumerate(((spread.lowest, "lowest"), (spread.highest, "highest"))):
        mark_at(on, value * 1e6, f"{name} {Cell(value, 'µm')}", row=row)
    label_axes(
        on,
        "working clearance [µm], below zero preload",
        f"bearings per {float(edges[1] - edges[0]):.3g} µm [1]",
    )
    return made


def radial_curve(examined: Examined) -> Figure:
    """Draw the displacement under a radial load alone, through the play and then against the
    elements.
    """
    return _curve(examined.radial, "Shift under a radial load alone", "radial load", "shift across")


def axial_curve(examined: Examined) -> Figure:
    """Draw the displacement under an axial load alone. Raises ValueError for bearings that carry
    none.
    """
    if examined.axial is None:
        raise ValueError("cylindrical rollers carry no axial load")
    return _curve(examined.axial, "Shift under an axial load alone", "axial load", "shift along")


def element_loads(examined: Examined) -> Figure:
    """Draw the load of each rolling element at the mean clearance. By its angle from the radial
    load, 0° on its side.
    """
    from matplotlib.ticker import MaxNLocator

    names, rows = examined.row_names, examined.settled.loads
    largest = max(float(np.nanmax(each[1])) for each in rows) or 1.0
    made = figure(84)
    panels = axes(
        made,
        "Load of each element [N] by its angle from the radial load",
        columns=len(rows),
        subplot_kw={"projection": "polar"},
    )[0]
    for on, name, loads in zip(panels, names, rows, strict=True):
        count = loads.shape[1]
        on.bar(
            np.arange(count) * 2 * math.pi / count,
            np.nan_to_num(loads[1]),
            width=0.7 * 2 * math.pi / count,
            color=LIGHT["robot"],
            linewidth=0,
        )
        on.set_theta_zero_location("S")
        on.set_ylim(0, 1.05 * largest)
        on.set_thetagrids(range(0, 360, 45), [f"{angle}°" for angle in range(0, 360, 45)])
        on.yaxis.set_major_locator(MaxNLocator(3))
        on.set_rlabel_position(180)
        grid(on, "both")
        on.spines["polar"].set_color(LIGHT["line"])
        on.set_title(name, loc="center")
    return made


def _curve(curve: ShiftCurve, title: str, load: str, shift: str) -> Figure:
    unit, factor = ("kN", 1e-3) if float(curve.loads[-1]) >= 1e4 else ("N", 1.0)  # noqa: PLR2004 - where people change units
    made, on = one(title, 78)
    grid(on, "both")
    for (name, colour), shifts in zip(_CASES, curve.shifts, strict=True):
        on.plot(
            curve.loads * factor,
            np.where(np.isfinite(shifts), shifts, math.nan) * 1e6,
            color=colour,
            linewidth=1.6,
            label=name,
        )
    on.set_xlim(left=0)
    on.set_ylim(bottom=min(0.0, on.get_ylim()[0]))
    label_axes(on, f"{load} [{unit}]", f"{shift} [µm]")
    legend(made)
    return made
