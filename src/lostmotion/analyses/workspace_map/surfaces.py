"""Isosurfaces of a field on a grid that may have unknown values.

Each cube is cut into six tetrahedra along its diagonal, in which the field is linear, so that surfaces have no holes except at the field's boundary.
Plotly's own isosurfaces treat unknown values as zero.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Paths from one corner of the cube to the opposite one, an axis at a time, in each order of the axes: four corners each.
_TETRAHEDRA: Final = tuple(
    tuple(np.cumsum([(0, 0, 0), *(np.eye(3, dtype=int)[axis] for axis in order)], axis=0).tolist()) for order in itertools.permutations(range(3))
)


def level_surface(field: Floats, level: float) -> tuple[Floats, np.ndarray]:
    """Return the triangles of the isosurface of the field (x, y, z) at this level.

    Vertices (vertex, 3) in grid steps, and their indices (triangle, 3). Cubes with a NaN at a corner contain no surface.
    """
    shape = np.array(field.shape)
    if (shape < 2).any():  # noqa: PLR2004 - a cube has two corners along each axis
        return np.zeros((0, 3)), np.zeros((0, 3), int)
    numbers = np.arange(field.size).reshape(field.shape)
    flat = field.ravel()
    edges: list[np.ndarray] = []  # (triangle, 3, 2): the two grid points between which each vertex lies
    for corners in _TETRAHEDRA:
        at = np.stack([numbers[tuple(slice(c, int(n) - 1 + c) for c, n in zip(corner, shape, strict=True))].ravel() for corner in corners], axis=1)
        values = flat[at]
        above = values > level
        crossed = np.isfinite(values).all(axis=1) & above.any(axis=1) & ~above.all(axis=1)
        at, above = at[crossed], above[crossed]
        count = above.sum(axis=1)
        # Corners above the level first, so that each case has its corners at fixed positions.
        at = np.take_along_axis(at, np.argsort(~above, axis=1, kind="stable"), axis=1)
        for number, triangles in ((1, (((0, 1), (0, 2), (0, 3)),)), (3, (((3, 0), (3, 1), (3, 2)),)), (2, _QUAD)):
            mine = at[count == number]
            edges += [np.stack([mine[:, list(ends)] for ends in triangle], axis=1) for triangle in triangles]
    ends = np.sort(np.concatenate(edges).reshape(-1, 2), axis=1)
    unique, faces = np.unique(ends, axis=0, return_inverse=True)
    low, high = flat[unique[:, 0]], flat[unique[:, 1]]
    share = ((level - low) / (high - low))[:, None]
    first, second = (np.column_stack(np.unravel_index(unique[:, k], field.shape)) for k in range(2))
    return np.asarray(first + share * (second - first)), faces.reshape(-1, 3)


# Two corners above and two below: two triangles between the four crossed edges.
_QUAD: Final = (((0, 2), (0, 3), (1, 3)), ((0, 2), (1, 3), (1, 2)))
