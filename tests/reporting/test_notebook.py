"""A result in a notebook: one line of text, and HTML that survives hosts which remove styles,
scripts and SVG.
"""

import base64
import re
import struct

import pytest

from tests.arms import small_study


@pytest.fixture(scope="module")
def study():
    """Return a small study."""
    return small_study()


@pytest.fixture(scope="module")
def shown(study):
    """Return what a notebook gets of it."""
    return study._repr_mimebundle_()


def test_text_is_the_answer_on_one_line(study, shown):
    """A notebook without HTML shows the name and the headline."""
    assert shown["text/plain"] == f"{study.arm.name}: {study.sheet.verdict}"
    assert "\n" not in shown["text/plain"]


def test_the_picture_is_a_png_within_the_html(study, shown):
    """The cut through the workspace is 160 pixels per inch, described in words, and rides along by
    itself.
    """
    (data,) = re.findall(
        r'<img src="data:image/png;base64,([^"]+)" alt="[^"]{40,}"', shown["text/html"]
    )
    assert data == shown["image/png"]
    png = base64.b64decode(data)
    assert png.startswith(b"\x89PNG")
    width, height = study._first_plot().figure.get_size_inches()
    assert struct.unpack(">II", png[16:24]) == pytest.approx((160 * width, 160 * height), abs=1)
    assert not re.search(r"<script|<svg|https?:", shown["text/html"])


def test_five_figures_and_five_bars_stand_beside_the_picture(study, shown):
    """Numbers and widths of bars are those of the sheet; the style of an element draws them, and no
    style sheet.
    """
    before, _, tables = shown["text/html"].partition("<details>")
    for card in study.sheet.cards[:5]:
        assert card.number.partition(" ")[0] in before
    (block,) = study.sheet.bars[:1]
    widths = [float(each) for each in re.findall(r"width:([\d.]+)%;height:10px", before)]
    low, high = block.ends
    assert widths == pytest.approx(
        [100 * abs(bar.size) / (high - low) for bar in block.bars[:5]], abs=0.06
    )
    assert "<style" not in before
    assert tables.count("<caption>") == len(study.sheet.sections)


def test_a_result_without_bars_shows_its_tables(study):
    """What has no error budget is its tables, unfolded and without a picture."""
    from lostmotion.reporting.page.notebook import notebook_bundle
    from lostmotion.reporting.sheet import Sheet

    found = notebook_bundle(
        Sheet(
            name="part", subject="", verdict="", cards=(), sections=study.sheet.sections, source=""
        ),
        None,
    )
    assert found["text/plain"] == "part"
    assert "image/png" not in found
    assert "<details>" not in found["text/html"]
    assert "<table" in found["text/html"]


def test_a_summary_in_a_notebook_is_one_block_of_text(study, monkeypatch, capsys):
    """In a notebook the first screen goes to standard output as on a terminal, instead of one HTML
    block for each line.
    """
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    study.summary()
    printed = capsys.readouterr().out
    assert printed.startswith(study.arm.name)
    assert "<pre" not in printed
    assert max(map(len, printed.splitlines())) <= 80
