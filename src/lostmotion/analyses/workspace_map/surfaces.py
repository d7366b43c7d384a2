"""Where does a field on a grid take a value? Triangles within cubes known at all corners; plotly's own isosurfaces take the unknown for zero.

Each cube is cut into six tetrahedra along its diagonal, in each of which the field is linear, so that surfaces have no holes but at the field's end.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# From one corner of the cube to the far one, an axis at a time, in each order of the axes: four corners each.
_TETRAHEDRA: Final = tuple(
    tuple(np.cumsum([(0, 0, 0), *(np.eye(3, dtype=int)[axis] for axis in order)], axis=0).tolist()) for order in itertools.permutations(range(3))
)


def level_surface(field: Floats, level: float) -> tuple[Floats, np.ndarray]:
    """Which triangles make the surface on which the field (x, y, z) has this value? (vertex, 3) in steps of the grid, and (triangle, 3) of these.

    NaN is unknown: no surface runs through a cube with such a corner.
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
        # Those above first, so that each case has its corners at known places.
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


# Two corners above and two below: four edges are crossed, two triangles between them.
_QUAD: Final = (((0, 2), (0, 3), (1, 3)), ((0, 2), (1, 3), (1, 2)))
