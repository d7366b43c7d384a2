"""How much of the expected error a compensated command leaves, by the model itself at the corrected
command.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, NamedTuple

import numpy as np

from lostmotion.controller_model.prediction import frames

if TYPE_CHECKING:
    from lostmotion.controller_model.controller import Controller, Prediction
    from lostmotion.spatial import Floats

# Poses whose position Jacobian has a smaller singular value (m) are near singular ones.
REGULAR: Final = 0.1


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
    """Return the share of the error (pose,) that remains, and the smallest singular value of the
    position Jacobian, m.

    Joints stand at the corrected command with the deflection that belongs to it, and so does
    everything else. NaN where there is no error.
    """
    found = model.compensate(q, passes=passes)
    start = found.prediction
    points = _points(model, np.asarray(q, dtype=float), start), reached(model, found.command)
    before, after = (np.linalg.norm(each - start.point, axis=1) for each in points)
    share: Floats = np.divide(after, before, out=np.full(len(before), np.nan), where=before > 0)
    return share, np.asarray(
        np.linalg.svd(start.jacobian[:, 3:], compute_uv=False)[:, -1], dtype=float
    )


def reached(model: Controller, command: Floats) -> Floats:
    """Return the tool points (pose, 3), m, that the model expects at a command (pose, joint):
    joints with their deflection, then the rest.
    """
    return _points(model, command, model.predict(command))


def _points(model: Controller, command: Floats, found: Prediction) -> Floats:
    """Return the tool points at a command from the prediction there."""
    _, points = frames(model.tables, command + found.joints)
    return np.asarray(points[-1] + found.elsewhere[:, 3:])
