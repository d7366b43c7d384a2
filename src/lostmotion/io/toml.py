"""TOML text as a tree of tables, lists and values; whatever cannot be read is one clear mistake."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, NoReturn

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import refuse_all
from lostmotion.io.text import read_text, refuse

MEGABYTES: Final = 5
# No arm needs any of these; without these bounds dotted keys of a hostile file take minutes, and
# deep tables break whatever walks them.
_LONGEST_LINE: Final = 1000
_LONGEST_TEXT: Final = 1_000_000
_DEEPEST: Final = 16
# Rows of numbers are counted apart: the covariance of 500 estimates has 250 000, in long lines.
_MOST_COMMAS: Final = 300_000
# No two neighbours of the pattern match the same letter, or a hostile line would take hours.
_NUMBER: Final = r"[-+]?[\d_]+(?:\.[\d_]+)?(?:[eE][-+]?\d+)?"
_ROW_OF_NUMBERS: Final = re.compile(
    rf"(?:\s*\w+\s*=)?[\[\s]*(?:{_NUMBER}[\],\[\s]+)*(?:{_NUMBER})?"
)

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
    _refuse_size(file, text)
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


def _refuse_size(file: str, text: str) -> None:
    if text.count(",") > _MOST_COMMAS:
        refuse(file, "", "lists of more than 300 000 values", "at most 300 000", "[1.0, 2.0, 3.0]")
    others = 0
    for number, line in enumerate(text.splitlines(), 1):
        if "," in line and _ROW_OF_NUMBERS.fullmatch(line):
            continue
        others += len(line)
        if others > _LONGEST_TEXT:
            refuse(
                file,
                "",
                "more than 1 MB",
                "at most 1 MB, rows of numbers apart",
                "one arm, or one table of poses, per file",
            )
        if len(line) > _LONGEST_LINE:
            refuse(
                f"{file}:{number}",
                "",
                f"a line of {len(line)} characters",
                f"lines of at most {_LONGEST_LINE} characters",
                "one key per line",
            )


def content(name: str, stated: Mapping[Any, Any]) -> dict[str, Any]:
    """Return what a dictionary of Python states as `read_toml` returns a file's content: lists for
    tuples and arrays, Python's numbers for NumPy's, text for paths.

    Raises InputError with every key and value that a file could not hold; `name` stands in the
    place of the file.
    """
    mistakes: list[Problem] = []

    def plain(value: Any, key: str, depth: int) -> Any:  # noqa: ANN401 - whatever a user passes
        value = value.tolist() if hasattr(value, "tolist") else value
        if depth > _DEEPEST:
            _refuse_depth(name)
        if isinstance(value, Mapping):
            return {
                each: plain(inner, f"{key}.{key_step(each)}".strip("."), depth + 1)
                for each, inner in value.items()
                if is_text(each, key)
            }
        if isinstance(value, list | tuple):
            return [plain(inner, f"{key}[{k}]", depth + 1) for k, inner in enumerate(value)]
        if isinstance(value, Path):
            return str(value)
        if not isinstance(value, str | bool | int | float):
            expected = "text, a number, true or false, a list or a dictionary"
            mistakes.append(Problem(name, key, shown(value), expected, '"400 mm"'))
        return value

    def is_text(each: object, key: str) -> bool:
        if not isinstance(each, str):
            mistakes.append(Problem(name, key, f"the key {shown(each)}", "text", '"A"'))
        return isinstance(each, str)

    tree: dict[str, Any] = plain(stated, "", 0)
    if mistakes:
        refuse_all(mistakes)
    return tree


def source_of(name: str, source: Path | Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return what messages call a file or a dictionary, the latter by `name`, and its content.
    Raises InputError as `read_toml` and `content`.
    """
    if isinstance(source, Mapping):
        return name, content(name, source)
    return str(source), read_toml(source)


def request_of(source: Path | Mapping[str, Any], table: str) -> tuple[str, dict[str, Any]]:
    """Return the same of a request, whose dictionary may be that of the file or of its table
    alone.
    """
    file, tree = source_of("by", source)
    return file, {table: tree} if isinstance(source, Mapping) and table not in tree else tree


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
