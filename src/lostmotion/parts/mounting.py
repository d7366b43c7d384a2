"""Tolerances of a joint's axis in the link before it."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from lostmotion.laws.distributions import Normal
from lostmotion.parts.error_source import AngleAmount, ErrorSource, LengthAmount
from lostmotion.parts.forms import Constant
from lostmotion.parts.provenance import OfClass
from lostmotion.parts.standard_terms import limit_terms, parameter
from lostmotion.spatial import across

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion, Term


class Mounting(OfClass, ErrorSource):
    """Tolerances of the joint's axis in the previous link: ± tilt about, and ± offset along, the two directions across it."""

    shareable: ClassVar[bool] = False
    tilt: AngleAmount = 0.0
    offset: LengthAmount = 0.0

    def terms(self, motion: Motion) -> list[Term]:
        """Return the errors of the axis in the seat's frame, which does not turn with the joint."""
        tilt, offset = parameter("axis tilt", self.tilt, "rad"), parameter("axis offset", self.offset, "m")
        law = Normal()
        out: list[Term] = []
        for k, direction in enumerate(across(motion.axis), 1):
            if self.tilt:
                turn = Constant(np.concatenate([direction, np.zeros(3)]))
                out += limit_terms(f"axis tilt {k}", turn, self.tilt, law, tilt, cause="axis tilt")
            if self.offset:
                shift = Constant(np.concatenate([np.zeros(3), direction]))
                out += limit_terms(f"axis offset {k}", shift, self.offset, law, offset, cause="axis offset")
        return out
