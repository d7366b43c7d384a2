"""How the C library deals with memory that is given back block after block."""

from __future__ import annotations

from typing import Final

import numpy as np

# The library goes by the largest array given back so far: it keeps freed memory up to twice its size for the next block, and hands back the rest
# only to ask for it again, page by page, which takes as long as a fifth of a block's work, or half.
_KEPT_BYTES: Final = 16 * 2**20


def keep_freed() -> None:
    """Have a block's memory kept for the next block: one array that is never touched does this. Elsewhere than with glibc it does nothing."""
    np.empty(_KEPT_BYTES, np.uint8)
