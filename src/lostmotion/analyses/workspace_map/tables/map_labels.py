"""What an accuracy map's figures are called, and figures over its cells."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.workspace_map.cell_statistics import BYS, QUANTILE
from lostmotion.analyses.workspace_map.validation_points import of_count
from lostmotion.error_model.intervals import Estimate
from lostmotion.reporting.sheet import Figure, length

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from lostmotion.analyses.workspace_map.map import Zones
    from lostmotion.analyses.workspace_map.placement import Box
    from lostmotion.spatial import Floats

# Errors that differ by a smaller share of themselves differ by rounding.
SAME: Final = 1e-9
_UNITS: Final = {3: "m³", 2: "m²", 1: "m"}


def level_said(found: Zones) -> str:
    """Name the share of errors that the figures are of."""
    return f"{100 * found.level:.6g} %"


def by_said(found: Zones) -> str:
    """Name the configuration that cells are judged by."""
    return "mean over configurations" if found.by == "mean" else f"{found.by} configuration"


def edge_said(found: Zones) -> str:
    """Name the cells' edge as it was asked for."""
    return f"{found.reached.grid.edge * 1e3:.6g} mm"


def place_said(box: Box) -> str:
    """Name a place by its middle, and its yaw where it is turned."""
    text = ", ".join(f"{axis} {value * 1e3:.0f}" for axis, value in zip("xyz", box.centre, strict=True)) + " mm"
    return text + (f", yaw {math.degrees(box.yaw):.0f}°" if box.yaw else "")


def size_said(size: Iterable[float]) -> str:
    """Name a box by its sides."""
    return " x ".join(f"{side * 1e3:.4g}" if side < 10 else f"{side * 1e3:.0f}" for side in size) + " mm"  # noqa: PLR2004 - no powers of ten


def counted(found: Zones) -> np.ndarray:
    """Which cells (x, y, z) do the figures count?"""
    return found.centre & np.isfinite(found.shown)


def per_cell_said(found: Zones) -> str:
    """Say how many configurations were looked at in a cell."""
    counts = found.reached.counts[found.reached.counts > 0]
    middle = float(np.median(counts))
    return f"{whole(middle)} configuration{'s' * (middle != 1)} in each (median; least {int(counts.min())})"


def whole(value: float, samples: str = "") -> Figure:
    """Give a median of counts: a whole number, or one and a half."""
    return Figure(int(value) if value.is_integer() else value, "1", samples=samples)


def unit_said(found: Zones) -> str:
    """Name the unit of the workspace's size."""
    return _UNITS[max(found.reached.grid.dimensions, 1)]


def over_cells(found: Zones, measure: int, column: int, what: Callable[[Floats], float]) -> Figure:
    """Return the least, median or largest figure of the cells."""
    return length(float(what(found.figures[measure, column][counted(found)])))


def share_within(found: Zones, error: float) -> tuple[Figure, Figure]:
    """Return how much of the workspace is within an error (m): its share, %, and its size."""
    error *= 1 + SAME
    afresh, column = found.afresh, BYS.index(found.by)
    if afresh is not None:
        share, size = afresh.share(QUANTILE, found.by, error)
        samples = f"{len(afresh.points)} points, {afresh.poses} poses"
    else:
        cells = counted(found)
        hits, (low, high) = found.shown[cells] <= error, np.nan_to_num(found.ends[:, QUANTILE, column][:, cells], nan=error)
        doubtful = found.uncertain[cells] & (low <= error) & (high >= error)
        sure, value, may = (of_count(int(each.sum()), len(hits)) for each in (hits & ~doubtful, hits, hits | doubtful))
        share = Estimate(value.value, sure.low, may.high)
        size = Estimate(share.value * found.size.value, share.low * found.size.low, share.high * found.size.high)
        samples = f"{int(cells.sum())} cells, {per_cell_said(found)}"
    return (
        Figure(100 * share.value, "%", 100 * share.low, 100 * share.high, samples),
        Figure(size.value, unit_said(found), size.low, size.high, samples),
    )
