"""Lazy greedy selection of the best exchange (M. Minoux, Lecture Notes in Control and Information
Sciences 7 (1978) 234).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

# The number of the slot, and that of the candidate to install.
Swap = tuple[int, int]


class LazyGreedy:
    """Ranks of swaps from earlier steps: only swaps whose last known rank exceeds the best new rank
    are ranked again.
    """

    def __init__(self) -> None:
        """Begin without ranks."""
        self._ranks: dict[Swap, float] = {}
        self._phase = False

    def set_phase(self, phase: bool) -> None:  # noqa: FBT001 - one of two
        """Clear all ranks when the criterion changes."""
        if phase != self._phase:
            self._phase = phase
            self._ranks.clear()

    def best(self, swaps: list[Swap], rank: Callable[[Swap], float]) -> Swap | None:
        """Return the swap of the highest rank; None where all ranks are zero."""
        best, highest = None, 0.0
        for swap in sorted(swaps, key=lambda each: (-self._ranks.get(each, math.inf), each)):
            if best is not None and self._ranks.get(swap, math.inf) < highest:
                break
            self._ranks[swap] = rank(swap)
            if self._ranks[swap] > highest:
                best, highest = swap, self._ranks[swap]
        return best
