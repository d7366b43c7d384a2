"""A vehicle on two tracks, its hull rigid, on ground that gives in proportion to the pressure on it."""

from __future__ import annotations

import numpy as np


def track_stiffness(length: float, width: float, gauge: float, bedding: float, shear_share: float) -> np.ndarray:
    """How stiffly does the ground hold a pair of tracks? (6,) about and along x (forward), y (left), z (up), at the middle of both contacts.

    `length` and `width` (m) of the ground contact of each track, `gauge` (m) between the tracks' middles, `bedding` (N/m^3) the ground's pressure per
    settlement, `shear_share` what it holds along the ground as a share of that. Winkler's bedding: every spot of the ground answers to its own
    pressure alone, evenly under all of both tracks, which do not lift off or slip; the tracks, their rollers and springs are rigid.
    Source: E. Winkler, Die Lehre von der Elasticitaet und Festigkeit, 1867; K. Terzaghi, Geotechnique 5 (1955) 297 (values of the bedding).
    """
    area = 2 * length * width
    about_x = area * (gauge**2 / 4 + width**2 / 12)
    about_y = area * length**2 / 12
    return bedding * np.array([about_x, about_y, shear_share * (about_x + about_y), shear_share * area, shear_share * area, area])
