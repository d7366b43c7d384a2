"""Plots of an ISO 9283 sheet: test cube, accuracy by pose, visits about barycentres, path, drift,
predicted and measured.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.iso9283.page.labels import accuracy_key, load_label, measured_label
from lostmotion.analyses.iso9283.page.measured_figures import (
    measured_accuracy,
    measured_path,
    side_by_side,
)
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.state import tool_points
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.propagation.iso9283.cube import NAMES
from lostmotion.reporting.chart import (
    axes,
    dots,
    figure,
    grid,
    label,
    label_axes,
    legend,
    one,
    swatch,
    text,
)
from lostmotion.reporting.chart_settings import SMALL
from lostmotion.reporting.map_chart import cells
from lostmotion.reporting.palette import LIGHT, round_below
from lostmotion.reporting.plot import Plot
from lostmotion.standards.comparison import over_robots

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.mechanism.warm_up import Drift
    from lostmotion.propagation.iso9283.robots import PredictedRobots
    from lostmotion.standards.comparison import ComparedFigure
    from lostmotion.standards.measured_robot import MeasuredRobot

_POINTS: Final = 16384
# Cells along each side of the reachable area.
_CELLS: Final = 40
# Opacity of the first load and of the second.
_PALE: Final = (1.0, 0.5)
_EDGES: Final = (0, 1, 2, 3, 0, 4, 5, 1, 5, 6, 2, 6, 7, 3, 7, 4)
_PLANE: Final = (0, 1, 6, 7, 0)
_ROBOT_COLOURS: Final = (LIGHT["robot"], LIGHT["design"], LIGHT["visit"])
_PANELS: Final = 5
_SMALLEST: Final = 1e-10


def iso_plots(
    predicted: PredictedRobots | None,
    drifted: Drift | None,
    measured: MeasuredRobot | None,
    compared: list[ComparedFigure],
) -> list[Plot]:
    """Return the plots of a sheet, in reading order."""
    drawn: list[Plot] = []
    if predicted is not None:
        drawn += [
            Plot(
                "cube",
                "cube",
                cube(predicted),
                (
                    "Test cube with its five poses and the path, in the cloud of reachable tool "
                    "points."
                ),
            ),
            Plot(
                "accuracy",
                "ap100",
                accuracy(predicted),
                (
                    "Bars of the 95th percentile of pose accuracy over robots, with commanded and "
                    "with best-fit frames."
                ),
            ),
        ]
        if predicted.loads[0].repeatability.max() > _SMALLEST:
            shown = [
                errors - errors.mean(axis=1, keepdims=True) for errors in predicted.loads[0].shown
            ]
            names = [f"robot {k + 1}" for k in range(len(shown))]
            drawn.append(
                Plot(
                    "visits",
                    "rp100",
                    visits(shown, list(NAMES), names),
                    "Visits of three robots about their own barycentres, at each pose.",
                )
            )
        drawn.append(
            Plot(
                "path",
                "path",
                path(predicted),
                (
                    "Path accuracy and repeatability along the line, mean and 95th percentile "
                    "over robots."
                ),
            )
        )
        if drifted is not None:
            drawn.append(
                Plot(
                    "drift",
                    "drift",
                    drift(drifted),
                    "Pose accuracy at P1 during warm-up of the links.",
                )
            )
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
    """Return the plots of a measured robot, with all its loads in one plot where it stays
    readable.
    """
    drawn = []
    several = list(
        dict.fromkeys(
            pose.name for load in measured.loads for pose in load.poses if pose.visits > 1
        )
    )[:_PANELS]
    if several:
        about = [
            [
                pose.errors - pose.errors.mean(axis=0)
                for name in several
                for pose in load.poses
                if pose.name == name
            ]
            for load in measured.loads
            if set(several) <= {pose.name for pose in load.poses}
        ]
        names = [
            measured_label("measured", load, measured.loads)
            for load in measured.loads
            if set(several) <= {pose.name for pose in load.poses}
        ]
        if about:
            drawn.append(
                Plot(
                    "measured-visits",
                    "measured-repeatability",
                    visits(about, several, names),
                    "Measured visits about their barycentres.",
                )
            )
    for load in measured.loads:
        if load.fit is not None:
            key, title = (
                accuracy_key(load, measured.loads),
                measured_label("Measured AP_p", load, measured.loads),
            )
            drawn.append(
                Plot(
                    key,
                    key,
                    measured_accuracy(load, title),
                    "AP_p of all poses, with commanded and with best-fit frames.",
                )
            )
    if any(load.paths for load in measured.loads):
        drawn.append(
            Plot(
                "measured-path",
                "measured-path",
                measured_path(measured),
                "Measured path accuracy and repeatability along the line, plane by plane.",
            )
        )
    return drawn


def cube(predicted: PredictedRobots) -> Figure:
    """Return the test cube in the workspace from above and from the side: cube, its plane, five
    poses, the path and the reachable area, mm.
    """
    cloud = tool_points(predicted.arm, sample_poses(predicted.arm, _POINTS).q) * 1e3
    corners, five = predicted.cube.corners * 1e3, predicted.cube.poses[:, :3, 3] * 1e3
    made = figure(88)
    for on, (across, up) in zip(
        axes(made, "Test cube in the workspace", columns=2)[0], ((0, 1), (0, 2)), strict=True
    ):
        pair = [across, up]
        counts, x, y = np.histogram2d(cloud[:, across], cloud[:, up], _CELLS)
        cells(on, x, y, np.where(counts > 0, 0, -1), (LIGHT["line"],))
        for points, name, colour, line in (
            (corners[list(_EDGES)], "test cube", LIGHT["ink"], "-"),
            (corners[list(_PLANE)], "plane C1-C2-C7-C8", LIGHT["robot"], "--"),
            (five[list(predicted.path_ends)], "path", LIGHT["design"], "-"),
        ):
            on.plot(
                points[:, across],
                points[:, up],
                color=colour,
                linestyle=line,
                linewidth=1.2,
                label=name,
            )
        on.plot(
            five[:, across],
            five[:, up],
            linestyle="none",
            marker="o",
            markersize=3.5,
            color=LIGHT["warn"],
            label="poses",
        )
        seen: dict[tuple[float, ...], list[str]] = {}
        for name, point in zip(NAMES, five, strict=True):
            seen.setdefault(tuple(np.round(point[pair], 6)), []).append(name)
        middle = five[0, pair]
        for (right, high), names in seen.items():
            side = (5 if right >= middle[0] else -5, 4 if high >= middle[1] else -4)
            how: dict[str, Any] = {
                "ha": "left" if side[0] > 0 else "right",
                "va": "bottom" if side[1] > 0 else "top",
            }
            text(on, right, high, ", ".join(names), xytext=side, **how)
        on.set_aspect("equal")
        on.locator_params(nbins=5)
        label_axes(on, f"{'xyz'[across]} [mm]", f"{'xyz'[up]} [mm]")
    legend(made, extra=[swatch("reachable", LIGHT["line"])])
    return made


def accuracy(predicted: PredictedRobots) -> Figure:
    """Return bars of the 95th percentile of AP_p at each pose and load, with commanded and with
    best-fit frames.
    """
    top = max(
        float(over_robots(sheet.accuracy[k]).high.value)
        for sheet in predicted.loads
        for k in range(len(NAMES))
    )
    unit = unit_of_length(top)
    rows = []
    for sheet, pale in zip(predicted.loads, _PALE, strict=False):
        for values, colour, name in (
            (sheet.accuracy, LIGHT["robot"], "commanded frames"),
            (sheet.fitted, LIGHT["visit"], "best-fit frames"),
        ):
            high = np.array(
                [over_robots(values[k]).high.value * factor_of(unit) for k in range(len(NAMES))]
            )
            rows.append((f"{name}, {100 * sheet.load:.0f} % load", colour, pale, high))
    made, on = one("95th percentile of AP_p over robots", 80)
    thick = 0.76 / len(rows)
    for k, (name, colour, pale, high) in enumerate(rows):
        at = np.arange(len(NAMES)) + (k - (len(rows) - 1) / 2) * thick
        on.bar(at, high, width=0.92 * thick, color=colour, alpha=pale, linewidth=0, label=name)
    on.set_xticks(range(len(NAMES)), NAMES, color=LIGHT["ink"])
    on.tick_params(axis="x", length=0)
    label_axes(on, "pose", f"AP_p [{unit}]")
    legend(made)
    return made


def visits(sets: list[Any], poses: list[str], names: list[str]) -> Figure:
    """Return the visits about their barycentres, a panel per pose, in top and side view at one
    scale; sets[robot][pose] (visit, 3), m.
    """
    most = max(float(np.abs(about).max()) for each in sets for about in each)
    unit = "µm" if most < 1e-3 else "mm"  # noqa: PLR2004 - usual change of unit
    limit = 1.15 * most * factor_of(unit) or 1.0
    made = figure(80)
    panels = axes(
        made, "Visits about their barycentres", rows=2, columns=len(poses), sharex=True, sharey=True
    )
    tick = round_below(0.6 * limit)  # well inside, or labels of neighbours run together
    for column, pose in enumerate(poses):
        panels[0, column].set_title(label(pose), loc="center", fontsize=SMALL)
        for on, axis in zip(panels[:, column], (1, 2), strict=True):
            for each, name, colour in zip(sets, names, _ROBOT_COLOURS, strict=False):
                points = np.asarray(each[column]) * factor_of(unit)
                dots(on, points[:, 0], points[:, axis], colour, name)
            on.set_xlim(-limit, limit)
            on.set_ylim(-limit, limit)
            on.set_xticks([-tick, tick])
            on.set_yticks([-tick, 0, tick])
            on.set_aspect("equal")
        label_axes(panels[1, column], f"x [{unit}]")
    label_axes(panels[0, 0], y=f"y [{unit}]")
    label_axes(panels[1, 0], y=f"z [{unit}]")
    legend(made)
    return made


def path(predicted: PredictedRobots) -> Figure:
    """Return AT and RT along the line: mean and 95th percentile over robots at each point."""
    a, b = (predicted.cube.poses[k, :3, 3] for k in predicted.path_ends)
    along = np.linspace(0, float(np.linalg.norm(b - a)) * 1e3, predicted.path_points)
    made = figure(100)
    panels = axes(made, "Along the path", rows=2, sharex=True)[:, 0]
    for row, (on, word) in enumerate(zip(panels, ("AT", "RT"), strict=True)):
        grid(on)
        unit = unit_of_length(
            max(float(sheet.path_profile[row].max()) for sheet in predicted.loads)
        )
        for sheet, pale in zip(predicted.loads, _PALE, strict=False):
            for k, (name, colour, line) in enumerate(
                (("mean", LIGHT["robot"], "-"), ("95th percentile", LIGHT["warn"], "--"))
            ):
                values = sheet.path_profile[row][:, k] * factor_of(unit)
                on.plot(
                    along,
                    values,
                    color=colour,
                    linestyle=line,
                    alpha=pale,
                    linewidth=1.5,
                    label=load_label(name, sheet.load, predicted.loads),
                )
        on.set_ylim(bottom=0)
        label_axes(on, y=f"{word} [{unit}]")
    label_axes(
        panels[1], f"distance along {' to '.join(NAMES[k] for k in predicted.path_ends)} [mm]"
    )
    legend(made)
    return made


def drift(drifted: Drift) -> Figure:
    """Return AP_p at P1 during warm-up: mean over robots and range from the 5th to the 95th
    percentile.
    """
    hours = drifted.time / 3600
    low, high = np.quantile(drifted.accuracy, [0.05, 0.95], axis=1)
    unit = unit_of_length(float(high.max()))
    factor = factor_of(unit)
    made, on = one("AP_p at P1 during warm-up", 76)
    grid(on)
    on.fill_between(
        hours,
        low * factor,
        high * factor,
        color=LIGHT["robot"],
        alpha=0.2,
        linewidth=0,
        label="5th to 95th percentile",
    )
    on.plot(
        hours,
        drifted.accuracy.mean(axis=1) * factor,
        color=LIGHT["robot"],
        linewidth=1.6,
        label="mean over robots",
    )
    on.set_ylim(bottom=0)
    on.set_xlim(hours[0], hours[-1])
    label_axes(on, "time since cold start [h]", f"AP_p [{unit}]")
    legend(made)
    return made
