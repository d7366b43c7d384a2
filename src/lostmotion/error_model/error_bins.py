"""Bins of the histogram over all errors: 128 per factor of two of the squared error."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Histogram over the squared error in m^2: 128 bins per factor of two, from 2^-64 (0.2 nm) to 2^8
# (16 m).
_LOWEST_EXPONENT: Final = -64
_HIGHEST_EXPONENT: Final = 8
MANTISSA_BITS: Final = 7
BINS: Final = (_HIGHEST_EXPONENT - _LOWEST_EXPONENT) << MANTISSA_BITS
# Rows are padded: rows of BINS alone would begin at the same offset in every memory page and evict
# each other from the first-level cache.
ROW_OF_BINS: Final = BINS + 24
SHIFT: Final = 52 - MANTISSA_BITS
FIRST_BIN: Final = (1023 + _LOWEST_EXPONENT) << MANTISSA_BITS
BASE_BITS: Final = FIRST_BIN << SHIFT


def bin_edges() -> Floats:
    """Return the edges (BINS + 1,) of the histogram's bins, in metres of error, in rising order."""
    bits = (np.arange(BINS + 1, dtype=np.int64) << SHIFT) + BASE_BITS
    return np.sqrt(bits.view(np.float64))
