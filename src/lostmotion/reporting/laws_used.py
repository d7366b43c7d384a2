"""The laws that the parts of a result rest on, each once, with its source as the docstring of its
module states it.
"""

from __future__ import annotations

import re
import sys
from types import ModuleType
from typing import TYPE_CHECKING, Final

from lostmotion.reporting.sheet import Row, Section, in_words, several

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lostmotion.error_model.given_values import GivenValue

_LAWS: Final = "lostmotion.laws."
_PARTS: Final = "lostmotion.parts."
_WHICH: Final = "the laws for parts of these kinds; which of them apply follows from the values"
# The rest of its paragraph belongs to the source.
_SOURCE: Final = re.compile(r"\bSources?(?: of [a-z ]+)?: (.+?)(?:\n\s*\n|\Z)", re.DOTALL)


def laws_section(given: Iterable[GivenValue]) -> tuple[Section, ...]:
    """Return the table of the laws that the parts with these values use, each with its source; no
    table where no part uses any.
    """
    found: dict[str, str] = {}
    for part in dict.fromkeys(each.part for each in given):
        for law in _laws_of(part):
            words = " ".join((law.__doc__ or "").partition("\n\n")[0].split()).rstrip(".")
            source = _SOURCE.search(law.__doc__ or "")
            if source:
                found.setdefault(words, " ".join(source[1].split()))
    rows = tuple(Row(words, (in_words(source),)) for words, source in found.items())
    folded = f"{several(len(rows), 'law')}, each with its source"
    return (Section("laws", "Laws behind it", ("source",), rows, _WHICH, folded),) if rows else ()


def _laws_of(part: type) -> Iterable[ModuleType]:
    """Yield the modules of laws that the modules of a part and of its base classes use."""
    for base in part.__mro__:
        if base.__module__.startswith(_PARTS):
            names = vars(sys.modules[base.__module__]).values()
            used = (
                each.__name__ if isinstance(each, ModuleType) else getattr(each, "__module__", "")
                for each in names
            )
            yield from (
                sys.modules[name]
                for name in dict.fromkeys(used)
                if isinstance(name, str) and name.startswith(_LAWS)
            )
