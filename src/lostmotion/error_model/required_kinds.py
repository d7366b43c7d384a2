"""Kinds of error that a real joint or link must have: where one of them is not described, every
figure is a lower bound.

A drive that carries a load winds up, and has backlash and friction; an encoder has a resolution; a
bearing or a guide has clearance or deflects; a guideway is not straight; a link bends and is made
to a length. Not required, because a real arm may be without them: a transmission error (a direct
drive has none), the tilt and offset of an axis (set or measured at assembly) and the tilt of the
base (levelled, or measured as the robot's frame).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.parts.joint import has_axis

if TYPE_CHECKING:
    from lostmotion.parts.joint import Joint, PrismaticJoint, RevoluteJoint

OF_DRIVE: Final = ("backlash", "stiffness", "hysteresis")
# Kinds that make the compliance of an arm.
ELASTIC: Final = ("stiffness", "bearing", "link bending")
OF_LINK: Final = ("link bending", "link length")


def required_kinds(joint: Joint, *, lumped: bool) -> tuple[str, ...]:
    """Return the kinds of error that a real joint like this one, with its link, must have, in the
    order of the table of states.

    lumped  whether the joint states a lumped error: it stands for all kinds of the joint itself,
            though not for those of its link
    """
    own: tuple[str, ...] = ()
    if has_axis(joint) and not lumped:
        own = (
            _of_bearing(joint)
            if joint.passive
            else (*_of_drive(joint), *_of_bearing(joint), "encoder")
        )
    return (*own, *(OF_LINK if joint.link.reach else ()))


def _of_drive(joint: RevoluteJoint | PrismaticJoint) -> tuple[str, ...]:
    """Return the kinds of a drive: behind an encoder on the output only the play stays; a class
    from a preset is described as a whole.
    """
    gearbox, encoder = joint.gearbox, joint.encoder
    if encoder is not None and encoder.side == "output":
        kinds: tuple[str, ...] = OF_DRIVE[:1]
    else:
        kinds = OF_DRIVE
    preset = getattr(gearbox, "preset", None)
    if preset is not None and preset.keys:
        return ()
    absent = getattr(gearbox, "absent", ())
    return tuple(kind for kind in kinds if kind not in absent)


def _of_bearing(joint: RevoluteJoint | PrismaticJoint) -> tuple[str, ...]:
    return ("bearing", "guideway") if joint.type == "prismatic" else ("bearing",)
