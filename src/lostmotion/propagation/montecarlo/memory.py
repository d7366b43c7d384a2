"""Reuse of freed memory by the C library from one block of poses to the next."""

from __future__ import annotations

from typing import Final

import numpy as np

# glibc keeps freed memory of up to twice the size of the largest array freed so far. It returns the
# rest to the system, and then requests it again for the next block, page by page, which takes from
# a fifth to half of the time of a block.
_KEPT_BYTES: Final = 16 * 2**20


def keep_freed() -> None:
    """Make glibc keep a block's freed memory for the next block, by freeing one large untouched
    array. No effect with other C libraries.
    """
    np.empty(_KEPT_BYTES, np.uint8)
