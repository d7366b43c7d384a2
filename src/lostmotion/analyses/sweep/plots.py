"""Plots of a sweep: error, AP and RP over one key, a map over two, main effects over more; error distribution of each design."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.sweep.tables.sweep import LEVEL
from lostmotion.reporting.plot import BLUE, GREEN, INK, LEGEND, ORANGE, PER_UNIT, RED, Plot, framed, label, styled
from lostmotion.runs.design_names import design_name, short_keys

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import plotly.graph_objects as go

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.io.sweep import Axis
    from lostmotion.runs.job import Order
    from lostmotion.runs.summary import Outcome
    from lostmotion.spatial import Floats

    _Curve = tuple[str, str, Callable[[Outcome], Estimate | None]]

# Viridis, dark where the error is large.
_SCALE: Final = ((0.0, "#fde725"), (0.25, "#5ec962"), (0.5, "#21918c"), (0.75, "#3b528b"), (1.0, "#440154"))
_SHADES: Final = {BLUE: "rgba(0,114,178,0.15)", ORANGE: "rgba(230,159,0,0.18)", GREEN: "rgba(0,158,115,0.15)", RED: "rgba(178,58,0,0.15)"}
_DASHES: Final = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
_MOST_CURVES: Final = 6
_MOST_LABELLED: Final = 6
_PAIRED: Final = "paired differences from the first design are more precise"


def sweep_plots(order: Order, outcomes: Sequence[Outcome]) -> list[Plot]:
    """Return the plots in reading order, over the keys that differ between designs."""
    order = order.model_copy(update={"axes": tuple(axis for axis in order.axes if len(axis.values) > 1) or order.axes})
    out = []
    if len(order.axes) == 1:
        out.append(
            Plot("designs", "designs", over_one(order, outcomes), "Curves of the 95th percentile and the mean of the error over the swept key.")
        )
        if outcomes[0].ap is not None:
            out.append(Plot("iso9283", "iso9283", iso_over_one(order, outcomes), "Curves of AP and RP over the swept key."))
    elif len(order.axes) == 2:  # noqa: PLR2004 - a plane
        out.append(
            Plot(
                "designs", "designs", over_two(order, *_errors(outcomes), _PAIRED), "Map of the 95th percentile of the error over the two swept keys."
            )
        )
        if outcomes[0].rp is not None:
            estimates = [each.rp[1] for each in outcomes if each.rp is not None]
            out.append(Plot("iso9283", "iso9283", over_two(order, estimates, "RP, 95th percentile of robots"), "Map of RP over the two swept keys."))
    elif order.axes:
        out.append(
            Plot("designs", "designs", effects(order, outcomes), "For each key, the 95th percentile of every design and the mean of each value.")
        )
    if len(outcomes) <= _MOST_CURVES:
        out.append(Plot("spread", "levels" if order.axes else "designs", spread(order, outcomes), "Cumulative distribution of the error."))
    return out


def _errors(outcomes: Sequence[Outcome]) -> tuple[list[Estimate], str]:
    return [each.quantiles[LEVEL] for each in outcomes], "95th percentile of the position error"


def _unit(largest: float) -> str:
    """Return the unit of an axis for its largest value, m."""
    return "µm" if largest < 1e-4 else "mm" if largest < 1 else "m"  # noqa: PLR2004 - where people change units


def _positions(axis: Axis, name: str) -> tuple[list[Any], dict[str, Any]]:
    """Return the positions of a key's values on an axis, and the axis' format: quantities to scale, other values as text."""
    if axis.quantities is None:
        return [label(text) for text in axis.labels], {"title_text": label(name), "type": "category"}
    numbers, unit = axis.quantities
    title = f"{label(name)} [{label(unit)}]" if unit else label(name)
    rising = np.sort(numbers)
    ratios = rising[1:] / rising[:-1] if rising[0] > 0 and len(rising) > 2 else np.array([1.0, 2.0])  # noqa: PLR2004 - two have any ratio
    even_in_log = bool(np.allclose(ratios, ratios[0], rtol=1e-6) and ratios[0] > 1 + 1e-9)
    return list(numbers), {"title_text": title, "type": "log" if even_in_log else "linear"}


def _curves(order: Order, outcomes: Sequence[Outcome], curves: Sequence[_Curve], title: str) -> go.Figure:
    """Plot estimates over one key, with intervals as bands, or as error bars where the values have no order."""
    import plotly.graph_objects as go

    axis = order.axes[0]
    x, axis_format = _positions(axis, short_keys(order.axes)[0])
    ranked = np.argsort(x, kind="stable") if axis.quantities is not None else np.arange(len(x))
    estimates = {name: [pick(outcomes[k]) for k in ranked] for name, _, pick in curves}
    values = [each.value for members in estimates.values() for each in members if each is not None]
    unit = _unit(max(values, default=1.0))
    factor = PER_UNIT[unit]
    along = [x[k] for k in ranked]
    traces = []
    for name, colour, _ in curves:
        members = [each for each in estimates[name] if each is not None]
        y, low, high = (np.array([getattr(each, end) for each in members]) * factor for end in ("value", "low", "high"))
        hover = f"%{{x}}: %{{y:.4~g}} {unit}, %{{customdata}}<extra>{name}</extra>"
        intervals = [f"{a:.4g} … {b:.4g}" if math.isfinite(b - a) else "no interval" for a, b in zip(low, high, strict=True)]
        if axis.quantities is None:
            bars = {"type": "data", "symmetric": False, "array": high - y, "arrayminus": y - low, "thickness": 1.3}
            marker = {"color": colour, "size": 9}
            traces.append(go.Scatter(x=along, y=y, mode="markers", name=name, error_y=bars, marker=marker, customdata=intervals, hovertemplate=hover))
            continue
        if np.isfinite(high - low).all():
            band = {"x": [*along, *along[::-1]], "y": [*high, *low[::-1]], "fill": "toself", "fillcolor": _SHADES[colour], "line": {"width": 0}}
            traces.append(go.Scatter(**band, mode="lines", hoverinfo="skip", showlegend=False))
        line = {"color": colour, "width": 2}
        traces.append(go.Scatter(x=along, y=y, mode="lines+markers", name=name, line=line, customdata=intervals, hovertemplate=hover))
    figure = framed(title, *traces, height=430)
    figure.update_xaxes(**axis_format)
    figure.update_yaxes(title_text=f"position error [{unit}]", rangemode="tozero")
    figure.update_layout(legend=LEGEND, margin_t=84)
    return figure


def over_one(order: Order, outcomes: Sequence[Outcome]) -> go.Figure:
    """Plot the error over one key, with 95 % confidence intervals."""
    curves = (("95th percentile", BLUE, lambda each: each.quantiles[LEVEL]), ("mean", ORANGE, lambda each: each.mean))
    return _curves(order, outcomes, curves, "Position error, with 95 % confidence interval")


def iso_over_one(order: Order, outcomes: Sequence[Outcome]) -> go.Figure:
    """Plot AP and RP over one key, with 95 % confidence intervals."""
    curves = (
        ("AP, 95th percentile of robots", GREEN, lambda each: each.ap and each.ap[1]),
        ("RP, 95th percentile of robots", RED, lambda each: each.rp and each.rp[1]),
    )
    return _curves(order, outcomes, curves, "Accuracy and repeatability, with 95 % confidence intervals")


def over_two(order: Order, estimates: Sequence[Estimate], title: str, hint: str = "") -> go.Figure:
    """Plot a map over two keys; cells whose interval overlaps that of the smallest are marked.

    Colours span the ends of the intervals, so that differences within them are faint. `hint` names a more precise comparison.
    """
    import plotly.graph_objects as go

    first, second = order.axes
    names = [label(name) for name in short_keys(order.axes)]
    shape = (len(first.values), len(second.values))
    largest = max(each.value for each in estimates)
    unit = _unit(largest)
    values = np.array([each.value * PER_UNIT[unit] for each in estimates]).reshape(shape)
    intervals = np.array([f"{each.low * PER_UNIT[unit]:.4g} … {each.high * PER_UNIT[unit]:.4g} {unit}" for each in estimates]).reshape(shape)
    overlapping = _overlap_smallest(estimates)
    marks = np.array(["≈ " if each else "" for each in overlapping]).reshape(shape)
    cell_text = {"texttemplate": "%{text}%{z:.3g}", "textfont": {"size": 12}} if shape[1] <= _MOST_LABELLED else {}
    ends = [end * PER_UNIT[unit] for each in estimates for end in (each.low, each.value, each.high) if math.isfinite(end)]
    cells = go.Heatmap(
        z=values,
        x=[label(text) for text in second.labels],
        y=[label(text) for text in first.labels],
        text=marks,
        zmin=max(min(ends), 0.0),
        zmax=max(ends),
        customdata=intervals,
        colorscale=[list(stop) for stop in _SCALE],
        colorbar={"title": {"text": unit, "side": "top"}, "thickness": 14, "outlinewidth": 0},
        hovertemplate=f"{names[0]} %{{y}}, {names[1]} %{{x}}<br>%{{text}}%{{z:.4~g}} {unit} (%{{customdata}})<extra></extra>",
        xgap=1,
        ygap=1,
        **cell_text,
    )
    figure = framed(f"{title} [{unit}]", cells, height=min(220 + 44 * shape[0], 700))
    note = ""
    if all(overlapping):
        note = "≈ all intervals overlap that of the smallest:<br>" + (hint or "differences may be chance")
    elif any(overlapping):
        note = "≈ interval overlaps that of the smallest:<br>" + (hint or "may be as small")
    figure.update_xaxes(title_text=f"{names[1]}<br>{note}" if note else names[1], type="category", showgrid=False)
    figure.update_yaxes(title_text=names[0], type="category", showgrid=False)
    return figure


def _overlap_smallest(estimates: Sequence[Estimate]) -> list[bool]:
    """Return which intervals overlap that of the smallest estimate, unknown ends counted as overlapping; none if it is alone."""
    best = min(estimates, key=lambda each: each.value)
    high = math.inf if math.isnan(best.high) else best.high
    overlapping = [math.isnan(each.low) or each.low <= high for each in estimates]
    return overlapping if sum(overlapping) > 1 else [False] * len(estimates)


def effects(order: Order, outcomes: Sequence[Outcome]) -> go.Figure:
    """Plot the main effect of each key: the mean over all other keys, and every design."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    shape = tuple(len(axis.values) for axis in order.axes)
    unit = _unit(max(each.quantiles[LEVEL].value for each in outcomes))
    errors: Floats = np.array([each.quantiles[LEVEL].value * PER_UNIT[unit] for each in outcomes]).reshape(shape)
    count = len(shape)
    figure = make_subplots(rows=count, cols=1, vertical_spacing=min(0.34 / count, 0.12), shared_yaxes="all")
    for k, (axis, name) in enumerate(zip(order.axes, short_keys(order.axes), strict=True)):
        x, axis_format = _positions(axis, name)
        at = np.indices(shape)[k].ravel()
        dots = {"color": BLUE, "size": 5, "opacity": 0.45}
        names = [label(design_name(order.axes, each.design)) for each in outcomes]
        hover = f"%{{customdata}}: %{{y:.4~g}} {unit}<extra></extra>"
        figure.add_trace(
            go.Scatter(
                x=[x[j] for j in at],
                y=errors.ravel(),
                mode="markers",
                marker=dots,
                name="one design",
                customdata=names,
                hovertemplate=hover,
                showlegend=k == 0,
            ),
            row=k + 1,
            col=1,
        )
        means = errors.mean(axis=tuple(j for j in range(count) if j != k))
        ranked = np.argsort(x, kind="stable") if axis.quantities is not None else np.arange(len(x))
        figure.add_trace(
            go.Scatter(
                x=[x[j] for j in ranked],
                y=means[ranked],
                mode="lines+markers",
                name="mean over the other keys",
                line={"color": RED, "width": 2},
                hovertemplate=f"mean at %{{x}}: %{{y:.4~g}} {unit}<extra></extra>",
                showlegend=k == 0,
            ),
            row=k + 1,
            col=1,
        )
        figure.update_xaxes(row=k + 1, col=1, **axis_format)
        figure.update_yaxes(row=k + 1, col=1, title_text=f"95th percentile [{unit}]")
    styled(figure, "Main effects on the 95th percentile of the error", height=110 + 230 * count)
    figure.update_layout(legend=LEGEND, margin_t=84)
    return figure


def spread(order: Order, outcomes: Sequence[Outcome]) -> go.Figure:
    """Plot the cumulative distribution of the error of each design."""
    import plotly.graph_objects as go

    unit = _unit(max(each.worst[0].error for each in outcomes))
    colours = (BLUE, ORANGE, GREEN, RED, INK, "#CC79A7")
    traces = [
        go.Scatter(
            x=each.spread[0] * PER_UNIT[unit],
            y=100 * each.spread[1],
            mode="lines",
            name=label(design_name(order.axes, each.design)),
            line={"color": colours[k], "width": 2, "dash": _DASHES[k]},
            hovertemplate=f"%{{y:.2f}} % within %{{x:.4~g}} {unit}<extra></extra>",
            showlegend=len(outcomes) > 1,
        )
        for k, each in enumerate(outcomes)
    ]
    figure = framed("Cumulative distribution of the position error", *traces, height=430)
    figure.update_xaxes(title_text=f"position error [{unit}]", rangemode="tozero")
    figure.update_yaxes(title_text="samples [%]", range=[0, 101])
    figure.update_layout(legend={**LEGEND, "orientation": "v", "x": 1, "xanchor": "right", "y": 0.05, "yanchor": "bottom"})
    return figure
