"""A ball screw, whose stiffness follows the position of its nut."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar, Literal, Self

from pydantic import model_validator

from lostmotion.laws.linear_drives import screw_compliance
from lostmotion.parts.error_source import LengthPlus, LinearStiffness
from lostmotion.parts.gearbox.gearbox import refuse
from lostmotion.parts.gearbox.slide import SlideFigures

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


class BallScrew(SlideFigures):
    """A ball screw of steel; figures as in `SlideFigures`.

    root_diameter      of the screw
    length             between its two bearings
    start              from the bearing on the motor's side to the nut where the joint's value is
                       zero; it grows with that value
    support            "fixed-free": the far bearing holds the screw across its axis only;
                       "fixed-fixed": both hold it axially
    nut_stiffness      axial, of the nut and its seat; default: rigid
    bearing_stiffness  axial, of each bearing that holds the screw axially; default: rigid
    """

    kind: Literal["ball screw"] = "ball screw"
    described_by: ClassVar[dict[str, tuple[str, ...]]] = {"stiffness": ("root_diameter",)}
    root_diameter: LengthPlus
    length: LengthPlus
    start: LengthPlus
    support: Literal["fixed-free", "fixed-fixed"] = "fixed-free"
    nut_stiffness: LinearStiffness | None = None
    bearing_stiffness: LinearStiffness | None = None

    @model_validator(mode="after")
    def _starts_on_the_screw(self) -> Self:
        if self.start >= self.length:
            raise refuse(
                "a start beyond the length of the screw",
                "a start shorter than length",
                'length = "600 mm", start = "80 mm"',
            )
        return self

    def compliance_at(self, position: Floats) -> Floats:
        """Return the compliance (m/N) of screw, nut and bearings at joint values (any shape), m."""
        bearing = self.bearing_stiffness or math.inf
        far = bearing if self.support == "fixed-fixed" else None
        at, nut = self.start + position, self.nut_stiffness or math.inf
        return screw_compliance(
            at,
            self.length,
            self.root_diameter,
            lead=self.lead,
            nut=nut,
            near_bearing=bearing,
            far_bearing=far,
        )

    def range_error(self, limits: tuple[float, float]) -> tuple[str, str, str] | None:
        """Return what was found, what is expected and an example where the nut would leave the
        screw within a joint's range.
        """
        if self.start + limits[0] > 0 and self.start + limits[1] < self.length:
            return None
        expected = (
            f"the nut between the bearings at both limits: start above {-limits[0]:g} m, length "
            f"above start + {limits[1]:g} m"
        )
        return (
            "a range in which the nut leaves the screw",
            expected,
            'length = "600 mm", start = "80 mm"',
        )
