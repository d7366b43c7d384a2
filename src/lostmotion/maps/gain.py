"""How near a closed chain is to a parallel singularity over its workspace: the gain."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.assembly import may_not_assemble
from lostmotion.mechanism.closed_trust import loosest

if TYPE_CHECKING:
    from lostmotion.maps.cells import CellPoses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_CHUNK: Final = 4096


def gain_by_cell(arm: Arm, reached: CellPoses) -> Floats | None:
    """Return how many times as far as at home an error of the drives moves the tool along its loose
    direction (x, y, z), the largest of the poses of each cell; NaN for cells without. None for an
    open chain, which has no such singularities.

    Rotation counts in rad, and shift as a share of the longest fixed distance in the chain.
    """
    if not may_not_assemble(arm):
        return None
    (home,) = loosest(arm.tree, arm.home[None])[1]
    found = np.full(reached.grid.shape, -np.inf)
    for start in range(0, len(reached.q), _CHUNK):
        here = slice(start, start + _CHUNK)
        gains = loosest(arm.tree, reached.q[here])[1] / home
        np.maximum.at(found.reshape(-1), reached.cell[here], gains)
    return np.where(np.isfinite(found), found, np.nan)
