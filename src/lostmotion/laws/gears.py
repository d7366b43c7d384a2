"""What every reducer does, whatever is inside: wind-up in stiffness zones, lost motion, backlash, friction's loop.

Source: makers' rules as Harmonic Drive (K1/K2/K3 zones) and Nabtesco (lost motion at +-3 % of the rated torque) print them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats


def wind_up(torque: Floats, stiffness: Sequence[float], limits: Sequence[float] = ()) -> Floats:
    """By which angle (rad) does the output wind up under torques (any shape, N m)? Odd in the torque.

    `stiffness` N m/rad, one per zone; `limits` N m, rising, one fewer: T/K1 up to T1, on top (T - T1)/K2 up to T2, then (T - T2)/K3.
    Raises ValueError where the counts do not fit or the limits do not rise.
    """
    if len(limits) != len(stiffness) - 1 or any(b <= a for a, b in zip((0.0, *limits), limits, strict=False)):
        raise ValueError("one rising torque limit fewer than stiffness zones is needed")
    size = np.abs(np.asarray(torque, dtype=float))
    angle = np.zeros_like(size)
    low = 0.0
    for k, high in zip(stiffness, (*limits, np.inf), strict=True):
        angle += np.clip(size - low, 0.0, high - low) / k
        low = high
    return np.asarray(np.sign(torque) * angle)


def play_from_lost_motion(lost_motion: float, small_torque: float, stiffness: Sequence[float], limits: Sequence[float] = ()) -> float:
    """How much of a lost motion (rad) is play, when it is read between + and - `small_torque` (N m)? May come out negative: then it is all elastic.

    Lost motion = play + 2 x wind-up at the small torque.
    """
    return lost_motion - 2 * float(wind_up(np.array([small_torque]), stiffness, limits)[0])


def planetary_ratio(sun: int, ring: int) -> float:
    """How often does the sun turn per turn of the planet carrier, with the ring held? From their teeth; Willis: 1 + ring/sun."""
    return 1 + ring / sun
