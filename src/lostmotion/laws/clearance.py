"""Play that a load closes once it overcomes dry friction, which differs from robot to robot.

Below the friction the part rests where the last motion left it, within its play; above it the load
holds the part on one side. Between robots the friction scatters, so that a load closes the play in
a share of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.distributions import of_tolerance

if TYPE_CHECKING:
    from lostmotion.spatial import Floats
    from lostmotion.units import Toleranced

# A load below this share of the whole wrench is rounding, not a load.
_ROUNDING = 1e-9


def closed_share(load: Floats, friction: Toleranced, scale: Floats) -> Floats:
    """Return the share of robots in which loads (pose,) of zero or more overcome the friction and
    close the play: 0..1.

    `friction` in the load's unit, zero or more, with its scatter between robots; without friction
    any load closes the play, and without scatter the share is 0 or 1. `scale` (pose,) is the
    magnitude of the whole wrench that the load is a component of. Where friction is at most 1e-9 of
    it, loads below 1e-9 of it are rounding and count as none. With scatter the share is continuous
    in the load.
    """
    rounding = _ROUNDING * scale
    real = np.where((load > rounding) | (friction.nominal > rounding), load, 0.0)
    if not friction.tolerance:
        return np.asarray((real > 0) & (real >= friction.nominal), dtype=float)
    # Beside a scatter that is next to nothing a load is infinitely far from the friction.
    with np.errstate(over="ignore"):
        return of_tolerance(friction.law).share_below(
            (real - friction.nominal) / friction.tolerance
        )
