"""The first screen on terminals of every width and encoding, and the options that print more or
less.
"""

import io
import json
import re
from pathlib import Path

import pytest
from rich.console import Console

from lostmotion.analyses.result import Result
from lostmotion.reporting.first_screen import print_first_screen
from lostmotion.reporting.sheet import Bar, Bars, Card, Cell, Lines, Row, Section, Sheet
from tests.command import carried_out

EXAMPLES = Path(__file__).parents[2] / "examples"
QUICK = ("--poses", "32", "--robots", "40", "--visits", "2")
SHARES = {"A.gearbox": 0.8, "B.link": 0.4, "C.bearing": -0.2}
BLAME = Bars(
    "budget",
    "Which part is to blame",
    "share",
    tuple(
        Bar(name, Cell(100 * share, "%"), share, Cell(share, "mm"))
        for name, share in SHARES.items()
    ),
    "reduction if halved",
)
ROWS = tuple(Row(f"row {k}", (Cell(float(k), "mm"),)) for k in range(40))
SHEET = Sheet(
    name="Arm",
    subject="",
    about="3 joints",
    verdict="Expect 95 % of positions within 1.27 mm. "
    + "A controller that knows the load leaves less. " * 3,
    cards=(Card("95 % of positions within", "1.27 mm"), Card("reach", "1.68 m")),
    sections=(Section("s", "Table of the rest", ("value",), ROWS),),
    source="",
    warnings=("joint A is overloaded",),
    bars=(BLAME,),
    brief=(("Where", "Best pose: here; worst pose: there. " * 4),),
    lines=Lines("Lines to copy:", "[[joints]]"),
)


def screen(sheet, width=80, encoding="utf-8"):
    """Return what the first screen prints on a terminal of this width and encoding."""
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding=encoding, errors="strict")
    print_first_screen(sheet, Console(file=stream, width=width))
    stream.flush()
    return raw.getvalue().decode(encoding)


@pytest.mark.parametrize("width", [40, 60, 80, 120, 200])
def test_no_line_is_wider_than_the_terminal(width):
    """From 40 to 200 columns every line fits, and answer, warning, bars and lines to copy are
    there.
    """
    text = screen(SHEET, width)
    assert max(map(len, text.splitlines())) <= width
    assert "Expect 95 % of positions within" in " ".join(text.split())
    for words in ("warning: joint A is overloaded", "A.gearbox", "Lines to copy:"):
        assert words in " ".join(text.split())
    assert text.index("Expect") < text.index("Which part") < text.index("Best pose")
    assert "1.68 m" in text
    assert text.count("1.27 mm") == 1  # the headline states it, so no card repeats it


def bars_of(text):
    """Return the length of each bar, and where it begins."""
    lines = [line for line in text.splitlines() if any(name in line for name in SHARES)]
    marks = [[k for k, char in enumerate(line) if char in "#█▏▎▍▌▋▊▉"] for line in lines]
    return [len(each) for each in marks], [each[0] for each in marks]


def test_bars_are_as_long_as_their_sizes():
    """Twice the share is twice the bar, to a column; a negative share stands on the other side of a
    zero line.
    """
    for encoding, zero in (("utf-8", "│"), ("ascii", "|")):
        text = screen(SHEET, 100, encoding)
        (first, second, negative), begins = bars_of(text)
        assert abs(first - 2 * second) <= 2
        assert abs(second - 2 * negative) <= 2
        assert begins[0] == begins[1] > begins[2]
        assert text.count(zero) == 3
    assert screen(SHEET, 100, "ascii").isascii()


def test_a_sheet_without_bars_shows_its_main_table_shortened():
    """The first fifteen rows and how many more there are; a sheet without an answer is its tables,
    whole.
    """
    text = screen(
        Sheet(name="x", subject="", verdict="Yes.", cards=(), sections=SHEET.sections, source="")
    )
    assert "row 14" in text
    assert "row 15" not in text
    assert "and 25 more rows" in text
    assert "row 39" in screen(
        Sheet(name="x", subject="", verdict="", cards=(), sections=SHEET.sections, source="")
    )


def test_figures_in_lines_say_what_they_are_as_far_as_there_is_room():
    """A quiet line stands behind the title where it fits, else what comes before its semicolon,
    else nothing.
    """
    quiet = "slope from 206 N m; 1 % open"
    cards = (
        *(Card(f"wind-up {'x' * 42}", "3.29 arcmin", "y" * 100) for _ in range(3)),
        Card("stiffness", "133 N m/arcmin", quiet),
    )
    sheet = Sheet(name="x", subject="", verdict="Yes.", cards=cards, sections=(), source="")
    for width, text in ((100, quiet), (92, "slope from 206 N m"), (80, "")):
        line = next(line for line in screen(sheet, width).splitlines() if "133 N m/arcmin" in line)
        assert line.split("stiffness")[1].strip() == text
        assert "y" not in screen(sheet, width)


def test_a_table_too_wide_for_the_screen_loses_its_intervals_and_no_figure():
    """On 60 columns the intervals are left to the full output, and every figure is whole; on 200
    they stand beside the figures.
    """
    rows = tuple(
        Row(f"design {k}", tuple(Cell(1.0 + k, "mm", 0.9 + k, 1.1 + k) for _ in range(3)))
        for k in range(2)
    )
    wide = Sheet(
        name="x",
        subject="",
        verdict="Yes.",
        cards=(),
        sections=(Section("s", "Designs", ("mean", "median", "largest"), rows),),
        source="",
    )
    narrow, broad = screen(wide, 60), screen(wide, 200)
    assert max(map(len, narrow.splitlines())) <= 60
    assert "…" not in narrow
    assert broad.count("…") == 6
    for text in (narrow, broad):
        assert len(re.findall(r"\d mm", text)) == 6


def run(*words, cwd, arm="planar-2r"):
    """Run the command in a folder, and return what it prints."""
    return carried_out("run", EXAMPLES / f"{arm}.toml", *QUICK, *words, cwd=cwd).stdout


def test_one_screen_one_line_or_all(tmp_path, monkeypatch):
    """Without an option about one screen, all figures with --full, one line with --quiet, and the
    content of result.json alone with --json.
    """
    # what is printed needs no drawings
    monkeypatch.setattr(Result, "report", lambda _, out, **__: Path(out))
    short = run(cwd=tmp_path, arm="z-arm")
    full, quiet = (run("--out", word[2:], word, cwd=tmp_path) for word in ("--full", "--quiet"))
    data = run("--json", cwd=tmp_path)
    assert len(short.splitlines()) <= 36
    assert max(map(len, short.splitlines()[:-1])) <= 80
    assert "First order against exact composition" in full
    assert "First order against exact composition" not in short
    assert json.loads(data)["answer"] == quiet.rstrip("\n")
    assert quiet.count("\n") == 1
    assert quiet.startswith("Expect 95 % of positions within ")
    assert "\x1b" not in short  # a pipe takes no colours
