"""Closures as an arm file states them: pairs of places that are one frame."""

from __future__ import annotations

from lostmotion.parts.error_source import Part
from lostmotion.parts.frame import Frame
from lostmotion.parts.moving_joint import PlaceName


class Closure(Part):
    """A closure: two frames on different branches that are one frame of one body.

    joins   names of the two places
    frames  the frame of that body in each of the two places; default: their own
    """

    joins: tuple[PlaceName, PlaceName]
    frames: tuple[Frame, Frame] = (Frame(), Frame())
