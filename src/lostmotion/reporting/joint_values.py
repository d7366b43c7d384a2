"""Joint values of a pose and its tool point as text."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


def joint_value(name: str, kind: str, value: float) -> str:
    """Return a joint's name and its value, in degrees or millimetres; `kind` as `Joint.type`,
    "revolute" or "prismatic".
    """
    size, unit = (math.degrees(value), "°") if kind == "revolute" else (value * 1e3, " mm")
    return f"{name} {round(size, 1) + 0.0:.1f}{unit}"  # without the sign of a zero


def joint_values(arm: Arm, q: Floats) -> str:
    """Return the values q (joint,) of all joints of the arm."""
    return ", ".join(
        joint_value(joint.name, joint.type, value)
        for joint, value in zip(arm.driven, q, strict=True)
    )


def tool_place(tool: Floats) -> str:
    """Return where the tool point (3,), m, is in the base's frame, in whole millimetres."""
    x, y, z = 1e3 * tool
    return f"tool at x {x:.0f}, y {y:.0f}, z {z:.0f} mm".replace("-", "−")
