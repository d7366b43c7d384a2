"""Plays that a load closes once it overcomes friction: the seat of a play, and the form of a closed
and of an open play.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.laws.clearance import closed_share
from lostmotion.parts.term import Form, Threshold, rows_times

if TYPE_CHECKING:
    from lostmotion.parts.term import Condition
    from lostmotion.spatial import Floats
    from lostmotion.units import Toleranced

# Smaller loads (N or N m) count as none: their squares have too few digits for a direction.
_LEAST: Final = 1e-140


@dataclass(frozen=True, eq=False)
class Seat(Threshold):
    """A play of unit half width in one to three directions, and the friction below which a load
    does not close it.

    way       (m, 6), m from 1 to 3: the load in the play is way @ wrench (m, pose), N or N m, and
              the part moves by way.T @ position, as reciprocity requires
    friction  load that closes the play, N or N m, with its scatter over robots
    lever     length by which the size of the wrench is divided before it is compared with a load,
              m; one where `way` has no lever arm
    stream    name of the draw of the friction within the part
    """

    way: Floats
    friction: Toleranced
    lever: float = 1.0
    stream: str = "friction"

    @property
    def scatters(self) -> bool:
        """Return whether the friction differs from robot to robot."""
        return self.friction.tolerance > 0

    def load(self, at: Condition) -> Floats:
        """Return the load in the play (m, pose), N or N m."""
        return at.once((self, "load"), lambda: rows_times(self.way, at.wrench))

    def load_size(self, at: Condition) -> Floats:
        """Return the size of the load in the play (pose,), N or N m."""
        return at.once((self, "load size"), lambda: _size(self.load(at)))

    def towards(self, at: Condition) -> Floats:
        """Return the unit direction of the load (m, pose); zero without a load."""
        size = self.load_size(at)
        return at.once((self, "towards"), lambda: self.load(at) / np.where(size > 0, size, 1.0))

    def share(self, at: Condition) -> Floats:
        """Return the share of robots (pose,) in which the load closes the play, 0..1
        (`laws.clearance.closed_share`).
        """
        return at.once(
            (self, "share"),
            lambda: closed_share(self.load_size(at), self.friction, at.load_size / self.lever),
        )


def _size(load: Floats) -> Floats:
    size = np.sqrt((load**2).sum(axis=0))
    return np.where(size > _LEAST, size, 0.0)


@dataclass(frozen=True, eq=False)
class AnySeat(Threshold):
    """Several seats of one shaft: the load counts as above the friction where it closes the play of
    any seat. The draw is that of the last seat.
    """

    seats: tuple[Seat, ...]

    @property
    def stream(self) -> str:  # type: ignore[override]
        """Return the name of the last seat's draw."""
        return self.seats[-1].stream

    @property
    def scatters(self) -> bool:
        """Return whether the friction differs from robot to robot."""
        return any(seat.scatters for seat in self.seats)

    def share(self, at: Condition) -> Floats:
        """Return the share of robots (pose,) in which any seat is closed, where one draw decides
        for all seats: the largest of their shares.
        """
        return np.asarray(np.max([seat.share(at) for seat in self.seats], axis=0))


class InPlay(Form):
    """A form that exists only where a load closes a play, or only where it leaves the play open.

    Where the friction scatters, `screw` is the screw of a robot that has it. Without scatter all
    robots are equal, and it is zero where none has it.
    """

    @property
    @abstractmethod
    def decides(self) -> Threshold | None:
        """Return the friction that decides whether the play is closed; None where all robots have
        the screw.
        """

    @property
    def threshold(self) -> Threshold | None:
        """Return `decides` where the friction differs from robot to robot; None elsewhere."""
        return self.decides if self.decides is not None and self.decides.scatters else None

    @abstractmethod
    def whole(self, at: Condition) -> Floats:
        """Return the screw (6, pose), rad and m, of a robot that has it."""

    def screw(self, at: Condition) -> Floats:
        """Return the screw (6, pose)."""
        if self.decides is None or self.decides.scatters:
            return self.whole(at)
        share = self.decides.share(at)
        return np.asarray(self.whole(at) * (share if self.above else 1 - share))


def decides_on(form: Form) -> Threshold | None:
    """Return the friction that decides whether the play of a form is closed; None without play."""
    return form.decides if isinstance(form, InPlay) else form.threshold


def seats_of(form: Form) -> tuple[Seat, ...]:
    """Return the seats of the play in which a form exists; none for a form without play."""
    decides = decides_on(form)
    if isinstance(decides, AnySeat):
        return decides.seats
    return (decides,) if isinstance(decides, Seat) else ()


@dataclass(frozen=True, eq=False)
class HeldPlay(InPlay):
    """A play of unit half width: "held" (closed), on the side of the load, or "free" (open), along
    a fixed `direction` (6,).
    """

    seat: Seat
    state: Literal["held", "free"]
    direction: Floats | None = None

    @property
    def decides(self) -> Seat:
        """Return the seat."""
        return self.seat

    @property
    def above(self) -> bool:
        """Return whether the screw is that of the closed play."""
        return self.state == "held"

    def whole(self, at: Condition) -> Floats:
        """Return the position of the part in its play (6, pose), per unit half width."""
        if self.direction is not None:
            return np.asarray(self.direction[:, None] * np.ones(len(at.angle)))
        return rows_times(self.seat.way.T, self.seat.towards(at))
