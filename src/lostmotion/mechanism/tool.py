"""The tool of an arm, and its payload."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, ClassVar, Final

import numpy as np
from pydantic import Field

from lostmotion.parts.error_source import Force, Mass, Price, Torque
from lostmotion.parts.frame import Frame, Vector
from lostmotion.parts.moving_joint import PlaceName
from lostmotion.parts.provenance import Sourced

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Largest share of a payload; more is a mistaken unit.
MOST_LOAD: Final = 2.0

FromTheToolPoint = Annotated[
    Vector, Field(description="x, y, z from the tool point, in the axes of the tool frame")
]
FromTheFlange = Annotated[
    Vector,
    Field(
        description=(
            "x, y, z from the place that the tool is fixed to (the flange), in its axes, not in "
            "the tool frame; default: the tool point"
        )
    ),
]
OfTheTool = Field(description="x, y, z in the axes of the tool frame; it acts at the tool point")


class Payload(Sourced):
    """A mass held by the tool, and a process force and moment.

    mass            kg
    centre_of_mass  from the tool point, in the axes of the tool frame, m
    force, moment   on the tool point, in the axes of the tool frame, N and N m
    """

    shareable: ClassVar[bool] = False
    mass: Mass = 0.0
    centre_of_mass: FromTheToolPoint = (0.0, 0.0, 0.0)
    force: Annotated[tuple[Force, Force, Force], OfTheTool] = (0.0, 0.0, 0.0)
    moment: Annotated[tuple[Torque, Torque, Torque], OfTheTool] = (0.0, 0.0, 0.0)


class Tool(Sourced):
    """The tool frame, and the mass of the tool itself.

    frame           pose of the tool relative to the place that it is fixed to
    mass            kg, without the payload
    price           of the tool
    centre_of_mass  from the place that the tool is fixed to (the mounting flange), in its axes, m:
                    as makers of grippers and robot controllers state it. It is not seen in the tool
                    frame. Default: the tool point
    after           name of the place that the tool is fixed to; by default the tip of the last
                    joint
    """

    shareable: ClassVar[bool] = False
    frame: Frame = Frame()
    mass: Mass = 0.0
    price: Price | None = None
    centre_of_mass: FromTheFlange | None = None
    after: PlaceName | None = None

    @functools.cached_property
    def mass_centre(self) -> Floats:
        """Return the centre of mass in the tool frame (3,), m; the tool point where none is
        stated.
        """
        if self.centre_of_mass is None:
            return np.zeros(3)
        return np.asarray(
            self.frame.pose[:3, :3].T @ (np.array(self.centre_of_mass) - self.frame.pose[:3, 3])
        )
