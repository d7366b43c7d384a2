"""Which number of its table a stream reads for one visit of one robot to one pose. Counter-based, so that any tiling reads the same numbers."""

from __future__ import annotations

from typing import Final

import numpy as np

from lostmotion.compiled import compiled

LANES: Final = 128
TABLE: Final = 8192
ROW: Final = TABLE + LANES  # a table, and its beginning again to continue into


@compiled
def mix(x):
    """Scatter the bits of a counter (the finaliser of SplitMix64; G. Steele et al., OOPSLA 2014)."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@compiled
def place_in_table(pose, tile, visit, key):
    """Return the position in its table from which the stream with this key is read, for one visit of one tile of robots to one pose."""
    here = np.uint64(pose) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(tile) * np.uint64(0xD1B54A32D192ED03)
    return np.int64(mix((here + np.uint64(visit) * np.uint64(0xABC98388FB8FAC03)) ^ key) >> np.uint64(51))
