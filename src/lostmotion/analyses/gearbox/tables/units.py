"""Units in which people read a gearbox: of a turning joint, or of a drive that slides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from lostmotion.parts.gearbox.kinds import is_sliding
from lostmotion.reporting.sheet import Cell

# The sample of a figure that was stated.
STATED: Final = "the values stated"


@dataclass(frozen=True, slots=True)
class Units:
    """Units in which a gearbox on a turning joint, or a sliding drive, is shown."""

    angle: str
    torque: str
    stiffness: str
    what: str
    limit: str

    def of_angle(
        self,
        value: float,
        samples: str,
        low: float = math.nan,
        high: float = math.nan,
        ends: str = "95 % interval",
    ) -> Cell:
        """Return an angle, or a length of a sliding drive."""
        return Cell(value, self.angle, low, high, samples, ends)

    def of_torque(
        self,
        value: float,
        samples: str,
        low: float = math.nan,
        high: float = math.nan,
        ends: str = "95 % interval",
    ) -> Cell:
        """Return a torque, or a force."""
        return Cell(value, self.torque, low, high, samples, ends, stated=samples == STATED)

    def of_stiffness(self, value: float, samples: str) -> Cell:
        """Return a stiffness."""
        return Cell(value, self.stiffness, samples=samples, stated=samples == STATED)


TURNING: Final = Units("arcmin", "N m", "N m/arcmin", "torque", "turn of the output")
SLIDING: Final = Units("µm", "N", "N/µm", "force", "turn of the screw or pulley")


def units_of(gearbox: object) -> Units:
    """Return the units of this gearbox."""
    return SLIDING if is_sliding(gearbox) else TURNING
