"""Compiled kernels on the disk, so that the next run need not compile them.

Numba's own cache compares the time of the file of a function alone: after a change of a constant in
another file it returns the old code, and a damaged file stops it. Here the folder is named by a
hash of all source that a kernel can see and of the versions that compile it, and each file contains
a checksum of its key and content. A file that does not match is compiled again and replaced.
"""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lostmotion.checked_file import read_checked, write_checked
from lostmotion.source_hash import is_unchanged, source_hash

if TYPE_CHECKING:
    from collections.abc import Callable

# Number of folders above which the least recently used are deleted: a version of the package has
# one for each layer with kernels.
_MOST: Final = 24


class KernelCache:
    """Compiled forms of one function, in the way that Numba's dispatcher asks for them. Whatever
    cannot be read or written is compiled each time.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        """Take the Python function, which is one of this package."""
        self._function = function
        self._about = (
            f"{function.__module__}.{function.__qualname__}:{function.__code__.co_firstlineno}"
        )
        self._layer = function.__module__.split(".")[1]

    @property
    def cache_path(self) -> str:
        """Return the folder of this function's files; empty where there is none."""
        return str(folder_of(self._layer) or "")

    def load_overload(self, signature: Any, target_context: Any) -> Any:  # noqa: ANN401 - Numba publishes no types
        """Return the compiled function of a signature; None where it must be compiled."""
        from numba.core.compiler import CompileResult

        target_context.refresh()
        key = self._key(signature, target_context.codegen())
        file = self._file(key)
        content = None if file is None else read_checked(file, key)
        if content is None:
            return None
        try:
            return CompileResult._rebuild(target_context, *pickle.loads(content))  # noqa: S301, SLF001 - as Numba does, of the user's own cache
        except Exception:  # noqa: BLE001 - a file of any content: the function is compiled instead
            return None

    def save_overload(self, signature: Any, result: Any) -> None:  # noqa: ANN401 - as above
        """Keep the compiled function of a signature, if it can be kept."""
        from numba.core.serialize import dumps

        # Addresses of this process are part of such code.
        if any(not each.can_cache for each in result.lifted) or result.library.has_dynamic_globals:
            return
        key = self._key(signature, result.codegen)
        file = self._file(key)
        if file is None or not is_unchanged():
            return
        with suppress(OSError):
            if not file.parent.is_dir():
                file.parent.unlink(missing_ok=True)
                file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
                _delete_least_recent(file.parent)
            write_checked(file, key, dumps(result._reduce()))  # noqa: SLF001 - as Numba does

    def flush(self) -> None:
        """Do nothing: outdated folders have other names."""

    def _key(self, signature: Any, codegen: Any) -> bytes:  # noqa: ANN401 - as above
        from numba.core.serialize import dumps

        closure = self._function.__closure__
        contents = hashlib.sha256(
            dumps(tuple(cell.cell_contents for cell in closure)) if closure else b""
        ).hexdigest()
        return f"{self._about} {signature} {codegen.magic_tuple()} {contents}".encode()

    def _file(self, key: bytes) -> Path | None:
        folder = folder_of(self._layer)
        return (
            None
            if folder is None
            else folder / f"{self._function.__name__}-{hashlib.sha256(key).hexdigest()[:32]}.kernel"
        )


@functools.cache
def folder_of(layer: str) -> Path | None:
    """Return the folder of the kernels of a layer of the package; None where nothing can be
    kept.
    """
    import llvmlite
    import numba
    import numpy as np

    source, base = source_hash(layer), base_folder()
    if source is None or base is None:
        return None
    about = (
        f"{source} {sys.implementation.cache_tag} {numba.__version__} {llvmlite.__version__} "
        f"{np.__version__}"
    )
    folder = base / f"{layer}-{hashlib.sha256(about.encode()).hexdigest()[:32]}"
    with suppress(OSError):
        os.utime(folder)  # used now
    return folder


@functools.cache
def base_folder() -> Path | None:
    """Return where the folders of kernels are: in $NUMBA_CACHE_DIR, else the user's cache folder,
    else beside the package.

    Where none can be written to, this process and those that it starts get a folder that is deleted
    when it ends. A folder that others can write to would let them run code here.
    """
    if named := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(named, "lostmotion").absolute()
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path(os.path.expanduser("~"), ".cache"))  # noqa: PTH111 - gives "~" back where there is no home
    kept = [home / "lostmotion-kernels"] if home.is_absolute() else []
    found = next(
        (
            each
            for each in (*kept, Path(__file__).parent / "__pycache__" / "kernels")
            if _can_write(each)
        ),
        None,
    )
    if found is not None:
        return found
    import atexit
    import shutil

    with suppress(OSError):
        folder = tempfile.mkdtemp(prefix="lostmotion-")
        os.environ["NUMBA_CACHE_DIR"] = folder
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        return Path(folder, "lostmotion")
    return None


def _can_write(folder: Path) -> bool:
    """Return whether this folder, or the nearest one above it that exists, can be written to."""
    there = next((each for each in (folder, *folder.parents) if each.exists()), folder)
    return there.is_dir() and os.access(there, os.W_OK | os.X_OK)


def _delete_least_recent(new: Path) -> None:
    """Delete the folders beside a new one that were not used for the longest time, beyond the
    number that is kept.
    """
    import shutil

    others = sorted(
        (each for each in new.parent.iterdir() if each.is_dir() and each != new),
        key=lambda each: each.stat().st_mtime,
        reverse=True,
    )
    for each in others[_MOST - 1 :]:
        shutil.rmtree(each, ignore_errors=True)
