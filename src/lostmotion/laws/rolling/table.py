"""Displacement of a shaft on two rows of rolling elements by interpolation in a table, in
microseconds per load instead of a Newton solution.

The displacement of a row depends on its radial reaction, which follows from statics, and on its
part of the axial force; its own tilt has little effect. So the shaft's displacement follows from
three numbers: the magnitudes of the two radial reactions, in whatever directions, and the axial
force. `shaft_equilibrium` fills the table. One row of crossed rollers is such a pair too: its two
families of rollers act pitch diameter x tan(lean) apart.

Exact where the rows carry no moment of their own and have many elements.
tests/laws/test_rolling_table.py measures the error for few balls and for wide rows. The result is
the mean over angular positions of the elements. The pair must be symmetric about its centre.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.rolling.equilibrium import shaft_equilibrium
from lostmotion.laws.rolling.rows import BallRow, CrossedRow, RollerRow, RowSeat

if TYPE_CHECKING:
    from scipy.interpolate import NdBSpline

    from lostmotion.spatial import Floats

# Numbers of nodes over the magnitude of the load, its split between the rows, and its axial part.
_NODES: Final = (17, 11, 13)
# With one shoulder per row, the load passes from one row to the other within a few degrees.
_NODES_ANGULAR: Final = (17, 15, 17)
# With crossed rollers the load passes from one family to the other within a few degrees. Their
# contacts are solved faster.
_NODES_CROSSED: Final = (17, 21, 21)
# Exponent by which nodes are concentrated near zero axial load.
_DENSER: Final = 1.5
# Rotation, as a share of the spacing of the elements, at which the displacements equal their
# average over a turn.
_BETWEEN: Final = 0.25
# Lowest load of the table over the largest: it closes any clearance with negligible deformation.
BOTTOM: Final = 1e-8
# A negative clearance beyond this (m) is a preload; a smaller one is lost under loads far below
# those of the table.
_LEAST_PRELOAD: Final = 3e-7
# Distance (rad) of the edge of the table from a row without load, which would be free in its
# clearance.
RIM: Final = 2e-3


@dataclass(frozen=True, slots=True)
class Pair:
    """Two rows of rolling elements, or one row of crossed rollers.

    seats  the rows on the shaft
    span   distance between the points where their forces intersect the axis, m
    axial  whether they carry axial load
    """

    seats: tuple[RowSeat, ...]
    span: float
    axial: bool

    @property
    def exponent(self) -> float:
        """Return n of the contacts, Q = K delta^n."""
        return self.seats[0].row.spring[1]

    def turned(self, share: float) -> Pair:
        """Return this pair with its elements rotated by a share of their spacing."""
        return replace(
            self, seats=tuple(replace(seat, row=_turned(seat.row, share)) for seat in self.seats)
        )

    def solve(
        self, behind: Floats, ahead: Floats, along: Floats, clearance: float
    ) -> tuple[Floats, Floats, Floats]:
        """Return the radial displacements of the rows behind and ahead and the axial displacement
        of the shaft (load,), m.

        behind, ahead  (load,) radial reactions of the rows in one plane, N
        along          (load,) axial force, N
        clearance      of both rows, m

        Raises DidNotConvergeError for a load without equilibrium.
        """
        zero = np.zeros_like(behind)
        loads = np.stack(
            [behind + ahead, zero, along, zero, (ahead - behind) * self.span / 2], axis=-1
        )
        found = shaft_equilibrium(self.seats, loads, clearance)
        if not found.converged.all():
            failed = (
                "no equilibrium of a shaft on its bearings in "
                f"{np.count_nonzero(~found.converged)} of {len(loads)} cases"
            )
            raise DidNotConvergeError(
                f"{failed}, the largest load among them "
                f"{np.abs(loads[~found.converged][:, :3]).max():.4g} N\n  check these loads"
            )
        x, z, tilt = found.displacement[:, 0], found.displacement[:, 2], found.displacement[:, 4]
        return x - tilt * self.span / 2, x + tilt * self.span / 2, z


def _turned(row: object, share: float) -> BallRow | RollerRow | CrossedRow:
    if not isinstance(row, BallRow | RollerRow | CrossedRow):
        raise TypeError(f"no row of rolling elements: {type(row).__name__}")
    return replace(row, first=row.first + share * 2 * math.pi / row.count)


def _nodes(row: object) -> tuple[int, int, int]:
    if isinstance(row, CrossedRow):
        return _NODES_CROSSED
    return _NODES_ANGULAR if isinstance(row, BallRow) and row.contact_angle else _NODES


class ShiftTable:
    """Displacements of a pair at one clearance (m), for loads up to `top` (N, all reactions
    together); larger loads are solved one by one.
    """

    def __init__(self, pair: Pair, clearance: float, top: float) -> None:
        """Fill the table. Raises DidNotConvergeError for a load without equilibrium, ValueError for
        a `top` that is not positive and finite.
        """
        from scipy.interpolate import NdBSpline, make_interp_spline

        if not (math.isfinite(top) and top > 0):
            raise ValueError(f"the largest load of a table must be positive and finite, not {top}")
        self.pair, self.clearance, self.top = pair, clearance, top
        self._exponent = pair.exponent
        nodes = _nodes(pair.seats[0].row)
        axes = [np.linspace(0, 1, nodes[0]), np.linspace(RIM, math.pi / 2 - RIM, nodes[1])]
        if pair.axial:
            # Denser near zero axial load, where the axial displacement changes fastest.
            axes.append((math.pi / 2 - RIM) * np.linspace(0, 1, nodes[2]) ** _DENSER)
        grid = np.meshgrid(*axes, indexing="ij")
        behind, ahead, along = self._loads(
            grid[0].ravel(),
            grid[1].ravel(),
            grid[2].ravel() if pair.axial else np.zeros(grid[0].size),
        )
        values = np.stack(pair.turned(_BETWEEN).solve(behind, ahead, along, clearance), axis=-1)
        coefficients = values.reshape(*grid[0].shape, 3) / self._growth(grid[0])[..., None]
        if pair.axial:
            # Negative axial forces by symmetry: rows and axial direction are exchanged.
            mirrored = coefficients[:, ::-1, :0:-1][..., [1, 0, 2]] * [1, 1, -1]
            coefficients = np.concatenate([mirrored, coefficients], axis=2)
            axes[2] = np.concatenate([-axes[2][:0:-1], axes[2]])
        knots = []
        for dimension, places in enumerate(axes):
            spline = make_interp_spline(places, coefficients, k=3, axis=dimension)
            coefficients = np.moveaxis(spline.c, 0, dimension)
            knots.append(spline.t)
        self.spline: NdBSpline = NdBSpline(tuple(knots), coefficients, 3)

    def shifts(self, behind: Floats, ahead: Floats, along: Floats) -> Floats:
        """Return the displacements of the rows behind and ahead along their reactions, and of the
        shaft along its axis: (load, 3), m.

        behind, ahead  (load,) magnitudes of the radial reactions, N
        along          (load,) axial force, signed, N
        """
        size, split, lean = self.coordinates(behind, ahead, along)
        out = self._at(np.minimum(size, 1.0), split, lean)
        beyond = size > 1
        if beyond.any():
            out[beyond] = np.stack(
                self.pair.solve(behind[beyond], ahead[beyond], along[beyond], self.clearance),
                axis=-1,
            )
        return out

    def edges(self, behind: Floats, ahead: Floats, along: Floats) -> Floats:
        """Return the displacements (load, 3), m, at which these loads begin to deform the contacts:
        at the edge of the clearance; zero without it.
        """
        _, split, lean = self.coordinates(behind, ahead, along)
        if self.clearance <= 0:
            return np.zeros((len(split), 3))
        found = self._at(np.zeros_like(split), split, lean)
        # The interpolation overshoots slightly at corners of the edge; the shaft never moves
        # against its load.
        found[:, :2] = np.maximum(found[:, :2], 0.0)
        return found

    def _at(self, size: Floats, split: Floats, lean: Floats) -> Floats:
        split = np.clip(split, RIM, math.pi / 2 - RIM)
        points = [size, split]
        if self.pair.axial:
            points.append(np.clip(lean, RIM - math.pi / 2, math.pi / 2 - RIM))
        return np.asarray(self.spline(np.stack(points, axis=-1)) * self._growth(size)[:, None])

    @property
    def preloaded(self) -> bool:
        """Return whether the rows are preloaded."""
        return self.clearance <= -_LEAST_PRELOAD or (
            self.clearance <= 0 and any(seat.preload_shift for seat in self.pair.seats)
        )

    def _growth(self, size: Floats) -> Floats:
        """Return the factor by which displacements grow with the load; the table stores their ratio
        to it, for accuracy under light loads.

        Preloaded rows deform in proportion to a light load. With clearance, or rows that just
        touch, the factor is one: a row without load is free to move, so displacements do not vanish
        with the load.
        """
        if not self.preloaded:
            return np.ones_like(size)
        return np.asarray(
            np.maximum(size, BOTTOM ** (1 / self._exponent / 2)) ** (2 * self._exponent)
        )

    def coordinates(
        self, behind: Floats, ahead: Floats, along: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Return magnitude (1 at the edge of the table) and direction of loads.

        Components are taken to the power 1/n of the contacts, in which displacements are nearly
        linear.
        """
        power = 1 / self._exponent
        one, two, axial = behind**power, ahead**power, np.sign(along) * np.abs(along) ** power
        whole = np.sqrt(one**2 + two**2 + axial**2)
        return (
            np.sqrt(whole / self.top**power),
            np.arctan2(two, one),
            np.arctan2(axial, np.hypot(one, two)),
        )

    def _loads(self, size: Floats, split: Floats, lean: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the loads at the nodes: the inverse of `coordinates`."""
        power = self._exponent
        whole = np.maximum(size**2, BOTTOM ** (1 / power)) * self.top ** (1 / power)
        one, two = whole * np.cos(lean) * np.cos(split), whole * np.cos(lean) * np.sin(split)
        axial = whole * np.sin(lean)
        return one**power, two**power, np.sign(axial) * np.abs(axial) ** power


@functools.lru_cache(maxsize=64)
def shift_table(pair: Pair, clearance: float, top: float) -> ShiftTable:
    """Return the table of this pair, cached for all joints with the same bearings. Arguments and
    errors as `ShiftTable`.
    """
    return ShiftTable(pair, clearance, top)
