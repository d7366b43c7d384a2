"""Plots of a measured robot by ISO 9283: accuracy over poses, along paths, and compared with predicted robots."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.iso9283.tables.comparison import SHOWN
from lostmotion.analyses.iso9283.tables.labels import load_label
from lostmotion.reporting.plot import BLUE, GREEN, INK, LEGEND, ORANGE, PER_UNIT, RED, framed, label, named, styled
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.iso9283.comparison import ComparedFigure
    from lostmotion.analyses.iso9283.measured import MeasuredLoad, MeasuredRobot

_SMALLEST: Final = 1e-10
_COLOURS: Final = (BLUE, ORANGE, GREEN, RED)


def side_by_side(compared: list[ComparedFigure]) -> go.Figure:
    """Return the measured lengths over the range from the 5th to the 95th percentile of the predicted robots."""
    import plotly.graph_objects as go

    shown = [each for name in SHOWN for each in compared if each.name == name and not each.angle and each.name != "AD_p" and each.measured.value > 0]
    shown = [each for each in shown if each.predicted.high.value > _SMALLEST]
    order = {key: k for k, key in enumerate(dict.fromkeys((each.name, each.pose) for each in shown))}
    shown.sort(key=lambda each: (order[each.name, each.pose], -each.load))
    places = list(range(len(shown)))
    low = np.array([max(each.predicted.low.value, _SMALLEST) for each in shown]) * 1e6
    high = np.array([each.predicted.high.value for each in shown]) * 1e6
    mean = [each.predicted.mean.value * 1e6 for each in shown]
    value = np.array([each.measured.value for each in shown]) * 1e6
    ends = [
        [abs(end * 1e6 - v) if math.isfinite(end) else 0.0 for end in (each.measured.low, each.measured.high)]
        for each, v in zip(shown, value, strict=True)
    ]
    colours = [GREEN if each.within else RED for each in shown]
    # Thick lines instead of bars, which need a base that a logarithmic axis does not have.
    bars = go.Scatter(
        x=[x for pair in zip(low, high, [None] * len(low), strict=True) for x in pair],
        y=[y for place in places for y in (place, place, None)],
        mode="lines",
        line={"color": "#9ec9e2", "width": 13},
        name="predicted, 5th to 95th percentile",
        hoverinfo="skip",
    )
    ticks = go.Scatter(
        x=mean,
        y=places,
        mode="markers",
        name="mean over robots",
        marker={"symbol": "line-ns", "size": 13, "line": {"color": BLUE, "width": 2}},
        hovertemplate="mean %{x:.4~g} µm<extra></extra>",
    )
    points = go.Scatter(
        x=value,
        y=places,
        mode="markers",
        name="measured (red: outside)",
        marker={"color": colours, "size": 9, "symbol": "diamond"},
        error_x={
            "type": "data",
            "symmetric": False,
            "array": [end[1] for end in ends],
            "arrayminus": [end[0] for end in ends],
            "thickness": 1.3,
            "color": INK,
        },
        hovertemplate="measured %{x:.4~g} µm<extra></extra>",
    )
    figure = framed("Predicted and measured", bars, ticks, points, height=170 + 26 * len(shown))
    figure.update_xaxes(title_text="µm, logarithmic", type="log", dtick=1)
    loads = {each.load for each in shown}
    figure.update_yaxes(**named([load_label(f"{each.name}, {label(each.pose)}", each.load, loads) for each in shown]))
    figure.update_layout(legend=LEGEND, margin_t=96)
    return figure


def measured_accuracy(found: MeasuredLoad, title: str = "Measured AP_p") -> go.Figure:
    """Return bars or a histogram of measured AP_p over the poses, with commanded and with best-fit frames."""
    import plotly.graph_objects as go

    raw = np.array([pose.accuracy.value for pose in found.poses])
    fitted = np.array([pose.fitted for pose in found.poses])
    unit = length(float(raw.max())).unit
    factor = PER_UNIT[unit]
    traces: list[Any] = []
    many = len(raw) > 20  # noqa: PLR2004 - too many to label
    for values, name, colour in ((raw, "commanded frames", BLUE), (fitted, "best-fit frames", GREEN)):
        if many:
            bins = {"start": 0.0, "end": float(raw.max()) * factor, "size": float(raw.max()) * factor / 40}
            traces.append(go.Histogram(x=values * factor, name=name, marker={"color": colour}, opacity=0.65, xbins=bins))
        else:
            names = [label(pose.name) for pose in found.poses]
            traces.append(go.Bar(x=names, y=values * factor, name=name, marker={"color": colour}, hovertemplate=f"%{{y:.4~g}} {unit}<extra></extra>"))
    figure = framed(title, *traces, height=340)
    figure.update_xaxes(title_text=f"AP_p [{unit}]" if many else "pose", showgrid=many)
    figure.update_yaxes(title_text="poses [1]" if many else f"AP_p [{unit}]", rangemode="tozero")
    figure.update_layout(barmode="overlay" if many else "group", legend=LEGEND, margin_t=80)
    return figure


def measured_path(found: MeasuredRobot) -> go.Figure:
    """Return measured AT and RT along each path under each load, with a point for each plane."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    drawn = [(load, path) for load in found.loads for path in load.paths]
    figure = styled(make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.09), "Measured along the path", height=420)
    several = len({path.name for _, path in drawn}) > 1
    for row, word in enumerate(("AT", "RT"), 1):
        unit = length(max(float(path.profile[row - 1].max()) for _, path in drawn)).unit
        for k, (load, path) in enumerate(drawn):
            name = load_label(f"measured{f', {label(path.name)}' if several else ''}", load.load, found.loads)
            trace = go.Scatter(
                x=path.places * 1e3,
                y=path.profile[row - 1] * PER_UNIT[unit],
                name=name,
                legendgroup=name,
                showlegend=row == 1,
                mode="lines+markers",
                line={"color": _COLOURS[k % len(_COLOURS)], "width": 2},
                marker={"size": 6},
                hovertemplate=f"%{{x:.0f}} mm: {word} %{{y:.4~g}} {unit}<extra></extra>",
            )
            figure.add_trace(trace, row=row, col=1)
        figure.update_yaxes(title_text=f"{word} [{unit}]", rangemode="tozero", row=row, col=1)
    start = "the start of the path" if several else f"the start of {label(drawn[0][1].name)}"
    figure.update_xaxes(title_text=f"distance from {start} [mm]", row=2, col=1)
    figure.update_layout(legend=LEGEND, margin_t=80, showlegend=True)
    return figure
