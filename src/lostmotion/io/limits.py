"""Parsing limits: how many mistakes are listed for one file, and how much work a file may cause."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final, NoReturn

from lostmotion import errors
from lostmotion.errors import InputError, Problem

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Sequence

MOST_MISTAKES: Final = 50
# Key of the last mistake where there are more.
MORE: Final = "and more"
_MOST_NAMES: Final = 20
_MOST_LETTERS: Final = 240
_CANDIDATES: Final = 200
_LONGEST_WORD: Final = 100


def refuse_all(mistakes: Sequence[Problem], most: int = MOST_MISTAKES) -> NoReturn:
    """Raise the first so many mistakes as an InputError, with a last line where there are more."""
    kept = list(mistakes[:most])
    if len(mistakes) > most:
        kept.append(
            Problem(
                kept[-1].file,
                MORE,
                f"more than these {most} mistakes",
                "none",
                "correct these, then read the file again",
            )
        )
    raise InputError(kept)


def nearest(word: str, known: Iterable[str]) -> str:
    """Return which of the first 200 known names was probably meant. Empty where none is close, or
    the word is none.
    """
    return (
        errors.nearest(word, itertools.islice(known, _CANDIDATES))
        if len(word) <= _LONGEST_WORD
        else ""
    )


def listed(names: Collection[str], show: Callable[[str], str] = str) -> str:
    """List names, at most 20 of them and only as many as fill a line or two."""
    kept: list[str] = []
    for name in itertools.islice(names, _MOST_NAMES):
        if kept and sum(map(len, kept)) + len(name) > _MOST_LETTERS:
            break
        kept.append(show(name))
    return ", ".join(kept) + (
        f" and {len(names) - len(kept)} more" if len(names) > len(kept) else ""
    )


def cut(text: str, longest: int) -> str:
    """Return a text without what cannot be printed, and not longer than this."""
    text = "".join(char if char.isprintable() else "?" for char in text[: longest + 1])
    return text if len(text) <= longest else text[: longest - 3] + "..."
