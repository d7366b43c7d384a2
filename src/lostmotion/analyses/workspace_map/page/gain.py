"""The gain of a closed chain over its workspace: slices beside those of the error."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.analyses.workspace_map.page.slices import (
    draw_cells,
    index_at,
    of_equal_scale,
    place_text,
)
from lostmotion.reporting.chart import label_axes
from lostmotion.reporting.map_chart import class_legend, class_of
from lostmotion.reporting.palette import class_limits
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Cell, Row

if TYPE_CHECKING:
    from lostmotion.maps.accuracy_map import WorkspaceMap
    from lostmotion.spatial import Floats


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
