"""Forward kinematics: the frame of each place from that of its parent."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.spatial import combined, inverse, motion

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# Poses evaluated at a time, so that their coordinates fit into the processor's cache.
_BLOCK: Final = 8192


def place_frames(tree: Tree, q: Floats, passive: Mapping[int, Floats] | None = None) -> Floats:
    """Return the poses of all places (place, pose, 4, 4) in the base's frame, m, for joint values q
    (pose, joint), rad or m.

    passive  motion (pose, 4, 4) of each place that a passive joint moves

    Source: product of exponentials, K. Lynch, F. Park, Modern Robotics, 2017, ch. 4.
    """
    # poses are the innermost axis in memory, along which all steps run
    out = np.empty((len(tree.places), 4, 4, len(q)))
    out[0] = np.eye(4)[..., None]
    out[1:, 3] = out[0, 3]
    rows = out[:, :3]
    for k, place in enumerate(tree.places[1:], start=1):
        step = (
            place.pose.tolist()
            if place.joint is None
            else motion(place.twist[:, 0], q[:, place.joint])
        )
        if passive and k in passive:
            step = passive[k].transpose(1, 2, 0)
        combined(rows[place.parent], step, out=rows[k])
    return out.transpose(0, 3, 1, 2)


def tool_point(tree: Tree, q: Floats) -> Floats:
    """Return the tool point (pose, 3), m, in the base's frame. Equal to the last of `place_frames`,
    in a fraction of its time.
    """
    out = np.empty((len(q), 3))
    for first in range(0, len(q), _BLOCK):
        here = slice(first, first + _BLOCK)
        out[here, 0], out[here, 1], out[here, 2] = _tool_point(tree, q[here])
    return out


def _tool_point(tree: Tree, q: Floats) -> list[Floats]:
    """Return x, y and z (pose,) of the tool point, place by place from the tool to the base.
    Rotations by Rodrigues' formula.
    """
    point: list[Floats] = [np.zeros(len(q))] * 3
    for number in reversed(tree.tool_path[1:]):
        place = tree.places[number]
        if place.joint is None:
            point = [_weighted(row, (*point, 1.0)) for row in place.pose[:3].tolist()]
            continue
        value, axis = q[:, place.joint], place.twist[:3, 0].tolist()
        if any(axis):
            cos, sin = np.cos(value), np.sin(value)
            along = (1 - cos) * _weighted(axis, point)
            turned = []
            for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                across = sin * _weighted((axis[j], -axis[k]), (point[k], point[j]))
                turns = float(bool(axis[j] or axis[k]))
                turned.append(_weighted((1.0, turns, axis[i]), (cos * point[i], across, along)))
            point = turned
        else:
            slide = place.twist[3:, 0].tolist()
            point = [_weighted((1.0, way), (p, value)) for p, way in zip(point, slide, strict=True)]
    return point


def _weighted(weights: Sequence[float], parts: Sequence[Floats | float]) -> Floats:
    """Return the sum of parts times weights, in order. Most weights are 0 or 1: no products."""
    out: Floats | float = 0.0
    for weight, part in zip(weights, parts, strict=True):
        if weight:
            term = part if weight == 1 else weight * part
            out = term if isinstance(out, float) else out + term
    return np.asarray(out)


def steps_between(at: Floats) -> Floats:
    """Return the pose of each frame relative to the previous one (place, pose, 4, 4), m; of the
    first one relative to the base.
    """
    out = at.copy()
    out[1:] = inverse(at[:-1]) @ at[1:]
    return out
