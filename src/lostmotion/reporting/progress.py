"""The progress bar on the terminal, drawn only where the work takes more than a second."""

from __future__ import annotations

import sys
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, Self, TextIO, cast

if TYPE_CHECKING:
    from types import TracebackType

    from rich.progress import Progress

_SECONDS_BEFORE_BAR: Final = 1.0


class _Forgiving:
    """A stream whose failures are ignored: a bar that cannot be drawn, on a full disk, must not
    cost the results.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 - whatever a stream has
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        with suppress(OSError, ValueError):
            return self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        with suppress(OSError, ValueError):
            self._stream.flush()


class ProgressBar:
    """Progress bar that shows itself, and loads what draws it, only once the work has taken a
    second.
    """

    def __init__(self) -> None:
        """Begin to count the time; nothing is shown yet."""
        self._started = time.monotonic()
        self._bar: Progress | None = None

    def __enter__(self) -> Self:
        """Begin to wait."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, what: str, done: int, of: int) -> None:
        """Show the step, and how much of it is done."""
        if self._bar is None and time.monotonic() - self._started > _SECONDS_BEFORE_BAR:
            self._bar = _drawn()
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], description=what, completed=done, total=of)


def _drawn() -> Progress:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeRemainingColumn(),
        console=Console(file=cast("TextIO", _Forgiving(sys.stderr))),
        transient=True,
    )
    bar.add_task("")
    bar.start()
    return bar
