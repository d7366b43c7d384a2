"""One lumped error of a whole joint, as in papers and quick estimates, where the parts are not
specified.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Final, Literal

import numpy as np
from pydantic import Field

from lostmotion.distribution_table import Distribution, TableRows
from lostmotion.laws.distributions import Law, Normal, Table, TwoSided, Uniform
from lostmotion.parts.error_source import AngleAmount, ErrorSource, LengthAmount
from lostmotion.parts.forms import Constant
from lostmotion.parts.provenance import Sourced
from lostmotion.parts.standard_terms import limit_terms, parameter
from lostmotion.parts.term import Motion, Term

Chance = Annotated[
    str | TableRows,
    Distribution(
        ("normal", "normal without limits", "uniform", "two-sided", "from zero to maximum")
    ),
]
_LAWS: Final[dict[str, Law]] = {
    "uniform": Uniform(),
    "two-sided": TwoSided(),
    "normal without limits": Normal(math.inf),
}


class Lumped(Sourced, ErrorSource):
    """A lumped joint error: an angle about the axis, and a shift of the joint's centre.

    angle     largest angle error. law "normal": +-angle at three sigma, truncated there; "uniform";
              "two-sided": always + or -;
              "from zero to maximum": normal around angle/2 with sigma angle/6, truncated to
              0..angle; "normal without limits": angle is three sigma, exceeded in 0.27 % of draws,
              so that there is no worst case; or a table of rows [value in units of the angle,
              probability of a smaller one], uniform between neighbouring values: [[-1, 0], [0.2,
              0.5], [1, 1]]
    offset    ± shift along each direction in `offset_along`, uniform
    varies    "visit": drawn at every visit; "robot": once per robot
    """

    shareable: ClassVar[bool] = False
    angle: AngleAmount = 0.0
    law: Chance = "normal"
    offset: LengthAmount = 0.0
    offset_along: Annotated[list[Literal["x", "y", "z"]], Field(max_length=3)] = Field(
        default=["x", "y", "z"]
    )
    varies: Literal["robot", "visit"] = "visit"

    def terms(self, motion: Motion) -> list[Term]:
        """Return the lumped angle about the joint's axis and the lumped shift of its centre."""
        visit, along = self.varies == "visit", Constant(motion.twist)
        out: list[Term] = []
        if self.angle:
            spread, sized = self.angle, parameter("angle", self.angle, motion.unit)
            if self.law == "from zero to maximum":
                spread = self.angle / 2
                out.append(Term("mean angle", "mean angle", along, spread, parameter=sized))
            law = _LAWS.get(self.law, Normal()) if isinstance(self.law, str) else Table(self.law)
            out += limit_terms("angle", along, spread, law, sized, visit=visit)
        if self.offset:
            sized = parameter("offset", self.offset, "m")
            for axis in dict.fromkeys(self.offset_along):
                shift = Constant(np.eye(6)[3 + "xyz".index(axis)])
                out += limit_terms(
                    f"offset {axis}", shift, self.offset, Uniform(), sized, visit=visit
                )
        return out
