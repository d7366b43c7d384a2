"""An arm in a few words, as every sheet about it begins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.parts.joint import has_drive
from lostmotion.reporting.sheet import Cell, several

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm


def about_arm(arm: Arm) -> str:
    """Return the numbers of driven and passive joints, the mass and the payload of an arm."""
    mass = f"{Cell(arm.mass, 'kg')}" if arm.mass else "mass not stated"
    if arm.mass and arm.gearboxes_without_mass:
        mass = f"{mass} without gearboxes of unstated mass"
    payload = (
        f"payload {Cell(arm.payload.mass, 'kg', stated=True)}" if arm.payload.mass else "no payload"
    )
    passive = passive_joints(arm)
    joints = several(len(arm.driven), "driven joint" if passive else "joint")
    also = f" and {passive} passive" if passive else ""
    return f"{joints}{also}, {mass}, {payload}"


def passive_joints(arm: Arm) -> int:
    """Return the number of joints that move without a drive, balls and universal ones too."""
    return sum(joint.type != "fixed" and not has_drive(joint) for joint in arm.joints)
