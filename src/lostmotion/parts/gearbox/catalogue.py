"""A gearbox by the figures of its data sheet, with a stated ratio.

On a turning joint its quantities are angles. On a sliding joint the same class describes a screw or belt drive: quantities are lengths at the slide,
and the screw or pulley makes a turn per `lead`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from lostmotion.parts.error_source import Lead
from lostmotion.parts.gearbox.gearbox import AmountT, FrictionT, Gearbox, LoadT, PlayT, StiffnessT
from lostmotion.parts.provenance import OfClass
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion


class CatalogueGearbox(Gearbox[AmountT, PlayT, StiffnessT, LoadT, FrictionT], OfClass):
    """A reducer or drive described by catalogue values, as `Gearbox` lists them; an omitted value is assumed ideal.

    ratio  turns of the motor per turn of the output, or of the screw
    lead   travel per turn of the screw or pulley, on a sliding joint; there the transmission error counts the screw's turns
    """

    kind: Literal["catalogue"] = "catalogue"
    ratio: Annotated[float, Quantity("", "121", above=0)] = 1.0
    lead: Lead | None = None

    @property
    def states_ratio(self) -> bool:
        """Return whether the ratio is stated; a row of a catalogue may omit it."""
        return "ratio" in self.model_fields_set

    def _turns(self, motion: Motion) -> float | None:
        return motion.turns(self.lead)
