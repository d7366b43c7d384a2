"""How an elementary error moves the tool of a loaded arm whose loads it changes.

An error displaces places, with them the weights, and turns places under their loads. So the loads
change, the springs follow, and that changes the loads again. With deflections e = d(e) + x and an
error x, de = (1 - D)^-1 x, where D is the change of the deflections per deflection: C dw/de, and
what gravity in the axes of a link does. The share of the stiffness that the load takes away
lengthens a droop by a tenth, and the error of an encoder with it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.mechanism.load_gradient import Freedom, load_gradient
from lostmotion.parts.forms import Linear
from lostmotion.spatial import cross, right_jacobian

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.mechanism.state import State
    from lostmotion.spatial import Floats

# Poses whose matrices are in memory at a time.
_BLOCK: Final = 256


def tool_twists(state: State, place: NDArray[np.int64], local: Floats) -> Floats:
    """Return the tool's twists (6, term, pose), rad and m, about the tool point in the base's axes,
    for errors `local` (6, term, pose) of an arm in its equilibrium, to first order in them.

    place  (term,) index of the place at which each error acts
    local  (6, term, pose) rad and m, which add to the deflection of the place

    The loads follow the errors, and the deflections the loads; plays stay open or closed, and held
    clearances keep their direction. Valid where the arm stands (`State.settled`).
    """
    places, out = np.unique(place), np.zeros_like(local)
    for start in range(0, len(state), _BLOCK):
        rows = slice(start, start + _BLOCK)
        for number, matrix in zip(places, _carries(state.rows(rows), places), strict=True):
            own = np.flatnonzero(place == number)
            carried = np.zeros((6, len(own), matrix.shape[1]))
            for j in range(6):  # in one order for any number of poses
                carried += matrix[:, None, :, j] * local[j, own, rows]
            out[:, own, rows] = carried
    return out


def tangent(state: State, freedoms: Sequence[Freedom]) -> tuple[Floats, Floats]:
    """Return the change of the deflections of these freedoms per displacement of each of them
    (pose, freedom, freedom), and their compliances (pose, freedom). The largest eigenvalue is the
    share of the stiffness that the loads take away.
    """
    springs = _springs(state)
    at = [springs.places.index(each.place) for each in freedoms]
    components = [each.component for each in freedoms]
    change = _changes(state, springs, freedoms)
    return (
        change[:, [6 * n + j for n, j in zip(at, components, strict=True)]],
        springs.whole[at, :, components, components].T,
    )


def _carries(state: State, places: NDArray[np.int64]) -> list[Floats]:
    """Return the twist of the tool per error at each of these places: (6, pose, 6) each."""
    springs = _springs(state)
    acting = np.array(springs.places, dtype=int)
    every = np.union1d(acting, places)
    found = state.equilibrium
    twists = np.zeros((*state.frames.shape[:2], 6)) if found is None else found.twists
    freedoms = [Freedom(k, j) for k in every.tolist() for j in range(6)]
    change = _changes(state, springs, freedoms)  # (pose, row, column)
    rows = change.shape[1]
    to_tool = {}
    for n, k in enumerate(every.tolist()):
        # what is added to a deflection, in the axes of the deflected place
        local = right_jacobian(twists[k])
        columns = slice(6 * n, 6 * n + 6)
        change[:, :, columns] = np.ascontiguousarray(change[:, :, columns]) @ local
        to_tool[k] = np.ascontiguousarray(state.carry(k)) @ local
    if not rows:
        return [to_tool[k].transpose(1, 0, 2) for k in places.tolist()]
    own = np.concatenate([6 * n + np.arange(6) for n in np.searchsorted(every, acting)])
    tangent = np.eye(rows) - change[:, :, own]
    carried = np.concatenate([to_tool[k] for k in acting.tolist()], axis=2)
    response = np.linalg.solve(tangent.transpose(0, 2, 1), carried.transpose(0, 2, 1))
    response = np.ascontiguousarray(response.transpose(0, 2, 1))
    out = []
    for n in np.searchsorted(every, places).tolist():
        block = np.ascontiguousarray(change[:, :, 6 * n : 6 * n + 6])
        out.append((to_tool[int(every[n])] + response @ block).transpose(1, 0, 2))
    return out


class _LoadedPlaces(NamedTuple):
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


def _springs(state: State) -> _LoadedPlaces:
    count = len(state.frames)
    whole, weights = np.zeros((2, count, len(state), 6, 6))
    own_weight, conditions = np.zeros((count, 6, 3)), state.conditions()
    acting = set()
    for placed in (each for each in state.arm.terms if each.term.level == "design"):
        form, k = placed.term.form, placed.place
        if not {"wrench", "weight", "gravity"}.isdisjoint(form.reads) and not form.jumps:
            own = placed.term.scale * form.compliance(conditions(placed))
            whole[k] += own
            if "weight" in form.reads:
                weights[k] += own
            if isinstance(form, Linear) and form.own_weight is not None:
                own_weight[k] += placed.term.scale * form.own_weight
            acting.add(k)
    places = tuple(sorted(acting))
    return _LoadedPlaces(places, *(each[list(places)] for each in (whole, weights, own_weight)))


def _changes(state: State, springs: _LoadedPlaces, freedoms: Sequence[Freedom]) -> Floats:
    """Return the change of the deflections of the springs per displacement of each freedom (pose, 6
    spring places, freedom), rad and m per rad and m.
    """
    arm, at, gravity = state.arm, state.frames, state.gravity
    rows = list(springs.places)
    wrenches = load_gradient(arm.tree, at, arm.payload, gravity, freedoms)[rows]
    out = springs.whole @ wrenches
    payload = arm.payload
    if springs.weights.any() and (any(payload.force) or any(payload.moment)):
        process = load_gradient(arm.tree, at, payload, np.zeros(3), freedoms)[rows]
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
