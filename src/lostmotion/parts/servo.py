"""The position control of a joint: where it lets the joint stop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, Generic, Self

from pydantic import model_validator
from pydantic_core import PydanticCustomError

from lostmotion.laws.distributions import Uniform
from lostmotion.parts.error_source import ErrorSource
from lostmotion.parts.forms import Constant, Curve, Spring
from lostmotion.parts.gearbox.gearbox import AmountT, StiffnessT
from lostmotion.parts.provenance import OfClass
from lostmotion.parts.standard_terms import limit_terms, parameter
from lostmotion.parts.term import Term
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion


class Servo(OfClass, Generic[AmountT, StiffnessT]):
    """The position control of a joint.

    dead_band  ± distance from the command within which the control lets the joint stop, measured
               where the encoder is: on a turning joint with an encoder on the motor it reaches the
               output divided by the encoder's ratio. Without an encoder, and on a sliding joint: at
               the output
    stiffness  torque of the control per angle of the output from its command (a proportional gain):
               a spring in series with the gearbox. Default: the control leaves no droop
    gravity_compensation  share of the torque of the weights that the controller feeds forward;
               only the rest winds the servo. It does not know the process force
    integral   true: integral action leaves no droop of the servo. Wind-up and play behind it stay

    The joint stops anywhere within the dead band, drawn at every visit and independent of the side
    of arrival. Valid where friction decides when the joint stops, since any position within the
    band is then as likely as another. A control that always stops at the edge where it arrives
    scatters less, and adds a constant offset of up to the dead band.
    """

    shareable: ClassVar[bool] = False
    dead_band: AmountT | None = None
    stiffness: StiffnessT | None = None
    gravity_compensation: Annotated[float, Quantity("", "70 %", low=0, high=1)] = 0.0
    integral: bool = False

    @model_validator(mode="after")
    def _compensates_a_droop(self) -> Self:
        if self.gravity_compensation and self.stiffness is None:
            raise PydanticCustomError(
                "limits",
                "{why}",
                {
                    "why": "gravity_compensation of a servo without a stiffness",
                    "expected": "the stiffness of the servo, which the rest of the torque winds",
                    "example": 'stiffness = "15 N m/rad", gravity_compensation = "70 %"',
                },
            )
        return self

    @property
    def droops(self) -> bool:
        """Return whether a load moves the joint off its command."""
        return self.stiffness is not None and not self.integral

    def behind(self, turns: float) -> ServoStops:
        """Return its errors at the output of a joint whose encoder makes this number of turns per
        turn of the output.
        """
        stiffness = self.stiffness if self.droops else None
        return ServoStops(self.dead_band or 0.0, turns, stiffness, self.gravity_compensation)


@dataclass(frozen=True, slots=True)
class ServoStops(ErrorSource):
    """Where a servo lets its joint stop: within ± `dead_band` (rad or m) of the command, measured
    `turns` turns before a turn of the output, and below it by the load over `stiffness` (N m/rad or
    N/m), of which a share of the weights' is fed forward. None: no droop.
    """

    dead_band: float
    turns: float = 1.0
    stiffness: float | None = None
    fed_forward: float = 0.0

    def terms(self, motion: Motion) -> list[Term]:
        """Return the droop, and the distance of the output from the command, drawn at every
        visit.
        """
        return [*self._droop(motion), *self._stops(motion)]

    def _droop(self, motion: Motion) -> list[Term]:
        if self.stiffness is None:
            return []
        line = Curve.of_zones([self.stiffness], [])
        sized = parameter("stiffness", self.stiffness, motion.stiffness_unit)
        droop = Spring(motion.twist, line)
        out = [Term("droop", "servo droop", droop, parameter=sized, exponent=-1)]
        if self.fed_forward:
            known = Spring(motion.twist, line, fed_forward=True)
            name = "gravity compensation"
            out.append(Term(name, name, known, -self.fed_forward, parameter=sized, exponent=-1))
        return out

    def _stops(self, motion: Motion) -> list[Term]:
        if not self.dead_band:
            return []
        limit, sized = (
            self.dead_band / (self.turns if motion.turning else 1.0),
            parameter("dead_band", self.dead_band, motion.unit),
        )
        return limit_terms("dead band", Constant(motion.twist), limit, Uniform(), sized, visit=True)
