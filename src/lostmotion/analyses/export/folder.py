"""The folder or the file of an export."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from lostmotion.errors import LostmotionError, OutputExistsError, refuse_argument

if TYPE_CHECKING:
    from collections.abc import Mapping


# By this file an earlier export is recognised.
_MARKS: Final = ("src/lm_model.h", "model/src/lm_model.h")


def write_files(files: Mapping[str, str | bytes], out: Path, *, force: bool) -> Path:
    """Write files, by their path within the folder `out`, and return the folder.

    Raises OutputExistsError where the folder has files and `force` is not set or they are no
    earlier export, LostmotionError where it cannot be written. With `force` files of other names
    stay.
    """
    if not force and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise OutputExistsError(
            f"'{out}' exists\n  replace its files with --force (force=True in Python), or name "
            "another folder with --out"
        )
    if out.is_dir() and any(out.iterdir()) and not any((out / mark).exists() for mark in _MARKS):
        raise OutputExistsError(
            f"'{out}' has files that are no export\n  name another folder with --out"
        )
    for name, content in files.items():
        _write(out / name, content.encode() if isinstance(content, str) else content)
    return Path(out)


def write_fmu(out: Path, content: bytes, *, force: bool) -> Path:
    """Write an FMU and return its path.

    Raises InputError for a name without .fmu, OutputExistsError where it exists and `force` is not
    set, LostmotionError as `write_files`.
    """
    if out.suffix.lower() != ".fmu":
        raise refuse_argument("out", str(out), "a file that ends in .fmu", out="arm.fmu")
    if out.exists() and not force:
        raise OutputExistsError(
            f"'{out}' exists\n  replace it with --force (force=True in Python), or name "
            "another file with --out"
        )
    _write(out, content)
    return Path(out)


def _write(path: Path, content: bytes) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    except OSError as error:
        raise LostmotionError(
            f"'{path}' could not be written: {error.strerror or error}\n  name a place that "
            "can be written with --out"
        ) from error
