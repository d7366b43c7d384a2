"""Play as a dead band whose side the load chooses.

A part with play rests on the side to which the load pushes it. Where the load is smaller than the friction that can hold the part elsewhere, the
direction of arrival decides. Between the two cases the law is linear: with c = load/friction limited to -1..1 the part rests at c times the half
play, and the direction of arrival moves it within the remaining 1 - |c|, so it never leaves the play.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# A load below this share of the whole wrench is rounding, not a load.
_ROUNDING = 1e-9


def seated(load: Floats, friction: float, scale: Floats) -> Floats:
    """Return the share of the half play that the load takes up, -1..1 with its sign, for loads (pose,).

    `friction` in the load's unit, zero or more; without friction any load closes the play. `scale` (pose,) is the magnitude of the whole wrench that
    the load is a component of. Where friction is at most 1e-9 of it, loads below 1e-9 of it are rounding and count as none. With more friction the
    share is continuous in the load, also through zero.
    """
    rounding = _ROUNDING * scale
    real = np.where((np.abs(load) > rounding) | (friction > rounding), load, 0.0)
    if friction == 0:
        return np.sign(real)
    return np.clip(real, -friction, friction) / friction
