"""The six forms in which an error follows from angle, load and gravity: everything that a part can do is one of them.

Constant, Harmonic (of the joint's angle), Spring (a curve along one motion), Linear (a compliance matrix), HeldPlay (a play that the load closes) and
LoadTable (shifts tabulated over several loads). Arrays have the pose last.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.laws.clearance import seated
from lostmotion.parts.term import Form, rows_times

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.rolling.table import ShiftTable
    from lostmotion.parts.term import Condition
    from lostmotion.spatial import Floats


@dataclass(frozen=True, eq=False)
class Curve:
    """A piecewise linear function of a load of zero or more: `value` at each `load` (n,), rising; beyond the last it goes on with slope `beyond`."""

    load: Floats
    value: Floats
    beyond: float = 0.0

    @classmethod
    def of_zones(cls, stiffness: Sequence[float], limits: Sequence[float]) -> Curve:
        """Return the wind-up over the load of a spring in zones: stiffness N m/rad or N/m, limits one fewer, rising, N m or N."""
        load = np.array([0.0, *limits])
        steps = np.diff(load) / np.array(stiffness[:-1])
        return cls(load, np.array([0.0, *np.cumsum(steps)]), 1 / stiffness[-1])

    @classmethod
    def through(cls, load: Floats, value: Floats) -> Curve:
        """Return the curve through these points that goes on straight beyond the last one."""
        return cls(load, value, float((value[-1] - value[-2]) / (load[-1] - load[-2])))

    def __call__(self, load: Floats) -> Floats:
        """Return the value at loads (any shape) of zero or more."""
        out = np.interp(load, self.load, self.value)
        return np.asarray(out + np.maximum(load - self.load[-1], 0.0) * self.beyond if self.beyond else out)

    def slope(self, load: Floats) -> Floats:
        """Return the slope at loads (any shape) of zero or more; at a knot that of the side of larger loads."""
        steps = np.append(np.diff(self.value) / np.diff(self.load), self.beyond)
        return np.asarray(np.where(load < self.load[0], 0.0, steps[np.searchsorted(self.load, load, "right") - 1]))


class _Along(Form):
    """A form along one fixed unit twist `direction` (6,), of a size that depends on the condition."""

    direction: Floats

    @abstractmethod
    def size(self, at: Condition) -> Floats | float:
        """Return the size (pose,), or one for all poses."""

    def screw(self, at: Condition) -> Floats:
        """Return the screw (6, pose)."""
        return np.asarray(self.direction[:, None] * np.broadcast_to(at.once(self, lambda: self.size(at)), len(at.angle)))

    def write(self, at: Condition, scale: float, out: Floats) -> None:
        """Write the screw times `scale` into `out` (6, pose)."""
        size = at.once(self, lambda: self.size(at)) * scale
        for row, weight in zip(out, self.direction, strict=True):
            row[:] = weight * size if weight else 0.0


@dataclass(frozen=True, eq=False)
class Constant(_Along):
    """The same screw at every pose."""

    direction: Floats

    @property
    def reads(self) -> tuple[str, ...]:
        """Return that it depends on nothing."""
        return ()

    def size(self, at: Condition) -> float:  # noqa: ARG002 - it depends on nothing
        """Return one."""
        return 1.0


@dataclass(frozen=True, eq=False)
class Harmonic(_Along):
    """The sine or the cosine of `order` times the angle that has been turned.

    turns     turning in rad per unit of the joint's value, for the screw of a sliding joint; None where the joint itself turns
    envelope  amplitude over the size of the load along `direction`; None: one
    """

    direction: Floats
    order: float
    phase: Literal["sine", "cosine"]
    turns: float | None = None
    envelope: Curve | None = None

    @property
    def reads(self) -> tuple[str, ...]:
        """Return that it depends on the angle, and with an envelope on the load."""
        return ("angle",) if self.envelope is None else ("angle", "wrench")

    def size(self, at: Condition) -> Floats:
        """Return the harmonic (pose,)."""
        # Order and turns are not folded into one factor: that alone would move a harmonic of 1 000 rad by 1e-12.
        turned = at.angle if self.turns is None else at.angle * self.turns
        out = (np.sin if self.phase == "sine" else np.cos)(self.order * turned)
        envelope = self.envelope
        return np.asarray(out if envelope is None else out * at.once(envelope, lambda: envelope(np.abs(at.along(self.direction)))))


@dataclass(frozen=True, eq=False)
class Spring(_Along):
    """A curve over the load along the same motion, odd in the load; with `odd` False even: half the width of a friction loop, which is no spring."""

    direction: Floats
    curve: Curve
    odd: bool = True

    @property
    def elastic(self) -> bool:
        """Return whether it is a spring."""
        return self.odd

    def size(self, at: Condition) -> Floats:
        """Return the deflection (pose,), rad or m."""
        load = at.along(self.direction)
        value = self.curve(np.abs(load))
        return np.asarray(np.sign(load) * value if self.odd else value)

    def compliance(self, at: Condition) -> Floats:
        """Return the tangent (pose, 6, 6), at a knot of the curve that on the side of larger loads."""
        slope = self.curve.slope(np.abs(at.along(self.direction)))
        return np.asarray(np.multiply.outer(slope * self.odd, np.outer(self.direction, self.direction)))


@dataclass(frozen=True, eq=False)
class Linear(Form):
    """A compliance `matrix` (6, 6) times the wrench, and `own_weight` (6, 3) times gravity."""

    matrix: Floats
    own_weight: Floats | None = None

    @property
    def reads(self) -> tuple[str, ...]:
        """Return whether it depends on load and gravity."""
        return (*(("wrench",) if self.elastic else ()), *(("gravity",) if self.own_weight is not None else ()))

    @property
    def elastic(self) -> bool:
        """Return whether a load moves it."""
        return bool(self.matrix.any())

    def screw(self, at: Condition) -> Floats:
        """Return the deflection (6, pose)."""
        out = rows_times(self.matrix, at.wrench)
        return out if self.own_weight is None else out + rows_times(self.own_weight, at.gravity)

    def compliance(self, at: Condition) -> Floats:
        """Return the matrix for every pose (pose, 6, 6)."""
        return np.broadcast_to(self.matrix, (len(at.angle), 6, 6))


@dataclass(frozen=True, eq=False)
class Seat:
    """A play of unit half width along `way` (m, 6), m from 1 to 3, and the friction below which a load does not close it.

    The load in the play is way @ wrench (m, pose), N or N m; the part moves by way.T @ position, so that reciprocity holds.
    lever  by which the size of the wrench is divided where it is compared with a load, m; one where `way` carries no lever arm
    """

    way: Floats
    friction: float
    lever: float = 1.0

    def load(self, at: Condition) -> Floats:
        """Return the load in the play (m, pose)."""
        return at.once((self, "load"), lambda: rows_times(self.way, at.wrench))

    def load_size(self, at: Condition) -> Floats:
        """Return the size of the load in the play (pose,)."""
        return at.once((self, "load size"), lambda: np.sqrt((self.load(at) ** 2).sum(axis=0)))

    def towards(self, at: Condition) -> Floats:
        """Return the unit direction of the load (m, pose); zero without a load."""
        size = self.load_size(at)
        return at.once((self, "towards"), lambda: self.load(at) / np.where(size > 0, size, 1.0))

    def share(self, at: Condition) -> Floats:
        """Return the share of the play that the load closes (pose,), 0..1 (`laws.clearance`)."""
        return at.once((self, "share"), lambda: seated(self.load_size(at), self.friction, at.load_size / self.lever))


@dataclass(frozen=True, eq=False)
class HeldPlay(Form):
    """A play of unit half width: "held" on the side of the load, or "free", along a fixed `direction` (6,), as far as the load leaves it."""

    seat: Seat
    state: Literal["held", "free"]
    direction: Floats | None = None

    def screw(self, at: Condition) -> Floats:
        """Return where the play lets the part rest (6, pose)."""
        share = self.seat.share(at)
        if self.direction is not None:
            return np.asarray(self.direction[:, None] * (1 - share))
        return rows_times(self.seat.way.T, self.seat.towards(at) * share)


# The last of a shaft's seats.
_AXIS: Final = 2
# The change of load, as a share of the whole load, over which a slope of a table is read.
_STEP: Final = 1e-3
# Makes one size of forces and moments, m: about the distance between the bearings of a joint.
_LEVER: Final = 0.1


@dataclass(frozen=True, eq=False)
class ShaftOnRows:
    """A shaft on rolling elements: its seats on the row behind, on the row ahead and along the axis, and the table of its shifts under their loads.

    axial   whether the rows hold the shaft along its axis
    wider   the table at a clearance larger by `step` (m); None where all bearings are the same
    """

    seats: tuple[Seat, Seat, Seat]
    axial: bool
    table: ShiftTable
    wider: ShiftTable | None
    step: float

    def loads(self, at: Condition) -> tuple[Floats, Floats, Floats]:
        """Return the sizes of the two radial loads and the axial force with its sign (pose,), N."""
        behind, ahead, along = self.seats
        return behind.load_size(at), ahead.load_size(at), along.load(at)[0] if self.axial else np.zeros(len(at.angle))

    def shifts(self, at: Condition) -> tuple[Floats, Floats, Floats]:
        """Return the shift along each load (3, pose), its part up to the edge of the play, and its growth per metre of clearance."""
        return at.once(self, lambda: self._shifts(at))

    def _shifts(self, at: Condition) -> tuple[Floats, Floats, Floats]:
        loads = self.loads(at)
        whole = self.table.shifts(*loads)
        grows = np.zeros_like(whole) if self.wider is None else (self.wider.shifts(*loads) - whole) / self.step
        return whole.T, self.table.edges(*loads).T, grows.T

    def slopes(self, at: Condition) -> Floats:
        """Return how the deflection along each load follows each load (3, 3, pose), m/N: symmetric differences over ±0.1 % of the load."""
        return at.once((self, "slopes"), lambda: self._slopes(at))

    def least(self, at: Condition) -> Floats:
        """Return the least load (pose,), N, at which a deflection is read: 0.1 % of the whole load, and of 1 N where it is less.

        Without any load a contact between rolling elements has no stiffness at all.
        """
        size = np.sqrt((at.wrench[3:] ** 2).sum(axis=0)) + np.sqrt((at.wrench[:3] ** 2).sum(axis=0)) / _LEVER
        return np.asarray(_STEP * np.maximum(size, 1.0))

    def _slopes(self, at: Condition) -> Floats:
        loads, step = self.loads(at), self.least(at)
        out = np.zeros((3, 3, len(step)))
        for j in range(3 if self.axial else _AXIS):
            ahead, behind = (self._deflection([load + sign * step * (k == j) for k, load in enumerate(loads)]) for sign in (1.0, -1.0))
            out[:, j] = (ahead - behind) / (2 * step)
        return out

    def turning(self, row: int, at: Condition) -> Floats:
        """Return the deflection of a row per radial load (pose,), m/N: its compliance across the load, whose direction alone turns."""
        loads = list(self.loads(at))
        loads[row] = np.maximum(loads[row], self.least(at))
        return np.asarray(self._deflection(loads)[row] / loads[row])

    def _deflection(self, loads: Sequence[Floats]) -> Floats:
        """Return the deflection along each load beyond the edge of the play (3, load), for radial loads of either sign."""
        behind, ahead, along = loads
        sizes = np.abs(behind), np.abs(ahead), along
        out = (self.table.shifts(*sizes) - self.table.edges(*sizes)).T
        out[:2] *= np.where(np.stack([behind, ahead]) < 0, -1.0, 1.0)
        return out


@dataclass(frozen=True, eq=False)
class LoadTable(Form):
    """Shifts of a shaft along the loads of some of its seats (`rows`): 0 and 1 are the rows, 2 is the axis, which counts `axial_weight` times.

    deflects  beyond the edge of the play
    held      to that edge, as far as the loads close the play
    grows     per metre of clearance
    free      along a fixed `direction` (6,), as far as all of these loads leave the play open
    """

    shaft: ShaftOnRows
    state: Literal["deflects", "held", "grows", "free"]
    rows: tuple[int, ...]
    direction: Floats | None = None
    axial_weight: float = 1.0

    @property
    def elastic(self) -> bool:
        """Return whether it is a spring."""
        return self.state == "deflects"

    def screw(self, at: Condition) -> Floats:
        """Return the shift (6, pose)."""
        if self.direction is not None:
            return np.asarray(self.direction[:, None] * self._left_open(at))
        whole, edge, grows = self.shaft.shifts(at)
        out = np.zeros((6, len(at.angle)))
        for row in self.rows:
            seat, axial = self.shaft.seats[row], row == _AXIS
            size = whole[row] - edge[row] if self.state == "deflects" else seat.share(at) * (edge[row] if self.state == "held" else grows[row])
            # Along the axis the table's own values have a sign.
            out += rows_times(seat.way.T, size[None] * self.axial_weight if axial else seat.towards(at) * size)
        return out

    def compliance(self, at: Condition) -> Floats:
        """Return the tangent (pose, 6, 6): along each load by the slopes of the table, across a radial one by its own direction's turning."""
        out = np.zeros((len(at.angle), 6, 6))
        if not self.elastic:
            return out
        slopes, seats = self.shaft.slopes(at), self.shaft.seats
        # How the size of each load follows the wrench (6, pose).
        sizes = [*(rows_times(seat.way.T, seat.towards(at)) for seat in seats[:_AXIS]), seats[_AXIS].way.T * np.ones(len(at.angle))]
        for row in self.rows:
            seat = seats[row]
            along = sizes[row]
            for j, size in enumerate(sizes):
                out += np.einsum("ip,jp,p->pij", along, size, slopes[row, j])
            if row != _AXIS:
                turning = self.shaft.turning(row, at)
                out += np.multiply.outer(turning, seat.way.T @ seat.way) - np.einsum("ip,jp,p->pij", along, along, turning)
        return out

    def _left_open(self, at: Condition) -> Floats:
        *rows, axis = (1 - self.shaft.seats[row].share(at) for row in self.rows)
        return np.asarray(axis * np.min(rows, axis=0))
