"""One crossed-roller bearing (or any preloaded bearing that carries all loads by itself): no play,
elastic deflection.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from lostmotion.parts.bearing.bearing import BearingFigures
from lostmotion.parts.bearing.runout import runout_terms
from lostmotion.parts.error_source import (
    AngularStiffness,
    LengthAmount,
    LengthPlus,
    LinearStiffness,
    PartFigure,
)
from lostmotion.parts.forms import Linear
from lostmotion.parts.provenance import OfClass
from lostmotion.parts.standard_terms import parameter
from lostmotion.parts.term import Motion, Term


class CrossedRoller(OfClass, BearingFigures):
    """A preloaded bearing by catalogue stiffness; an omitted value is assumed rigid or exact.

    moment_stiffness  against tilting; default: k D^2/8 per radian of axial_stiffness k and
                      pitch_diameter D, where both are stated radial_stiffness, axial_stiffness
                      against displacement
    axial_runout, radial_runout  full indicator reading over a turn, with a random phase per robot

    Runout and axial_stiffness are for turning joints only: along a slide the drive carries the
    load.
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
        """Return the stiffness against tilting (N m/rad): as stated, or that of a ring of axial
        springs; None where neither is known.
        """
        if (
            self.moment_stiffness is None
            and self.axial_stiffness is not None
            and self.pitch_diameter is not None
        ):
            return self.axial_stiffness * self.pitch_diameter**2 / 8
        return self.moment_stiffness

    @property
    def stated_figures(self) -> list[PartFigure]:
        """Return the figures that are stated, for the sheet of the bearing."""
        springs = (
            PartFigure("stiffness across", self.radial_stiffness or 0.0, "N/m"),
            PartFigure("stiffness along the axis", self.axial_stiffness or 0.0, "N/m"),
            PartFigure("stiffness against tilting", self.tilt_stiffness or 0.0, "N m/rad"),
        )
        runout = (
            PartFigure("radial runout", self.radial_runout, "m"),
            PartFigure("axial runout", self.axial_runout, "m"),
        )
        return [*(each for each in springs if each.value), *runout]

    def terms(self, motion: Motion) -> list[Term]:
        """Return the deflection in tilt, across and along the axis, and runout."""
        axis, turning, zero = motion.axis, motion.turning, np.zeros((3, 3))
        along = np.outer(axis, axis)
        radially = np.eye(3) - along
        out: list[Term] = []
        if self.tilt_stiffness is not None:
            form = Linear(np.block([[radially / self.tilt_stiffness, zero], [zero, zero]]))
            sized = parameter("moment stiffness", self.tilt_stiffness, "N m/rad")
            out.append(Term("tilt", "tilt", form, parameter=sized, exponent=-1))
        if self.radial_stiffness is not None:
            form = Linear(np.block([[zero, zero], [zero, radially / self.radial_stiffness]]))
            sized = parameter("radial stiffness", self.radial_stiffness, "N/m")
            out.append(
                Term("radial deflection", "radial deflection", form, parameter=sized, exponent=-1)
            )
        if self.axial_stiffness is not None and turning:
            form = Linear(np.block([[zero, zero], [zero, along / self.axial_stiffness]]))
            sized = parameter("axial stiffness", self.axial_stiffness, "N/m")
            out.append(
                Term("axial deflection", "axial deflection", form, parameter=sized, exponent=-1)
            )
        return out + (runout_terms(axis, self.radial_runout, self.axial_runout) if turning else [])
