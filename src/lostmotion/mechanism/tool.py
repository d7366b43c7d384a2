"""The tool of an arm, and what it carries."""

from __future__ import annotations

from typing import ClassVar

from lostmotion.parts.error_source import Force, Mass, Torque
from lostmotion.parts.frame import Frame, Vector
from lostmotion.parts.joint import PlaceName
from lostmotion.parts.provenance import Sourced


class Payload(Sourced):
    """A mass with its centre in the tool frame, and a process force and moment in the tool's axes."""

    shareable: ClassVar[bool] = False
    mass: Mass = 0.0
    centre_of_mass: Vector = (0.0, 0.0, 0.0)
    force: tuple[Force, Force, Force] = (0.0, 0.0, 0.0)
    moment: tuple[Torque, Torque, Torque] = (0.0, 0.0, 0.0)


class Tool(Sourced):
    """The tool frame, and what the tool itself weighs.

    frame  seen from the place that the tool is fixed to
    after  name of that place; by default the tip of the last joint
    """

    shareable: ClassVar[bool] = False
    frame: Frame = Frame()
    mass: Mass = 0.0
    centre_of_mass: Vector = (0.0, 0.0, 0.0)
    after: PlaceName | None = None
