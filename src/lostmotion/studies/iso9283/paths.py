"""How well is a straight path followed? AT and RT by ISO 9283:1998, 8.2 and 8.3: one definition, for robots predicted and measured alike.

The standard cuts the attained paths by planes across the commanded one, and looks at the points of one plane together. Errors (..., cycle, 6) at one
plane: rotation vector from the commanded orientation, rad, and shift from the commanded point, in one unit; base axes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.studies.iso9283 import characteristics as iso

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# What is told of a path, in the order of every array here; the standard gives accuracy and repeatability of its orientation about each axis.
PATH_FIGURES: Final = ("AT_p", "RT_p", "AT_a", "AT_b", "AT_c", "RT_a", "RT_b", "RT_c")
_DIRECTION: Final = 3


def across_path(errors: Floats, along: Floats) -> Floats:
    """Which part of errors (..., 3) lies in the plane across a path's direction (3,)? There the standard looks at paths."""
    along = np.asarray(along) / np.linalg.norm(along)
    return np.asarray(errors - (errors * along).sum(axis=-1, keepdims=True) * along)


def at_plane(errors: Floats, along: Floats) -> Floats:
    """What do the cycles' errors (..., cycle, 6) say at one plane across the direction `along` (3,)? `PATH_FIGURES` there (8, ...), none signed.

    AT_p: length of the average across the path; RT_p: mean + 3 s of the distances from it; AT_a, b, c: size of the average turn; RT_a, b, c: 3 s.
    s has n - 1 below the fraction; the standard asks for n = 10. Raises ValueError for fewer than two cycles.
    """
    across, turn = across_path(errors[..., 3:], along), errors[..., :3]
    lengths = iso.pose_accuracy(across, np.zeros(3)), iso.pose_repeatability(across)
    turns = np.abs(iso.axis_accuracy(turn)), iso.axis_repeatability(turn)
    return np.stack([*lengths, *(np.moveaxis(each, -1, 0)[k] for each in turns for k in range(_DIRECTION))])


def along_path(errors: Floats, along: Floats) -> Floats:
    """What does the path say whose planes hold errors (plane, ..., cycle, 6)? `PATH_FIGURES` (8, ...) at the worst plane for each."""
    return np.asarray(np.stack([at_plane(each, along) for each in errors]).max(axis=0))


def crossings(way: Floats, readings: Floats, places: Floats) -> Floats:
    """Where does one attained path cross the planes at `places` (plane,) along the commanded one? (plane, k), straight from reading to reading.

    way       (reading,) how far along the commanded path each reading stands; where it steps back, by noise, readings are taken in order of way
    readings  (reading, k) what was read there
    """
    order = np.argsort(way, kind="stable")
    return np.stack([np.interp(places, way[order], column[order]) for column in readings.T], axis=-1)
