"""Texts of charts, for tests: the titles of their axes, and the figures in them that a report does
not print.
"""

from __future__ import annotations

import re
from itertools import combinations
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from lostmotion.reporting.svg import inline_svg

if TYPE_CHECKING:
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet

NUMBER = re.compile(r"\d+(?:\.\d+)?")
CLASS = re.compile(r"[<>] −?[\d.]+|−?[\d.]+ to −?[\d.]+")
TICK = re.compile(r"−?[\d.]+(?:e[−+]?\d+)?°?")
PLACE = re.compile(r"[xyz] = −?[\d.]+ mm")
OTHERS = re.compile(r"\d+ others?")


def texts(plot: Plot) -> list[str]:
    """Return every text of the plot's SVG, in order."""
    return [
        each.text
        for each in ET.fromstring(inline_svg(plot)).iter()  # noqa: S314
        if each.tag.endswith("text") and each.text
    ]


def axis_titles(plot: Plot) -> list[str]:
    """Return the titles of every axis that carries numbers, empty where it has none; axes that
    share another's numbers are not asked.
    """
    found = []
    for on in plot.figure.axes:
        for axis, outer in (
            (on.xaxis, on.get_subplotspec().is_last_row()),
            (on.yaxis, on.get_subplotspec().is_first_col()),
        ):
            shared = (
                len(
                    {
                        each
                        for group in (on.get_shared_x_axes(), on.get_shared_y_axes())
                        for each in group.get_siblings(on)
                    }
                )
                > 1
            )
            if (outer or not shared) and _numbers(axis) and on.name != "polar":
                found.append(axis.get_label_text())
    return found


def unprinted(plot: Plot, sheet: Sheet) -> set[str]:
    """Return the numbers in a plot's texts that the sheet does not print.

    Ticks and titles of axes, limits of classes and the place of a slice along its third axis are
    coordinates, not figures; how many rows share one bar is counted in the plot alone.
    """
    shown = texts(plot)
    for on in plot.figure.axes:
        for axis in (on.xaxis, on.yaxis):
            for text in [
                *_numbers(axis),
                *axis.get_label_text().split("\n"),
                axis.get_offset_text().get_text(),
            ]:
                if text in shown:
                    shown.remove(text)
    printed = {number for text in _printed(sheet) for number in NUMBER.findall(text)}
    return {
        number
        for text in shown
        if not CLASS.fullmatch(text) and not OTHERS.fullmatch(text)
        for number in NUMBER.findall(PLACE.sub("", text))
        if number not in printed
    }


def crowded(figure: Figure) -> list[str]:
    """Return which parts of a figure, axes with their words, title and legends, reach beyond its
    edge or into each other: by matplotlib's measure.
    """
    figure.set_dpi(100)  # as on a screen; coarser pixels widen the letters
    canvas = FigureCanvasAgg(figure)
    figure.draw_without_rendering()  # places everything, and paints nothing
    renderer = canvas.get_renderer()
    parts = {f"axes {k}": on.get_tightbbox(renderer) for k, on in enumerate(figure.axes)}
    parts |= {
        f"legend {k}": legend.get_window_extent(renderer) for k, legend in enumerate(figure.legends)
    }
    parts |= {
        text.get_text(): text.get_window_extent(renderer)
        for text in figure.findobj(Text)
        if text.get_text() == figure.get_suptitle() != ""
    }
    inside = figure.bbox
    beyond = [
        name
        for name, box in parts.items()
        if min(box.x0, box.y0, inside.x1 - box.x1, inside.y1 - box.y1) < -0.5
    ]
    return beyond + [
        f"{one} over {other}"
        for (one, a), (other, b) in combinations(parts.items(), 2)
        if Bbox.intersection(a, b) is not None
    ]


def _numbers(axis: Axis) -> list[str]:
    """Return the labels of an axis' ticks that are numbers."""
    return [
        text for text in (each.get_text() for each in axis.get_ticklabels()) if TICK.fullmatch(text)
    ]


def _printed(sheet: Sheet) -> list[str]:
    """Return every text of a sheet."""
    rows = [row for section in sheet.sections for row in section.rows]
    figures = [
        text
        for row in rows
        for figure in row.cells
        for text in (str(figure), figure.between, figure.samples)
    ]
    labels = [text for row in rows for text in (row.label, row.note)]
    heads = [
        text
        for section in sheet.sections
        for text in (section.title, section.note, *section.columns)
    ]
    return [sheet.name, sheet.verdict, sheet.counts, *sheet.notes, *figures, *labels, *heads]
