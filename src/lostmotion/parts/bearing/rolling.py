"""Two rolling bearings at a distance: clearance lets the axis shift and tilt, and the load decides where to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from lostmotion.laws.clearance import seated, seated_across
from lostmotion.laws.distributions import Cosine, Sine, TwoSided
from lostmotion.parts.error_source import (
    HELD_SHARE,
    OF_HELD,
    ClearanceDim,
    Condition,
    Draw,
    ErrorSource,
    ForceAmount,
    Friction,
    Holding,
    LengthPlus,
    LinearStiffness,
    Term,
    play_terms,
)
from lostmotion.parts.provenance import Sourced, default_friction
from lostmotion.spatial import across, cross, mapped, skew
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

_SIDES = (("inboard", -1.0), ("outboard", 1.0))


class RollingPair(Sourced, ErrorSource):
    """A spaced pair of rolling bearings, each with the same working clearance.

    clearance         diametral working clearance of each bearing; ± is its scatter over bearings
    span              distance between the two; the axis can tilt by clearance/span
    axial_play        full axial play; on a turning joint only, for along a slide the drive holds
    radial_stiffness  of each bearing; left out: rigid once the clearance is closed
    axial_stiffness   of the pair, on a turning joint only; left out: rigid
    closing_force     a load below it on one bearing cannot hold its clearance closed; left out: 2 % of the most that one bearing holds at rest, in
                      any pose on any slope

    Each bearing takes its share of force and moment and sits at half its clearance towards its own reaction. Valid for loads that bend
    neither shaft nor housing.
    """

    kind: Literal["rolling"] = "rolling"
    clearance: ClearanceDim = Toleranced(0.0)
    span: LengthPlus
    axial_play: ClearanceDim = Toleranced(0.0)
    radial_stiffness: LinearStiffness | None = None
    axial_stiffness: LinearStiffness | None = None
    closing_force: ForceAmount | None = None

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the default friction."""
        return {**super().assumptions, **default_friction("closing_force", self.play_friction(Holding))}

    def terms(self, at: Condition) -> list[Term]:
        """Shift and tilt in the clearances, axial play, and elastic give."""
        axis = at.axis[:3] if at.axis[:3].any() else at.axis[3:]
        out: list[Term] = []
        closing = closing_friction(self.closing_force, self.span, at.holding).load
        for name, side in _SIDES:
            reaction = self._reaction(at.wrench, axis, side)
            out += self._in_clearance(name, per_shift(axis, side, self.span), reaction, closing, axis, at.scale / min(self.span, 1.0))
            if self.radial_stiffness is not None:
                give = reaction / self.radial_stiffness
                out.append(Term(f"{name} radial give", mapped(per_shift(axis, side, self.span).T, give)))
        return [*out, *self._axial(at, axis, closing)]

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:
        """Return the closing force that is stated, or else assumed."""
        return closing_friction(self.closing_force, self.span, holding) if self.clearance.nominal or self.axial_play.nominal else None

    def _reaction(self, wrench: Floats, axis: Floats, side: float) -> Floats:
        """Give the radial load (pose, 3) that one bearing carries: half of the force, and its part of the moment."""
        force, moment = wrench[:, 3:], wrench[:, :3]
        across = force - np.outer(mapped(axis, force), axis)
        return across / 2 + side * cross(moment, axis) / self.span

    def _in_clearance(self, name: str, per_shift: Floats, reaction: Floats, closing: float, axis: Floats, scale: Floats) -> list[Term]:
        half = self.clearance.nominal / 2
        if not half:
            return []
        sitting, free = seated_across(reaction, closing, scale)
        known = mapped(per_shift.T, sitting) * half
        first, second = across(axis)
        stream = f"{name} position"
        size = free[:, None] * (half / np.sqrt(2))
        # Unloaded, the bearing rests somewhere on the circle that its clearance leaves it.
        circle = [
            Term(f"{name} clearance position 1", size * (first @ per_shift), visit=Draw(stream, Cosine())),
            Term(f"{name} clearance position 2", size * (second @ per_shift), visit=Draw(stream, Sine())),
        ]
        return play_terms(f"{name} clearance", self.clearance, known, circle, f"{name} amount")

    def _axial(self, at: Condition, axis: Floats, closing: float) -> list[Term]:
        if at.axis[3:].any():
            return []  # along a sliding joint the drive holds, not the bearing; the joint refuses what would be lost here
        force = mapped(axis, at.wrench[:, 3:])
        twist = np.concatenate([np.zeros(3), axis])
        out: list[Term] = []
        half = self.axial_play.nominal / 2
        if half:
            closed = seated(force, closing, at.scale)
            either = (1 - np.abs(closed))[:, None] * twist * half
            ends = [Term("axial play", either, visit=Draw("axial side", TwoSided()))]
            out += play_terms("axial play", self.axial_play, closed[:, None] * twist * half, ends, "axial amount")
        if self.axial_stiffness is not None:
            out.append(Term("axial give", (force / self.axial_stiffness)[:, None] * twist))
        return out


def closing_friction(stated: float | None, span: float, holding: Callable[[], Holding]) -> Friction:
    """Which load (N) on one of two bearings at a distance of `span` (m) closes its clearance? As stated, or else assumed."""
    if stated is not None:
        return Friction(stated)
    most = holding()
    return Friction(HELD_SHARE * (most.force / 2 + most.moment / span), OF_HELD)


def per_shift(axis: Floats, side: float, span: float) -> Floats:
    """Which twist (3, 6) follows per radial shift of one bearing while the other stays? Half shift, and a tilt of 1/span."""
    return np.hstack([skew(axis).T * (side / span), (np.eye(3) - np.outer(axis, axis)) / 2])
