"""The page of what each part of the computation is compared with, made of what the tests state in
their constant VALIDATES.

Write the page with `python -m tests.docs.validation > docs/validation.md`.
"""

from __future__ import annotations

import ast
import functools
import sys
from typing import TYPE_CHECKING, NamedTuple

from tests.docs.pages import ROOT

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

SOURCE = ROOT / "src" / "lostmotion"
PAGE = ROOT / "docs" / "validation.md"
INTRODUCTION = """\
# Validation

What each part of the computation is compared with, and how closely they agree. All comparisons run in the test suite. The table is made of the tests:
each module states its comparisons in the constant `VALIDATES`, and a test requires one for every law and for every way to propagate errors.
"""
# Folders of the tests in the order of the page, each with its title.
SECTIONS = {
    "validation": "Published cases and other programs",
    "laws": "Laws of parts",
    "parts": "Parts",
    "catalogue": "Catalogue",
    "io": "Reading files",
    "mechanism": "Mechanism and statics",
    "error_model": "Error model",
    "propagation": "Propagation",
    "calibration": "Calibration",
    "sizing": "Sizes of parts",
    "standards": "Standards",
    "maps": "Accuracy maps",
    "loads": "Loads at rest",
    "analyses": "Analyses",
    "runs": "Big runs",
    "controller_model": "The model in a controller",
    "examples": "Example arms",
    "reporting": "Results",
}


class Comparison(NamedTuple):
    """One comparison: the quantity, what it is compared with, how closely they agree, and the files
    of the source and of the tests.
    """

    quantity: str
    against: str
    within: str
    sources: tuple[str, ...]
    tests: tuple[str, ...]


@functools.cache
def comparisons() -> tuple[Comparison, ...]:
    """Return what the tests state, in the order of the page."""
    order = [*SECTIONS]
    files = sorted((ROOT / "tests").rglob("test_*.py"), key=lambda path: path.name)
    found = [each for path in files for each in _stated(path)]
    return tuple(sorted(found, key=lambda each: order.index(_folder(ROOT / each.tests[0]))))


def _folder(path: Path) -> str:
    return path.relative_to(ROOT / "tests").parts[0]


def _stated(path: Path) -> Iterator[Comparison]:
    """Yield the comparisons of a test module, which is read and not imported."""
    for node in ast.parse(path.read_text("utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "VALIDATES":
            for quantity, against, within, *files in ast.literal_eval(node.value):
                others = " ".join(files).split()
                own = str(path.relative_to(ROOT))
                tests = tuple(name for name in others if name.startswith("tests/"))
                yield Comparison(
                    quantity,
                    against,
                    within,
                    tuple(name for name in others if name not in tests),
                    (own, *tests),
                )


def page() -> str:
    """Return the page as Markdown."""
    found = comparisons()
    lines = [INTRODUCTION]
    for folder, title in SECTIONS.items():
        rows = [each for each in found if _folder(ROOT / each.tests[0]) == folder]
        if rows:
            lines += [
                f"## {title}",
                "",
                "| quantity | compared with | agreement | source | test |",
                "|---|---|---|---|---|",
            ]
            lines += [
                (
                    f"| {each.quantity} | {each.against} | {each.within} | {_links(each.sources)} "
                    f"| {_links(each.tests)} |"
                )
                for each in rows
            ]
            lines.append("")
    return "\n".join(lines)


def _links(names: tuple[str, ...]) -> str:
    return ", ".join(
        f"[{name}](../{name})"
        if name.startswith("tests/")
        else f"[{name}](../src/lostmotion/{name})"
        for name in names
    )


if __name__ == "__main__":
    sys.stdout.write(page())
