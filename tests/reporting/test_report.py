"""The folder a study leaves behind: whole or not at all, the same bytes every time, safe to open,
and nobody else's files touched.
"""

from __future__ import annotations

import functools
import html
import html.parser
import io
import json
import os
import re
import subprocess
import sys
import tempfile
import warnings
from dataclasses import fields, replace
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import xarray
from rich.console import Console

from lostmotion import LostmotionError, OutputExistsError
from lostmotion.analyses.accuracy.page import sections, sheet
from lostmotion.analyses.accuracy.page.plots import plots
from lostmotion.analyses.accuracy.result import Study
from lostmotion.printed import ARCMIN, ARCSEC
from lostmotion.reporting import folder as folder_of_report
from lostmotion.reporting.joint_values import joint_value
from lostmotion.reporting.page.document import page as page_of
from lostmotion.reporting.page.first_screen import first_screen
from lostmotion.reporting.page.text import escaped, foldable, headline, spaced
from lostmotion.reporting.screen import print_sheet
from lostmotion.reporting.sheet import Card, Cell, Row, Section, Sheet
from tests.arms import small_study

HOSTILE = "<script>alert(1)</script>\"'&</title>"


def of_page(page: str) -> html.parser.HTMLParser:
    """Read a page as a browser would: its tags, what they point at, and its scripts."""

    class Reader(html.parser.HTMLParser):
        def __init__(self):
            super().__init__()
            self.tags, self.targets, self.scripts, self.ids = [], [], [], []

        def handle_starttag(self, tag, attrs):
            self.tags.append(tag)
            self.targets += [
                value
                for name, value in attrs
                if name in {"src", "href", "action", "data", "poster", "srcset"}
            ]
            self.ids += [value for name, value in attrs if name == "id"]
            if tag == "script":
                self.scripts.append("")

        def handle_data(self, data):
            if self.lasttag == "script" and self.scripts:
                self.scripts[-1] += data

    reader = Reader()
    reader.feed(page)
    return reader


def write_folder(study, out, *, force=False):
    """Write the report of a study."""
    made = {each.name: getattr(study, each.name) for each in fields(study)}
    return Study(**made).report(out, force=force)


@pytest.fixture
def undrawn(monkeypatch):
    """Write studies without their plots, where the folder is the subject."""
    monkeypatch.setattr(Study, "plots", ())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Write the small study once."""
    return write_folder(small_study(), tmp_path_factory.mktemp("written") / "new" / "deep" / "out")


@pytest.fixture(scope="module")
def page(folder):
    """Read its page."""
    return (folder / "report.html").read_text(encoding="utf-8")


@functools.cache
def drawn():
    """Return the plots of the small study, of which nothing is changed."""
    return plots(small_study())


def left_in(path: Path) -> list[str]:
    """Name everything in a folder, hidden things too."""
    return sorted(entry.name for entry in path.iterdir())


def test_folder_holds_three_files_and_its_parents_are_made(folder):
    """The report lies in the folder that the user named, and nothing beside it."""
    assert left_in(folder) == ["arrays.nc", "report.html", "result.json"]
    assert left_in(folder.parent) == ["out"]


def test_same_study_gives_the_same_bytes_on_any_threads(folder, tmp_path):
    """Run twice, on one thread and on two: every file is the same to the byte."""
    again = write_folder(small_study(threads=2), tmp_path / "again")
    for name in left_in(folder):
        assert (again / name).read_bytes() == (folder / name).read_bytes(), name


def test_page_stays_small_enough_to_mail(folder):
    """The page with its charts stays under 600 kB."""
    assert (folder / "report.html").stat().st_size < 600e3


def test_every_figure_on_screen_is_in_result_json(folder):
    """Whatever number the terminal shows, a program can read from result.json, with its unit."""
    plain = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    known = set()
    for row in (row for section in plain["sections"] for row in section["rows"]):
        for figure in row["figures"]:
            known.add(figure["display"])
            assert figure["samples"] or figure["words"]
    screen = io.StringIO()
    print_sheet(sheet(small_study()), Console(file=screen, width=250))
    shown = {
        figure.display
        for section in sheet(small_study()).sections
        for row in section.rows
        for figure in row.cells
    }
    assert shown == known
    said = json.dumps(plain, ensure_ascii=False)
    for shown_number in re.findall(
        r"(?<!\S)(?:[≥≤] )?[-<]?[\d.]+ (?:µm|mm|m³|m|%|arcmin|N m|N)(?!\S)", screen.getvalue()
    ):
        assert shown_number in said, shown_number


def test_tables_fit_a_terminal_of_80_columns():
    """Long labels, four figures with units and two intervals; a word wider than its column is never
    cut, and no column of remarks stands empty.
    """
    plain = Cell(49.25 / ARCMIN, "N m/arcmin")
    between = Cell(49.25 * ARCSEC, "arcsec", 45.0 * ARCSEC, 53.0 * ARCSEC)
    for figures, columns in (
        ((between,) * 2, ("now", "with equal effect")),
        ((*(plain,) * 3, Cell(0.2737, "%")), ("now", "equal factor", "equal effect", "share")),
    ):
        rows = tuple(Row(f"joints.B.gearbox stiffness {k}", figures) for k in range(3))
        screen = io.StringIO()
        shown = replace(
            sheet(small_study()),
            sections=(Section("one", "One", columns, rows),),
            verdict="",
            notes=(),
        )
        print_sheet(shown, Console(file=screen, width=80))
        lines = screen.getvalue().splitlines()
        assert max(map(len, lines)) <= 80
        assert sum(str(figures[0]) in line for line in lines) == 3
    screen = io.StringIO()
    print_sheet(sheet(small_study()), Console(file=screen, width=80))
    assert max(map(len, screen.getvalue().splitlines())) <= 80


def test_every_figure_is_in_the_tables(page):
    """The report prints each value and interval that the screen prints."""
    for section in sections(small_study()):
        for row in section.rows:
            assert escaped(row.label) in page.replace("<wbr>", "")
            for figure in row.cells:
                assert spaced(str(figure)) in page
                assert spaced(figure.interval) in page


def test_verdict_speaks_of_what_was_asked(page):
    """The headline is the 95 % error, its number marked, with the largest contributor; how well
    robots repeat stands below it.
    """
    found = re.search(r"<h1>(.*?)</h1>(.*?)<nav", page, re.DOTALL)
    assert found
    assert re.match(
        r"(Expect 95\u202f% of positions within|At least) <em>[\d.]+\u202f[mµ]m</em>", found[1]
    )
    assert "argest contributor: O." in found[1] + found[2]
    assert "RP, ISO cycle" in found[2]
    assert not re.search(r"\d (%|mm|µm)", found[1]), "a number and its unit could be torn apart"


def test_a_range_stands_whole_in_a_headline():
    """The two dots between the ends of a range end no sentence, and the marked result is the whole
    range.
    """
    first, rest = headline(
        "Stiffness 0.0237 .. 0.131 N m/arcmin (5-95 %), middle 0.063. Play 78.9 arcmin. 2 % jam."
    )
    assert (
        first
        == "Stiffness <em>0.0237 .. 0.131\u202fN\u202fm/arcmin</em> (5-95\u202f%), middle 0.063."
    )
    assert rest == "Play 78.9\u202farcmin. 2\u202f% jam."


def test_the_unit_of_a_key_figure_is_never_torn():
    """Where a card is too narrow, the line breaks before the unit."""
    cards = (Card("mean", "0.6654 mm"), Card("k", "69.8 N m/arcmin"))
    sheet = Sheet(name="arm", subject="", verdict="", cards=cards, sections=(), source="")
    shown = first_screen(sheet, [], "0")
    assert "0.6654\u202f<wbr>mm<" in shown
    assert "69.8\u202f<wbr>N\u202f<wbr>m/<wbr>arcmin<" in shown


def test_a_name_of_any_length_folds():
    """A name of 80 letters without a gap, of words or with brackets folds in a narrow column and
    loses no letter; a usual one only at its joints.
    """
    for name in (
        "abcdefghij" * 8,
        "the long arm of the robot <b>on the left</b> & \N{ROBOT FACE}",
        "a" * 20 + "\t" + "b" * 20,
    ):
        pieces = foldable(name).split("<wbr>")
        assert "".join(pieces) == escaped(name)
        assert max(len(html.unescape(piece)) for piece in pieces) <= 13
    assert foldable("O.gearbox") == "O.<wbr>gearbox"
    assert foldable("joints") == "joints"


def test_a_joint_value_that_rounds_to_zero_has_no_sign():
    """A joint a hair below zero stands at 0.0°."""
    assert joint_value("A", "revolute", -1e-6) == "A 0.0°"
    assert joint_value("A", "prismatic", -1e-6) == "A 0.0 mm"
    assert joint_value("A", "revolute", -0.1) == "A -5.7°"


def test_page_asks_nothing_of_the_network(page):
    """Opened from a disk without a net, the page is complete: it points only into itself and at its
    two neighbours.
    """
    targets = of_page(page).targets
    assert targets
    assert {target for target in targets if not target.startswith("#")} == {
        "result.json",
        "arrays.nc",
    }
    assert "default-src 'none'" in page
    assert not re.search(r"@import|url\(", page[: page.index("<body")])


def test_every_plot_has_its_place_and_its_words(page):
    """Each plot has an element of its own, ids are unique, and a screen reader is given a
    description of it.
    """
    reader = of_page(page)
    wanted = [plot.key for plot in drawn()]
    assert len(wanted) == 12
    assert len(set(reader.ids)) == len(reader.ids)
    assert {f"plot-{key}" for key in wanted} <= set(reader.ids)
    # and the bars of what RP is made of, for each approach
    assert page.count(' role="img" aria-label="') == 12 + 2


def test_hostile_names_are_shown_not_run():
    """An arm from an unknown source may call itself a script; the page and the notebook show the
    name and run nothing.
    """
    study = small_study(16, 8, 2, name=HOSTILE)
    # a plot shows no name; that its own texts are no markup is tested below
    page = page_of(sheet(study), drawn()[:1], "0")
    reader = of_page(page)
    assert not any("alert(1)" in script for script in reader.scripts)
    assert reader.tags.count("script") == 3  # what the viewer draws, its code, and the loader
    assert "<script>alert" not in page
    assert "<script>alert" not in study._repr_html_()
    assert reader.tags.count("title") == 1


def test_text_of_a_plot_is_no_markup():
    """Text inside a plot holds no bracket that a browser would read as a tag, and is still the same
    text, though it looks like an attribute.
    """
    from lostmotion.reporting.chart import one
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.svg import inline_svg, raw_svg, with_plain_fonts

    hostile = '</svg><script>alert(1)</script>&amp; style="fill: #abcdef" id="a" x="1.23456" url(#b) font-family: \N{ROBOT FACE}'
    figure, _ = one(hostile, 60)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ET.fromstring(with_plain_fonts(raw_svg(figure))) is not None  # noqa: S314 - made here
    reader = of_page(inline_svg(Plot("k", "s", figure, hostile)))
    assert "script" not in reader.tags
    assert hostile in [
        text.strip()
        for text in ET.fromstring(inline_svg(Plot("k", "s", figure, hostile))).itertext()  # noqa: S314
    ]


def test_arrays_read_back_with_units(folder):
    """Every variable in arrays.nc says its unit and what it is, and holds the study's own
    numbers.
    """
    with xarray.open_dataset(folder / "arrays.nc", engine="scipy") as read:
        assert read.sizes["pose"] == 64
        assert read.sizes["robot"] == 32
        for name, variable in read.data_vars.items():
            assert variable.attrs["units"], name
            assert variable.attrs["long_name"], name
        assert (read["tool"].values == small_study().tool).all()
        assert read.attrs["arm"] == "test arm"


def test_existing_folder_needs_force(folder):
    """Results once written are not lost to a second run: it refuses and says what to do."""
    before = (folder / "result.json").stat().st_mtime_ns
    with pytest.raises(OutputExistsError, match=r"exists\n.*--force.*--out"):
        write_folder(small_study(), folder)
    assert (folder / "result.json").stat().st_mtime_ns == before


@pytest.mark.usefixtures("undrawn")
def test_force_replaces_our_own_folder(tmp_path):
    """With --force the new results stand where the old ones stood, and nothing is left beside
    them.
    """
    target = tmp_path / "out"
    target.mkdir()
    (target / "result.json").write_text("old")
    write_folder(small_study(), target, force=True)
    assert json.loads((target / "result.json").read_text(encoding="utf-8"))["arm"] == "test arm"
    assert left_in(tmp_path) == ["out"]


@pytest.mark.parametrize("stranger", ["thesis.tex", ".git", "report.html/"])
def test_force_spares_what_is_not_ours(tmp_path, stranger):
    """--out pointed at the wrong folder by mistake: not even --force removes it, and the message
    names what is there.
    """
    target = tmp_path / "home"
    target.mkdir()
    if stranger.endswith("/"):
        (target / stranger).mkdir()
    else:
        (target / stranger).write_text("years of work")
    with pytest.raises(OutputExistsError, match="not ours") as refused:
        write_folder(small_study(), target, force=True)
    assert repr(stranger.rstrip("/")) in str(refused.value)
    assert left_in(target) == [stranger.rstrip("/")]


def test_force_spares_an_arm_whose_file_has_a_name_of_ours(tmp_path):
    """A folder with robot.toml and poses.csv alone is the user's: ours have a report too."""
    target = tmp_path / "robot"
    target.mkdir()
    for name in ("robot.toml", "poses.csv"):
        (target / name).write_text("mine")
    with pytest.raises(OutputExistsError, match=r"not ours: 'poses.csv', 'robot.toml'"):
        write_folder(small_study(), target, force=True)
    assert left_in(target) == ["poses.csv", "robot.toml"]


@pytest.mark.parametrize("force", [False, True])
def test_a_file_in_the_way_is_kept(tmp_path, force):
    """A file of that name is never replaced by a folder."""
    target = tmp_path / "out"
    target.write_text("mine")
    with pytest.raises(OutputExistsError, match="is a file"):
        write_folder(small_study(), target, force=force)
    assert target.read_text() == "mine"


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("dangling", [False, True])
def test_a_link_in_the_way_is_not_followed(tmp_path, force, dangling):
    """A link at the target may lead anywhere: it is refused, and neither it nor what it points at
    changes.
    """
    if not dangling:
        (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "elsewhere")
    before = left_in(tmp_path)
    with pytest.raises(OutputExistsError, match="symbolic link"):
        write_folder(small_study(), tmp_path / "out", force=force)
    assert left_in(tmp_path) == before


def failing_at(name: str, error: BaseException):
    """Write files until one of this name comes."""
    write = Path.write_bytes

    def written(path, content):
        if path.name == name:
            write(path, content[:10])
            raise error
        return write(path, content)

    return written


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("name", ["report.html", "result.json", "arrays.nc"])
def test_full_disk_leaves_nothing(tmp_path, monkeypatch, name):
    """Whichever file the disk runs full at, no half folder, no temporary and no empty parent stays
    behind.
    """
    monkeypatch.setattr(
        Path, "write_bytes", failing_at(name, OSError(28, "No space left on device"))
    )
    with pytest.raises(LostmotionError, match="No space left on device"):
        write_folder(small_study(), tmp_path / "deep" / "out")
    assert left_in(tmp_path) == []


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_failure_keeps_the_old_results(tmp_path, monkeypatch, error):
    """When replacing fails midway, by a full disk or by Ctrl-C, the earlier results are still
    whole.
    """
    target = tmp_path / "out"
    target.mkdir()
    (target / "result.json").write_text("old")
    monkeypatch.setattr(Path, "write_bytes", failing_at("arrays.nc", error))
    with pytest.raises((LostmotionError, KeyboardInterrupt)):
        write_folder(small_study(), target, force=True)
    assert left_in(tmp_path) == ["out"]
    assert (target / "result.json").read_text() == "old"


@pytest.mark.usefixtures("undrawn")
def test_failed_swap_puts_the_old_folder_back(tmp_path, monkeypatch):
    """When the new folder is complete but cannot take its place, the old one returns to it."""
    target = tmp_path / "out"
    target.mkdir()
    (target / "result.json").write_text("old")
    # a system that only renames
    monkeypatch.setattr(folder_of_report, "exchange", lambda *_: False)
    rename = Path.rename

    def renamed(path, to):
        if path.name.endswith(".new"):
            raise OSError(13, "Permission denied")
        return rename(path, to)

    monkeypatch.setattr(Path, "rename", renamed)
    with pytest.raises(LostmotionError, match="Permission denied"):
        write_folder(small_study(), target, force=True)
    assert left_in(tmp_path) == ["out"]
    assert (target / "result.json").read_text() == "old"


KILLED_WHILE_REPLACING = """
import os, sys
from pathlib import Path
from lostmotion.reporting import folder

target, atomic = Path(sys.argv[1]), sys.argv[2] == "atomic"
old, new = ({name: (word * 9).encode() for name in ("report.html", "result.json")} for word in ("old", "new"))
if not atomic:
    folder.exchange = lambda *_: False
folder.write_whole(old, target)
missing = 0
for step in range(1000):
    child = os.fork()
    if child == 0:
        left = [step]
        def dying(act):
            def instead(*given, **named):
                if left[0] == 0:
                    os._exit(9)
                left[0] -= 1
                return act(*given, **named)
            return instead
        for owner, names in ((Path, ("mkdir", "write_bytes", "rename", "unlink", "rmdir")), (os, ("fsync", "scandir")), (folder, ("exchange",))):
            for name in names:
                setattr(owner, name, dying(getattr(owner, name)))
        folder.write_whole(new, target, force=True)
        os._exit(0)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    missing += not target.exists()
    folder.refuse_existing(target, force=True)  # whoever comes next
    found = {each.name: each.read_bytes() for each in target.iterdir()}
    assert found in (old, new), (step, found)
    if code == 0:
        break
    folder.write_whole(old, target, force=True)
assert found == new
print(step, missing)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system that forks")
@pytest.mark.parametrize("how", ["atomic", "renames"])
def test_killed_at_any_step_of_replacing_the_old_or_the_new_results_stand(tmp_path, how):
    """Killed before each step of --force, the earlier or the new results stand whole: at once, or
    from the next start on without an exchange.
    """
    if how == "atomic" and not folder_of_report.exchange(
        *(Path(tempfile.mkdtemp(dir=tmp_path)) for _ in range(2))
    ):
        pytest.skip("this disk cannot exchange two folders in one step")
    ran = subprocess.run(
        [sys.executable, "-c", KILLED_WHILE_REPLACING, tmp_path / "out", how],
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    steps, missing = map(int, ran.stdout.split())
    assert steps > 8
    assert missing == (0 if how == "atomic" else 1)


@pytest.mark.usefixtures("undrawn")
def test_a_parent_that_is_a_file_is_one_message(tmp_path):
    """A path through a file cannot be; the message is the package's own."""
    (tmp_path / "file").write_text("mine")
    with pytest.raises(LostmotionError, match="could not be written"):
        write_folder(small_study(), tmp_path / "file" / "out")
    assert left_in(tmp_path) == ["file"]


@pytest.mark.parametrize("here", [".", "..", "sub/.."])
def test_the_folder_one_stands_in_is_never_replaced(tmp_path, monkeypatch, here):
    """`--out .` names the working folder: it exists, so it is refused."""
    if here != ".":
        (tmp_path / "sub").mkdir()
    monkeypatch.chdir(tmp_path / "sub" if here == ".." else tmp_path)
    with pytest.raises(OutputExistsError):
        folder_of_report.refuse_existing(here, force=True)


def test_tables_for_notebooks_carry_every_section():
    """A study shown in a notebook is its tables, each with its caption, and asks for no script."""
    shown = small_study()._repr_html_()
    for section in sections(small_study()):
        assert f"<caption>{section.title}</caption>" in shown
    assert "<script" not in shown
