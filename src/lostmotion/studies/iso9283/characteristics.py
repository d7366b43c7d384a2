"""ISO 9283:1998 by its definitions: accuracy and repeatability of poses and distances, predicted or measured (paths: `paths.py`); never 'certified'.

Positions in one unit, (..., visit, 3); leading axes are anything: poses, robots. Orientations are small rotation vectors about the base's x, y, z
(a, b, c), attained against commanded, rad.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.normal_length import normal_length

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


def expected_repeatability(covariance: Floats, visits: int | None = None) -> tuple[Floats, Floats]:
    """Which RP_l is to be expected of visits that scatter normally with this covariance (n, 3, 3), and how much will it vary? Both (n,).

    `visits` None: what RP_l tends to with many visits, deviation 0. Otherwise the mean and standard deviation over sets of so many visits, to first
    order in 1 / visits: distances from the barycentre are shorter by sqrt(1 - 1/n), and s follows from the distances' third and fourth moments
    (M. Kendall, A. Stuart, The Advanced Theory of Statistics, vol. 1, ch. 10). Within 0.1 % of the mean and 2 % of the deviation at n = 30. Not for
    scatter by a few two-sided or flat draws. Raises ValueError for fewer than two visits.
    """
    if visits is not None and visits < 2:  # noqa: PLR2004 - a scatter needs two
        raise ValueError(f"{visits} visit; repeatability needs at least 2")
    covariance = np.asarray(covariance, dtype=float)
    found = normal_length(np.zeros((len(covariance), 3)), covariance, ())
    mean, square, cube = found.mean, found.mean_square, found.cube_mean
    fourth = square**2 + 2 * np.einsum("nij,nij->n", covariance, covariance)
    spread = np.sqrt(np.maximum(square - mean**2, 0.0))
    if visits is None:
        return mean + 3 * spread, np.zeros_like(mean)
    safe = np.where(spread > 0, spread, 1.0)
    skew = (cube - 3 * mean * square + 2 * mean**3) / safe**3
    excess = (fourth - 4 * mean * cube + 6 * mean**2 * square - 3 * mean**4) / safe**4 - 3
    noise = 2 / (visits - 1) + excess / visits
    shrunk = np.sqrt(1 - 1 / visits)
    expected = shrunk * (mean + 3 * spread * (1 - noise / 8))
    deviation = shrunk * spread * np.sqrt(np.maximum(1 / visits + 9 * noise / 4 + 3 * skew / visits, 0.0))
    return np.asarray(expected), np.asarray(deviation)


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
