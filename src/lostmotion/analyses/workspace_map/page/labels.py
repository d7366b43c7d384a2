"""Labels and cells of an accuracy map."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.intervals import Estimate
from lostmotion.maps.cell_statistics import CONFIGURATIONS, QUANTILE
from lostmotion.maps.validation_points import of_count
from lostmotion.reporting.sheet import Cell, length

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from lostmotion.maps.accuracy_map import WorkspaceMap
    from lostmotion.maps.placement import Placement
    from lostmotion.spatial import Floats

# Relative difference of errors that is due to rounding.
SAME: Final = 1e-9


_UNITS: Final = {3: "m³", 2: "m²", 1: "m"}


def level_label(accuracy_map: WorkspaceMap) -> str:
    """Return the probability of the quantile, in %."""
    return f"{100 * accuracy_map.level:.6g} %"


def percentile_label(accuracy_map: WorkspaceMap) -> str:
    """Return the name of the quantile: "95th percentile"."""
    percent = f"{100 * accuracy_map.level:.6g}"
    ordinary = "." in percent or percent[-2:] in {"11", "12", "13"}
    suffix = "th" if ordinary else {"1": "st", "2": "nd", "3": "rd"}.get(percent[-1], "th")
    return f"{percent}{suffix} percentile"


def configuration_label(accuracy_map: WorkspaceMap) -> str:
    """Return the name of the configuration by which cells are evaluated."""
    return (
        "mean over configurations"
        if accuracy_map.by == "mean"
        else f"{accuracy_map.by} configuration"
    )


def edge_label(accuracy_map: WorkspaceMap) -> str:
    """Return the edge of the cells, as requested."""
    return f"{accuracy_map.reached.grid.edge * 1e3:.6g} mm"


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


def counted_cells(accuracy_map: WorkspaceMap) -> np.ndarray:
    """Return the cells (x, y, z) that the figures count."""
    return accuracy_map.centre & np.isfinite(accuracy_map.selected)


def configurations_label(accuracy_map: WorkspaceMap) -> str:
    """Return the number of configurations in a cell."""
    counts = accuracy_map.reached.counts[accuracy_map.reached.counts > 0]
    middle = float(np.median(counts))
    return (
        f"{median_count(middle)} configuration{'s' * (middle != 1)} in each (median; least "
        f"{int(counts.min())})"
    )


def median_count(value: float, samples: str = "") -> Cell:
    """Return a median of counts, which may be half an integer."""
    return Cell(int(value) if value.is_integer() else value, "1", samples=samples)


def size_unit(accuracy_map: WorkspaceMap) -> str:
    """Return the unit of the workspace's size."""
    return _UNITS[max(accuracy_map.reached.grid.dimensions, 1)]


def figure_over_cells(
    accuracy_map: WorkspaceMap, measure: int, column: int, what: Callable[[Floats], float]
) -> Cell:
    """Return the minimum, median or maximum of a figure over the cells."""
    return length(float(what(accuracy_map.errors[measure, column][counted_cells(accuracy_map)])))


def share_within(accuracy_map: WorkspaceMap, error: float) -> tuple[Cell, Cell]:
    """Return the share of the workspace within an error (m), %, and its size."""
    error *= 1 + SAME
    validation, column = accuracy_map.validation, CONFIGURATIONS.index(accuracy_map.by)
    if validation is not None:
        share, size = validation.share(QUANTILE, accuracy_map.by, error)
        samples = f"{len(validation.points)} points, {validation.poses} poses"
    else:
        cells = counted_cells(accuracy_map)
        hits, (low, high) = (
            accuracy_map.selected[cells] <= error,
            np.nan_to_num(accuracy_map.bounds[:, QUANTILE, column][:, cells], nan=error),
        )
        doubtful = accuracy_map.uncertain[cells] & (low <= error) & (high >= error)
        low, value, high = (
            of_count(int(each.sum()), len(hits))
            for each in (hits & ~doubtful, hits, hits | doubtful)
        )
        share = Estimate(value.value, low.low, high.high)
        size = Estimate(
            share.value * accuracy_map.size.value,
            share.low * accuracy_map.size.low,
            share.high * accuracy_map.size.high,
        )
        samples = f"{int(cells.sum())} cells, {configurations_label(accuracy_map)}"
    return (
        Cell(share.value, "%", share.low, share.high, samples),
        Cell(size.value, size_unit(accuracy_map), size.low, size.high, samples),
    )
