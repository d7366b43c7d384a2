"""Drives of sliding joints: what all kinds of them share."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Self

import numpy as np
from pydantic import model_validator

from lostmotion.parts.error_source import (
    ClearanceDim,
    ForceAmount,
    FrictionForce,
    Gradient,
    Lead,
    LengthAmount,
    LinearStiffness,
    PartFigure,
)
from lostmotion.parts.forms import Curve
from lostmotion.parts.gearbox.gearbox import Gearbox, refuse
from lostmotion.parts.provenance import OfClass
from lostmotion.parts.standard_terms import parameter, proportional_terms
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion, Term
    from lostmotion.spatial import Floats

# Positions at which the compliance of a belt or screw is tabulated: between them it is off by less
# than 1e-4 of itself.
_POSITIONS: Final = 129


def lead_terms(motion: Motion, lead_error: float | None) -> list[Term]:
    """Return the terms of a lead that is too long or too short: ± this share of the joint's
    value.
    """
    return (
        []
        if not lead_error
        else proportional_terms(
            "lead error", motion, lead_error, parameter("lead_error", lead_error, ""), "lead error"
        )
    )


class SlideFigures(
    Gearbox[LengthAmount, ClearanceDim, LinearStiffness, ForceAmount, FrictionForce], OfClass
):
    """Base class of the kinds for sliding joints only; the figures that makers print, as `Gearbox`
    lists them, as lengths and forces at the slide.

    ratio       turns of the motor per turn of the screw, pulley or pinion
    lead        travel per turn of the screw, pulley or pinion
    lead_error  ± share by which the travel is too long or too short, in proportion to the joint's
                value
    stiffness   of all that is not described by the kind's own keys, in series with it
    """

    # Whether the stiffness depends on the position.
    follows_travel: ClassVar[bool] = True
    ratio: Annotated[float, Quantity("", "121", above=0)] = 1.0
    lead: Lead | None = None
    lead_error: Gradient | None = None

    @abstractmethod
    def compliance_at(self, position: Floats) -> Floats:
        """Return the compliance (m/N) of the kind's own members at joint values (any shape), m."""

    @property
    def per_turn(self) -> float | None:
        """Return the travel per turn of the screw, pulley or pinion, m; None where it is not
        known.
        """
        return self.lead

    @property
    def zones(self) -> list[float]:
        """Return the stiffness (N/m) at the joint's zero, everything in series; empty for a rigid
        drive.
        """
        compliance = float(self.compliance_at(np.zeros(1))[0]) + self._rest
        return [1 / compliance] if compliance else []

    @property
    def _rest(self) -> float:
        """Return the compliance (m/N) of all that the kind's own keys do not describe."""
        return (
            0.0
            if self.stiffness is None or isinstance(self.stiffness, list)
            else 1 / self.stiffness
        )

    @model_validator(mode="after")
    def _has_one_stiffness(self) -> Self:
        if isinstance(self.stiffness, list):
            raise refuse(
                "stiffness zones of a drive of this kind",
                "one stiffness, of all but its own members",
                'stiffness = "100 N/µm"',
            )
        return self

    def range_error(self, limits: tuple[float, float]) -> tuple[str, str, str] | None:  # noqa: ARG002 - for kinds of limited length
        """Return what was found, what is expected and an example where the drive is too short for a
        joint's range; None where it is not.
        """
        return None

    @property
    def own_figures(self) -> list[PartFigure]:
        """Return the stiffness of a drive whose stiffness depends on the position, at the joint's
        zero.
        """
        note = "at the joint's zero; it depends on the position"
        return (
            [PartFigure("stiffness of the drive", self.zones[0], "N/m", note)]
            if self.follows_travel
            else []
        )

    def terms(self, motion: Motion) -> list[Term]:
        """Return the terms of any drive, with the spring of its own members, and the lead error."""
        return [*super().terms(motion), *lead_terms(motion, self.lead_error)]

    def _travel(self, motion: Motion) -> Curve | None:
        if motion.limits is None or not self.zones:
            return None
        at = np.linspace(*motion.limits, _POSITIONS)
        return Curve(at, (self.compliance_at(at) + self._rest) * self.zones[0])

    def _turns(self, motion: Motion) -> float | None:
        return motion.turns(self.per_turn)
