"""The arm in three dimensions in a real browser: it draws in the colours of the legend, turns,
cuts, and keeps quiet.
"""

from __future__ import annotations

import base64
import io
import json
from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest

from lostmotion.reporting.page.document import page
from lostmotion.reporting.palette import DARK, LIGHT
from tests.arms import small_study
from tests.browser.chromium import CHROMIUM, Browser

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"),
]
DRAWN = "document.querySelector('.viewer').dataset.drawn"


def picture(browser: Browser, what: str = "canvas") -> np.ndarray:
    """Return the pixels of an element (row, column, 3), 0..255, after the next frame."""
    browser.value(
        "new Promise(done => requestAnimationFrame(() => "
        "requestAnimationFrame(done))).then(() => true)"
    )
    box = json.loads(
        browser.value(f"JSON.stringify(document.querySelector('{what}').getBoundingClientRect())")
    )
    clip = {name: box[name] for name in ("x", "y", "width", "height")} | {"scale": 1}
    png = base64.b64decode(browser.ask("Page.captureScreenshot", format="png", clip=clip)["data"])
    return np.round(255 * matplotlib.image.imread(io.BytesIO(png))[:, :, :3]).astype(int)


def share(pixels: np.ndarray, colour: str) -> float:
    """Return the share of pixels that have exactly this colour: the cut is unlit."""
    wanted = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    return float((pixels == wanted).all(axis=2).mean())


def classes(pixels: np.ndarray, palette: dict[str, str]) -> set[str]:
    """Return the classes of the legend that are seen."""
    return {f"c{k}" for k in range(7) if share(pixels, palette[f"c{k}"]) > 1e-4}


def choose(browser: Browser, cut: str) -> None:
    """Choose a cut in the menu."""
    browser.value(
        f"(menu => {{ menu.value = '{cut}'; menu.dispatchEvent(new Event('change')) "
        f"}})(document.querySelector('.cut select'))"
    )


def coloured() -> str:
    """Return the page of a study whose workspace shows all seven classes, in layers."""
    study = small_study()
    first, *others = study.plots
    cells = first.scene.cells
    layers = 7 * np.arange(cells.classes.shape[2]) // cells.classes.shape[2]
    shown = replace(cells, classes=np.where(cells.classes < 0, -1, layers))
    return page(
        study.sheet, [replace(first, scene=replace(first.scene, cells=shown)), *others], "0"
    )


def test_the_viewer_draws_turns_and_cuts(tmp_path):
    """Cells have the colours of the legend in both schemes; keys, buttons, cut and slider change
    the picture; nothing is fetched or goes wrong.
    """
    written = tmp_path / "report.html"
    written.write_text(coloured(), encoding="utf-8")
    with Browser(written.as_uri(), (1440, 900)) as browser:
        browser.wait(DRAWN)
        first = picture(browser)
        assert 0.2 < share(first, LIGHT["panel"]) < 0.9
        assert classes(picture(browser, ".legend"), LIGHT) == {f"c{k}" for k in range(7)}
        assert classes(first, LIGHT) == {f"c{k}" for k in range(7)}
        assert sum(share(first, LIGHT[f"c{k}"]) for k in range(7)) > 0.05
        # Answer, arm and largest contributors are seen without scrolling.
        for what in ("h1", ".shown", ".bars tbody tr:last-child"):
            assert browser.value(
                f"document.querySelector('{what}').getBoundingClientRect().bottom <= innerHeight"
            ), what
        assert (
            browser.value("getComputedStyle(document.querySelector('#plot-arm')).display") == "none"
        )

        browser.value("document.querySelector('canvas').focus()")
        seen = [first]
        for name, code in (("ArrowLeft", 37), ("ArrowUp", 38), ("+", 187)):
            browser.key(name, code)
            seen.append(picture(browser))
            assert (seen[-1] != seen[-2]).any(axis=2).mean() > 0.01, name
        browser.key("0", 48)
        inner = (slice(8, -8), slice(8, -8))  # within the ring of the focus
        assert (picture(browser)[inner] == first[inner]).all()

        browser.value("document.querySelectorAll('.controls button')[1].click()")
        best = picture(browser)
        assert (best != first).any(axis=2).mean() > 0.01
        assert browser.value("document.querySelector('.shown').textContent").startswith(
            "Best pose: mean error"
        )
        for cut in ("x", "y", "z", "all", "none"):
            choose(browser, cut)
            now = picture(browser)
            assert share(now, LIGHT["panel"]) < 0.97, cut
            assert (len(classes(now, LIGHT)) == 0) == (cut == "none"), cut
        choose(browser, "z")
        before = picture(browser)
        browser.value(
            "(at => { at.value = +at.value - 200; at.dispatchEvent(new Event('input')) "
            "})(document.querySelector('.cut input'))"
        )
        assert (picture(browser) != before).any(axis=2).mean() > 0.01

        choose(browser, "x")
        browser.show(dark=True)
        assert len(classes(picture(browser), DARK)) > 3
        assert share(picture(browser), DARK["panel"]) > 0.2
        browser.show(on_paper=True)
        shown = [
            browser.value(f"document.querySelector('{what}').checkVisibility()")
            for what in (".viewer", "#plot-arm", "#plot-arm-best")
        ]
        assert shown == [False, True, True]
        assert browser.errors == []
        assert browser.requests == [written.as_uri()]


def test_without_webgl_the_pictures_stay(tmp_path):
    """Both cuts are in the page as drawings before any script runs; a machine that cannot draw the
    viewer shows them, without a complaint.
    """
    written = small_study().report(tmp_path / "report")
    with Browser("about:blank", (1440, 900)) as browser:
        browser.ask(
            "Page.addScriptToEvaluateOnNewDocument",
            source="HTMLCanvasElement.prototype.getContext = () => null",
        )
        browser.ask("Page.navigate", url=(written / "report.html").as_uri())
        browser.wait("document.scripts.length === 4")  # the loader has added the viewer
        shown = [
            browser.value(f"document.querySelector('{what}').checkVisibility()")
            for what in (".viewer", "#plot-arm", "#plot-arm-best")
        ]
        assert shown == [False, True, True]
        assert browser.errors == []
