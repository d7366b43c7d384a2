"""Which exchange is best? By what each was worth when it was last looked at, so that few are looked at again (M. Minoux, LNCIS 7 (1978) 234)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

# The slot of the part, and the candidate to come.
Swap = tuple[int, int]


class Stale:
    """What exchanges were worth when they were last looked at: those that are not among the best are rarely worth more a step later."""

    def __init__(self) -> None:
        """Begin with nothing looked at."""
        self._worth: dict[Swap, float] = {}
        self._phase = False

    def of_phase(self, phase: bool) -> None:  # noqa: FBT001 - one of two
        """Forget everything where the measure changes."""
        if phase != self._phase:
            self._phase = phase
            self._worth.clear()

    def best(self, swaps: list[Swap], rank: Callable[[Swap], float]) -> Swap | None:
        """Which exchange ranks highest? None where all rank zero. The next is looked at as long as it ranked higher than the best so far does."""
        found, most = None, 0.0
        for swap in sorted(swaps, key=lambda each: (-self._worth.get(each, math.inf), each)):
            if found is not None and self._worth.get(swap, math.inf) < most:
                break
            self._worth[swap] = rank(swap)
            if self._worth[swap] > most:
                found, most = swap, self._worth[swap]
        return found
