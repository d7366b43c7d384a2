"""Positioning of one axis approached from two sides, by the definitions of ISO 230-2:2014, clause
3.

They apply to predicted and measured deviations, lengths or angles; they certify nothing. The
standard asks for at least five target positions along the axis, and five approaches to each from
either side.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Target positions, and approaches to each from a side, that the standard asks for.
POSITIONS: Final = 5
APPROACHES: Final = 5
_SIDES: Final = 2


def reversal(mean: Floats) -> Floats:
    """Return the reversal value B_i (position, ...) at each position: mean deviation (side,
    position, ...) from the first side less that from the second.
    """
    return np.asarray(mean[0] - mean[1])


def positioning(mean: Floats, deviation: Floats) -> dict[str, Floats]:
    """Return the figures of an axis by their symbols, each (...,): A, R, B, E and M; with "1" and
    "2" those of one direction, from the first and the second side.

    mean, deviation  (side, position, ...) mean deviation from the target position and standard
                     deviation, of n - 1, in one unit
    """
    spread = 2 * deviation
    back = reversal(mean)
    both = spread.sum(axis=0) + np.abs(back)
    out = {
        "A": (mean + spread).max(axis=(0, 1)) - (mean - spread).min(axis=(0, 1)),
        "R": np.maximum(both, 2 * spread.max(axis=0)).max(axis=0),
        "B": np.abs(back).max(axis=0),
        "mean B": back.mean(axis=0),
        "E": np.ptp(mean, axis=(0, 1)),
        "M": np.ptp(mean.mean(axis=0), axis=0),
    }
    for k in range(_SIDES):
        out |= {
            f"A{k + 1}": (mean[k] + spread[k]).max(axis=0) - (mean[k] - spread[k]).min(axis=0),
            f"R{k + 1}": 2 * spread[k].max(axis=0),
            f"E{k + 1}": np.ptp(mean[k], axis=0),
        }
    return {name: np.asarray(value) for name, value in out.items()}
