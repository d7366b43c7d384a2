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
