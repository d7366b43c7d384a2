"""How well is a straight path followed? AT and RT by ISO 9283:1998, 8.2 and 8.3: one definition, for robots predicted and measured alike.

The standard cuts the attained paths by planes across the commanded one, and looks at the points of one plane together. Errors (..., cycle, 6) at one
plane: rotation vector from the commanded orientation, rad, and shift from the commanded point, in one unit; base axes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.iso9283 import characteristics as iso

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# What is told of a path, in the order of every array here; the standard gives accuracy and repeatability of its orientation about each axis.
PATH_FIGURES: Final = ("AT_p", "RT_p", "AT_a", "AT_b", "AT_c", "RT_a", "RT_b", "RT_c")
_DIRECTION: Final = 3
# A cycle of fewer readings shows no path.
MIN_READINGS: Final = 5
# Of the mean distance between readings: as far apart two readings still stand at one place.
_NEAR: Final = 0.1
# Of the places of the cycle with the fewest readings: so many must be shared, or single places would be left out.
_SHARED: Final = 0.9


def across_path(errors: Floats, along: Floats) -> Floats:
    """Which part of errors (..., 3) lies in the plane across a path's direction (3,)? There the standard looks at paths."""
    along = np.asarray(along) / np.linalg.norm(along)
    return np.asarray(errors - (errors * along).sum(axis=-1, keepdims=True) * along)


def path_figures(errors: Floats, along: Floats) -> Floats:
    """What do the cycles' errors (..., cycle, 6) say at one plane across the direction `along` (3,)? `PATH_FIGURES` there (8, ...), none signed.

    AT_p: length of the average across the path; RT_p: mean + 3 s of the distances from it; AT_a, b, c: size of the average turn; RT_a, b, c: 3 s.
    s has n - 1 below the fraction; the standard asks for n = 10. Raises ValueError for fewer than two cycles.
    """
    across, turn = across_path(errors[..., 3:], along), errors[..., :3]
    lengths = iso.pose_accuracy(across, np.zeros(3)), iso.pose_repeatability(across)
    turns = np.abs(iso.axis_accuracy(turn)), iso.axis_repeatability(turn)
    return np.stack([*lengths, *(np.moveaxis(each, -1, 0)[k] for each in turns for k in range(_DIRECTION))])


def shared_places(ways: Sequence[Floats]) -> list[np.ndarray] | None:
    """Return which readings of each cycle stand at places that all cycles share, in the order of the path; None where they share too few.

    ways  (reading,) of each cycle: how far along the commanded path its readings stand, m
    A place is shared where every cycle has a reading within a tenth of the mean distance between readings; the result holds one index array
    (place,) for each cycle. At least nine tenths of the places of the cycle with the fewest readings must be shared, and five.
    """
    fewest = np.sort(min(ways, key=len))
    if len(fewest) < MIN_READINGS:
        return None
    near = _NEAR * float(fewest[-1] - fewest[0]) / (len(fewest) - 1)
    kept = [fewest[0]]
    for place in fewest[1:]:
        if place - kept[-1] > 2 * near:  # readings at rest stand at one place
            kept.append(place)
    places = np.array(kept)
    nearest = [np.abs(way[:, None] - places).argmin(axis=0) for way in ways]
    everywhere = np.all([np.abs(way[at] - places) <= near for way, at in zip(ways, nearest, strict=True)], axis=0)
    if everywhere.sum() < max(MIN_READINGS, _SHARED * len(places)):
        return None
    return [at[everywhere] for at in nearest]


def moved_to_planes(ways: Sequence[Floats], errors: Sequence[Floats], places: Floats) -> Floats:
    """Return errors (plane, cycle, k) at `places` (plane,) that all cycles cover, of two cycles or more that were read at places of their own.

    Each cycle's nearest reading is moved to the plane by as much as the other cycles change from there to the plane on the average, straight from
    reading to reading. So the reading keeps its whole noise: a point interpolated between two readings has about two thirds of its variance, and a
    repeatability from such points is 18 % low where neighbouring readings have nothing in common. A cycle without a reading between the outer planes
    is interpolated.

    ways    (reading,) of each cycle: how far along the commanded path its readings stand, m
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
    """Return which reading between the outer planes is nearest to each plane; None without any."""
    inside = np.flatnonzero((way >= places[0]) & (way <= places[-1]))
    return inside[np.abs(way[inside, None] - places).argmin(axis=0)] if inside.size else None


def crossings(way: Floats, readings: Floats, places: Floats) -> Floats:
    """Where does one attained path cross the planes at `places` (plane,) along the commanded one? (plane, k), straight from reading to reading.

    way       (reading,) how far along the commanded path each reading stands; where it steps back, by noise, readings are taken in order of way
    readings  (reading, k) what was read there
    """
    order = np.argsort(way, kind="stable")
    return np.stack([np.interp(places, way[order], column[order]) for column in readings.T], axis=-1)
