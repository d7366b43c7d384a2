"""The plots of an arm that stands still: where it gives, its ellipsoid at the softest pose, which part gives, whose weight the drives hold."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.load_causes import CAUSES
from lostmotion.reporting.plot import BLUE, INK, LEGEND, OF_CAUSE, ORANGE, RED, Plot, framed, label, named, styled

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.statics.survey import Survey
    from lostmotion.mechanism.elastostatics import Ellipsoid
    from lostmotion.spatial import Floats

_SCALE: Final = ((0.0, "#c8df3a"), (0.2, "#5ec962"), (0.4, "#21918c"), (0.6, "#31688e"), (0.8, "#443983"), (1.0, "#2b0040"))
_MOST_POSES: Final = 3000
_PARTS_SHOWN: Final = 15


def statics_plots(found: Survey) -> list[Plot]:
    """Which plots does a survey have? In reading order; no compliance is drawn of an arm that is rigid."""
    drawn = [Plot("causes", "causes", causes(found), "Stacked bars of each joint's largest holding torque by whose weight it is.")]
    if found.parts:
        drawn += [
            Plot("compliance-xoz", "map", compliance_map(found, 0, 2), "Tool points on the XOZ plane coloured by their softest direction."),
            Plot("compliance-xoy", "map", compliance_map(found, 0, 1), "Tool points on the XOY plane coloured by their softest direction."),
            Plot("ellipsoid", "ellipsoid", ellipsoid_plot(found), "Compliance ellipsoids at the softest pose, tool free to turn and turning held."),
            Plot("shares", "shares", shares(found), "Bars of each part's share of the compliance, mean over poses and at the softest pose."),
        ]
    return drawn


def causes(found: Survey) -> go.Figure:
    """Whose weight does each drive hold where it holds the most? Parts that help are drawn to the left."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    units = [unit for unit in ("N m", "N") if any(node.unit == unit for node in found.nodes)]
    counts = [sum(node.unit == unit for node in found.nodes) for unit in units]
    gap = 74 * (len(units) - 1)
    inside = 40 * sum(counts) + gap
    figure = make_subplots(rows=len(units), cols=1, row_heights=counts, vertical_spacing=gap / inside)
    how = "whichever way the base is tilted" if found.tilt is None else "within the tilt of the base"
    figure = styled(figure, f"What drives hold at worst, {how}", height=inside + 150)
    shown: set[str] = set()
    for row, unit in enumerate(units, start=1):
        nodes = [node for node in found.nodes if node.unit == unit]
        for cause in CAUSES:
            parts = [node.needed for node in nodes]
            values = [float(np.sign(asked.value)) * asked.by_cause.get(cause, 0.0) for asked in parts]
            if not any(abs(value) > 1e-9 * max(abs(asked.value) for asked in parts) for value in values):
                continue
            bars = go.Bar(
                x=values,
                y=list(range(len(nodes))),
                orientation="h",
                name=cause,
                legendgroup=cause,
                showlegend=cause not in shown,
                marker={"color": OF_CAUSE[cause]},
                hovertemplate=f"{cause}: %{{x:.4~g}} {unit}<extra></extra>",
            )
            shown.add(cause)
            figure.add_trace(bars, row=row, col=1)
        figure.update_yaxes(**named([label(node.joint) for node in nodes]), row=row, col=1)
        figure.update_xaxes(title_text=f"holding {'torque' if unit == 'N m' else 'force'} [{unit}]", row=row, col=1)
    figure.update_layout(barmode="relative", bargap=0.35, legend=LEGEND, margin_t=84)
    return figure


def compliance_map(found: Survey, across: int, up: int) -> go.Figure:
    """Where does the arm give most? Tool points (mm) seen along one axis, coloured by the compliance along their softest direction."""
    import plotly.graph_objects as go

    chosen = np.unique(np.linspace(0, len(found.tool) - 1, min(_MOST_POSES, len(found.tool))).astype(int))
    # The softest on top, so that none hides behind stiffer ones.
    chosen = chosen[np.argsort(found.softest[chosen], kind="stable")]
    at, soft = _mm(found.tool[chosen]), np.round(found.softest[chosen] * 1e6, 5).astype(np.float32)
    names = "XYZ"[across], "XYZ"[up]
    title = {"text": "softest direction [µm/N]", "side": "right", "font": {"size": 13}}
    marker = {
        "size": 4.5,
        "color": soft,
        "colorscale": [list(stop) for stop in _SCALE],
        "colorbar": {"title": title, "thickness": 12, "outlinewidth": 0, "ticks": "outside", "len": 0.85, "nticks": 7},
    }
    worst = _mm(found.tool[[found.worst]])
    ring = {"size": 13, "symbol": "circle-open", "color": RED, "line": {"width": 2}}
    hover = f"{names[0].lower()} %{{x:.0f}} mm, {names[1].lower()} %{{y:.0f}} mm<br>%{{marker.color:.4~g}} µm/N<extra></extra>"
    figure = framed(
        f"Compliance on {names[0]}O{names[1]}",
        go.Scatter(x=at[:, across], y=at[:, up], mode="markers", marker=marker, name="visited", hovertemplate=hover),
        go.Scatter(
            x=worst[:, across],
            y=worst[:, up],
            mode="markers",
            marker=ring,
            name="softest pose",
            hovertemplate=f"softest pose, number {found.worst}<extra></extra>",
        ),
        height=520,
    )
    figure.update_xaxes(title_text=f"{names[0].lower()} [mm]")
    figure.update_yaxes(title_text=f"{names[1].lower()} [mm]", scaleanchor="x", scaleratio=1)
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure


def ellipsoid_plot(found: Survey) -> go.Figure:
    """How does the softest pose give in space? Ellipsoids of principal compliances (µm/N), the tool free to turn and its turning held."""
    import plotly.graph_objects as go

    free, held = found.free, found.held
    traces = [_surface(free, BLUE, 0.25, "free to turn"), _surface(held, ORANGE, 0.6, "turning held")]
    for k in range(3):
        end = free.directions[0, :, k] * free.values[0, k] * 1e6
        traces.append(
            go.Scatter3d(
                x=[-end[0], end[0]],
                y=[-end[1], end[1]],
                z=[-end[2], end[2]],
                mode="lines",
                line={"color": INK, "width": 3},
                hoverinfo="skip",
                showlegend=False,
            )
        )
    figure = framed(f"Compliance ellipsoid at pose {found.worst}", *traces, height=460)
    reach = 1.05e6 * float(free.values[0, 0])
    axis = {"range": [-reach, reach], "backgroundcolor": "white", "gridcolor": "#dddddd", "linecolor": "#888888", "showline": True, "nticks": 6}
    scene = {f"{name}axis": {**axis, "tickfont": {"size": 11}, "title": {"text": f"{name} [µm/N]", "font": {"size": 13}}} for name in "xyz"}
    figure.update_layout(
        scene={**scene, "aspectmode": "cube", "camera": {"eye": {"x": 1.4, "y": -1.6, "z": 0.9}}},
        margin={"l": 0, "r": 0, "t": 64, "b": 0},
        legend=LEGEND,
    )
    return figure


def _surface(ellipsoid: Ellipsoid, colour: str, opacity: float, name: str) -> go.Surface:
    import plotly.graph_objects as go

    round_, up = np.linspace(0, 2 * np.pi, 41), np.linspace(0, np.pi, 21)
    ball = np.stack([np.outer(np.cos(round_), np.sin(up)), np.outer(np.sin(round_), np.sin(up)), np.outer(np.ones(41), np.cos(up))])
    points = np.einsum("ij,jab->iab", ellipsoid.directions[0] * ellipsoid.values[0] * 1e6, ball)
    x, y, z = np.asarray(np.round(points, 5), dtype=np.float32)
    scale = [[0, colour], [1, colour]]
    return go.Surface(x=x, y=y, z=z, colorscale=scale, showscale=False, opacity=opacity, name=name, showlegend=True, hoverinfo="name")


def shares(found: Survey) -> go.Figure:
    """Which parts give? Each part's share of the compliance, mean over poses and where the arm is softest, the softest part on top."""
    import plotly.graph_objects as go

    order = np.argsort(-found.shares, kind="stable")[:_PARTS_SHOWN]
    names = [label(found.parts[k].removeprefix("joints.")) for k in order]
    bars = [
        go.Bar(
            x=100 * values[order],
            y=list(range(len(names))),
            orientation="h",
            name=name,
            marker={"color": colour},
            hovertemplate=f"{name}: %{{x:.3~g}} %<extra></extra>",
        )
        for name, values, colour in (("mean over poses", found.shares, BLUE), ("softest pose", found.worst_shares, ORANGE))
    ]
    figure = framed("Share of compliance by part", *bars, height=140 + 30 * len(names))
    figure.update_xaxes(title_text="share of compliance [%]", rangemode="tozero")
    figure.update_yaxes(**named(names))
    figure.update_layout(barmode="group", bargap=0.3, bargroupgap=0.08, legend=LEGEND, margin_t=80)
    return figure


def _mm(metres: Floats) -> Floats:
    return np.asarray(np.round(metres * 1e3, 1), dtype=np.float32)
