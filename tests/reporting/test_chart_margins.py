"""The words about the axes of a chart stand within the picture and beside each other."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from lostmotion.reporting.chart import (
    axes,
    axes_by_unit,
    figure,
    label_axes,
    legend,
    mark_at,
    named_rows,
    one,
    ringed,
    stacked,
    swatch,
    text,
)
from lostmotion.reporting.map_chart import class_legend
from lostmotion.reporting.palette import LIGHT
from tests.reporting.chart_texts import crowded


def long_names():
    """Return bars with the longest names that are drawn, and words that reach beyond the axes."""
    made, on = one("Bars", 60)
    named_rows(on, ["A long name of 36 letters of an arm m", "two\nlines", "i"])
    text(on, 0.9, 0, "words that reach far beyond the axes", xytext=(4, 0), va="center")
    text(on, 0.0, 1, "and to the left", xytext=(-4, 0), ha="right", va="center")
    label_axes(on, "share [%]")
    return made


def many_marks():
    """Return a chart with marks one above the other at its ends, under a legend that is its
    title's, too.
    """
    made, on = one("Marks", 70)
    stacked(on, [("a name", LIGHT["robot"], np.array([1.0, 2.0]))])
    on.set_xlim(0, 1)
    for row in range(4):
        mark_at(on, row / 3, f"mark number {row} at its place", row=row)
    label_axes(on, "over\ntwo lines [mm]", "upright")
    legend(made, extra=[swatch(f"entry {k} with a long name", LIGHT["visit"]) for k in range(7)])
    return made


def large_numbers():
    """Return axes whose numbers need a common factor or an offset, one of them logarithmic."""
    made = figure(90)
    first, second = axes(made, "Numbers", rows=2)[:, 0]
    first.plot([1e9, 1e9 + 5], [1e-9, 3e-9])
    second.loglog([1e-4, 1e6], [1e-9, 1e9])
    for on in (first, second):
        label_axes(on, "x [1]", "y [1]")
    return made


def small_multiples():
    """Return panels of equal scales with titles of their own and shared axes, over a legend of
    classes.
    """
    made = figure(100)
    panels = axes(made, "Panels", rows=2, columns=4, sharex=True, sharey=True)
    for k, on in enumerate(panels.flat):
        on.set_title(f"panel {k}", loc="center")
        on.plot([0, 3000], [-2000, 1000])
        on.set_aspect("equal")
        label_axes(on, "x [mm]" if k > 3 else "", "y [mm]" if k % 4 == 0 else "")
    class_legend(
        made, [0.4, 0.6, 0.8, 1.0, 1.2, 1.4], "error [mm]", [swatch("further", LIGHT["line"])]
    )
    return made


def low_and_wide():
    """Return axes of equal scales that need far less than their place, with a ring at their
    corner.
    """
    made, on = one("Low", 90)
    on.plot([0, 1000], [0, 20])
    on.set_xlim(0, 1000)
    on.set_ylim(0, 20)
    ringed(on, 1000, 20, "at the corner")
    on.set_aspect("equal")
    label_axes(on, "distance from the base's axis [mm]", "a name longer than the axes [mm]")
    class_legend(
        made, [0.4, 0.6, 0.8, 1.0, 1.2, 1.4], "error [mm]", on.get_legend_handles_labels()[0]
    )
    return made


def upright_ticks():
    """Return two panels of different heights, with upright names below both."""
    made, panels = axes_by_unit("Panels", {"N m": 6, "N": 3}, bar=16.0)
    for on in panels.values():
        on.set_xticks(range(3), ["a pose with a name", "b", "c"])
        on.tick_params(axis="x", labelrotation=90)
        label_axes(on, "pose", "AP [mm]")
    return made


CHARTS = (long_names, many_marks, large_numbers, small_multiples, low_and_wide, upright_ticks)


@pytest.mark.parametrize("chart", CHARTS, ids=lambda chart: chart.__name__)
def test_no_word_is_cut_or_printed_over_another(chart):
    """Ticks, names, marks, titles and legends stand within the picture, and none over another's
    axes.
    """
    assert crowded(chart()) == []


@pytest.mark.parametrize("chart", CHARTS, ids=lambda chart: chart.__name__)
def test_margins_are_no_wider_than_the_words(chart):
    """Up to two lines of text of the picture's width and height are left empty, unless its scales
    are equal.
    """
    made = chart()
    canvas = FigureCanvasAgg(made)
    canvas.draw()
    used = made.get_tightbbox(canvas.get_renderer()).extents
    equal = made.axes[0].get_aspect() != "auto"
    assert (
        np.array([used[0], used[1], *(made.get_size_inches() - used[2:])])[
            [0, 1, 3] if equal else [0, 1, 2, 3]
        ]
        < 0.25
    ).all()


def test_a_chart_keeps_its_place_when_drawn_again():
    """A second drawing moves nothing."""
    made = long_names()
    places = []
    for _ in range(2):
        FigureCanvasAgg(made).draw()
        places.append(made.axes[0].get_position().extents)
    assert places[0] == pytest.approx(places[1], abs=1e-3)


def test_words_larger_than_the_picture_are_drawn_all_the_same():
    """A figure of a few millimetres has no room for its words; it is drawn where matplotlib puts
    it.
    """
    made = many_marks()
    made.set_size_inches(0.5, 0.3)
    FigureCanvasAgg(made).draw()
    assert made.axes[0].get_position().width > 0


def test_a_word_beyond_the_edge_is_found():
    """The check sees a word that is cut, and one that stands in the title's place."""
    made, on = one("Title", 60)
    label_axes(on, "x [1]")
    made.set_layout_engine("none")
    made.subplots_adjust(left=0, bottom=0, right=1, top=1)
    assert crowded(made) == ["axes 0", "axes 0 over Title"]
