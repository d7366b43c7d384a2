"""One bearing, or a pair, under one load: the clearance it works with, what each element carries,
how far the shaft gives and how stiff it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.laws.rolling.equilibrium import shaft_equilibrium

if TYPE_CHECKING:
    from lostmotion.laws.rolling.equilibrium import ShaftEquilibrium
    from lostmotion.parts.bearing.rolling_contact import DrawnBearing
    from lostmotion.spatial import Floats

# Points of a curve over the load.
_POINTS: Final = 33
# Stiffness below this share of the largest counts as none: nothing holds there.
_FREE: Final = 1e-9


@dataclass(frozen=True, slots=True)
class BearingLoad:
    """Load of the shaft midway between its bearings: radial and axial force (N), and a moment in
    the plane of both (N m).
    """

    radial: float = 0.0
    axial: float = 0.0
    moment: float = 0.0

    @property
    def row(self) -> Floats:
        """Return the load vector (5,) of `shaft_equilibrium`: the radial force along x; a positive
        moment lifts the outboard end along x.
        """
        return np.array([self.radial, 0.0, self.axial, 0.0, self.moment])


@dataclass(frozen=True)
class ShiftCurve:
    """Shift of the shaft (clearance, load; m) under increasing loads (load,; N), at the lowest,
    mean and highest working clearance.
    """

    loads: Floats
    shifts: Floats


@dataclass(frozen=True)
class Examined:
    """Results of a bearing under a load.

    clearances  (3,) m: the lowest, mean and highest working clearance
    settled     the shaft under the load at each of them
    stiffness   (5,) N/m across, across, along, N m/rad about both: in one direction with the others
                unconstrained; 0 where unsupported
    pressure    (3,) Pa, of the most heavily loaded element
    """

    bearing: DrawnBearing
    load: BearingLoad
    count: int
    seed: int
    clearances: Floats
    samples: dict[str, Floats]
    settled: ShaftEquilibrium
    stiffness: Floats
    pressure: Floats
    radial: ShiftCurve
    axial: ShiftCurve | None

    @property
    def row_names(self) -> tuple[str, ...]:
        """Return the names of the rows in the order of their loads, by where they stand along the
        axis.
        """
        seats = self.bearing.rows.seats
        if len(seats) == 1:
            return (f"{self.bearing.elements}s",)
        return tuple("outboard" if seat.at > 0 else "inboard" for seat in seats)


def examine(bearing: DrawnBearing, load: BearingLoad, count: int = 1000, seed: int = 1) -> Examined:
    """Return the behaviour of this bearing under this load. `count` bearings are simulated for its
    clearance, the same for the same seed.

    Raises InputError for an axial load on bearings that carry none.
    """
    pair = bearing.rows
    if load.axial and not pair.axial:
        raise refuse_argument(
            "force_axial",
            f"{load.axial:g} N",
            "none: cylindrical rollers carry no axial load",
            force_axial="0 N",
        )
    spread = bearing.spreads["working"]
    clearances = np.array([spread.lowest, spread.mean, spread.highest])
    settled = shaft_equilibrium(pair.seats, np.tile(load.row, (3, 1)), clearances)
    hardest = np.max([each.max(axis=1) for each in settled.loads], axis=0)
    scale = max(abs(load.radial), abs(load.axial), 2 * abs(load.moment) / pair.span, 1.0)
    return Examined(
        bearing,
        load,
        count,
        seed,
        clearances,
        bearing.sample(count, seed),
        settled,
        _held(settled.stiffness[1]),
        bearing.pressure(hardest),
        _curve(bearing, clearances, 0, 1.5 * scale),
        _curve(bearing, clearances, 2, 1.5 * scale) if pair.axial else None,
    )


def _held(slope: Floats) -> Floats:
    """Return the stiffness (5,) in each direction with the others unconstrained, from the slope of
    the load (5, 5); NaN where there is none.
    """
    if not np.isfinite(slope).all():
        return np.full(5, np.nan)
    size = np.sqrt(np.abs(np.diag(slope)))
    held = size > _FREE * size.max()
    out = np.zeros(5)
    if held.any():
        # Scaled, so that N/m and N m/rad have equal weight.
        scaled = slope[np.ix_(held, held)] / np.outer(size[held], size[held])
        values, vectors = np.linalg.eigh(scaled)
        soft = ((vectors**2) / np.maximum(values, _FREE)).sum(axis=1)
        out[held] = size[held] ** 2 / soft
    return np.where(out > _FREE * 10 * size**2, out, 0.0)


def _curve(bearing: DrawnBearing, clearances: Floats, way: int, top: float) -> ShiftCurve:
    """Return the shift in one direction under increasing load in it, with more points at light
    loads.
    """
    loads = top * np.linspace(0, 1, _POINTS) ** 2
    cases = np.zeros((3, _POINTS, 5))
    cases[:, :, way] = np.maximum(loads, 1e-6 * top)
    settled = shaft_equilibrium(
        bearing.rows.seats, cases.reshape(-1, 5), np.repeat(clearances, _POINTS)
    )
    return ShiftCurve(loads, settled.displacement[:, way].reshape(3, _POINTS))
