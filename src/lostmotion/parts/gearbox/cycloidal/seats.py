"""Seats of bearings in plates and housings, and ball bearings of which only the size is known, as a
drawing states them.
"""

from __future__ import annotations

import functools
import math
from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from lostmotion.laws.annulus import Annulus, Plane
from lostmotion.laws.cycloid.seat import seat_compliance
from lostmotion.parts.error_source import LengthPlus, Line
from lostmotion.parts.gearbox.cycloidal.pins import EXTREME_FITS, UNKNOWN_FIT, Fit
from lostmotion.parts.gearbox.gearbox import refuse
from lostmotion.parts.material import Material
from lostmotion.parts.provenance import Sourced

Named = Annotated[Line, Field(max_length=80)]


class BearingSeat(Sourced):
    """The seat of a bearing in a plate or housing.

    diameter        of the bore; outer_diameter of the material around it: material farther away
                    counts as rigid
    width           of the bearing's ring
    fit             "bonded" (glued, moulded in), "pressed", or "snug" (without preload: the contact
                    opens behind the bearing); default: between bonded and snug, the geometric mean
                    of their compliances
    """

    assumed_unless_stated: ClassVar[dict[str, str]] = UNKNOWN_FIT
    material: Material
    diameter: LengthPlus
    outer_diameter: LengthPlus
    width: LengthPlus
    fit: Fit | None = None

    @model_validator(mode="after")
    def _encloses(self) -> Self:
        if self.outer_diameter <= self.diameter:
            why = (
                f"an outer_diameter of {self.outer_diameter * 1e3:g} mm around a bore of "
                f"{self.diameter * 1e3:g} mm"
            )
            raise refuse(
                why, "material around the bore", f'outer_diameter = "{2e3 * self.diameter:.3g} mm"'
            )
        return self

    @functools.cached_property
    def compliances(self) -> tuple[float, float]:
        """Return the smallest and largest shift of the bearing per force, m/N, for a fit that is
        not stated; else both are that of the fit.

        Plane strain for a seat wider than its bore, else plane stress.
        """
        plane: Plane = "strain" if self.width > self.diameter else "stress"
        body = Annulus(
            self.diameter / 2,
            self.outer_diameter / 2,
            self.width,
            self.material.plate_modulus,
            self.material.poisson,
            plane,
        )
        low, high = (seat_compliance(body, self.fit or each) for each in EXTREME_FITS)
        return low, high

    @property
    def compliance(self) -> float:
        """Return the shift of the bearing per force (m/N): the geometric mean for a fit that is not
        stated.
        """
        return math.sqrt(math.prod(self.compliances))


class BearingSize(Sourced):
    """A deep groove ball bearing by its size alone: its stiffness is then known to a factor of 0.7
    to 1.4.
    """

    bore: LengthPlus
    outside_diameter: LengthPlus

    @model_validator(mode="after")
    def _has_room(self) -> Self:
        if self.outside_diameter <= self.bore:
            why = (
                f"an outside_diameter of {self.outside_diameter * 1e3:g} mm around a bore of "
                f"{self.bore * 1e3:g} mm"
            )
            raise refuse(why, "room for balls", 'bore = "10 mm", outside_diameter = "26 mm"')
        return self
