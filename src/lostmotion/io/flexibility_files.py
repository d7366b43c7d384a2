"""Flexibilities of the elastic bodies of drawn gearboxes in the user's cache folder, so that the next run need not compute them.

A file has a checksum and its content, arrays as NumPy writes them; without a match it is computed again. Its name is a hash of what the arrays follow
from, with the source text of all laws and the version of NumPy: another version never reads them. The folder can be deleted at any time.
"""

from __future__ import annotations

import functools
import hashlib
import io
import os
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# Number of files above which the older half is deleted, and bytes of the largest one; most have some 50 kB.
_MOST: Final = 500
_LARGEST: Final = 4_000_000
_CHECKSUM: Final = 32


def keep_flexibilities() -> None:
    """Keep flexibilities in the user's cache folder: $XDG_CACHE_HOME/lostmotion or ~/.cache/lostmotion; nowhere if there is neither."""
    from lostmotion.laws.cycloid.kept import keep_in

    home = Path(os.environ.get("XDG_CACHE_HOME") or Path(os.path.expanduser("~"), ".cache"))  # noqa: PTH111 - gives "~" back where there is no home
    keep_in(FlexibilityFiles(home / "lostmotion") if home.is_absolute() else None)


class FlexibilityFiles:
    """Arrays as files of a folder, at most some hundred. Whatever cannot be read or written is computed each time."""

    def __init__(self, folder: Path) -> None:
        """Take the folder, which is made once something is written."""
        self._folder = folder

    def read(self, key: str) -> tuple[Floats, ...] | None:
        """Return the arrays of a key, to the bit; None where there are none or the file is damaged."""
        import numpy as np

        try:
            with self._file(key).open("rb") as file:
                raw = file.read(_LARGEST + 1)
        except OSError:
            return None
        content = io.BytesIO(raw[_CHECKSUM:])
        if len(raw) > _LARGEST or hashlib.sha256(content.getbuffer()).digest() != raw[:_CHECKSUM]:
            return None
        arrays = []
        with suppress(ValueError, EOFError):
            while content.read(1):
                content.seek(-1, os.SEEK_CUR)
                arrays.append(np.load(content, allow_pickle=False))
            return tuple(arrays)
        return None

    def write(self, key: str, arrays: Sequence[Floats]) -> None:
        """Keep arrays under a key, if the folder can be written to."""
        import numpy as np

        content = io.BytesIO()
        for each in arrays:
            np.save(content, each, allow_pickle=False)
        raw = content.getvalue()
        if len(raw) + _CHECKSUM > _LARGEST:
            return
        with suppress(OSError):
            self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._delete_oldest()
            file = tempfile.NamedTemporaryFile(dir=self._folder, delete=False)  # noqa: SIM115 - closed below, before it is renamed
            try:
                with file:
                    file.write(hashlib.sha256(raw).digest() + raw)
                Path(file.name).replace(self._file(key))
            finally:  # a full disk must not become fuller
                Path(file.name).unlink(missing_ok=True)

    def _file(self, key: str) -> Path:
        return self._folder / hashlib.sha256((_laws() + key).encode()).hexdigest()

    def _delete_oldest(self) -> None:
        files = list(self._folder.iterdir())
        if len(files) >= _MOST:
            for each in sorted(files, key=lambda file: file.stat().st_mtime)[: _MOST // 2]:
                each.unlink()


@functools.cache
def _laws() -> str:
    """Return a hash of the source text of all laws, with the version of NumPy."""
    import numpy as np

    import lostmotion.laws

    found = hashlib.sha256(np.__version__.encode())
    for file in sorted(Path(lostmotion.laws.__path__[0]).rglob("*.py")):
        found.update(file.read_bytes())
    return found.hexdigest()
