"""The tool of an arm, and its payload."""

from __future__ import annotations

from typing import ClassVar

from lostmotion.parts.error_source import Force, Mass, Price, Torque
from lostmotion.parts.frame import Frame, Vector
from lostmotion.parts.joint import PlaceName
from lostmotion.parts.provenance import Sourced


class Payload(Sourced):
    """A mass (kg) with its centre of mass (m) in the tool frame, and a process force (N) and moment (N m) on the tool point, in the tool's axes."""

    shareable: ClassVar[bool] = False
    mass: Mass = 0.0
    centre_of_mass: Vector = (0.0, 0.0, 0.0)
    force: tuple[Force, Force, Force] = (0.0, 0.0, 0.0)
    moment: tuple[Torque, Torque, Torque] = (0.0, 0.0, 0.0)


class Tool(Sourced):
    """The tool frame, and the mass of the tool itself.

    frame           pose of the tool relative to the place that it is fixed to
    mass            kg, without the payload
    price           of the tool
    centre_of_mass  in the tool frame, m
    after           name of the place that the tool is fixed to; by default the tip of the last joint
    """

    shareable: ClassVar[bool] = False
    frame: Frame = Frame()
    mass: Mass = 0.0
    price: Price | None = None
    centre_of_mass: Vector = (0.0, 0.0, 0.0)
    after: PlaceName | None = None
