"""What goes to the terminal, whatever the terminal is: closed, full, a pipe that ends, or one that
knows ASCII alone.
"""

from __future__ import annotations

import codecs
import contextlib
import errno
import json
import os
import sys
from typing import TYPE_CHECKING, Any, Final, TextIO

import typer

from lostmotion.errors import legible

if TYPE_CHECKING:
    from io import TextIOWrapper

LOST: Final = "the output was closed before all was printed; the results are written"
_HANDLER: Final = "lostmotion.plain"
# How a terminal without these characters shows them; any other becomes "?".
_PLAIN: Final = str.maketrans(
    {
        "µ": "u",
        "μ": "u",
        "°": " deg",
        "±": "+/-",
        "′": "'",
        "″": '"',
        "–": "-",
        "—": "-",
        "…": "...",
    }
    | {"≤": "<=", "≥": ">=", "≈": "~", "²": "^2", "³": "^3"}
)
# What writing says of a full disk, a closed pipe, a closed file and a broken device.
_OUTPUT_ERRORS: Final = frozenset(
    {
        errno.ENOSPC,
        errno.EPIPE,
        errno.EBADF,
        errno.EIO,
        errno.EDQUOT if hasattr(errno, "EDQUOT") else errno.ENOSPC,
    }
)


# Whether this command prints its results by now: until then an error without the name of a file is
# one of a file that is read.
_printing: list[bool] = []


def begin_printing(*, begun: bool = True) -> None:
    """Note that all is written, and that results are printed from here on; or that a new command
    begins.
    """
    _printing[:] = [True] if begun else []


def is_printing() -> bool:
    """Return whether results are printed by now, so that all files are written."""
    return bool(_printing)


def say(text: str, *, error: bool = False) -> None:
    """Print a line; control characters in it are written out."""
    if not error:
        begin_printing()
    typer.echo(legible(text), err=error)


def say_json(data: Any) -> None:  # noqa: ANN401 - whatever JSON can hold
    """Print data for machines: JSON that holds the same on a terminal of any encoding, without a
    character that one would obey.
    """
    begin_printing()
    text = json.dumps(data, indent=2, ensure_ascii=not _knows_unicode(sys.stdout), allow_nan=False)
    typer.echo(
        "".join(
            char if char == "\n" or legible(char) == char else json.dumps(char)[1:-1]
            for char in text
        )
    )


def _knows_unicode(stream: TextIO | None) -> bool:
    return (
        (getattr(stream, "encoding", None) or "utf-8")
        .lower()
        .replace("-", "")
        .replace("_", "")
        .startswith("utf")
    )


def open_up() -> bool:
    """Make both streams fit to be written to; return whether standard output exists.

    Characters that an encoding lacks are replaced instead of raising. In the place of closed
    streams a null device is opened, or the next file that is opened would take their numbers, and a
    stray word would end in a report.
    """
    codecs.register_error(_HANDLER, _plainly)
    there = sys.stdout is not None
    if not there or sys.stderr is None or sys.stdin is None:
        while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:  # noqa: PLR2004 - the three standard streams
            pass
        os.close(handle)
        sys.stdout, sys.stderr = sys.stdout or _nowhere(), sys.stderr or _nowhere()
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=_HANDLER)
    return there


def _nowhere() -> TextIOWrapper:
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123 - a stream for the rest of the process


def _plainly(error: UnicodeError) -> tuple[str | bytes, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lost = error.object[error.start : error.end].translate(_PLAIN)
    return lost.encode("ascii", "replace").decode("ascii"), error.end


def flush() -> OSError | None:
    """Write buffered output; return the error, if any."""
    try:
        sys.stdout.flush()
    except OSError as error:
        return error
    return None


def is_of_output(error: OSError) -> bool:
    """Return whether an error is one of a stream while results are printed; an error of a file
    names the file.
    """
    return is_printing() and error.filename is None and error.errno in _OUTPUT_ERRORS


def give_up() -> None:
    """Send what cannot be printed nowhere, or Python reports a second error when it closes the
    streams.
    """
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            if stream is sys.stdout or _is_broken(stream):
                os.dup2(nowhere, stream.fileno())


def _is_broken(stream: TextIO) -> bool:
    try:
        stream.flush()
    except OSError:
        return True
    return False
