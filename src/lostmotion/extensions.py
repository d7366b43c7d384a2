"""Extensions: kinds of parts, figures and questions that other installed packages bring.

A package names each by an entry point: kinds of gearboxes and bearings in the group
`lostmotion.parts`, figures of the error in `lostmotion.figures`, questions in
`lostmotion.questions`. Entry points are looked up when first needed, and only what is used is
loaded.
"""

from __future__ import annotations

import functools
import importlib.util
import os
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from lostmotion.errors import InputError, Problem, legible
from lostmotion.public_names import HOMES

if TYPE_CHECKING:
    from collections.abc import Callable
    from importlib.metadata import EntryPoint

Group: TypeAlias = Literal["parts", "figures", "questions"]
_GROUPS: Final[tuple[Group, ...]] = ("parts", "figures", "questions")
_LONGEST: Final = 200


@dataclass(frozen=True)
class Extension:
    """An entry point of another package, in one of the groups."""

    group: Group
    entry: EntryPoint

    @property
    def name(self) -> str:
        """Return its name."""
        return self.entry.name

    @property
    def package(self) -> tuple[str, str]:
        """Return the name of the package and its version."""
        found = self.entry.dist
        return ("unknown", "") if found is None else (found.name, found.version)

    def load(self, expected: str, fits: Callable[[Any], bool]) -> Any:  # noqa: ANN401 - whatever the package has there
        """Return what the entry point names. Raises InputError where it cannot be loaded, for
        whatever reason, and where it does not fit what is expected.
        """
        try:
            found = self.entry.load()
        except (Exception, SystemExit) as error:
            raise self.refusal(f"{type(error).__name__}: {error}", expected) from error
        if not fits(found):
            raise self.refusal(repr(found), expected)
        return found

    def refusal(self, found: str, expected: str) -> InputError:
        """Return the error that names the package, with what to do."""
        name, version = self.package
        line = next(iter(legible(found).splitlines()), "")
        return InputError(
            [
                Problem(
                    f"package {name} {version}".strip(),
                    f'lostmotion.{self.group}, {self.name} = "{self.entry.value}"',
                    line if len(line) <= _LONGEST else f"{line[:_LONGEST]} ...",
                    expected,
                    f"pip install --upgrade {name}, or pip uninstall {name}",
                )
            ]
        )


def extensions(group: Group) -> dict[str, Extension]:
    """Return the extensions of a group by name. Raises InputError where two packages use the same
    name in any group, and for a question with the name of something else.
    """
    return _extensions(tuple(sys.path))[group]


@functools.lru_cache(maxsize=1)
def _extensions(path: tuple[str, ...]) -> dict[Group, dict[str, Extension]]:
    out: dict[Group, dict[str, Extension]] = {group: {} for group in _GROUPS}
    if not _may_be_declared(path):
        return out
    from importlib.metadata import entry_points

    entries = entry_points()  # once: it reads a file of every package installed
    for group, found in out.items():
        every = [Extension(group, each) for each in entries.select(group=f"lostmotion.{group}")]
        for each in sorted(every, key=lambda each: (each.name, each.package)):
            if each.name in found:
                other = " ".join(found[each.name].package)
                raise each.refusal(f"a name that package {other} uses", "a name of its own")
            if group == "questions" and _is_taken(each.name):
                raise each.refusal("a name of lostmotion itself", "a name of its own")
            found[each.name] = each
    return out


def _may_be_declared(path: tuple[str, ...]) -> bool:
    """Return whether a package on this path may bring extensions. Most often none does, and to load
    `importlib.metadata` and ask it takes a sixth of the time of `--help`.
    """
    for folder in path:
        try:
            inside = os.listdir(folder or ".")  # noqa: PTH208 - names, of which few become paths
        except NotADirectoryError:
            return True  # an archive of packages
        except OSError:
            continue
        for name in inside:
            if name.lower().endswith("-info"):
                with suppress(OSError):
                    declared = Path(folder, name, "entry_points.txt").read_bytes()
                    if b"[lostmotion." in declared:
                        return True
    return False


def _is_taken(name: str) -> bool:
    """Return whether the package has something of this name, or uses it as a command."""
    return (
        name in {*HOMES, "run"}
        or not name.isidentifier()
        or importlib.util.find_spec(f"lostmotion.{name}") is not None
    )


def question_named(name: str) -> Callable[..., Any] | None:
    """Return a question of another package; None where there is none of this name. Raises
    InputError where it cannot be loaded, or is no question.
    """
    extension = extensions("questions").get(name)
    if extension is None:
        return None
    found: Callable[..., Any] = extension.load(
        f"a function {name} marked by lostmotion.analyses.signature.question",
        lambda each: getattr(getattr(each, "question", None), "name", None) == name,
    )
    return found
