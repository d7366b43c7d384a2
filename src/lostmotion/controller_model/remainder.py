"""How much of the expected error a compensated command leaves where the arm stands in
equilibrium.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, NamedTuple

import numpy as np

from lostmotion.controller_model.compensation import REGULAR
from lostmotion.controller_model.standing import standing

if TYPE_CHECKING:
    from lostmotion.controller_model.controller import Controller
    from lostmotion.spatial import Floats

# Rounds of the iteration to the equilibrium, whose error shrinks by the wind-up in radians each.
_ROUNDS: Final = 12


class Remainder(NamedTuple):
    """Share of the length of the expected error that remains at so many regular poses with an
    error; fractions, zero without such poses.
    """

    poses: int
    median: float
    percentile95: float
    worst: float


def remainder(model: Controller, q: Floats, passes: Literal[1, 2]) -> Remainder:
    """Return what compensation of the position leaves at poses (pose, joint), with the payload of
    the arm.
    """
    share, singular = shares_left(model, q, passes)
    share = share[(singular > REGULAR) & np.isfinite(share)]
    if not len(share):
        return Remainder(0, 0.0, 0.0, 0.0)
    return Remainder(
        len(share), float(np.median(share)), float(np.quantile(share, 0.95)), float(share.max())
    )


def shares_left(model: Controller, q: Floats, passes: Literal[1, 2] = 1) -> tuple[Floats, Floats]:
    """Return the share of the error (pose,) that remains where the arm then stands, and the
    smallest singular value of the position Jacobian, m. NaN where there is no error.
    """
    found = model.compensate(q, passes=passes)
    before, after = (
        np.linalg.norm(reached(model, each) - found.prediction.point, axis=1)
        for each in (np.asarray(q, dtype=float), found.command)
    )
    share: Floats = np.divide(after, before, out=np.full(len(before), np.nan), where=before > 0)
    return share, np.asarray(
        np.linalg.svd(found.prediction.jacobian[:, 3:], compute_uv=False)[:, -1], dtype=float
    )


def reached(model: Controller, command: Floats) -> Floats:
    """Return the tool points (pose, 3), m, where the arm stands in equilibrium with its own payload
    at a command (pose, joint).
    """
    tables, count = model.tables, len(command)
    load, gravity = (
        np.broadcast_to(each, (count, each.size)) for each in (tables.load, tables.gravity)
    )
    twists, side = np.zeros((len(tables.records), count, 6)), np.zeros_like(command)
    for _ in range(_ROUNDS):
        stands = standing(tables, command, load, gravity, side, twists)
        twists = stands.twists
    return stands.point
