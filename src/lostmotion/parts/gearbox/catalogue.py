"""A gearbox by the figures of its data sheet, with a stated ratio.

On a turning joint its quantities are angles. On a sliding joint the same class describes a screw or
belt drive: quantities are lengths at the slide, and the screw or pulley makes a turn per `lead`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from lostmotion.parts.error_source import Gradient, Lead
from lostmotion.parts.gearbox.gearbox import AmountT, FrictionT, Gearbox, LoadT, PlayT, StiffnessT
from lostmotion.parts.gearbox.slide import lead_terms
from lostmotion.parts.provenance import OfClass
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion, Term


class CatalogueGearbox(Gearbox[AmountT, PlayT, StiffnessT, LoadT, FrictionT], OfClass):
    """A reducer or drive described by catalogue values, as `Gearbox` lists them; an omitted value
    is assumed ideal.

    ratio  turns of the motor per turn of the output, or of the screw
    lead   travel per turn of the screw or pulley, on a sliding joint; there the transmission error
           counts the screw's turns
    lead_error  on a sliding joint: ± share by which its travel is too long or too short, in
                proportion to the joint's value
    """

    kind: Literal["catalogue"] = "catalogue"
    ratio: Annotated[float, Quantity("", "121", above=0)] = 1.0
    lead: Lead | None = None
    lead_error: Gradient | None = None

    @property
    def states_ratio(self) -> bool:
        """Return whether the ratio is stated; a row of a catalogue may omit it."""
        return "ratio" in self.model_fields_set

    def terms(self, motion: Motion) -> list[Term]:
        """Return the terms of any gearbox, and on a sliding joint the lead error."""
        return [*super().terms(motion), *lead_terms(motion, self.lead_error)]

    def _turns(self, motion: Motion) -> float | None:
        return motion.turns(self.lead)
