"""What the slices of a map share: their place, and axes of equal scale."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.reporting.chart import one
from lostmotion.reporting.map_chart import cells

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
