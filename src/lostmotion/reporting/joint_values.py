"""Joint values of a pose as text."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


def joint_value(name: str, kind: str, value: float) -> str:
    """Return a joint's name and its value, in degrees or millimetres; `kind` as `Joint.type`, "revolute" or "prismatic"."""
    return f"{name} {math.degrees(value):.1f}°" if kind == "revolute" else f"{name} {value * 1e3:.1f} mm"


def joint_values(arm: Arm, q: Floats) -> str:
    """Return the values q (joint,) of all joints of the arm."""
    return ", ".join(joint_value(joint.name, joint.type, value) for joint, value in zip(arm.moving, q, strict=True))
