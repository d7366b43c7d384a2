"""Plays that a load closes once it overcomes friction: their seats, and the form of a play held by the load or left free."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from lostmotion.laws.clearance import closed_share
from lostmotion.parts.term import Form, Threshold, rows_times

if TYPE_CHECKING:
    from lostmotion.parts.term import Condition
    from lostmotion.spatial import Floats
    from lostmotion.units import Toleranced


@dataclass(frozen=True, eq=False)
class Seat(Threshold):
    """A play of unit half width along `way` (m, 6), m from 1 to 3, and the friction below which a load does not close it.

    The load in the play is way @ wrench (m, pose), N or N m; the part moves by way.T @ position, so that reciprocity holds.
    lever  by which the size of the wrench is divided where it is compared with a load, m; one where `way` carries no lever arm
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
        """Return the share of robots (pose,) in which the load closes the play (`laws.clearance`)."""
        return at.once((self, "share"), lambda: closed_share(self.load_size(at), self.friction, at.load_size / self.lever))


@dataclass(frozen=True, eq=False)
class AnySeat(Threshold):
    """Several seats of one shaft: the load overcomes the friction where it does so in any of them. The draw is that of the last seat."""

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
        """Return the share of robots (pose,) in which one draw for all seats closes any of them."""
        return np.asarray(np.max([seat.share(at) for seat in self.seats], axis=0))


class InPlay(Form):
    """A form that is there only where a load closes a play, or only where it leaves it open.

    `screw` is that of a robot in which it is there where the friction scatters; without scatter it is zero where it is there in no robot.
    """

    @property
    @abstractmethod
    def decides(self) -> Threshold | None:
        """Return what decides whether the play is closed; None where all robots have the screw."""

    @property
    def threshold(self) -> Threshold | None:
        """Return what decides, where it differs from robot to robot."""
        return self.decides if self.decides is not None and self.decides.scatters else None

    @abstractmethod
    def whole(self, at: Condition) -> Floats:
        """Return the screw (6, pose) where it is there."""

    def screw(self, at: Condition) -> Floats:
        """Return the screw (6, pose)."""
        if self.decides is None or self.decides.scatters:
            return self.whole(at)
        share = self.decides.share(at)
        return np.asarray(self.whole(at) * (share if self.above else 1 - share))


@dataclass(frozen=True, eq=False)
class HeldPlay(InPlay):
    """A play of unit half width: "held" on the side of the load, or "free", along a fixed `direction` (6,), where the load leaves it open."""

    seat: Seat
    state: Literal["held", "free"]
    direction: Floats | None = None

    @property
    def decides(self) -> Seat:
        """Return the seat."""
        return self.seat

    @property
    def above(self) -> bool:
        """Return whether the load holds the part."""
        return self.state == "held"

    def whole(self, at: Condition) -> Floats:
        """Return where the play lets the part rest (6, pose)."""
        if self.direction is not None:
            return np.asarray(self.direction[:, None] * np.ones(len(at.angle)))
        return rows_times(self.seat.way.T, self.seat.towards(at))
