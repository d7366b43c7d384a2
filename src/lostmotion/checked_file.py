"""Files of a cache that are believed only whole and in their own place: content behind a checksum
of key and content.
"""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Final

_CHECKSUM: Final = 32


def read_checked(file: Path, key: bytes, most: int | None = None) -> bytes | None:
    """Return the content that was written under this key; None where the file is missing, damaged,
    of another key, or of more than `most` bytes.
    """
    try:
        with file.open("rb") as opened:
            raw = opened.read() if most is None else opened.read(most + _CHECKSUM + 1)
    except OSError:
        return None
    content = raw[_CHECKSUM:]
    return (
        content
        if (most is None or len(content) <= most) and _checksum(key, content) == raw[:_CHECKSUM]
        else None
    )


def write_checked(file: Path, key: bytes, content: bytes) -> None:
    """Write content under a key, in place of whatever lies there, if that is possible; no part of a
    file ever stays.
    """
    with suppress(OSError):
        if file.is_dir():
            shutil.rmtree(file)
        written = tempfile.NamedTemporaryFile(dir=file.parent, delete=False)  # noqa: SIM115 - closed below, before it is renamed
        try:
            with written:
                written.write(_checksum(key, content) + content)
            Path(written.name).replace(file)
        finally:  # a full disk must not become fuller
            Path(written.name).unlink(missing_ok=True)


def _checksum(key: bytes, content: bytes) -> bytes:
    return hashlib.sha256(hashlib.sha256(key).digest() + content).digest()
