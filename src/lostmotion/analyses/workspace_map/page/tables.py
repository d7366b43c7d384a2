"""Tables of an accuracy map: errors over its cells, share by error, budget by zone, reach, and the
best placements of a box.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.workspace_map.page.labels import (
    SAME,
    configuration_label,
    configurations_label,
    counted_cells,
    edge_label,
    median_count,
    percentile_label,
    placement_label,
    share_within,
    size_label,
    size_unit,
)
from lostmotion.analyses.workspace_map.page.slices import gain_rows
from lostmotion.maps.cell_statistics import CONFIGURATIONS, MEAN, QUANTILE
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.provenance import at_least
from lostmotion.reporting.sheet import Cell, Row, Section, length, several

if TYPE_CHECKING:
    from lostmotion.error_model.provenance import States
    from lostmotion.maps.accuracy_map import WorkspaceMap
    from lostmotion.maps.placement import Placement, Placements

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


def placement_sentence(placements: Placements, accuracy_map: WorkspaceMap, known: States) -> str:
    """Return the best placement in words, or that there is none and the largest box that fits."""
    if placements.best:
        box = placements.best[0]
        worst, validated = (
            at_least(length(error), known) for error in (box.worst, box.validated_worst)
        )
        return (
            f"The best placement of a task of {size_label(placements.size)} is centred at "
            f"{placement_label(box)}: {percentile_label(accuracy_map)} "
            f"{worst} in its worst cell of {len(box.cells)}, {validated} at its worst "
            "validation point."
        )
    return no_placement_sentence(placements)


def no_placement_sentence(placements: Placements) -> str:
    """Return that no placement is within reach, and the largest box that fits."""
    if placements.largest is None:
        return (
            f"No box of the proportions {size_label(placements.size)} fits into the workspace on "
            "this grid, however small."
        )
    largest = size_label(placements.largest)
    return (
        f"No placement of {size_label(placements.size)} is within reach; the largest box of these "
        f"proportions that fits is {largest}."
    )


def placement_section(accuracy_map: WorkspaceMap) -> Section | None:
    """Return the table of the best placements; None where none was requested."""
    placements = accuracy_map.placements
    if placements is None:
        return None
    title = f"Best placement for a task of {size_label(placements.size)}"
    if not placements.best:
        return Section("places", title, ("value",), (), no_placement_sentence(placements))
    rows, places = [], []
    for number, box in enumerate(placements.best, start=1):
        cells = f"{several(len(box.cells), 'cell')} of the map"
        other = (
            f"{box.validation_reached} of {box.validation_points} other points reached, "
            f"{box.validation_poses} other poses"
        )
        # no -0
        low, high = (
            np.round(end, 9) + 0.0 for end in (box.centre - box.size / 2, box.centre + box.size / 2)
        )
        sides = (
            ", ".join(
                f"{axis} {a * 1e3:.0f} … {b * 1e3:.0f}"
                for axis, a, b in zip("xyz", low, high, strict=True)
            )
            + " mm"
        )
        sides = sides if not box.yaw else f"yaw {math.degrees(box.yaw):.0f}°"
        figures = (
            ("worst cell", box.worst, cells),
            ("mean of cells", box.mean, cells),
            ("worst validation point", box.validated_worst, other),
            ("mean of validation points", box.validated_mean, other),
        )
        for (name, value, samples), (low, high) in zip(figures, box.bounds.T, strict=True):
            figure = length(value, float(low), float(high), samples)
            rows.append(
                Row(f"{number}. {name}", (figure,), _counts_label(box, validation=samples == other))
            )
        places.append(f"{number}. centre {placement_label(box)}: {sides}")
    criterion = "mean over its cells" if placements.by_mean else "worst cell"
    turned = ", any yaw in steps of 15°" if placements.turned else ""
    note = (
        f"{percentile_label(accuracy_map)} of the error, {configuration_label(accuracy_map)}; "
        "ranked by the "
        f"{criterion}, out of {placements.tried} placements "
        f"on the grid{turned} with the centre and corners of every cell in reach; no two share "
        "a cell"
    )
    note = (
        f"{'; '.join(places)}. {note}. Interval: uncertainty of the sums over terms, and 95 % "
        "confidence interval of means over configurations"
    )
    if placements.largest is not None:
        note += f". Largest box of these proportions in reach: {size_label(placements.largest)}"
    return Section("places", title, ("value",), tuple(rows), note)


def _counts_label(box: Placement, *, validation: bool) -> str:
    """Return the number of cells, or of validation points and poses."""
    if not validation:
        return f"{len(box.cells)} cell{'s' * (len(box.cells) != 1)}"
    return (
        f"{box.validation_reached} of {box.validation_points} points, {box.validation_poses} poses"
    )


def placement_facts(placements: Placements) -> dict[str, Any]:
    """Return the placements as plain data, SI."""
    return {
        "box_m": list(placements.size),
        "largest_box_m": None if placements.largest is None else placements.largest.tolist(),
        "places": [
            {
                "centre_m": box.centre.tolist(),
                "yaw_rad": box.yaw,
                "worst_m": box.worst,
                "mean_m": box.mean,
                "afresh_worst_m": box.validated_worst
                if math.isfinite(box.validated_worst)
                else None,
            }
            for box in placements.best
        ],
    }
