"""Cubic grid cells of the workspace, with corners at integer multiples of their edge from the
base's origin, and poses by cell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.printed import round_number

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Default number of cells along the longest side of the workspace, before rounding of the edge.
_CELLS_ALONG: Final = 30
MOST_CELLS: Final = 2_000_000
# Share of the longest extent below which the tool cannot move along an axis.
_FLAT: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Grid:
    """Cubic cells (x, y, z) of one edge, m, in the base's axes.

    first   index of the first cell along each axis, counted from the base's origin
    shape   number of cells along each axis
    plane   (3,) constant coordinate of the tool along an axis that it cannot move along, m; else
            NaN. Such an axis has one cell, centred on it
    """

    edge: float
    first: tuple[int, int, int]
    shape: tuple[int, int, int]
    plane: tuple[float, float, float]

    @property
    def low(self) -> Floats:
        """Return the lower corner (3,) of the first cell, m."""
        return np.asarray(self.edge * np.array(self.first) + self._shift)

    @property
    def flat(self) -> np.ndarray:
        """Return which axes the tool cannot move along (3,)."""
        return np.array([math.isfinite(at) for at in self.plane])

    @property
    def _shift(self) -> Floats:
        return np.asarray(
            np.where(self.flat, np.nan_to_num(np.array(self.plane)) - self.edge / 2, 0.0)
        )

    @property
    def dimensions(self) -> int:
        """Return the number of axes that the tool can move along."""
        return 3 - int(self.flat.sum())

    @property
    def cell_size(self) -> float:
        """Return the size of a cell: m^3; for motion in a plane m^2, on a line m."""
        return float(self.edge**self.dimensions)

    def cell_numbers(self, points: Floats) -> np.ndarray:
        """Return the flat index (point,) of the cell that contains each point (point, 3); -1
        outside the grid.
        """
        at = self.indices(points)
        inside = ((at >= 0) & (at < np.array(self.shape))).all(axis=1)
        return np.asarray(
            np.where(
                inside,
                np.ravel_multi_index(tuple(np.where(inside.reshape(-1, 1), at, 0).T), self.shape),
                -1,
            )
        )

    def indices(self, points: Floats) -> np.ndarray:
        """Return the cell index along each axis (point, 3) for points (point, 3), beyond the grid
        as well.
        """
        # From the base's origin, so that grids of different extent have identical cells.
        return np.asarray(
            np.floor((points - self._shift) / self.edge).astype(np.int64) - np.array(self.first)
        )

    def centres(self, numbers: np.ndarray) -> Floats:
        """Return the centres (cell, 3) of these cells, m."""
        return np.asarray(
            self.edge
            * (np.array(self.first) + np.column_stack(np.unravel_index(numbers, self.shape)) + 0.5)
            + self._shift
        )

    def centres_along(self, axis: int) -> Floats:
        """Return the centres of the cells along an axis, m."""
        return np.asarray(
            self.edge * (self.first[axis] + np.arange(self.shape[axis]) + 0.5) + self._shift[axis]
        )

    def cropped_to(self, numbers: np.ndarray) -> Grid:
        """Return the smallest grid of the same cells that contains these cells."""
        at = np.column_stack(np.unravel_index(numbers, self.shape))
        low, high = at.min(axis=0), at.max(axis=0)
        first = tuple(int(a + b) for a, b in zip(self.first, low, strict=True))
        return Grid(self.edge, first, tuple(int(n) for n in high - low + 1), self.plane)  # type: ignore[arg-type]


def grid_around(points: Floats, edge: float | None = None, margin: float = 0.15) -> Grid:
    """Return a grid that contains these points (point, 3), with a margin as a share of their
    extent.

    `edge` None: about a thirtieth of the longest extent, rounded to 1, 2 or 5 times a power of ten.
    Raises InputError for an edge that is not positive, longer than the extent, or so small that
    there would be more than `MOST_CELLS` cells.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    extent = high - low
    longest = float(extent.max())
    if edge is None:
        edge = round_number(longest / _CELLS_ALONG) if longest > 0 else 0.1
    if not (math.isfinite(edge) and edge > 0):
        raise refuse_argument("cell", edge, "a length above zero, m", cell=0.05)
    if 0 < longest < edge:
        found = (
            f"{edge * 1e3:.4g} mm around a workspace of "
            f"{' x '.join(f'{x * 1e3:.4g}' for x in extent)} mm"
        )
        example = f"{longest * 1e3 / _CELLS_ALONG:.2g} mm"
        raise refuse_argument(
            "cell",
            found,
            f"an edge shorter than the workspace, {longest * 1e3:.4g} mm",
            cell=example,
        )
    flat = extent <= _FLAT * longest
    first = np.where(flat, 0, np.floor((low - margin * longest) / edge)).astype(float)
    count = np.where(flat, 1, np.floor((high + margin * longest) / edge) - first + 1)
    if float(count.prod()) > MOST_CELLS:
        least = edge * (float(count.prod()) / MOST_CELLS) ** (1 / max(int((~flat).sum()), 1))
        found = (
            f"{edge * 1e3:.4g} mm, {float(count.prod()):.3g} cells around a workspace of "
            f"{' x '.join(f'{x * 1e3:.4g}' for x in extent)} mm"
        )
        example = f"{math.ceil(least * 1e3 * 1.05):d} mm"
        raise refuse_argument(
            "cell",
            found,
            f"at most {MOST_CELLS} cells: edges of about {least * 1e3:.3g} mm or more",
            cell=example,
        )
    plane = tuple(
        float(a + b) / 2 if still else math.nan for a, b, still in zip(low, high, flat, strict=True)
    )
    return Grid(edge, tuple(int(n) for n in first), tuple(int(n) for n in count), plane)  # type: ignore[arg-type]


def dilated(cells: np.ndarray) -> np.ndarray:
    """Return these cells (x, y, z) and all that touch one of them, at least at a corner."""
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(cells, np.ones((3, 3, 3), bool)))


def interior(cells: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Return which of these cells (x, y, z) have all their neighbours among them, including
    diagonal ones; a flat axis has no neighbours.
    """
    from scipy.ndimage import binary_erosion

    return np.asarray(
        binary_erosion(cells, np.ones(tuple(1 if still else 3 for still in flat), bool))
    )


def mostly_enclosed(cells: np.ndarray, dimensions: int) -> np.ndarray:
    """Return these cells (x, y, z) and those with more than half of their faces adjacent to
    them.
    """
    from scipy.ndimage import convolve, generate_binary_structure

    faces = (
        convolve(
            cells.astype(np.int64),
            generate_binary_structure(3, 1).astype(np.int64),
            mode="constant",
        )
        - cells
    )
    return np.asarray(cells | (faces > dimensions))


@dataclass(frozen=True)
class CellPoses:
    """Poses by grid cell, sorted by cell and then in the order of discovery.

    q         (pose, joint) rad or m
    points    (pose, 3) position of the tool, m: the centre of the cell, or a point in it where the
              centre is out of reach
    cell      (pose,) flat index of the cell
    members   (pose,) index of the independent sample that the pose comes from
    brought   (pose,) whether the pose was moved from another cell by inverse kinematics
    sampled   number of sampled poses
    centre    (x, y, z) whether the centre of the cell was reached
    """

    grid: Grid
    q: Floats
    points: Floats
    cell: np.ndarray
    members: np.ndarray
    brought: np.ndarray
    sampled: int
    centre: np.ndarray

    @property
    def counts(self) -> np.ndarray:
        """Return the number of poses in each cell (x, y, z)."""
        return np.bincount(self.cell, minlength=int(np.prod(self.grid.shape))).reshape(
            self.grid.shape
        )
