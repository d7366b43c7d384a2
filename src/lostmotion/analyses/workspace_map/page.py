"""Sheet of an accuracy map."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.workspace_map.cell_statistics import CONFIGURATIONS, MEAN, QUANTILE
from lostmotion.analyses.workspace_map.placement_tables import (
    SAME,
    configuration_label,
    configurations_label,
    counted_cells,
    edge_label,
    figure_over_cells,
    level_label,
    median_count,
    percentile_label,
    placement_facts,
    placement_label,
    placement_section,
    placement_sentence,
    share_within,
    size_unit,
)
from lostmotion.error_model.provenance import states
from lostmotion.error_model.trust import trust_remarks
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.arm_sheet import with_arm
from lostmotion.reporting.provenance import (
    at_least,
    caveats,
    share_within_bounded,
)
from lostmotion.reporting.sheet import Card, Cell, Row, Section, Sheet, length, several

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.analyses.workspace_map.map import WorkspaceMap
    from lostmotion.error_model.provenance import States
    from lostmotion.spatial import Floats


# Shares of the workspace in the table of errors.
_SHARES: Final = (0.1, 0.5, 0.9)


_WORDS: Final = (
    (
        "cell",
        (
            "a cube of the grid, with the error at its centre; where the centre is out of reach, "
            "at the points reached."
        ),
    ),
    (
        "best, mean, worst",
        (
            "over the arm configurations in a cell. Best and worst are one-sided bounds that "
            "change with more configurations; the mean does not."
        ),
    ),
    (
        "position error",
        (
            "distance between commanded and attained position of the tool point, over all robots "
            "and visits."
        ),
    ),
    (
        "configuration",
        (
            "joint values with the tool point there, in any orientation of the tool. Obstacles, "
            "floor and self-collision are not checked."
        ),
    ),
    (
        "validation points",
        "a lattice over the box, corners included, with other poses than those of the map.",
    ),
    (
        "share",
        (
            "of the mean-square error over the poses on which the zone's figures are based, exact "
            "sums over terms. Shares add to 100 %."
        ),
    ),
)


def map_sheet(found: WorkspaceMap, at: Floats | None = None) -> Sheet:
    """Return the sheet of an accuracy map, with slices through the point `at` (3,), m."""
    known = with_limits(states(found.arm), found.arm, found.reached.q)
    sections = (
        _map(found),
        _within(found),
        placement_section(found),
        _budget(found),
        _reach(found),
    )
    return with_arm(
        Sheet(
            subject="accuracy map",
            verdict=_verdict(found, known),
            cards=tuple(_cards(found, known)),
            sections=tuple(section for section in sections if section is not None),
            counts=(
                f"{several(int(np.isfinite(found.selected).sum()), 'cell')} of "
                f"{edge_label(found)}, {configurations_label(found)}"
            ),
            notes=(*_remarks(found), *_point_off_map(found, at)),
            words=_WORDS,
            source=f"{found.reached.sampled} poses sampled (sobol), {len(found.reached.q)} "
            f"evaluated, seed {found.seed}. "
            "The same file, version, seed and options give the same bytes.",
            arrays="the map, cell by cell",
            seed=found.seed,
            facts=_facts(found),
        ),
        found.arm,
        known,
        sections=("map", "within", "places"),
    )


def _points_label(found: WorkspaceMap) -> str:
    validation = found.validation
    if validation is None:
        return "cells reached at their centre"
    return f"{len(validation.points)} of {validation.drawn} sampled points are in reach"


def _verdict(found: WorkspaceMap, known: States) -> str:
    least, middle, most = (_over_shown(found, what) for what in (np.min, np.median, np.max))
    text = f"{level_label(found)} of positions ({configuration_label(found)}) are within "
    if str(least) == str(most):
        text += f"{at_least(least, known)} in every cell."
    else:
        text += (
            f"{at_least(middle, known)} in the median cell, {least} in the most accurate and "
            f"{most} in the least accurate one."
        )
    if found.within_target is not None:
        text += f" {_share_sentence(found, found.within_target.target, known)}"
    if found.placements is not None:
        text += " " + placement_sentence(found.placements, found, known)
    return " ".join([text, *caveats(known)])


def _over_shown(found: WorkspaceMap, what: Callable[[Floats], float]) -> Cell:
    return figure_over_cells(found, QUANTILE, CONFIGURATIONS.index(found.by), what)


def _share_sentence(found: WorkspaceMap, target: float, known: States) -> str:
    share, _ = share_within(found, target)
    text = share_within_bounded(
        f"{100 * share.value:.3g} % ({100 * share.low:.3g} … {100 * share.high:.3g}) "
        "of the workspace",
        known,
    )
    return f"{text[0].upper()}{text[1:]} is within {length(target, stated=True)}."


def _cards(found: WorkspaceMap, known: States) -> list[Card]:
    least, middle, most = (_over_shown(found, what) for what in (np.min, np.median, np.max))
    out = [
        Card(
            f"{percentile_label(found)}, median cell",
            str(middle),
            configuration_label(found),
            limited_as="error",
        ),
        Card(
            "most accurate cell",
            str(least),
            f"least accurate {at_least(most, known)}",
            limited_as="error",
        ),
    ]
    if found.within_target is not None:
        share, _ = share_within(found, found.within_target.target)
        out.append(
            Card(
                f"within {length(found.within_target.target, stated=True)}",
                share_within_bounded(f"{100 * share.value:.3g} %", known),
                f"of the workspace, {100 * share.low:.3g} … {100 * share.high:.3g} %",
            )
        )
    if found.placements is not None and found.placements.best:
        box = found.placements.best[0]
        out.append(
            Card(
                "best placement",
                str(length(box.validated_worst)),
                f"{placement_label(box)}; worst validation point",
                limited_as="error",
            )
        )
    return out


def _map(found: WorkspaceMap) -> Section:
    known = counted_cells(found)
    counts = found.reached.counts[known]
    usual = int(np.median(counts))
    all_cells = f"{several(len(counts), 'cell')}, {configurations_label(found)}"
    rows: list[Row] = []
    uniform: list[str] = []
    measures = ((QUANTILE, percentile_label(found)), (MEAN, "mean error"))
    for measure, name in measures:
        every = found.errors[measure][:, known]
        # one configuration, or all have the same error
        if np.allclose(every, every[1], rtol=SAME, atol=0):
            uniform.append(name)
        cells: dict[str, list[Cell]] = {
            "most accurate cell": [],
            "median cell": [],
            "least accurate cell": [],
        }
        for k in range(len(CONFIGURATIONS)):
            values, (low, high) = (
                found.errors[measure, k][known],
                found.bounds[:, measure, k][:, known],
            )
            for cell, at in (
                ("most accurate cell", int(values.argmin())),
                ("least accurate cell", int(values.argmax())),
            ):
                samples = f"{several(int(counts[at]), 'configuration')} in the cell"
                cells[cell].append(
                    length(float(values[at]), float(low[at]), float(high[at]), samples)
                )
            cells["median cell"].append(length(*_median(found, measure, k), samples=all_cells))
        rows += [Row(f"{name}, {cell}", tuple(figures)) for cell, figures in cells.items()]
    columns: tuple[str, ...] = CONFIGURATIONS
    if len(uniform) == len(measures):
        columns, rows = ("value",), [Row(row.label, row.cells[1:2]) for row in rows]
    note = (
        f"cells of {edge_label(found)} "
        f"reached{' at their centre' * bool(found.reached.centre.any())}, "
        f"{several(usual, 'configuration')} in most of them, result.json states those of every "
        f"figure; medians of {_median_count_label(found)}. "
        f"The plots show the {percentile_label(found)}, {configuration_label(found)}. "
        "Interval of a cell: uncertainty of the sums over terms, and 95 % confidence interval "
        "of a mean over sampled configurations; ?: the limit "
        "for more configurations is unknown. Selected as extremes, the two extreme cells are "
        "slightly biased outwards"
    )
    if uniform:
        note = (
            f"{' and '.join(uniform)}: best, mean and worst configuration are the same in "
            "every cell; "
        ) + note
    else:
        note = (
            f"{', '.join(CONFIGURATIONS[:-1])} and {CONFIGURATIONS[-1]} of the arm's "
            f"configurations in a cell; {note}"
        )
    return Section("map", "Accuracy map", columns, tuple(rows), note)


def _median(found: WorkspaceMap, measure: int, column: int) -> tuple[float, float, float]:
    """Return the median over the cells with bounds that also contain the median over the
    workspace.
    """
    known = counted_cells(found)
    value, bounds = (
        float(np.median(found.errors[measure, column][known])),
        found.bounds[:, measure, column][:, known],
    )
    # An unknown bound of a cell may be anywhere; the median's bound is unknown if it depends on
    # one.
    low, high = (
        float(np.median(np.where(np.isnan(end), beyond, end)))
        for end, beyond in zip(bounds, (-np.inf, np.inf), strict=True)
    )
    low, high = (end if math.isfinite(end) else math.nan for end in (low, high))
    if found.validation is not None:
        over = found.validation.quantile(measure, CONFIGURATIONS[column], 0.5)
        low = low if math.isnan(low + over.low) else min(low, over.low)
        high = high if math.isnan(high + over.high) else max(high, over.high)
    return value, low, high


def _median_count_label(found: WorkspaceMap) -> str:
    points = (
        ""
        if found.validation is None
        else f", {several(len(found.validation.points), 'validation point')}"
    )
    return several(int(counted_cells(found).sum()), "cell") + points


def _within(found: WorkspaceMap) -> Section:
    values, validation = found.selected[counted_cells(found)], found.validation
    target = None if found.within_target is None else found.within_target.target
    errors = {} if target is None else {str(length(target, stated=True)): (target, "the target")}
    for part in _SHARES:
        error = float(np.quantile(values, part))
        errors.setdefault(str(length(error)), (error, ""))
    rows = tuple(
        Row(f"within {label}", share_within(found, error), remark)
        for label, (error, remark) in errors.items()
    )
    note = f"{percentile_label(found)} of the error, {configuration_label(found)}. " + (
        (
            "No point sampled in space is in reach (the workspace is nearly a surface): shares of "
            "the cells, with intervals as of independent draws"
        )
        if validation is None
        else f"At {several(len(validation.points), 'validation point')} sampled uniformly over the "
        "workspace; Clopper-Pearson intervals, including "
        "the uncertainty of the figures"
    )
    return Section("within", "Share of the workspace by error", ("share", "size"), rows, note)


def _budget(found: WorkspaceMap) -> Section | None:
    if not found.budgets or not found.budgets[0].costs:
        return None
    first = found.budgets[0]
    shares = [{cost.part: cost.share for cost in each.costs} for each in found.budgets]
    samples = [
        f"{several(each.poses, 'pose')} in {several(each.cells, 'cell')}: {each.zone}"
        for each in found.budgets
    ]
    rows = [
        Row(
            "r.m.s. error",
            tuple(
                length(each.rms, samples=text)
                for each, text in zip(found.budgets, samples, strict=True)
            ),
            "of the zone",
        )
    ]
    for cost in first.costs:
        figures = tuple(
            Cell(of.get(cost.part, 0.0), "%", samples=text)
            for of, text in zip(shares, samples, strict=True)
        )
        rows.append(Row(short_name(cost.part), figures))
    note = (
        "shares of the mean-square error, exact sums over terms at the poses of the figures "
        f"({configuration_label(found)}), the largest first"
    )
    return Section(
        "budget",
        "Error budget by zone",
        tuple(each.zone for each in found.budgets),
        tuple(rows),
        note,
    )


def _reach(found: WorkspaceMap) -> Section:
    reached, errors = found.reached, found.evaluated.errors
    counts = reached.counts[reached.counts > 0]
    poses = f"{len(reached.q)} evaluated poses"
    rim = int(((reached.counts > 0) & ~reached.centre).sum())
    size = found.size
    rows = [
        Row("cells reached", (Cell(len(counts), "1"),), f"edge {edge_label(found)}"),
        Row("partly reached cells", (Cell(rim, "1"),), "centre out of reach"),
        Row(
            {3: "volume", 2: "area", 1: "length"}[max(reached.grid.dimensions, 1)],
            (Cell(size.value, size_unit(found), size.low, size.high, _points_label(found)),)
            if size.value
            else (Cell(0.0, size_unit(found)),),
            _points_label(found) if size.value else "the workspace is a surface on this grid",
        ),
        Row("poses sampled", (Cell(reached.sampled, "1"),), "Sobol sequences"),
        Row(
            "poses by inverse kinematics",
            (Cell(int(reached.brought.sum()), "1"),),
            "from neighbouring cells",
        ),
        Row(
            "configurations in a cell, median",
            (median_count(float(np.median(counts)), poses),),
            "distinct ones",
        ),
        Row(
            "cells with fewer than requested",
            (Cell(int((counts < found.per_cell).sum()), "1"),),
            f"least {int(counts.min())} of {found.per_cell}",
        ),
        Row(
            "poses with valid figures",
            (Cell(float(errors.valid.mean()), "%", samples=poses),),
            "uncertainty below 5 %; others count only in cells without",
        ),
        Row(
            "cells without a valid figure",
            (Cell(int(found.uncertain.sum()), "1"),),
            "a few two-valued errors dominate: see the intervals",
        ),
    ]
    return Section(
        "reach",
        "Reachable cells and evaluated poses",
        ("value",),
        tuple(rows),
        "all reachable cells are evaluated",
    )


def _remarks(found: WorkspaceMap) -> list[str]:
    out = ["any orientation of the tool; obstacles, floor and self-collision are not checked"]
    out += trust_remarks(found.arm)
    if found.uncertain.any():
        cells = several(int(found.uncertain.sum()), "cell")
        out.append(
            f"{cells} without a valid figure: a few two-valued errors dominate. Monte Carlo "
            "(lostmotion study) shows the distribution there"
        )
    for box in () if found.placements is None else found.placements.best:
        if box.validation_reached < box.validation_points:
            missed = box.validation_points - box.validation_reached
            out.append(
                f"placement at {placement_label(box)}: {missed} of {box.validation_points} "
                "validation points were not reached"
            )
    return out


def _point_off_map(found: WorkspaceMap, at: Floats | None) -> list[str]:
    """Return a note where the slices were requested through a point that no pose reaches."""
    if at is None:
        return []
    grid = found.reached.grid
    number = int(
        grid.cell_numbers(np.where(grid.flat, np.nan_to_num(np.array(grid.plane)), at)[None])[0]
    )
    on_plane = bool(
        np.allclose(at[grid.flat], np.array(grid.plane)[grid.flat], rtol=0, atol=grid.edge / 2)
    )
    point = (
        ", ".join(f"{axis} {value * 1e3:.6g}" for axis, value in zip("xyz", at, strict=True))
        + " mm"
    )
    if number >= 0 and on_plane and found.reached.counts.flat[number]:
        return []
    if number >= 0 and on_plane:
        return [f"no pose found in the cell of the point {point} of the slices"]
    high = grid.low + grid.edge * np.array(grid.shape)
    extent = (
        ", ".join(
            f"{axis} {a * 1e3:.4g} … {b * 1e3:.4g}"
            for axis, a, b in zip("xyz", grid.low, high, strict=True)
        )
        + " mm"
    )
    return [f"the point {point} is outside the map ({extent}): the slices show the nearest cells"]


def _facts(found: WorkspaceMap) -> dict[str, Any]:
    grid = found.reached.grid
    facts: dict[str, Any] = {
        "by": found.by,
        "level": found.level,
        "seed": found.seed,
        "cell_m": grid.edge,
        "cells": int(np.isfinite(found.selected).sum()),
        "low_m": grid.low.tolist(),
        "shape": list(grid.shape),
        "poses": {
            "sampled": found.reached.sampled,
            "looked_at": len(found.reached.q),
            "per_cell_asked": found.per_cell,
        },
    }
    if found.within_target is not None:
        facts["target_m"] = found.within_target.target
    return facts if found.placements is None else facts | placement_facts(found.placements)
