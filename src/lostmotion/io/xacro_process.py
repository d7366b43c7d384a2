"""Expand one xacro file by the package xacro: a module of its own process, started by `xacro_file`.

xacro evaluates Python and opens any file that a file names. Here an expression is evaluated only
where its syntax can reach nothing but numbers, text, lists and the properties of the file; and the
process can open files of the project alone.
"""

from __future__ import annotations

import encodings.latin_1  # loaded before the process is confined, which ends all imports
import encodings.utf_8_sig  # noqa: F401 - loaded, not used
import os
import re
import xml.dom.expatbuilder
import xml.dom.minidom
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn
from xml.parsers.expat import ExpatError

import xacro
import xacro.substitution_args as substitution  # with yaml, which a file may use
from xacro import XacroException

from lostmotion.errors import InputError, Problem, nearest, shown
from lostmotion.io.limits import listed
from lostmotion.io.own_process import confine, serve
from lostmotion.io.project_root import MANIFEST, RULE, package_name
from lostmotion.io.text import read_old_text, refuse
from lostmotion.io.xacro_expression import check_plain

if TYPE_CHECKING:
    from collections.abc import Mapping

MEGABYTES: Final = 5
# Functions that xacro offers and that lead from any value to the inside of Python.
_INWARD: Final = ("vars", "type")
# What is replaced here: without these names, another version of xacro would evaluate whatever a
# file says.
_HOOKS: Final = (
    (xacro, "safe_eval"),
    (xacro, "parse"),
    (substitution, "_eval"),
    (substitution, "_eval_find"),
)
_PACKAGE: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_LONGEST_WORDS: Final = 200


class _Arguments(dict[str, str]):
    """Arguments of the file by name, which note the names that it asked for, and those whose values
    it used.
    """

    def __init__(self, stated: Mapping[str, str]) -> None:
        super().__init__(stated)
        self.asked: dict[str, None] = {}
        self.used: dict[str, None] = {}

    def __contains__(self, name: object) -> bool:
        self.asked[str(name)] = None
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked[name] = self.used[name] = None
        return super().__getitem__(name)


class _Expansion:
    """One expansion: the file, the folders that it may read, and what it was doing last, for the
    messages.
    """

    def __init__(self, request: dict[str, Any]) -> None:
        self.file, self.sidecar = str(request["file"]), str(request["sidecar"])
        self.path = Path(os.path.realpath(request["path"]))
        self.arguments = _Arguments(request["arguments"])
        self.root, self.own = Path(request["root"]), Path(request["own"])
        self.name = package_name(self.own)
        self.folders = [str(self.root)]
        self.homes: list[str] = request["homes"]
        self.packages: dict[str, str] = request["packages"]
        self.refused: list[str] = []
        self.absent: dict[str, str] = {}  # where packages would be that are not there
        self.expression = ""

    def run(self) -> str:
        """Return the expanded text."""
        for owner, name in _HOOKS:
            if not callable(getattr(owner, name, None)):
                refuse(
                    self.file,
                    "",
                    "an unknown version of the package xacro",
                    "xacro 2",
                    "pip install 'lostmotion[xacro]'",
                )
        for name in _INWARD:
            xacro._global_symbols["python"].pop(name, None)  # noqa: SLF001 - xacro has no option for it
        xacro.safe_eval, self.evaluate = self._evaluate, xacro.safe_eval
        xacro.parse = self._parse
        substitution._eval, substitution._eval_find = self._substitute, self._find  # noqa: SLF001 - the same
        self.refused = confine(self.folders)
        try:
            document = xacro.process_file(str(self.path), mappings=self.arguments, verbosity=0)
        except Exception as error:  # noqa: BLE001 - expressions of the file raise what they like
            self._refuse(error)
        if self.refused:  # an include that was marked as optional
            self._refuse_place()
        self._check(document)
        text: str = document.documentElement.toxml()
        return text

    def _evaluate(
        self, expression: str, symbols: dict[str, Any], inner: dict[str, Any] | None = None
    ) -> Any:  # noqa: ANN401 - any value
        """Evaluate an expression of the file, as `xacro.safe_eval`, where it is plain."""
        self.expression = expression
        check_plain(expression, self._place())
        return self.evaluate(expression, symbols, inner)

    def _substitute(self, expression: str, context: dict[str, Any]) -> str:
        """Evaluate what stands in $(eval ...)."""
        self.expression = expression
        check_plain(expression, self._place())
        arguments = context["arg"]
        known = {
            **substitution._eval_dict,  # noqa: SLF001
            "arg": lambda name: substitution.convert_value(arguments[name], "auto"),
        }
        return str(
            eval(expression, {"__builtins__": {}}, substitution._DictWrapper(arguments, known))  # noqa: S307, SLF001
        )

    def _find(self, package: str) -> str:
        """Return the folder of a package: by the name in its manifest, else by the name of its
        folder, among the places that are searched.

        A package that is not there is no mistake until a file of it is opened: meshes are not.
        """
        if package == self.name or (self.name and package == self.own.name):
            self.folders.append(str(self.own))
            return str(self.own)
        homes = [Path(home) / package for home in self.homes] if _PACKAGE.fullmatch(package) else []
        found = self.packages.get(package) or next(
            (str(each) for each in homes if (each / MANIFEST).is_file()), None
        )
        if found is None:
            folder = str(self.own.parent / (package if _PACKAGE.fullmatch(package) else "NAME"))
            self.absent[folder] = package
            return folder
        self.folders.append(os.path.realpath(found))
        return found

    def _parse(self, _: object, file: str) -> Any:  # noqa: ANN401 - a document of minidom
        """Return the XML of a file: of bounded size, and without a document type, so that no parser
        meets an entity.
        """
        if not Path(file).exists():
            xacro.filestack.pop()
            raise XacroException(exc=FileNotFoundError(2, "no such file", file))
        if Path(file).is_dir():
            xacro.filestack.pop()
            self._refuse_include("which is a folder", file)
        try:
            text = read_old_text(Path(file), MEGABYTES)[0]
        except InputError:
            xacro.filestack.pop()  # the mistake is in the file that includes it
            raise
        if "<!DOCTYPE" in text:
            line = text.count("\n", 0, text.index("<!DOCTYPE")) + 1
            refuse(
                f"{self._place()}:{line}",
                "",
                "a document type (<!DOCTYPE)",
                "XML without one",
                '<robot name="arm">',
            )
        return xml.dom.minidom.parseString(text)  # noqa: S318 - without a document type

    def _check(self, document: Any) -> None:  # noqa: ANN401 - a document of minidom
        """Refuse arguments that nothing asked for, and a file without a robot."""
        problems = []
        for name in self.arguments.keys() - self.arguments.asked.keys():
            near = nearest(name, self.arguments.asked)
            known = (
                f"an argument of the file: {listed(self.arguments.asked)}"
                if self.arguments.asked
                else "none: the file has no arguments"
            )
            example = near or next(iter(self.arguments.asked), "")
            problems.append(
                Problem(
                    self.sidecar,
                    f"xacro.{name}",
                    "an argument that the file never asks for",
                    known,
                    f'{example} = "..."',
                    near,
                )
            )
        if problems:
            raise InputError(problems)
        if not document.getElementsByTagName("link"):
            expected = "the file that uses the macros, often NAME.urdf.xacro"
            refuse(
                self.file,
                "",
                "definitions of macros and no link: a library for other files",
                expected,
                "arm.urdf.xacro",
            )

    def _refuse(self, error: Exception) -> NoReturn:
        """Raise what went wrong in the words of this project, else in those of xacro."""
        cause: Any = error
        while isinstance(cause, XacroException) and cause.exc is not None:
            cause = cause.exc
        self._refuse_absent([*self.refused, str(getattr(cause, "filename", ""))])
        if self.refused:
            self._refuse_place()
        if isinstance(cause, InputError):
            raise cause
        place = self._place()
        if isinstance(cause, substitution.ArgException):
            others = [name for name in self.arguments.asked if name != str(cause)]
            stated = f", as the other arguments of the file: {listed(others)}" if others else ""
            expected = f"its value in the table [xacro] of {self.sidecar}{stated}"
            refuse(
                place,
                "",
                f"the argument {shown(str(cause))} without a value",
                expected,
                f'[xacro] with {_legible(str(cause), 60)} = "..."',
            )
        if isinstance(cause, FileNotFoundError):
            self._refuse_include("which is not there", str(cause.filename))
        if isinstance(cause, ExpatError):
            refuse(
                f"{place}:{cause.lineno}",
                "",
                str(cause).partition(":")[0],
                "well-formed XML",
                '<robot name="arm"> ... </robot>',
            )
        if isinstance(cause, RecursionError | MemoryError):
            refuse(
                place,
                "",
                "macros or values without end",
                "macros that end",
                '<xacro:if value="${count > 0}">',
            )
        at = (
            f" in {shown('${' + self.expression + '}')}"
            if self.expression and not isinstance(cause, XacroException)
            else ""
        )
        text = (
            cause.msg
            if isinstance(cause, SyntaxError)
            else f"no key {cause}"
            if isinstance(cause, KeyError)
            else str(cause)
        )
        words = _legible(text or type(cause).__name__, _LONGEST_WORDS)
        refuse(
            place,
            "",
            f"{words}{at}",
            f"a file that the program xacro expands{self._empties()}",
            f"xacro {self.path.name} > arm.urdf",
        )

    @property
    def empty(self) -> list[str]:
        """Return the arguments that the file has used and that are empty."""
        return [name for name in self.arguments.used if self.arguments.get(name) == ""]

    def _empties(self) -> str:
        """Return what to add to a message where an argument is empty, which often is the cause."""
        return (
            (
                f"; empty: the argument {listed(self.empty)}, whose value stands in [xacro] of "
                f"{self.sidecar}"
            )
            if self.empty
            else ""
        )

    def _refuse_include(self, why: str, file: str) -> NoReturn:
        """Refuse an include, by its path from the file that includes it where that is not far."""
        beside = (
            Path(os.path.realpath(xacro.filestack[-1])).parent
            if xacro.filestack
            else self.path.parent
        )
        short = os.path.relpath(os.path.realpath(file), beside)
        path = str(file) if short.startswith(3 * f"..{os.sep}") else short
        expected = (
            f"a file in {self.root}, by its path from the file that includes it, or $(find "
            f"PACKAGE)/...{self._empties()}"
        )
        refuse(
            self._place(),
            "",
            f"an include of {shown(path, _LONGEST_WORDS)}, {why}",
            expected,
            'filename="wrist.xacro"',
        )

    def _refuse_absent(self, places: list[str]) -> None:
        """Refuse a place in a package that is not there."""
        for folder, package in self.absent.items():
            place = next((place for place in places if place.startswith(folder)), None)
            if place is not None:
                where = (
                    "the folder of the file's package, the project, AMENT_PREFIX_PATH or "
                    "ROS_PACKAGE_PATH"
                )
                expected = (
                    f"a {MANIFEST} with <name>{_legible(package, 60)}</name> below one of: "
                    f"{where}{self._empties()}"
                )
                wanted = shown(f"$(find {package}){place.removeprefix(folder)}", _LONGEST_WORDS)
                found = f"the package {shown(package)}, which is not there, in {wanted}"
                refuse(
                    self._place(),
                    "",
                    found,
                    expected,
                    str(self.own.parent / "ur_description" / MANIFEST),
                )

    def _refuse_place(self) -> NoReturn:
        expected = (
            f'files in {self.root}: {RULE}; root = ".." in {self.sidecar} names another folder '
            "above"
        )
        refuse(
            self._place(),
            "",
            f"a file that opens {shown(self.refused[0], _LONGEST_WORDS)}",
            expected,
            '<xacro:include filename="wrist.xacro"/>',
        )

    def _place(self) -> str:
        """Return the file that is being expanded, as the user would write it."""
        current = os.path.realpath(xacro.filestack[-1]) if xacro.filestack else str(self.path)
        return (
            self.file
            if current == str(self.path)
            else os.path.normpath(
                Path(self.file).parent / os.path.relpath(current, self.path.parent)
            )
        )


def _legible(text: str, longest: int) -> str:
    """Return text of a file in one line, without quotes."""
    return shown(" ".join(text.split()), longest)[1:-1]


def _answer(request: dict[str, Any]) -> dict[str, Any]:
    expansion = _Expansion(request)
    return {"text": expansion.run(), "empty": expansion.empty}


if __name__ == "__main__":
    serve(_answer)
