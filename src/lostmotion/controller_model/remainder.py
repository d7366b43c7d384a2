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


def remainder(
    model: Controller,
    arm: Arm,
    q: Floats,
    passes: Literal[1, 2],
    uncompensated: Floats | None = None,
) -> Remainder:
    """Return what compensation of the position leaves at poses (pose, joint), with the payload of
    the arm.

    uncompensated  `reached` at these poses, where it is known
    """
    share, singular = shares_left(model, arm, q, passes, uncompensated)
    share = share[(singular > REGULAR) & np.isfinite(share)]
    if not len(share):
        return Remainder(0, 0.0, 0.0, 0.0)
    return Remainder(
        len(share), float(np.median(share)), float(np.quantile(share, 0.95)), float(share.max())
    )


def shares_left(
    model: Controller,
    arm: Arm,
    q: Floats,
    passes: Literal[1, 2] = 1,
    uncompensated: Floats | None = None,
) -> tuple[Floats, Floats]:
    """Return the share of the error (pose,) that remains where the arm then stands, and the
    smallest singular value of the position Jacobian, m. NaN where there is no error or no
    equilibrium. Arguments as `remainder`.
    """
    found = model.compensate(q, passes=passes)
    if uncompensated is None:
        uncompensated = reached(arm, np.asarray(q, dtype=float))
    before, after = (
        np.linalg.norm(stands - found.prediction.point, axis=1)
        for stands in (uncompensated, reached(arm, found.command))
    )
    share: Floats = np.divide(after, before, out=np.full(len(before), np.nan), where=before > 0)
    return share, np.asarray(
        np.linalg.svd(found.prediction.jacobian[:, 3:], compute_uv=False)[:, -1], dtype=float
    )


def reached(arm: Arm, command: Floats) -> Floats:
    """Return the tool points (pose, 3), m, where the arm stands under its own loads at a command
    (pose, joint); NaN where its springs cannot hold them.
    """
    return np.asarray(state_of(arm, command).settled().frames[-1, :, :3, 3])
