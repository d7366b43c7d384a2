"""How far an arm droops under its own loads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.equilibrium import displacement
from lostmotion.mechanism.even_poses import even_poses
from lostmotion.mechanism.state import states_of

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm

# Of the evenly spread poses, each of this many.
_EACH: Final = 4


@dataclass(frozen=True)
class Droop:
    """The largest displacement (m) and rotation (rad) of the tool by the arm's loads, over poses
    spread evenly over the joint ranges.
    """

    length: float
    turn: float


def droop(arm: Arm) -> Droop:
    """Return how far the arm droops under its own weight, its payload and its process force; of the
    poses where it stands.
    """
    found = []
    for _, state in states_of(arm, even_poses(arm)[::_EACH]):
        settled = state.settled().equilibrium
        if settled is None:  # of first order
            found.append(state.sag.T)
        else:
            found.append(displacement(settled)[:, settled.falls_at < 0])
    turns, lengths = (np.linalg.norm(part, axis=0) for part in np.split(np.hstack(found), 2))
    return Droop(float(lengths.max(initial=0.0)), float(turns.max(initial=0.0)))
