"""The pictures of the tour are those that their script draws, and each is shown with words for
those who cannot see it.
"""

import importlib.util
import re

import pytest
from lxml import etree

from tests.docs.pages import ROOT, TOUR

FOLDER = ROOT / "docs" / "pictures"
SPEC = importlib.util.spec_from_file_location("draw", FOLDER / "draw.py")
draw = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(draw)


def test_every_picture_has_a_drawing():
    """No SVG lies in the folder that the script does not draw."""
    assert {path.stem for path in FOLDER.glob("*.svg")} == set(draw.PICTURES)


@pytest.mark.parametrize("name", list(draw.PICTURES))
def test_a_picture_is_what_the_script_draws_and_stays_on_its_page(name):
    """After a change of the script, `python docs/pictures/draw.py` writes the same pictures; every
    word lies within the frame.
    """
    written = (FOLDER / f"{name}.svg").read_text("utf-8")
    assert written == draw.svg(name)
    root = etree.fromstring(written.encode())
    _, _, width, height = map(float, root.get("viewBox").split())
    for words in root.iterfind(".//{*}text"):
        room = 0.62 * float(words.get("font-size")) * len(words.text)
        left = (
            float(words.get("x"))
            - {"start": 0, "middle": room / 2, "end": room}[words.get("text-anchor")]
        )
        assert left >= 0, words.text
        assert left + room <= width, words.text
        assert 0 < float(words.get("y")) < height, words.text


def test_every_picture_stands_in_the_tour_with_a_description():
    """Each is shown once at least, and its alternative text is a phrase."""
    shown = {
        name: words
        for page in TOUR
        for words, name in re.findall(
            r"!\[([^\]]*)\]\(\S*pictures/(\w+)\.svg\)", page.read_text("utf-8")
        )
    }
    assert set(shown) == set(draw.PICTURES)
    assert all(len(words.split()) > 5 for words in shown.values())
