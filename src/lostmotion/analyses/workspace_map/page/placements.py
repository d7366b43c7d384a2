"""Tables of the best placements of a box in an accuracy map."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from lostmotion.analyses.workspace_map.page.labels import (
    configuration_label,
    percentile_label,
    placement_label,
    size_label,
)
from lostmotion.reporting.provenance import at_least
from lostmotion.reporting.sheet import Row, Section, length, several

if TYPE_CHECKING:
    from lostmotion.error_model.provenance import States
    from lostmotion.maps.accuracy_map import WorkspaceMap
    from lostmotion.maps.placement import Placement, Placements


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
