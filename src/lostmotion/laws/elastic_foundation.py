"""A vehicle with a rigid hull on two tracks, on ground whose settlement is proportional to the pressure."""

from __future__ import annotations

import numpy as np


def track_stiffness(length: float, width: float, gauge: float, bedding: float, shear_share: float) -> np.ndarray:
    """Return the stiffness (6,) of the ground under a pair of tracks, about and along x (forward), y (left), z (up), at the contacts' common centre.

    `length` and `width` (m) of the ground contact of each track, `gauge` (m) between the tracks' centre lines, `bedding` (N/m^3) pressure per
    settlement, `shear_share` the tangential stiffness as a share of that. Winkler's foundation: each point of the ground responds to the pressure
    there alone, uniformly under both tracks, which neither lift off nor slip; the tracks, their rollers and springs are rigid. Source: E. Winkler,
    Die Lehre von der Elasticitaet und Festigkeit, 1867; K. Terzaghi, Geotechnique 5 (1955) 297 (values of the bedding).
    """
    area = 2 * length * width
    about_x = area * (gauge**2 / 4 + width**2 / 12)
    about_y = area * length**2 / 12
    return bedding * np.array([about_x, about_y, shear_share * (about_x + about_y), shear_share * area, shear_share * area, area])
