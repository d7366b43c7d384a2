"""How far an arm droops under its own loads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.equilibrium import displacement
from lostmotion.mechanism.even_poses import even_poses
from lostmotion.mechanism.standing import settled_at
from lostmotion.mechanism.state import BLOCK, states_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.arm import Arm

# Of the evenly spread poses, each of this many.
_EACH: Final = 4


@dataclass(frozen=True)
class Droop:
    """The largest displacement (m) and rotation (rad) of the tool by the arm's loads, over poses
    spread evenly over the joint ranges.

    falls_at  (pose,) index of the place that cannot hold the load there; -1 where the arm stands
    """

    length: float
    turn: float
    falls_at: NDArray[np.int64]


def droop(arm: Arm) -> Droop:
    """Return how far the arm droops under its own weight, its payload and its process force; of the
    poses where it stands.
    """
    found, falls_at = [], []
    poses = even_poses(arm)[::_EACH]
    # The steps of a soft arm take nearly the same time for any number of poses, and several sheets
    # state its droop.
    states = (
        [settled_at(arm, poses)]
        if arm.soft_freedoms
        else (state.settled() for _, state in states_of(arm, poses, BLOCK))
    )
    for state in states:
        settled = state.equilibrium
        if settled is None:  # of first order
            found.append(state.sag.T)
            falls_at.append(np.full(len(state), -1))
        else:
            found.append(displacement(settled)[:, settled.falls_at < 0])
            falls_at.append(settled.falls_at)
    turns, lengths = (np.linalg.norm(part, axis=0) for part in np.split(np.hstack(found), 2))
    length, turn = (float(each.max(initial=0.0)) for each in (lengths, turns))
    return Droop(length, turn, np.concatenate(falls_at))
