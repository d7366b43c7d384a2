"""Two spaced rolling bearings: shift and tilt of the axis in the clearances, in the direction of
the load.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.laws.distributions import TwoSided
from lostmotion.parts.bearing.bearing import BearingFigures
from lostmotion.parts.error_source import (
    HELD_SHARE,
    OF_HELD,
    ClearanceDim,
    Friction,
    FrictionForce,
    LengthPlus,
    LinearStiffness,
    PartFigure,
)
from lostmotion.parts.forms import Linear
from lostmotion.parts.play import Seat
from lostmotion.parts.provenance import OfClass, with_friction
from lostmotion.parts.standard_terms import End, circle, parameter, play_terms
from lostmotion.parts.term import Draw, Holding, Motion, Term
from lostmotion.spatial import skew
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

SIDES: Final = (("inboard", -1.0), ("outboard", 1.0))


class RollingPair(OfClass, BearingFigures):
    """A spaced pair of rolling bearings, each with the same working clearance.

    clearance         diametral working clearance of each bearing; ± is its scatter over bearings
    span              distance between the two; the axis can tilt by clearance/span
    axial_play        full axial play; on a turning joint only, because along a slide the drive
                      carries the load
    radial_stiffness  of each bearing; default: rigid once the clearance is closed
    axial_stiffness   of the pair, on a turning joint only; default: rigid
    closing_force     under a load below it on one bearing its clearance stays open; default: 2 % of
                      the largest load on one bearing at rest, in any pose on any slope. ± is its
                      scatter over joints; default: ±50 %

    Each bearing carries its share of force and moment, and is displaced by half its clearance
    towards its own reaction. Valid for a rigid shaft and housing.
    """

    kind: Literal["rolling"] = "rolling"
    clearance: ClearanceDim = Toleranced(0.0)
    span: LengthPlus
    axial_play: ClearanceDim = Toleranced(0.0)
    radial_stiffness: LinearStiffness | None = None
    axial_stiffness: LinearStiffness | None = None
    closing_force: FrictionForce | None = None

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the default
        friction.
        """
        return with_friction(super().assumptions, "closing_force", self.play_friction(Holding))

    @property
    def stated_figures(self) -> list[PartFigure]:
        """Return the figures that are stated, and the tilt that follows, for the sheet of the
        bearing.
        """
        nominal, scatter = self.clearance.nominal, f"± {self.clearance.tolerance * 1e6:.3g} µm"
        stiffness = (
            [PartFigure("stiffness of each", self.radial_stiffness, "N/m")]
            if self.radial_stiffness is not None
            else []
        )
        return [
            PartFigure("working clearance of each", nominal, "m", scatter),
            PartFigure(
                "tilt in it, either way",
                nominal / self.span,
                "rad",
                f"over a span of {self.span * 1e3:.4g} mm",
            ),
            *stiffness,
        ]

    def terms(self, motion: Motion) -> list[Term]:
        """Return shift and tilt in the clearances, axial play, and elastic deflection."""
        axis, out = motion.axis, []
        closing = closing_friction(self.closing_force, self.span, motion.holding).load
        clearance, stiffness = (
            parameter("clearance", self.clearance.nominal, "m"),
            parameter("radial stiffness", self.radial_stiffness, "N/m"),
        )
        for name, side in SIDES:
            way = per_shift(axis, side, self.span)
            if self.clearance.nominal:
                seat = Seat(way, closing, min(self.span, 1.0), f"{name} friction")
                # Without load the shaft rests anywhere on the circle of the clearance.
                ends = circle(f"{name} clearance", f"{name} position", way, axis)
                out += play_terms(
                    f"{name} clearance",
                    self.clearance,
                    seat,
                    ends,
                    f"{name} amount",
                    clearance,
                    cause="clearance",
                )
            if self.radial_stiffness is not None:
                form = Linear(way.T @ way / self.radial_stiffness)
                out.append(
                    Term(
                        f"{name} radial deflection",
                        "radial deflection",
                        form,
                        parameter=stiffness,
                        exponent=-1,
                    )
                )
        # Along a sliding joint the drive carries the load; the joint refuses axial values that this
        # would ignore.
        return (
            [*out, *self._axial(np.concatenate([np.zeros(3), axis]), closing)]
            if motion.turning
            else out
        )

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:
        """Return the closing force that is stated, or else assumed."""
        return (
            closing_friction(self.closing_force, self.span, holding)
            if self.clearance.nominal or self.axial_play.nominal
            else None
        )

    def _axial(self, along: Floats, closing: Toleranced) -> list[Term]:
        out: list[Term] = []
        if self.axial_play.nominal:
            ends, sized = (
                [End("axial play", along, Draw("axial side", TwoSided()))],
                parameter("axial play", self.axial_play.nominal, "m"),
            )
            out += play_terms(
                "axial play",
                self.axial_play,
                Seat(along[None], closing, stream="axial friction"),
                ends,
                "axial amount",
                sized,
            )
        if self.axial_stiffness is not None:
            form = Linear(np.outer(along, along) / self.axial_stiffness)
            sized = parameter("axial stiffness", self.axial_stiffness, "N/m")
            out.append(
                Term("axial deflection", "axial deflection", form, parameter=sized, exponent=-1)
            )
        return out


def closing_friction(
    stated: Friction | None, span: float, holding: Callable[[], Holding]
) -> Friction:
    """Return the load (N), stated or else assumed, that closes the clearance of one of two bearings
    `span` (m) apart.
    """
    if stated is not None:
        return stated
    most = holding()
    return Friction.of_load(HELD_SHARE * (most.force / 2 + most.moment / span), OF_HELD)


def per_shift(axis: Floats, side: float, span: float) -> Floats:
    """Return the map (3, 6) from a wrench to the load on one bearing; transposed, from its radial
    shift to a twist (shift/2, tilt shift/span).
    """
    return np.hstack([skew(axis).T * (side / span), (np.eye(3) - np.outer(axis, axis)) / 2])
