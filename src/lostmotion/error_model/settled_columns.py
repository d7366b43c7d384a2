"""How the columns of a pose matrix move the tool of an arm that stands under its loads."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.mechanism import load_feedback
from lostmotion.mechanism.equilibrium import displacement
from lostmotion.spatial import added_in_order

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.state import State
    from lostmotion.spatial import Floats


def moved_tool(
    state: State, place: NDArray[np.int64], local: Floats, settles: NDArray[np.bool_]
) -> Floats:
    """Return the motion of the tool (6, column, pose), rad and m, by screws at places.

    place    (column,) index of the place of each screw, in groups of equal indices
    local    (6, column, pose) screws, rad and m
    settles  (column,) whether it is part of the equilibrium: design columns

    In a settled state those that are add up to the exact displacement of the tool from its command:
    each moves the tool by the mean of its effects at the command and where the arm stands, and what
    that leaves (third order) is shared in proportion to their sizes. The others move a soft arm
    with the loads that they change.
    """
    found = state.equilibrium
    if found is None or not state.arm.soft_freedoms:
        tool = state.tool_twists(place, local)
    else:
        tool = np.empty_like(local)
        tool[:, settles] = state.tool_twists(place[settles], local[:, settles])
        tool[:, ~settles] = load_feedback.tool_twists(state, place[~settles], local[:, ~settles])
    if found is not None and settles.any():
        own, command = local[:, settles], replace(state, frames=found.command, equilibrium=None)
        mean = (command.tool_twists(place[settles], own) + tool[:, settles]) / 2
        left = displacement(found) - added_in_order(mean, 1)
        for rows in (slice(0, 3), slice(3, 6)):
            size = np.sqrt(added_in_order(mean[rows] ** 2, 0))
            share = size / np.where(size.any(axis=0), added_in_order(size, 0), 1.0)
            tool[rows, settles] = mean[rows] + left[rows, None] * share
    return tool
