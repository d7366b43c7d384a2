"""Plots of a selection of parts: cost against target, effect of each choice, effect of halving a part's errors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.analyses.sizing.tables.selection import has_prices, objective_text
from lostmotion.reporting.plot import BLUE, INK, LEGEND, ORANGE, RED, Plot, framed, label, named
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.sizing.target_study import PartSelection

# The least accurate candidate may hide all differences: bars are cut at this multiple of the target.
_WIDEST: Final = 3.0


def selection_plots(result: PartSelection) -> list[Plot]:
    """Return the plots in reading order."""
    plots = [
        Plot("trade", "trade", trade_off(result), "Curve of the 95 % error against the cost of the selected parts."),
        Plot("halving", "halving", halving(result), "Bars of the reduction of the 95 % error by halving one part's errors."),
    ]
    if any(each.error_with_cheapest is not None for each in result.parts):
        plots.insert(0, Plot("buys", "buys", savings(result), "Bars of the 95 % error with one part replaced by the cheapest."))
    return plots


def trade_off(result: PartSelection) -> go.Figure:
    """Plot the 95 % error (mm) against the cost of the selection for each target."""
    import plotly.graph_objects as go

    unit = "" if has_prices(result) else " kg"
    curve = go.Scatter(
        x=[each.cost for each in result.trade_off],
        y=[each.error.value * 1e3 for each in result.trade_off],
        error_y={
            "type": "data",
            "symmetric": False,
            "array": [(each.error.high - each.error.value) * 1e3 for each in result.trade_off],
            "arrayminus": [(each.error.value - each.error.low) * 1e3 for each in result.trade_off],
            "thickness": 1.2,
            "width": 4,
        },
        mode="lines+markers",
        name="selections",
        line={"color": BLUE, "width": 2, "shape": "vh"},
        marker={"size": 7, "symbol": ["circle" if each.meets_target else "x" for each in result.trade_off]},
        customdata=[f"target {each.target * 1e3:.4g} mm" for each in result.trade_off],
        hovertemplate=f"%{{customdata}}<br>cost %{{x:.5~g}}{unit}, 95 % error %{{y:.4~g}} mm<extra></extra>",
    )
    here = result.objective.cost(result.mass, result.price)
    selected = go.Scatter(
        x=[here],
        y=[result.error.value * 1e3],
        mode="markers",
        name="selected parts",
        marker={"size": 13, "symbol": "circle-open", "color": RED, "line": {"width": 2}},
        hovertemplate=f"selected parts: cost %{{x:.5~g}}{unit}, %{{y:.4~g}} mm<extra></extra>",
    )
    traces = [curve, selected]
    before = result.objective.cost(result.mass_before, result.price_before)
    if before == before:  # noqa: PLR0124 - known, not NaN
        traces.append(
            go.Scatter(
                x=[before],
                y=[result.error_before.value * 1e3],
                mode="markers",
                name="as stated",
                marker={"size": 10, "symbol": "diamond", "color": INK},
                hovertemplate=f"as stated: cost %{{x:.5~g}}{unit}, %{{y:.4~g}} mm<extra></extra>",
            )
        )
    figure = framed("Cost against accuracy", *traces, height=420)
    figure.add_hline(y=result.target * 1e3, line={"color": RED, "width": 1.3, "dash": "dot"})
    figure.update_xaxes(title_text=f"{objective_text(result)} (mass in kg)" if has_prices(result) else "mass of the selected parts [kg]")
    figure.update_yaxes(title_text="95 % error [mm]", rangemode="tozero")
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure


def savings(result: PartSelection) -> go.Figure:
    """Plot the 95 % error (mm) with one part replaced by the cheapest candidate."""
    import plotly.graph_objects as go

    rows = sorted(((each.error_with_cheapest.value, each) for each in result.parts if each.error_with_cheapest is not None), key=lambda row: -row[0])
    names = [label(each.slot.label) for _, each in rows]
    bars = go.Bar(
        x=[value * 1e3 for value, _ in rows],
        y=list(range(len(rows))),
        orientation="h",
        marker={"color": ORANGE},
        text=[str(length(value)) for value, _ in rows],
        textposition="inside",
        insidetextanchor="start",
        customdata=[f"{label(each.cheapest.name)}, saves {each.saving:.4g}" for _, each in rows],
        hovertemplate="%{customdata}<br>95 % error %{x:.4~g} mm<extra></extra>",
        showlegend=False,
    )
    figure = framed("95 % error with one part replaced by the cheapest", bars, height=150 + 30 * len(rows))
    for value, name, colour in ((result.target, "target", RED), (result.error.value, "as selected", BLUE)):
        line = {"color": colour, "width": 1.5, "dash": "dot"}
        figure.add_shape(type="line", x0=value * 1e3, x1=value * 1e3, y0=0, y1=1, yref="y domain", line=line)
        # named in the legend, because labels of two close lines would overlap
        figure.add_trace(go.Scatter(x=[None], y=[None], mode="lines", name=name, line=line, showlegend=True))
    most = min(max(value for value, _ in rows), _WIDEST * max(result.target, result.error.value))
    cut = ", longer bars cut" if max(value for value, _ in rows) > most else ""
    figure.update_xaxes(title_text=f"95 % error [mm]{cut}", range=[0, 1.05e3 * most])
    figure.update_yaxes(**named(names))
    figure.update_layout(bargap=0.35, legend=LEGEND, margin_t=80)
    return figure


def halving(result: PartSelection) -> go.Figure:
    """Plot the reduction of the 95 % error (µm) by halving the errors of each part."""
    import plotly.graph_objects as go

    gains = sorted(result.halving.gains.items(), key=lambda pair: -pair[1].value)[:10]
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
    figure = framed("Effect of halving one part's errors", bars, height=150 + 30 * len(gains))
    figure.update_xaxes(title_text="reduction of the 95 % error [µm]")
    figure.update_yaxes(**named([label(name) for name, _ in gains]))
    figure.update_layout(bargap=0.35)
    return figure
