"""Limits of the inputs for which the controller of an arm answers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.controller_model.tables import Validity

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm

# Largest payload as a multiple of that of the arm file, and largest acceleration as a multiple of
# gravity.
_PAYLOADS: Final = 2.0
_ACCELERATION: Final = 1.5
# Payload (kg) and gravity (m/s^2) where the file states neither payload nor masses, or no gravity.
_PAYLOAD: Final = 10.0
_GRAVITY: Final = 10.0


def validity_of(arm: Arm, payload: float | None = None) -> Validity:
    """Return the limits for an arm.

    payload  largest mass, kg; by default twice the payload of the arm file, or the mass of the arm
             where the file states no payload

    The centre of mass may lie within the arm's length of the tool point. The process force may be
    as large as the largest weight plus twice the stated force; its moment likewise, at that length.
    """
    most = payload if payload is not None else _PAYLOADS * arm.payload.mass or arm.mass or _PAYLOAD
    gravity = _ACCELERATION * (arm.gravity or _GRAVITY)
    lengths = [float(np.linalg.norm(place.pose[:3, 3])) for place in arm.tree.places]
    slides = [
        float(np.abs(joint.limits).max()) for joint in arm.driven if not joint.twist[:3].any()
    ]
    reach = sum(lengths) + sum(slides)
    force = most * gravity + _PAYLOADS * float(np.abs(arm.payload.force).max())
    moment = force * max(reach, 1.0) + _PAYLOADS * float(np.abs(arm.payload.moment).max())
    return Validity(
        most,
        max(reach, _PAYLOADS * float(np.abs(arm.payload.centre_of_mass).max())),
        force,
        moment,
        gravity,
    )
