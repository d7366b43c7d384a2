"""Play as a dead band that the load closes on one side.

A part with play rests on the side to which the load pushes it. Only when the load is smaller than the friction that can hold it
elsewhere does the way of arriving decide. Between the two this law goes over linearly: with c = load/friction cut to -1..1 the part sits at
c of the half play, and the way of arriving moves it within the 1 - |c| that is left, so it never leaves the play.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# A load smaller than this share of the whole wrench is what rounding leaves of zero, not a load.
_ROUNDING = 1e-9


def seated(load: Floats, friction: float, scale: Floats) -> Floats:
    """Which share of the half play does the load take up, with its sign, for loads (pose,)? Result in -1..1.

    `friction` in the load's unit, zero or more; with zero friction any load closes the play. `scale` (pose,) is the size of the whole wrench
    that the load is a component of: where friction is not above 1e-9 of it, a smaller load than that counts as none. With more friction the share is
    continuous in the load, through zero too.
    """
    rounding = _ROUNDING * scale
    real = np.where((np.abs(load) > rounding) | (friction > rounding), load, 0.0)
    if friction == 0:
        return np.sign(real)
    return np.clip(real, -friction, friction) / friction
