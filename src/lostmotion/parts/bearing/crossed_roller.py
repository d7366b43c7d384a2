"""One crossed-roller bearing (or any preloaded bearing that carries all loads by itself): no play, but it gives under load."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from lostmotion.laws.chance import Cosine, Sine
from lostmotion.parts.source import (
    AngularStiffness,
    Condition,
    Draw,
    ErrorSource,
    LengthAmount,
    LinearStiffness,
    Part,
    Term,
    wave_terms,
)
from lostmotion.spatial import across

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


class CrossedRoller(Part, ErrorSource):
    """A preloaded bearing by catalogue stiffness; every value left out is taken as rigid or exact.

    moment_stiffness  against tilting across the axis
    radial_stiffness, axial_stiffness  against shifting
    axial_runout, radial_runout  full indicator reading over a turn, with a phase that differs from robot to robot

    A sliding joint takes neither runout nor axial_stiffness: nothing turns, and along the slide the drive holds.
    """

    kind: Literal["crossed roller"] = "crossed roller"
    moment_stiffness: AngularStiffness | None = None
    radial_stiffness: LinearStiffness | None = None
    axial_stiffness: LinearStiffness | None = None
    radial_runout: LengthAmount = 0.0
    axial_runout: LengthAmount = 0.0

    def terms(self, at: Condition) -> list[Term]:
        """Elastic give in tilt, across and along the axis, and runout."""
        turning = bool(at.axis[:3].any())
        axis = at.axis[:3] if turning else at.axis[3:]
        along = np.outer(axis, axis)
        radially = np.eye(3) - along
        zero = np.zeros((len(at.angle), 3))
        moment, force = at.wrench[:, :3], at.wrench[:, 3:]
        out: list[Term] = []
        if self.moment_stiffness is not None:
            out.append(Term("tilt", np.hstack([moment @ radially / self.moment_stiffness, zero])))
        if self.radial_stiffness is not None:
            out.append(Term("radial give", np.hstack([zero, force @ radially / self.radial_stiffness])))
        if self.axial_stiffness is not None and turning:
            out.append(Term("axial give", np.hstack([zero, force @ along / self.axial_stiffness])))
        if turning:
            out += self._runout(at, axis)
        return out

    def _runout(self, at: Condition, axis: Floats) -> list[Term]:
        """Give what a high spot on the turning ring does: across the axis it turns with this frame, along it it rises and falls."""
        out: list[Term] = []
        if self.radial_runout:
            size = self.radial_runout / 2 / np.sqrt(2)
            for k, (direction, law) in enumerate(zip(across(axis), (Cosine(), Sine()), strict=True), 1):
                out.append(Term(f"radial runout {k}", np.concatenate([np.zeros(3), direction * size]), robot=Draw("radial runout", law)))
        if self.axial_runout:
            along = np.concatenate([np.zeros(3), axis])
            out += wave_terms("axial runout", along, at.angle, self.axial_runout / 2, ("1", "2"))
        return out
