"""How joints arrive at a pose. A repeatability RP depends on it, so that its name always states it.

ISO 9283 visits every pose from the same direction, 30 times: each joint arrives from one side, and
backlash and hysteresis add a constant. Where joints arrive from either side at random, backlash
that no load closes and hysteresis count as well.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

ISO_CYCLE: Final = "ISO cycle"
ANY_APPROACH: Final = "any approach"
# A joint that moves by less than this (rad, m) between two poses is at rest.
STILL: Final = 1e-7


def arrival(approach: float) -> str:
    """Return how joints arrive: `approach` is the sign of their last motion, 0 where it is drawn at
    every visit.
    """
    return ISO_CYCLE if approach else ANY_APPROACH


def arriving(approach: float) -> str:
    """Return the side from which joints arrive, as it follows "joints arrive"; `approach` as in
    `arrival`.
    """
    if approach == 0:
        return "from either side at random"
    return "moving up" if approach > 0 else "moving down"


def rp_name(approach: float) -> str:
    """Return the name of the repeatability of joints that arrive this way ("RP, ISO cycle");
    `approach` as in `arrival`.
    """
    return f"RP, {arrival(approach)}"


def rp_key(approach: float) -> str:
    """Return the key of the repeatability of joints that arrive this way ("rp_iso", "rp_any");
    `approach` as in `arrival`.
    """
    return "rp_iso" if approach else "rp_any"


def last_motion(
    q: Floats, stated: Floats | None = None, before: Floats | None = None
) -> tuple[Floats, NDArray[np.int64]]:
    """Return the sign of each joint's last motion on arrival at the rows of a path (row, joint),
    and the row at which each joint took the side on which it rests there (row, joint).

    q       (row, joint) joint values in the order of the visits, rad or m; joints move
            monotonically from row to row
    stated  (row, joint) signs that replace those of the path, 0 for a side drawn at random; NaN
            where the path decides. None: the path decides everywhere
    before  (joint,) sign before the first row; None: 0, drawn at random

    A joint that does not move between two rows keeps its side: the sign is 0 until its first
    motion. Motions are assumed to traverse the play.
    """
    steps = np.diff(q, axis=0)
    signs = np.where(np.abs(steps) < STILL, np.nan, np.sign(steps))
    first = np.zeros(q.shape[1]) if before is None else before
    signs = np.vstack([first, signs])
    if stated is not None:
        signs = np.where(np.isnan(stated), signs, stated)
    rows = np.where(np.isnan(signs), 0, np.arange(len(q))[:, None])
    since = np.maximum.accumulate(rows, axis=0)
    return np.take_along_axis(signs, since, axis=0), since


def undescribed_scatter(arm: Arm) -> tuple[str, ...]:
    """Return the names of the moving joints that describe neither a dead band nor a scatter of
    friction, from which one-sided RP comes.
    """
    return tuple(joint.name for joint in arm.driven if not _describes_scatter(joint))


def _describes_scatter(joint: object) -> bool:
    servo, gearbox, lumped = (getattr(joint, name, None) for name in ("servo", "gearbox", "lumped"))
    scatters = gearbox is not None and "hysteresis_scatter" in gearbox.model_fields_set
    return scatters or lumped is not None or (servo is not None and servo.dead_band is not None)
