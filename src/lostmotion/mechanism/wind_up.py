"""The largest elastic wind-up of each drive under its static load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.standing import settled_at
from lostmotion.mechanism.state import as_poses, blocks_of

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_CAUSE: Final = "wind-up"


@dataclass(frozen=True, slots=True)
class WindUp:
    """The wind-up of one drive at the pose where it is largest, of the nominal part: rad, or m on a
    sliding joint, positive along the motion.
    """

    joint: str
    value: float
    index: int


def wind_ups(arm: Arm, q: Floats) -> list[WindUp]:
    """Return the largest wind-up of each drive whose stiffness is described, over these poses q
    (pose, joint), rad or m.

    It is the deflection of the output along the joint under the static torque where the arm stands,
    without backlash, of a part with nominal stiffness; NaN where the arm cannot hold its load.
    Raises ValueError for q of another shape or not finite.
    """
    values = as_poses(arm, q)
    elastic = [
        (of.joint, of)
        for of in arm.terms
        if of.joint is not None and of.kind == "gearbox" and of.term.cause == _CAUSE
    ]
    nominal = [(joint, of) for joint, of in elastic if of.term.level == "design"]
    found = {joint: np.zeros(len(values)) for joint, _ in nominal}
    for here, some in blocks_of(values):
        conditions = settled_at(arm, some).conditions()
        for joint, of in nominal:
            found[joint][here] += arm.driven[joint].twist @ (
                of.term.scale * of.term.form.screw(conditions(of))
            )
    largest = {joint: int(np.abs(angle).argmax()) for joint, angle in found.items()}
    return [
        WindUp(arm.driven[joint].name, float(found[joint][at]), at)
        for joint, at in sorted(largest.items())
    ]
