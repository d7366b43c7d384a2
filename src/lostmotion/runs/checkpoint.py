"""Which blocks are done: a small file for each, with the sums by which its pieces are known
again.
"""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import stat
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

_LARGEST_ENTRY: Final = 10_000
PARTIAL: Final = ".partial"


def digest(content: bytes) -> str:
    """Return the checksum of this content. SHA-256."""
    return hashlib.sha256(content).hexdigest()


def entry(sums: Mapping[str, str]) -> bytes:
    """Write down the sums of a block's pieces, by name."""
    return (json.dumps(dict(sums), indent=1, sort_keys=True) + "\n").encode()


def read_entry(path: Path) -> dict[str, str]:
    """Return the checksums in this file of the ledger. None for a file that is not there, torn, or
    none of ours.
    """
    raw = read_regular(path, _LARGEST_ENTRY)
    try:
        found: Any = json.loads(raw) if raw is not None else {}
    except (ValueError, RecursionError):
        return {}
    return (
        found
        if isinstance(found, dict) and all(isinstance(each, str) for each in found.values())
        else {}
    )


def read_regular(path: Path, most: int) -> bytes | None:
    """Return the content of a regular file of at most so many bytes. None for anything else: a
    link, a device, a file too large or not there.
    """
    try:
        handle = os.open(
            path,
            os.O_RDONLY
            | getattr(os, "O_NOFOLLOW", 0)
            | getattr(os, "O_NONBLOCK", 0)
            | getattr(os, "O_BINARY", 0),
        )
    except OSError:
        return None
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        return None
    with os.fdopen(handle, "rb") as stream:
        raw = stream.read(most + 1)
    return raw if len(raw) <= most else None


def place(path: Path, content: bytes, *, to_disk: bool = False) -> None:
    """Put a file where it belongs, whole or not at all: under a name of its own first, then
    renamed.

    With `to_disk` also where the machine loses its power; blocks do without, whose checksums show
    what was lost.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f"{path.name}.{secrets.token_hex(4)}{PARTIAL}")
    try:
        with partial.open("wb") as stream:
            stream.write(content)
            if to_disk:
                stream.flush()
                os.fsync(stream.fileno())
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
