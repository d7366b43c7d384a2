"""Reports of every kind in a real browser: on a wide screen and a phone, light and dark, and on
paper.
"""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path

import pytest

import lostmotion
from tests.browser.chromium import CHROMIUM, Browser

EXAMPLES = Path(__file__).parents[2] / "examples"
Z_ARM = EXAMPLES / "z-arm.toml"
AXE = importlib.util.find_spec("axe_playwright_python")
SWEEP = (
    '[sweep]\n"joints.A.gearbox.backlash" = ["0.5 arcmin", "1 arcmin", "2 arcmin"]\n'
    '"payload.mass" = ["1 kg", "5 kg"]\n'
)
REPORTS = {
    "study": lambda _: lostmotion.study(Z_ARM, poses=64, robots=40, visits=4),
    "map": lambda _: lostmotion.map(
        Z_ARM,
        cell="150 mm",
        poses=512,
        per_cell=2,
        target="1 mm",
        box="300 mm x 200 mm x 100 mm",
    ),
    "gear": lambda _: lostmotion.gear(EXAMPLES / "gearbox" / "printed.toml", gearboxes=20),
    "bearing": lambda _: lostmotion.bearing(EXAMPLES / "bearing" / "6209-pair.toml", bearings=50),
    "iso9283": lambda _: lostmotion.iso9283(
        Z_ARM, measured=EXAMPLES / "measured" / "z-arm.csv", robots=20, instrument="5 µm"
    ),
    "target": lambda _: lostmotion.target(
        EXAMPLES / "planar-2r.toml", error="1 mm", robots=60, visits=4, poses=64
    ),
    "size": lambda _: lostmotion.size(Z_ARM, poses=64),
    "compare": lambda _: lostmotion.compare(
        Z_ARM, EXAMPLES / "gantry.toml", EXAMPLES / "scara.toml", poses=64, robots=60, visits=4
    ),
    "compare two": lambda _: lostmotion.compare(
        Z_ARM, EXAMPLES / "scara.toml", poses=64, robots=60, visits=4
    ),
    "task": lambda _: lostmotion.task(
        Z_ARM,
        {
            "placement": {"xyz": (0.8, 0.0, 0.6)},
            "features": [{"name": "c", "kind": "circle", "centre": (0, 0, 0), "diameter": 0.1}],
            "tolerances": [{"roundness": 0.1e-3}, {"sphere": 2e-3}],
        },
        robots=40,
        runs=2,
    ),
    "statics": lambda _: lostmotion.statics(Z_ARM, poses=64, tilt="10 deg"),
    "sweep": lambda folder: lostmotion.sweep(
        Z_ARM, folder / "sweep.toml", poses=8, robots=20, visits=4, out=folder / "run"
    ),
}
# Whole numbers that are counted, and so are exact: alone in a cell of a table, or before what was
# counted.
COUNTED = re.compile(
    r"\d+(?= (?:paired samples|samples|evaluated poses|evaluated|poses|cells|visits)\b)|^\d+$"
)
NAMED = re.compile(r"\d+\.\d+\.\d+(?:[.\w+]*)|(?:ISO|ISO/TS|EN) [\d-]+")  # versions and standards
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:[eE][+−-]?\d+)?")

# What sticks out of the page to the right and does not scroll by itself; on paper, what is wider
# than its section.
STICKS_OUT = """[...document.querySelectorAll('body *')].filter(each => !each.closest('.skip, .table, pre')
    && each.getBoundingClientRect().right > document.documentElement.clientWidth + 1).map(each => each.outerHTML.slice(0, 80))"""
TOO_WIDE = """[...document.querySelectorAll('table, svg, pre')].filter(each => each.getBoundingClientRect().width
    && each.getBoundingClientRect().right > each.closest('section, .bars, figure, header').getBoundingClientRect().right + 1
).map(each => each.outerHTML.slice(0, 80))"""
TEXTS = """[...document.querySelectorAll('svg')].flatMap(chart => {
    const name = chart.parentElement.id, frame = chart.getBoundingClientRect();
    const texts = [...chart.querySelectorAll('text')].map(each => [each.textContent.trim(), each.getBoundingClientRect()]);
    const drawn = texts.filter(([words, box]) => words && box.width);
    const cut = drawn.filter(([, box]) => box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1
        || box.bottom > frame.bottom + 1);
    const over = drawn.flatMap(([words, a], k) => drawn.slice(0, k).filter(([, b]) => {
        const across = Math.min(a.right, b.right) - Math.max(a.left, b.left), down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        return across > 1 && down > 0.25 * Math.min(a.height, b.height);
    }).map(([other]) => `${name}: "${words}" over "${other}"`));
    return [...cut.map(([words]) => `${name}: "${words}" is cut`), ...over];
})"""
NAMELESS = """[...document.querySelectorAll('svg, img, canvas')].filter(each => !each.getAttribute('aria-label') && !each.getAttribute('alt')
    && !each.closest('[aria-hidden=true]')).length"""
VIOLATIONS = """axe.run({resultTypes: ['violations']}).then(
    found => found.violations.map(each => each.id + ': ' + each.nodes.map(node => node.target.join(' ')).join(', ')))"""

pytestmark = [
    pytest.mark.few_counts,
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine"),
]


@pytest.fixture(scope="module")
def browser():
    """Start one browser for all reports."""
    with Browser() as started:
        yield started


@pytest.fixture(scope="module", params=REPORTS)
def kind(request):
    """Return the kind of the report that is shown: all tests of one kind run in a row."""
    return request.param


@pytest.fixture(scope="module")
def folder(kind, tmp_path_factory):
    """Write a small report of each kind once."""
    at = tmp_path_factory.mktemp(kind)
    (at / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    return REPORTS[kind](at).report(at / "report")


@pytest.fixture
def page(browser, folder):
    """Show the report, with all tables open, in light colours on a wide screen."""
    browser.show()
    browser.resize(1440, 900)
    browser.open((folder / "report.html").as_uri())
    browser.value("document.querySelectorAll('details').forEach(each => each.open = true)")
    return browser


def test_a_report_loads_itself_alone_and_without_an_error(page, folder):
    """The page asks nothing of the network, its scripts and its security policy agree, and the
    console stays empty.
    """
    page.wait("document.readyState === 'complete'")
    assert page.errors == []
    assert [each for each in page.requests if not each.startswith("data:")] == [
        (folder / "report.html").as_uri()
    ]


@pytest.mark.skipif(
    AXE is None, reason="axe-playwright-python, which brings axe-core, is not installed"
)
@pytest.mark.parametrize(
    ("width", "dark"), [(1440, False), (390, True)], ids=["light", "dark-phone"]
)
def test_axe_finds_nothing(page, width, dark):
    """Contrast, names, order and keyboard access hold by the rules of axe-core, in light on a
    screen and in dark on a phone.
    """
    page.resize(width, 900)
    page.show(dark=dark)
    page.value(
        f"{(Path(AXE.submodule_search_locations[0]) / 'axe.min.js').read_text(encoding='utf-8')}; 0"
    )
    assert page.value(VIOLATIONS) == []


def test_every_picture_says_what_it_shows(page):
    """Whoever cannot see a chart is given its words."""
    assert page.value("document.querySelectorAll('svg').length") > 0
    assert page.value(NAMELESS) == 0


def test_nothing_is_wider_than_the_screen(page):
    """From a phone to a large screen nobody scrolls sideways; a wide table scrolls by itself."""
    for width in (360, 375, 390, 768, 1440, 2560):
        page.resize(width, 900)
        assert page.value("document.documentElement.scrollWidth <= innerWidth"), width
        assert page.value(STICKS_OUT) == [], width


def test_notes_of_a_table_that_scrolls_are_read_without_scrolling(page):
    """On a phone a note fills the width of the screen at most, also where its table is wider."""
    page.resize(375, 812)
    widths = page.value(
        "[...document.querySelectorAll('tfoot div, tr.remark div')].map(each => "
        "each.getBoundingClientRect().right)"
    )
    assert widths
    assert max(widths) <= 375


def test_texts_of_charts_are_whole_and_apart(page):
    """No text of a chart is cut by its edge or lies over another."""
    assert page.value(TEXTS) == []


def test_no_number_has_more_than_four_significant_digits(page):
    """Only what is counted, a version and the number of a standard are printed to more digits; no
    power of ten stands on a page for people.
    """
    shown = page.value(
        "[document.body.innerText, ...[...document.querySelectorAll('svg text')].map(each => "
        "each.textContent)].join('\\n')"
    )
    found = []
    for words in re.split(r"[\t\n]", shown):
        for number in NUMBER.findall(COUNTED.sub("", NAMED.sub("", words))):
            digits = number.replace(".", "").lstrip("0")
            if len(digits if "." in number else digits.rstrip("0")) > 4 or "e" in number.lower():
                found.append(words)
    assert found == []


def test_a_report_prints_on_a4_with_every_figure(page, folder, kind):
    """On paper nothing sticks out and every figure is there; the report of a study takes three to
    four pages, and that of a small sweep three: its first section begins on the first.
    """
    page.value("document.querySelectorAll('details').forEach(each => each.open = false)")
    page.show(on_paper=True)
    page.resize(695, 1000)  # the width of A4 within its margins, 184 mm
    assert page.value(STICKS_OUT) == []
    assert page.value(TOO_WIDE) == []
    figures = page.value(
        "[...document.querySelectorAll('svg')].map(each => each.getBoundingClientRect().height)"
    )
    page.show()
    printed = page.pdf()
    assert min(figures) > 60
    # bars beside a table that has their figures are left to the screen
    assert printed.count(b"/Alt ") == len(figures)
    sizes = re.findall(rb"/MediaBox \[([\d. ]+)\]", printed)
    assert {tuple(round(float(side)) for side in size.split()) for size in sizes} == {
        (0, 0, 595, 842)
    }
    if json.loads((folder / "result.json").read_text(encoding="utf-8"))["figures"].get("waterfall"):
        assert 3 <= len(sizes) <= 4
    if kind == "sweep":
        assert len(sizes) == 3


@pytest.mark.parametrize("kind", ["study"], indirect=True)
def test_the_first_screen_of_a_study_has_answer_arm_and_largest_contributors(page):
    """At 1440 x 900 all three are seen without scrolling."""
    page.value("document.querySelectorAll('details').forEach(each => each.open = false)")
    for what in ("h1", ".viewer", ".numbers", ".bars"):
        assert (
            page.value(f"document.querySelector('{what}').getBoundingClientRect().height") > 30
        ), what
        assert (
            page.value(f"document.querySelector('{what}').getBoundingClientRect().bottom") <= 900
        ), what
