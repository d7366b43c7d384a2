"""Deep groove ball bearings of which only the size is known: usual size and number of balls.

Balls of 0.30 (D - d) and 2.9 (D + d)/(D - d) of them fit the common series to about 10 %. The
stiffness is then known to a factor of 0.7 to 1.4.

Source: this project's estimate from common deep groove bearings; contacts after T. Harris, Rolling
Bearing Analysis, 4th ed., 2001.
"""

from __future__ import annotations

from typing import Final

from lostmotion.laws.rolling.radial import (
    BALL_EXPONENT,
    ball_stiffness,
    element_angles,
    radial_shift,
)

_BALL: Final = 0.30
_NUMBER: Final = 2.9
# Uncertainty of the stiffness, as a factor.
STIFFNESS_BAND: Final = (0.7, 1.4)


def balls_of_size(bore: float, outside: float) -> tuple[int, float]:
    """Return the usual number of balls of a bearing, and the stiffness K (N/m^1.5) of one, from its
    bore and outside diameter (m).

    Raises ValueError for an outside diameter that leaves no room for balls.
    """
    if not 0 < bore < outside:
        raise ValueError(
            f"a bearing with a bore of {bore:g} m and an outside diameter of {outside:g} m has "
            "no room for balls"
        )
    number = max(3, round(_NUMBER * (outside + bore) / (outside - bore)))
    return number, ball_stiffness(_BALL * (outside - bore), (outside + bore) / 2)


def stiffness_of_size(bore: float, outside: float, force: float) -> float:
    """Return the secant stiffness (N/m) of a bearing of this bore and outside diameter (m) under a
    radial force (N), without clearance.
    """
    number, each = balls_of_size(bore, outside)
    return force / float(radial_shift(force, 0.0, each, BALL_EXPONENT, element_angles(number)))
