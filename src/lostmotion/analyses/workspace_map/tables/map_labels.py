"""What an accuracy map's figures are called, and which of them are bounds."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.analyses.workspace_map.cell_statistics import BYS, MEAN, QUANTILE
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


def at_most(figure: Figure) -> str:
    """Say a figure in a sentence, an upper bound as one."""
    return f"{replace(figure, bound='')} at most" if figure.bound else str(figure)


def below_said(found: Zones) -> str:
    """Name what maps show: the error that a share stays below, or an upper bound of it."""
    return f"{level_said(found)} below{bounds_said(found)}"


def bounds_said(found: Zones) -> str:
    """Say behind a figure's name whether upper bounds stand in its place, in some cells or in all."""
    bounded = found.bounded[np.isfinite(found.shown)]
    return "" if not bounded.any() else ", upper bound" if bounded.all() else ", or upper bound"


def over_cells(found: Zones, measure: int, column: int, what: Callable[[Floats], float]) -> Figure:
    """Give the least, median or largest figure of the cells; an upper bound where its cell has a bound alone, the median where any such moves it."""
    cells = counted(found)
    values = found.figures[measure, column][cells]
    low = np.where(_bounded(found, measure)[cells], np.nan_to_num(found.ends[0, measure, column][cells]), values)
    value = float(what(values))
    least = float(what(low)) if what is np.median else float(low[np.argmin(np.abs(values - value))])
    return replace(length(value), bound="upper" if least < (1 - SAME) * value else "")


def _bounded(found: Zones, measure: int) -> np.ndarray:
    """Which cells (x, y, z) have a bound in the place of this figure?"""
    if measure == QUANTILE:
        return found.bounded
    errors, cell = found.looked.errors, found.reached.cell
    bound = (errors.mean >= errors.high[MEAN]) & (errors.low[MEAN] < errors.mean)
    counts = np.bincount(cell[bound & (errors.known | found.bounded.ravel()[cell])], minlength=found.bounded.size)
    return (counts > 0).reshape(found.bounded.shape)


def share_within(found: Zones, error: float) -> tuple[Figure, Figure]:
    """How much of the workspace is within an error (m): its share, %, and its size?

    No smaller than told where of some cells or points bounds alone are known that lie beyond; not known where that leaves none.
    """
    error *= 1 + SAME
    afresh, column = found.afresh, BYS.index(found.by)
    if afresh is not None:
        values, low, high = (each[QUANTILE, column] for each in (afresh.figures, *afresh.ends))
        beyond = (high <= values) & (low <= error) & (values > error)
        share, size = afresh.share(QUANTILE, found.by, error)
        samples = f"{len(afresh.points)} points, {afresh.poses} poses"
    else:
        cells = counted(found)
        values, low = found.shown[cells], np.nan_to_num(found.ends[0, QUANTILE, column][cells])
        beyond = found.bounded[cells] & (low <= error) & (values > error)
        hits = int((values <= error).sum())
        share = replace(of_count(hits, len(values)), high=of_count(hits + int(beyond.sum()), len(values)).high)
        size = Estimate(share.value * found.size.value, share.low * found.size.low, share.high * found.size.high)
        samples = f"{len(values)} cells, {per_cell_said(found)}"
    none = bool(beyond.any()) and not share.value
    bound: Literal["", "lower"] = "lower" if beyond.any() and not none else ""
    in_cent, of_space = (
        Figure(math.nan if none else by * each.value, unit, by * each.low, by * each.high, samples, bound=bound)
        for each, unit, by in ((share, "%", 100.0), (size, unit_said(found), 1.0))
    )
    return in_cent, of_space
