"""One crossed-roller bearing (or any preloaded bearing that carries all loads by itself): no play, but it gives under load."""

from __future__ import annotations

from typing import Literal

import numpy as np

from lostmotion.parts.bearing.runout import runout_terms
from lostmotion.parts.error_source import AngularStiffness, Condition, ErrorSource, LengthAmount, LengthPlus, LinearStiffness, Term
from lostmotion.parts.provenance import Sourced
from lostmotion.spatial import mapped


class CrossedRoller(Sourced, ErrorSource):
    """A preloaded bearing by catalogue stiffness; every value left out is taken as rigid or exact.

    moment_stiffness  against tilting across the axis; left out: k D^2/8 per radian of axial_stiffness k and pitch_diameter D, where both are stated
    radial_stiffness, axial_stiffness  against shifting
    axial_runout, radial_runout  full indicator reading over a turn, with a phase that differs from robot to robot

    A sliding joint takes neither runout nor axial_stiffness: nothing turns, and along the slide the drive holds.
    """

    kind: Literal["crossed roller"] = "crossed roller"
    moment_stiffness: AngularStiffness | None = None
    radial_stiffness: LinearStiffness | None = None
    axial_stiffness: LinearStiffness | None = None
    pitch_diameter: LengthPlus | None = None
    radial_runout: LengthAmount = 0.0
    axial_runout: LengthAmount = 0.0

    @property
    def tilt_stiffness(self) -> float | None:
        """Give the stiffness against tilting (N m/rad): the maker's own, or that of a ring of axial springs; None where neither is known."""
        if self.moment_stiffness is None and self.axial_stiffness is not None and self.pitch_diameter is not None:
            return self.axial_stiffness * self.pitch_diameter**2 / 8
        return self.moment_stiffness

    def terms(self, at: Condition) -> list[Term]:
        """Elastic give in tilt, across and along the axis, and runout."""
        turning = bool(at.axis[:3].any())
        axis = at.axis[:3] if turning else at.axis[3:]
        along = np.outer(axis, axis)
        radially = np.eye(3) - along
        zero = np.zeros((len(at.angle), 3))
        moment, force = at.wrench[:, :3], at.wrench[:, 3:]
        out: list[Term] = []
        if self.tilt_stiffness is not None:
            out.append(Term("tilt", np.hstack([mapped(radially, moment) / self.tilt_stiffness, zero])))
        if self.radial_stiffness is not None:
            out.append(Term("radial give", np.hstack([zero, mapped(radially, force) / self.radial_stiffness])))
        if self.axial_stiffness is not None and turning:
            out.append(Term("axial give", np.hstack([zero, mapped(along, force) / self.axial_stiffness])))
        if turning:
            out += runout_terms(at, axis, self.radial_runout, self.axial_runout)
        return out
