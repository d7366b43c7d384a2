"""Texts of a page: escaped, with numbers and units that stay together."""

from __future__ import annotations

import html
import re
from typing import Final

_UNIT: Final = r"(?:%|[mµnk]?m|m[²³]|k?g|N|°|°C|arcmin|arcsec|rad|deg|K|GPa|MPa|h)(?![\w])"
_BEFORE_A_UNIT: Final = re.compile(rf"(?<=\d) (?={_UNIT})")
_WITHIN_A_UNIT: Final = re.compile(r"(?<=\u202fN) (?=m(?!\w))")
_MINUS: Final = re.compile(r"(?<![\w.\-])-(?=\d)")
# The end of a sentence: before a capital letter or a digit, and not the dots between the ends of a
# range.
_END: Final = re.compile(r"(?<=[^.\s][.!?]) (?=[A-Z0-9])")
# A result within a headline: a number with a unit that is no share, or a range.
_RESULT: Final = re.compile(r"(?:[\d.]+ \.\. )?[-−]?[\d.]+\u202f(?!%)[^ <;:,.)]+")
# A name that fits in every column, and the pieces in which a longer one folds.
_LONGEST: Final = 30
_PIECES: Final = re.compile(r"\S{1,12}\s?|\s+")
NARROW: Final = "\u202f"


def escaped(text: str) -> str:
    """Return the text as HTML that shows it and runs none of it."""
    return html.escape(text)


def spaced(text: str) -> str:
    """Return the text as HTML, numbers with a true minus sign and joined to their units by a narrow
    space that does not break.
    """
    return _MINUS.sub("−", _WITHIN_A_UNIT.sub(NARROW, _BEFORE_A_UNIT.sub(NARROW, escaped(text))))


def foldable(name: str) -> str:
    """Return the name of a part as HTML that folds at its joints; a name that is longer than any
    column also between its words, and within them.
    """
    if len(name) <= _LONGEST:
        return folded(escaped(name))
    return "<wbr>".join(folded(escaped(piece)) for piece in _PIECES.findall(name))


def folded(content: str) -> str:
    """Return HTML in which names of parts fold at their joints; numbers stay whole."""
    return re.sub(r"([._])(?=[^\W\d]\w\w)", r"\1<wbr>", content)


def headline(verdict: str) -> tuple[str, str]:
    """Return the first sentence of a verdict, its first result marked, and the rest, both as
    HTML.
    """
    first, *rest = _END.split(verdict, maxsplit=1)
    return _RESULT.sub(lambda result: f"<em>{result[0]}</em>", spaced(first), count=1), spaced(
        rest[0]
    ) if rest else ""
