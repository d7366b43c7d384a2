"""TOML text as a tree of tables, lists and values; whatever cannot be read is one clear mistake."""

from __future__ import annotations

import re
import tomllib
from typing import TYPE_CHECKING, Any, Final, NoReturn

from lostmotion.errors import shown
from lostmotion.io.text import read_text, refuse

if TYPE_CHECKING:
    from pathlib import Path

MEGABYTES: Final = 1
# No arm needs either; without these bounds dotted keys of a hostile file take minutes, and deep
# tables break whatever walks them.
_LONGEST_LINE: Final = 1000
_DEEPEST: Final = 16

# A number and its unit without quotes, as a value or in a list.
_BARE: Final = re.compile(
    r"(?<=[=\[,{])\s*(?P<value>[+\-±]?\s*\d[^,\[\]{}#\"'=]*?[^\d\s,\[\]{}#\"'=.][^,\[\]{}#\"'=]*?)\s*(?=[,\]}#]|$)"
)
_ESCAPED: Final = '"\\'
_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")
_STEP: Final = re.compile(r'(?:"(?P<quoted>(?:[^"\\]|\\["\\])*)"|(?P<bare>[^."][^.]*)|)(?=\.|$)')
_PLACE: Final = re.compile(
    r" \((at line (?P<line>\d+), column (?P<column>\d+)|at end of document)\)$"
)


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file. Raises InputError, with line and column where the text is
    not TOML.
    """
    file, text = str(path), read_text(path, MEGABYTES)
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > _LONGEST_LINE:
            refuse(
                f"{file}:{number}",
                "",
                f"a line of {len(line)} characters",
                f"lines of at most {_LONGEST_LINE} characters",
                "one key per line",
            )
    try:
        tree = tomllib.loads(text)
    except RecursionError:
        _refuse_depth(file)
    except ValueError as error:
        # TOMLDecodeError, and Python's own refusal of integers with thousands of digits
        where = _PLACE.search(str(error))
        place, key = file, ""
        if where is not None:
            place = f"{file}:{where['line'] or len(text.splitlines()) or 1}"
            key = f"column {where['column']}" if where["line"] else "end of file"
            bare = _bare_at(text, where)
            if bare:
                refuse(
                    place,
                    key,
                    f"{shown(bare)[1:-1]} without quotes",
                    "a value with its unit in quotes",
                    f'"{shown(bare)[1:-1]}"',
                )
        if text.lstrip().startswith("<"):
            from lostmotion.io.urdf_xml import refuse_xml

            refuse_xml(text, file)
        expected = "valid TOML"
        refuse(
            place,
            key,
            shown(_PLACE.sub("", str(error)), 90).strip("'\""),
            expected,
            'key = "value"',
        )
    if not _is_shallow(tree):
        _refuse_depth(file)
    return tree


def quoted(text: str) -> str:
    """Write a text as a TOML string; what cannot be printed, which no terminal should get, as a
    question mark.
    """
    return (
        '"'
        + "".join(
            f"\\{char}" if char in _ESCAPED else char if char.isprintable() else "?"
            for char in text
        )
        + '"'
    )


def key_step(name: str) -> str:
    """Write a name as one step of a TOML key: in quotes where it is more than letters, digits, -
    and _.
    """
    return name if _BARE_KEY.fullmatch(name) else quoted(name)


def key_steps(key: str) -> list[str]:
    """Take a dotted key apart; a step in quotes may hold dots. Empty steps stand for what is no
    key.
    """
    steps = []
    at = 0
    while at <= len(key):
        match = _STEP.match(key, at)
        if match is None:
            return [""]
        steps.append(match["bare"] or re.sub(r"\\(.)", r"\1", match["quoted"] or ""))
        at = match.end() + 1
    return steps


def _bare_at(text: str, where: re.Match[str]) -> str:
    """Return the value with its unit that stands without quotes where reading broke off, if that is
    what is wrong there.
    """
    if not where["line"]:
        return ""
    line, column = text.split("\n")[int(where["line"]) - 1], int(where["column"]) - 1
    return next(
        (
            match["value"]
            for match in _BARE.finditer(line)
            if match.start("value") <= column <= match.end("value")
        ),
        "",
    )


def _is_shallow(tree: dict[str, Any]) -> bool:
    level: list[Any] = [tree]
    for _ in range(_DEEPEST):
        level = [
            inner
            for outer in level
            for inner in (outer.values() if isinstance(outer, dict) else outer)
            if isinstance(inner, dict | list)
        ]
    return not level


def _refuse_depth(file: str) -> NoReturn:
    refuse(
        file,
        "",
        "tables or lists nested too deeply",
        f"at most {_DEEPEST} levels",
        'joints = [{ name = "A", link = { length = "400 mm" } }]',
    )
