"""Colours, classes and SVG text of charts."""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lostmotion.reporting.chart import (
    label_axes,
    legend,
    mark_at,
    named_rows,
    one,
    stacked,
)
from lostmotion.reporting.map_chart import cells, class_names, class_of
from lostmotion.reporting.palette import CLASSES, DARK, LIGHT, class_limits
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.svg import inline_svg

# Linear RGB as seen with each deficiency (G. M. Machado, M. M. Oliveira, L. A. F. Fernandes 2009,
# severity 1).
SIGHT = {
    "normal": np.eye(3),
    "deutan": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "protan": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "tritan": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}


def linear(colour):
    """Return the linear RGB of a colour in sRGB (IEC 61966-2-1)."""
    coded = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    return np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)


def luminance(rgb):
    """Return the relative luminance of linear RGB."""
    return float(np.array([0.2126729, 0.7151522, 0.0721750]) @ np.clip(rgb, 0, 1))


def contrast(one_colour, other):
    """Return the contrast of two colours by WCAG 2."""
    high, low = sorted((luminance(linear(one_colour)), luminance(linear(other))), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("sight", SIGHT)
@pytest.mark.parametrize(("scheme", "direction"), [(LIGHT, -1), (DARK, 1)], ids=["light", "dark"])
def test_larger_errors_stand_out_for_every_eye(scheme, direction, sight):
    """From class to class the lightness moves away from the paper, also for those who confuse red
    and green or blue and yellow.
    """
    seen = [luminance(SIGHT[sight] @ linear(scheme[f"c{k}"])) for k in range(7)]
    assert (direction * np.diff(seen) > 0).all()


@pytest.mark.parametrize("scheme", [LIGHT, DARK], ids=["light", "dark"])
def test_texts_and_bars_are_seen_on_paper(scheme):
    """Text has a contrast of at least 4.5 (WCAG 2, 1.4.3), bars of at least 3 (1.4.11)."""
    assert all(
        contrast(scheme[name], scheme["paper"]) >= 4.5
        for name in ("ink", "quiet", "accent", "warn")
    )
    assert all(
        contrast(scheme[name], scheme["paper"]) >= 3.0
        for name in ("design", "robot", "visit", "other")
    )


def test_both_schemes_name_the_same_colours():
    """A page swaps the values of its variables, so each name has one colour in each scheme, and no
    two names share one.
    """
    assert list(LIGHT) == list(DARK)
    assert len(set(LIGHT.values())) == len(LIGHT)


@given(st.floats(-1e3, 1e3), st.floats(1e-6, 1e3))
def test_classes_have_round_limits_that_cover_the_range(low, span):
    """Seven classes reach from the least to the largest value in equal steps of 1, 2 or 5 times a
    power of ten.
    """
    limits = class_limits(low, low + span)
    step = limits[1] - limits[0]
    assert np.diff(limits) == pytest.approx(step, abs=1e-9)
    assert round(step / 10 ** math.floor(math.log10(step) + 1e-6), 3) in {1, 2, 5}
    assert len(limits) == len(CLASSES) - 1
    if span > 1e-3 * abs(low + span):
        assert limits[0] - step <= low + step
        assert limits[-1] + step >= low + span - step


def test_a_value_on_a_limit_is_in_one_class():
    """Each number has one class, and what is not known has none."""
    assert class_of(np.array([0.1, 0.4, 0.5, 9.0, math.nan]), class_limits(0.22, 1.4)).tolist() == [
        0,
        1,
        1,
        6,
        -1,
    ]
    assert class_names([-1.0, 0.2, 0.4])[:2] == ["< −1", "−1 to 0.2"]


def drawn(words="A share & a <limit>"):
    """Return a chart with bars, a mark, a legend and a title."""
    figure, on = one("Shares", 60)
    stacked(
        on,
        [
            ("adds", LIGHT["robot"], np.array([3.123456, 2.0])),
            ("cancels", LIGHT["design"], np.array([-0.5, 0.0])),
        ],
    )
    named_rows(on, ["A.gearbox", "0.123456 mm"])
    mark_at(on, 1.5, "95th percentile 1.234567 mm")
    label_axes(on, "share [%]")
    legend(figure)
    return Plot("shares", "budget", figure, words)


def test_an_inline_chart_is_described_and_uses_the_colours_of_the_page():
    """Whoever cannot see it reads its words; every colour is a variable of the page; no style or
    identifier of one chart meets another's.
    """
    text = inline_svg(drawn())
    root = ET.fromstring(text)  # noqa: S314 - made here
    assert (root.get("role"), root.get("aria-label")) == ("img", "A share & a <limit>")
    assert not re.search(r"#[0-9a-fA-F]{3,6}", re.sub(r'(url\(|href=")#[^")]*', "", text))
    assert set(re.findall(r"var\(--(\w+)\)", text)) <= {*LIGHT, "font"}
    assert "<style" not in text
    assert all(name.startswith("shares-") for name in re.findall(r' id="([^"]*)"', text))
    assert set(re.findall(r'(?:url\(#|href="#)([^")]*)', text)) <= set(
        re.findall(r' id="([^"]*)"', text)
    )


def test_coordinates_are_shortened_and_texts_are_not():
    """Coordinates need 0.01 pt; a number that somebody reads is never cut."""
    text = inline_svg(drawn())
    assert {"0.123456 mm", "95th percentile 1.234567 mm", "Shares"} <= set(
        re.findall(r">([^<>]+)</text>", text)
    )
    coordinates = " ".join(re.findall(r' (?:d|transform|x|y)="([^"]*)"', text))
    assert max(len(part) for part in re.findall(r"[.](\d+)", coordinates)) == 2


def test_the_same_chart_is_the_same_text():
    """No clock and no random number goes into a page."""
    assert inline_svg(drawn()) == inline_svg(drawn())


def test_bars_that_cancel_others_start_at_a_zero_line():
    """Positive parts reach to the right of zero and negative ones to the left, with a line between
    them.
    """
    _, on = one("Shares", 60)
    low, high = stacked(
        on,
        [
            ("a", LIGHT["robot"], np.array([3.0, -1.0])),
            ("b", LIGHT["visit"], np.array([-2.0, -1.0])),
        ],
    )
    assert (low.tolist(), high.tolist()) == ([-2.0, -2.0], [3.0, 0.0])
    assert [line.get_xdata() for line in on.lines] == [[0.0, 0.0]]


def test_cells_of_one_class_are_one_path():
    """Each class is one path, whose area is that of its cells."""
    _, on = one("Map", 60)
    classes = np.array([[0, 0, 1], [0, 1, 1], [-1, 2, 2]])
    cells(on, np.array([0.0, 1.0, 2.0, 4.0]), np.array([0.0, 1.0, 2.0, 3.0]), classes)
    assert len(on.patches) == 3
    areas = []
    for patch in on.patches:
        rings = patch.get_path().vertices.reshape(-1, 5, 2)
        areas.append(sum(np.ptp(ring[:, 0]) * np.ptp(ring[:, 1]) for ring in rings))
    assert areas == [3.0, 3.0, 4.0]
