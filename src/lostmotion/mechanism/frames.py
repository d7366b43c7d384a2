"""Frames of the places: one step from each parent."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.spatial import combined, inverse, motion

if TYPE_CHECKING:
    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats


def place_frames(tree: Tree, q: Floats) -> Floats:
    """Return the poses of all places (place, pose, 4, 4) in the base's frame, m, for joint values q (pose, joint), rad or m.

    Source: product of exponentials, K. Lynch, F. Park, Modern Robotics, 2017, ch. 4.
    """
    out = np.empty((len(tree.places), 4, 4, len(q)))  # poses lie innermost in memory: all steps run along them
    out[0] = np.eye(4)[..., None]
    out[1:, 3] = out[0, 3]
    rows = out[:, :3]
    for k, place in enumerate(tree.places[1:], start=1):
        step = place.pose.tolist() if place.joint is None else motion(place.twist, q[:, place.joint])
        combined(rows[place.parent], step, out=rows[k])
    return out.transpose(0, 3, 1, 2)


def tool_point(tree: Tree, q: Floats) -> Floats:
    """Return the tool point (pose, 3), m, in the base's frame: that of `place_frames` in a tenth of the time."""
    point = np.zeros((len(q), 3))
    for number in reversed(tree.way[1:]):
        place = tree.places[number]
        if place.joint is None:
            point = point @ place.pose[:3, :3].T + place.pose[:3, 3]
        elif place.twist[:3].any():
            angle, turning = q[:, place.joint, None], place.twist[:3]
            along = np.outer(point @ turning, turning)
            point = along + np.cos(angle) * (point - along) + np.sin(angle) * np.cross(turning, point)
        else:
            point = point + q[:, place.joint, None] * place.twist[3:]
    return point


def steps_between(at: Floats) -> Floats:
    """Return the pose that leads from each frame to the next (place, pose, 4, 4), the first one from the base."""
    out = at.copy()
    out[1:] = inverse(at[:-1]) @ at[1:]
    return out
