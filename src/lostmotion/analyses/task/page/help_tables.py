"""Tables of what would help a task, and of how much more it would bear."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.sheet import Cell, Row, several, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.task.outcome import TaskOutcome
    from lostmotion.propagation.task_remedies import Margin, Remedied, Remedies
    from lostmotion.reporting.sheet import Section


def help_sections(outcome: TaskOutcome) -> tuple[Section, ...]:
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
