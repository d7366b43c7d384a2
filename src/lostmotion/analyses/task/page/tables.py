"""Further tables of a task: the drift of the tool by the own heat of joints, what would help, and
how much more the task would bear.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.placed_terms import short_name
from lostmotion.mechanism.warm_up import HOUR
from lostmotion.reporting.sheet import Cell, Row, length, several, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.task.outcome import TaskResult
    from lostmotion.propagation.task_remedies import Margin, Remedied, Remedies
    from lostmotion.reporting.sheet import Section

_INSTANTS: Final = 8


def drift_section(outcome: TaskResult) -> tuple[Section, ...]:
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


def _time(seconds: float) -> str:
    hours = seconds >= 2 * HOUR
    return f"{seconds / HOUR:.3g} h" if hours else f"{seconds / 60:.3g} min"


def help_sections(outcome: TaskResult) -> tuple[Section, ...]:
    """Return what remedies leave, what is left without each part, and how much the task would
    bear.
    """
    helps = outcome.helps
    counted = f"{several(helps.robots, 'robot')} x {several(helps.runs, 'run')}"
    name = outcome.outcomes[outcome.decisive].tolerance.name

    def of(key: str, title: str, lines: Sequence[Remedied], note: str) -> Section:
        rows = [
            Row(
                short_name(each.name),
                (
                    Cell(each.success.value, "%", each.success.low, each.success.high, counted),
                    Cell(each.used, "%", samples=counted),
                ),
            )
            for each in (helps.before, *lines)
        ]
        return table(key, title, ("probability", "used, 95 %"), rows, note)

    same = (
        f"the same robots and runs each time; used: of the decisive tolerance '{name}' alone, "
        "while another may decide then"
    )
    margins = [
        Row(each.name, (_factor(each.factor, counted),), _bears(each)) for each in helps.margins
    ]
    return (
        of("remedies", "What would help", helps.stages, f"ideal remedies; {same}"),
        of("without", "Success without the error of a part", helps.parts, same + _cancels(helps)),
        table(
            "margins",
            "How much the task would bear",
            {"factor": "1"},
            margins,
            f"largest factor with which {Cell(outcome.task.required, '%', stated=True)} are met, "
            "everything else as it is; by bisection with the same robots and runs",
        ),
    )


def _cancels(helps: Remedies) -> str:
    """Return the remark on parts without which fewer robots and runs succeed; empty without any."""
    fewer = [each.name for each in helps.parts if each.success.value < helps.before.success.value]
    if not fewer:
        return ""
    names = ", ".join(short_name(name) for name in fewer)
    return f". Fewer succeed without {names}: mean errors of other parts are opposite and cancel it"


def _factor(factor: float, samples: str) -> Cell:
    words = "none" if math.isnan(factor) else "any" if math.isinf(factor) else ""
    return Cell(factor, "1", samples=samples, words=words)


def _bears(margin: Margin) -> str:
    if math.isnan(margin.factor):
        return f"no reduction of {margin.name} alone meets the requirement"
    if math.isinf(margin.factor):
        return f"64 times the {margin.name} still meets it"
    return ""
