"""Plots of an ISO 9283 sheet: test cube, accuracy by pose, visits about barycentres, path, drift, predicted and measured."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.iso9283.comparison import over_robots
from lostmotion.analyses.iso9283.cube import NAMES
from lostmotion.analyses.iso9283.plots.measured import measured_accuracy, measured_path, side_by_side
from lostmotion.analyses.iso9283.tables.labels import load_label
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.serial import tool_points
from lostmotion.reporting.plot import BLUE, GREEN, INK, LEGEND, ORANGE, PER_UNIT, RED, Plot, framed, label, styled
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.iso9283.comparison import ComparedFigure
    from lostmotion.analyses.iso9283.measured import MeasuredRobot
    from lostmotion.analyses.iso9283.predicted import PredictedRobots
    from lostmotion.analyses.iso9283.warm_up import Drift
    from lostmotion.spatial import Floats

_CLOUD: Final = "#cfcfcf"
_POINTS: Final = 4096
_EDGES: Final = (0, 1, 2, 3, 0, 4, 5, 1, 5, 6, 2, 6, 7, 3, 7, 4)
_PLANE: Final = (0, 1, 6, 7, 0)
_ROBOT_COLOURS: Final = (BLUE, ORANGE, GREEN)
_PANELS: Final = 5
_SMALLEST: Final = 1e-10


def iso_plots(predicted: PredictedRobots | None, drifted: Drift | None, measured: MeasuredRobot | None, compared: list[ComparedFigure]) -> list[Plot]:
    """Return the plots of a sheet, in reading order."""
    drawn: list[Plot] = []
    if predicted is not None:
        drawn += [
            Plot("cube", "cube", cube(predicted), "Test cube with its five poses and the path, in the cloud of reachable tool points."),
            Plot(
                "accuracy",
                "ap100",
                accuracy(predicted),
                "Bars of the 95th percentile of pose accuracy over robots, with commanded and with best-fit frames.",
            ),
        ]
        if predicted.loads[0].repeatability.max() > _SMALLEST:
            shown = [errors - errors.mean(axis=1, keepdims=True) for errors in predicted.loads[0].shown]
            names = [f"robot {k + 1}" for k in range(len(shown))]
            drawn.append(
                Plot("visits", "rp100", visits(shown, list(NAMES), names), "Visits of three robots about their own barycentres, at each pose.")
            )
        drawn.append(Plot("path", "path", path(predicted), "Path accuracy and repeatability along the line, mean and 95th percentile over robots."))
        if drifted is not None:
            drawn.append(Plot("drift", "drift", drift(drifted), "Pose accuracy at P1 during warm-up of the links."))
    if compared:
        drawn.append(
            Plot(
                "compared",
                "compared",
                side_by_side(compared),
                "Predicted 5th to 95th percentile, and measured values.",
            )
        )
    if measured is not None:
        drawn += _measured(measured)
    return drawn


def _measured(measured: MeasuredRobot) -> list[Plot]:
    """Return the plots of a measured robot, with all its loads in one plot where it stays readable."""
    drawn = []
    several = list(dict.fromkeys(pose.name for load in measured.loads for pose in load.poses if pose.visits > 1))[:_PANELS]
    if several:
        about = [
            [pose.errors - pose.errors.mean(axis=0) for name in several for pose in load.poses if pose.name == name]
            for load in measured.loads
            if set(several) <= {pose.name for pose in load.poses}
        ]
        names = [load_label("measured", load.load, measured.loads) for load in measured.loads if set(several) <= {pose.name for pose in load.poses}]
        if about:
            drawn.append(Plot("measured-visits", "measured-repeatability", visits(about, several, names), "Measured visits about their barycentres."))
    for load in measured.loads:
        if load.fit is not None:
            key = "measured-accuracy" if load is measured.loads[0] else f"measured-accuracy-{100 * load.load:g}"
            title = load_label("Measured AP_p", load.load, measured.loads)
            drawn.append(Plot(key, key, measured_accuracy(load, title), "AP_p of all poses, with commanded and with best-fit frames."))
    if any(load.paths for load in measured.loads):
        drawn.append(
            Plot(
                "measured-path", "measured-path", measured_path(measured), "Measured path accuracy and repeatability along the line, plane by plane."
            )
        )
    return drawn


def cube(found: PredictedRobots) -> go.Figure:
    """Return the test cube in the workspace: cube, its plane, five poses, the path and reachable tool points, mm."""
    import plotly.graph_objects as go

    def line(points: Floats, name: str, colour: str, **style: Any) -> go.Scatter3d:  # noqa: ANN401 - plotly publishes no types
        x, y, z = (points * 1e3).T
        return go.Scatter3d(x=x, y=y, z=z, name=name, mode="lines", line={"color": colour, "width": 4, **style}, hoverinfo="skip")

    cloud = tool_points(found.arm, sample_poses(found.arm, _POINTS).q) * 1e3
    corners, five = found.cube.corners, found.cube.poses[:, :3, 3]
    marker = {"size": 1.3, "color": _CLOUD, "opacity": 0.6}
    traces = [
        go.Scatter3d(x=cloud[:, 0], y=cloud[:, 1], z=cloud[:, 2], mode="markers", name="reachable points", marker=marker, hoverinfo="skip"),
        line(corners[list(_EDGES)], "test cube", INK),
        line(corners[list(_PLANE)], "plane C1-C2-C7-C8", BLUE, dash="dash"),
        line(five[list(found.path_ends)], "path", ORANGE),
        go.Scatter3d(
            x=five[:, 0] * 1e3,
            y=five[:, 1] * 1e3,
            z=five[:, 2] * 1e3,
            mode="markers+text",
            name="poses",
            text=[f"<b>{name}</b>" for name in NAMES],
            textposition=["middle right", "bottom left", "bottom right", "top right", "top left"],  # away from the cube, as the camera sees it
            textfont={"size": 15, "color": INK},
            marker={"size": 4.5, "color": RED},
            hovertemplate="%{text} x %{x:.1f}, y %{y:.1f}, z %{z:.1f} mm<extra></extra>",
        ),
    ]
    figure = framed("Test cube in the workspace", *traces, height=480)
    axis = {"backgroundcolor": "white", "gridcolor": "#dddddd", "linecolor": "#888888", "showline": True, "zeroline": False, "nticks": 6}
    scene = {f"{name}axis": {**axis, "tickfont": {"size": 11}, "title": {"text": f"{name} [mm]", "font": {"size": 13}}} for name in "xyz"}
    figure.update_layout(
        scene={**scene, "aspectmode": "data", "camera": {"eye": {"x": 1.25, "y": -1.58, "z": 0.82}, "center": {"x": 0, "y": 0, "z": -0.2}}},
        legend={**LEGEND, "y": 0.98, "yanchor": "bottom"},
        margin={"l": 0, "r": 0, "t": 74, "b": 0},
    )
    return figure


def accuracy(found: PredictedRobots) -> go.Figure:
    """Return bars of the 95th percentile of AP_p at each pose and load, with commanded and with best-fit frames."""
    import plotly.graph_objects as go

    top = max(float(over_robots(sheet.accuracy[k]).high.value) for sheet in found.loads for k in range(len(NAMES)))
    unit = length(top).unit
    bars = []
    for sheet, (raw, fitted) in zip(found.loads, ((BLUE, GREEN), ("#86bfe0", "#8fd3bd")), strict=False):
        for values, colour, name in ((sheet.accuracy, raw, "commanded frames"), (sheet.fitted, fitted, "best-fit frames")):
            high = [over_robots(values[k]).high.value * PER_UNIT[unit] for k in range(len(NAMES))]
            text = f"{name}, {100 * sheet.load:.0f} % load"
            bars.append(
                go.Bar(x=list(NAMES), y=high, name=text, marker={"color": colour}, hovertemplate=f"{text}: %{{y:.4~g}} {unit}<extra></extra>")
            )
    figure = framed("95th percentile of AP_p over robots", *bars, height=360)
    figure.update_yaxes(title_text=f"AP_p [{unit}]", rangemode="tozero")
    figure.update_xaxes(title_text="pose", showgrid=False)
    figure.update_layout(barmode="group", bargap=0.25, legend=LEGEND, margin_t=100)
    return figure


def visits(sets: list[Any], poses: list[str], names: list[str]) -> go.Figure:
    """Return the visits about their barycentres, a panel per pose, in top and side view at one scale; sets[robot][pose] (visit, 3), m."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    most = max(float(np.abs(about).max()) for each in sets for about in each)
    unit = "µm" if most < 1e-3 else "mm"  # noqa: PLR2004 - usual change of unit
    limit = 1.15 * most * PER_UNIT[unit] or 1.0
    count = len(poses)
    figure = make_subplots(
        rows=2,
        cols=count,
        shared_xaxes=True,
        shared_yaxes=True,
        horizontal_spacing=0.02,
        vertical_spacing=0.04,
        column_titles=[label(name) for name in poses],
    )
    figure = styled(figure, "Visits about their barycentres", height=400)
    for each, name, colour in zip(sets, names, _ROBOT_COLOURS, strict=False):
        for column, about in enumerate(each):
            for row, axis in ((1, 1), (2, 2)):
                points = np.asarray(about) * PER_UNIT[unit]
                figure.add_trace(
                    go.Scatter(
                        x=points[:, 0],
                        y=points[:, axis],
                        mode="markers",
                        name=name,
                        legendgroup=name,
                        showlegend=column == 0 and row == 1,
                        marker={"size": 4, "color": colour, "opacity": 0.7},
                        hovertemplate=f"%{{x:.3~g}}, %{{y:.3~g}} {unit}<extra>{name}</extra>",
                    ),
                    row=row,
                    col=column + 1,
                )
    decade = 10.0 ** math.floor(math.log10(0.6 * limit))
    tick = max(step * decade for step in (1, 2, 5) if step * decade <= 0.6 * limit)  # well inside, or labels of neighbours run together
    figure.update_xaxes(range=[-limit, limit], tickvals=[-tick, 0, tick], title_standoff=4)
    figure.update_yaxes(range=[-limit, limit], tickvals=[-tick, 0, tick])
    for column in range(1, count + 1):
        figure.update_xaxes(title_text=f"x [{unit}]", row=2, col=column)
    figure.update_yaxes(title_text=f"y [{unit}]", row=1, col=1)
    figure.update_yaxes(title_text=f"z [{unit}]", row=2, col=1)
    figure.update_layout(legend={**LEGEND, "y": 1.09}, margin_t=96)
    return figure


def path(found: PredictedRobots) -> go.Figure:
    """Return AT and RT along the line: mean and 95th percentile over robots at each point."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    a, b = (found.cube.poses[k, :3, 3] for k in found.path_ends)
    along = np.linspace(0, float(np.linalg.norm(b - a)) * 1e3, found.path_points)
    figure = styled(make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.09), "Along the path", height=440)
    for row, word in enumerate(("AT", "RT"), 1):
        unit = length(max(float(sheet.path_profile[row - 1].max()) for sheet in found.loads)).unit
        for sheet, colours in zip(found.loads, ((BLUE, RED), ("#86bfe0", "#e8a77f")), strict=False):
            profile = sheet.path_profile[row - 1]
            for values, name, colour, dash in (
                (profile[:, 0], "mean", colours[0], "solid"),
                (profile[:, 1], "95th percentile", colours[1], "dot"),
            ):
                text = load_label(name, sheet.load, found.loads)
                trace = go.Scatter(
                    x=along,
                    y=values * PER_UNIT[unit],
                    name=text,
                    legendgroup=text,
                    showlegend=row == 1,
                    mode="lines",
                    line={"color": colour, "dash": dash, "width": 2},
                    hovertemplate=f"%{{x:.0f}} mm: {word} %{{y:.4~g}} {unit}<extra></extra>",
                )
                figure.add_trace(trace, row=row, col=1)
        figure.update_yaxes(title_text=f"{word} [{unit}]", rangemode="tozero", row=row, col=1)
    ends = " to ".join(NAMES[k] for k in found.path_ends)
    figure.update_xaxes(title_text=f"distance along {ends} [mm]", row=2, col=1)
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure


def drift(found: Drift) -> go.Figure:
    """Return AP_p at P1 during warm-up: mean over robots and range from the 5th to the 95th percentile."""
    import plotly.graph_objects as go

    hours = found.time / 3600
    low, high = np.quantile(found.accuracy, [0.05, 0.95], axis=1)
    unit = length(float(high.max())).unit
    factor = PER_UNIT[unit]
    band = go.Scatter(
        x=np.concatenate([hours, hours[::-1]]),
        y=np.concatenate([high, low[::-1]]) * factor,
        fill="toself",
        mode="none",
        fillcolor="rgba(0,114,178,0.18)",
        name="5th to 95th percentile",
        hoverinfo="skip",
    )
    mean = go.Scatter(
        x=hours,
        y=found.accuracy.mean(axis=1) * factor,
        name="mean over robots",
        line={"color": BLUE, "width": 2},
        hovertemplate=f"%{{x:.2f}} h: %{{y:.4~g}} {unit}<extra></extra>",
    )
    figure = framed("AP_p at P1 during warm-up", band, mean, height=340)
    figure.update_xaxes(title_text="time since cold start [h]")
    figure.update_yaxes(title_text=f"AP_p [{unit}]", rangemode="tozero")
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure
