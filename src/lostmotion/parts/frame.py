"""Frames and directions."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Annotated, Final, Literal

import numpy as np
from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from lostmotion.parts.error_source import Angle, Length, Part
from lostmotion.spatial import pose_of

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

Vector = Annotated[tuple[Length, Length, Length], Field(description="x, y, z, each with its unit")]


def _is_direction(stated: str | tuple[float, float, float]) -> str | tuple[float, float, float]:
    with np.errstate(over="ignore"):  # an overflowing length is infinite, and refused
        length = float(np.linalg.norm(stated)) if isinstance(stated, tuple) else 1.0
    if not 0 < length < math.inf:  # never true of a NaN
        context = {
            "why": f"the direction {list(stated)}",
            "expected": "a finite direction that is not zero",
            "example": "[0, 0, 1]",
        }
        raise PydanticCustomError("direction", "{why}", context)
    return stated


Direction = Annotated[
    Literal["x", "y", "z", "-x", "-y", "-z"] | tuple[float, float, float],
    AfterValidator(_is_direction),
]


class Frame(Part):
    """A frame in its parent frame: xyz, then roll, pitch, yaw about the fixed x, y, z axes (as in
    URDF).
    """

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)

    @functools.cached_property
    def pose(self) -> Floats:
        """Return the frame as a pose (4, 4)."""
        return pose_of(self.xyz, self.rpy)


_AXES: Final = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def unit(direction: Direction) -> Floats:
    """Return the unit vector (3,) of a direction."""
    if isinstance(direction, str):
        sign = -1.0 if direction.startswith("-") else 1.0
        return sign * np.array(_AXES[direction[-1]])
    vector = np.array(direction, dtype=float)
    return np.asarray(vector / math.sqrt(float(vector @ vector)))
