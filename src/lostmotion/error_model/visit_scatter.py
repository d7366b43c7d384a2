"""Whether any described error differs between visits. Without one a repeatability is unknown, and
no target on it is met.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.error_model.budget import NOTHING
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.errors import InputError, Problem

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


def refuse_without_scatter(arm: Arm, q: Floats, approach: float) -> None:
    """Raise InputError where no described error moves the tool differently at every visit to these
    poses (pose, joint), with what to describe. `approach` as for `screws`: a backlash that no load
    closes scatters only where the side is drawn.
    """
    squares = pose_matrix(arm, q, approach=approach).merged.level_squares.sum(axis=0)
    if squares[2] > NOTHING**2 * squares.sum():
        return
    joint = arm.driven[0]
    noise = "1 µm" if joint.type == "prismatic" else "2 arcsec"
    expected = (
        "what differs between visits: noise or resolution of an encoder, hysteresis or friction of "
        f"a gearbox{'' if approach else ', a backlash that no load closes'}"
    )
    raise InputError(
        [
            Problem(
                arm.name,
                f"joints.{joint.name}.encoder",
                "no described error differs between visits, so no repeatability is predicted",
                expected,
                f'encoder = {{ noise = "{noise}" }}',
            )
        ]
    )
