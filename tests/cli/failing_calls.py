"""A system that fails: calls on the files of one folder are counted, and one of them fails."""

from __future__ import annotations

import _io
import builtins
import errno
import io
import os
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Self

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

ERRORS: dict[str, Callable[[], BaseException]] = {
    "full disk": lambda: OSError(errno.ENOSPC, "No space left on device"),
    "broken disk": lambda: OSError(errno.EIO, "Input/output error"),
    "memory": MemoryError,
}
_ON_PATHS = (
    "open",
    "mkdir",
    "rename",
    "replace",
    "unlink",
    "rmdir",
    "scandir",
    "listdir",
    "stat",
    "lstat",
    "utime",
)
_ON_HANDLES = ("fsync", "fdopen")


class Stream:
    """An open file whose writes and closing are calls too; one that fails has written the first
    half.
    """

    def __init__(self, stream: Any, system: System) -> None:
        """Stand before a stream."""
        self._stream, self._system = stream, system

    def __getattr__(self, name: str) -> Any:
        """Return what the stream has."""
        return getattr(self._stream, name)

    def __enter__(self) -> Self:
        """Return the stream."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def __iter__(self) -> Iterator[Any]:
        """Return its lines."""
        return iter(self._stream)

    def write(self, content: Any) -> Any:
        """Write all, or half of it."""
        if self._system.fails():
            self._stream.write(content[: len(content) // 2])
            raise self._system.error()
        return self._stream.write(content)

    def read(self, *size: int) -> Any:
        """Read, or fail."""
        if self._system.fails():
            raise self._system.error()
        return self._stream.read(*size)

    def close(self) -> None:
        """Close in any case."""
        self._stream.close()
        if self._system.fails():
            raise self._system.error()


class System:
    """Counts calls on the files of a folder; the one with the number `at` fails."""

    def __init__(self, folder: Path, error: Callable[[], BaseException], at: int) -> None:
        """Count from the beginning."""
        self.folder, self.error, self.at, self.count = str(folder), error, at, 0

    def fails(self) -> bool:
        """Count a call, and return whether it fails."""
        self.count += 1
        return self.count == self.at

    def concerns(self, place: object) -> bool:
        """Return whether a path is within the folder."""
        return isinstance(place, str | os.PathLike) and os.path.abspath(  # noqa: PTH100
            os.fspath(place)
        ).startswith(self.folder)

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Count and fail within."""
        with pytest.MonkeyPatch.context() as patch:
            for name in _ON_PATHS:
                patch.setattr(os, name, self._failing(getattr(os, name)))
            for name in _ON_HANDLES:
                patch.setattr(os, name, self._failing(getattr(os, name), always=True))
            opening = self._opening(io.open)
            for module in (io, _io, builtins):
                patch.setattr(module, "open", opening)
            yield

    def _of_path(self, place: Any) -> BaseException:
        """Return the error, with the path where the system was given one."""
        error = self.error()
        return (
            type(error)(*error.args, os.fspath(place))
            if isinstance(error, OSError) and place is not None
            else error
        )

    def _failing(self, call: Callable[..., Any], *, always: bool = False) -> Callable[..., Any]:
        def made(*given: Any, **named: Any) -> Any:
            if (always or (given and self.concerns(given[0]))) and self.fails():
                raise self._of_path(None if always else given[0])
            return call(*given, **named)

        return made

    def _opening(self, call: Callable[..., Any]) -> Callable[..., Any]:
        def made(place: Any, *given: Any, **named: Any) -> Any:
            if not self.concerns(place):
                return call(place, *given, **named)
            if self.fails():
                raise self._of_path(place)
            return Stream(call(place, *given, **named), self)

        return made


def every_failure(
    folder: Path, work: Callable[[], Any], prepare: Callable[[], None], step: int = 1
) -> Iterator[tuple[str, int, Any, BaseException | None]]:
    """Do some work again and again, from the same start; each time the next call fails, or the one
    `step` calls later, in each way. Each way begins at another call, so that together they reach
    three times as many.

    Yields how and at which call it failed, what the work returned, and what it raised. Ends where
    the work has no further call.
    """
    for n, (name, error) in enumerate(ERRORS.items()):
        at = -(n * step // len(ERRORS))
        while True:
            at += step
            prepare()
            system = System(folder, error, at)
            found, raised = None, None
            with system.at_work():
                try:
                    found = work()
                except Exception as caught:  # noqa: BLE001 - the test looks at it
                    raised = caught
            if system.count < at:
                break
            yield name, at, found, raised
