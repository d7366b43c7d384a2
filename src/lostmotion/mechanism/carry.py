"""Carry matrices: the twist of the tool per twist at a place. They transfer every error and every
deflection to the tool.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats


def carry(tree: Tree, at: Floats, place: int) -> Floats:
    """Return the twist of the tool about the tool point, in the base's axes, per twist at a place
    in its own axes: (pose, 6, 6).

    at     (place, pose, 4, 4) frames of all places, m
    place  index of the place

    Zero for a place that does not carry the tool. The transpose is the wrench at the place per
    wrench on the tool (virtual work).
    Source: adjoint map, K. Lynch, F. Park, Modern Robotics, 2017, 3.3.
    """
    return at_tool_point(at, place) if place in tree.tool_path else np.zeros((at.shape[1], 6, 6))


def at_tool_point(at: Floats, place: int) -> Floats:
    """Return the twist about the tool point, in the base's axes, per twist about a place in its own
    axes (pose, 6, 6), of one rigid body; arguments and source as `carry`.
    """
    out = np.zeros((6, 6, at.shape[1]))  # poses lie innermost in memory
    frame, tool = at[place].transpose(1, 2, 0), at[-1].transpose(1, 2, 0)
    axes, to_tool = frame[:3, :3], tool[:3, 3] - frame[:3, 3]
    out[:3, :3] = out[3:, 3:] = axes
    # each axis x the vector to the tool point
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[3 + i, :3] = axes[j] * to_tool[k] - axes[k] * to_tool[j]
    return out.transpose(2, 0, 1)
