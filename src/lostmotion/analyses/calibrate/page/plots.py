"""Plots of a calibration: distributions of the error, held-out errors over the workspace, and the
predicted accuracy over it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.calibrate.answer import corrected_radius
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.state import tool_points
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.reporting.chart import axes, figure, label_axes, legend, logarithmic, one
from lostmotion.reporting.map_chart import cells, class_legend, class_of
from lostmotion.reporting.palette import LIGHT, class_limits
from lostmotion.reporting.plot import Plot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.analyses.calibrate.answer import CalibrationAnswer
    from lostmotion.spatial import Floats

# Poses of the map between the joint limits, and cells along its longer side.
_SAMPLED: Final = 4096
_CELLS: Final = 28
# Shares of the cells outside the inner classes.
_TAILS: Final = (0.03, 0.97)


def calibrated_plots(calibration: CalibrationAnswer) -> list[Plot]:
    """Return the distributions of the error before and after, the held-out errors over the
    workspace, and the map of the predicted accuracy.
    """
    return [
        Plot(
            "errors",
            "accuracy",
            _distributions(calibration),
            "Share of the measured poses with an error below a length, before and after.",
        ),
        Plot(
            "places",
            "rows",
            _places(calibration),
            "Held-out error of each measured pose by its place in the base's axes.",
        ),
        Plot(
            "map",
            "predicted",
            _map(calibration),
            "Predicted 95 % radius with the estimates corrected, from above and from the side, in "
            "classes of the mean of each cell; measured poses, and those beyond their 95 % region.",
        ),
    ]


def _distributions(calibration: CalibrationAnswer) -> Figure:
    made, on = one("Error at poses that were not used", 80)
    climb = calibration.robot.climb
    for name, error, colour in (
        ("base and tool frame", calibration.before, "c3"),
        ("calibrated, excluded regions", climb.kept.blocked.error, "c2"),
        ("calibrated, random folds", climb.random.error, "c1"),
    ):
        share = 100 * np.arange(1, len(error) + 1) / len(error)
        on.plot(1e3 * np.sort(error), share, color=LIGHT[colour], label=name)
    logarithmic(on)
    on.set_ylim(0, 100)
    label_axes(on, "error, logarithmic [mm]", "poses below [%]")
    legend(made)
    return made


def _places(calibration: CalibrationAnswer) -> Figure:
    points = 1e3 * calibration.robot.frames[:, :3, 3]
    error = calibration.robot.climb.random.error
    made, on = one("Held-out error over the workspace, seen from above", 110)
    limits = np.quantile(error, [0.5, 0.9])
    for number, (colour, name) in enumerate(
        (("c1", "lower half"), ("c3", "up to the 90th percentile"), ("warn", "largest tenth"))
    ):
        inside = np.searchsorted(limits, error) == number
        on.plot(
            *points[inside, :2].T,
            linestyle="none",
            marker="o",
            markersize=3,
            color=LIGHT[colour],
            label=name,
        )
    on.set_aspect("equal", adjustable="datalim")
    label_axes(on, "x [mm]", "y [mm]")
    legend(made)
    return made


def _map(calibration: CalibrationAnswer) -> Figure:
    """Return the predicted radius between the joint limits, with the measured poses."""
    robot = calibration.robot
    q = sample_poses(robot.arm, _SAMPLED, "sobol", calibration.seed).q
    radius = corrected_radius(robot, q)
    unit = unit_of_length(float(np.median(radius)))
    views = [
        (_seen(tool_points(robot.arm, q), side), _seen(robot.frames[:, :3, 3], side), names)
        for side, names in ((False, ("x", "y")), (True, ("distance from the first axis", "z")))
    ]
    drawn = [_cell_means(points, radius * factor_of(unit)) for points, _, _ in views]
    known = np.concatenate([mean[np.isfinite(mean)] for *_, mean in drawn])
    limits = class_limits(*(float(each) for each in np.quantile(known, _TAILS)))
    made = figure(104)
    inside = robot.climb.kept.blocked.covered
    panels = axes(made, "Predicted 95 % radius once calibrated", columns=2)[0]
    for on, (_, measured, names), (x, y, mean) in zip(panels, views, drawn, strict=True):
        cells(on, 1e3 * x, 1e3 * y, class_of(mean, limits))
        for of, marker, colour, name in (
            (inside, ".", "ink", "measured pose"),
            (~inside, "x", "warn", f"beyond its 95 % region: {100 * (~inside).mean():.0f} %"),
        ):
            at = 1e3 * measured[of].T
            on.plot(*at, marker, markersize=3, color=LIGHT[colour], label=name)
        on.set_aspect("equal", adjustable="box")
        label_axes(on, *(f"{name} [mm]" for name in names))
    marks = panels[0].get_legend_handles_labels()[0]
    class_legend(made, limits, f"mean 95 % radius of a cell [{unit}]", marks)
    return made


def _seen(points: Floats, side: bool) -> Floats:  # noqa: FBT001 - one of two views
    """Return places (pose, 2), m, from above, or from the side by the distance from the z axis."""
    if not side:
        return points[:, :2]
    return np.column_stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]])


def _cell_means(points: Floats, values: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the edges of square cells along both axes, and the mean of the values (pose,) in each
    (across, up); NaN for one without points (pose, 2).
    """
    low, extent = points.min(axis=0), np.ptp(points, axis=0)
    edge = float(extent.max()) / _CELLS or 1.0
    counts = np.maximum(np.ceil(extent / edge), 1).astype(int)
    x, y = (start + edge * np.arange(n + 1) for start, n in zip(low, counts, strict=True))
    across, up = (np.minimum((points - low) / edge, counts - 1).astype(int)).T
    number, size = across * counts[1] + up, int(counts.prod())
    total = np.bincount(number, values, size)
    count = np.bincount(number, minlength=size)
    mean = np.where(count, total / np.maximum(count, 1), np.nan)
    return x, y, mean.reshape(counts)
