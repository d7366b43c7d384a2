"""Tolerances of a cycloidal stage that its drawing does not state, by the process that makes it.
They count as assumed.

Of the tolerance of a dimension, two thirds are common to a part (its scale), and one third differs
from lobe to lobe [M 75]. Radii have half of the tolerance of their diameter, and the eccentricity
half of that of the throw.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.laws.process_tolerance import process_tolerance
from lostmotion.parts.provenance import DEFAULT

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.tolerances import DimensionScatter

_COMMON: Final = 2 / 3
_EACH: Final = 1 / 3


def tolerances_by_process(process: str, stage: Any) -> dict[str, float]:  # noqa: ANN401 - the dimensions of a stage, whose module uses this one
    """Return the tolerances (m) that a process sets where the drawing of the stage states none, by
    key ("ring_radius", "output_pins.clearance").

    A tolerance of zero counts as not stated. Raises ValueError for sizes that the process has no
    tolerance for.
    """
    out: dict[str, float] = {}
    ring, pin = (
        process_tolerance(process, 2 * getattr(stage, name).nominal) / 2
        for name in ("ring_radius", "pin_radius")
    )
    throw = process_tolerance(process, 2 * stage.eccentricity.nominal) / 2
    for name, half in (("ring_radius", ring), ("pin_radius", pin), ("eccentricity", throw)):
        if not getattr(stage, name).tolerance:
            out[name] = _COMMON * half
    if not stage.relief.roller.tolerance:
        # part of the flank of the disc, which is as large as the ring; a clearance is not below
        # zero
        out["relief.roller"] = min(_COMMON * ring, float(stage.relief.roller.nominal))
    for name, half in (("pin_position", ring), ("pin_size", pin), ("flank_form", ring)):
        if name not in stage.model_fields_set:
            out[name] = _EACH * half
    pins = stage.output_pins
    if pins is not None:
        circle = process_tolerance(process, 2 * pins.circle_radius) / 2
        if "position" not in pins.model_fields_set:
            out["output_pins.position"] = _EACH * circle
        if pins.outer_diameter is not None and not pins.clearance.tolerance:
            out["output_pins.clearance"] = min(
                _COMMON * process_tolerance(process, pins.outer_diameter),
                float(pins.clearance.nominal),
            )
    if "position" not in stage.eccentric.model_fields_set:
        out["eccentric.position"] = _EACH * ring
    return {name: tolerance for name, tolerance in out.items() if tolerance}


# The tolerances by their names in `Scatter`.
_IN_SCATTER: Final = {
    "relief.roller": "roller",
    "output_pins.position": "output_position",
    "output_pins.clearance": "output_clearance",
    "eccentric.position": "crank_position",
}


def with_process(scatter: DimensionScatter, tolerances: dict[str, float]) -> DimensionScatter:
    """Return the tolerances of a stage, completed by those of its process."""
    changed: dict[str, Any] = {}
    for key, tolerance in tolerances.items():
        name = _IN_SCATTER.get(key, key)
        stated = getattr(scatter, name)
        changed[name] = (
            tolerance if isinstance(stated, float) else replace(stated, tolerance=tolerance)
        )
    return replace(scatter, **changed)


def reasons(process: str, tolerances: dict[str, float]) -> dict[str, str]:
    """Return the assumed tolerances of a stage: key to reason."""
    return {
        key: f"{DEFAULT} tolerance of {process}, ± {1e3 * tolerance:.2g} mm"
        for key, tolerance in tolerances.items()
    }
