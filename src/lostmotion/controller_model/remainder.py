"""How much of the expected error a compensated command leaves where the arm stands in equilibrium,
by the mechanism and its parts: the tables of the controller have no share in it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from lostmotion.controller_model.compensation import REGULAR
from lostmotion.mechanism.state import state_of

if TYPE_CHECKING:
    from lostmotion.controller_model.controller import Controller
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


class Remainder(NamedTuple):
    """Share of the length of the expected error that remains at so many regular poses with an
    error; fractions, zero without such poses.
    """

    poses: int
    median: float
    percentile95: float
    worst: float


def remainders(model: Controller, arm: Arm, q: Floats) -> tuple[Remainder, Remainder]:
    """Return what compensation of the position in one pass and in two leaves at poses (pose,
    joint), with the payload of the arm.
    """
    uncompensated = reached(arm, q)
    return _remainder(model, arm, q, uncompensated, 1), _remainder(model, arm, q, uncompensated, 2)


def _remainder(
    model: Controller, arm: Arm, q: Floats, uncompensated: Floats, passes: Literal[1, 2]
) -> Remainder:
    found = model.compensate(q, passes=passes)
    before, after = (
        np.linalg.norm(stands - found.prediction.point, axis=1)
        for stands in (uncompensated, reached(arm, found.command))
    )
    # NaN where there is no error or no equilibrium
    share = np.divide(after, before, out=np.full(len(before), np.nan), where=before > 0)
    singular = np.linalg.svd(found.prediction.jacobian[:, 3:], compute_uv=False)[:, -1]
    share = share[(singular > REGULAR) & np.isfinite(share)]
    if not len(share):
        return Remainder(0, 0.0, 0.0, 0.0)
    return Remainder(
        len(share), float(np.median(share)), float(np.quantile(share, 0.95)), float(share.max())
    )


def reached(arm: Arm, command: Floats) -> Floats:
    """Return the tool points (pose, 3), m, where the arm stands under its own loads at a command
    (pose, joint); NaN where its springs cannot hold them.
    """
    return np.asarray(state_of(arm, command).settled().frames[-1, :, :3, 3])
