"""At which poses an arm is assembled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import InputError, Problem
from lostmotion.mechanism.closed_arrays import ASSEMBLED
from lostmotion.mechanism.closed_box import drives_in_box, excluded
from lostmotion.mechanism.closed_chain import home_frames
from lostmotion.mechanism.closed_position import assemble

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Poses evaluated at a time, so that their frames fit into memory.
_BLOCK: Final = 4096
# Factor by which the position of a closed chain takes longer than that of an open one, roughly.
_STEP_BY_STEP: Final = 128


def assembled(arm: Arm, q: Floats) -> NDArray[np.bool_]:
    """Return whether (pose,) the arm is assembled at each of these poses (pose, joint), within the
    limits of its passive joints: everywhere for an arm without closures.
    """
    out = np.ones(len(q), dtype=bool)
    for first in range(0, len(q) if arm.closures else 0, _BLOCK):
        here = slice(first, first + _BLOCK)
        out[here] = assemble(arm.tree, q[here]).problem == ASSEMBLED
    return out


def pose_ranges(arm: Arm) -> Floats:
    """Return the ranges (value, 2), rad or m, in which poses are sampled: the limits of the drives,
    or those of the box of the tool that the file of a closed chain states.
    """
    return arm.limits if arm.workspace is None else arm.workspace.ranges


def drives_at(arm: Arm, values: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the joint values (pose, joint), rad or m, for values (pose, value) in the ranges of
    `pose_ranges`, and whether (pose,) the arm is assembled there, within the limits of its joints.

    Joint values of other poses have no meaning.
    """
    if arm.workspace is None:
        return values, assembled(arm, values)
    q, inside = np.empty((len(values), len(arm.driven))), np.empty(len(values), dtype=bool)
    for first in range(0, len(values), _BLOCK):
        here = slice(first, first + _BLOCK)
        q[here], problem = drives_in_box(arm.tree, arm.limits, arm.workspace, values[here])
        inside[here] = problem == ASSEMBLED
    return q, inside


def hardly_assembled(arm: Arm, inside: NDArray[np.bool_]) -> InputError:
    """Return the error of a closed chain that is assembled at hardly any pose in its ranges, with
    what excludes the others; `inside` (pose,) is where it is.
    """
    found = f"a closed chain that is assembled at {np.count_nonzero(inside)} of {len(inside)} poses"
    why = excluded(arm.tree, arm.limits, arm.workspace)
    if arm.workspace is None:
        key, expected, example = "joints", "limits of the drives near their values at home", ""
    else:
        at = ", ".join(f"{round(1e3 * x, 3) + 0.0:g}" for x in home_frames(arm.tree)[-1, 0, :3, 3])
        key, example = "workspace", 'x = ["-50 mm", "50 mm"]'
        expected = f"a box that the tool reaches; it is at ({at}) mm at home"
    return InputError([Problem(arm.name, key, f"{found}; {why}", expected, example)])


def may_not_assemble(arm: Arm) -> bool:
    """Return whether there may be values of the drives within their limits at which the arm is not
    assembled: of a closed chain, never of an open one.
    """
    return bool(arm.closures)


def affordable(arm: Arm, points: int) -> int:
    """Return how many of so many tool points are worth their time for a picture or a volume: fewer
    of a closed chain, whose closures are met step by step.
    """
    return points // _STEP_BY_STEP if arm.closures else points
