"""Tests to run for the files that were changed: `python -m tests.affected FILE ...` prints them.

A file of the package is followed along imports to the nearest test files, and to those named after
it; a test file stands for itself; of any other file the tests that name it are meant. Without
FILE, those that differ from the last commit are taken.
"""

from __future__ import annotations

import ast
import functools
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import grimp

import lostmotion

if TYPE_CHECKING:
    from collections.abc import Iterable

ROOT = Path(__file__).parents[1]
TESTS = sorted((ROOT / "tests").rglob("test_*.py"))
# Of more tests than these, those in the room of the changed file are enough while work is going on.
FEW = 12
# Started as a program of its own by the other, and imported by nothing.
PROGRAM = ("lostmotion.io.xacro_file", "lostmotion.io.xacro_process")


@functools.cache
def import_graph() -> grimp.ImportGraph:
    """Return the imports of the package and of its tests, names of `lostmotion` included, which
    are loaded when they are first used.
    """
    sys.path.insert(0, str(ROOT))
    try:
        graph = grimp.build_graph("lostmotion", "tests", cache_dir=None)
    finally:
        sys.path.remove(str(ROOT))
    for home in lostmotion.QUESTIONS.values():
        graph.add_import(importer="lostmotion.cli.app", imported=home)
    graph.add_import(importer=PROGRAM[0], imported=PROGRAM[1])
    for home in graph.find_descendants("lostmotion.analyses"):
        for page in _pages(home) & graph.modules:
            graph.add_import(importer=home, imported=page)
    for test in graph.find_descendants("tests"):
        path = _file(test)
        for name in public_names(path.read_text("utf-8")) if path.is_file() else ():
            graph.add_import(importer=test, imported=lostmotion.HOMES[name])
    return graph


def public_names(text: str) -> set[str]:
    """Return the public names of the package that a module uses."""
    return {
        node.attr
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == "lostmotion"
    } & lostmotion.HOMES.keys()


def _pages(module: str) -> set[str]:
    """Return the pages that the results of a module load when they are asked for."""
    path = ROOT / "src" / Path(*module.split(".")).with_suffix(".py")
    text = path.read_text("utf-8") if path.is_file() else ""
    named = re.findall(r'^    page = "([\w.]+)"$', text, re.MULTILINE)
    room = module.rpartition(".")[0]
    return {f"{room}.{page}" for page in named or ["page"] if "Result)" in text}


def affected(files: Iterable[Path], graph: grimp.ImportGraph) -> list[Path]:
    """Return the test files to run for these files, which may be deleted ones."""
    found: set[Path] = set()
    for path in files:
        module = _module(path)
        if path in TESTS:
            found.add(path)
        elif module in graph.modules:
            found |= nearest_tests(module, graph)
        else:
            found |= {test for test in TESTS if path.name in test.read_text("utf-8")}
    return sorted(found)


def nearest_tests(module: str, graph: grimp.ImportGraph) -> set[Path]:
    """Return the tests named after a module, and those that reach it in the fewest steps."""
    stem = module.rpartition(".")[2]
    named = {test for test in TESTS if test.stem.startswith(f"test_{stem}")}
    near: set[Path] = set()
    seen, front = {module}, {module}
    while front and not near:
        front = {
            importer
            for imported in front
            for importer in graph.find_modules_that_directly_import(imported)
        } - seen
        seen |= front
        near = {_file(each) for each in front} & {*TESTS}
    room = ROOT / "tests" / Path(*module.split(".")[1:2])
    in_room = {test for test in near if room in test.parents}
    return named | (in_room if len(near) > FEW and in_room else near)


def _module(path: Path) -> str:
    """Return the name of the module in a file; empty where it is none."""
    for folder in (ROOT / "src", ROOT):
        if path.suffix == ".py" and path.is_relative_to(folder):
            return ".".join(path.relative_to(folder).with_suffix("").parts).removesuffix(
                ".__init__"
            )
    return ""


def _file(module: str) -> Path:
    return ROOT / Path(*module.split(".")).with_suffix(".py")


def _changed() -> list[str]:
    """Return the files that differ from the last commit, new ones included."""
    status = subprocess.run(
        ["git", "status", "--porcelain", "--no-renames", "--untracked-files=all", "-z"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    return [str(ROOT / line[3:]) for line in status.split("\0") if line]


def main(names: list[str]) -> int:
    """Print the tests for these files; 1 where there are none."""
    files = [Path(name).absolute() for name in names or _changed()]
    tests = affected(files, import_graph())
    for test in tests:
        print(test.relative_to(ROOT))  # noqa: T201 - its output
    if not tests:
        print("No test file reaches these files by imports or by name.", file=sys.stderr)  # noqa: T201 - its message
    return 0 if tests else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
