"""Fields of a meshed wheel as a picture: on a square of pixels, and the outline of the mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.finite_elements.wheel import Field
    from lostmotion.spatial import Floats

# Pixels on the side of a triangle belong to it.
_EDGE: Final = 1e-9


def raster(
    field: Field, values: Floats, left: float, low: float, right: float, pixels: int
) -> Floats:
    """Return a field (point,) on a square of pixels (row, column), NaN outside of the body; peaks
    between pixels are kept as their pixel's value.
    """
    step = (right - left) / pixels
    at = (field.points - [left, low]) / step - 0.5
    out = np.full((pixels, pixels), np.nan)
    corners = at[field.triangles]
    inside = (corners.max(axis=1) >= 0).all(axis=1) & (corners.min(axis=1) <= pixels - 1).all(
        axis=1
    )
    for triangle, corner in zip(field.triangles[inside], corners[inside], strict=True):
        (x0, y0), (x1, y1) = (
            np.maximum(np.ceil(corner.min(axis=0)), 0).astype(int),
            np.minimum(np.floor(corner.max(axis=0)), pixels - 1).astype(int),
        )
        if x1 < x0 or y1 < y0:
            continue
        y, x = np.mgrid[y0 : y1 + 1, x0 : x1 + 1]
        a, b, c = corner
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
        third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
        within = (second >= -_EDGE) & (third >= -_EDGE) & (second + third <= 1 + _EDGE)
        first, of_second, of_third = values[triangle]
        out[y[within], x[within]] = (
            first + second * (of_second - first) + third * (of_third - first)
        )[within]
    column, row = np.round(at).astype(int).T
    seen = (column >= 0) & (column < pixels) & (row >= 0) & (row < pixels)
    np.fmax.at(out, (row[seen], column[seen]), values[seen])
    return out


def outline(field: Field, points: Floats, spacing: float) -> Floats:
    """Return the closed boundaries of a mesh, with points no closer than `spacing`, as lines
    (point, 2) with gaps of NaN.
    """
    sides = np.concatenate([field.triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    _, first, times = np.unique(
        np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True
    )
    after = dict(sides[first[times == 1]].tolist())
    lines = []
    while after:
        start, here = after.popitem()
        line = [points[start]]
        while here != start:
            if float(np.abs(points[here] - line[-1]).max()) > spacing:
                line.append(points[here])
            here = after.pop(here)
        lines += [*line, line[0], np.full(2, np.nan)]
    return np.array(lines)
