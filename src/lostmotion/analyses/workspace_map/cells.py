"""Which cell of a grid does a tool point lie in? Cubes with their corners at whole multiples of their edge from the base's origin."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Cells along the longest side of the workspace where nothing is asked for, before rounding to 1, 2 or 5 times a power of ten.
_CELLS_ALONG: Final = 30
MOST_CELLS: Final = 2_000_000
# An axis along which tool points differ by less than this share of the longest extent is one that the tool cannot move along.
_FLAT: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Grid:
    """Cubic cells (x, y, z) of one edge, m, in the base's axes.

    first   number of the first cell along each axis, counted from the base's origin
    shape   how many cells along each axis
    plane   (3,) where along an axis the tool stays, m, if it cannot move along it; NaN for the others. Such an axis has one cell, with the tool in
            its middle
    """

    edge: float
    first: tuple[int, int, int]
    shape: tuple[int, int, int]
    plane: tuple[float, float, float]

    @property
    def low(self) -> Floats:
        """Give the corner (3,) of the first cell, m."""
        return np.asarray(self.edge * np.array(self.first) + self._shift)

    @property
    def flat(self) -> np.ndarray:
        """Tell which axes the tool cannot move along (3,)."""
        return np.array([math.isfinite(at) for at in self.plane])

    @property
    def _shift(self) -> Floats:
        return np.asarray(np.where(self.flat, np.nan_to_num(np.array(self.plane)) - self.edge / 2, 0.0))

    @property
    def dimensions(self) -> int:
        """Tell along how many axes the tool can move."""
        return 3 - int(self.flat.sum())

    @property
    def cell_size(self) -> float:
        """Give the size of a cell: m^3, of a tool that stays in a plane m^2, on a line m."""
        return float(self.edge**self.dimensions)

    def number(self, points: Floats) -> np.ndarray:
        """Which cell holds each of these points (point, 3)? The cell's number (point,), row by row, -1 outside the grid."""
        at = self.steps(points)
        inside = ((at >= 0) & (at < np.array(self.shape))).all(axis=1)
        return np.asarray(np.where(inside, np.ravel_multi_index(tuple(np.where(inside.reshape(-1, 1), at, 0).T), self.shape), -1))

    def steps(self, points: Floats) -> np.ndarray:
        """Which cell along each axis holds these points (point, 3)? Whole numbers (point, 3), beyond the grid as well."""
        # From the base's origin, so that a grid of other extent has the same cells to the last bit.
        return np.asarray(np.floor((points - self._shift) / self.edge).astype(np.int64) - np.array(self.first))

    def centres(self, numbers: np.ndarray) -> Floats:
        """Give the middles (cell, 3) of these cells, m."""
        return np.asarray(self.edge * (np.array(self.first) + np.column_stack(np.unravel_index(numbers, self.shape)) + 0.5) + self._shift)

    def along(self, axis: int) -> Floats:
        """Give the middles of the cells along an axis, m."""
        return np.asarray(self.edge * (self.first[axis] + np.arange(self.shape[axis]) + 0.5) + self._shift[axis])

    def around(self, numbers: np.ndarray) -> Grid:
        """Give the smallest grid of the same cells that holds these cells."""
        at = np.column_stack(np.unravel_index(numbers, self.shape))
        low, high = at.min(axis=0), at.max(axis=0)
        first = tuple(int(a + b) for a, b in zip(self.first, low, strict=True))
        return Grid(self.edge, first, tuple(int(n) for n in high - low + 1), self.plane)  # type: ignore[arg-type]


def grid_over(points: Floats, edge: float | None = None, margin: float = 0.15) -> Grid:
    """Which grid holds these points (point, 3) with a margin, a share of their extent, around them?

    `edge` left out: about a thirtieth of the longest extent, rounded to 1, 2 or 5 times a power of ten. Raises InputError for an edge that is not a
    positive length, longer than all of the extent, or so small that there would be more than `MOST_CELLS` cells.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    extent = high - low
    longest = float(extent.max())
    if edge is None:
        edge = _round(longest / _CELLS_ALONG) if longest > 0 else 0.1
    if not (math.isfinite(edge) and edge > 0):
        raise refuse_argument("cell", edge, "a length above zero, m", cell=0.05)
    if 0 < longest < edge:
        found = f"{edge * 1e3:.4g} mm around a workspace of {' x '.join(f'{x * 1e3:.4g}' for x in extent)} mm"
        example = f"{longest * 1e3 / _CELLS_ALONG:.2g} mm"
        raise refuse_argument(
            "cell", found, f"an edge shorter than the workspace, {longest * 1e3:.4g} mm: one cell tells no places apart", cell=example
        )
    flat = extent <= _FLAT * longest
    first = np.where(flat, 0, np.floor((low - margin * longest) / edge)).astype(float)
    count = np.where(flat, 1, np.floor((high + margin * longest) / edge) - first + 1)
    if float(count.prod()) > MOST_CELLS:
        least = edge * (float(count.prod()) / MOST_CELLS) ** (1 / max(int((~flat).sum()), 1))
        found = f"{edge * 1e3:.4g} mm, {float(count.prod()):.3g} cells around a workspace of {' x '.join(f'{x * 1e3:.4g}' for x in extent)} mm"
        example = f"{math.ceil(least * 1e3 * 1.05):d} mm"
        raise refuse_argument("cell", found, f"at most {MOST_CELLS} cells: edges of about {least * 1e3:.3g} mm or more", cell=example)
    plane = tuple(float(a + b) / 2 if still else math.nan for a, b, still in zip(low, high, flat, strict=True))
    return Grid(edge, tuple(int(n) for n in first), tuple(int(n) for n in count), plane)  # type: ignore[arg-type]


def _round(length: float) -> float:
    """Round a length to the nearest of 1, 2 and 5 times a power of ten, by ratio."""
    power = 10.0 ** math.floor(math.log10(length))
    return min((step * power for step in (1.0, 2.0, 5.0, 10.0)), key=lambda step: abs(math.log(step / length)))


def near(cells: np.ndarray) -> np.ndarray:
    """Which cells (x, y, z) are these or touch one of them, at a corner at least?"""
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(cells, np.ones((3, 3, 3), bool)))


def within(cells: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Which of these cells (x, y, z) have all their neighbours among them, at corners too? Along a flat axis there are none."""
    from scipy.ndimage import binary_erosion

    return np.asarray(binary_erosion(cells, np.ones(tuple(1 if still else 3 for still in flat), bool)))


def amid(cells: np.ndarray, dimensions: int) -> np.ndarray:
    """Which cells (x, y, z) are these, or have more than half of their faces towards them?"""
    from scipy.ndimage import convolve, generate_binary_structure

    faces = convolve(cells.astype(np.int64), generate_binary_structure(3, 1).astype(np.int64), mode="constant") - cells
    return np.asarray(cells | (faces > dimensions))
