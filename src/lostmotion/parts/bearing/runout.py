"""Runout of a bearing: a high spot on its turning ring."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.parts.forms import Constant
from lostmotion.parts.standard_terms import PHASES, harmonic_terms, parameter
from lostmotion.parts.term import Draw, Term
from lostmotion.spatial import across

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


def runout_terms(axis: Floats, radial: float, axial: float) -> list[Term]:
    """Return the terms of runout: the radial part turns with this frame, the axial part is a
    harmonic of the joint's angle.

    `radial`, `axial`: full indicator reading over a turn, m; with a random phase per robot.
    """
    out: list[Term] = []
    if radial:
        size, sized, name = (
            radial / 2 / math.sqrt(2),
            parameter("radial runout", radial, "m"),
            "radial runout",
        )
        for k, (direction, law) in enumerate(zip(across(axis), PHASES.values(), strict=True), 1):
            form = Constant(np.concatenate([np.zeros(3), direction]))
            out.append(
                Term(f"{name} {k}", name, form, size, Draw(name, law), parameter=sized, effect=name)
            )
    if axial:
        along = np.concatenate([np.zeros(3), axis])
        out += harmonic_terms(
            "axial runout",
            "axial runout",
            along,
            1.0,
            axial / 2,
            parameter("axial runout", axial, "m"),
        )
    return out
