"""Position in a stream's table that is read for one visit of one robot to one pose. It follows from
counters, so it is the same for any tiling.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lostmotion.compiled import compiled

LANES: Final = 128
TABLE: Final = 8192
# a table and its first LANES values again, so that LANES values can be read from any position
ROW: Final = TABLE + LANES


@compiled
def mix(x):
    """Return the mixed bits of a 64-bit counter (the finaliser of SplitMix64; G. Steele et al.,
    OOPSLA 2014).
    """
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@compiled
def place_in_table(pose, tile, visit, key):
    """Return the position, 0 to TABLE - 1, from which the stream with this key reads its table for
    one visit of one tile of robots to one pose.
    """
    here = np.uint64(pose) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(tile) * np.uint64(
        0xD1B54A32D192ED03
    )
    return np.int64(
        mix((here + np.uint64(visit) * np.uint64(0xABC98388FB8FAC03)) ^ key) >> np.uint64(51)
    )
