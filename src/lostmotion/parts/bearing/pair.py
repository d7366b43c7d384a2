"""Two spaced bearings from their drawing: deep-groove or angular-contact balls, or cylindrical
rollers.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.errors import Worded
from lostmotion.laws.rolling.equilibrium import shaft_equilibrium
from lostmotion.laws.rolling.radial import ball_pressure, roller_pressure
from lostmotion.laws.rolling.rows import BallRow, RollerRow, RollingRow, RowSeat
from lostmotion.laws.rolling.table import Pair
from lostmotion.parts.bearing.rolling_contact import DrawnBearing
from lostmotion.parts.error_source import ForceAmount, LengthPlus
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

Count = Annotated[int, Field(ge=3, le=200), Worded("a whole number from 3 to 200", "9")]
Conformity = Annotated[float, Quantity("", "0.52", low=0.505, high=0.6)]
ContactAngle = Annotated[float, Quantity("rad", "25 deg", low=0, high=1.1)]


def refuse_drawing(why: str, expected: str, example: str) -> PydanticCustomError:
    """Return the validation error of an impossible bearing drawing."""
    return PydanticCustomError(
        "limits", "{why}", {"why": why, "expected": expected, "example": example}
    )


def check_sizes(pitch: float, element: float, count: int, bore: float, outside: float) -> None:
    """Refuse elements that do not fit between bore and outside, or not side by side around the
    pitch circle.
    """
    if not bore < pitch - element < pitch + element < outside:
        found = (
            f"elements of {element * 1e3:g} mm on a pitch circle of {pitch * 1e3:g} mm, in a "
            f"bearing of {bore * 1e3:g} x {outside * 1e3:g} mm"
        )
        raise refuse_drawing(
            found, "elements between bore and outside_diameter", 'pitch_diameter = "65 mm"'
        )
    if count * math.asin(min(element / pitch, 1.0)) > math.pi:
        raise refuse_drawing(
            f"{count} elements of {element * 1e3:g} mm side by side",
            "no more than fit on the pitch circle",
            "balls = 9",
        )


class BallPair(DrawnBearing):
    """Two ball bearings of one kind, `span` apart: deep-groove, or angular-contact ones mirrored to
    each other.

    balls, ball_diameter, pitch_diameter  of each bearing
    groove_conformity   radius of the inner and the outer groove over the ball's diameter
    contact_angle       0: deep groove, axial load in both directions; above 0: each in one
                        direction
    arrangement         of angular-contact bearings: "back-to-back" (pressure centres outside the
                        span) or "face-to-face"
    preload             axial force between two angular-contact bearings as mounted; they have no
                        clearance
    """

    kind: Literal["ball pair"] = "ball pair"
    balls: Count
    ball_diameter: LengthPlus
    pitch_diameter: LengthPlus
    span: LengthPlus
    groove_conformity: tuple[Conformity, Conformity] = (0.52, 0.52)
    contact_angle: ContactAngle = 0.0
    arrangement: Literal["back-to-back", "face-to-face"] = "back-to-back"
    preload: ForceAmount = 0.0

    @model_validator(mode="after")
    def _is_a_bearing(self) -> Self:
        check_sizes(
            self.pitch_diameter, self.ball_diameter, self.balls, self.bore, self.outside_diameter
        )
        if not self.contact_angle and self.preload:
            raise refuse_drawing(
                "a preload of deep-groove bearings",
                "a preload of angular-contact ones only",
                'contact_angle = "25 deg"',
            )
        if self.contact_angle and (self.clearance.nominal or self.clearance.tolerance):
            raise refuse_drawing(
                "a clearance of angular-contact bearings",
                "their preload instead",
                'preload = "200 N"',
            )
        if self.clearance_error:
            raise refuse_drawing(*self.clearance_error)
        if self.preload > self.balls * self.static_load:
            found = f"a preload of {self.preload:.4g} N"
            raise refuse_drawing(
                found,
                f"at most {self.balls * self.static_load:.4g} N, the balls' static limit",
                'preload = "200 N"',
            )
        if self.rows.span <= 0:
            raise refuse_drawing(
                "face-to-face bearings so close that their pressure centres coincide",
                "a longer span, or back-to-back",
                'arrangement = "back-to-back"',
            )
        return self

    @property
    def elements(self) -> Literal["ball", "roller"]:
        """Return the kind of rolling element."""
        return "ball"

    @property
    def largest_clearance(self) -> float:
        """Return nine tenths of the clearance between ball and grooves, m."""
        return 0.9 * (sum(self.groove_conformity) - 1) * self.ball_diameter

    @property
    def bearings(self) -> int:
        """Return the number of bearings, 2."""
        return 2

    @property
    def rows(self) -> Pair:
        """Return the two rows, one of them mirrored for angular contact."""
        row = BallRow(
            count=self.balls,
            ball=self.ball_diameter,
            pitch=self.pitch_diameter,
            grooves=self.groove_conformity,
            contact_angle=self.contact_angle,
        )
        if not self.contact_angle:
            return _spaced(row, self.span, axial=True)
        back = self.arrangement == "back-to-back"
        preload_shift = (
            float(
                shaft_equilibrium(
                    [RowSeat(row)], [[0.0, 0.0, self.preload, 0.0, 0.0]]
                ).displacement[0, 2]
            )
            if self.preload
            else 0.0
        )
        out = self.span / 2 if back else -self.span / 2
        seats = (
            RowSeat(row, -out, preload_shift=preload_shift),
            RowSeat(row, out, mirrored=True, preload_shift=preload_shift),
        )
        beyond = self.pitch_diameter * math.tan(self.contact_angle)
        return Pair(
            seats if back else seats[::-1],
            self.span + beyond if back else self.span - beyond,
            axial=True,
        )

    def pressure(self, load: Floats) -> Floats:
        """Return the Hertz point-contact pressure (Pa) at the inner groove."""
        return ball_pressure(
            load,
            self.ball_diameter,
            self.pitch_diameter,
            self.groove_conformity[0],
            self.contact_angle,
        )


class RollerPair(DrawnBearing):
    """Two cylindrical roller bearings of one kind, `span` apart; they carry no axial load.

    rollers, roller_diameter, roller_length, pitch_diameter  of each bearing; the length is the
                                                             effective one, without the rounded ends
    """

    kind: Literal["roller pair"] = "roller pair"
    rollers: Count
    roller_diameter: LengthPlus
    roller_length: LengthPlus
    pitch_diameter: LengthPlus
    span: LengthPlus

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
        return self

    @property
    def largest_clearance(self) -> float:
        """Return 4 % of the diameter of a roller, m."""
        return 0.04 * self.roller_diameter

    @property
    def bearings(self) -> int:
        """Return the number of bearings, 2."""
        return 2

    @property
    def rows(self) -> Pair:
        """Return the two rows of crowned rollers."""
        row = RollerRow(
            count=self.rollers,
            length=self.roller_length,
            roller=self.roller_diameter,
            pitch=self.pitch_diameter,
        )
        return _spaced(row, self.span, axial=False)

    def pressure(self, load: Floats) -> Floats:
        """Return the Hertz line-contact pressure (Pa) at the inner race, uniform along the
        roller.
        """
        return roller_pressure(load, self.roller_length, self.roller_diameter, self.pitch_diameter)


def _spaced(row: RollingRow, span: float, *, axial: bool) -> Pair:
    return Pair((RowSeat(row, -span / 2), RowSeat(row, span / 2)), span, axial)
