"""The frame of a cycloidal gearbox by its dimensions: a tube, and the screws that transmit the
torque, as a drawing states them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Self

import numpy as np
from pydantic import model_validator

from lostmotion.laws import screw_circle as laws
from lostmotion.laws.cycloid.output_pins import ElasticPinSeat
from lostmotion.parts.error_source import ForceAmount, LengthAmount, LengthPlus
from lostmotion.parts.gearbox.counts import Whole
from lostmotion.parts.gearbox.cycloidal.pins import STEEL
from lostmotion.parts.gearbox.gearbox import refuse
from lostmotion.parts.material import Material
from lostmotion.parts.provenance import DEFAULT, Sourced
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


class FrameScrews(Sourced):
    """Screws on a circle that transmit the torque of the gearbox.

    count, circle_radius  their number and the radius of their circle
    size                  metric thread, such as "M3"
    material              of the body that they push on, in a snug seat
    depth                 of this seat; default: twice the diameter of the screw
    preload, friction     of each screw, and the coefficient between the bodies: below the torque at
                          which the joint slips it is rigid; default: no preload, because plastics
                          lose it
    clearance             diametral, of a screw in its hole: the joint turns by it once it slips
    """

    assumed_unless_stated: ClassVar[dict[str, str]] = {
        "preload": f"{DEFAULT}, none, because plastics lose it",
        "depth": f"{DEFAULT}, twice the diameter of the screw",
    }
    count: Annotated[int, Whole("", "8", low=2, high=1000)]
    circle_radius: LengthPlus
    size: laws.Thread
    material: Material
    depth: LengthPlus | None = None
    preload: ForceAmount = 0.0
    friction: Annotated[float, Quantity("", "0.15", low=0, high=2)] = 0.15
    clearance: LengthAmount = 0.0

    @property
    def stiffness(self) -> float:
        """Return the torsional stiffness (N m/rad) of the circle once it slips."""
        diameter = laws.nominal_diameter(self.size)
        depth = self.depth or 2 * diameter
        seat = ElasticPinSeat(
            depth, diameter / 2 + depth, self.material.plate_modulus, self.material.poisson, "snug"
        )
        each = laws.screw_stiffness(self.size, STEEL.young, STEEL.poisson, seat)
        return laws.circle_stiffness(self.count, self.circle_radius, each)

    @property
    def slip(self) -> float:
        """Return the torque (N m) below which the joint is rigid."""
        return laws.slip_torque(self.count, self.circle_radius, self.preload, self.friction)

    def wind_up(self, torque: Floats) -> Floats:
        """Return the rotation (rad) under torques (torque,) above zero; that of a joint without
        preload excludes its play.
        """
        slipping = np.maximum(torque - self.slip, 0.0)
        closed = np.where(
            (slipping > 0) & (self.slip > 0), self.clearance / (2 * self.circle_radius), 0.0
        )
        return np.asarray(slipping / self.stiffness + closed)

    @property
    def play(self) -> float:
        """Return the play (rad) of a joint that nothing holds by friction; zero with preload."""
        return 0.0 if self.slip else self.clearance / self.circle_radius


class FrameTube(Sourced):
    """The housing as a tube in torsion: mean radius of its wall, thickness of the wall, length."""

    radius: LengthPlus
    wall: LengthPlus
    length: LengthPlus
    material: Material = STEEL

    @model_validator(mode="after")
    def _has_a_bore(self) -> Self:
        if self.wall >= 2 * self.radius:
            raise refuse(
                f"a wall of {self.wall * 1e3:g} mm on a mean radius of {self.radius * 1e3:g} mm",
                "a hollow tube",
                'wall = "4 mm"',
            )
        return self

    @property
    def stiffness(self) -> float:
        """Return the torsional stiffness, N m/rad."""
        return laws.tube_stiffness(
            self.radius, self.wall, self.length, self.material.shear * self.material.infill
        )


class GearboxFrame(Sourced):
    """The frame by its dimensions: screws on a circle, and the housing as a tube; a housing that is
    not stated is bounded.
    """

    screws: FrameScrews | None = None
    tube: FrameTube | None = None

    @model_validator(mode="after")
    def _states_something(self) -> Self:
        if self.screws is None and self.tube is None:
            raise refuse(
                "a frame without screws and tube",
                "one of the two, or a stiffness",
                'tube = { radius = "45 mm", wall = "4 mm", length = "30 mm" }',
            )
        return self
