"""An arm in a few words, as every sheet about it begins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.reporting.sheet import Cell, several

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm


def about_arm(arm: Arm) -> str:
    """Return the number of moving joints, the stated mass and the payload of an arm."""
    mass = f"{Cell(arm.mass, 'kg')}" if arm.mass else "mass not stated"
    if arm.mass and arm.gearboxes_without_mass:
        mass = f"{mass} without gearboxes of unstated mass"
    payload = (
        f"payload {Cell(arm.payload.mass, 'kg', stated=True)}" if arm.payload.mass else "no payload"
    )
    return f"{several(len(arm.moving), 'joint')}, {mass}, {payload}"
