"""Where an arm stands under load: the loads act on the deflected arm, not at the command."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lostmotion.controller_model.prediction import (
    expected_twist,
    factors_of,
    frames,
    process_wrenches,
    wrenches,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.controller_model.tables import Tables
    from lostmotion.spatial import Floats


class Standing(NamedTuple):
    """The arm under load.

    turn, point  rotation (pose, 3, 3) and point (pose, 3) of the tool, m
    twists       (place, pose, 6) of the places in their own axes
    beyond       (pose,) whether a load is beyond a table of displacements
    """

    turn: Floats
    point: Floats
    twists: Floats
    beyond: NDArray[np.bool_]


def standing(
    tables: Tables, q: Floats, load: Floats, gravity: Floats, side: Floats, twists: Floats
) -> Standing:
    """Return the arm at a command q (pose, joint) under the loads that act where it stands with
    these twists (place, pose, 6): one step of the iteration to its equilibrium.
    """
    turns, points = frames(tables, q, twists)
    carried = wrenches(tables, turns, points, load, gravity)
    process = process_wrenches(tables, turns, points, load)
    out, beyond = np.zeros_like(twists), np.zeros(len(q), dtype=bool)
    none = np.zeros(len(q))
    for k, record in enumerate(tables.records):
        if not record.carries_tool:
            continue
        moves = record.joint >= 0
        value, last = (q[:, record.joint], side[:, record.joint]) if moves else (none, none)
        factors = factors_of(record, value, carried[k], process[k])
        fall = np.einsum("pij,pi->pj", turns[k], gravity)
        out[k] = expected_twist(record, factors.values, last, carried[k], fall)
        beyond |= factors.beyond
    turns, points = frames(tables, q, out)
    return Standing(turns[-1], points[-1], out, beyond)
