"""ISO 9283:1998 by its definitions: accuracy and repeatability of poses and distances, predicted or measured (paths: `paths.py`); never 'certified'.

Positions in one unit, (..., visit, 3); leading axes are anything: poses, robots. Orientations are small rotation vectors about the base's x, y, z
(a, b, c), attained against commanded, rad.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


def pose_accuracy(attained: Floats, command: Floats) -> Floats:
    """How far is the barycentre of the attained positions (..., visit, 3) from the commanded one (..., 3)? AP_p (...,), in their unit (7.2.1)."""
    return np.asarray(np.linalg.norm(np.mean(attained, axis=-2) - command, axis=-1))


def pose_repeatability(attained: Floats) -> Floats:
    """How far do the attained positions (..., visit, 3) scatter about their barycentre? RP_l = mean + 3 s of the distances (...,) (7.2.2).

    s has n - 1 below the fraction; the standard asks for n = 30. A sample value: at n = 30 it is 2 % low on the average for a round normal
    scatter, and varies by 9 % from one set of visits to the next. Raises ValueError for fewer than two visits.
    """
    attained = np.asarray(attained, dtype=float)
    if attained.shape[-2] < 2:  # noqa: PLR2004 - a scatter needs two
        raise ValueError(f"{attained.shape[-2]} visit; repeatability needs at least 2")
    distance = np.linalg.norm(attained - attained.mean(axis=-2, keepdims=True), axis=-1)
    return np.asarray(distance.mean(axis=-1) + 3 * distance.std(axis=-1, ddof=1))


def axis_accuracy(errors: Floats) -> Floats:
    """How far off is the average along or about each axis? AP_x,y,z or AP_a,b,c (..., 3), signed, of errors (..., visit, 3) (7.2.1)."""
    return np.asarray(np.mean(errors, axis=-2))


def axis_repeatability(errors: Floats) -> Floats:
    """How far do errors (..., visit, 3) scatter along or about each axis? 3 s (..., 3): RP_a, RP_b, RP_c are plus and minus it (7.2.2).

    Raises ValueError for fewer than two visits.
    """
    errors = np.asarray(errors, dtype=float)
    if errors.shape[-2] < 2:  # noqa: PLR2004 - a scatter needs two
        raise ValueError(f"{errors.shape[-2]} visit; repeatability needs at least 2")
    return np.asarray(3 * errors.std(axis=-2, ddof=1))


def multi_directional_accuracy(attained: Floats) -> Floats:
    """How far apart are the barycentres of visits from different sides (..., direction, visit, 3)? vAP_p (...,), the largest distance (7.2.3)."""
    barycentres = np.mean(attained, axis=-2)
    apart = np.linalg.norm(barycentres[..., :, None, :] - barycentres[..., None, :, :], axis=-1)
    return np.asarray(apart.max(axis=(-2, -1)))


def distance_accuracy(first: Floats, second: Floats, command: Floats | float) -> Floats:
    """By how much is the average distance of two attained positions (..., visit, 3) larger than the commanded one? AD_p (...,), signed (7.3.2)."""
    return np.asarray(np.linalg.norm(np.asarray(second) - first, axis=-1).mean(axis=-1) - command)


def distance_repeatability(first: Floats, second: Floats) -> Floats:
    """How far does the distance between two attained positions (..., visit, 3) scatter? RD (...,) is plus and minus this 3 s (7.3.3)."""
    distance = np.linalg.norm(np.asarray(second, dtype=float) - first, axis=-1)
    if distance.shape[-1] < 2:  # noqa: PLR2004 - a scatter needs two
        raise ValueError(f"{distance.shape[-1]} visit; repeatability needs at least 2")
    return np.asarray(3 * distance.std(axis=-1, ddof=1))
