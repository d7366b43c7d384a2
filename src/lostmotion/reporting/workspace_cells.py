"""Cells of a workspace, each with the mean value of the poses nearest to it: of a plane cut, and in
space.

Where values do not depend on the angle about a vertical axis, poses are compared by their distance
from it and their height: all azimuths then count for each cell, and 16 poses lie much nearer to it
than in space.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Cells along the longest side of a workspace.
CELLS: Final = 44
# Poses whose mean value a cell has.
NEAREST: Final = 16


# Position (x, y) of a vertical axis in the base's axes, m; None without one.
Axis: TypeAlias = tuple[float, float] | None


def cells_of_cut(
    points: Floats,
    tool: Floats,
    values: Floats,
    view: Floats,
    depth: float,
    edge: float,
    axis: Axis = None,
) -> tuple[Floats, Floats, Floats]:
    """Return the edges of the cells of a cut across and upwards, m, and their values (across, up);
    NaN where no point of the workspace is.

    points  (point, 3) m, of the workspace
    tool    (pose, 3) m, with their values (pose,)
    view    (3, 3) directions to the right, upwards and towards the viewer; the cut is at this depth
            along the last, m
    edge    of a cell, m
    axis    vertical axis about which the values do not change
    """
    near = np.concatenate([points, tool])  # never empty: the plane contains the tool of one pose
    inside = near[np.abs(near @ view[2] - depth) <= edge] @ view[:2].T
    across, up = (
        np.arange(math.floor(low / edge), math.floor(high / edge) + 2) * edge
        for low, high in zip(inside.min(0), inside.max(0), strict=True)
    )
    reached = _closed(np.histogram2d(inside[:, 0], inside[:, 1], bins=(across, up))[0] > 0)
    column, row = np.nonzero(reached)
    centres = (
        np.column_stack([across[column] + edge / 2, up[row] + edge / 2, np.full(len(row), depth)])
        @ view
    )
    out = np.full(reached.shape, np.nan)
    out[column, row] = _near(tool, values, centres, axis)
    return across, up, out


def cells_in_space(
    points: Floats, tool: Floats, values: Floats, edge: float, axis: Axis = None
) -> tuple[Floats, Floats]:
    """Return the corner (3,) of the first cell, m, and the values (x, y, z) of cubic cells; NaN
    where no point of the workspace is.

    Arguments as for `cells_of_cut`. The cells lie symmetrically about the middle of the workspace,
    so those of a flat one lie symmetrically about it.
    """
    near = np.concatenate([points, tool])
    low, high = near.min(axis=0), near.max(axis=0)
    # the last bits of a length add no cell
    shape = np.maximum(np.ceil((high - low) / edge - 1e-9).astype(int), 1)
    first = (low + high - shape * edge) / 2
    reached = np.zeros(shape, bool)
    reached[tuple(np.clip((near - first) / edge, 0, shape - 1).astype(int).T)] = True
    reached = _closed(reached)
    cell = np.nonzero(reached)
    out = np.full(shape, np.nan)
    out[cell] = _near(tool, values, first + edge * (np.column_stack(cell) + 0.5), axis)
    return first, out


def _closed(reached: np.ndarray) -> np.ndarray:
    """Return which cells count as reached: gaps between sampled points are closed."""
    from scipy.ndimage import binary_closing

    around = np.pad(reached, 1)
    inner = (slice(1, -1),) * reached.ndim
    return np.asarray(reached | binary_closing(around, np.ones((3,) * reached.ndim, bool))[inner])


def _near(tool: Floats, values: Floats, centres: Floats, axis: Axis) -> Floats:
    """Return the mean value over the poses nearest to each centre (cell, 3)."""
    from scipy.spatial import KDTree

    if axis is not None:
        tool, centres = (
            np.column_stack([np.hypot(at[:, 0] - axis[0], at[:, 1] - axis[1]), at[:, 2]])
            for at in (tool, centres)
        )
    of_poses = KDTree(tool).query(centres, k=np.arange(1, min(NEAREST, len(tool)) + 1))[1]
    return np.asarray(values[of_poses].mean(axis=1))
