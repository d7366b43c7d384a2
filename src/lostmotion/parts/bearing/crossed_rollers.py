"""One crossed-roller bearing from its drawing: alternating rollers are inclined in opposite
directions, so that it carries all loads.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import model_validator

from lostmotion.laws.rolling.radial import roller_pressure
from lostmotion.laws.rolling.rows import CrossedRow, RowSeat
from lostmotion.laws.rolling.table import Pair
from lostmotion.parts.bearing.pair import Count, check_sizes, refuse_drawing
from lostmotion.parts.bearing.rolling_contact import DrawnBearing
from lostmotion.parts.error_source import LengthPlus
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

_LEAN = math.pi / 4
# Contact angles at which the rollers carry both radial and axial load.
Lean = Annotated[float, Quantity("rad", "45 deg", low=0.3, high=1.3)]


class CrossedRollerBearing(DrawnBearing):
    """A crossed-roller bearing from the number and the size of its rollers.

    rollers         total number, even
    roller_length   effective length of the contact
    lean            contact angle, from the bearing's plane
    clearance       usually negative, a preload: "-5 µm ± 3 µm"
    """

    kind: Literal["crossed roller bearing"] = "crossed roller bearing"
    rollers: Count
    roller_diameter: LengthPlus
    roller_length: LengthPlus
    pitch_diameter: LengthPlus
    lean: Lean = _LEAN

    @model_validator(mode="after")
    def _is_a_bearing(self) -> Self:
        check_sizes(
            self.pitch_diameter,
            self.roller_diameter,
            self.rollers,
            self.bore,
            self.outside_diameter,
        )
        if self.clearance_error:
            raise refuse_drawing(*self.clearance_error)
        if self.rollers % 2:
            raise refuse_drawing(
                f"{self.rollers} crossed rollers",
                "an even number: their directions alternate",
                "rollers = 48",
            )
        return self

    @property
    def largest_clearance(self) -> float:
        """Return 4 % of the diameter of a roller, m."""
        return 0.04 * self.roller_diameter

    @property
    def bearings(self) -> int:
        """Return the number of bearings, 1."""
        return 1

    @property
    def rows(self) -> Pair:
        """Return the row, and the distance on the axis between the pressure centres of its two
        families of rollers.
        """
        row = CrossedRow(
            count=self.rollers, length=self.roller_length, pitch=self.pitch_diameter, lean=self.lean
        )
        return Pair((RowSeat(row),), self.pitch_diameter * math.tan(self.lean), axial=True)

    def pressure(self, load: Floats) -> Floats:
        """Return the Hertz line-contact pressure (Pa) at the inner race."""
        return roller_pressure(
            load, self.roller_length, self.roller_diameter, self.pitch_diameter, self.lean
        )
