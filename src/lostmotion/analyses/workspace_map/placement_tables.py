"""Labels of an accuracy map, and the tables of its best placements."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.workspace_map.cell_statistics import CONFIGURATIONS, QUANTILE
from lostmotion.analyses.workspace_map.validation_points import of_count
from lostmotion.error_model.intervals import Estimate
from lostmotion.reporting.provenance import at_least
from lostmotion.reporting.sheet import Cell, Row, Section, length, several

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from lostmotion.analyses.workspace_map.map import WorkspaceMap
    from lostmotion.analyses.workspace_map.placement import Placement, Placements
    from lostmotion.error_model.provenance import States
    from lostmotion.spatial import Floats


# Relative difference of errors that is due to rounding.
SAME: Final = 1e-9


_UNITS: Final = {3: "m³", 2: "m²", 1: "m"}


def level_label(found: WorkspaceMap) -> str:
    """Return the probability of the quantile, in %."""
    return f"{100 * found.level:.6g} %"


def percentile_label(found: WorkspaceMap) -> str:
    """Return the name of the quantile: "95th percentile"."""
    percent = f"{100 * found.level:.6g}"
    ordinary = "." in percent or percent[-2:] in {"11", "12", "13"}
    suffix = "th" if ordinary else {"1": "st", "2": "nd", "3": "rd"}.get(percent[-1], "th")
    return f"{percent}{suffix} percentile"


def configuration_label(found: WorkspaceMap) -> str:
    """Return the name of the configuration by which cells are evaluated."""
    return "mean over configurations" if found.by == "mean" else f"{found.by} configuration"


def edge_label(found: WorkspaceMap) -> str:
    """Return the edge of the cells, as requested."""
    return f"{found.reached.grid.edge * 1e3:.6g} mm"


def placement_label(box: Placement) -> str:
    """Return the centre of a placement, and its yaw if any."""
    text = (
        ", ".join(
            f"{axis} {value * 1e3:.0f}" for axis, value in zip("xyz", box.centre, strict=True)
        )
        + " mm"
    )
    return text + (f", yaw {math.degrees(box.yaw):.0f}°" if box.yaw else "")


def size_label(size: Iterable[float]) -> str:
    """Return the sides of a box."""
    return (
        " x ".join(f"{side * 1e3:.4g}" if side < 10 else f"{side * 1e3:.0f}" for side in size)  # noqa: PLR2004
        + " mm"
    )


def counted_cells(found: WorkspaceMap) -> np.ndarray:
    """Return the cells (x, y, z) that the figures count."""
    return found.centre & np.isfinite(found.selected)


def configurations_label(found: WorkspaceMap) -> str:
    """Return the number of configurations in a cell."""
    counts = found.reached.counts[found.reached.counts > 0]
    middle = float(np.median(counts))
    return (
        f"{median_count(middle)} configuration{'s' * (middle != 1)} in each (median; least "
        f"{int(counts.min())})"
    )


def median_count(value: float, samples: str = "") -> Cell:
    """Return a median of counts, which may be half an integer."""
    return Cell(int(value) if value.is_integer() else value, "1", samples=samples)


def size_unit(found: WorkspaceMap) -> str:
    """Return the unit of the workspace's size."""
    return _UNITS[max(found.reached.grid.dimensions, 1)]


def figure_over_cells(
    found: WorkspaceMap, measure: int, column: int, what: Callable[[Floats], float]
) -> Cell:
    """Return the minimum, median or maximum of a figure over the cells."""
    return length(float(what(found.errors[measure, column][counted_cells(found)])))


def share_within(found: WorkspaceMap, error: float) -> tuple[Cell, Cell]:
    """Return the share of the workspace within an error (m), %, and its size."""
    error *= 1 + SAME
    validation, column = found.validation, CONFIGURATIONS.index(found.by)
    if validation is not None:
        share, size = validation.share(QUANTILE, found.by, error)
        samples = f"{len(validation.points)} points, {validation.poses} poses"
    else:
        cells = counted_cells(found)
        hits, (low, high) = (
            found.selected[cells] <= error,
            np.nan_to_num(found.bounds[:, QUANTILE, column][:, cells], nan=error),
        )
        doubtful = found.uncertain[cells] & (low <= error) & (high >= error)
        low, value, high = (
            of_count(int(each.sum()), len(hits))
            for each in (hits & ~doubtful, hits, hits | doubtful)
        )
        share = Estimate(value.value, low.low, high.high)
        size = Estimate(
            share.value * found.size.value, share.low * found.size.low, share.high * found.size.high
        )
        samples = f"{int(cells.sum())} cells, {configurations_label(found)}"
    return (
        Cell(share.value, "%", share.low, share.high, samples),
        Cell(size.value, size_unit(found), size.low, size.high, samples),
    )


def placement_sentence(placements: Placements, found: WorkspaceMap, known: States) -> str:
    """Return the best placement in words, or that there is none and the largest box that fits."""
    if placements.best:
        box = placements.best[0]
        worst, validated = (
            at_least(length(error), known) for error in (box.worst, box.validated_worst)
        )
        return (
            f"The best placement of a task of {size_label(placements.size)} is centred at "
            f"{placement_label(box)}: {percentile_label(found)} "
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


def placement_section(found: WorkspaceMap) -> Section | None:
    """Return the table of the best placements; None where none was requested."""
    placements = found.placements
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
        f"{percentile_label(found)} of the error, {configuration_label(found)}; ranked by the "
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
