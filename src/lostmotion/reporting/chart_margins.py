"""Margins of a chart: as wide as the words around its axes need. Loaded with matplotlib, when a
chart is drawn.

Matplotlib's "constrained" layout measures every word several times, which takes as long as drawing
the chart.
"""

from __future__ import annotations

import functools
import io
import re
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.backends.backend_svg import RendererSVG
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.layout_engine import LayoutEngine
from matplotlib.textpath import text_to_path
from matplotlib.transforms import Bbox, ScaledTranslation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec
    from matplotlib.legend import Legend
    from matplotlib.text import Text
    from matplotlib.transforms import Transform

    from lostmotion.spatial import Floats

# Lengths in pt; a figure is placed at 72 dots per inch, so that a dot is a point. Around the
# figure, and between panels.
EDGE: Final = 3.0
_APART: Final = 10.0
# Height of a line of text, of its size; distance of labels from ticks where none is stated, and of
# a title from its axes.
_LINE: Final = 1.2
_WIDER: Final = 1.06  # on a screen, where letters are of whole pixels
_PAD: Final = 3.5
_TITLE_PAD: Final = 8.0
# Ticks and the ends of words within axes depend on the size of the axes, and that on them; until
# the shares of the figure agree so closely.
_PASSES: Final = 5
_CLOSE: Final = 1e-3
_ROUNDING: Final = 1e-9
# How matplotlib writes a power of ten at a tick.
_POWER: Final = r"$\mathdefault{10^{"


class Margins(LayoutEngine):
    """Layout of panels with margins for ticks, titles and words about them."""

    _adjust_compatible = True
    _colorbar_gridspec = False

    def __init__(self) -> None:
        """Leave no place for a title or a legend yet."""
        super().__init__()
        self.parts: dict[str, Legend | Text] = {}

    def set(self, **parts: Any) -> None:  # noqa: ANN401 - artists of matplotlib
        """Set the title or legend that has a place of its own: `head` above all panels, `foot`
        below them.
        """
        self.parts |= parts

    def execute(self, fig: Figure) -> None:
        """Place the panels."""
        panels = [(on, spec) for on in fig.axes if (spec := on.get_subplotspec()) is not None]
        dots, fig.dpi = fig.dpi, 72
        try:
            if panels:
                self._place(fig, panels)
        finally:
            fig.dpi = dots

    def _place(self, fig: Figure, panels: list[tuple[Axes, SubplotSpec]]) -> None:
        width, height = 72 * fig.get_size_inches()
        renderer = RendererSVG(width, height, io.StringIO())  # type: ignore[no-untyped-call]
        head, foot = (
            _WIDER * each.get_window_extent(renderer).height + EDGE if each else 0.0
            for each in map(self.parts.get, ("head", "foot"))
        )
        rows, columns = panels[0][1].get_gridspec().get_geometry()
        for _ in range(_PASSES):
            # before and after each column, above and below each row
            across, up = np.zeros((columns, 2)), np.zeros((rows, 2))
            for on, spec in panels:
                left, below, right, above = _needed(on, renderer)
                across[spec.colspan.start] = np.maximum(across[spec.colspan.start], (left, right))
                up[spec.rowspan.start] = np.maximum(up[spec.rowspan.start], (above, below))
            up[0, 0] += head
            up[-1, 1] += foot
            (left, right, between), (top, bottom, rising) = (
                _spaces(across, width),
                _spaces(up, height),
            )
            wanted, now = (
                np.array([left, bottom, 1 - right, 1 - top, between, rising]),
                fig.subplotpars,
            )
            if np.allclose(
                wanted,
                [now.left, now.bottom, now.right, now.top, now.wspace, now.hspace],
                rtol=0,
                atol=_CLOSE,
            ):
                break
            if left + right < 1 and top + bottom < 1:  # or the figure is too small to draw anything
                fig.subplots_adjust(*wanted)


def corner(fig: Figure, *, above: bool) -> Transform:
    """Return the transform of figure coordinates whose left corners above or below lie within the
    edge of the figure.
    """
    return fig.transFigure + ScaledTranslation(
        EDGE / 72, (-EDGE if above else EDGE) / 72, fig.dpi_scale_trans
    )


def _spaces(needed: Floats, size: float) -> tuple[float, float, float]:
    """Return the margins before and after panels in a line, as shares of a size (pt), and the space
    between them as a share of a panel.
    """
    count = len(needed)
    between = float((needed[:-1, 1] + needed[1:, 0]).max()) + _APART if count > 1 else 0.0
    first, last = needed[0, 0] + EDGE, needed[-1, 1] + EDGE
    panel = (size - first - last - (count - 1) * between) / count
    return (first / size, last / size, between / panel) if panel > 0 else (1.0, 1.0, 0.0)


def _needed(on: Axes, renderer: RendererSVG) -> Floats:
    """Return what the words about an axes need beyond its panel to the left, below, to the right
    and above, pt; and place the names of its axes.

    Axes of equal scales may be smaller than their panel.
    """
    on.apply_aspect()
    panel = on.get_position(original=True).transformed(on.figure.transSubfigure)
    box, square = on.bbox, on.name == "rectilinear"
    words = [
        each.get_window_extent(renderer).expanded(2 * _WIDER - 1, 1)
        for each in on.texts
        if each.get_text()
    ]
    lines = [each.get_window_extent(renderer) for each in on.lines if not each.get_clip_on()]
    around = Bbox.union([box, *words, *lines]) if square else on.get_tightbbox(renderer) or box
    out = np.array([box.x0 - around.x0, box.y0 - around.y0, around.x1 - box.x1, around.y1 - box.y1])
    if square:
        out = np.maximum(
            out,
            np.maximum(
                _along(on, on.xaxis, box.width), _along(on, on.yaxis, box.height)[[1, 0, 3, 2]]
            ),
        )
        titles = [on.get_title(place) for place in ("left", "center", "right")]
        out[3] += max(
            (_TITLE_PAD + _height(each, _size(on.title)) for each in titles if each), default=0.0
        )
    return np.asarray(
        np.maximum(
            0.0, out - [box.x0 - panel.x0, box.y0 - panel.y0, panel.x1 - box.x1, panel.y1 - box.y1]
        )
    )


def _along(on: Axes, axis: Axis, length: float) -> Floats:
    """Return what the labels of an axis of this length (pt) need: before its start, beside it,
    beyond its end, and nothing on its other side.

    The name of the axis is placed beside them.
    """
    upright, how = axis is on.yaxis, axis.get_tick_params()
    before, beside, beyond = 0.0, how.get("length", _PAD), 0.0
    if how.get("labelleft" if upright else "labelbottom", True):
        places, formatter = np.asarray(axis.get_majorticklocs()), axis.get_major_formatter()
        names, size = (
            formatter.format_ticks(places.tolist()),
            FontProperties(size=how.get("labelsize")).get_size_in_points(),
        )
        start, end, *at = axis.get_transform().transform(
            np.concatenate([axis.get_view_interval(), places])
        )
        shown = [
            (name, (each - start) / (end - start)) for name, each in zip(names, at, strict=True)
        ]
        shown = [
            (name, share) for name, share in shown if name and -_ROUNDING < share < 1 + _ROUNDING
        ]
        if shown:
            sizes = np.array([(_width(name, size), _height(name, size)) for name, _ in shown])
            along, depth = sizes.T[
                :: -1 if upright or how.get("rotation", how.get("labelrotation")) else 1
            ]
            share = np.array([each for _, each in shown])
            before, beyond = (
                float((along / 2 - share * length).max()),
                float((along / 2 - (1 - share) * length).max()),
            )
            beside += how.get("pad", _PAD) + float(depth.max())
        if formatter.get_offset() and upright:
            beyond = max(beyond, _PAD + _height("", size))
        elif formatter.get_offset():
            beside += _PAD + _height("", size)
    name, size = axis.get_label_text(), _size(axis.label)
    if name:
        beside += axis.labelpad
        to_left, down = (-beside, 0.0) if upright else (0.0, -beside)
        x, y = (
            (0.0, axis.label.get_position()[1]) if upright else (axis.label.get_position()[0], 0.0)
        )
        axis.set_label_coords(
            x,
            y,
            on.transAxes + ScaledTranslation(to_left / 72, down / 72, on.figure.dpi_scale_trans),
        )
        beside += _height(name, size)
        longer = (_width(name, size) - length) / 2
        before, beyond = max(before, longer), max(beyond, longer)
    return np.array([before, beside, beyond, 0.0])


def _size(text: Text) -> float:
    return text.get_fontproperties().get_size_in_points()


def _width(words: str, size: float) -> float:
    """Return the width of the longest line of words in this size, pt."""
    if words.startswith(_POWER):
        words = re.sub(r"\\mathdefault|[${}^]", "", words)
    return max(_width_in(line, size, findfont(FontProperties())) for line in words.split("\n"))


@functools.lru_cache(maxsize=4096)
def _width_in(words: str, size: float, font: str) -> float:
    """Return the width of a line of words in a font (file) of this size, pt."""
    return _WIDER * float(
        text_to_path.get_text_width_height_descent(
            words, FontProperties(fname=font, size=size), ismath=False
        )[0]
    )


def _height(words: str, size: float) -> float:
    """Return the height of lines of words in this size, pt."""
    return _LINE * size * (words.count("\n") + 1)
