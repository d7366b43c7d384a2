"""Plots of an arm at rest: holding torques by cause, compliance over the poses, compliance ellipsoid, compliance by part."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.load_causes import CAUSES
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.plot import BLUE, INK, LEGEND, OF_CAUSE, ORANGE, Plot, framed, label, named, projected, styled

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.statics.survey import Survey
    from lostmotion.mechanism.elastostatics import Ellipsoid
    from lostmotion.spatial import Floats

_SCALE: Final = ((0.0, "#c8df3a"), (0.2, "#5ec962"), (0.4, "#21918c"), (0.6, "#31688e"), (0.8, "#443983"), (1.0, "#2b0040"))
_MOST_POSES: Final = 3000
_PARTS_SHOWN: Final = 15


def statics_plots(survey: Survey) -> list[Plot]:
    """Return the plots in reading order; a rigid arm has none of compliance."""
    drawn = [Plot("causes", "causes", causes(survey), "Stacked bars of each joint's largest holding torque by cause.")]
    if survey.parts:
        drawn += [
            Plot("compliance-xoz", "map", compliance_map(survey, 0, 2), "Tool points on the XOZ plane coloured by the largest compliance."),
            Plot("compliance-xoy", "map", compliance_map(survey, 0, 1), "Tool points on the XOY plane coloured by the largest compliance."),
            Plot(
                "ellipsoid", "ellipsoid", ellipsoid_plot(survey), "Compliance ellipsoids at the most compliant pose, rotation free and constrained."
            ),
            Plot("shares", "shares", shares(survey), "Bars of each part's share of the compliance, mean and at the most compliant pose."),
        ]
    return drawn


def causes(survey: Survey) -> go.Figure:
    """Plot the largest holding torque of each drive by cause; causes that relieve the drive are negative."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    units = [unit for unit in ("N m", "N") if any(node.unit == unit for node in survey.joint_loads)]
    counts = [sum(node.unit == unit for node in survey.joint_loads) for unit in units]
    gap = 74 * (len(units) - 1)
    inside = 40 * sum(counts) + gap
    figure = make_subplots(rows=len(units), cols=1, row_heights=counts, vertical_spacing=gap / inside)
    tilt = "any tilt of the base" if survey.tilt is None else "worst tilt of the base"
    figure = styled(figure, f"Largest holding torques, {tilt}", height=inside + 150)
    shown: set[str] = set()
    for row, unit in enumerate(units, start=1):
        nodes = [node for node in survey.joint_loads if node.unit == unit]
        for cause in CAUSES:
            loads = [node.required for node in nodes]
            values = [float(np.sign(load.value)) * load.by_cause.get(cause, 0.0) for load in loads]
            if not any(abs(value) > 1e-9 * max(abs(load.value) for load in loads) for value in values):
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


def compliance_map(survey: Survey, across: int, up: int) -> go.Figure:
    """Plot tool points (mm) projected along one axis, coloured by the compliance along the most compliant direction."""
    import plotly.graph_objects as go

    chosen = np.unique(np.linspace(0, len(survey.tool_positions) - 1, min(_MOST_POSES, len(survey.tool_positions))).astype(int))
    # The most compliant on top, so that stiffer ones do not cover them.
    chosen = chosen[np.argsort(survey.max_compliance[chosen], kind="stable")]
    at, soft = _mm(survey.tool_positions[chosen]), np.round(survey.max_compliance[chosen] * 1e6, 5).astype(np.float32)
    names = "XYZ"[across], "XYZ"[up]
    title = {"text": "largest compliance [µm/N]", "side": "right", "font": {"size": 13}}
    marker = {
        "size": 4.5,
        "color": soft,
        "colorscale": [list(stop) for stop in _SCALE],
        "colorbar": {"title": title, "thickness": 12, "outlinewidth": 0, "ticks": "outside", "len": 0.85, "nticks": 7},
    }
    hover = f"{names[0].lower()} %{{x:.0f}} mm, {names[1].lower()} %{{y:.0f}} mm<br>%{{marker.color:.4~g}} µm/N<extra></extra>"
    return projected(
        "Compliance",
        across,
        up,
        _mm(survey.tool_positions[survey.softest_pose]),
        "most compliant pose",
        survey.softest_pose,
        go.Scatter(x=at[:, across], y=at[:, up], mode="markers", marker=marker, name="sampled", hovertemplate=hover),
    )


def ellipsoid_plot(survey: Survey) -> go.Figure:
    """Plot the compliance ellipsoids (µm/N) at the most compliant pose, rotation of the tool free and constrained."""
    import plotly.graph_objects as go

    free, guided = survey.translational, survey.guided
    traces = [_surface(free, BLUE, 0.25, "free to rotate"), _surface(guided, ORANGE, 0.6, "rotation constrained")]
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
    figure = framed(f"Compliance ellipsoid at pose {survey.softest_pose}", *traces, height=460)
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

    azimuth, polar = np.linspace(0, 2 * np.pi, 41), np.linspace(0, np.pi, 21)
    sphere = np.stack([np.outer(np.cos(azimuth), np.sin(polar)), np.outer(np.sin(azimuth), np.sin(polar)), np.outer(np.ones(41), np.cos(polar))])
    points = np.einsum("ij,jab->iab", ellipsoid.directions[0] * ellipsoid.values[0] * 1e6, sphere)
    x, y, z = np.asarray(np.round(points, 5), dtype=np.float32)
    scale = [[0, colour], [1, colour]]
    return go.Surface(x=x, y=y, z=z, colorscale=scale, showscale=False, opacity=opacity, name=name, showlegend=True, hoverinfo="name")


def shares(survey: Survey) -> go.Figure:
    """Plot each part's share of the compliance, mean over poses and at the most compliant pose, the largest first."""
    import plotly.graph_objects as go

    order = np.argsort(-survey.shares, kind="stable")[:_PARTS_SHOWN]
    names = [label(short_name(survey.parts[k])) for k in order]
    bars = [
        go.Bar(
            x=100 * values[order],
            y=list(range(len(names))),
            orientation="h",
            name=name,
            marker={"color": colour},
            hovertemplate=f"{name}: %{{x:.3~g}} %<extra></extra>",
        )
        for name, values, colour in (("mean over poses", survey.shares, BLUE), ("most compliant pose", survey.softest_shares, ORANGE))
    ]
    figure = framed("Share of compliance by part", *bars, height=140 + 30 * len(names))
    figure.update_xaxes(title_text="share of compliance [%]", rangemode="tozero")
    figure.update_yaxes(**named(names))
    figure.update_layout(barmode="group", bargap=0.3, bargroupgap=0.08, legend=LEGEND, margin_t=80)
    return figure


def _mm(metres: Floats) -> Floats:
    return np.asarray(np.round(metres * 1e3, 1), dtype=np.float32)
