"""Bearings by their drawing: rolling elements that only push, behind the clearance that mounting left, so a dead band and then a hardening spring."""

from __future__ import annotations

import functools
from abc import abstractmethod
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.clearance import seated, seated_across
from lostmotion.laws.distributions import Amount, Cosine, Law, Sine, TwoSided, of_tolerance
from lostmotion.laws.rolling.table import Pair, ShiftTable, shift_table
from lostmotion.parts.bearing.fits import MountedBearing
from lostmotion.parts.bearing.rolling import closing_friction, per_shift
from lostmotion.parts.bearing.runout import runout_terms
from lostmotion.parts.error_source import Condition, Draw, ErrorSource, ForceAmount, Friction, Holding, LengthAmount, Term
from lostmotion.parts.provenance import default_friction
from lostmotion.spatial import across, cross, mapped

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

_SIDES: Final = (("inboard", -1.0), ("outboard", 1.0))
# By how much the clearance is changed to see what follows from it, m.
_STEP: Final = 1e-6


class DrawnBearing(MountedBearing, ErrorSource):
    """What every bearing by its drawing has besides its mounting.

    closing_force  a load below it on one bearing cannot hold its clearance closed; left out: 2 % of the most that one bearing holds at rest, in any
                   pose on any slope
    radial_runout, axial_runout  full indicator reading over a turn

    Rings, shaft and housing are rigid, friction none. Loads on the elements and the shaft's stand are `laws.rolling_space`'s, for a pose read
    from `laws.rolling_table`.
    """

    closing_force: ForceAmount | None = None
    radial_runout: LengthAmount = 0.0
    axial_runout: LengthAmount = 0.0

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the default friction."""
        return {**super().assumptions, **default_friction("closing_force", self.play_friction(Holding))}

    @property
    @abstractmethod
    def rows(self) -> Pair:
        """Give its rows on the shaft, z along the joint's axis, and where their forces meet the axis."""

    @property
    @abstractmethod
    def bearings(self) -> int:
        """Give how many bearings there are: each has a clearance of its own."""

    @property
    def is_single(self) -> bool:
        """Say whether one row stands by itself, so that it holds next to no moment."""
        return False

    @abstractmethod
    def pressure(self, load: Floats) -> Floats:
        """How hard do elements under these loads (N) press on the inner race, Pa?"""

    @functools.cached_property
    def static_load(self) -> float:
        """Give the load (N) that presses an element as hard as static ratings allow: 4 200 MPa for balls, 4 000 MPa for rollers (ISO 76)."""
        limit, power = (4200e6, 3) if self.elements == "ball" else (4000e6, 2)
        return float((limit / self.pressure(np.ones(1))[0]) ** power)

    @property
    def top(self) -> float:
        """Give the load (N) at the top of the table: all elements of a third of the ring at their static limit."""
        return sum(self.static_load * seat.row.count / 3 for seat in self.rows.seats)

    def table(self, clearance: float) -> ShiftTable:
        """Give the shifts under load at one clearance (m)."""
        return shift_table(self.rows, clearance, self.top)

    def terms(self, at: Condition) -> list[Term]:
        """Where the load holds the shaft in the clearance, what is left to chance, how the elements give, how bearings differ, and runout."""
        turning = bool(at.axis[:3].any())
        axis = at.axis[:3] if turning else at.axis[3:]
        rows, play = self.rows, self.working
        reactions = [self._reaction(at.wrench, axis, side) for _, side in _SIDES]
        sizes = tuple(np.linalg.norm(each, axis=-1) for each in reactions)
        force = mapped(axis, at.wrench[:, 3:]) if turning and rows.axial else np.zeros(len(at.angle))
        loads = sizes[0], sizes[1], force
        table = self.table(play.nominal)
        whole, edge = table.shifts(*loads), table.edges(*loads)
        grows = (self.table(play.nominal + _STEP).shifts(*loads) - whole) / _STEP if play.tolerance else np.zeros_like(whole)
        law = of_tolerance(play.law)
        spread = play.tolerance / law.bound
        scale = at.scale / min(rows.span, 1.0)
        friction = self.play_friction(at.holding)
        closing = 0.0 if friction is None else friction.load
        out: list[Term] = []
        left = np.ones(len(at.angle))
        streams = [f"{name} amount" if self.bearings > 1 else "amount" for name, _ in _SIDES]
        moved = dict.fromkeys(streams, np.zeros((len(at.angle), 6)))
        for k, (name, side) in enumerate(_SIDES):
            way = per_shift(axis, side, rows.span)
            unit = reactions[k] / np.where(sizes[k] > 0, sizes[k], 1.0)[:, None]
            sitting, free = seated_across(reactions[k], closing, scale)
            left = np.minimum(left, free)
            out.append(Term(f"{name} give", mapped(way.T, unit * (whole - edge)[:, k, None])))
            if play.nominal > 0:
                out.append(Term(f"{name} clearance side held by load", mapped(way.T, sitting * edge[:, k, None]), seated=True))
                out += _circle(f"{name} clearance", free * play.nominal / 2, way, axis, _amount(streams[k], spread / play.nominal, law))
            share = np.linalg.norm(sitting, axis=-1)[:, None]
            moved[streams[k]] = moved[streams[k]] + mapped(way.T, unit * share * grows[:, k, None])
        if turning and rows.axial:
            closed, twist = seated(force, closing, at.scale), np.concatenate([np.zeros(3), axis])
            out += self._along(twist, closed, left, edge[:, 2], whole[:, 2])
            for stream in moved:
                moved[stream] = moved[stream] + (np.abs(closed) * grows[:, 2] / len(moved))[:, None] * twist
        if spread:
            out += [Term(stream, by * spread, robot=Draw(stream, law)) for stream, by in moved.items()]
        return out + (runout_terms(at, axis, self.radial_runout, self.axial_runout) if turning else [])

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:
        """Return the closing force that is stated, or else assumed; where every bearing is preloaded there is no play to close."""
        some_have_play = self.working.nominal + self.working.tolerance > 0
        return closing_friction(self.closing_force, self.rows.span, holding) if some_have_play else None

    def _reaction(self, wrench: Floats, axis: Floats, side: float) -> Floats:
        """Give the radial load (pose, 3) on one row: half of the force, and its part of the moment."""
        force, moment = wrench[:, 3:], wrench[:, :3]
        return (force - np.outer(mapped(axis, force), axis)) / 2 + side * cross(moment, axis) / self.rows.span

    def _along(self, twist: Floats, closed: Floats, left: Floats, edge: Floats, whole: Floats) -> list[Term]:
        """Give the axial give and play from how far the axial load closes the play (-1..1) and what the radial loads leave free (0..1)."""
        out = [Term("axial give", (whole - edge)[:, None] * twist)]
        play = self.working.nominal
        if play > 0:
            half = float(self.table(play).edges(*np.array([[0.0], [0.0], [1.0]]))[0, 2])
            out.append(Term("axial play side held by load", (np.abs(closed) * edge)[:, None] * twist, seated=True))
            out.append(Term("axial play", ((1 - np.abs(closed)) * left * half)[:, None] * twist, visit=Draw("axial side", TwoSided())))
        return out


def _amount(stream: str, scatter: float, law: Law) -> Draw | None:
    return Draw(stream, Amount(scatter, law)) if scatter else None


def _circle(name: str, radius: Floats, way: Floats, axis: Floats, amount: Draw | None) -> list[Term]:
    """Give where an unloaded row rests: somewhere on the circle (radius (pose,), m) that its clearance leaves it, larger for some robots."""
    grown = np.hypot(1, amount.law.scatter) if amount is not None and isinstance(amount.law, Amount) else 1.0
    size = radius[:, None] * (grown / np.sqrt(2))
    return [
        Term(f"{name} position {k}", size * (direction @ way), robot=amount, visit=Draw(f"{name} position", law))
        for k, (direction, law) in enumerate(zip(across(axis), (Cosine(), Sine()), strict=True), 1)
    ]
