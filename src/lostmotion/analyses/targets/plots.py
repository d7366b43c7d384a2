"""Plots of a target: stated and allowed size of each item, the allocation to all items, and yield against target."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.targets.tables.items import ordered
from lostmotion.analyses.targets.tables.sizes import size_at, stated_size
from lostmotion.analyses.targets.tables.yield_ import CRITERION_LABELS
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.plot import BLUE, GREEN, INK, LEGEND, ORANGE, RED, Plot, framed, label, named

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any

    import plotly.graph_objects as go

    from lostmotion.analyses.targets.targets import Allowance, Targets

_MOST_BARS: Final = 40
_BAND: Final = {BLUE: "rgba(0,114,178,0.18)", ORANGE: "rgba(230,159,0,0.22)"}
_FACTOR: Final = "factor on the error"


def targets_plots(result: Targets) -> list[Plot]:
    """Return the plots in reading order."""
    out = []
    for key, title, allowed in (
        ("single", "Allowance for one item at a time", result.allowances),
        ("kinds", "Allowance for one cause in all parts of a kind", result.shared_allowances),
    ):
        some = ordered(allowed)[:_MOST_BARS]
        if some:
            out.append(Plot(f"{key}-allowed", key, dumbbells(some, title), "Dumbbells from the stated to the allowed size of each item."))
    if result.equal_factor is not None:
        out.append(
            Plot("together-allowed", "together", allocation_plot(result), "Dumbbells from the stated size of each item to that of equal effect.")
        )
    out.append(Plot("yield", "yield", yield_curve(result), "Share of robots that meet a target, against the target, with its confidence interval."))
    return out


def dumbbells(allowed: Sequence[Allowance], title: str) -> go.Figure:
    """Plot the factor on the error of each item with which the target is just met."""
    import plotly.graph_objects as go

    rows = list(range(len(allowed)))
    names = [label(short_name(each.item.name)) for each in allowed]
    values = [each.factor.value for each in allowed]
    texts = [f"{stated_size(each.item)} → {size_at(each.item, each.factor)}" for each in allowed]
    ends = [(_finite(each.factor.low, each.factor.value), _finite(each.factor.high, each.factor.value)) for each in allowed]
    colours = [BLUE if value >= 1 else RED for value in values]
    above = {
        "type": "data",
        "symmetric": False,
        "array": [high - value for (_, high), value in zip(ends, values, strict=True)],
        "arrayminus": [value - low for (low, _), value in zip(ends, values, strict=True)],
        "color": INK,
        "thickness": 1,
        "width": 3,
    }
    figure = framed(
        title,
        *_bars([1.0] * len(rows), values, colours),
        _dots([1.0] * len(rows), rows, "as stated", INK, texts, symbol="line-ns-open"),
        go.Scatter(
            x=values,
            y=rows,
            mode="markers",
            name="allowed, 95 % confidence interval",
            marker={"size": 9, "color": colours},
            error_x=above,
            customdata=texts,
            hovertemplate="%{customdata}<br>factor %{x:.4~g}<extra></extra>",
        ),
        height=180 + 22 * len(rows),
    )
    return _formatted(figure, names, values)


def allocation_plot(result: Targets) -> go.Figure:
    """Plot the allocation of equal effect, and the equal factor on all errors."""
    import plotly.graph_objects as go

    factor, effect = result.equal_factor, result.equal_effect
    if factor is None:
        raise ValueError("nothing moves the tool")
    shown = [k for k in range(len(result.items)) if np.isfinite(factor.factors[k])]
    other = factor if effect is None else effect
    shown = sorted(shown, key=lambda k: float(other.factors[k]))[:_MOST_BARS]
    rows = list(range(len(shown)))
    values = [float(other.factors[k]) for k in shown]
    colours = [GREEN if value >= 1 else RED for value in values]
    texts = [
        f"{stated_size(result.items[k])}, {'not limiting' if other.not_limiting[k] else f'factor {value:.3g}'}"
        for k, value in zip(shown, values, strict=True)
    ]
    figure = framed(
        "Allocation to all items: as stated, and with equal effect",
        *_bars([1.0] * len(rows), values, colours),
        _dots([1.0] * len(rows), rows, "as stated", INK, texts, symbol="line-ns-open"),
        _dots(values, rows, "equal effect" if effect is not None else "equal factor", colours, texts),
        height=180 + 22 * len(rows),
    )
    uniform = float(np.nanmax(factor.factors))
    line = {"color": ORANGE, "width": 1.5, "dash": "dot"}
    figure.add_trace(go.Scatter(x=[uniform] * 2, y=[-0.5, len(rows) - 0.5], mode="lines", name=f"equal factor {uniform:.3g}", line=line))
    names = [label(short_name(result.items[k].name)) + (" (not limiting)" if other.not_limiting[k] else "") for k in shown]
    return _formatted(figure, names, [*values, uniform])


def yield_curve(result: Targets) -> go.Figure:
    """Plot the yield (%) against the target (mm)."""
    import plotly.graph_objects as go

    traces: list[Any] = []
    for one, colour in zip(result.yields, (BLUE, ORANGE), strict=True):
        targets, shares, ends = one.curve()
        x, name = targets * 1e3, CRITERION_LABELS[one.criterion].format(share=100 * one.share_of_positions)
        band = {"x": [*x, *x[::-1]], "y": [*(100 * ends[:, 1]), *(100 * ends[::-1, 0])]}
        traces.append(go.Scatter(**band, fill="toself", fillcolor=_BAND[colour], line={"width": 0}, mode="lines", hoverinfo="skip", showlegend=False))
        line = {"color": colour, "width": 2, "shape": "hv"}
        traces.append(go.Scatter(x=x, y=100 * shares, mode="lines", name=name, line=line, hovertemplate="%{x:.4~g} mm: %{y:.4~g} %<extra></extra>"))
    figure = framed("Yield against target, with 95 % confidence interval", *traces, height=420)
    figure.add_shape(
        type="line",
        x0=result.target * 1e3,
        x1=result.target * 1e3,
        y0=0,
        y1=1,
        yref="y domain",
        line={"color": RED, "width": 1.3, "dash": "dot"},
    )
    figure.add_annotation(
        x=result.target * 1e3,
        y=0.02,
        yref="y domain",
        yanchor="bottom",
        xanchor="left",
        xshift=4,
        text="target",
        showarrow=False,
        font={"color": RED},
    )
    figure.update_xaxes(title_text="target [mm]")
    figure.update_yaxes(title_text="yield [%]", range=[-2, 102])
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure


def _finite(value: float, instead: float) -> float:
    return value if math.isfinite(value) else instead


def _bars(starts: Sequence[float], values: Sequence[float], colours: Sequence[str]) -> list[go.Scatter]:
    """Return the bars of the dumbbells, one trace per colour."""
    import plotly.graph_objects as go

    out = []
    for colour in dict.fromkeys(colours):
        x: list[float | None] = []
        y: list[float | None] = []
        for k, (start, value) in enumerate(zip(starts, values, strict=True)):
            if colours[k] == colour:
                x += [start, value, None]
                y += [k, k, None]
        out.append(go.Scatter(x=x, y=y, mode="lines", line={"color": colour, "width": 3}, opacity=0.45, hoverinfo="skip", showlegend=False))
    return out


def _dots(x: Sequence[float], y: Sequence[int], name: str, colour: Any, texts: Sequence[str], symbol: str = "circle") -> go.Scatter:  # noqa: ANN401
    import plotly.graph_objects as go

    marker = {"size": 9, "color": colour, "symbol": symbol, "line": {"width": 2, "color": colour}}
    return go.Scatter(
        x=list(x), y=list(y), mode="markers", name=name, marker=marker, customdata=list(texts), hovertemplate="%{customdata}<extra></extra>"
    )


def _formatted(figure: go.Figure, names: Sequence[str], values: Sequence[float]) -> go.Figure:
    low, high = math.log10(min(1.0, *values)), math.log10(max(1.0, *values))
    margin = 0.06 * (high - low) + 0.02
    low, high = low - margin, high + margin
    marks = (1.0,) if high - low > 3 else (1.0, 2.0, 5.0) if high - low > 0.9 else (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0)  # noqa: PLR2004 - decades
    ticks = [mark * 10.0**power for power in range(math.floor(low), math.ceil(high) + 1) for mark in marks]
    shown = [tick for tick in ticks if low <= math.log10(tick) <= high]
    figure.update_xaxes(title_text=_FACTOR, type="log", range=[low, high], tickvals=shown, ticktext=[f"{tick:.6g}" for tick in shown])
    figure.update_yaxes(**named(names), tickfont={"size": 11})
    figure.update_layout(legend=LEGEND, margin_t=108)  # beside long names the legend has three rows
    return figure
