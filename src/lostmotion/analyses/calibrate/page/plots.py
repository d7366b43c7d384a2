"""Plots of a calibration: distributions of the error, and held-out errors over the workspace."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.reporting.chart import label_axes, legend, one
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.analyses.calibrate.answer import CalibrationAnswer


def calibrated_plots(found: CalibrationAnswer) -> list[Plot]:
    """Return the distributions of the error before and after, and the held-out errors over the
    workspace.
    """
    return [
        Plot(
            "errors",
            "accuracy",
            _distributions(found),
            "Share of the measured poses with an error below a length, before and after.",
        ),
        Plot(
            "places",
            "rows",
            _places(found),
            "Held-out error of each measured pose by its place in the base's axes.",
        ),
    ]


def _distributions(found: CalibrationAnswer) -> Figure:
    made, on = one("Error at poses that were not used", 80)
    climb = found.robot.climb
    for name, error, colour in (
        ("base and tool frame", found.before, "c3"),
        ("calibrated, excluded regions", climb.kept.blocked.error, "c2"),
        ("calibrated, random folds", climb.random.error, "c1"),
    ):
        share = 100 * np.arange(1, len(error) + 1) / len(error)
        on.plot(1e3 * np.sort(error), share, color=LIGHT[colour], label=name)
    on.set_xscale("log")
    on.set_ylim(0, 100)
    label_axes(on, "error [mm]", "poses below [%]")
    legend(made)
    return made


def _places(found: CalibrationAnswer) -> Figure:
    points = 1e3 * found.robot.frames[:, :3, 3]
    error = found.robot.climb.random.error
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
