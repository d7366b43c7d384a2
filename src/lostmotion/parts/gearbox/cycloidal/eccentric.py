"""The eccentric of a stage with its bearings, as a drawing states them."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import model_validator

from lostmotion.parts.error_source import (
    AngularStiffness,
    ClearanceDim,
    LengthAmount,
    LengthPlus,
    LinearStiffness,
)
from lostmotion.parts.gearbox.counts import Whole
from lostmotion.parts.gearbox.cycloidal.seats import BearingSize
from lostmotion.parts.gearbox.cycloidal.shaft import Shaft
from lostmotion.parts.gearbox.gearbox import refuse
from lostmotion.parts.provenance import Sourced
from lostmotion.units import Toleranced


class Eccentric(Sourced):
    """The eccentric with its bearings, one per disc and crankshaft.

    clearance       diametral working clearance of each bearing
    position        ± position of each disc's bore, in both directions: relative to the flank and,
                    with several crankshafts, relative to these rollers, roller_length   its rolling
                    elements, or:
    bearing         its radial stiffness, or the bore and outside_diameter of a ball bearing
    cup             thickness of the drawn cup of its needle bearing, which bends in the bore of the
                    disc; default: a rigid outer ring
    offset          of a disc's mid-plane from that of its bearing: the disc tilts, if the bearing
                    resists it
    tilt            its stiffness against tilting; default: that of its rollers
    shaft           stiffness of the shaft with its seats, at one disc; or a table of its sections,
                    bearings and seats
    cranks, circle_radius    several crankshafts that carry the output, as in an RV reducer;
                             default: one central eccentric
    """

    clearance: ClearanceDim = Toleranced(0.0)
    position: LengthAmount = 0.0
    rollers: Annotated[int, Whole("", "16", low=3, high=200)] | None = None
    roller_length: LengthPlus | None = None
    bearing: LinearStiffness | BearingSize | None = None
    cup: LengthPlus | None = None
    offset: LengthAmount = 0.0
    tilt: AngularStiffness | None = None
    shaft: LinearStiffness | Shaft | None = None
    cranks: Annotated[int, Whole("", "2", low=1, high=8)] = 1
    circle_radius: LengthPlus | None = None

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if (self.rollers is None) != (self.roller_length is None) or (
            self.rollers is not None and self.bearing is not None
        ):
            expected = (
                "rollers with roller_length, or a bearing by its stiffness or size, or neither "
                "(bounded)"
            )
            raise refuse(
                "an incomplete or doubly stated bearing of the eccentric",
                expected,
                'rollers = 16, roller_length = "10 mm"',
            )
        if self.cup is not None and (self.rollers is None or self.cranks > 1):
            raise refuse(
                "a cup without the rollers of one central eccentric",
                "a needle bearing in a cup",
                'rollers = 16, roller_length = "10 mm"',
            )
        if self.offset and self.tilt is None and self.rollers is None:
            expected = (
                "a bearing that resists tilting: rollers with roller_length, or its tilt "
                "stiffness (otherwise the flanks carry the disc)"
            )
            raise refuse(
                "an offset of the discs from bearings that do not resist tilting",
                expected,
                'tilt = "500 N m/rad"',
            )
        if (self.cranks > 1) != (self.circle_radius is not None):
            raise refuse(
                (
                    f"{self.cranks} crank{'s' if self.cranks > 1 else ''} "
                    f"{'with' if self.circle_radius else 'without'} circle_radius"
                ),
                (
                    "two or more cranks with the radius of their circle, or one central crank "
                    "without it"
                ),
                'cranks = 3, circle_radius = "36 mm"',
            )
        return self
