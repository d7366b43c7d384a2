"""Arms whose drives are all assumed, from presets of the catalogue or a class of drive."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.parts.provenance import NO_VALUES

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.provenance import Preset

# Parts that every drive has, and those that it may have.
OF_DRIVE: Final = ("gearbox", "encoder")
_BESIDE: Final = ("bearing", "guideway", "servo", "lumped")


def whole_preset(part: Any) -> Preset | None:  # noqa: ANN401 - a part of a joint, or None
    """Return the preset or class that all values of a part come from; None where any is stated."""
    preset: Preset | None = getattr(part, "preset", None)
    own = preset and part.model_fields_set - NO_VALUES - {"preset", *preset.keys}
    return None if own else preset


def presets_of_arm(arm: Arm) -> tuple[str, ...]:
    """Return the names of the presets that all gearboxes, bearings, encoders and servos of an arm
    are, in the order of its joints; empty where any value of one is stated, or a joint lacks a
    gearbox or an encoder.
    """
    names: dict[str, None] = {}
    for joint in arm.driven:
        for key in (*OF_DRIVE, *_BESIDE):
            part = getattr(joint, key, None)
            preset = whole_preset(part)
            if preset is not None:
                names[preset.name] = None
            elif part is not None or key in OF_DRIVE:
                return ()
    return tuple(names)
