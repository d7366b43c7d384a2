"""What remains after a calibration: the accuracy that is predicted, what is not estimated, what to
measure next, and plots of the error before and after, over the workspace.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.calibrate.answer import FEWEST_COUNTED, corrected_radius
from lostmotion.calibration.plan import next_poses
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.state import tool_points
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.reporting.chart import axes, figure, label_axes, legend, logarithmic, one
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.map_chart import cells, class_legend, class_of
from lostmotion.reporting.palette import LIGHT, class_limits
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import in_words, length, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.analyses.calibrate.answer import CalibrationAnswer
    from lostmotion.reporting.sheet import Section
    from lostmotion.spatial import Floats

_PREDICTED: Final = 256
_QUANTILE: Final = 0.95
# What no measurement of this kind can resolve: what it is, why, and what to measure instead.
_STIFFNESS: Final = (
    "joint stiffness",
    "one payload: deflection by the arm's own weight resembles tilts and first harmonics",
    "the same poses with two payloads, in a column payload [kg]",
)
_SIDE: Final = (
    "play",
    "the direction of approach is not recorded: play counts as scatter between visits",
    "both directions, with a column NAME approach",
)
_DRIFT: Final = ("drift", "no time is recorded", "the time of each row, in a column time [s]")
_ORIENTATION: Final = (
    "orientation of the tool",
    "a point has none",
    "three points of the tool, or its full pose",
)
# Poses of the map between the joint limits, and cells along its longer side.
_SAMPLED: Final = 4096
_CELLS: Final = 28
# Shares of the cells outside the inner classes.
_TAILS: Final = (0.03, 0.97)


def predicted_accuracy(answer: CalibrationAnswer) -> Section:
    """Return the accuracy that is predicted where the estimates are corrected."""
    robot = answer.robot
    low, high = answer.visits.q.min(axis=0), answer.visits.q.max(axis=0)
    share = np.random.default_rng(answer.seed).random((_PREDICTED, len(low)))
    limits = robot.arm.limits
    rows = []
    for name, ends in (("measured joint ranges", (low, high)), ("joint limits", limits.T)):
        radius = corrected_radius(robot, ends[0] + share * (ends[1] - ends[0]))
        worst = np.quantile(radius, _QUANTILE)
        rows.append((name, length(float(radius.mean())), length(float(worst))))
    covered = 100 * robot.climb.kept.blocked.coverage
    note = "the tool is within it of the corrected command in 95 % of visits, each in the base "
    note += "frame as measured; noise of the instrument is not in it. Of the measurements in "
    note += f"excluded regions {covered:.0f} % are within their 95 % regions"
    if len(answer.visits) < FEWEST_COUNTED:
        note += f", a share that fewer than {FEWEST_COUNTED} poses do not compare with 95 %"
    title = "Predicted accuracy with the estimates corrected"
    return table("predicted", title, ("mean 95 % radius", "95th percentile"), rows, note)


def refusals(answer: CalibrationAnswer) -> list[Section]:
    """Return what no such measurement can estimate, why, and what to measure instead."""
    payload = answer.visits.payload
    kinds = [_STIFFNESS] if payload is None or not np.ptp(payload) else []
    kinds += [_DRIFT] if answer.visits.time is None else []
    kinds += [] if np.any(answer.visits.approach) else [_SIDE]
    kinds += [_ORIENTATION] if answer.visits.rotation is None else []
    rows = [(what, in_words(instead), why) for what, why, instead in kinds]
    return [table("refused", "Not estimated", ("measure instead",), rows)] if rows else []


def next_measurements(answer: CalibrationAnswer) -> Section:
    """Return the poses that would improve the calibration most."""
    q, radius = next_poses(answer.robot, answer.visits.q, answer.seed)
    rows = [
        (joint_values(answer.robot.arm, each), length(float(radius[k])))
        for k, each in enumerate(q, 1)
    ]
    return table(
        "next",
        "Poses to measure next",
        ("95 % radius with so many",),
        rows,
        f"now {length(float(radius[0]))}, mean over the measured joint ranges, without the scatter "
        "between visits",
    )


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
