"""What can go wrong, as one tree.

LostmotionError
├── InputError        a file or an argument says something that cannot be; lists every mistake found
├── OutputExistsError the place for the results is taken, and the user did not say --force
└── DidNotConvergeError  a law found no answer; no plausible number is returned in its place
"""

from __future__ import annotations

import difflib
import unicodedata
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, ParamSpec, Self, TypeVar, cast

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Worded:
    """Marks a field of a file with what a refusal expects there, and with an example as it stands
    in a file.
    """

    expected: str
    example: str


@dataclass(frozen=True, slots=True)
class Problem:
    """One mistake: where it stands, what was found, what belongs there, and an example that would
    pass.

    Without a file, `key` names arguments of a call ("cube, centre"), and `passing` has values for
    them that would pass. Here they are spelled as in Python; whoever was asked otherwise, as on the
    command line, spells them so.
    """

    file: str
    key: str
    found: str
    expected: str
    example: str = ""
    nearest: str = ""
    passing: tuple[tuple[str, object], ...] = field(default=(), kw_only=True)

    def __str__(self) -> str:
        """Lay the mistake out as a short block that a person can act on."""
        lines = [": ".join(part for part in (self.file, self.key) if part)]
        lines.append(f"  found     {self.found}")
        lines.append(f"  expected  {self.expected}")
        example = self.example or ", ".join(
            f"{name} = {_literal(value)}" for name, value in self.passing
        )
        if example:
            lines.append(f"  example   {example}")
        if self.nearest:
            lines.append(f"  did you mean '{self.nearest}'?")
        return "\n".join(lines)


def _literal(value: object) -> str:
    """Write a value as Python code, text in double quotes."""
    if isinstance(value, str):
        return f'"{value}"'
    return f"({', '.join(map(_literal, value))})" if isinstance(value, tuple) else str(value)


class LostmotionError(Exception):
    """Anything this package refuses to do, reported in one message for the user.

    Names and paths may come from a stranger's file: control characters in the message are written
    out, so that a terminal obeys none of them.
    """

    def __init__(self, message: object = "") -> None:
        """Keep the message."""
        super().__init__(legible(str(message)))


class InputError(LostmotionError, ValueError):
    """Input that cannot be used; `problems` holds every mistake, not only the first."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        """Keep the mistakes and say them all at once."""
        self.problems = tuple(problems)
        count = len(self.problems)
        head = "1 mistake" if count == 1 else f"{count} mistakes"
        super().__init__(head + "\n" + "\n".join(str(problem) for problem in self.problems))


class Mistakes:
    """Mistakes collected one after the other, reported together by an InputError where `with
    Mistakes() as mistakes:` ends.
    """

    def __init__(self) -> None:
        """Begin without any."""
        self._problems: list[Problem] = []

    def of(self, read: Callable[P, T], *given: P.args, **named: P.kwargs) -> T:
        """Return what `read` makes of these; where it refuses them, keep its mistakes and return
        None, which never reaches the caller.
        """
        try:
            return read(*given, **named)
        except InputError as error:
            self._problems += error.problems
            return cast("T", None)

    def __enter__(self) -> Self:
        """Begin to read."""
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Raise InputError with all mistakes, unless another exception is under way."""
        if kind is None and self._problems:
            raise InputError(self._problems)


class OutputExistsError(LostmotionError):
    """The output folder is already there; nothing in it was touched."""


class DidNotConvergeError(LostmotionError):
    """A law found no answer to the stated tolerance."""


def refuse_argument(name: str, found: object, expected: str, /, **passing: object) -> InputError:
    """Return the error for one argument of a call, or several ("cube, centre"), with values by
    argument that would pass.
    """
    return InputError(
        [
            Problem(
                "",
                name,
                "nothing" if found is None else shown(found),
                expected,
                passing=tuple(passing.items()),
            )
        ]
    )


def nearest(word: str, known: Iterable[str]) -> str:
    """Return the known name that was probably meant. Empty where none is close."""
    close = difflib.get_close_matches(word, list(known), n=1, cutoff=0.6)
    return close[0] if close else ""


# Categories of characters that a terminal obeys, hides or has no shape for: controls, formats,
# halves of characters, separators of lines, private and unassigned ones.
_UNSEEN: Final = frozenset({"Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp"})


def legible(text: str) -> str:
    r"""Write out what a terminal would obey or not show, "\x1b" for an escape; line breaks stay."""
    if text.isascii() and text.replace("\n", "").isprintable():
        return text
    return "".join(
        ascii(char)[1:-1] if char != "\n" and unicodedata.category(char) in _UNSEEN else char
        for char in text
    )


def shown(value: object, limit: int = 60) -> str:
    """Show a value from a file within one line, whatever it holds."""
    text = repr(value) if isinstance(value, str) else str(value)
    text = "".join(char if char.isprintable() else "?" for char in text)
    return text if len(text) <= limit else text[: limit - 3] + "..."
