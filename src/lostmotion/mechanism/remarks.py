"""Remarks on an arm: what an encoder on the output corrects, and what the description does not
state.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.parts.error_source import FRICTION_SCATTER_TEXT, OF_HELD
from lostmotion.parts.joint import has_axis

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.parts.bands import UnknownValue
    from lostmotion.parts.environment import Environment
    from lostmotion.parts.error_source import Friction
    from lostmotion.parts.joint import Joint, PrismaticJoint, RevoluteJoint

    Moving = Sequence[RevoluteJoint | PrismaticJoint]

_MOST_KEYS: Final = 6


def remarks_on(
    moving: Moving,
    assumed: Mapping[tuple[str, str], Friction],
    gearboxes_without_mass: Sequence[str],
) -> tuple[str, ...]:
    """Return remarks on encoders on the output, bounded members, gearboxes without a rating,
    assumed friction and gearbox masses, a text each.

    moving                  the moving joints
    assumed                 friction (N m or N) of which the size or the scatter is assumed because
                            none is stated, by names of joint and part gearboxes_without_mass
                            models of gearboxes without a stated mass
    """
    return (
        *_corrected(moving),
        *_bounded_members(moving),
        *_unrated(moving),
        *_assumed_frictions(moving, assumed),
        *_masses(moving, gearboxes_without_mass),
    )


def remarks_on_ranges(unknown: Sequence[UnknownValue]) -> tuple[str, ...]:
    """Return the remark on values that the description states as ranges; none without them."""
    unknown = [each for each in unknown if ".unstated." not in each.key]
    keys = ", ".join(each.name for each in unknown[:_MOST_KEYS]) + (
        f" and {len(unknown) - _MOST_KEYS} more" if len(unknown) > _MOST_KEYS else ""
    )
    return (
        (
            (
                f"stated as a range a .. b: {keys}; figures without a band are computed with the "
                "middle of each range"
            ),
        )
        if unknown
        else ()
    )


def _corrected(moving: Moving) -> tuple[str, ...]:
    corrected = ", ".join(joint.name for joint in moving if joint.corrected)
    effect = (
        "the controller corrects wind-up and backlash, except backlash that stays open under a "
        "load below the friction"
    )
    return (f"encoder on the output of {corrected}: {effect}",) if corrected else ()


def _bounded_members(moving: Moving) -> tuple[str, ...]:
    unspecified: dict[str, list[str]] = {}
    for joint in moving:
        if joint.gearbox is not None and joint.gearbox.not_specified:
            unspecified.setdefault(joint.gearbox.not_specified, []).append(joint.name)
    return tuple(
        f"gearbox of {', '.join(joints)}: not specified and bounded by the other members: {members}"
        for members, joints in unspecified.items()
    )


def _unrated(moving: Moving) -> tuple[str, ...]:
    unrated = ", ".join(
        joint.name
        for joint in moving
        if joint.gearbox is not None and joint.gearbox.rated_torque is None
    )
    return (
        (f"rated torque of the gearbox of {unrated}: not stated, so overload is not checked there",)
        if unrated
        else ()
    )


def _assumed_frictions(
    moving: Moving, assumed: Mapping[tuple[str, str], Friction]
) -> tuple[str, ...]:
    grouped: dict[tuple[str, str, str], dict[str, str]] = {}
    units = {joint.name: joint.load_unit for joint in moving}
    scattered: dict[str, list[str]] = {}
    for (joint, part), friction in assumed.items():
        if not friction.reason:
            scattered.setdefault(part, []).append(joint)
            continue
        unit = units[joint] if part.startswith("gearbox") else "N"
        grouped.setdefault((part, friction.reason, unit), {})[joint] = (
            f"{friction.load.nominal:.3g}"
        )
    loads_assumed = [
        f"friction of the {part} of {', '.join(loads)}: not stated, assumed "
        f"{reason}{', in any pose, at any tilt' if reason == OF_HELD else ''}, "
        f"{FRICTION_SCATTER_TEXT} "
        f"({', '.join(loads.values() if len(set(loads.values())) > 1 else [*loads.values()][:1])} "
        f"{unit}); "
        "a smaller load does not close the play"
        for (part, reason, unit), loads in grouped.items()
    ]
    scatter_of = [
        (
            f"scatter of the friction of the {part} of {', '.join(joints)}: not stated, assumed "
            f"{FRICTION_SCATTER_TEXT}"
        )
        for part, joints in scattered.items()
    ]
    return (*loads_assumed, *scatter_of)


def _masses(moving: Moving, gearboxes_without_mass: Sequence[str]) -> list[str]:
    stated = [joint for joint in moving if joint.gearbox is not None and joint.gearbox.mass]
    own = [
        f"{joint.name} {joint.gearbox.mass:g} kg"
        for joint in stated
        if joint.mass is None and joint.gearbox is not None
    ]
    within = [
        f"{joint.name} {joint.gearbox.mass:g} kg"
        for joint in stated
        if joint.mass is not None and joint.gearbox is not None
    ]
    notes = []
    if own:
        notes.append(
            f"gearbox masses added at joints whose own mass is not stated: {', '.join(own)}"
        )
    if within:
        notes.append(
            "gearbox masses not added, because the stated mass of the joint or link includes "
            f"them: {', '.join(within)}"
        )
    if gearboxes_without_mass:
        notes.append(f"mass of {', '.join(gearboxes_without_mass)} not stated: counted as zero")
    return notes


def temperature_remarks(joints: Sequence[Joint], environment: Environment) -> tuple[str, ...]:
    """Return the remark on what expands at the stated temperature and what does not; none without a
    temperature.
    """
    rise = environment.rise
    if rise is None:
        return ()
    links = [joint for joint in joints if joint.link.reach]
    expand = ", ".join(joint.name for joint in links if joint.link.expands)
    unknown = ", ".join(joint.name for joint in links if not joint.link.expands)
    without = f"links of {unknown} (expansion not stated), " if unknown else ""
    varies = environment.temperature_varies
    differs = f" (± {rise.tolerance:.3g} K from {varies} to {varies})" if rise.tolerance else ""
    fitted = ", ".join(
        joint.name
        for joint in joints
        if has_axis(joint) and joint.bearing is not None and joint.bearing.has_fits
    )
    clearances = (
        (
            f"; clearance of the bearings of {fitted} by the expansion of shaft and housing (steel "
            "unless stated)"
        )
        if fitted
        else ""
    )
    meshing = ", ".join(joint.name for joint in joints if joint.drive_expands)
    clearances += (
        f"; clearances of the gearboxes of {meshing} by the expansion of disc, pins and ring"
        if meshing
        else ""
    )
    clearances += (
        "; the ± changes no open clearance"
        if clearances and rise.tolerance and varies == "visit"
        else ""
    )
    silent = ", ".join(joint.name for joint in joints if joint.drive_expands is None)
    without += f"gearboxes of {silent} (expansion not stated), " if silent else ""
    counted = (
        f"temperature {rise.nominal:+.3g} K{differs} from the reference temperature: expansion of "
        f"the links of {expand or 'no joint'}{clearances}"
    )
    return (
        (
            f"{counted}. Not counted: expansion of {without}base, joint offsets, tool, other "
            "gearboxes and bearings; change of moduli"
        ),
    )
