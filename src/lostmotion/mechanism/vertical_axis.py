"""The vertical axis about which an arm turns as a whole."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from lostmotion.mechanism.state import state_of

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm

# Horizontal part of a unit vector that is vertical but for rounding.
_UPRIGHT: Final = 1e-9


def vertical_axis(arm: Arm) -> tuple[float, float] | None:
    """Return the position (x, y; m) of the first joint's axis in the base's axes if that joint
    turns the whole arm about a vertical axis; else None.
    """
    place = arm.tree.moved[arm.tree.tool_joints[0]]
    if not arm.tree.moves_tool <= arm.tree.outboard(place) | arm.tree.inboard(place):
        return None  # loops around the joint
    at = state_of(arm, arm.home).frames[place, 0]
    axis = at[:3, :3] @ arm.tree.places[place].twist[:3, 0]  # zero for a joint that slides
    upright = axis.any() and math.hypot(axis[0], axis[1]) <= _UPRIGHT
    return (float(at[0, 3]), float(at[1, 3])) if upright else None
