"""Units in which people read a gearbox: of a turning joint, or of a drive that slides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from lostmotion.parts.gearbox.kinds import is_sliding
from lostmotion.reporting.sheet import ARCMIN, Figure

# The sample of a figure that was stated.
STATED: Final = "the values stated"


@dataclass(frozen=True, slots=True)
class Units:
    """Display units of a gearbox on a turning joint, or of a sliding drive, each with its factor
    from SI.
    """

    angle: str
    angle_factor: float
    torque: str
    stiffness: str
    stiffness_factor: float
    what: str
    limit: str

    def of_angle(
        self,
        value: float,
        samples: str,
        low: float = math.nan,
        high: float = math.nan,
        ends: str = "95 % interval",
    ) -> Figure:
        """Return an angle, or a length of a sliding drive."""
        factor = self.angle_factor
        return Figure(value * factor, self.angle, low * factor, high * factor, samples, ends)

    def of_torque(
        self,
        value: float,
        samples: str,
        low: float = math.nan,
        high: float = math.nan,
        ends: str = "95 % interval",
    ) -> Figure:
        """Return a torque, or a force."""
        return Figure(value, self.torque, low, high, samples, ends, stated=samples == STATED)

    def of_stiffness(self, value: float, samples: str) -> Figure:
        """Return a stiffness."""
        return Figure(
            value * self.stiffness_factor, self.stiffness, samples=samples, stated=samples == STATED
        )


TURNING: Final = Units(
    "arcmin", 1 / ARCMIN, "N m", "N m/arcmin", ARCMIN, "torque", "turn of the output"
)
SLIDING: Final = Units("µm", 1e6, "N", "N/µm", 1e-6, "force", "turn of the screw or pulley")


def units_of(gearbox: object) -> Units:
    """Return the units of this gearbox."""
    return SLIDING if is_sliding(gearbox) else TURNING
