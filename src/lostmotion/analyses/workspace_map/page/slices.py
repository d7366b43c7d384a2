"""Slices of a map: their place, and axes of equal scale; and the gain of a closed chain over the
workspace, in slices beside those of the error, with its largest value.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.reporting.chart import label_axes, one
from lostmotion.reporting.map_chart import cells, class_legend, class_of
from lostmotion.reporting.palette import class_limits
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Cell, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.maps.accuracy_map import WorkspaceMap
    from lostmotion.maps.cells import Grid
    from lostmotion.spatial import Floats

# Width of the plot area, and height of title, axis and legend, mm.
ACROSS: Final = 112.0
AROUND: Final = 40.0


def index_at(grid: Grid, axis: int, point: Floats) -> int:
    """Return the index along an axis of the cells at a point (3,), m."""
    index = np.floor((point[axis] - grid.low[axis]) / grid.edge)
    return int(np.clip(index, 0, grid.shape[axis] - 1))


def place_text(axis: int, place: float) -> str:
    """Return the place of a slice along one of the base's axes as text."""
    return f"{'xyz'[axis]} = {place * 1e3:.4g} mm".replace("-", "−")


def draw_cells(on: Axes, edge: float, x: Floats, y: Floats, classes: np.ndarray) -> None:
    """Draw the classes (x, y) of cells of this edge with these centres, m."""
    ends = [1e3 * np.append(each - edge / 2, each[-1] + edge / 2) for each in (x, y)]
    cells(on, ends[0], ends[1], classes)


def of_equal_scale(title: str, x: Floats, y: Floats) -> tuple[Figure, Axes]:
    """Return a figure whose axes have the same scale, as high as the cells with these centres
    need.
    """
    wide, tall = (max(float(np.ptp(each)), 1e-6) for each in (x, y))
    made, on = one(title, float(np.clip(AROUND + ACROSS * tall / wide, 70, 170)))
    on.set_aspect("equal")
    return made, on


def gain_plots(accuracy_map: WorkspaceMap, through: Floats) -> list[Plot]:
    """Return the slices of the gain through this point (3,), m; none for an open chain."""
    gain, grid = accuracy_map.gain, accuracy_map.reached.grid
    if gain is None:
        return []
    limits = class_limits(float(np.nanmin(gain)), float(np.nanmax(gain)))
    out = []
    for across, up in ((0, 1), (0, 2), (1, 2)):
        if gain.shape[across] == 1 or gain.shape[up] == 1:
            continue
        other, names = 3 - across - up, "xyz"[across] + "xyz"[up]
        index = index_at(grid, other, through)
        x, y = grid.centres_along(across), grid.centres_along(up)
        height = float(grid.centres_along(other)[index])
        made, on = of_equal_scale(
            f"Gain, {names[0]}-{names[1]} slice, {place_text(other, height)}", x, y
        )
        draw_cells(on, grid.edge, x, y, class_of(np.take(gain, index, axis=other), limits))
        label_axes(on, f"{names[0]} [mm]", f"{names[1]} [mm]")
        class_legend(made, limits, "gain over that at home")
        words = (
            f"Slice of the workspace in the {names[0]}-{names[1]} plane, in classes of the gain: "
            "how many times as far as at home an error of the drives moves the tool."
        )
        out.append(Plot(f"gain-{names}", "map", made, words))
    return out


def gain_rows(accuracy_map: WorkspaceMap) -> list[Row]:
    """Return the row of the largest gain; none for an open chain."""
    gain = accuracy_map.gain
    if gain is None:
        return []
    return [
        Row(
            "largest gain over that at home",
            (Cell(float(np.nanmax(gain)), "1"),),
            f"median of cells {float(np.nanmedian(gain)):.3g}; an error of the drives moves the "
            "tool so many times as far as at home. Beyond 5 poses are excluded",
        )
    ]
