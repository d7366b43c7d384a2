"""The largest load that each joint of an arm holds at rest: the measure of friction that is not stated."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.parts.error_source import Holding
from lostmotion.parts.joint import FixedJoint
from lostmotion.spatial import cross, mapped, out_of

if TYPE_CHECKING:
    from lostmotion.mechanism.serial import Arm
    from lostmotion.spatial import Floats

_POSES: Final = 256


def holdings(arm: Arm, at: Floats, process: Floats, least: float) -> tuple[Holding, ...]:
    """Return the largest load that each joint holds at rest, under every tilt of the base, at these poses.

    at       frames of the arm's places (place, pose, 4, 4), m, in the base's axes
    process  wrenches of the process force without gravity (place, pose, 6), each in its place's axes, N m and N
    least    weight (N) that every joint holds at the arm's reach at least

    The weight and the moment of everything outboard of a joint are turned to where they load it most, and the process force adds to them.
    """
    masses = arm.payload.mass, arm.tool.mass
    tips = [at[-1, :, :3, 3] + out_of(at[-1], np.array(centre)) for centre in (arm.payload.centre_of_mass, arm.tool.centre_of_mass)]
    mass, moved = sum(masses), sum(weight * tip for weight, tip in zip(masses, tips, strict=True))
    start = next(3 * k + 1 for k, joint in enumerate(arm.joints) if not isinstance(joint, FixedJoint))
    reach = max(float(np.linalg.norm(point - at[start, :, :3, 3], axis=-1).max()) for point in (at[-1, :, :3, 3], *tips))
    out = []
    for k, joint in reversed(list(enumerate(arm.joints))):
        seat, here = at[3 * k + 1], at[3 * k + 2]
        mass += joint.link.total_mass
        moved = moved + joint.link.total_mass * (here[:, :3, 3] + out_of(here, np.asarray(joint.link.mass_centre, dtype=float)))
        lever = moved - mass * here[:, :3, 3]
        turning = joint.twist[:3].any()
        hung = np.linalg.norm(cross(out_of(here, joint.twist[:3]), lever), axis=-1) if turning else np.full(len(lever), mass * joint.twist.any())
        asked = np.abs(mapped(joint.twist, process[3 * k + 2])), *(np.linalg.norm(part, axis=-1) for part in np.split(process[3 * k + 2], 2, axis=-1))
        load, moment, force = (
            float((arm.gravity * weight + more).max())
            for weight, more in zip((hung, np.linalg.norm(lever, axis=-1), np.full(len(lever), mass)), asked, strict=True)
        )
        out.append(Holding(max(load, least * (reach if turning else 1.0)), max(force, least), max(moment, least * reach)))
        mass += joint.total_mass
        moved = moved + joint.total_mass * (seat[:, :3, 3] + out_of(seat, np.array(joint.centre_of_mass)))
    return tuple(reversed(out))


def spread_evenly(limits: Floats) -> Floats:
    """Return 256 poses (pose, joint) between limits (joint, 2): multiples of powers of the generalised golden ratio (M. Roberts 2018), not random."""
    joints = len(limits)
    ratio = 2.0
    for _ in range(60):
        ratio = (1 + ratio) ** (1 / (joints + 1))  # the root of x^(joints + 1) = x + 1
    share = (0.5 + np.arange(_POSES)[:, None] * ratio ** -np.arange(1.0, joints + 1)) % 1.0
    return limits[:, 0] + share * (limits[:, 1] - limits[:, 0])
