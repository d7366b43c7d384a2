"""How far an arm droops under its own loads, as the first-order sum of its deflections has it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.even_poses import even_poses
from lostmotion.mechanism.state import states_of

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm

# A larger turn of the tool under the arm's own weight is no droop: some stiffness or mass is not
# what was meant.
_ABSURD: Final = 1.0


@dataclass(frozen=True)
class Droop:
    """The largest displacement (m) and rotation (rad) of the tool by the arm's loads, over poses
    spread evenly over the joint ranges.
    """

    length: float
    turn: float

    @property
    def absurd(self) -> bool:
        """Return whether no arm droops as much: by more than a radian."""
        return not math.isfinite(self.length) or self.turn > _ABSURD


def droop(arm: Arm) -> Droop:
    """Return how far the arm droops under its own weight, its payload and its process force, first
    order.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        found = np.concatenate([state.sag for _, state in states_of(arm, even_poses(arm))])
        turns, lengths = (np.linalg.norm(each, axis=1) for each in np.split(found, 2, axis=1))
    return Droop(float(lengths.max()), float(turns.max()))
