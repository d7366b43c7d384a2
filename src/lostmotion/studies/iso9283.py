"""ISO 9283:1998 by its definitions: pose accuracy AP and pose repeatability RP of positions, predicted or measured; never 'certified'."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


def pose_accuracy(attained: Floats, command: Floats) -> Floats:
    """How far is the barycentre of the attained positions (..., visit, 3) from the commanded one (..., 3)? AP_p (...,), in their unit (7.2.1)."""
    return np.asarray(np.linalg.norm(np.mean(attained, axis=-2) - command, axis=-1))


def pose_repeatability(attained: Floats) -> Floats:
    """How far do the attained positions (..., visit, 3) scatter about their barycentre? RP_l = mean + 3 s of the distances (...,) (7.2.2).

    s has n - 1 below the fraction; the standard asks for n = 30. A sample value: at n = 30 it is 2 % low on the average for a round normal
    scatter, and varies by 9 % from one set of visits to the next. Raises ValueError for fewer than two visits.
    """
    attained = np.asarray(attained, dtype=float)
    if attained.shape[-2] < 2:  # noqa: PLR2004 - a scatter needs two
        raise ValueError(f"{attained.shape[-2]} visit; repeatability needs at least 2")
    distance = np.linalg.norm(attained - attained.mean(axis=-2, keepdims=True), axis=-1)
    return np.asarray(distance.mean(axis=-1) + 3 * distance.std(axis=-1, ddof=1))
