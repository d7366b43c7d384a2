"""Compliance of belts, ball screws and racks along a linear axis.

Sources: "Timing Belt Theory", Gates Mectrol (stiffness of both strands of a linear positioner);
THK, "General Catalog", ball screws, axial rigidity of the feed system (screw, nut and support
bearings in series; two-sided support in parallel).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Young's and shear modulus of steel, Pa.
STEEL: Final = 206e9
STEEL_SHEAR: Final = 79.3e9


def belt_compliance(near: Floats, length: float, tension: float) -> Floats:
    """Return the compliance (m/N) of a carriage on an open belt against its drive pulley: both
    strands hold it.

    k = EA/near + EA/(length - near). Valid while the pretension keeps both strands taut, and for
    pulleys that do not yield.

    near     free length from the drive pulley to the carriage (any shape), m
    length   free length of the whole belt, both strands, without what lies on the drive pulley, m
    tension  EA: force per strain, N
    """
    return near * (length - near) / (tension * length)


def belt_stage_stiffness(strand: float, radius: float, tension: float) -> float:
    """Return the torsional stiffness (N m/rad) at a pulley of this pitch radius (m), by the two
    strands of a closed belt: 2 EA r²/l.

    Valid while the pretension keeps both strands taut, for a motor pulley that is held.

    strand   free length of each strand, m
    tension  EA: force per strain, N
    """
    return 2 * tension * radius**2 / strand


def screw_compliance(
    at: Floats,
    length: float,
    diameter: float,
    *,
    lead: float | None,
    nut: float,
    near_bearing: float,
    far_bearing: float | None,
) -> Floats:
    """Return the axial compliance (m/N) of the nut of a ball screw against a held motor.

    The near end holds the screw axially and in rotation. With a far bearing both ends hold it
    axially: two springs in parallel. The nut is in series, and so is the torsion of the screw
    between the near end and the nut, which the lead turns into travel: (lead/2π)² x/(G J).

    at            distance of the nut from the near bearing (any shape), m
    length        distance between the bearings, m
    diameter      root diameter of the steel screw, m
    lead          travel per turn, m; None: no torsion
    nut, near_bearing, far_bearing  axial stiffness, N/m; inf: rigid; far_bearing None: that end is
                                    free axially
    """
    area, torsion = math.pi * diameter**2 / 4, math.pi * diameter**4 / 32
    near = at / (STEEL * area) + 1 / near_bearing
    if far_bearing is not None:
        near = 1 / (1 / near + 1 / ((length - at) / (STEEL * area) + 1 / far_bearing))
    turning = 0.0 if lead is None else (lead / (2 * math.pi)) ** 2 * at / (STEEL_SHEAR * torsion)
    return near + 1 / nut + turning


def rack_compliance(radius: float, torsional_stiffness: float) -> float:
    """Return the compliance (m/N) along a rack of a pinion of this pitch radius (m) on a drive of
    this torsional stiffness (N m/rad): r²/k.
    """
    return radius**2 / torsional_stiffness
