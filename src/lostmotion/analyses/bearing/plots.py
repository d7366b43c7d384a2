"""The plots of a bearing: how clearances come out, what each element carries, how far the shaft gives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.analyses.bearing.tables import row_names
from lostmotion.propagation.montecarlo.histogram import binned
from lostmotion.reporting.plot import BLUE, GREEN, LEGEND, ORANGE, RED, Plot, framed, histogram, styled

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.bearing.bearing import Curve, Examined

_CASES = (("lowest clearance", GREEN), ("middle", BLUE), ("highest", ORANGE))


def bearing_plots(found: Examined) -> list[Plot]:
    """Return the plots of a bearing from its drawing. In reading order."""
    drawn = [
        Plot(
            "clearance-histogram", "built", clearance_histogram(found), "Histogram of the working clearance of simulated bearings, with its limits."
        ),
        Plot("radial-curve", "shift", radial_curve(found), "Shift across over the radial load, at three working clearances."),
    ]
    if found.axial is not None:
        drawn.append(Plot("axial-curve", "shift", axial_curve(found), "Shift along the axis over the axial load, at three working clearances."))
    drawn.append(Plot("element-loads", "elements", element_loads(found), "Polar bars of the load on each rolling element at the middle clearance."))
    return drawn


def clearance_histogram(found: Examined) -> go.Figure:
    """Draw the working clearance of simulated bearings. All of them are counted, between the limits of their dimensions."""
    working = found.samples["working"] * 1e6
    spread = found.bearing.spreads["working"]
    # A clearance whose dimensions have no tolerance is the same in every bearing.
    edges, counts = binned(working, about=30) if np.ptp(working) > 1e-6 else (working[0] + np.array([-0.5, 0.5]), np.array([len(working)]))  # noqa: PLR2004 - µm
    bars = histogram(edges, counts, BLUE, "%{x:.3~g} µm ± half a bin<br>%{y} bearings, %{customdata:.2f} %<extra></extra>")
    figure = framed(f"Working clearance of {found.count} simulated bearings", bars, height=380)
    for value, name, anchor in ((spread.lowest, "lowest", "left"), (spread.highest, "highest", "right")):
        figure.add_vline(x=value * 1e6, line={"color": RED, "width": 1.3, "dash": "dot"})
        figure.add_annotation(
            x=value * 1e6,
            y=1,
            yref="paper",
            yanchor="bottom",
            xanchor=anchor,
            text=f"{name} {value * 1e6:.1f} µm",
            showarrow=False,
            font={"color": RED},
        )
    figure.update_xaxes(title_text="working clearance [µm], below zero preload", showgrid=False)
    figure.update_yaxes(title_text=f"bearings per {float(edges[1] - edges[0]):.3g} µm [1]")
    figure.update_layout(margin_t=72, bargap=0)
    return figure


def radial_curve(found: Examined) -> go.Figure:
    """Draw the displacement under a radial load alone, through the play and then against the elements."""
    return _curve(found.radial, "Shift under a radial load alone", "radial load", "shift across")


def axial_curve(found: Examined) -> go.Figure:
    """Draw the displacement under an axial load alone. Raises ValueError for bearings that carry none."""
    if found.axial is None:
        raise ValueError("cylindrical rollers carry no axial load")
    return _curve(found.axial, "Shift under an axial load alone", "axial load", "shift along")


def element_loads(found: Examined) -> go.Figure:
    """Draw the load of each rolling element at the middle clearance. By its angle from the radial load, 0° on its side."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    names, rows = row_names(found), found.settled.loads
    largest = max(float(np.nanmax(each[1])) for each in rows) or 1.0
    figure = styled(
        make_subplots(rows=1, cols=len(rows), specs=[[{"type": "polar"}] * len(rows)], horizontal_spacing=0.2), "Load of each element", height=400
    )
    for column, (name, loads) in enumerate(zip(names, rows, strict=True), start=1):
        count = loads.shape[1]
        bars = go.Barpolar(
            r=loads[1],
            theta=np.arange(count) * 360 / count,
            width=[0.7 * 360 / count] * count,
            marker={"color": BLUE},
            hovertemplate=f"{name}, %{{theta:.0f}}°: %{{r:.4~g}} N<extra></extra>",
            showlegend=False,
        )
        figure.add_trace(bars, row=1, col=column)
    figure.update_polars(
        radialaxis={"range": [0, 1.05 * largest], "ticksuffix": " N", "angle": 90, "tickangle": 90, "nticks": 4, "gridcolor": "#dddddd"},
        angularaxis={"rotation": -90, "direction": "counterclockwise", "ticksuffix": "°", "dtick": 45, "gridcolor": "#dddddd"},
        domain_y=[0, 0.9],
    )
    for column, name in enumerate(names):
        figure.add_annotation(
            x=0.5 if len(names) == 1 else 0.2 + 0.6 * column,
            y=1.0,
            xref="paper",
            yref="paper",
            yanchor="bottom",
            text=name,
            xanchor="center",
            showarrow=False,
            font={"size": 13},
        )
    figure.update_layout(margin={"l": 40, "r": 40, "t": 70, "b": 30})
    return figure


def _curve(curve: Curve, title: str, load: str, shift: str) -> go.Figure:
    import plotly.graph_objects as go

    unit, factor = ("kN", 1e-3) if float(curve.loads[-1]) >= 1e4 else ("N", 1.0)  # noqa: PLR2004 - where people change units
    traces = [
        go.Scatter(
            x=curve.loads * factor,
            y=np.where(np.isfinite(shifts), shifts, math.nan) * 1e6,
            mode="lines",
            name=name,
            line={"color": colour, "width": 2},
            hovertemplate=f"{name}<br>%{{x:.4~g}} {unit}: %{{y:.4~g}} µm<extra></extra>",
        )
        for (name, colour), shifts in zip(_CASES, curve.shifts, strict=True)
    ]
    figure = framed(title, *traces, height=360)
    figure.update_xaxes(title_text=f"{load} [{unit}]", rangemode="tozero")
    figure.update_yaxes(title_text=f"{shift} [µm]", rangemode="tozero")
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure
