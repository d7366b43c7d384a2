"""How an elementary error moves the tool of a loaded arm whose loads it changes.

An error displaces places, with them the weights, and turns places under their loads. So the loads
change, the springs follow, and that changes the loads again. With deflections e = d(e) + x and an
error x, de = (1 - D)^-1 x, where D is the change of the deflections per deflection: C dw/de, and
what gravity in the axes of a link does. The share of the stiffness that the load takes away
lengthens a droop by a tenth, and the error of an encoder with it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.load_changes import changes, loaded_places
from lostmotion.mechanism.load_gradient import Freedom
from lostmotion.mechanism.standing import bytes_of
from lostmotion.recent import Recent
from lostmotion.spatial import right_jacobian

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.state import State
    from lostmotion.spatial import Floats

# Poses whose matrices are in memory at a time.
_BLOCK: Final = 256


# States with their matrices that a study keeps: it asks twice, for each way to arrive.
_RECENT: Final = Recent["tuple[State, list[Floats]]"](
    160 << 20, lambda kept: bytes_of(kept[0]) + sum(matrix.nbytes for matrix in kept[1])
)


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
        for number, matrix in zip(places, _kept(state, rows, places), strict=True):
            own = np.flatnonzero(place == number)
            carried = np.zeros((6, len(own), matrix.shape[1]))
            for j in range(6):  # in one order for any number of poses
                carried += matrix[:, None, :, j] * local[j, own, rows]
            out[:, own, rows] = carried
    return out


def _kept(state: State, rows: slice, places: NDArray[np.int64]) -> list[Floats]:
    """Return `_carries` at the poses in these rows."""
    key = id(state), rows.start, places.tobytes()
    return _RECENT.of(key, lambda: (state, _carries(state.rows(rows), places)))[1]


def forget_carries() -> None:
    """Keep no matrix, in a run that visits each pose once."""
    _RECENT.clear()


def _carries(state: State, places: NDArray[np.int64]) -> list[Floats]:
    """Return the twist of the tool per error at each of these places: (6, pose, 6) each."""
    springs = loaded_places(state, state.conditions())
    acting = np.array(springs.places, dtype=int)
    every = np.union1d(acting, places)
    found = state.equilibrium
    twists = np.zeros((*state.frames.shape[:2], 6)) if found is None else found.twists
    freedoms = [Freedom(k, j) for k in every.tolist() for j in range(6)]
    change = changes(state, springs, freedoms)  # (pose, row, column)
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
