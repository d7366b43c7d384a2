"""Refusal of errors that are too large for a first-order sum, for analyses that do not print a
comparison with exact composition.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.poses import sample_poses
from lostmotion.error_model.trust import with_figures
from lostmotion.errors import InputError, Problem
from lostmotion.propagation.exact import FAILS, check, share_neglected

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm

_POSES: Final = 16
_ROBOTS: Final = 16
_VISITS: Final = 4
_SEED: Final = 1
# Errors are judged where they have figures; where hardly any pose has, that is the message.
_MOST_WITHOUT: Final = 0.5


def refuse_large_errors(arm: Arm) -> None:
    """Raise InputError for an arm whose errors are too large for a first-order sum; the message
    states the error of that sum.

    1 024 samples are compared: 16 poses between the joint limits, 16 robots and four visits. Errors
    are too large where their first-order sum differs from their exact composition by more than a
    tenth of the largest error, as it does for rotations of about 11 degrees.
    """
    q = with_figures(arm, sample_poses(arm, _POSES), most=_MOST_WITHOUT).q
    with np.errstate(over="ignore", invalid="ignore"):
        found = check(
            pose_matrix(arm, q),
            0,
            np.arange(len(q)),
            _SEED,
            _ROBOTS,
            _VISITS,
        )
    if share_neglected(found, found.length) <= FAILS:
        return
    problem = (
        f"errors of up to {math.degrees(found.turn):.2g}°, of which the first-order sum is wrong "
        f"by {found.largest * 1e3:.2g} mm"
    )
    expected = "errors small enough to be added up; `lostmotion study FILE` lists the largest"
    raise InputError([Problem(arm.name, "", problem, expected, 'backlash = "1 arcmin"')])
