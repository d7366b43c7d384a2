"""Remarks on an arm: what its file does not state, and what an encoder on the output corrects."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.parts.error_source import OF_HELD
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.parts.joint import RevoluteJoint

if TYPE_CHECKING:
    from lostmotion.mechanism.serial import Arm


def remarks_on(arm: Arm) -> tuple[str, ...]:
    """Return, in a sentence each, what encoders correct, rigid members, gearboxes without a rating, assumed friction, gearbox masses."""
    return (*_corrected(arm), *_rigid_members(arm), *_unrated(arm), *_assumed_frictions(arm), *_masses_of_gearboxes(arm))


def _corrected(arm: Arm) -> tuple[str, ...]:
    corrected = ", ".join(joint.name for joint in arm.moving if joint.corrected)
    said = "the controller corrects wind-up and backlash, except backlash that stays open under a load below the friction"
    return (f"encoder on the output of {corrected}: {said}",) if corrected else ()


def _rigid_members(arm: Arm) -> tuple[str, ...]:
    silent: dict[str, list[str]] = {}
    for joint in arm.moving:
        if isinstance(joint.gearbox, CycloidalGearbox) and joint.gearbox.rigid:
            silent.setdefault(joint.gearbox.rigid_said, []).append(joint.name)
    return tuple(f"gearbox of {', '.join(joints)}: not specified and taken as rigid: {rigid}" for rigid, joints in silent.items())


def _unrated(arm: Arm) -> tuple[str, ...]:
    unrated = ", ".join(joint.name for joint in arm.moving if joint.gearbox is not None and joint.gearbox.rated_torque is None)
    return (f"rated torque of the gearbox of {unrated}: not stated, so overload is not checked there",) if unrated else ()


def _assumed_frictions(arm: Arm) -> tuple[str, ...]:
    grouped: dict[tuple[str, str, str], dict[str, str]] = {}
    turning = [joint.name for joint in arm.joints if isinstance(joint, RevoluteJoint)]
    for (joint, part), friction in arm.assumed_friction.items():
        unit = "N m" if part.startswith("gearbox") and joint in turning else "N"
        grouped.setdefault((part, friction.reason, unit), {})[joint] = f"{friction.load:.3g}"
    return tuple(
        f"friction of the {part} of {', '.join(loads)}: not stated, assumed {reason}{', in any pose, at any tilt' if reason == OF_HELD else ''} "
        f"({', '.join(loads.values() if len(set(loads.values())) > 1 else [*loads.values()][:1])} {unit}); "
        "a smaller load does not close the play"
        for (part, reason, unit), loads in grouped.items()
    )


def _masses_of_gearboxes(arm: Arm) -> list[str]:
    stated = [joint for joint in arm.moving if joint.gearbox is not None and joint.gearbox.mass]
    own = [f"{joint.name} {joint.gearbox.mass:g} kg" for joint in stated if joint.mass is None and joint.gearbox is not None]
    within = [f"{joint.name} {joint.gearbox.mass:g} kg" for joint in stated if joint.mass is not None and joint.gearbox is not None]
    notes = []
    if own:
        notes.append(f"gearbox masses added at joints whose own mass is not stated: {', '.join(own)}")
    if within:
        notes.append(f"gearbox masses not added, because the stated mass of the joint or link includes them: {', '.join(within)}")
    if arm.unweighed:
        notes.append(f"mass of {', '.join(arm.unweighed)} not stated: counted as none")
    return notes
