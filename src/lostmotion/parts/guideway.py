"""Error motions of the carriage of a linear axis, by the terms of ISO 230-1."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from lostmotion.parts.error_source import AngleAmount, ErrorSource, LengthAmount, LengthPlus
from lostmotion.parts.frame import Direction, unit
from lostmotion.parts.provenance import OfClass
from lostmotion.parts.standard_terms import harmonic_terms, parameter

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion, Term
    from lostmotion.spatial import Floats

# What is expected in place of a rail that bends between its supports.
_NO_BEAM: Final = (
    (
        "error motions: a rail that bends between its supports is not modelled. A bearing of "
        "radial_stiffness 24 E I/L^3, or 96 E I/L^3 "
        "where its ends are clamped, deflects as it does with the carriage at mid-span"
    ),
    (
        'bearing = { kind = "rolling", clearance = "0 µm", span = "150 mm", radial_stiffness = '
        '"0.1 N/µm" }'
    ),
)
# Sine of an angle below which two directions count as parallel.
_PARALLEL: Final = 1e-6


class Guideway(OfClass, ErrorSource):
    """Error motions of a carriage: deviations from motion along a straight line. They are equal at
    every visit, and differ from robot to robot.

    Each value is peak to peak over the range of the joint, as ISO 230-1 defines the error, and is
    modelled as one harmonic of random phase. The straight line is the joint's axis. Its tilt is the
    squareness error, stated as `tilt` of the joint's mounting. The positioning error along the axis
    is stated by the drive and the encoder.

    straightness   along `up`, and across it and the axis (EZX, EYX of an axis X): one value for
                   both, or two
    pitch          rotation about the direction across `up` and the axis (EBX)
    yaw            rotation about `up` (ECX)
    roll           rotation about the axis (EAX)
    wavelength     of all of them; default: the range of the joint
    up             direction across the axis, in the joint's axes; default: z, or x for an axis
                   along z

    The angles act about the joint's frame, which moves with the carriage: a point at a distance
    from it is shifted by angle x distance (Abbe error).
    """

    shareable: ClassVar[bool] = False
    not_modelled: ClassVar[dict[str, tuple[str, str]]] = dict.fromkeys(
        ("beam", "rail", "section", "supports"), _NO_BEAM
    )
    straightness: LengthAmount | tuple[LengthAmount, LengthAmount] = 0.0
    pitch: AngleAmount = 0.0
    yaw: AngleAmount = 0.0
    roll: AngleAmount = 0.0
    wavelength: LengthPlus | None = None
    up: Direction | None = None

    def terms(self, motion: Motion) -> list[Term]:
        """Return the error motions along and about the directions across the axis, and about the
        axis.

        Raises ValueError without a wavelength for a part without a range, and for a direction up
        along the axis.
        """
        wavelength = self.wavelength
        if wavelength is None:
            if motion.limits is None:
                raise ValueError("a guideway without a wavelength, on a joint without limits")
            wavelength = motion.limits[1] - motion.limits[0]
        turns = 2 * math.pi / wavelength
        along, up, across = motion.axis, *self.directions(motion.axis)
        high, wide = (
            self.straightness
            if isinstance(self.straightness, tuple)
            else (self.straightness, self.straightness)
        )
        none = np.zeros(3)
        found = (
            ("straightness up", "straightness", high, "m", np.concatenate([none, up])),
            ("straightness across", "straightness", wide, "m", np.concatenate([none, across])),
            ("pitch", "pitch", self.pitch, "rad", np.concatenate([across, none])),
            ("yaw", "yaw", self.yaw, "rad", np.concatenate([up, none])),
            ("roll", "roll", self.roll, "rad", np.concatenate([along, none])),
        )
        out: list[Term] = []
        for name, cause, range_, unit_, direction in found:
            if range_:
                sized = parameter(cause, getattr(self, cause), unit_)
                out += harmonic_terms(name, cause, direction, 1.0, range_ / 2, sized, turns)
        return out

    def directions(self, axis: Floats) -> tuple[Floats, Floats]:
        """Return the directions up and across (3,) of an axis (3,). Raises ValueError for a
        direction up along the axis.
        """
        stated = (
            unit(self.up)
            if self.up is not None
            else np.eye(3)[2 if abs(axis[2]) < 1 - _PARALLEL else 0]
        )
        up = stated - axis * (axis @ stated)
        length = float(np.linalg.norm(up))
        if length < _PARALLEL:
            raise ValueError("up along the axis itself")
        return up / length, np.cross(up / length, axis)
