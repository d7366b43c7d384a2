"""The folder of an export."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from lostmotion.errors import LostmotionError, OutputExistsError

if TYPE_CHECKING:
    from collections.abc import Mapping


def write_files(files: Mapping[str, str | bytes], out: Path, *, force: bool) -> Path:
    """Write files, by their path within the folder `out`, and return the folder.

    Raises OutputExistsError where the folder has files and `force` is not set, LostmotionError where it cannot be written. With `force` files of the
    same names are replaced, and others stay.
    """
    if not force and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise OutputExistsError(f"'{out}' exists\n  replace its files with --force (force=True in Python), or name another folder with --out")
    try:
        for name, content in files.items():
            path = out / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.encode() if isinstance(content, str) else content)
    except OSError as error:
        raise LostmotionError(f"'{out}' could not be written: {error.strerror or error}\n  name a folder that can be written with --out") from error
    return Path(out)
