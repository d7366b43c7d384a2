"""Tables of an accuracy map: errors over its cells, share by error, budget by zone, and reach."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.workspace_map.page.gain import gain_rows
from lostmotion.analyses.workspace_map.page.labels import (
    SAME,
    configuration_label,
    configurations_label,
    counted_cells,
    edge_label,
    median_count,
    percentile_label,
    share_within,
    size_unit,
)
from lostmotion.maps.cell_statistics import CONFIGURATIONS, MEAN, QUANTILE
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.sheet import Cell, Row, Section, length, several

if TYPE_CHECKING:
    from lostmotion.maps.accuracy_map import WorkspaceMap

# Shares of the workspace in the table of errors.
_SHARES: Final = (0.1, 0.5, 0.9)


def _points_label(accuracy_map: WorkspaceMap) -> str:
    validation = accuracy_map.validation
    if validation is None:
        return "cells reached at their centre"
    return f"{len(validation.points)} of {validation.drawn} sampled points are in reach"


def map_section(accuracy_map: WorkspaceMap) -> Section:
    """Return the table of the errors in the most and least accurate and the median cell."""
    known = counted_cells(accuracy_map)
    counts = accuracy_map.reached.counts[known]
    usual = int(np.median(counts))
    all_cells = f"{several(len(counts), 'cell')}, {configurations_label(accuracy_map)}"
    rows: list[Row] = []
    uniform: list[str] = []
    measures = ((QUANTILE, percentile_label(accuracy_map)), (MEAN, "mean error"))
    for measure, name in measures:
        every = accuracy_map.errors[measure][:, known]
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
                accuracy_map.errors[measure, k][known],
                accuracy_map.bounds[:, measure, k][:, known],
            )
            for cell, at in (
                ("most accurate cell", int(values.argmin())),
                ("least accurate cell", int(values.argmax())),
            ):
                samples = f"{several(int(counts[at]), 'configuration')} in the cell"
                cells[cell].append(
                    length(float(values[at]), float(low[at]), float(high[at]), samples)
                )
            cells["median cell"].append(
                length(*_median(accuracy_map, measure, k), samples=all_cells)
            )
        rows += [Row(f"{name}, {cell}", tuple(figures)) for cell, figures in cells.items()]
    columns: tuple[str, ...] = CONFIGURATIONS
    if len(uniform) == len(measures):
        columns, rows = ("value",), [Row(row.label, row.cells[1:2]) for row in rows]
    note = (
        f"cells of {edge_label(accuracy_map)} "
        f"reached{' at their centre' * bool(accuracy_map.reached.centre.any())}, "
        f"{several(usual, 'configuration')} in most of them, result.json states those of every "
        f"figure; medians of {_median_count_label(accuracy_map)}. "
        f"The plots show the {percentile_label(accuracy_map)}, "
        f"{configuration_label(accuracy_map)}. "
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


def _median(accuracy_map: WorkspaceMap, measure: int, column: int) -> tuple[float, float, float]:
    """Return the median over the cells with bounds that also contain the median over the
    workspace.
    """
    known = counted_cells(accuracy_map)
    value, bounds = (
        float(np.median(accuracy_map.errors[measure, column][known])),
        accuracy_map.bounds[:, measure, column][:, known],
    )
    # An unknown bound of a cell may be anywhere; the median's bound is unknown if it depends on
    # one.
    low, high = (
        float(np.median(np.where(np.isnan(end), beyond, end)))
        for end, beyond in zip(bounds, (-np.inf, np.inf), strict=True)
    )
    low, high = (end if math.isfinite(end) else math.nan for end in (low, high))
    if accuracy_map.validation is not None:
        over = accuracy_map.validation.quantile(measure, CONFIGURATIONS[column], 0.5)
        low = low if math.isnan(low + over.low) else min(low, over.low)
        high = high if math.isnan(high + over.high) else max(high, over.high)
    return value, low, high


def _median_count_label(accuracy_map: WorkspaceMap) -> str:
    points = (
        ""
        if accuracy_map.validation is None
        else f", {several(len(accuracy_map.validation.points), 'validation point')}"
    )
    return several(int(counted_cells(accuracy_map).sum()), "cell") + points


def within_section(accuracy_map: WorkspaceMap) -> Section:
    """Return the table of the share and size of the workspace within several errors."""
    values, validation = accuracy_map.selected[counted_cells(accuracy_map)], accuracy_map.validation
    target = None if accuracy_map.within_target is None else accuracy_map.within_target.target
    errors = {} if target is None else {str(length(target, stated=True)): (target, "the target")}
    for part in _SHARES:
        error = float(np.quantile(values, part))
        errors.setdefault(str(length(error)), (error, ""))
    rows = tuple(
        Row(f"within {label}", share_within(accuracy_map, error), remark)
        for label, (error, remark) in errors.items()
    )
    note = (
        f"{percentile_label(accuracy_map)} of the error, {configuration_label(accuracy_map)}. "
        + (
            (
                "No point sampled in space is in reach (the workspace is nearly a surface): "
                "shares of "
                "the cells, with intervals as of independent draws"
            )
            if validation is None
            else f"At {several(len(validation.points), 'validation point')} sampled uniformly "
            "over the "
            "workspace; Clopper-Pearson intervals, including "
            "the uncertainty of the figures"
        )
    )
    return Section("within", "Share of the workspace by error", ("share", "size"), rows, note)


def budget_section(accuracy_map: WorkspaceMap) -> Section | None:
    """Return the table of the error budget by zone; None where the arm has no errors."""
    if not accuracy_map.budgets or not accuracy_map.budgets[0].costs:
        return None
    first = accuracy_map.budgets[0]
    shares = [{cost.part: cost.share for cost in each.costs} for each in accuracy_map.budgets]
    samples = [
        f"{several(each.poses, 'pose')} in {several(each.cells, 'cell')}: {each.zone}"
        for each in accuracy_map.budgets
    ]
    rows = [
        Row(
            "r.m.s. error",
            tuple(
                length(each.rms, samples=text)
                for each, text in zip(accuracy_map.budgets, samples, strict=True)
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
        f"({configuration_label(accuracy_map)}), the largest first"
    )
    return Section(
        "budget",
        "Error budget by zone",
        tuple(each.zone for each in accuracy_map.budgets),
        tuple(rows),
        note,
    )


def reach_section(accuracy_map: WorkspaceMap) -> Section:
    """Return the table of reachable cells and evaluated poses."""
    reached, errors = accuracy_map.reached, accuracy_map.evaluated.errors
    counts = reached.counts[reached.counts > 0]
    poses = f"{len(reached.q)} evaluated poses"
    rim = int(((reached.counts > 0) & ~reached.centre).sum())
    size = accuracy_map.size
    rows = [
        Row("cells reached", (Cell(len(counts), "1"),), f"edge {edge_label(accuracy_map)}"),
        Row("partly reached cells", (Cell(rim, "1"),), "centre out of reach"),
        Row(
            {3: "volume", 2: "area", 1: "length"}[max(reached.grid.dimensions, 1)],
            (
                Cell(
                    size.value,
                    size_unit(accuracy_map),
                    size.low,
                    size.high,
                    _points_label(accuracy_map),
                ),
            )
            if size.value
            else (Cell(0.0, size_unit(accuracy_map)),),
            _points_label(accuracy_map)
            if size.value
            else "the workspace is a surface on this grid",
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
            (Cell(int((counts < accuracy_map.per_cell).sum()), "1"),),
            f"least {int(counts.min())} of {accuracy_map.per_cell}",
        ),
        Row(
            "poses with valid figures",
            (Cell(float(errors.valid.mean()), "%", samples=poses),),
            "uncertainty below 5 %; others count only in cells without",
        ),
        Row(
            "cells without a valid figure",
            (Cell(int(accuracy_map.uncertain.sum()), "1"),),
            "a few two-valued errors dominate: see the intervals",
        ),
        *gain_rows(accuracy_map),
    ]
    return Section(
        "reach",
        "Reachable cells and evaluated poses",
        ("value",),
        tuple(rows),
        "all reachable cells are evaluated",
    )
