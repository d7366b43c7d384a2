"""Commands by which a calibrated robot reaches the nominal poses: its inverse kinematics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.inverse import pose_difference, tool_and_jacobian
from lostmotion.mechanism.standing import standing_if_soft
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.exact import compose

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_STEPS: Final = 8
_REACHED: Final = 1e-10
_FULL: Final = 6
# Singular values of the Jacobian below this share of the largest are of directions that no joint
# moves.
_SINGULAR: Final = 1e-3


def expected_tool(arm: Arm, q: Floats) -> Floats:
    """Return the expected frames of the tool (pose, 4, 4), m: the exact composition of all design
    errors, of a calibrated arm its estimates too; of a soft arm where it stands.
    """
    matrix = screws(standing_if_soft(state_of(arm, q)))
    draws = np.array([float(info.level == "design") for info in matrix.infos])
    rows = np.arange(len(q))
    return compose(matrix, rows, np.broadcast_to(draws[:, None], (len(rows), len(draws), 1)))[:, 0]


def corrected(arm: Arm, q: Floats) -> tuple[Floats, Floats]:
    """Return commands (pose, joint) by which this calibrated arm reaches the poses of the nominal
    arm at q (pose, joint), rad and m, and the distances (pose,), m, that remain.

    Newton steps with the nominal Jacobian, from q. An arm with fewer than six joints reaches the
    tool point alone. Near singular poses a direction that no joint moves remains.
    """
    wanted = state_of(arm.calibrated(None), q).frames[-1]
    rows = slice(0, 6) if len(arm.driven) >= _FULL else slice(3, 6)
    command = np.array(q, dtype=float)
    for _ in range(_STEPS):
        error = pose_difference(expected_tool(arm, command), wanted)[:, rows]
        if np.abs(error).max() < _REACHED:
            break
        jacobian = tool_and_jacobian(arm, command)[1][:, rows]
        command += (np.linalg.pinv(jacobian, rcond=_SINGULAR) @ error[:, :, None])[:, :, 0]
    left = expected_tool(arm, command)[:, :3, 3] - wanted[:, :3, 3]
    return command, np.asarray(np.linalg.norm(left, axis=1))
