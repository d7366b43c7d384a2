"""Materials of a cycloidal gearbox: which members follow the modulus of which material, and by
which share.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from lostmotion.parts.gearbox.cycloidal.frame import GearboxFrame
from lostmotion.parts.gearbox.cycloidal.names import (
    BORE,
    CONTACTS,
    DISC_BODY,
    FIRST_STAGE,
    FRAME,
    FRAME_SCREWS,
    HOLES,
    PINS,
    RING_BODY,
    RING_LOBES,
    RING_PINS,
    SEATS,
    SHAFT,
    SHAFT_SEATS,
)
from lostmotion.parts.gearbox.cycloidal.pins import middle_compliance
from lostmotion.parts.material import Material, with_material

if TYPE_CHECKING:
    from lostmotion.parts.gearbox.cycloidal.drawing import CycloidalDrawing
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage

# Relative change of a modulus by which the share of a material in a member's compliance is found.
_CHANGE: Final = 0.01


@dataclass(frozen=True, slots=True)
class MaterialShares:
    """A material, which is one batch wherever it is named: its name, and the share of each member's
    wind-up that follows its compliance.
    """

    name: str
    material: Material
    shares: dict[str, float]


def material_shares(gearbox: CycloidalDrawing) -> tuple[MaterialShares, ...]:
    """Return the materials of a gearbox with the members that they make elastic: equal materials
    are of one batch.
    """
    found = _of_stage(gearbox)
    first, frame = gearbox.first_stage, gearbox.frame
    if first is not None and first.kind == "cycloidal":
        found += [
            (material, {f"{FIRST_STAGE}{member}": share for member, share in shares.items()})
            for material, shares in _of_stage(first)
        ]
    if isinstance(frame, GearboxFrame):
        found += [(frame.screws.material, {FRAME_SCREWS: 1.0})] if frame.screws is not None else []
        found += [(frame.tube.material, {FRAME: 1.0})] if frame.tube is not None else []
    out: dict[str, tuple[Material, dict[str, float]]] = {}
    for material, each in found:
        _, together = out.setdefault(_name_of(material), (material, {}))
        for member, share in each.items():
            if share:
                together[member] = together.get(member, 0.0) + share
    return tuple(
        MaterialShares(name, material, each) for name, (material, each) in out.items() if each
    )


def _name_of(material: Material) -> str:
    """Return a name that equal materials share, for the stream of their scatter."""
    density = math.nan if material.density is None else material.density
    return (
        f"material {material.name} of {material.young:.6g} Pa, {material.poisson:.6g}, "
        f"{density:.6g} kg/m^3, {material.scatter:.6g}"
    )


def _of_stage(stage: CycloidalStage) -> list[tuple[Material, dict[str, float]]]:
    """Return the materials of a stage with the members that they make elastic."""
    disc, ring = stage.disc_material, stage.ring_material
    soft = [(1 - each.poisson**2) / each.modulus for each in (disc, ring)]
    of_disc = soft[0] / sum(soft)
    out: list[tuple[Material, dict[str, float]]] = [
        (disc, {CONTACTS: of_disc, DISC_BODY: 1.0, HOLES: 1.0, BORE: 1.0}),
        (ring, {CONTACTS: 1 - of_disc, RING_BODY: 1.0, RING_LOBES: 1.0, RING_PINS: 1.0}),
    ]
    springs, pins, shaft = stage.shaft_springs, stage.output_pins, stage.eccentric.shaft
    if springs is not None:
        before = {SHAFT: springs.shaft, SHAFT_SEATS: sum(springs.seats.values())}
        for old in _materials_in((shaft, stage.seats)):
            after = stage.shaft_springs_with(old, _softer(old)) or springs
            out.append(
                (old, _shares(before, {SHAFT: after.shaft, SHAFT_SEATS: sum(after.seats.values())}))
            )
    if pins is not None and pins.diameter is not None:
        names = (PINS, SEATS)
        # a default material is not a field, so it is put in
        stiffest, softest = (
            each.model_copy(update={"material": pins.pin_material}) for each in stage.pin_limits
        )
        limits = (stiffest, softest)
        before = dict(zip(names, middle_compliance(limits, stage.discs, stage.rigid), strict=True))
        for old in _materials_in(limits):
            softer = middle_compliance(
                with_material(limits, old, _softer(old)), stage.discs, stage.rigid
            )
            out.append((old, _shares(before, dict(zip(names, softer, strict=True)))))
    return out


def _materials_in(part: Any) -> list[Material]:  # noqa: ANN401 - a part, or a list, tuple or mapping of parts, of any class
    """Return the different materials in a part."""
    if isinstance(part, Material):
        return [part]
    inside: Any = (
        part.values() if isinstance(part, dict) else part if isinstance(part, list | tuple) else ()
    )
    if not isinstance(part, list | tuple | dict) and hasattr(type(part), "model_fields"):
        inside = [getattr(part, name) for name in type(part).model_fields]
    out: list[Material] = []
    for each in inside:
        out += [material for material in _materials_in(each) if material not in out]
    return out


def _softer(material: Material) -> Material:
    return material.model_copy(update={"young": material.young * (1 - _CHANGE)})


def _shares(before: dict[str, float], after: dict[str, float]) -> dict[str, float]:
    """Return the share of each compliance that grows in proportion to that of a material."""
    grown = 1 / (1 - _CHANGE) - 1
    return {
        name: max((after[name] / each - 1) / grown, 0.0) for name, each in before.items() if each
    }
