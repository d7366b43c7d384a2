"""Names of a stranger's file in what others open: spreadsheets compute nothing, Markdown shows no
link, picture or HTML.
"""

from __future__ import annotations

import csv
import io
import re
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import pytest

import lostmotion
from lostmotion.analyses.export.model import c_files, controller
from lostmotion.reporting.sheet import Cell, Row, Section
from lostmotion.reporting.table_files import table_files

EXAMPLES = Path(__file__).parents[2] / "examples"
FORMULAS = [
    "=cmd|' /C calc'!A0",
    "+1+1",
    "-2+3",
    "@SUM(1)",
    "\t=1",
    "\r=1",
    "＝1",
    " =1",
    "A;=1",
    "A;\t@x",
    '=HYPERLINK("http://x")',
]


def cells(text: str) -> list[str]:
    """Return the cells of a CSV as any spreadsheet divides it: at commas, and at semicolons and
    tabulators within.
    """
    return [
        cell
        for row in csv.reader(io.StringIO(text, newline=""))
        for whole in row
        for cell in re.split(r"[;\t\r\n]", whole)
    ]


def is_formula(cell: str) -> bool:
    """Return whether a spreadsheet computes a cell; a number is only a number."""
    try:
        float(cell)
    except ValueError:
        return cell.strip()[:1] in tuple("=+-@＝＋－＠")
    return False


@pytest.mark.parametrize("name", FORMULAS)
def test_no_cell_is_a_formula_and_numbers_stay_numbers(name):
    """In every place of a table: label, heading, text in place of a number, unit and note."""
    row = Row(
        name,
        (Cell(-1.5, "mm", -2.5, -0.5), Cell(0.0, name), Cell(0.0, "1", words=name)),
        note=name,
    )
    text = table_files(
        SimpleNamespace(sections=(Section("key", "title", ("x", name, "y"), (row,)),)), "csv"
    )["tables/key.csv"].decode()
    assert [cell for cell in cells(text) if is_formula(cell)] == []
    assert {"-1.5", "-2.5", "-0.5"} <= set(cells(text))
    assert text.count(name.strip()[-1:]) >= 4


def hostile(name: str) -> lostmotion.Arm:
    """Return an arm with a hostile name of itself and of a joint."""
    arm = lostmotion.read(EXAMPLES / "planar-2r.toml")
    first, *others = arm.joints
    return arm.model_copy(
        update={"name": name, "joints": (first.model_copy(update={"name": name}), *others)}
    )


@cache
def readme_of(name: str, *remarks: str) -> str:
    """Return the README of the exported model of an arm of this name."""
    arm = hostile(name)
    return c_files(controller(arm), arm, [*remarks], "0" * 64, single=False)["README.md"]


def test_no_table_of_a_study_has_a_formula():
    """Every section of a study of an arm whose names are formulas."""
    study = lostmotion.study(hostile("=cmd|calc!A0"), poses=16, robots=8, visits=2)
    files = table_files(study.sheet, "csv")
    assert len(files) > 3
    assert any("'=cmd" in content.decode() for content in files.values())
    assert [
        cell for content in files.values() for cell in cells(content.decode()) if is_formula(cell)
    ] == []


@pytest.mark.parametrize(
    "name",
    [
        "<script>alert(1)</script>",
        "[click](http://example.org)",
        "![x](http://example.org/x.png)",
        "http://example.org",
        "a | b | c",
        "`code",
        "*bold* _slanted_ ~~gone~~",
        "# head",
        "a\nb",
        "x\n\n# head",
        "\x1b[31mred",
        "&lt;b&gt;",
        "{poses}",
        "\\<b>",
    ],
)
def test_the_readme_of_a_model_shows_names_as_they_stand(name):
    """Rendered by a Markdown parser the names are plain text: no link, picture, HTML, head,
    emphasis or further cell.
    """
    from markdown_it import MarkdownIt

    readme, plain = (readme_of(each, f"joint {each}: doubtful") for each in (name, "name"))

    def kinds(text: str) -> list[str]:
        tokens = MarkdownIt("gfm-like", {"linkify": False}).parse(text)
        return [
            each.type
            for token in tokens
            for each in (token, *(token.children or ()))
            if each.type not in ("text", "text_special")
        ]

    assert kinds(readme) == kinds(plain)
    assert "\x1b" not in readme
    assert re.search(r"(?<!\\)://example", readme) is None


def test_an_ordinary_name_is_not_changed():
    """Letters, digits, underscores within a word, and signs of units."""
    readme = readme_of("shoulder_pan-2 (left)")
    assert "# Error model of shoulder_pan-2 (left)\n" in readme
