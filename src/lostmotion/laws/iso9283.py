"""Pose, distance and path characteristics of ISO 9283:1998.

The definitions apply to predicted and measured positions; they certify nothing. Positions are in
one unit, (..., visit, 3), with any leading axes (poses, robots). Orientation errors are small
rotation vectors about the base's x, y, z axes (a, b, c), attained relative to commanded, rad.

For path accuracy AT and path repeatability RT (8.2, 8.3) the standard cuts the attained paths by
planes normal to the commanded path and evaluates each plane. Errors (..., cycle, 6) at a plane are
the rotation vector from the commanded orientation, rad, and the displacement from the commanded
point, in one unit; base axes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# Characteristics of a path, in the order of every array here; those of orientation about each axis.
PATH_FIGURES: Final = ("AT_p", "RT_p", "AT_a", "AT_b", "AT_c", "RT_a", "RT_b", "RT_c")
_DIRECTION: Final = 3
# Fewest readings of a cycle from which a path is evaluated.
MIN_READINGS: Final = 5
# Largest distance of two readings at one place, as a share of the mean distance between readings.
_NEAR: Final = 0.1
# Smallest share of the places of the cycle with the fewest readings that all cycles must share.
_SHARED: Final = 0.9


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


def across_path(errors: Floats, along: Floats) -> Floats:
    """Return the components of errors (..., 3) normal to a path's direction (3,)."""
    along = np.asarray(along) / np.linalg.norm(along)
    return np.asarray(errors - (errors * along).sum(axis=-1, keepdims=True) * along)


def path_figures(errors: Floats, along: Floats) -> Floats:
    """Return `PATH_FIGURES` (8, ...), all unsigned, of the cycles' errors (..., cycle, 6) at one
    plane normal to the direction `along` (3,).

    AT_p: length of the mean across the path; RT_p: mean + 3 s of the distances from it; AT_a, b, c:
    absolute mean rotation; RT_a, b, c: 3 s. s uses the n - 1 denominator; the standard asks for n =
    10. Raises ValueError for fewer than two cycles.
    """
    across, turn = across_path(errors[..., 3:], along), errors[..., :3]
    lengths = pose_accuracy(across, np.zeros(3)), pose_repeatability(across)
    turns = np.abs(axis_accuracy(turn)), axis_repeatability(turn)
    return np.stack(
        [*lengths, *(np.moveaxis(each, -1, 0)[k] for each in turns for k in range(_DIRECTION))]
    )


def shared_places(ways: Sequence[Floats]) -> list[np.ndarray] | None:
    """Return the indices (place,) of each cycle's readings at places that all cycles share, in path
    order; None where they share too few.

    `ways` holds the positions (reading,) of each cycle's readings along the commanded path, m. A
    place is shared where every cycle has a reading within a tenth of the mean reading distance. At
    least five places, and nine tenths of those of the cycle with the fewest readings, must be
    shared.
    """
    fewest = np.sort(min(ways, key=len))
    if len(fewest) < MIN_READINGS:
        return None
    near = _NEAR * float(fewest[-1] - fewest[0]) / (len(fewest) - 1)
    kept = [fewest[0]]
    for place in fewest[1:]:
        if place - kept[-1] > 2 * near:  # readings at rest share one place
            kept.append(place)
    places = np.array(kept)
    nearest = [np.abs(way[:, None] - places).argmin(axis=0) for way in ways]
    everywhere = np.all(
        [np.abs(way[at] - places) <= near for way, at in zip(ways, nearest, strict=True)], axis=0
    )
    if everywhere.sum() < max(MIN_READINGS, _SHARED * len(places)):
        return None
    return [at[everywhere] for at in nearest]


def moved_to_planes(ways: Sequence[Floats], errors: Sequence[Floats], places: Floats) -> Floats:
    """Return errors (plane, cycle, k) at `places` (plane,) that all cycles cover, from two cycles
    or more that were read at different places.

    Each cycle's nearest reading is moved to the plane by the mean change of the other cycles over
    the same distance, interpolated linearly. The reading keeps its full noise: a point interpolated
    between two readings has about two thirds of its variance, and RT from such points is 18 % low
    where neighbouring readings are independent. A cycle without a reading between the outer planes
    is interpolated.

    ways    (reading,) of each cycle: position along the commanded path, m
    errors  (reading, k) of each cycle
    """
    here = [crossings(way, each, places) for way, each in zip(ways, errors, strict=True)]
    nearest = [_nearest(way, places) for way in ways]
    at = np.array([places if k is None else way[k] for way, k in zip(ways, nearest, strict=True)])
    steps = np.zeros((len(ways), len(places), errors[0].shape[1]))
    for way, each, there in zip(ways, errors, here, strict=True):
        steps += there - crossings(way, each, at.ravel()).reshape(steps.shape)
    out = np.empty_like(steps)
    for k, (each, there, chosen) in enumerate(zip(errors, here, nearest, strict=True)):
        read = there if chosen is None else each[chosen]
        out[k] = read + (steps[k] - (there - read)) / (len(ways) - 1)
    return np.swapaxes(out, 0, 1)


def _nearest(way: Floats, places: Floats) -> np.ndarray | None:
    """Return the index of the reading between the outer planes that is nearest to each plane; None
    without any.
    """
    inside = np.flatnonzero((way >= places[0]) & (way <= places[-1]))
    return inside[np.abs(way[inside, None] - places).argmin(axis=0)] if inside.size else None


def crossings(way: Floats, readings: Floats, places: Floats) -> Floats:
    """Return the readings (plane, k) of one attained path, interpolated linearly to `places`
    (plane,) along the commanded path.

    way       (reading,) position along the commanded path; where noise makes it decrease, readings
              are sorted by it
    readings  (reading, k)
    """
    order = np.argsort(way, kind="stable")
    return np.stack(
        [np.interp(places, way[order], column[order]) for column in readings.T], axis=-1
    )
