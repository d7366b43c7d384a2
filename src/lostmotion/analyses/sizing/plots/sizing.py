"""Plots of an arm with sized links: masses, utilisation of the limits, and mass against tool error."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.reporting.plot import BLUE, INK, LEGEND, ORANGE, RED, Plot, framed, label, named
from lostmotion.reporting.sheet import ARCMIN

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.sizing.sizing import Sizing


def sizing_plots(result: Sizing) -> list[Plot]:
    """Return the plots in reading order."""
    return [
        Plot("masses", "sections", masses(result), "Bars of each link's mass, as stated and as sized."),
        Plot("shares", "bending", utilisation(result), "Bars of slope and deflection of each sized link over their limits."),
        Plot("trade", "trade", trade_off(result), "Curve of the r.m.s. tool error against the mass of the links for scaled limits."),
    ]


def masses(result: Sizing) -> go.Figure:
    """Plot the mass of each link, as stated and as sized (kg)."""
    import plotly.graph_objects as go

    names = [label(link.joint) for link in result.links]
    values = (("now", [link.mass_before for link in result.links], ORANGE), ("sized", [link.mass for link in result.links], BLUE))
    bars = [
        go.Bar(
            x=each,
            y=list(range(len(names))),
            orientation="h",
            name=name,
            marker={"color": colour},
            hovertemplate=f"{name}: %{{x:.4~g}} kg<extra></extra>",
        )
        for name, each, colour in values
    ]
    figure = framed("Mass of each link", *bars, height=150 + 44 * len(names))
    figure.update_xaxes(title_text="mass [kg]", rangemode="tozero")
    figure.update_yaxes(**named(names))
    figure.update_layout(barmode="group", bargap=0.3, bargroupgap=0.08, legend=LEGEND, margin_t=80)
    return figure


def utilisation(result: Sizing) -> go.Figure:
    """Plot slope and deflection of each sized link at the worst pose over their limits (%)."""
    import plotly.graph_objects as go

    names = [label(link.joint) for link in result.links]
    bars = [
        go.Bar(
            x=[100 * link.utilisation[k] for link in result.links],
            y=list(range(len(names))),
            orientation="h",
            name=name,
            marker={"color": colour},
            hovertemplate=f"{name}: %{{x:.4~g}} %<extra></extra>",
        )
        for k, (name, colour) in enumerate((("slope", BLUE), ("deflection", ORANGE)))
    ]
    figure = framed("Utilisation of the limits at the worst pose", *bars, height=150 + 44 * len(names))
    figure.add_shape(type="line", x0=100, x1=100, y0=0, y1=1, yref="y domain", line={"color": RED, "width": 1.3, "dash": "dot"})
    figure.update_xaxes(title_text="utilisation [%]", rangemode="tozero")
    figure.update_yaxes(**named(names))
    figure.update_layout(barmode="group", bargap=0.3, bargroupgap=0.08, legend=LEGEND, margin_t=80)
    return figure


def trade_off(result: Sizing) -> go.Figure:
    """Plot the r.m.s. tool error (mm) against the mass of the links (kg) for scaled limits."""
    import plotly.graph_objects as go

    limits = [f"{result.limits.slope * each.scale / ARCMIN:.3g}', length/{result.limits.deflection / each.scale:.0f}" for each in result.trade_off]
    curve = go.Scatter(
        x=[each.mass for each in result.trade_off],
        y=[each.rms_error * 1e3 for each in result.trade_off],
        mode="lines+markers",
        name="scaled limits",
        line={"color": BLUE, "width": 2},
        marker={"size": 7, "symbol": ["circle" if each.meets_limits else "x" for each in result.trade_off]},
        customdata=limits,
        hovertemplate="%{customdata}<br>%{x:.4~g} kg, %{y:.4~g} mm<extra></extra>",
    )
    here = next(each for each in result.trade_off if each.scale == 1)
    stated = go.Scatter(
        x=[here.mass],
        y=[here.rms_error * 1e3],
        mode="markers",
        name="stated limits",
        marker={"size": 13, "symbol": "circle-open", "color": RED, "line": {"width": 2}},
        hovertemplate="stated limits: %{x:.4~g} kg, %{y:.4~g} mm<extra></extra>",
    )
    before = sum(link.mass_before for link in result.links)
    now = go.Scatter(
        x=[before],
        y=[result.rms_error_before * 1e3],
        mode="markers",
        name="as stated",
        marker={"size": 10, "symbol": "diamond", "color": INK},
        hovertemplate="as stated: %{x:.4~g} kg, %{y:.4~g} mm<extra></extra>",
    )
    figure = framed("Mass of the links against tool error", curve, stated, now, height=420)
    figure.update_xaxes(title_text="links [kg]")
    figure.update_yaxes(title_text="r.m.s. tool error [mm]")
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure
