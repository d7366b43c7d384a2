"""How the deflections of the parts of an arm change where its places are displaced: the springs,
by the loads that the displacement changes, and links by gravity in their own axes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lostmotion.mechanism.load_gradient import load_gradient
from lostmotion.parts.forms import Linear
from lostmotion.parts.term import LOADS
from lostmotion.spatial import cross

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from lostmotion.mechanism.conditions import Conditions, Stands
    from lostmotion.mechanism.load_gradient import Freedom
    from lostmotion.spatial import Floats


def tangent(
    state: Stands, conditions: Conditions, freedoms: Sequence[Freedom]
) -> tuple[Floats, Floats]:
    """Return the change of the deflections of these freedoms per displacement of each of them
    (pose, freedom, freedom), and their compliances (pose, freedom). The largest eigenvalue is the
    share of the stiffness that the loads take away.
    """
    springs = loaded_places(state, conditions, {each.place for each in freedoms})
    at = [springs.places.index(each.place) for each in freedoms]
    components = [each.component for each in freedoms]
    change = changes(state, springs, freedoms)
    return (
        change[:, [6 * n + j for n, j in zip(at, components, strict=True)]],
        springs.whole[at, :, components, components].T,
    )


class LoadedPlaces(NamedTuple):
    """What deflects under load, at the places with such parts.

    places      their indices
    whole       (place, pose, 6, 6) compliance to weights, rad and m per N m and N
    weights     the part of it that the process force does not wind
    own_weight  (place, 6, 3) rad and m per m/s^2
    """

    places: tuple[int, ...]
    whole: Floats
    weights: Floats
    own_weight: Floats


def loaded_places(
    state: Stands, conditions: Conditions, among: Collection[int] | None = None
) -> LoadedPlaces:
    """Return what deflects under load in a state of these conditions, at all places or at those
    `among` them that the caller names.
    """
    count = len(state.frames)
    whole, weights = np.zeros((2, count, len(state), 6, 6))
    own_weight = np.zeros((count, 6, 3))
    acting = set()
    for placed in (each for each in state.arm.terms if each.term.level == "design"):
        form, k = placed.term.form, placed.place
        if among is not None and k not in among:
            continue
        if not LOADS.isdisjoint(form.reads) and not form.jumps:
            own = placed.term.scale * form.compliance(conditions(placed))
            whole[k] += own
            if "weight" in form.reads:
                weights[k] += own
            if isinstance(form, Linear) and form.own_weight is not None:
                own_weight[k] += placed.term.scale * form.own_weight
            acting.add(k)
    places = tuple(sorted(acting))
    return LoadedPlaces(places, *(each[list(places)] for each in (whole, weights, own_weight)))


def changes(state: Stands, springs: LoadedPlaces, freedoms: Sequence[Freedom]) -> Floats:
    """Return the change of the deflections of the springs per displacement of each freedom (pose, 6
    spring places, freedom), rad and m per rad and m.
    """
    arm, at, gravity = state.arm, state.frames, state.gravity
    rows = list(springs.places)
    wrenches = load_gradient(arm.tree, at, arm.payload, gravity, freedoms, rows)
    out = springs.whole @ wrenches
    payload = arm.payload
    if springs.weights.any() and (any(payload.force) or any(payload.moment)):
        process = load_gradient(arm.tree, at, payload, np.zeros(3), freedoms, rows)
        out -= springs.weights @ process
    for n, k in enumerate(rows):
        if not springs.own_weight[n].any():
            continue
        inboard = arm.tree.inboard(k)
        for j, (place, component) in enumerate(freedoms):
            if component < 3 and place in inboard:  # noqa: PLR2004 - a rotation
                falls = cross(at[place][:, :3, component], gravity[None])
                turned = np.einsum("pji,pj->pi", at[k][:, :3, :3], falls)
                out[n, :, :, j] -= np.einsum("ij,pj->pi", springs.own_weight[n], turned)
    return np.ascontiguousarray(
        out.transpose(1, 0, 2, 3).reshape(len(state), 6 * len(rows), len(freedoms))
    )
