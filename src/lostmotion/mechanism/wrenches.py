"""Static wrenches on the places: one pass from the outermost place to the base."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.places import PlacedMass
from lostmotion.spatial import cross, out_of

if TYPE_CHECKING:
    from lostmotion.mechanism.places import Tree
    from lostmotion.mechanism.tool import Payload
    from lostmotion.spatial import Floats

_NONE: Final = (0.0, 0.0, 0.0)


def place_wrenches(tree: Tree, at: Floats, payload: Payload, gravity: Floats) -> Floats:
    """Return the static wrench on each place from everything outboard of it: (place, pose, 6) in
    the place's own frame, N m and N.

    at       (place, pose, 4, 4) frames of the places in the base's frame, m
    gravity  (3,) acceleration of free fall in the base's axes, m/s^2

    Each place carries the weights on it and the wrenches of its children. The process force and
    moment of the payload act on the tool, in its axes.
    """
    tool = len(at) - 1
    weights: dict[int, list[PlacedMass]] = {}
    for weight in (
        PlacedMass(tool, tool, payload.mass, np.array(payload.centre_of_mass)),
        *tree.masses,
    ):
        if weight.mass and gravity.any():
            weights.setdefault(weight.on, []).append(weight)
    force, moment = np.zeros((2, len(at), 3, at.shape[1])).transpose(0, 1, 3, 2)
    if not (weights or any(payload.force) or any(payload.moment)):  # an arm without any load
        return _about_places(at, force, moment)

    def apply(place: int, point: Floats, load: Floats) -> None:
        force[place] += load
        moment[place] += cross(point, load)

    for k in range(tool, -1, -1):
        for weight in weights.get(k, ()):
            apply(
                k,
                at[weight.at][:, :3, 3] + out_of(at[weight.at], weight.centre),
                weight.mass * gravity,
            )
        if k == tool and any(payload.force):
            apply(k, at[k][:, :3, 3], out_of(at[k], np.array(payload.force)))
        if k == tool and any(payload.moment):
            moment[k] += out_of(at[k], np.array(payload.moment))
        if k:
            parent = tree.places[k].parent
            force[parent] += force[k]
            moment[parent] += moment[k]
    return _about_places(at, force, moment)


def _about_places(at: Floats, forces: Floats, moments: Floats) -> Floats:
    """Return wrenches (place, pose, 6) about each place's origin, in its axes, for forces and
    moments about the base's origin, in its axes.
    """
    out = np.zeros((len(at), 6, at.shape[1])).transpose(0, 2, 1)
    for vector, local in (
        (moments - cross(at[:, :, :3, 3], forces), out[..., :3]),
        (forces, out[..., 3:]),
    ):
        for j in range(3):
            local[..., j] = sum(vector[..., i] * at[..., i, j] for i in range(3))
    return out


def weights_by_axis(tree: Tree, at: Floats, payload: Payload) -> Floats:
    """Return the wrenches of all weights per unit of gravity along each axis of the base (3, place,
    pose, 6), N m and N per m/s^2; arguments as `place_wrenches`.
    """
    weight_only = payload.model_copy(update={"force": _NONE, "moment": _NONE})
    return np.stack([place_wrenches(tree, at, weight_only, axis) for axis in np.eye(3)])


def process_wrenches(tree: Tree, at: Floats, payload: Payload) -> Floats:
    """Return the wrenches of the process force and moment alone (place, pose, 6), N m and N;
    arguments as `place_wrenches`.
    """
    return place_wrenches(tree, at, payload, np.zeros(3))
