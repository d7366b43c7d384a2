"""Figures and tables of a result as files for a thesis."""

from __future__ import annotations

import csv
import io
import math
import re
import struct
from functools import cache
from xml.etree import ElementTree as ET

import matplotlib as mpl
import pytest

import lostmotion
from lostmotion.errors import InputError, OutputExistsError
from lostmotion.reporting.figure_files import figure_files
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.sheet import Cell, Row, Section
from lostmotion.reporting.table_files import escaped, table_files
from tests.arms import small_study
from tests.command import carried_out

ARM = """
name = "one"
[[joints]]
name = "A"
type = "revolute"
axis = "z"
limits = ["-60 deg", "60 deg"]
link = { length = "1 m", mass = "1 kg", rigid = true }
"""
BEGINNINGS = {"svg": b"<?xml", "pdf": b"%PDF-", "png": b"\x89PNG"}


# Tables that are written with the figures of each kind.
TABLES = {"svg": "csv", "pdf": "latex", "png": None}


@cache
def drawn():
    """Return the plots of the small study, of which nothing is changed."""
    return small_study().plots


@cache
def drawn_again():
    """Return the same plots drawn a second time."""
    return small_study().plots


def written(kind):
    """Return the plots that are written as files of a kind: all of them as SVG; as others, which
    matplotlib alone makes of the same figures, every third.
    """
    return drawn() if kind == "svg" else drawn()[::3]


@cache
def files(kind):
    """Return the figures of a kind, with tables, that are written into the small study's report, by
    their names there.
    """
    return small_study().copies(written(kind), kind, TABLES[kind])


@pytest.fixture
def at_rest(tmp_path):
    """Return a result with one plot."""
    (tmp_path / "one.toml").write_text(ARM, "utf-8")
    return lostmotion.statics(tmp_path / "one.toml", poses=16)


@pytest.mark.parametrize("kind", BEGINNINGS)
def test_every_figure_is_written_as_a_file_of_its_kind(kind):
    """A file for each plot of the report, under its name, and the same bytes when written again."""
    figures = {name: files(kind)[name] for name in files(kind) if name.startswith("figures/")}
    assert set(figures) == {f"figures/{plot.key}.{kind}" for plot in written(kind)}
    assert all(content.startswith(BEGINNINGS[kind]) for content in figures.values())
    # Of every third plot: what a kind of file could add is the same for all of them, and that each
    # plot is drawn the same again is tested on the pages of two reports.
    for name, content in figure_files(drawn_again()[::3], kind).items():
        assert figures[name] == content, name


def test_svg_files_stand_alone_in_light_colours():
    """A thesis has white paper: the files name their colours and fonts themselves, and their texts
    are texts.
    """
    for name in (f"figures/{plot.key}.svg" for plot in drawn()):
        text = files("svg")[name].decode()
        assert "var(" not in text
        assert set(re.findall(r"(?<=[ :])#[0-9a-f]{6}", text)) <= set(LIGHT.values()), name
        assert "DejaVu" not in text
        assert [each for each in ET.fromstring(text).iter() if each.tag.endswith("}text")], (  # noqa: S314
            name
        )


def test_a_figure_has_the_size_asked_for(tmp_path):
    """80 mm x 60 mm are 945 x 709 pixels at 300 per inch; matplotlib's settings stay the user's."""
    before = dict(mpl.rcParams)
    figure = small_study().figure("error-histogram", size=(80, 60))
    figure.savefig(tmp_path / "error.png", dpi=300)
    width, height = struct.unpack(">II", (tmp_path / "error.png").read_bytes()[16:24])
    assert (width, height) == (
        pytest.approx(80 / 25.4 * 300, abs=1),
        pytest.approx(60 / 25.4 * 300, abs=1),
    )
    assert dict(mpl.rcParams) == before
    assert small_study().figure().get_suptitle() == drawn()[0].figure.get_suptitle()


def test_the_users_settings_of_matplotlib_change_no_report():
    """A user who writes all texts by LaTeX, on black, has the same figures in his report."""
    from lostmotion.reporting.svg import inline_svg

    plain = inline_svg(drawn()[3])
    with mpl.rc_context(
        {
            "font.size": 30,
            "axes.facecolor": "black",
            "savefig.bbox": "tight",
            "path.simplify": False,
        }
    ):
        assert inline_svg(small_study().plots[3]) == plain


def test_a_figure_that_is_not_there_is_refused(at_rest):
    """A mistyped name is refused with the nearest one."""
    with pytest.raises(InputError) as refused:
        at_rest.figure("causess")
    assert refused.value.problems[0].nearest == "causes"


def test_csv_tables_hold_every_digit():
    """Each value, unit and end of an interval reads back as the number that result.json holds."""
    study = small_study()
    kept = study.result()["figures"]["error"]["p95"]
    for section in study.sheet.sections:
        rows = list(
            csv.DictReader(
                io.StringIO(files("svg")[f"tables/{section.key}.csv"].decode(), newline="")
            )
        )
        assert [row["name"] for row in rows] == [row.label for row in section.rows]
        for row, printed in zip(rows, section.rows, strict=True):
            for name, figure in zip(section.columns, printed.cells, strict=True):
                assert row[name] == (
                    figure.words
                    or (repr(float(figure.value)) if math.isfinite(figure.value) else "")
                )
                assert row[f"{name}: unit"] == (
                    "" if figure.words or figure.unit == "1" else figure.unit
                )
                if figure.interval:
                    ends = [float(row[f"{name}: {end}"] or "nan") for end in ("low", "high")]
                    assert ends == pytest.approx(
                        [
                            end if math.isfinite(end) else math.nan
                            for end in (figure.low, figure.high)
                        ],
                        nan_ok=True,
                        rel=1e-15,
                    )
        if section.key == "error":
            (row,) = [row for row in rows if row["name"] == "95th percentile"]
            assert (float(row["value"]), float(row["value: low"]), row["value: unit"]) == (
                kept["value"],
                kept["low"],
                kept["unit"],
            )


def test_latex_tables_are_whole():
    """Each row has as many cells as the table has columns, no special character stands by itself,
    and every printed figure is there.
    """
    for section in small_study().sheet.sections:
        text = files("pdf")[f"tables/{section.key}.tex"].decode()
        columns = re.search(r"\\begin\{tabular\}\{(\w+)\}", text)
        assert columns is not None
        lines = [line for line in text.splitlines() if line.endswith(r"\\")]
        assert len(lines) == 1 + len(section.rows)
        for line in lines:
            assert len(re.findall(r"(?<!\\)&", line)) == len(columns[1]) - 1
            bare = re.sub(
                r"\\[a-z]+\{\}|\\[a-z]+\{\d\}|\\[&%$#_{},]|\$[^$]*\$", "", line.removesuffix(r"\\")
            )
            assert not set("%$#_{}^\\") & set(bare), line
        printed = re.sub(r"\\,", " ", text)
        assert all(escaped(str(figure)) in printed for row in section.rows for figure in row.cells)


def test_latex_prints_every_sign_as_it_stands():
    """What LaTeX takes as an instruction is escaped; a table of hostile names is still a table."""
    assert (
        escaped(r"50 % of A_b & {c} #1 $2 ~ ^ \n")
        == r"50 \% of A\_b \& \{c\} \#1 \$2 \textasciitilde{} \textasciicircum{} \textbackslash{}n"
    )
    section = Section("k", "Title & more", ("value",), (Row(r"\input{x}", (Cell(1.5e-6, "µm"),)),))
    sheet = small_study().sheet
    text = table_files(
        type(sheet)(name="n", subject="s", verdict="v", cards=(), sections=(section,), source=""),
        "latex",
    )["tables/k.tex"].decode()
    assert r"\textbackslash{}input\{x\} & 1.50\,\textmu{}m \\" in text


def test_the_folder_of_figures_is_ours_alone(at_rest, tmp_path):
    """A report with figures is replaced with --force; one into which somebody put a file of his own
    is left alone.
    """
    folder = at_rest.report(tmp_path / "out", figures="svg", tables="csv")
    assert (folder / "tables").exists()
    at_rest.report(folder, force=True, figures="png")
    assert {path.suffix for path in (folder / "figures").iterdir()} == {".png"}
    assert not (folder / "tables").exists()
    (folder / "figures" / "notes.txt").write_text("mine")
    with pytest.raises(OutputExistsError, match="figures"):
        at_rest.report(folder, force=True)
    assert (folder / "figures" / "notes.txt").read_text() == "mine"


def test_commands_write_figures_and_tables(tmp_path):
    """Both are options of every command that writes a report; another word is refused with those
    there are.
    """
    (tmp_path / "one.toml").write_text(ARM, "utf-8")
    kinds = ("--figures", "pdf", "--tables", "latex", "--quiet")
    done = carried_out("statics", "one.toml", "--poses", "16", *kinds, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert [path.name for path in (tmp_path / "one-statics" / "figures").iterdir()] == [
        "causes.pdf"
    ]
    assert (
        (tmp_path / "one-statics" / "tables" / "torques.tex")
        .read_text("utf-8")
        .startswith("% needs")
    )
    refused = carried_out("statics", "one.toml", "--figures", "jpg", cwd=tmp_path)
    assert refused.returncode == 2
    assert "--figures" in refused.stderr
    assert "svg, pdf, png" in refused.stderr


def test_a_run_of_designs_keeps_its_figures(tmp_path):
    """A sweep writes figures and tables beside its blocks."""
    (tmp_path / "one.toml").write_text(ARM + "encoder = { zero = '1 arcmin' }\n", "utf-8")
    found = lostmotion.sweep(
        tmp_path / "one.toml", poses=8, robots=4, visits=2, out=tmp_path / "run", workers=1
    )
    folder = found.report(figures="svg", tables="csv")
    assert {f"{plot.key}.svg" for plot in found.plots} == {
        path.name for path in (folder / "figures").iterdir()
    }
    assert (folder / "tables" / "designs.csv").exists()
