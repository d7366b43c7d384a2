"""Stiffness of the ground under a tracked vehicle, as an elastic (Winkler) foundation: settlement
proportional to pressure.
"""

from __future__ import annotations

import numpy as np


def track_stiffness(
    length: float, width: float, gauge: float, bedding: float, shear_share: float
) -> np.ndarray:
    """Return the stiffness (6,) of the ground under a pair of tracks, about (N m/rad) and along
    (N/m) x (forward), y (left) and z (up).

    length, width  of the ground contact of each track, m
    gauge          distance between the centre lines of the tracks, m
    bedding        pressure per settlement, N/m^3
    shear_share    tangential stiffness as a share of the bedding

    The reference point is the common centre of both contacts. Valid for uniform ground that settles
    at each point by the pressure there alone, and for tracks that neither lift off nor slip. Hull,
    tracks, rollers and springs are rigid. Source: E. Winkler, Die Lehre von der Elasticitaet und
    Festigkeit, 1867; K. Terzaghi, Geotechnique 5 (1955) 297 (values of the bedding).
    """
    area = 2 * length * width
    about_x = area * (gauge**2 / 4 + width**2 / 12)
    about_y = area * length**2 / 12
    return bedding * np.array(
        [
            about_x,
            about_y,
            shear_share * (about_x + about_y),
            shear_share * area,
            shear_share * area,
            area,
        ]
    )
