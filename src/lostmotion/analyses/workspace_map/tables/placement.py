"""The figures of an accuracy map's places: where work should stand, and how accurate the arm is there."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from lostmotion.analyses.workspace_map.tables.map_labels import by_said, level_said, place_said, size_said
from lostmotion.reporting.sheet import Row, Section, length

if TYPE_CHECKING:
    from lostmotion.analyses.workspace_map.map import Zones
    from lostmotion.analyses.workspace_map.placement import Box, Boxes


def boxes_said(boxes: Boxes, found: Zones) -> str:
    """Say where the box should stand, or that it fits nowhere, and which one would."""
    if boxes.found:
        box = boxes.found[0]
        return (
            f"Work of {size_said(boxes.size)} is best placed around {place_said(box)}: {level_said(found)} within "
            f"{length(box.worst)} in the worst of its cells ({len(box.cells)}); looked at afresh, "
            f"{length(box.afresh_worst)}."
        )
    if boxes.largest is None:
        return f"No box of the proportions {size_said(boxes.size)} fits into the reach on this grid, however small."
    return f"No place within reach holds {size_said(boxes.size)}; the largest box of these proportions that fits here is {size_said(boxes.largest)}."


def places_section(found: Zones) -> Section | None:
    """Where should the work stand, and how accurate is the arm there? None where none was asked to be placed."""
    boxes = found.boxes
    if boxes is None:
        return None
    title = f"Where work of {size_said(boxes.size)} should stand"
    if not boxes.found:
        return Section("places", title, ("value",), (), boxes_said(boxes, found))
    rows, places = [], []
    for number, box in enumerate(boxes.found, start=1):
        cells = f"{len(box.cells)} cells of the map"
        other = f"{box.afresh_reached} of {box.afresh_points} other points reached, {box.afresh_poses} other poses"
        low, high = (np.round(end, 9) + 0.0 for end in (box.centre - box.size / 2, box.centre + box.size / 2))  # no -0
        sides = ", ".join(f"{axis} {a * 1e3:.0f} … {b * 1e3:.0f}" for axis, a, b in zip("xyz", low, high, strict=True)) + " mm"
        sides = sides if not box.yaw else f"sides along x, y turned by {math.degrees(box.yaw):.0f}°"
        said = (
            ("worst cell", box.worst, cells),
            ("mean of cells", box.mean, cells),
            ("worst point, afresh", box.afresh_worst, other),
            ("mean, afresh", box.afresh_mean, other),
        )
        for (what, value, counted), (low, high) in zip(said, box.ends.T, strict=True):
            figure = length(value, float(low), float(high), counted)
            rows.append(Row(f"{number}. {what}", (figure,), _counts_said(box, afresh=counted == other)))
        places.append(f"{number}. around {place_said(box)}: {sides}")
    judged = "mean over its cells" if boxes.by_mean else "worst cell"
    turned = ", any yaw in steps of 15°" if boxes.turned else ""
    note = (
        f"{level_said(found)} of errors by the {by_said(found)}; judged by the {judged}; the best of all {boxes.tried} places on the grid"
        f"{turned} of which the tool was brought to every cell's middle and corners; no two share a cell"
    )
    note = (
        "; ".join(places) + ". " + note + ". Interval: the uncertainty of the sums over terms, and of means over drawn configurations 95 % (Student)"
    )
    if boxes.largest is not None:
        note += f". The largest box of these proportions in reach: {size_said(boxes.largest)}"
    return Section("places", title, ("value",), tuple(rows), note)


def _counts_said(box: Box, *, afresh: bool) -> str:
    if not afresh:
        return f"{len(box.cells)} cell{'s' * (len(box.cells) != 1)}"
    return f"{box.afresh_reached} of {box.afresh_points} points, {box.afresh_poses} poses"


def places_facts(boxes: Boxes) -> dict[str, Any]:
    """Give the places as plain data, SI."""
    return {
        "box_m": list(boxes.size),
        "largest_box_m": None if boxes.largest is None else boxes.largest.tolist(),
        "places": [
            {
                "centre_m": box.centre.tolist(),
                "yaw_rad": box.yaw,
                "worst_m": box.worst,
                "mean_m": box.mean,
                "afresh_worst_m": box.afresh_worst if math.isfinite(box.afresh_worst) else None,
            }
            for box in boxes.found
        ],
    }
