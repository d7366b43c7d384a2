"""The position control of a joint: where it lets the joint stop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Generic, TypeVar

from lostmotion.laws.distributions import Uniform
from lostmotion.parts.error_source import ErrorSource
from lostmotion.parts.forms import Constant
from lostmotion.parts.provenance import OfClass
from lostmotion.parts.standard_terms import limit_terms, parameter

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion, Term

AmountT = TypeVar("AmountT", bound=float)


class Servo(OfClass, Generic[AmountT]):
    """The position control of a joint.

    dead_band  ± distance from the command within which the control lets the joint stop, measured
               where the encoder is: on a turning joint with an encoder on the motor it reaches the
               output divided by the encoder's ratio. Without an encoder, and on a sliding joint: at
               the output

    The joint stops anywhere within the dead band, drawn at every visit and independent of the side
    of arrival. Valid where friction decides when the joint stops, since any position within the
    band is then as likely as another. A control that always stops at the edge where it arrives
    scatters less, and adds a constant offset of up to the dead band.
    """

    shareable: ClassVar[bool] = False
    dead_band: AmountT | None = None

    def behind(self, turns: float) -> ServoStops:
        """Return its errors at the output of a joint whose encoder makes this number of turns per
        turn of the output.
        """
        return ServoStops(self.dead_band or 0.0, turns)


@dataclass(frozen=True, slots=True)
class ServoStops(ErrorSource):
    """Where a servo lets its joint stop: within ± `dead_band` (rad or m) of the command, measured
    `turns` turns before a turn of the output.
    """

    dead_band: float
    turns: float = 1.0

    def terms(self, motion: Motion) -> list[Term]:
        """Return the distance of the output from the command, drawn at every visit."""
        if not self.dead_band:
            return []
        limit, sized = (
            self.dead_band / (self.turns if motion.turning else 1.0),
            parameter("dead_band", self.dead_band, motion.unit),
        )
        return limit_terms("dead band", Constant(motion.twist), limit, Uniform(), sized, visit=True)
