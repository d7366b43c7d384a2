"""Accuracy map in a half plane through a vertical first axis that turns without limit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.maps.cell_statistics import CONFIGURATIONS, QUANTILE, cell_figures
from lostmotion.mechanism.vertical_axis import vertical_axis

if TYPE_CHECKING:
    from lostmotion.maps.accuracy_map import WorkspaceMap
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_TURN: Final = 2 * math.pi
_ROUNDING: Final = 1e-9


@dataclass(frozen=True, slots=True)
class RadialSection:
    """Quantile (r, z) over all poses at a distance r from the first axis and a height z, m, for the
    selected configuration; NaN if unreached.
    """

    r: Floats
    z: Floats
    values: Floats


def radial_section(accuracy_map: WorkspaceMap) -> RadialSection | None:
    """Return the quantile by distance from the first axis and height, over all azimuths; None
    unless that axis is vertical and turns fully.
    """
    axis = full_turn_axis(accuracy_map.arm)
    if axis is None:
        return None
    grid, points = accuracy_map.reached.grid, accuracy_map.reached.points
    at = np.floor(np.hypot(points[:, 0] - axis[0], points[:, 1] - axis[1]) / grid.edge).astype(int)
    rings, heights = int(at.max()) + 1, grid.shape[2]
    up = np.unravel_index(accuracy_map.reached.cell, grid.shape)[2]
    values = cell_figures(accuracy_map.evaluated.errors, at * heights + up, rings * heights)[
        QUANTILE, CONFIGURATIONS.index(accuracy_map.by)
    ]
    return RadialSection(
        np.asarray(grid.edge * (np.arange(rings) + 0.5), dtype=float),
        grid.centres_along(2),
        values.reshape(rings, heights),
    )


def full_turn_axis(arm: Arm) -> tuple[float, float] | None:
    """Return the position (x, y; m) of the first axis if it is vertical and turns through 360°;
    else None.
    """
    low, high = arm.driven[arm.tree.tool_joints[0]].limits
    return vertical_axis(arm) if high - low >= _TURN * (1 - _ROUNDING) else None
