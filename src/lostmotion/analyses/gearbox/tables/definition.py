"""Definition of a stiffness as text, to be printed beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.printed import stated_text

if TYPE_CHECKING:
    from lostmotion.analyses.gearbox.tables.units import Units
    from lostmotion.laws.torque_angle import Definitions


def definition_text(asked: Definitions, units: Units) -> str:
    """Return the definition of the stiffness asked for, with its torques."""
    load = f"{stated_text(asked.torque)} {units.torque}"
    if asked.stiffness == "secant":
        return f"secant from the middle of the play to {load}"
    if asked.stiffness == "tangent":
        return f"tangent at {load}"
    if asked.span is None:
        raise ValueError("no torques for the stiffness")
    low, high = asked.span
    name = "b/a of the hysteresis curve" if asked.stiffness == "b/a" else "slope"
    return f"{name} from {stated_text(low)} to {stated_text(high)} {units.torque}"
