"""The plots of an ISO 9283 sheet: cube in the workspace, accuracy by pose, visits about barycentres, path, drift, predicted and measured."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.arm import tool_points
from lostmotion.figures import length
from lostmotion.figures.iso9283_measured import SHOWN
from lostmotion.plots import BLUE, GREEN, INK, LEGEND, ORANGE, PER_UNIT, RED, Plot, framed, label, named, styled
from lostmotion.studies.iso9283.compared import over_robots
from lostmotion.studies.iso9283.cube import NAMES
from lostmotion.studies.poses import sample_poses

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.spatial import Floats
    from lostmotion.studies.iso9283.compared import Compared
    from lostmotion.studies.iso9283.measured import Measured
    from lostmotion.studies.iso9283.predicted import Predicted
    from lostmotion.studies.iso9283.warm_up import Drift

_CLOUD: Final = "#cfcfcf"
_POINTS: Final = 4096
_EDGES: Final = (0, 1, 2, 3, 0, 4, 5, 1, 5, 6, 2, 6, 7, 3, 7, 4)
_PLANE: Final = (0, 1, 6, 7, 0)
_ROBOT_COLOURS: Final = (BLUE, ORANGE, GREEN)
_PANELS: Final = 5
_SMALLEST: Final = 1e-10


def iso_plots(predicted: Predicted | None, drifted: Drift | None, measured: Measured | None, compared: list[Compared]) -> list[Plot]:
    """Which plots does a sheet have? In reading order."""
    drawn: list[Plot] = []
    if predicted is not None:
        drawn += [
            Plot(
                "cube", "cube", cube(predicted), "The test cube with its five poses and the path, within the cloud of points that the tool reaches."
            ),
            Plot(
                "accuracy",
                "ap100",
                accuracy(predicted),
                "Bars of the pose accuracy that 95 % of robots stay below, as it is and with best-fit frames.",
            ),
        ]
        if predicted.loads[0].repeatability.max() > _SMALLEST:
            shown = [errors - errors.mean(axis=1, keepdims=True) for errors in predicted.loads[0].shown]
            names = [f"robot {k + 1}" for k in range(len(shown))]
            drawn.append(
                Plot("visits", "rp100", visits(shown, list(NAMES), names), "Visits of three robots about their own barycentres, at each pose.")
            )
        drawn.append(Plot("path", "path", path(predicted), "Path accuracy and repeatability along the line, mean and 95 % of robots."))
        if drifted is not None:
            drawn.append(Plot("drift", "drift", drift(drifted), "Pose accuracy at P1 over the hours while the links warm up."))
    if compared:
        drawn.append(Plot("compared", "compared", side_by_side(compared), "Bars from 5 to 95 % of the robots predicted, with the measured values."))
    if measured is not None:
        several = [pose for pose in measured.poses if pose.visits > 1][:_PANELS]
        if several:
            about = [pose.errors - pose.errors.mean(axis=0) for pose in several]
            drawn.append(
                Plot(
                    "measured-visits",
                    "measured-poses",
                    visits([about], [pose.name for pose in several], ["measured"]),
                    "Measured visits about their barycentres.",
                )
            )
        if measured.fit is not None:
            drawn.append(
                Plot("measured-accuracy", "measured-accuracy", measured_accuracy(measured), "AP_p of all poses, as it is and with best-fit frames.")
            )
    return drawn


def cube(found: Predicted) -> go.Figure:
    """Where does the test cube stand in the workspace? Cube, its plane, five poses, the path and the tool's reach, mm."""
    import plotly.graph_objects as go

    def line(points: Floats, name: str, colour: str, **style: Any) -> go.Scatter3d:  # noqa: ANN401 - plotly publishes no types
        x, y, z = (points * 1e3).T
        return go.Scatter3d(x=x, y=y, z=z, name=name, mode="lines", line={"color": colour, "width": 4, **style}, hoverinfo="skip")

    cloud = tool_points(found.arm, sample_poses(found.arm, _POINTS).q) * 1e3
    corners, five = found.cube.corners, found.cube.poses[:, :3, 3]
    marker = {"size": 1.3, "color": _CLOUD}
    traces = [
        go.Scatter3d(x=cloud[:, 0], y=cloud[:, 1], z=cloud[:, 2], mode="markers", name="within reach", marker=marker, hoverinfo="skip"),
        line(corners[list(_EDGES)], "test cube", INK),
        line(corners[list(_PLANE)], "plane C1-C2-C7-C8", BLUE, dash="dash"),
        line(five[list(found.path_ends)], "path", ORANGE),
        go.Scatter3d(
            x=five[:, 0] * 1e3,
            y=five[:, 1] * 1e3,
            z=five[:, 2] * 1e3,
            mode="markers+text",
            name="poses",
            text=list(NAMES),
            textposition="top center",
            textfont={"size": 13, "color": RED},
            marker={"size": 4.5, "color": RED},
            hovertemplate="%{text}: x %{x:.1f}, y %{y:.1f}, z %{z:.1f} mm<extra></extra>",
        ),
    ]
    figure = framed("Test cube in the workspace", *traces, height=480)
    axis = {"backgroundcolor": "white", "gridcolor": "#dddddd", "linecolor": "#888888", "showline": True, "zeroline": False, "nticks": 6}
    scene = {f"{name}axis": {**axis, "tickfont": {"size": 11}, "title": {"text": f"{name} [mm]", "font": {"size": 13}}} for name in "xyz"}
    figure.update_layout(
        scene={**scene, "aspectmode": "data", "camera": {"eye": {"x": 1.3, "y": -1.65, "z": 0.85}, "center": {"x": 0, "y": 0, "z": -0.18}}},
        legend={**LEGEND, "y": 0.98, "yanchor": "bottom"},
        margin={"l": 0, "r": 0, "t": 74, "b": 0},
    )
    return figure


def accuracy(found: Predicted) -> go.Figure:
    """How large is AP_p that 95 % of robots stay below, at each pose and load, as it is and with best-fit frames?"""
    import plotly.graph_objects as go

    top = max(float(over_robots(sheet.accuracy[k]).high.value) for sheet in found.loads for k in range(len(NAMES)))
    unit = length(top).unit
    bars = []
    for sheet, (raw, fitted) in zip(found.loads, ((BLUE, GREEN), ("#86bfe0", "#8fd3bd")), strict=False):
        for values, colour, name in ((sheet.accuracy, raw, "as it is"), (sheet.fitted, fitted, "best-fit frames")):
            high = [over_robots(values[k]).high.value * PER_UNIT[unit] for k in range(len(NAMES))]
            text = f"{name}, {100 * sheet.load:.0f} % load"
            bars.append(
                go.Bar(x=list(NAMES), y=high, name=text, marker={"color": colour}, hovertemplate=f"{text}: %{{y:.4~g}} {unit}<extra></extra>")
            )
    figure = framed("AP_p that 95 % of robots stay below", *bars, height=360)
    figure.update_yaxes(title_text=f"AP_p [{unit}]", rangemode="tozero")
    figure.update_xaxes(title_text="pose", showgrid=False)
    figure.update_layout(barmode="group", bargap=0.25, legend=LEGEND, margin_t=100)
    return figure


def visits(sets: list[Any], poses: list[str], names: list[str]) -> go.Figure:
    """How do visits fall about their barycentres? A panel per pose, from above and from the side, at one scale; sets[robot][pose] (visit, 3), m."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    most = max(float(np.abs(about).max()) for each in sets for about in each)
    unit = "µm" if most < 1e-3 else "mm"  # noqa: PLR2004 - where people change units
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


def path(found: Predicted) -> go.Figure:
    """How do AT and RT run along the line? Mean over robots and what 95 % of them stay below, at each point."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    a, b = (found.cube.poses[k, :3, 3] for k in found.path_ends)
    along = np.linspace(0, float(np.linalg.norm(b - a)) * 1e3, found.path_points)
    figure = styled(make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.09), "Along the path", height=420)
    for row, (word, profile) in enumerate(zip(("AT", "RT"), found.path_profile, strict=True), 1):
        unit = length(float(profile.max())).unit
        for values, name, colour, dash in ((profile[:, 0], "mean over robots", BLUE, "solid"), (profile[:, 1], "95 % of robots below", RED, "dot")):
            trace = go.Scatter(
                x=along,
                y=values * PER_UNIT[unit],
                name=name,
                legendgroup=name,
                showlegend=row == 1,
                mode="lines",
                line={"color": colour, "dash": dash, "width": 2},
                hovertemplate=f"%{{x:.0f}} mm: {word} %{{y:.4~g}} {unit}<extra></extra>",
            )
            figure.add_trace(trace, row=row, col=1)
        figure.update_yaxes(title_text=f"{word} [{unit}]", rangemode="tozero", row=row, col=1)
    ends = " to ".join(NAMES[k] for k in found.path_ends)
    figure.update_xaxes(title_text=f"way from {ends} [mm]", row=2, col=1)
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure


def drift(found: Drift) -> go.Figure:
    """How does AP_p at P1 change while the links warm up? Mean over robots and the band from 5 to 95 % of them."""
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
        name="5 to 95 % of robots",
        hoverinfo="skip",
    )
    mean = go.Scatter(
        x=hours,
        y=found.accuracy.mean(axis=1) * factor,
        name="mean over robots",
        line={"color": BLUE, "width": 2},
        hovertemplate=f"%{{x:.2f}} h: %{{y:.4~g}} {unit}<extra></extra>",
    )
    figure = framed("AP_p at P1 while warming up", band, mean, height=340)
    figure.update_xaxes(title_text="time since the start, cold [h]")
    figure.update_yaxes(title_text=f"AP_p [{unit}]", rangemode="tozero")
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure


def side_by_side(compared: list[Compared]) -> go.Figure:
    """Does the measured robot lie among those predicted? Lengths: from what 5 % to what 95 % of robots stay below, the measured value over it."""
    import plotly.graph_objects as go

    shown = [each for name in SHOWN for each in compared if each.name == name and not each.angle and each.name != "AD_p" and each.measured.value > 0]
    shown = [each for each in shown if each.predicted.high.value > _SMALLEST]
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
    # Bars as thick lines: on a logarithmic axis a bar would begin at its base.
    bars = go.Scatter(
        x=[x for pair in zip(low, high, [None] * len(low), strict=True) for x in pair],
        y=[y for place in places for y in (place, place, None)],
        mode="lines",
        line={"color": "#9ec9e2", "width": 13},
        name="5 to 95 % of robots predicted",
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
    figure.update_yaxes(**named([f"{each.name}, {label(each.pose)}" for each in shown]))
    figure.update_layout(legend=LEGEND, margin_t=96)
    return figure


def measured_accuracy(found: Measured) -> go.Figure:
    """How are measured AP_p spread over the poses, as they are and with best-fit frames?"""
    import plotly.graph_objects as go

    raw = np.array([pose.accuracy.value for pose in found.poses])
    fitted = np.array([pose.fitted for pose in found.poses])
    unit = length(float(raw.max())).unit
    factor = PER_UNIT[unit]
    traces: list[Any] = []
    many = len(raw) > 20  # noqa: PLR2004 - more than one can read the names of
    for values, name, colour in ((raw, "as it is", BLUE), (fitted, "best-fit frames", GREEN)):
        if many:
            bins = {"start": 0.0, "end": float(raw.max()) * factor, "size": float(raw.max()) * factor / 40}
            traces.append(go.Histogram(x=values * factor, name=name, marker={"color": colour}, opacity=0.65, xbins=bins))
        else:
            names = [label(pose.name) for pose in found.poses]
            traces.append(go.Bar(x=names, y=values * factor, name=name, marker={"color": colour}, hovertemplate=f"%{{y:.4~g}} {unit}<extra></extra>"))
    figure = framed("Measured AP_p", *traces, height=340)
    figure.update_xaxes(title_text=f"AP_p [{unit}]" if many else "pose", showgrid=many)
    figure.update_yaxes(title_text="poses [1]" if many else f"AP_p [{unit}]", rangemode="tozero")
    figure.update_layout(barmode="overlay" if many else "group", legend=LEGEND, margin_t=80)
    return figure
