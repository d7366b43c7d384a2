"""Docstrings as the reference shows them: questions with the arguments that are joined to them when
they are imported, and tables of names as lists.

`mkdocstrings` loads it (`extensions` in mkdocs.yml); everything else is read from the source.
"""

from __future__ import annotations

import inspect
import re
from typing import Any

import griffe

import lostmotion

QUESTIONS = {f"{home}.{name}": name for name, home in lostmotion.QUESTIONS.items()}
# A row of a table in a docstring: names, two spaces or more, and a text that may go on below.
_ROW = re.compile(r"^(\w+(?:, \w+)*)  +(\S.*(?:\n +\S.*)*)", re.MULTILINE)


class ReferenceDocs(griffe.Extension):
    """Complete what griffe reads from the source."""

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:  # noqa: ANN401 - whatever else is passed
        """Complete the questions, then list the names of every table."""
        for path, name in QUESTIONS.items():
            _complete(pkg[path.removeprefix(f"{pkg.path}.")], getattr(lostmotion, name))
        _list_names(pkg)


def _complete(function: griffe.Function, question: Any) -> None:  # noqa: ANN401 - any function
    """Take docstring and defaults of a question from the function as it is imported."""
    function.overloads = None
    function.docstring = griffe.Docstring(
        inspect.getdoc(question) or "", parent=function, parser=griffe.Parser.numpy
    )
    for name, parameter in inspect.signature(question).parameters.items():
        if parameter.default is not inspect.Parameter.empty:
            function.parameters[name].default = repr(parameter.default)


def _list_names(of: griffe.Object) -> None:
    """Turn the tables of an object's docstring, and of its members', into Markdown lists."""
    if of.docstring:
        of.docstring.value = listed(of.docstring.value)
    for member in of.members.values():
        if not member.is_alias:
            _list_names(member)


def listed(text: str) -> str:
    """Return a docstring whose rows of names are a list in Markdown."""
    rows = _ROW.sub(lambda row: f"- `{row[1]}` {' '.join(row[2].split())}", text)
    return re.sub(r"^((?!- ).+)\n(?=- `)", r"\1\n\n", rows, flags=re.MULTILINE)
