"""Arrays that a law keeps from one run of the program to the next: nowhere, unless the edge of the
program provides a store.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.spatial import Floats


class FlexibilityStore(Protocol):
    """Where arrays are kept by a text that states all they follow from."""

    def read(self, key: str) -> tuple[Floats, ...] | None:
        """Return the arrays of a key, to the bit; None where there are none."""

    def write(self, key: str, arrays: Sequence[Floats]) -> None:
        """Keep arrays, if possible."""


class _Kept:
    store: FlexibilityStore | None = None


def keep_in(store: FlexibilityStore | None) -> None:
    """Keep arrays in this store from now on, or nowhere."""
    _Kept.store = store


def recalled(key: str, compute: Callable[[], tuple[Floats, ...]]) -> tuple[Floats, ...]:
    """Return what `compute` returns, from the store where it is there. The key states everything
    that the arrays follow from.
    """
    store = _Kept.store
    if store is None:
        return compute()
    found = store.read(key)
    if found is None:
        found = compute()
        store.write(key, found)
    return found
