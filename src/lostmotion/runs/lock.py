"""One process at a time works in a run's folder: a lock that the system takes back when its process
ends, also by SIGKILL.
"""

from __future__ import annotations

import os
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from lostmotion.errors import LostmotionError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

# The file stays: whoever removed it could lock another file than the one who waits for it.
LOCK: Final = "run.lock"
_SECONDS_BETWEEN: Final = 0.02


@contextmanager
def lock(folder: Path, wait: float = 0.0) -> Iterator[None]:
    """Hold the lock of a run's folder, which is made where it is missing. Waits at most `wait`
    seconds for another process.

    The system's own lock on an open file (flock; on Windows a locked byte): no process that died
    leaves one behind.
    Raises LostmotionError where another process holds it for longer, the folder cannot be written,
    or its disk knows no locks.
    """
    path = folder / LOCK
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(
            path,
            os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0),
            0o644,
        )
    except OSError as error:
        raise LostmotionError(
            f"'{path}' cannot be written: {error.strerror or error}\n  name a folder that can "
            "be written with --out"
        ) from error
    try:
        deadline = time.monotonic() + wait
        while not _taken(handle, path):
            if time.monotonic() >= deadline:
                raise LostmotionError(
                    f"another process is writing to '{folder}'\n  wait for it, or name another "
                    "folder with --out"
                )
            time.sleep(_SECONDS_BETWEEN)
        yield
    finally:
        os.close(handle)  # releases the lock


def _taken(handle: int, path: Path) -> bool:
    """Take the lock if it is free; return whether it was taken."""
    try:
        try:
            import fcntl
        except ImportError:  # Windows
            import msvcrt

            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined,unused-ignore]
        else:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        # raised by flock and by Windows while another process holds the lock
        return False
    except OSError as error:
        message = (
            f"'{path}' cannot be locked: {error.strerror or error}\n  two runs at once would mix; "
            "name a folder on a disk with file locks with --out"
        )
        raise LostmotionError(message) from error
    return True
