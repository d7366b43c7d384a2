"""Outer size of sections along a link, for pictures."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np

from lostmotion.parts.profile import Composite, Stepped, Tapered
from lostmotion.parts.section import CustomSection, Outline, Rod, Tube

if TYPE_CHECKING:
    from lostmotion.parts.profile import CrossSection, Section

Size: TypeAlias = tuple[float, float]
RoundOrBox: TypeAlias = Literal["round", "box"]


class OuterPiece(NamedTuple):
    """A piece of a link from `start` to `end` (m along the link), with its outer width and height
    (m) at both ends.
    """

    start: float
    end: float
    form: RoundOrBox
    near: Size
    far: Size

    @property
    def middle(self) -> float:
        """Return the middle of the piece along the link, m."""
        return (self.start + self.end) / 2

    @property
    def length(self) -> float:
        """Return the length of the piece, m."""
        return self.end - self.start


def outer_sizes(section: Section, length: float) -> list[OuterPiece]:
    """Return the outer sizes of a link of this length (m) and section, piece by piece from the
    joint on.

    Tubes and rods are round. Other sections have the size of their bounding box, and a custom
    section is a circle of equal area.
    """
    if isinstance(section, Tapered):
        stretch = length / section.length
        ends = [(station.at * stretch, *_outer(station.section)) for station in section.stations]
        return [
            OuterPiece(start, end, form, near, far)
            for (start, form, near), (end, _, far) in itertools.pairwise(ends)
            if start < end
        ]
    steps = (
        [(step.length, step.section) for step in section.steps]
        if isinstance(section, Stepped)
        else [(length, section)]
    )
    at = np.cumsum([0.0, *(each for each, _ in steps)])
    at *= length / at[-1]
    sizes = [_outer(each) for _, each in steps]
    return [
        OuterPiece(start, end, form, size, size)
        for (start, end), (form, size) in zip(itertools.pairwise(at.tolist()), sizes, strict=True)
    ]


def _outer(section: CrossSection) -> tuple[RoundOrBox, Size]:
    if isinstance(section, Tube | Rod):
        return "round", (section.height, section.height)
    if isinstance(section, CustomSection):
        diameter = 2 * math.sqrt(section.area / math.pi)
        return "round", (diameter, diameter)
    if isinstance(section, Outline):
        return "box", (float(np.ptp([y for y, _ in section.points])), section.height)
    if isinstance(section, Composite):
        layers = [(*_outer(layer.section), layer.offset) for layer in section.layers]
        low, high = (
            f(offset + side * size[1] / 2 for _, size, offset in layers)
            for f, side in ((min, -1), (max, 1))
        )
        form: RoundOrBox = (
            "round" if all(form == "round" and not offset for form, _, offset in layers) else "box"
        )
        return form, (max(size[0] for _, size, _ in layers), high - low)
    return "box", (section.width, section.height)
