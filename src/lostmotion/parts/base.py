"""What the arm stands on: a tilt, known or not, and a mount that gives."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Literal

import numpy as np

from lostmotion.laws.chance import of_tolerance
from lostmotion.parts.source import AngleDim, AngularStiffness, Condition, Draw, ErrorSource, LinearStiffness, Part, Term
from lostmotion.spatial import pose_of
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

Six = tuple[AngularStiffness, AngularStiffness, AngularStiffness]
Three = tuple[LinearStiffness, LinearStiffness, LinearStiffness]


class Base(Part, ErrorSource):
    """The ground, chassis or table under the arm.

    roll, pitch   tilt about the base's x, then y axis; the nominal turns gravity, the tolerance is what nobody measured
    tilt_varies   "robot": the arm is set down once; "visit": a mobile base stands differently every time
    angular_stiffness, linear_stiffness  of the mount about and along x, y, z; left out: rigid

    The error that an unmeasured tilt makes is counted at the tool, seen from the level ground; the change of load that comes with it
    is second order and left out.
    """

    roll: AngleDim = Toleranced(0.0)
    pitch: AngleDim = Toleranced(0.0)
    tilt_varies: Literal["robot", "visit"] = "robot"
    angular_stiffness: Six | None = None
    linear_stiffness: Three | None = None

    @functools.cached_property
    def tilt(self) -> Floats:
        """Give the rotation (3, 3) of the base against level ground."""
        return pose_of(rpy=(self.roll.nominal, self.pitch.nominal, 0.0))[:3, :3]

    def terms(self, at: Condition) -> list[Term]:
        """Tilt that nobody measured, and the mount's give."""
        out: list[Term] = []
        for k, (name, dimension) in enumerate((("roll", self.roll), ("pitch", self.pitch))):
            if dimension.tolerance:
                law = of_tolerance(dimension.law)
                draw = Draw(name, law)
                screw = np.eye(6)[k] * (dimension.tolerance / law.bound)
                # `tilt` is R_y R_x; its roll axis is the base's own x, its pitch axis the level y
                screw[:3] = screw[:3] if k == 0 else self.tilt.T @ screw[:3]
                out.append(Term(name, screw, visit=draw) if self.tilt_varies == "visit" else Term(name, screw, robot=draw))
        if self.angular_stiffness is not None or self.linear_stiffness is not None:
            give = np.zeros_like(at.wrench)
            if self.angular_stiffness is not None:
                give[:, :3] = at.wrench[:, :3] / np.array(self.angular_stiffness)
            if self.linear_stiffness is not None:
                give[:, 3:] = at.wrench[:, 3:] / np.array(self.linear_stiffness)
            out.append(Term("mount give", give))
        return out
