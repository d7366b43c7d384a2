"""The folder or the file of an export."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.errors import OutputExistsError, refuse_argument
from lostmotion.reporting.folder import write_file

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


# By this file an earlier export is recognised.
_MARKS: Final = ("src/lm_model.h", "model/src/lm_model.h")


def write_files(files: Mapping[str, str], out: Path, *, force: bool) -> Path:
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
        write_file(content.encode(), out / name, force=True)
    return out


def write_fmu(out: Path, content: bytes, *, force: bool) -> Path:
    """Write an FMU and return its path.

    Raises InputError for a name without .fmu, OutputExistsError where it exists and `force` is not
    set, LostmotionError as `write_files`.
    """
    if out.suffix.lower() != ".fmu":
        raise refuse_argument("out", str(out), "a file that ends in .fmu", out="arm.fmu")
    return write_file(content, out, force=force)
