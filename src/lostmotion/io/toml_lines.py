"""Line numbers in messages about TOML files: the line of the key that a mistake names.

Files are read by `tomllib`, which keeps no positions. The lines are looked up only where there is a
mistake to report.
"""

from __future__ import annotations

import functools
import re
import tomllib
from contextlib import suppress
from dataclasses import replace
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, ParamSpec, TypeAlias, TypeVar

from lostmotion.errors import InputError
from lostmotion.io.limits import MORE
from lostmotion.io.text import read_text
from lostmotion.io.toml import MEGABYTES, key_steps

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from lostmotion.errors import Problem

P = ParamSpec("P")
T = TypeVar("T")
Steps: TypeAlias = tuple[str | int, ...]

_ENDING: Final = ".toml"
# Strings (the four kinds), comments, line breaks, the marks of tables and lists, and runs of
# anything else.
_TOKEN: Final = re.compile(
    r"""
    \"{3}(?:[^\\]|\\.)*?\"{3,5} | '{3}.*?'{3,5} | "(?:[^"\\]|\\.)*" | '[^']*'
    | \#[^\n]* | \n | [\[\]{},=.] | [^\s\[\]{},=.\#"']+
    """,
    re.DOTALL | re.VERBOSE,
)
_INDEX: Final = re.compile(r"\[(\d+)\]")
# Where a value without brackets ends.
_ENDS: Final = frozenset({",", "]", "}", "\n"})


def names_lines(read: Callable[P, T]) -> Callable[P, T]:
    """Make a function that reads files name the line, FILE:LINE, in its mistakes about TOML
    files.
    """

    @functools.wraps(read)
    def with_lines(*given: P.args, **named: P.kwargs) -> T:
        try:
            return read(*given, **named)
        except InputError as error:
            located = _located(error.problems)
            if located == error.problems:
                raise
            raise InputError(located) from error

    return with_lines


def key_lines(text: str) -> dict[Steps, int]:
    """Return the line of every key and list entry of a valid TOML text. Steps are keys, and
    positions in lists from 0.
    """
    scan = _Scan(text)
    scan.document()
    return scan.lines


def _located(problems: tuple[Problem, ...]) -> tuple[Problem, ...]:
    """Return the mistakes with the lines of their keys, those of a file in the order of its lines;
    others stay as they are, before them.
    """
    files = dict.fromkeys(
        each.file for each in problems if each.key and Path(each.file).suffix.lower() == _ENDING
    )
    known: dict[str, tuple[dict[Steps, int], dict[str, Any]]] = {}
    for file in files:
        with suppress(InputError, ValueError, RecursionError):
            text = read_text(Path(file), MEGABYTES)
            known[file] = (key_lines(text), tomllib.loads(text))
    out = [each for each in problems if each.file not in known]
    for file, where in known.items():
        lines = [
            (_line(each.key, *where), each)
            for each in problems
            if each.file == file and each.key != MORE
        ]
        # a mistake in a leg, which is written once, is one mistake of all its copies
        once: dict[tuple[Steps, str, str], tuple[int, Problem]] = {}
        for line, each in sorted(lines, key=itemgetter(0)):
            steps = _by_position(_steps(each.key), where[1])
            once.setdefault((steps, each.found, each.expected), (line, each))
        out += [replace(each, file=f"{file}:{line}") for line, each in once.values()]
    return (*out, *(each for each in problems if each.file in known and each.key == MORE))


def _line(key: str, lines: dict[Steps, int], tree: dict[str, Any]) -> int:
    """Return the line of a key as messages spell it (joints by name), or of the innermost table
    around it that the file has; 1 without one.
    """
    steps = _by_position(_steps(key), tree)
    return next(
        (lines[steps[:length]] for length in range(len(steps), 0, -1) if steps[:length] in lines), 1
    )


def _steps(key: str) -> Steps:
    out: list[str | int] = []
    for step in key_steps(key):
        name, bracket, _ = step.partition("[")
        indices = _INDEX.findall(step) if bracket else []
        out += [name, *map(int, indices)] if indices else [step]
    return tuple(out)


def _by_position(steps: Steps, tree: dict[str, Any]) -> Steps:
    """Replace the name of a joint by its position where the joints are a list, and a closure that
    no table states by what states it in a leg.
    """
    if steps[:1] == ("closures",):
        return _of_loop(steps, tree)
    joints = tree.get("joints")
    if len(steps) < 2 or steps[0] != "joints" or not isinstance(joints, list):  # noqa: PLR2004 - the table and the name
        return steps
    index = next(
        (
            index
            for index, joint in enumerate(joints)
            if isinstance(joint, dict) and joint.get("name") == steps[1]
        ),
        None,
    )
    if index is not None:
        return ("joints", index, *steps[2:])
    return _of_leg(steps, tree.get("legs"))


def _of_leg(steps: Steps, legs: Any) -> Steps:  # noqa: ANN401 - whatever a file holds
    """Replace the name of a joint of a copy, COPY_NAME, by the place of what is stated: in the copy
    itself, or else in the joint of the leg, which all copies share.
    """
    with suppress(KeyError, TypeError):  # a leg without joints or names
        for k, leg in enumerate(legs):
            for j, joint in enumerate(leg["joints"]):
                for i, each in enumerate(leg["copies"]):
                    if f"{each['name']}_{joint['name']}" != steps[1]:
                        continue
                    of_copy: Steps = ("legs", k, "copies", i)
                    key = steps[2] if len(steps) > 2 else ""  # noqa: PLR2004 - joints, its name, its key
                    if key in each.get(joint["name"], {}):
                        return (*of_copy, joint["name"], *steps[2:])
                    own = "place" if key == "origin" else key
                    if j == 0 and own in {"place", "after"} and own in each:
                        return (*of_copy, own, *steps[3:])
                    return ("legs", k, "joints", j, *steps[2:])
    return steps


def _of_loop(steps: Steps, tree: dict[str, Any]) -> Steps:
    """Replace the position of a closure, which counts those of all copies of the legs behind the
    stated ones, by the place in the leg.
    """
    with suppress(KeyError, TypeError, AttributeError):  # legs that are no such tables
        left = int(steps[1] if len(steps) > 1 else 0) - len(tree.get("closures", []))
        if left < 0:
            return steps
        places: list[Steps] = []
        for k, leg in enumerate(tree["legs"]):
            own: list[Steps] = [("closures", c) for c in range(len(leg.get("closures", [])))]
            own += [("joins",)] * ("joins" in leg)
            places += [("legs", k, *each) for each in own] * len(leg["copies"])
        return places[left] if left < len(places) else steps
    return steps


class _Scan:
    """A walk through the tokens of a TOML text that `tomllib` accepts, which notes the line of
    every key.
    """

    def __init__(self, text: str) -> None:
        self.lines: dict[Steps, int] = {}
        self._tokens: list[tuple[str, int]] = []
        self._at = 0
        self._last: dict[Steps, int] = {}  # index of the last table of each list of tables
        line, end = 1, 0
        for match in _TOKEN.finditer(text):
            line += text.count("\n", end, match.start())
            end = match.start()
            if not match[0].startswith("#"):
                self._tokens.append((match[0], line))

    def document(self) -> None:
        """Walk through tables and pairs of a key and a value."""
        table: Steps = ()
        while self._at < len(self._tokens):
            mark, line = self._tokens[self._at]
            if mark == "\n":
                self._at += 1
            elif mark == "[":
                table = self._header(line)
            else:
                self._pair(table)

    def _header(self, line: int) -> Steps:
        is_list = self._tokens[self._at + 1][0] == "["
        self._at += 1 + is_list
        steps = self._key("]")
        self._at += is_list
        path: Steps = ()
        for k, step in enumerate(steps, 1):
            path = (*path, step)
            self._note(path, line)
            if k == len(steps) and is_list:
                self._last[path] = self._last.get(path, -1) + 1
            if path in self._last:
                path = (*path, self._last[path])
                self._note(path, line)
        return path

    def _pair(self, table: Steps) -> None:
        line = self._tokens[self._at][1]
        steps = self._key("=")
        for length in range(1, len(steps) + 1):
            self._note((*table, *steps[:length]), line)
        self._value((*table, *steps))

    def _key(self, end: str) -> list[str]:
        out = []
        while (step := self._next()) != end:
            if step != ".":
                out.append(_unquoted(step))
        return out

    def _value(self, path: Steps) -> None:
        opening = self._tokens[self._at][0]
        if opening == "[":
            self._at += 1
            index = 0
            while (token := self._tokens[self._at])[0] != "]":
                if token[0] in _ENDS:
                    self._at += 1
                    index += token[0] == ","
                else:
                    self._note((*path, index), token[1])
                    self._value((*path, index))
            self._at += 1
        elif opening == "{":
            self._at += 1
            while (token := self._tokens[self._at])[0] != "}":
                if token[0] in _ENDS:
                    self._at += 1
                else:
                    self._pair(path)
            self._at += 1
        else:
            while self._at < len(self._tokens) and self._tokens[self._at][0] not in _ENDS:
                self._at += 1

    def _next(self) -> str:
        self._at += 1
        return self._tokens[self._at - 1][0]

    def _note(self, path: Iterable[str | int], line: int) -> None:
        self.lines.setdefault(tuple(path), line)


def _unquoted(key: str) -> str:
    """Return a key without its quotes."""
    if key[0] == '"':
        return str(next(iter(tomllib.loads(f"{key} = 0"))))
    return key[1:-1] if key[0] == "'" else key
