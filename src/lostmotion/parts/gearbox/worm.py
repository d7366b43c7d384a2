"""A worm and its wheel, ordinary or duplex."""

from __future__ import annotations

import math
from typing import Annotated, Final, Literal, Self

from pydantic import model_validator

from lostmotion.laws.gears import duplex_take_up, friction_angle
from lostmotion.parts.error_source import AngleAmount, LengthAmount, LengthPlus, PartFigure
from lostmotion.parts.gearbox.counts import Whole, teeth
from lostmotion.parts.gearbox.gearbox import TurningFigures, refuse
from lostmotion.parts.provenance import Sourced
from lostmotion.units import Quantity, Toleranced

_DEGREE: Final = math.pi / 180
_MILLIMETRE: Final = 1e-3
_DUPLEX_EXAMPLE: Final = (
    'duplex = { left_lead = "6.2 mm", right_lead = "6.4 mm", shift = "0.5 mm" }'
)


class Duplex(Sourced):
    """A worm whose flanks have two leads, so that its thread thickens along the axis: an axial
    shift by `shift` reduces the play.
    """

    left_lead: LengthPlus
    right_lead: LengthPlus
    shift: LengthAmount = 0.0


class WormGearbox(TurningFigures):
    """A worm gear; data-sheet figures as in `Gearbox`, and numbers of teeth.

    starts, wheel_teeth   threads of the worm, teeth of the wheel
    lead_angle, friction_coefficient  with both, `locking_reserve` shows whether the wheel can drive
                                      the worm; pressure_angle is the normal one duplex        a
                                      worm of two leads, and its shift since the stated backlash (or
                                      lost motion) was measured
    worm_error, wheel_error, mesh_error  amplitude at the output of the harmonic of each: once per
                                         turn of the worm, of the wheel, once per
                  tooth of the wheel
    """

    kind: Literal["worm"] = "worm"
    starts: Annotated[int, Whole("", "1", low=1, high=100)] = 1
    wheel_teeth: Annotated[int, teeth("60")]
    lead_angle: Annotated[float, Quantity("rad", "4.5 deg", above=0, high=80 * _DEGREE)] | None = (
        None
    )
    friction_coefficient: Annotated[float, Quantity("", "0.06", low=0, high=1)] | None = None
    pressure_angle: Annotated[float, Quantity("rad", "20 deg", low=0, high=45 * _DEGREE)] = (
        20 * _DEGREE
    )
    duplex: Duplex | None = None
    worm_error: AngleAmount = 0.0
    wheel_error: AngleAmount = 0.0
    mesh_error: AngleAmount = 0.0

    @property
    def ratio(self) -> float:
        """Return the turns of the worm per turn of the wheel."""
        return self.wheel_teeth / self.starts

    @property
    def locking_reserve(self) -> float | None:
        """Return the friction angle less the lead angle (rad): above zero the wheel cannot drive
        the worm at rest; None where one is not stated.

        Vibration lowers friction, so that a small reserve is not safe.
        """
        if self.lead_angle is None or self.friction_coefficient is None:
            return None
        return friction_angle(self.friction_coefficient, self.pressure_angle) - self.lead_angle

    @property
    def play(self) -> Toleranced:
        """Return the free play, as stated or computed from the lost motion, less the reduction by a
        duplex worm.
        """
        stated = self._stated_play
        return Toleranced(max(stated.nominal - self._take_up(), 0.0), stated.tolerance, stated.law)

    def _take_up(self) -> float:
        return (
            0.0
            if self.duplex is None
            else duplex_take_up(
                self.duplex.shift, (self.duplex.left_lead, self.duplex.right_lead), self.ratio
            )
        )

    @model_validator(mode="after")
    def _turns_freely(self) -> Self:
        if self.starts > self.wheel_teeth:
            found = f"a worm of {self.starts} starts on a wheel of {self.wheel_teeth} teeth"
            raise refuse(
                found,
                "a wheel with at least as many teeth as the worm has starts",
                f"starts = {self.wheel_teeth}",
            )
        if self.duplex is None:
            return self
        if self.duplex.left_lead == self.duplex.right_lead:
            raise refuse(
                "a duplex worm of two equal leads",
                "different leads: otherwise a shift does not reduce the play",
                _DUPLEX_EXAMPLE,
            )
        least = self._stated_play.nominal - self._stated_play.tolerance
        if self._take_up() > least * (1 + 1e-9):
            shift = self.duplex.shift * least / self._take_up()
            raise refuse(
                (
                    f"a shift of {self.duplex.shift / _MILLIMETRE:.4g} mm, which reduces the play "
                    "by more than its lower limit"
                ),
                "a smaller shift, which leaves some play",
                f'shift = "{math.floor(shift / _MILLIMETRE * 1e4) / 1e4:g} mm"',
            )
        return self

    @property
    def own_figures(self) -> list[PartFigure]:
        """Return the locking reserve, where it is known."""
        note = "friction angle less lead angle: above zero the wheel cannot drive the worm at rest"
        return (
            []
            if self.locking_reserve is None
            else [PartFigure("locking reserve", self.locking_reserve, "rad", note)]
        )

    def _own_harmonics(self) -> list[tuple[str, float, float]]:
        return [
            ("worm", self.worm_error, self.ratio),
            ("wheel", self.wheel_error, 1.0),
            ("mesh", self.mesh_error, float(self.wheel_teeth)),
        ]
