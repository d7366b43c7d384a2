"""Plots of a task: its path in the colours of its tolerances, the drift of the tool, and the
contributors.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.placed_terms import short_name
from lostmotion.mechanism.warm_up import HOUR
from lostmotion.reporting.chart import label_axes, legend, named_rows, one, ringed, swatch
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.analyses.task.outcome import TaskResult
    from lostmotion.spatial import Floats

_CURVE: Final = 97
_PARTS: Final = 12
_LEAST: Final = 0.005
# Colours of the path by the share of the tolerance that 95 % stay within.
_CLASSES: Final = (
    (0.5, "c1", "below half of the tolerance"),
    (1.0, "c3", "half to all of it"),
    (math.inf, "warn", "beyond it"),
)


def plots(outcome: TaskResult) -> list[Plot]:
    """Return the path in the colours of its tolerances, and the contributors."""
    out = [
        Plot(
            "path",
            "places",
            _path(outcome),
            "Places of the task in the plane in which they extend most, coloured by the share of "
            "the tolerance that 95 % of robots and runs use.",
        )
    ]
    if outcome.drift is not None:
        out.append(
            Plot(
                "drift",
                "drift",
                _drift(outcome),
                "Displacement of the tool over the time of the task at the place with the largest "
                "one, and by the own heat of each joint.",
            )
        )
    if any(outcome.parts.values()):
        out.append(
            Plot(
                "contributors",
                "parts",
                _contributors(outcome),
                "Bars of each part's share of the mean square in the decisive tolerance.",
            )
        )
    return out


def _path(outcome: TaskResult) -> Figure:
    points = 1e3 * outcome.program.places.points
    extent = np.ptp(points, axis=0)
    across, up = sorted(np.argsort(-extent, kind="stable")[:2])
    tall = float(np.clip(40 + 90 * (extent[up] + 1) / (extent[across] + 1), 60, 130))
    made, on = one(f"Task '{outcome.task.name}'", tall)
    for each in outcome.program.features:
        if each.kind in {"line", "circle", "path"}:
            on.plot(*points[each.places][:, [across, up]].T, color=LIGHT["line"], linewidth=0.8)
    worst = points[outcome.outcomes[outcome.decisive].worst]
    ringed(on, worst[across], worst[up], "worst place")
    _dots(on, points[:, [across, up]], outcome.place_used)
    on.set_aspect("equal", adjustable="datalim")
    label_axes(on, f"{'xyz'[across]} [mm]", f"{'xyz'[up]} [mm]")
    legend(made, extra=[swatch(name, LIGHT[colour]) for _, colour, name in _CLASSES])
    return made


def _dots(on: Axes, points: Floats, used: Floats) -> None:
    low = 0.0
    for high, colour, _ in _CLASSES:
        inside = (used > low) & (used <= high) if low else used <= high
        on.plot(*points[inside].T, linestyle="none", marker="o", markersize=4, color=LIGHT[colour])
        low = high


def _drift(outcome: TaskResult) -> Figure:
    """Return the displacement of the tool over the time of the task at the place with the largest
    one.
    """
    drift, heat = outcome.drift, outcome.task.heat
    if drift is None or heat is None:
        raise ValueError("a task without own heat")
    time = np.linspace(0.0, heat.over, _CURVE)
    each = drift.growth[:, :, None] * heat.shares(time)[:, None]
    made, on = one(f"Drift of the tool at {outcome.where(drift.place)}", 70)
    scale, unit = (HOUR, "h") if heat.over >= 2 * HOUR else (60.0, "min")
    on.plot(
        time / scale,
        1e3 * np.linalg.norm(each.sum(axis=0), axis=0),
        color=LIGHT["ink"],
        label="all",
    )
    for k, (name, moved) in enumerate(zip(drift.joints, each, strict=True)):
        colour = LIGHT[f"c{k % 4 + 1}"]
        on.plot(time / scale, 1e3 * np.linalg.norm(moved, axis=0), color=colour, label=name)
    label_axes(on, f"time [{unit}]", "displacement [mm]")
    legend(made)
    return made


def _contributors(outcome: TaskResult) -> Figure:
    shown = [(name, value) for name, value in outcome.parts.items() if value >= _LEAST][:_PARTS]
    made, on = one("Share of the mean square in the decisive tolerance", 30 + 8 * len(shown))
    on.barh(range(len(shown)), [100 * value for _, value in shown], color=LIGHT["robot"])
    named_rows(on, [short_name(name) for name, _ in shown])
    label_axes(on, "share [%]")
    return made
