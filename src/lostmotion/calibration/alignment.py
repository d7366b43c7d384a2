"""The frame of an instrument, before any error is estimated: measured positions in the base frame,
and signs of an arm, a tool or a file that do not belong together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.laws.frame_fit import rigid
from lostmotion.spatial import inverse

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

_STEPS: Final = 200
_SETTLED: Final = 1e-12
# Fewest positions by which a tool offset is distinguished from the frame.
_FEWEST: Final = 6


class Alignment(NamedTuple):
    """A rigid motion and a tool offset that bring nominal onto measured positions.

    frame   (4, 4) base frame in the frame of the instrument, m
    offset  (3,) shift of the tool point in the tool's axes, m
    left    mean distance that remains, m
    """

    frame: Floats
    offset: Floats
    left: float

    @property
    def turn(self) -> float:
        """Return the angle of the frame, rad."""
        return float(np.arccos(np.clip((np.trace(self.frame[:3, :3]) - 1) / 2, -1.0, 1.0)))

    @property
    def shift(self) -> float:
        """Return the shift of the frame, m."""
        return float(np.linalg.norm(self.frame[:3, 3]))


def align(frames: Floats, measured: Floats, *, with_tool: bool = True) -> Alignment:
    """Return the rigid motion, and the tool offset where asked for, from nominal frames of the tool
    (pose, 4, 4) to measured positions (pose, 3), by turns.
    """
    offset = np.zeros(3)
    frame = rigid(measured, frames[:, :3, 3])
    steps = _STEPS if with_tool and len(frames) >= _FEWEST else 0
    for _ in range(steps):
        moved = frame @ frames
        wanted = np.einsum("pji,pj->pi", moved[:, :3, :3], measured - moved[:, :3, 3])
        before, offset = offset, wanted.mean(axis=0)
        frame = rigid(measured, frames[:, :3, 3] + frames[:, :3, :3] @ offset)
        if np.abs(offset - before).max() < _SETTLED:
            break
    moved = frame @ frames
    left = measured - moved[:, :3, 3] - moved[:, :3, :3] @ offset
    return Alignment(frame, offset, float(np.linalg.norm(left, axis=1).mean()))


def in_base(frame: Floats, points: Floats) -> Floats:
    """Return positions (pose, 3) of the instrument's frame in the base frame (4, 4)."""
    back = inverse(frame)
    return np.asarray(points @ back[:3, :3].T + back[:3, 3])
