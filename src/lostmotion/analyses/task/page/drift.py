"""Drift of the tool over a task by the own heat of joints: its section and its plot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.warm_up import HOUR
from lostmotion.reporting.chart import label_axes, legend, one
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.sheet import Cell, Row, length, several, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.analyses.task.outcome import TaskOutcome
    from lostmotion.reporting.sheet import Section

_INSTANTS: Final = 8
_CURVE: Final = 97


def drift_section(outcome: TaskOutcome) -> tuple[Section, ...]:
    """Return the section on the drift; nothing without own heat."""
    drift, heat = outcome.drift, outcome.task.heat
    if drift is None or heat is None:
        return ()
    at = heat.over * np.arange(1, _INSTANTS + 1) / _INSTANTS
    curve = np.linalg.norm(drift.growth.T @ heat.shares(at), axis=0)
    rows = [
        Row(
            "largest displacement",
            (length(drift.largest, samples="exact"),),
            f"at {outcome.where(drift.place)} after {_time(drift.time)}",
            key="largest",
        ),
        *(
            Row(f"of it by {name}", (Cell(float(share), "%", samples="exact"),))
            for name, share in zip(drift.joints, drift.shares, strict=True)
        ),
        *(
            Row(f"there after {_time(time)}", (length(float(size), samples="exact"),))
            for time, size in zip(at, curve, strict=True)
        ),
    ]
    if heat.over > heat.duration and outcome.runs > 1:
        counted = several(outcome.robots, "robot")
        rows += [
            Row(name, (Cell(of.value, "%", of.low, of.high, counted),))
            for name, of in (
                ("all tolerances hold, first run", drift.first),
                ("all tolerances hold, last run", drift.last),
            )
        ]
    return (
        table(
            "drift",
            "Drift of the tool by the own heat of joints",
            ("value",),
            rows,
            "displacement of the tool point from where it is while all links are at the arm's "
            f"temperature; the arm is {'warm' if heat.warm else 'cold'} at the start. Counted: "
            f"expansion of the links of {', '.join(drift.joints)}. Not counted: expansion of "
            "housings and base, clearances that follow the temperature, links that bend",
        ),
    )


def drift_plot(outcome: TaskOutcome) -> Figure:
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


def _time(seconds: float) -> str:
    hours = seconds >= 2 * HOUR
    return f"{seconds / HOUR:.3g} h" if hours else f"{seconds / 60:.3g} min"
