"""Members of a cycloidal stage as lines of the error budget: the wind-up of each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.cycloid import wind_up
from lostmotion.laws.cycloid.output_pins import largest_pin_force, needle_compliance
from lostmotion.parts.gearbox.cycloidal.names import (
    BEARING,
    BORE,
    HOLES,
    NEEDLES,
    PINS,
    SEATS,
    SHAFT,
    SHAFT_BEARINGS,
    SHAFT_SEATS,
    TILT,
)
from lostmotion.parts.gearbox.cycloidal.pins import middle_compliance

if TYPE_CHECKING:
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.spatial import Floats


def stage_wind_up(stage: CycloidalStage, torque: Floats) -> dict[str, Floats]:
    """Return the nominal wind-up (torque,), rad, of each member of a stage under torques (torque,)
    above zero on its discs, beyond the play.

    Raises DidNotConvergeError where a load is beyond the contact law.
    """
    found = wind_up.wind_up_by_member(stage.drive, torque)
    tilt = stage.tilt_share
    if tilt:
        found |= {BEARING: found[BEARING] / (1 + tilt), TILT: found[BEARING] * tilt / (1 + tilt)}
    return found | _shaft(stage, found[SHAFT]) | _pins(stage, torque)


def _shaft(stage: CycloidalStage, whole: Floats) -> dict[str, Floats]:
    """Return the wind-up of the members of the eccentric's shaft and of its bearing's seat, which
    add up to that of the `whole`.
    """
    springs = stage.shaft_springs
    if springs is None and not stage.bore_compliance:
        return {}
    parts = {SHAFT: stage.shaft_compliance, BORE: stage.bore_compliance}
    if springs is not None:
        parts |= {
            SHAFT: springs.shaft,
            SHAFT_BEARINGS: springs.bearings,
            SHAFT_SEATS: sum(springs.seats.values()),
        }
    together = stage.shaft_compliance + stage.bore_compliance
    return {
        name: whole * (each / together) for name, each in parts.items() if each or name == SHAFT
    }


def _pins(stage: CycloidalStage, torque: Floats) -> dict[str, Floats]:
    """Return the wind-up of the members of output pins that the drawing states by their
    dimensions.
    """
    pins = stage.output_pins
    out: dict[str, Floats] = {}
    if pins is None or pins.diameter is None:
        return out
    for name, each in zip(
        (PINS, SEATS), middle_compliance(stage.pin_limits, stage.discs, stage.rigid), strict=True
    ):
        out[name] = wind_up.output_pin_wind_up(stage.drive, torque, each)
    force = [
        largest_pin_force(each, pins.circle_radius, pins.count, stage.discs)
        for each in torque.tolist()
    ]
    if pins.sleeve is not None and pins.sleeve.rollers is not None and NEEDLES not in stage.rigid:
        soft = np.array(
            [needle_compliance(each, pins.sleeve.rollers, pins.sleeve.length) for each in force]
        )
        out[NEEDLES] = wind_up.output_pin_wind_up(stage.drive, torque, soft)
    hole = stage.hole
    if hole is not None:
        out[HOLES] = wind_up.output_pin_wind_up(
            stage.drive, torque, np.array([hole.compliance(each) for each in force])
        )
    return out
