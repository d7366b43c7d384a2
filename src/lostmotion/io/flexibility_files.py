"""Flexibilities of the elastic bodies of drawn gearboxes in the user's cache folder, so that the
next run need not compute them.

A file has a checksum of its name and content, arrays as NumPy writes them; without a match they are
computed again. Its name is a hash of what the arrays follow from, with the source text of all laws
and the version of NumPy: another version never reads them. The folder can be deleted at any time.
"""

from __future__ import annotations

import hashlib
import io
import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lostmotion.checked_file import read_checked, write_checked
from lostmotion.source_hash import is_unchanged, source_hash

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# Number of files above which the older half is deleted, and bytes of the largest one; most have
# some 50 kB.
_MOST: Final = 500
_LARGEST: Final = 4_000_000


def keep_flexibilities() -> None:
    """Keep flexibilities in the user's cache folder: $XDG_CACHE_HOME/lostmotion or
    ~/.cache/lostmotion; nowhere if there is neither.
    """
    from lostmotion.laws.cycloid.kept import keep_in

    home = Path(os.environ.get("XDG_CACHE_HOME") or Path(os.path.expanduser("~"), ".cache"))  # noqa: PTH111 - gives "~" back where there is no home
    keep_in(FlexibilityFiles(home / "lostmotion") if home.is_absolute() else None)


class FlexibilityFiles:
    """Arrays as files of a folder, at most some hundred. Whatever cannot be read or written is
    computed each time.
    """

    def __init__(self, folder: Path) -> None:
        """Take the folder, which is made once something is written."""
        self._folder = folder

    def read(self, key: str) -> tuple[Floats, ...] | None:
        """Return the arrays of a key, to the bit; None where there are none or the file is
        damaged.
        """
        import numpy as np

        file = self._file(key)
        raw = None if file is None else read_checked(file, file.name.encode(), _LARGEST)
        if raw is None:
            return None
        content = io.BytesIO(raw)
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
        raw, file = content.getvalue(), self._file(key)
        if len(raw) > _LARGEST or file is None or not is_unchanged():
            return
        with suppress(OSError):
            self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._delete_oldest()
            write_checked(file, file.name.encode(), raw)

    def _file(self, key: str) -> Path | None:
        laws = _laws()
        return (
            None
            if laws is None
            else self._folder / hashlib.sha256((laws + key).encode()).hexdigest()
        )

    def _delete_oldest(self) -> None:
        # entries of the folder know which are files, without asking the disk about each
        with os.scandir(self._folder) as entries:
            files = [each for each in entries if each.is_file()]
        if len(files) >= _MOST:
            for each in sorted(files, key=lambda file: file.stat().st_mtime)[: _MOST // 2]:
                os.unlink(each)  # noqa: PTH108 - an entry is no Path


def _laws() -> str | None:
    """Return a hash of the source text of all laws, with the version of NumPy; None where it cannot
    be read.
    """
    import numpy as np

    source = source_hash("laws")
    return None if source is None else f"{source} {np.__version__} "
