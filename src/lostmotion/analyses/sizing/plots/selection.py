"""The plots of an arm whose parts were chosen for a target: cost against target, what each choice buys, what binds now."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.analyses.sizing.tables.selection import priced, small_said
from lostmotion.reporting.plot import BLUE, INK, LEGEND, ORANGE, RED, Plot, framed, label, named
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.sizing.target_study import Aimed

# The weakest of what is offered may err so much that nothing else could be told apart: bars end at so many times the target.
_WIDEST: Final = 3.0


def aimed_plots(found: Aimed) -> list[Plot]:
    """Which plots does an arm have whose parts were chosen? In reading order."""
    plots = [
        Plot("trade", "trade", trade(found), "Curve of the 95 % error against the cost of the parts chosen for it."),
        Plot("halving", "halving", binds(found), "Bars of how much the 95 % error falls when one part's errors are halved."),
    ]
    if any(each.without is not None for each in found.bought):
        plots.insert(0, Plot("buys", "buys", buys(found), "Bars of the 95 % error that is left when one part is put back to the cheapest."))
    return plots


def trade(found: Aimed) -> go.Figure:
    """What does accuracy cost? Each point the parts found for one target (cost, mm)."""
    import plotly.graph_objects as go

    unit = "" if priced(found) else " kg"
    curve = go.Scatter(
        x=[each.cost for each in found.trade],
        y=[each.error.value * 1e3 for each in found.trade],
        error_y={
            "type": "data",
            "symmetric": False,
            "array": [(each.error.high - each.error.value) * 1e3 for each in found.trade],
            "arrayminus": [(each.error.value - each.error.low) * 1e3 for each in found.trade],
            "thickness": 1.2,
            "width": 4,
        },
        mode="lines+markers",
        name="parts found",
        line={"color": BLUE, "width": 2, "shape": "vh"},
        marker={"size": 7, "symbol": ["circle" if each.holds else "x" for each in found.trade]},
        customdata=[f"target {each.target * 1e3:.4g} mm" for each in found.trade],
        hovertemplate=f"%{{customdata}}<br>cost %{{x:.5~g}}{unit}, 95 % error %{{y:.4~g}} mm<extra></extra>",
    )
    here = found.worth.of(found.mass, found.price)
    asked = go.Scatter(
        x=[here],
        y=[found.error.value * 1e3],
        mode="markers",
        name="parts chosen",
        marker={"size": 13, "symbol": "circle-open", "color": RED, "line": {"width": 2}},
        hovertemplate=f"parts chosen: cost %{{x:.5~g}}{unit}, %{{y:.4~g}} mm<extra></extra>",
    )
    traces = [curve, asked]
    before = found.worth.of(found.mass_before, found.price_before)
    if before == before:  # noqa: PLR0124 - known, not NaN
        traces.append(
            go.Scatter(
                x=[before],
                y=[found.error_before.value * 1e3],
                mode="markers",
                name="as stated",
                marker={"size": 10, "symbol": "diamond", "color": INK},
                hovertemplate=f"as stated: cost %{{x:.5~g}}{unit}, %{{y:.4~g}} mm<extra></extra>",
            )
        )
    figure = framed("Cost against accuracy", *traces, height=420)
    figure.add_hline(y=found.target * 1e3, line={"color": RED, "width": 1.3, "dash": "dot"})
    figure.update_xaxes(title_text=f"{small_said(found)} (mass in kg)" if priced(found) else "mass of the chosen parts [kg]")
    figure.update_yaxes(title_text="95 % error [mm]", rangemode="tozero")
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure


def buys(found: Aimed) -> go.Figure:
    """Which 95 % error would be left if one part were made in the cheapest way (mm)?"""
    import plotly.graph_objects as go

    rows = sorted(((each.without.value, each) for each in found.bought if each.without is not None), key=lambda row: -row[0])
    names = [label(each.slot.label) for _, each in rows]
    bars = go.Bar(
        x=[value * 1e3 for value, _ in rows],
        y=list(range(len(rows))),
        orientation="h",
        marker={"color": ORANGE},
        text=[str(length(value)) for value, _ in rows],
        textposition="inside",
        insidetextanchor="start",
        customdata=[f"{label(each.cheapest.name)}, saves {each.saved:.4g}" for _, each in rows],
        hovertemplate="%{customdata}<br>95 % error %{x:.4~g} mm<extra></extra>",
        showlegend=False,
    )
    figure = framed("95 % error with one part put back to the cheapest", bars, height=150 + 30 * len(rows))
    for value, name, colour in ((found.target, "target", RED), (found.error.value, "as chosen", BLUE)):
        line = {"color": colour, "width": 1.5, "dash": "dot"}
        figure.add_shape(type="line", x0=value * 1e3, x1=value * 1e3, y0=0, y1=1, yref="y domain", line=line)
        # in the legend: labels at two lines so close would lie on each other
        figure.add_trace(go.Scatter(x=[None], y=[None], mode="lines", name=name, line=line, showlegend=True))
    most = min(max(value for value, _ in rows), _WIDEST * max(found.target, found.error.value))
    cut = ", longer bars cut" if max(value for value, _ in rows) > most else ""
    figure.update_xaxes(title_text=f"95 % error [mm]{cut}", range=[0, 1.05e3 * most])
    figure.update_yaxes(**named(names))
    figure.update_layout(bargap=0.35, legend=LEGEND, margin_t=80)
    return figure


def binds(found: Aimed) -> go.Figure:
    """By how much does the 95 % error fall when a part's errors are halved (µm)?"""
    import plotly.graph_objects as go

    gains = sorted(found.halving.gains.items(), key=lambda pair: -pair[1].value)[:10]
    bars = go.Bar(
        x=[gain.value * 1e6 for _, gain in gains],
        y=list(range(len(gains))),
        orientation="h",
        marker={"color": BLUE},
        error_x={
            "type": "data",
            "symmetric": False,
            "array": [(gain.high - gain.value) * 1e6 for _, gain in gains],
            "arrayminus": [(gain.value - gain.low) * 1e6 for _, gain in gains],
            "thickness": 1.2,
            "width": 3,
        },
        hovertemplate="%{x:.4~g} µm<extra></extra>",
        showlegend=False,
    )
    figure = framed("What halving one part's errors takes off the 95 % error", bars, height=150 + 30 * len(gains))
    figure.update_xaxes(title_text="off the 95 % error [µm]")
    figure.update_yaxes(**named([label(name) for name, _ in gains]))
    figure.update_layout(bargap=0.35)
    return figure
