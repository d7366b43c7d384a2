"""A pinion on a rack, driven through a gearbox whose own figures are angles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np

from lostmotion.laws.linear_drives import rack_compliance
from lostmotion.parts.error_source import AngularStiffness, LengthAmount, LengthPlus, PlayDim
from lostmotion.parts.gearbox.counts import teeth
from lostmotion.parts.gearbox.slide import SlideFigures
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


class RackDrive(SlideFigures):
    """A pinion on a rack; figures as in `SlideFigures`, of the mesh. The lead is the pinion's pitch
    circumference unless stated.

    pinion_radius      pitch radius of the pinion
    gearbox_stiffness  torsional, of the pinion's gearbox and shaft; default: rigid
    gearbox_backlash   of the pinion's gearbox, at the pinion: it adds to `backlash`, which is that
                       of the mesh
    pinion_error       amplitude along the rack of the harmonic of the pinion's eccentricity: once
                       per turn of it
    pinion_teeth, mesh_error  number of teeth, and amplitude along the rack of the harmonic of their
                              pitch: once per tooth
    lead_error         ± share by which the rack is too long or too short: its cumulative pitch
                       error per length

    Its stiffness does not depend on the position.
    """

    kind: Literal["rack"] = "rack"
    described_by: ClassVar[dict[str, tuple[str, ...]]] = {
        "stiffness": ("gearbox_stiffness",),
        "backlash": ("gearbox_backlash",),
    }
    follows_travel: ClassVar[bool] = False
    pinion_radius: LengthPlus
    gearbox_stiffness: AngularStiffness | None = None
    gearbox_backlash: PlayDim | None = None
    pinion_error: LengthAmount = 0.0
    pinion_teeth: Annotated[int, teeth("20")] | None = None
    mesh_error: LengthAmount = 0.0

    @property
    def per_turn(self) -> float:
        """Return the travel per turn of the pinion, m: the lead, or its pitch circumference."""
        return self.lead or 2 * math.pi * self.pinion_radius

    def compliance_at(self, position: Floats) -> Floats:
        """Return the compliance (m/N) of the pinion's gearbox, the same at all joint values (any
        shape).
        """
        own = (
            0.0
            if self.gearbox_stiffness is None
            else rack_compliance(self.pinion_radius, self.gearbox_stiffness)
        )
        return np.full(np.shape(position), own)

    @property
    def play(self) -> Toleranced:
        """Return the play of mesh and gearbox together (m); their tolerances add up, so that the
        sum stays within its limits.
        """
        mesh, gearbox = self._stated_play, self.gearbox_backlash
        if gearbox is None:
            return mesh
        law = mesh.law if mesh.nominal else gearbox.law
        return Toleranced(
            mesh.nominal + self.pinion_radius * gearbox.nominal,
            mesh.tolerance + self.pinion_radius * gearbox.tolerance,
            law,
        )

    def _own_harmonics(self) -> list[tuple[str, float, float]]:
        return [
            ("pinion", self.pinion_error, 1.0),
            ("mesh", self.mesh_error, float(self.pinion_teeth or 1)),
        ]
