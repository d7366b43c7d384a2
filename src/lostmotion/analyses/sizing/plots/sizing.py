"""The plots of an arm whose links were sized: mass against tool error, mass of each link now and then, how much of each limit is taken."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.reporting.plot import BLUE, INK, LEGEND, ORANGE, RED, Plot, framed, label, named
from lostmotion.reporting.sheet import ARCMIN

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.sizing.sizing import Sizing


def sizing_plots(found: Sizing) -> list[Plot]:
    """Which plots does a sizing have? In reading order."""
    return [
        Plot("masses", "sections", masses(found), "Bars of each link's mass, as stated and as sized."),
        Plot("shares", "bending", shares(found), "Bars of how much of its limits each sized link takes, slope and deflection."),
        Plot("trade", "trade", trade(found), "Curve of the links' mass against the r.m.s. tool error as both limits widen together."),
    ]


def masses(found: Sizing) -> go.Figure:
    """What does each link weigh, as stated and as sized (kg)?"""
    import plotly.graph_objects as go

    names = [label(link.joint) for link in found.links]
    values = (("now", [link.mass_before for link in found.links], ORANGE), ("sized", [link.mass for link in found.links], BLUE))
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


def shares(found: Sizing) -> go.Figure:
    """How much of its limits does each sized link take at worst (%)?"""
    import plotly.graph_objects as go

    names = [label(link.joint) for link in found.links]
    bars = [
        go.Bar(
            x=[100 * link.shares[k] for link in found.links],
            y=list(range(len(names))),
            orientation="h",
            name=name,
            marker={"color": colour},
            hovertemplate=f"{name}: %{{x:.4~g}} %<extra></extra>",
        )
        for k, (name, colour) in enumerate((("slope", BLUE), ("deflection", ORANGE)))
    ]
    figure = framed("Share of each limit at the worst pose", *bars, height=150 + 44 * len(names))
    figure.add_shape(type="line", x0=100, x1=100, y0=0, y1=1, yref="y domain", line={"color": RED, "width": 1.3, "dash": "dot"})
    figure.update_xaxes(title_text="share of the limit [%]", rangemode="tozero")
    figure.update_yaxes(**named(names))
    figure.update_layout(barmode="group", bargap=0.3, bargroupgap=0.08, legend=LEGEND, margin_t=80)
    return figure


def trade(found: Sizing) -> go.Figure:
    """What does mass buy? Each point an arm sized anew with both limits wider or narrower by one factor (kg, mm)."""
    import plotly.graph_objects as go

    said = [f"{found.limits.slope * each.scale / ARCMIN:.3g}', length/{found.limits.deflection / each.scale:.0f}" for each in found.trade]
    curve = go.Scatter(
        x=[each.mass for each in found.trade],
        y=[each.rms * 1e3 for each in found.trade],
        mode="lines+markers",
        name="sized anew",
        line={"color": BLUE, "width": 2},
        marker={"size": 7, "symbol": ["circle" if each.holds else "x" for each in found.trade]},
        customdata=said,
        hovertemplate="%{customdata}<br>%{x:.4~g} kg, %{y:.4~g} mm<extra></extra>",
    )
    here = next(each for each in found.trade if each.scale == 1)
    asked = go.Scatter(
        x=[here.mass],
        y=[here.rms * 1e3],
        mode="markers",
        name="limits asked for",
        marker={"size": 13, "symbol": "circle-open", "color": RED, "line": {"width": 2}},
        hovertemplate="limits asked for: %{x:.4~g} kg, %{y:.4~g} mm<extra></extra>",
    )
    before = sum(link.mass_before for link in found.links)
    now = go.Scatter(
        x=[before],
        y=[found.rms_before * 1e3],
        mode="markers",
        name="as stated",
        marker={"size": 10, "symbol": "diamond", "color": INK},
        hovertemplate="as stated: %{x:.4~g} kg, %{y:.4~g} mm<extra></extra>",
    )
    figure = framed("Mass of the links against tool error", curve, asked, now, height=420)
    figure.update_xaxes(title_text="links [kg]")
    figure.update_yaxes(title_text="r.m.s. tool error [mm]")
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure
