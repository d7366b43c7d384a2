"""Results that are asked for again soon, kept for a while."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

T = TypeVar("T")


class Recent(Generic[T]):
    """The results used last, up to a number of bytes. Threads may share it.

    A result refers to every object that its key names by `id`, so that no other object has that
    key.
    """

    def __init__(self, most: int, size: Callable[[T], int]) -> None:
        """Keep at most `most` bytes; `size` returns those of a result."""
        self._most, self._size = most, size
        self._kept: OrderedDict[Hashable, T] = OrderedDict()
        self._bytes = 0
        self._lock = Lock()

    def of(self, key: Hashable, compute: Callable[[], T]) -> T:
        """Return the result of this key, which is computed where it is not kept."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        found = compute()
        with self._lock:
            if key not in self._kept and self._size(found) <= self._most:
                self._kept[key] = found
                self._bytes += self._size(found)
            while self._bytes > self._most:
                self._bytes -= self._size(self._kept.popitem(last=False)[1])
        return found

    def clear(self) -> None:
        """Keep nothing."""
        with self._lock:
            self._kept.clear()
            self._bytes = 0
