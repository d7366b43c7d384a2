"""The figures of a study with a stopping rule: the tolerance asked for, and the precision
reached.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from lostmotion.reporting.sheet import Cell, Row, Section, several

if TYPE_CHECKING:
    from lostmotion.propagation.montecarlo.stopping import Stopping, Watched


def stopping_section(
    found: Stopping, where: str = "", key: str = "stopping", *, scarce: bool = False
) -> Section:
    """Return the precision of each figure, stage by stage; `where` and `scarce` as in `outcome`."""
    columns = tuple(
        f"{several(stage.poses, 'pose')} x {several(stage.robots, 'robot')}"
        for stage in found.stages
    )
    last = found.stages[-1]
    rows = []
    for name, figure in last.figures.items():
        figures = tuple(
            _half(
                stage.figures[name],
                f"{several(stage.poses, 'pose')} x {several(stage.robots, 'robot')}",
            )
            for stage in found.stages
        )
        asked = _asked(found, figure, missed=name in found.missed)
        rows.append(Row(figure.name, figures, asked, name))
    note = (
        "half of each 95 % interval, as a share of the figure, at each stage; asked for: "
        f"{found.tolerance}. The first stage shows how many robots "
        "and poses are needed; every printed interval is that of the last stage alone (JCGM "
        "101:2008, 7.9, in two stages or more)"
    )
    return Section(key, outcome(found, where, scarce=scarce), columns, tuple(rows), note)


def outcome(found: Stopping, where: str = "", *, scarce: bool = False) -> str:
    """Return a sentence on whether the figures have the precision asked for.

    `where` names the poses, where there are several kinds; `scarce` means that there are no more of
    them.
    """
    last = found.stages[-1]
    where = where and f" {where}"
    if found.reached:
        watched = ", ".join(
            dict.fromkeys(
                each.name.rpartition(", ")[0] or each.name for each in last.figures.values()
            )
        )
        return (
            f"Reached ±{found.tolerance}{where and f'{where} ({watched})'} after "
            f"{several(last.robots, 'robot')} and {several(last.poses, 'pose')}"
        )
    figure = last.figures[found.missed[0]]
    half = (
        f"half-width {100 * figure.relative:.2g} %"
        if math.isfinite(figure.relative)
        else "too few robots"
    )
    why = {
        "poses": "mostly due to the choice of poses"
        + (
            f", and no more than {last.poses} were found"
            if scarce
            else f": ask for more than {last.poses}"
        ),
        "robots": f"after the most robots allowed, {last.robots}",
        "stages": (
            f"after {len(found.stages)} stages, {several(last.robots, 'robot')} and "
            f"{several(last.poses, 'pose')}"
        ),
    }[found.limited_by]
    return f"Did not reach ±{found.tolerance}{where}: {half} ({figure.name}), {why}"


def _half(figure: Watched, counted: str) -> Cell:
    return Cell(
        figure.relative if math.isfinite(figure.relative) else math.nan, "%", samples=counted
    )


def _asked(found: Stopping, figure: Watched, *, missed: bool) -> str:
    allowed = (
        f", ±{100 * found.tolerance.half(figure.value) / abs(figure.value):.2g} % here"
        if found.tolerance.digits and figure.value
        else ""
    )
    return ("not precise enough" if missed else "precise enough") + allowed
