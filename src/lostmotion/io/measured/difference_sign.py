"""The sign of measured differences, as a comment above the rows of a file states it: `# sign:
commanded - attained`.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from lostmotion.errors import Problem, nearest, shown
from lostmotion.io.limits import listed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.io.measured.table import Header, TextTable

_LINE: Final = re.compile(r"^\s*#\s*sign\s*[:=]\s*(.*?)\s*$", re.IGNORECASE)
_SIGNS: Final = {"attained - commanded": 1, "commanded - attained": -1}
# Other words for the two positions, and for their difference.
_WORDS: Final = {
    **dict.fromkeys(("measured", "actual"), "attained"),
    **dict.fromkeys(("command", "nominal", "target"), "commanded"),
    **dict.fromkeys(("less", "minus", "\N{MINUS SIGN}", "\N{EN DASH}"), "-"),
}


def stated_sign(
    table: TextTable, columns: Header, differences: Sequence[str]
) -> tuple[int, Header]:
    """Return 1 where the file states that its differences are attained less commanded, -1 for the
    reverse, and 0 where it states no sign; and the columns, with the mistakes in that line.

    differences  roles of the columns that the sign is about

    A mapping that negates such a column is refused beside a stated sign: either may be meant.
    """
    lines = ((number, _LINE.match(text)) for number, text in table.comments)
    stated = [(f"line {number}, sign", match[1]) for number, match in lines if match]
    there = [role for role in differences if role in columns.of]
    out, signs = [], set()
    for where, text in stated:
        words = text.lower().replace("-", " - ").split()
        normal = " ".join(_WORDS.get(word, word) for word in words)
        if normal in _SIGNS:
            signs.add(_SIGNS[normal])
        else:
            expected, example = " or ".join(_SIGNS), "# sign: commanded - attained"
            near = nearest(normal, _SIGNS)
            out.append(Problem(table.file, where, shown(text), expected, example, near))
    if signs and not out:
        where = stated[-1][0]
        if len(signs) > 1:
            out.append(Problem(table.file, where, "two different signs", "one for the file"))
        if not there:
            expected = f"a column that it is about, {listed(differences)}, or no such line"
            out.append(Problem(table.file, where, "no differences in the file", expected))
        for role in there:
            if (columns.of[role].factor or 0.0) < 0:
                both = f"a sign, and {role} negated by the mapping"
                out.append(Problem(table.file, where, both, "one of the two"))
    return 0 if out or not signs else signs.pop(), columns._replace(mistakes=columns.mistakes + out)
