"""Where compiled code is cached."""

from __future__ import annotations

import os
from pathlib import Path


def let_numba_cache() -> None:
    """Return compiled code a folder of this process's own where it can be kept neither beside the package nor in the user's home.

    Numba refuses to compile at all without one. A folder that others could write to would let them run code here, so each process makes its own and
    compiles each time.
    """
    if "NUMBA_CACHE_DIR" in os.environ:
        return
    here = Path(__file__).parent
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path(os.path.expanduser("~"), ".cache"))  # noqa: PTH111 - gives "~" back where there is no home
    kept = [
        here / room / "__pycache__" for room in ("error_model", "laws/cycloid", "laws/rolling", "mechanism", "propagation", "propagation/montecarlo")
    ]
    if all(map(_can_write, kept)) or (home.is_absolute() and _can_write(home / "numba")):
        return
    import atexit
    import contextlib
    import shutil
    import tempfile

    with contextlib.suppress(OSError):  # nowhere at all: Numba then says so
        folder = tempfile.mkdtemp(prefix="lostmotion-")
        os.environ["NUMBA_CACHE_DIR"] = folder
        atexit.register(shutil.rmtree, folder, ignore_errors=True)


def _can_write(folder: Path) -> bool:
    """Return whether this folder, or the nearest one above it that exists, can be written to."""
    there = next((each for each in (folder, *folder.parents) if each.exists()), folder)
    return there.is_dir() and os.access(there, os.W_OK | os.X_OK)
