"""The one place where a text file is opened: a regular file, of bounded size, in UTF-8."""

from __future__ import annotations

import itertools
import math
import os
import re
import stat
from pathlib import Path
from typing import TYPE_CHECKING, Final, NoReturn

from lostmotion.errors import InputError, Problem
from lostmotion.io.limits import nearest

if TYPE_CHECKING:
    from collections.abc import Sequence

_MEGABYTE: Final = 1_000_000
_NAMES_LOOKED_AT: Final = 1000
_FIRST_BYTES: Final = 4096
# Stands in no plain decimal number, but in others that Python reads: "1_0", "infinity", digits of
# other scripts.
_FOREIGN: Final = re.compile(r"[^0-9+\-.eE \t\r\n]")
_SAVE_AS: Final = "save the file as UTF-8 in your editor"
# First bytes of the files of spreadsheet programs: .xlsx and .ods are ZIP archives, .xls is an
# older container.
_WORKBOOKS: Final = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")


def refuse(*fields: str) -> NoReturn:
    """Raise one mistake, given as the fields of a Problem, as an InputError."""
    raise InputError([Problem(*fields)])


def read_text(path: Path, megabytes: int, example: str = "examples/z-arm.toml") -> str:
    """Return the text of a file of at most so many megabytes (1e6 bytes); `example` is a file of
    its kind, for the message.

    Nothing is read from a folder, device or pipe, nor beyond the size. A byte order mark is
    dropped. Raises InputError where the file is missing, no regular file, unreadable, too big, not
    UTF-8, or holds a NUL.
    """
    raw = _raw(path, megabytes, example)
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        found = f"the byte 0x{raw[error.start]:02x}, which is no UTF-8"
        refuse(f"{path}:{_line_at(raw, error.start)}", "", found, "text in UTF-8", _SAVE_AS)
    return _without_nul(text, str(path))


def read_old_text(path: Path, megabytes: int) -> tuple[str, int]:
    """Return a file's text, in UTF-8 or else in Latin-1, and the line of the first byte that is not
    UTF-8, 0 where there is none.

    For formats that older programs write. Bounds and errors as of `read_text`.
    """
    raw = _raw(path, megabytes, str(path))
    try:
        return _without_nul(raw.decode("utf-8-sig"), str(path)), 0
    except UnicodeDecodeError as error:
        return _without_nul(raw.decode("latin-1"), str(path)), _line_at(raw, error.start)


def _raw(path: Path, megabytes: int, example: str) -> bytes:
    file = str(path)
    try:
        kind = path.stat().st_mode
        raw = b""
        if stat.S_ISREG(kind):
            with path.open("rb") as stream:
                raw = stream.read(megabytes * _MEGABYTE + 1)
    except FileNotFoundError:
        refuse(
            file, "", "no such file", "the path of a file that exists", example, _near_file(path)
        )
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path itself
        refuse(
            file,
            "",
            getattr(error, "strerror", None) or str(error),
            "a file that can be read",
            example,
        )
    if not stat.S_ISREG(kind):
        refuse(
            file,
            "",
            "a folder" if stat.S_ISDIR(kind) else "no regular file",
            "a text file",
            f"{path.name or 'arm'}/arm{path.suffix or '.toml'}",
        )
    if len(raw) > megabytes * _MEGABYTE:
        refuse(
            file,
            "",
            f"more than {megabytes} MB",
            f"at most {megabytes} MB",
            "one arm, or one table of poses, per file",
        )
    if raw.startswith(_WORKBOOKS):
        found = (
            "an Excel workbook or another packed file"
            if path.suffix[:4].lower() in {".xls", ".ods"}
            else "a packed file, such as an Excel workbook"
        )
        refuse(
            file,
            "",
            found,
            "plain text: save the sheet as CSV in the spreadsheet program",
            f"{path.stem or 'visits'}.csv",
        )
    return raw


def _line_at(raw: bytes, at: int) -> int:
    return raw.count(b"\n", 0, at) + 1


def _without_nul(text: str, file: str) -> str:
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        refuse(f"{file}:{line}", "", "a NUL character", "text in UTF-8", _SAVE_AS)
    return text


def begins_as_xml(path: Path) -> bool:
    """Return whether a regular file's first visible letter opens a tag; False where it cannot be
    read, which its reader reports.
    """
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            return False
        with path.open("rb") as stream:
            return stream.read(_FIRST_BYTES).removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"<")
    except (OSError, ValueError):
        return False


def _near_file(path: Path) -> str:
    """Return the file of the same folder that was probably meant: a similar name with the same
    ending, or the same name with another one.
    """
    try:
        others = sorted(
            itertools.islice(path.parent.iterdir(), _NAMES_LOOKED_AT),
            key=lambda other: other.suffix == path.suffix,
        )
    except OSError:
        return ""
    names = {
        other.stem: other.name
        for other in others
        if path.suffix == other.suffix or path.stem == other.stem
    }
    return names.get(nearest(path.stem, names), "")


def beside(file: str, stated: object) -> Path | None:
    """Return the file in the folder, or in one below, that a file names. None for what is no name,
    and for one that leads out of the folder.
    """
    if not isinstance(stated, str) or not stated.isprintable() or not stated:
        return None
    folder = Path(file).parent
    path = folder / stated
    inside = Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))
    return (
        path
        if inside and not Path(stated).is_absolute() and ".." not in Path(stated).parts
        else None
    )


def numbers(words: Sequence[str]) -> list[float]:
    """Return the numbers that these words state in plain decimal notation. Raises ValueError for
    any other word; one too large is infinite.
    """
    if _FOREIGN.search(" ".join(words)):
        raise ValueError("not a plain decimal number")
    return [float(word) for word in words]


def number(word: str) -> float:
    """Return the number that a word states in plain decimal notation; NaN for any other word."""
    try:
        return numbers([word])[0]
    except ValueError:
        return math.nan
