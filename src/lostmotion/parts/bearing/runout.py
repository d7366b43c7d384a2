"""Runout of a bearing: a high spot on its turning ring."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.distributions import Cosine, Sine
from lostmotion.parts.error_source import Condition, Draw, Term, wave_terms
from lostmotion.spatial import across

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


def runout_terms(at: Condition, axis: Floats, radial: float, axial: float) -> list[Term]:
    """Which errors does a high spot make: across the axis it turns with this frame, along it it rises and falls?

    `radial`, `axial`: full indicator reading over a turn, m; with a phase that differs from robot to robot.
    """
    out: list[Term] = []
    if radial:
        size = radial / 2 / np.sqrt(2)
        for k, (direction, law) in enumerate(zip(across(axis), (Cosine(), Sine()), strict=True), 1):
            out.append(Term(f"radial runout {k}", np.concatenate([np.zeros(3), direction * size]), robot=Draw("radial runout", law)))
    if axial:
        out += wave_terms("axial runout", np.concatenate([np.zeros(3), axis]), at.angle, axial / 2, ("1", "2"))
    return out
