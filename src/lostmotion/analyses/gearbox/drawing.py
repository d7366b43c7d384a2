"""Write the profile of a cycloidal gearbox to a DXF file."""

from __future__ import annotations

import secrets
import tempfile
from typing import TYPE_CHECKING

from lostmotion.errors import LostmotionError, OutputExistsError
from lostmotion.reporting.folder import to_disk

if TYPE_CHECKING:
    from pathlib import Path


def refuse_existing_file(out: Path, *, force: bool) -> None:
    """Raise OutputExistsError for an existing file without `force`, a folder or a link;
    LostmotionError where the parent folder is missing.
    """
    if not out.absolute().parent.is_dir():
        raise LostmotionError(
            f"there is no folder '{out.parent}' for the drawing\n  make it, or name another "
            "file with --dxf"
        )
    if out.is_symlink() or (out.exists() and not out.is_file()):
        raise OutputExistsError(
            f"'{out}' is no file of ours to replace\n  name another file with --dxf"
        )
    if out.exists() and not force:
        raise OutputExistsError(
            f"'{out}' exists\n  replace it with --force, or name another file with --dxf"
        )
    try:
        # permissions alone do not show whether that works
        with tempfile.TemporaryFile(prefix=".lostmotion-", dir=out.absolute().parent):
            pass
    except OSError as error:
        raise LostmotionError(
            f"'{out}' could not be written: {error.strerror or error}\n  name a file that can "
            "be written with --dxf"
        ) from error


def write_drawing(drawing: bytes, out: Path, *, force: bool = False) -> Path:
    """Write the drawing into the file `out`, whole or not at all, and return its path.

    Raises OutputExistsError as `refuse_existing_file`, LostmotionError where the file cannot be
    written.
    """
    refuse_existing_file(out, force=force)
    new = out.with_name(f".{out.name[:80]}.{secrets.token_hex(4)}.new")
    try:
        new.write_bytes(drawing)
        to_disk(new)
        new.replace(out)
    except BaseException as error:
        new.unlink(missing_ok=True)
        if not isinstance(error, OSError):
            raise
        raise LostmotionError(
            f"'{out}' could not be written: {error.strerror or error}\n  name a file that can "
            "be written with --dxf"
        ) from error
    return out
