"""The figures of an accuracy map: the error over the cells, how much of the workspace is good enough, where work should stand, who is to blame."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.workspace_map.cell_statistics import BYS, MEAN, QUANTILE
from lostmotion.analyses.workspace_map.tables.map_labels import (
    SAME,
    by_said,
    counted,
    edge_said,
    level_said,
    over_cells,
    per_cell_said,
    place_said,
    share_within,
    unit_said,
    whole,
)
from lostmotion.analyses.workspace_map.tables.placement import boxes_said, places_facts, places_section
from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.reporting.provenance import at_least, bounded_cards, caveats, provenance_facts, provenance_sections
from lostmotion.reporting.sheet import Card, Figure, Row, Section, Sheet, length, several
from lostmotion.reporting.warnings import arm_warnings

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.analyses.workspace_map.map import Zones
    from lostmotion.error_model.provenance import States
    from lostmotion.spatial import Floats

# Shares of the workspace for which the error that they stay within is told.
_SHARES: Final = (0.1, 0.5, 0.9)
_WORDS: Final = (
    ("cell", "a cube of the grid. Its error is that at its middle; where only a part of the cell is in reach, at the points reached."),
    (
        "best, mean, worst",
        "over the arm configurations looked at in a cell. Best and worst are bounds, from one side, and move on with more poses; the mean does not.",
    ),
    ("position error", "distance between the point the tool was sent to and the point it reaches, over all robots and visits together."),
    (
        "configuration",
        "joint values that bring the tool point there; the tool may stand in any direction. No obstacle, floor or self-collision counts.",
    ),
    ("afresh", "at the points of another lattice over the box, its corners included, with other poses than those of the map."),
    ("share", "of the mean-square error over the poses that the zone's figures rest on, exact sums over terms. Shares add to 100 %."),
)


def zones_sheet(found: Zones, at: Floats | None = None) -> Sheet:
    """What is there to say about an accuracy map, with slices through the point `at` (3,), m?"""
    known = with_limits(states(found.arm), found.arm, found.reached.q)
    return Sheet(
        name=found.arm.name,
        subject="accuracy map",
        verdict=_verdict(found, known),
        cards=bounded_cards(_cards(found), known, (level_said(found), "most accurate", "best place")),
        sections=tuple(
            section
            for section in (_map(found), _within(found), places_section(found), _budget(found), _reach(found), *provenance_sections(known))
            if section is not None
        ),
        counts=f"{several(int(np.isfinite(found.shown).sum()), 'cell')} of {edge_said(found)}, {per_cell_said(found)}",
        warnings=arm_warnings(found.arm),
        notes=(*found.arm.remarks, *_remarks(found), *_off_the_map(found, at)),
        words=_WORDS,
        source=f"{found.reached.sampled} poses sampled (sobol), {len(found.reached.q)} looked at, seed {found.seed}. "
        "The same file, version, seed and options give the same bytes.",
        arrays="the map, cell by cell",
        seed=found.seed,
        facts={**_facts(found), **provenance_facts(known)},
    )


def _drawn(found: Zones) -> str:
    afresh = found.afresh
    return "cells reached at their middle" if afresh is None else f"{len(afresh.points)} of {afresh.drawn} points drawn around are in reach"


def _verdict(found: Zones, known: States) -> str:
    least, middle, most = (_over_shown(found, what) for what in (np.min, np.median, np.max))
    text = f"By the {by_said(found)}, {level_said(found)} of positions lie within "
    if str(least) == str(most):
        text += f"{at_least(least, known)} in every cell."
    else:
        text += f"{at_least(middle, known)} in the median cell, {least} in the most accurate one"
        text += f" and {most} in the least accurate one."
    if found.within is not None:
        text += f" {_share_said(found, found.within.target)}"
    if found.boxes is not None:
        text += " " + boxes_said(found.boxes, found)
    return " ".join([text, *caveats(known)])


def _over_shown(found: Zones, what: Callable[[Floats], float]) -> Figure:
    return over_cells(found, QUANTILE, BYS.index(found.by), what)


def _share_said(found: Zones, target: float) -> str:
    share, _ = share_within(found, target)
    return f"{share.value:.3g} % ({share.low:.3g} … {share.high:.3g}) of the workspace is within {length(target, stated=True)}."


def _cards(found: Zones) -> list[Card]:
    least, middle, most = (_over_shown(found, what) for what in (np.min, np.median, np.max))
    out = [
        Card(f"{level_said(found)} below, median cell", str(middle), by_said(found)),
        Card("most accurate cell", str(least), f"least accurate {most}"),
    ]
    if found.within is not None:
        share, _ = share_within(found, found.within.target)
        out.append(
            Card(
                f"within {length(found.within.target, stated=True)}",
                f"{share.value:.3g} %",
                f"of the workspace, {share.low:.3g} … {share.high:.3g} %",
            )
        )
    if found.boxes is not None and found.boxes.found:
        box = found.boxes.found[0]
        out.append(Card("best place", str(length(box.afresh_worst)), f"{place_said(box)}; worst point, looked at afresh"))
    return out


def _map(found: Zones) -> Section:
    known = counted(found)
    counts = found.reached.counts[known]
    usual = int(np.median(counts))
    all_cells = f"{several(len(counts), 'cell')}, {per_cell_said(found)}"
    rows: list[Row] = []
    alike: list[str] = []
    for measure, name in ((QUANTILE, f"{level_said(found)} below"), (MEAN, "mean error")):
        every = found.figures[measure][:, known]
        columns = [(k, f"{name}, {by}") for k, by in enumerate(BYS)]
        if np.allclose(every, every[1], rtol=SAME, atol=0):  # one configuration, or all are as good
            columns, alike = [(1, name)], [*alike, name]
        for k, label in columns:
            values, (low, high) = found.figures[measure, k][known], found.ends[:, measure, k][:, known]
            for cell, at in (("most", int(values.argmin())), ("median", None), ("least", int(values.argmax()))):
                if at is None:
                    rows.append(Row(f"{label}, median cell", (length(*_median(found, measure, k), samples=all_cells),)))
                    continue
                said = f"{several(int(counts[at]), 'configuration')} in the cell"
                shown = length(float(values[at]), float(low[at]), float(high[at]), said)
                rows.append(Row(f"{label}, {cell} accurate cell", (shown,), said if counts[at] != usual else ""))
    note = (
        f"cells of {edge_said(found)} reached{' at their middle' * bool(found.reached.centre.any())}, "
        f"{several(usual, 'configuration')} looked at in a cell where no other number stands; "
        f"medians of {_counted_in_median(found)}. The plots show {level_said(found)} below, {by_said(found)}. "
        "Interval of a cell: the uncertainty of the sums over terms, and of a mean over drawn "
        "configurations 95 % (Student); ?: more configurations may be better, or worse, without a limit known. Chosen as extremes, the two extreme "
        "cells stand a little too far out"
    )
    if alike:
        note = f"{' and '.join(alike)}: best, mean and worst configuration looked at are the same in every cell; " + note
    return Section("map", "Accuracy map", ("value",), tuple(rows), note)


def _median(found: Zones, measure: int, column: int) -> tuple[float, float, float]:
    """Give the median over the cells with ends that hold that over the workspace as well."""
    known = counted(found)
    value, ends = float(np.median(found.figures[measure, column][known])), found.ends[:, measure, column][:, known]
    # A cell of which nothing is known on one side may lie anywhere there; if that leaves the median nowhere to stand, nothing is known of it.
    low, high = (float(np.median(np.where(np.isnan(end), beyond, end))) for end, beyond in zip(ends, (-np.inf, np.inf), strict=True))
    low, high = (end if math.isfinite(end) else math.nan for end in (low, high))
    if found.afresh is not None:
        over = found.afresh.quantile(measure, BYS[column], 0.5)
        low = low if math.isnan(low + over.low) else min(low, over.low)
        high = high if math.isnan(high + over.high) else max(high, over.high)
    return value, low, high


def _counted_in_median(found: Zones) -> str:
    return several(int(counted(found).sum()), "cell") + ("" if found.afresh is None else f", {several(len(found.afresh.points), 'point')} afresh")


def _within(found: Zones) -> Section:
    values, afresh = found.shown[counted(found)], found.afresh
    told = {} if found.within is None else {str(length(found.within.target, stated=True)): (found.within.target, "the target")}
    for part in _SHARES:
        error = float(np.quantile(values, part))
        told.setdefault(str(length(error)), (error, ""))
    rows = tuple(Row(f"within {said}", share_within(found, error), remark) for said, (error, remark) in told.items())
    note = f"by the {by_said(found)}, {level_said(found)} of errors. " + (
        "No point drawn in space is in reach (the workspace is next to a surface): shares of the cells, with intervals as if those were drawn"
        if afresh is None
        else f"At {several(len(afresh.points), 'point')} drawn evenly over the workspace, looked at afresh; intervals of a count "
        "(Clopper and Pearson), from the points that are surely within to those that may be"
    )
    return Section("within", "How much of the workspace is how accurate", ("share", "size"), rows, note)


def _budget(found: Zones) -> Section | None:
    if not found.budgets or not found.budgets[0].costs:
        return None
    first = found.budgets[0]
    shares = [{cost.part: cost.share for cost in each.costs} for each in found.budgets]
    said = [f"{each.poses} pose{'s' * (each.poses != 1)} in {each.cells} cell{'s' * (each.cells != 1)}: {each.zone}" for each in found.budgets]
    rows = [Row("r.m.s. error", tuple(length(each.rms, samples=counted) for each, counted in zip(found.budgets, said, strict=True)), "of the zone")]
    for cost in first.costs:
        figures = tuple(Figure(100 * of.get(cost.part, 0.0), "%", samples=counted) for of, counted in zip(shares, said, strict=True))
        rows.append(Row(cost.part.removeprefix("joints."), figures))
    note = f"shares of the mean-square error, exact sums over terms at the poses that the figures rest on ({by_said(found)}); the largest first"
    return Section("budget", "Which part is to blame, where", tuple(each.zone for each in found.budgets), tuple(rows), note)


def _reach(found: Zones) -> Section:
    reached, errors = found.reached, found.looked.errors
    counts = reached.counts[reached.counts > 0]
    poses = f"{len(reached.q)} poses looked at"
    rim = int(((reached.counts > 0) & ~reached.centre).sum())
    size = found.size
    rows = [
        Row("cells reached", (Figure(len(counts), "1"),), f"edge {edge_said(found)}"),
        Row("of them only in part", (Figure(rim, "1"),), "the middle is out of reach, or was not found"),
        Row(
            {3: "volume", 2: "area", 1: "length"}[max(reached.grid.dimensions, 1)],
            (Figure(size.value, unit_said(found), size.low, size.high, _drawn(found)),) if size.value else (Figure(0.0, unit_said(found)),),
            _drawn(found) if size.value else "the workspace is a surface on this grid",
        ),
        Row("poses sampled", (Figure(reached.sampled, "1"),), "Sobol sequences"),
        Row("poses brought by inverse kinematics", (Figure(int(reached.brought.sum()), "1"),), "from cells around"),
        Row("configurations in a cell, median", (whole(float(np.median(counts)), poses),), "each once: those that differ"),
        Row(
            "cells with fewer than asked", (Figure(int((counts < found.per_cell).sum()), "1"),), f"least {int(counts.min())}, asked {found.per_cell}"
        ),
        Row(
            "poses with valid figures",
            (Figure(100 * float(errors.valid.mean()), "%", samples=poses),),
            "known to 5 %; others only where a cell has none",
        ),
        Row("cells without a valid figure", (Figure(int(found.uncertain.sum()), "1"),), "a few two-sided errors dominate: see the intervals"),
    ]
    return Section("reach", "What was looked at", ("value",), tuple(rows), "cells that are reached are all looked at; none is left unvisited")


def _remarks(found: Zones) -> list[str]:
    out = ["the tool may stand in any direction; obstacles, floor and self-collision are not looked at"]
    if found.uncertain.any():
        cells = several(int(found.uncertain.sum()), "cell")
        out.append(f"{cells} without a valid figure: a few two-sided errors dominate. Monte Carlo (lostmotion study) shows the distribution there")
    for box in () if found.boxes is None else found.boxes.found:
        if box.afresh_reached < box.afresh_points:
            missed = box.afresh_points - box.afresh_reached
            out.append(f"the place around {place_said(box)}: {missed} of {box.afresh_points} points looked at afresh were not reached")
    return out


def _off_the_map(found: Zones, at: Floats | None) -> list[str]:
    """Say where slices were asked for through a point that no pose reaches."""
    if at is None:
        return []
    grid = found.reached.grid
    number = int(grid.number(np.where(grid.flat, np.nan_to_num(np.array(grid.plane)), at)[None])[0])
    on_plane = bool(np.allclose(at[grid.flat], np.array(grid.plane)[grid.flat], rtol=0, atol=grid.edge / 2))
    point = ", ".join(f"{axis} {value * 1e3:.6g}" for axis, value in zip("xyz", at, strict=True)) + " mm"
    if number >= 0 and on_plane and found.reached.counts.flat[number]:
        return []
    if number >= 0 and on_plane:
        return [f"no pose was found that reaches the cell of the point {point}, through which the slices go"]
    high = grid.low + grid.edge * np.array(grid.shape)
    ends = ", ".join(f"{axis} {a * 1e3:.4g} … {b * 1e3:.4g}" for axis, a, b in zip("xyz", grid.low, high, strict=True)) + " mm"
    return [f"the point {point} is out of reach, beyond the map ({ends}): the slices go through the map's cells nearest to it"]


def _facts(found: Zones) -> dict[str, Any]:
    grid = found.reached.grid
    facts: dict[str, Any] = {
        "arm": found.arm.name,
        "by": found.by,
        "level": found.level,
        "seed": found.seed,
        "cell_m": grid.edge,
        "cells": int(np.isfinite(found.shown).sum()),
        "low_m": grid.low.tolist(),
        "shape": list(grid.shape),
        "poses": {"sampled": found.reached.sampled, "looked_at": len(found.reached.q), "per_cell_asked": found.per_cell},
    }
    if found.within is not None:
        facts["target_m"] = found.within.target
    return facts if found.boxes is None else facts | places_facts(found.boxes)
