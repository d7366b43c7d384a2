"""Members of a cycloidal stage as lines of the error budget: the wind-up of each, and the material that it follows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid import drive
from lostmotion.laws.cycloid.output_pins import largest_pin_force, needle_compliance
from lostmotion.parts.gearbox.cycloidal_shaft import Shaft

if TYPE_CHECKING:
    from lostmotion.parts.gearbox.cycloidal_stage import CycloidalStage
    from lostmotion.parts.material import Material
    from lostmotion.spatial import Floats

SHAFT: Final = "eccentric shaft"
SHAFT_BEARINGS: Final = "bearings of the eccentric shaft"
SHAFT_SEATS: Final = "seats of the eccentric shaft"
BORE: Final = "seat of the eccentric bearing"
PINS: Final = "output pins"
SEATS: Final = "seats of the output pins"
NEEDLES: Final = "needles of the output pins"
HOLES: Final = "holes of the output pins"
PIN_MEMBERS: Final = (PINS, SEATS, NEEDLES, HOLES)


def stage_wind_up(stage: CycloidalStage, torque: Floats) -> dict[str, Floats]:
    """Return the nominal wind-up (torque,), rad, of each member of a stage under torques (torque,) above zero on its discs, beyond the play.

    Raises DidNotConvergeError where a load is beyond the contact law.
    """
    found = drive.wind_up_by_member(stage.drive, torque)
    return found | _shaft(stage, found[SHAFT]) | _pins(stage, torque)


def _shaft(stage: CycloidalStage, whole: Floats) -> dict[str, Floats]:
    """Return the wind-up of the members of the eccentric's shaft and of its bearing's seat, which add up to that of the `whole`."""
    springs = stage.shaft_springs
    if springs is None and not stage.bore_compliance:
        return {}
    parts = {SHAFT: stage.shaft_compliance, BORE: stage.bore_compliance}
    if springs is not None:
        parts |= {SHAFT: springs.shaft, SHAFT_BEARINGS: springs.bearings, SHAFT_SEATS: sum(springs.seats.values())}
    together = stage.shaft_compliance + stage.bore_compliance
    return {name: whole * (each / together) for name, each in parts.items() if each or name == SHAFT}


def _pins(stage: CycloidalStage, torque: Floats) -> dict[str, Floats]:
    """Return the wind-up of the members of output pins that the drawing states by their dimensions."""
    pins = stage.output_pins
    out: dict[str, Floats] = {}
    if pins is None or pins.diameter is None:
        return out
    for name, each in zip((PINS, SEATS), pins.compliance(stage.discs), strict=True):
        out[name] = drive.output_pin_wind_up(stage.drive, torque, each)
    force = [largest_pin_force(each, pins.circle_radius, pins.count, stage.discs) for each in torque.tolist()]
    if pins.sleeve is not None and pins.sleeve.rollers is not None:
        soft = np.array([needle_compliance(each, pins.sleeve.rollers, pins.sleeve.length) for each in force])
        out[NEEDLES] = drive.output_pin_wind_up(stage.drive, torque, soft)
    hole = stage.hole
    if hole is not None:
        out[HOLES] = drive.output_pin_wind_up(stage.drive, torque, np.array([hole.compliance(each) for each in force]))
    return out


@dataclass(frozen=True, slots=True)
class MaterialShares:
    """A material of a stage: the name of its scatter, and the share of each member's wind-up that is proportional to its compliance."""

    name: str
    material: Material
    shares: dict[str, float]


def material_shares(stage: CycloidalStage) -> tuple[MaterialShares, ...]:
    """Return the materials of a stage with the members that they make elastic."""
    out = [
        MaterialShares("disc material", stage.disc_material, {"lobe contacts": 0.5, "disc body": 1.0, HOLES: 1.0, BORE: 1.0}),
        MaterialShares("ring material", stage.ring_material, {"lobe contacts": 0.5, **dict.fromkeys(("ring body", "ring lobes", "ring pins"), 1.0)}),
    ]
    pins = stage.output_pins
    if pins is not None and pins.diameter is not None:
        out.append(MaterialShares("output pin material", pins.pin_material, {PINS: 1.0}))
        if pins.seat is not None:
            out.append(MaterialShares("output pin seat material", pins.seat.material, {SEATS: 1.0}))
    springs, shaft = stage.shaft_springs, stage.eccentric.shaft
    if springs is not None and isinstance(shaft, Shaft):
        for k, (section, part) in enumerate(zip(shaft.sections, springs.sections, strict=True)):
            bending = sum(layer.bending for layer, _ in section.layers)
            for layer, material in section.layers:
                name = f"shaft section {k + 1} {'core ' if material is section.core else ''}material"
                out.append(MaterialShares(name, material, {SHAFT: part / springs.shaft * layer.bending / bending}))
        of_seats = sum(springs.seats.values())
        out += [
            MaterialShares(f"seat {name} material", stage.seats[name].material, {SHAFT_SEATS: each / of_seats})
            for name, each in springs.seats.items()
            if each
        ]
    return tuple(out)
