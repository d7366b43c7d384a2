"""Pose and distance characteristics of ISO 9283:1998 (path characteristics: `paths.py`).

The definitions apply to predicted and measured positions; they certify nothing. Positions are in
one unit, (..., visit, 3), with any leading axes (poses, robots). Orientation errors are small
rotation vectors about the base's x, y, z axes (a, b, c), attained relative to commanded, rad.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


def pose_accuracy(attained: Floats, command: Floats) -> Floats:
    """Return the pose accuracy AP_p (...,): distance of the barycentre of attained positions (...,
    visit, 3) from the command (..., 3) (7.2.1).
    """
    return np.asarray(np.linalg.norm(np.mean(attained, axis=-2) - command, axis=-1))


def pose_repeatability(attained: Floats) -> Floats:
    """Return the pose repeatability RP_l (...,) = mean + 3 s of the distances of attained positions
    (..., visit, 3) from their barycentre (7.2.2).

    s uses the n - 1 denominator; the standard asks for n = 30. A sample estimate: with n = 30 and
    isotropic normal scatter it is 2 % low on average and varies by 9 % between sets of visits.
    Raises ValueError for fewer than two visits.
    """
    attained = np.asarray(attained, dtype=float)
    if attained.shape[-2] < 2:  # noqa: PLR2004 - a standard deviation needs two
        raise ValueError(f"{attained.shape[-2]} visit; repeatability needs at least 2")
    distance = np.linalg.norm(attained - attained.mean(axis=-2, keepdims=True), axis=-1)
    return np.asarray(distance.mean(axis=-1) + 3 * distance.std(axis=-1, ddof=1))


def axis_accuracy(errors: Floats) -> Floats:
    """Return the signed mean error along or about each axis, AP_x,y,z or AP_a,b,c (..., 3), of
    errors (..., visit, 3) (7.2.1).
    """
    return np.asarray(np.mean(errors, axis=-2))


def axis_repeatability(errors: Floats) -> Floats:
    """Return 3 s of errors (..., visit, 3) along or about each axis (..., 3); RP_a, RP_b, RP_c are
    plus and minus this value (7.2.2).

    Raises ValueError for fewer than two visits.
    """
    errors = np.asarray(errors, dtype=float)
    if errors.shape[-2] < 2:  # noqa: PLR2004 - a standard deviation needs two
        raise ValueError(f"{errors.shape[-2]} visit; repeatability needs at least 2")
    return np.asarray(3 * errors.std(axis=-2, ddof=1))


def multi_directional_accuracy(attained: Floats) -> Floats:
    """Return vAP_p (...,): largest distance between the barycentres of visits from several
    directions (..., direction, visit, 3) (7.2.3).
    """
    barycentres = np.mean(attained, axis=-2)
    apart = np.linalg.norm(barycentres[..., :, None, :] - barycentres[..., None, :, :], axis=-1)
    return np.asarray(apart.max(axis=(-2, -1)))


def distance_accuracy(first: Floats, second: Floats, command: Floats | float) -> Floats:
    """Return AD_p (...,): mean distance of two attained positions (..., visit, 3) less the
    commanded distance, signed (7.3.2).
    """
    return np.asarray(np.linalg.norm(np.asarray(second) - first, axis=-1).mean(axis=-1) - command)


def distance_repeatability(first: Floats, second: Floats) -> Floats:
    """Return 3 s of the distance between two attained positions (..., visit, 3); RD (...,) is plus
    and minus this value (7.3.3).

    Raises ValueError for fewer than two visits.
    """
    distance = np.linalg.norm(np.asarray(second, dtype=float) - first, axis=-1)
    if distance.shape[-1] < 2:  # noqa: PLR2004 - a standard deviation needs two
        raise ValueError(f"{distance.shape[-1]} visit; repeatability needs at least 2")
    return np.asarray(3 * distance.std(axis=-1, ddof=1))
