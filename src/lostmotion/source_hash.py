"""Hash of the package's source text: the key under which results of this source are stored between
runs.

The hash covers contents, since a file can be replaced by another one of the same size and time (`cp
-p`, `rsync -t`, archives). Times and inodes only serve to notice a change while this process runs:
then what is in memory and what is on the disk differ, and there is no hash.
"""

from __future__ import annotations

import functools
import hashlib
import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

# Packages of the numeric core. Each imports those before it and the modules of the folder that
# contains them, and nothing else of this package.
LAYERS: Final = ("laws", "parts", "catalogue", "mechanism", "error_model", "propagation")
_HERE: Final = Path(__file__).parent


@functools.cache
def source_hash(layer: str) -> str | None:
    """Return a hash of all source that a layer can see: its own, that of the layers below and of
    the modules beside them.

    None where the source cannot be read, or has changed since the package was imported.
    """
    found = hashlib.sha256()
    try:
        for path in sorted(_files(LAYERS[: LAYERS.index(layer) + 1])):
            content = Path(path).read_bytes()
            found.update(f"{os.path.relpath(path, _HERE)}\0{len(content)}\0".encode())
            found.update(content)
    except OSError:
        return None
    return found.hexdigest() if is_unchanged() else None


def is_unchanged() -> bool:
    """Return whether the source can be read and is as it was when the package was imported."""
    return bool(_AT_START) and _states() == _AT_START


def _files(layers: tuple[str, ...]) -> Iterator[str]:
    """Yield the paths of the source files of these layers and of the modules beside them."""
    yield from (each.path for each in os.scandir(_HERE) if each.name.endswith(".py"))
    for layer in layers:
        for folder, _, names in os.walk(_HERE / layer):
            yield from (os.path.join(folder, name) for name in names if name.endswith(".py"))  # noqa: PTH118 - 200 paths at each start


def _states() -> dict[str, tuple[int, ...]]:
    """Return what changes with the content of each file: inode, size, and times of content and of
    inode; empty where there are no files.
    """
    try:
        found = {path: os.stat(path) for path in _files(LAYERS)}  # noqa: PTH116 - as above
    except OSError:
        return {}
    return {
        path: (state.st_ino, state.st_size, state.st_mtime_ns, state.st_ctime_ns)
        for path, state in found.items()
    }


_AT_START: Final = _states()
