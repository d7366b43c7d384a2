"""The form of a shaft on rolling elements: shifts tabulated over the radial loads of its two rows
and the axial load.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.parts.play import AnySeat, InPlay
from lostmotion.parts.term import rows_times

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.rolling.table import ShiftTable
    from lostmotion.parts.play import Seat
    from lostmotion.parts.term import Condition, Threshold
    from lostmotion.spatial import Floats

# Number of the axial seat, after the two rows.
_AXIS: Final = 2
# Change of load, as a share of the whole load, over which a slope of the table is taken.
_STEP: Final = 1e-3
# Length that turns a moment into a force, m: about the distance between the bearings of a joint.
_LEVER: Final = 0.1


@dataclass(frozen=True, eq=False)
class ShaftOnRows:
    """A shaft on two rows of rolling elements, and the table of its shifts under load.

    seats   the row behind, the row ahead, and the axial seat
    axial   whether the rows support the shaft along its axis
    table   shifts over the two radial loads and the axial force
    wider   the same table at a clearance larger by `step` (m); None where the clearance does not
            scatter
    """

    seats: tuple[Seat, Seat, Seat]
    axial: bool
    table: ShiftTable
    wider: ShiftTable | None
    step: float

    def loads(self, at: Condition) -> tuple[Floats, Floats, Floats]:
        """Return the sizes of the two radial loads and the axial force with its sign, each (pose,),
        N.
        """
        behind, ahead, along = self.seats
        return (
            behind.load_size(at),
            ahead.load_size(at),
            along.load(at)[0] if self.axial else np.zeros(len(at.angle)),
        )

    def shifts(self, at: Condition) -> tuple[Floats, Floats, Floats]:
        """Return the shift along each load, its part up to the edge of the play (both m), and its
        growth per metre of clearance; each (3, pose).
        """
        return at.once(self, lambda: self._shifts(at))

    def _shifts(self, at: Condition) -> tuple[Floats, Floats, Floats]:
        loads = self.loads(at)
        whole = self.table.shifts(*loads)
        grows = (
            np.zeros_like(whole)
            if self.wider is None
            else (self.wider.shifts(*loads) - whole) / self.step
        )
        return whole.T, self.table.edges(*loads).T, grows.T

    def slopes(self, at: Condition) -> Floats:
        """Return the derivative of the deflection along each load by each load (3, 3, pose), m/N:
        central differences over ±0.1 % of the load.
        """
        return at.once((self, "slopes"), lambda: self._slopes(at))

    def least(self, at: Condition) -> Floats:
        """Return the smallest load (pose,), N, at which a deflection is taken: 0.1 % of the whole
        load, and at least 0.001 N.

        An unloaded contact between rolling elements has no stiffness.
        """
        size = (
            np.sqrt((at.wrench[3:] ** 2).sum(axis=0))
            + np.sqrt((at.wrench[:3] ** 2).sum(axis=0)) / _LEVER
        )
        return np.asarray(_STEP * np.maximum(size, 1.0))

    def _slopes(self, at: Condition) -> Floats:
        loads, step = self.loads(at), self.least(at)
        out = np.zeros((3, 3, len(step)))
        for j in range(3 if self.axial else _AXIS):
            ahead, behind = (
                self._deflection([load + sign * step * (k == j) for k, load in enumerate(loads)])
                for sign in (1.0, -1.0)
            )
            out[:, j] = (ahead - behind) / (2 * step)
        return out

    def turning(self, row: int, at: Condition) -> Floats:
        """Return the deflection of a row per radial load (pose,), m/N: its compliance to a force
        across the load, which only turns the load.
        """
        loads = list(self.loads(at))
        loads[row] = np.maximum(loads[row], self.least(at))
        return np.asarray(self._deflection(loads)[row] / loads[row])

    def _deflection(self, loads: Sequence[Floats]) -> Floats:
        """Return the deflection along each load beyond the edge of the play (3, load), for radial
        loads of either sign.
        """
        behind, ahead, along = loads
        sizes = np.abs(behind), np.abs(ahead), along
        out = (self.table.shifts(*sizes) - self.table.edges(*sizes)).T
        out[:2] *= np.where(np.stack([behind, ahead]) < 0, -1.0, 1.0)
        return out


@dataclass(frozen=True, eq=False)
class LoadTable(InPlay):
    """One part of the shift of a shaft, at one of its seats (`row`): 0 and 1 are the rows, 2 is the
    axis. `state` selects the part.

    deflects  elastic shift along the load, beyond the edge of the play
    held      shift along the load to the edge of the play, where the load closes it
    grows     change of the closed position per metre of clearance
    free      unit shift along a fixed `direction` (6,), where no load closes its play
    """

    shaft: ShaftOnRows
    state: Literal["deflects", "held", "grows", "free"]
    row: int
    direction: Floats | None = None

    @property
    def elastic(self) -> bool:
        """Return whether it is a spring."""
        return self.state == "deflects"

    @functools.cached_property
    def decides(self) -> Threshold | None:
        """Return the seat of the row, all seats for a free play, and None for the elastic shift."""
        return (
            None
            if self.elastic
            else AnySeat(self.shaft.seats)
            if self.state == "free"
            else self.shaft.seats[self.row]
        )

    @property
    def above(self) -> bool:
        """Return whether the screw exists where the load closes the play; a free shift exists where
        it does not.
        """
        return self.state != "free"

    def whole(self, at: Condition) -> Floats:
        """Return the shift (6, pose) of a robot that has it, rad and m per unit."""
        if self.direction is not None:
            return np.asarray(self.direction[:, None] * np.ones(len(at.angle)))
        whole, edge, grows = (each[self.row] for each in self.shaft.shifts(at))
        seat, size = (
            self.shaft.seats[self.row],
            {"deflects": whole - edge, "held": edge, "grows": grows}[self.state],
        )
        # Axial values of the table are signed; radial ones are sizes along the load.
        return rows_times(seat.way.T, size[None] if self.row == _AXIS else seat.towards(at) * size)

    def compliance(self, at: Condition) -> Floats:
        """Return the tangent compliance (pose, 6, 6): slopes of the table along each load, and
        across a radial load the turning of its direction.
        """
        out = np.zeros((len(at.angle), 6, 6))
        if not self.elastic:
            return out
        slopes, seats = self.shaft.slopes(at), self.shaft.seats
        # Derivative of the size of each load by the wrench (6, pose).
        sizes = [
            *(rows_times(seat.way.T, seat.towards(at)) for seat in seats[:_AXIS]),
            seats[_AXIS].way.T * np.ones(len(at.angle)),
        ]
        for j, size in enumerate(sizes):
            out += np.einsum("ip,jp,p->pij", sizes[self.row], size, slopes[self.row, j])
        if self.row != _AXIS:
            seat, turning = seats[self.row], self.shaft.turning(self.row, at)
            out += np.multiply.outer(turning, seat.way.T @ seat.way) - np.einsum(
                "ip,jp,p->pij", sizes[self.row], sizes[self.row], turning
            )
        return out
