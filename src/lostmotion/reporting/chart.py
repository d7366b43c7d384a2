"""The pieces that charts are made of: figures in mm, axes, bars, histograms, marks and legends.
Matplotlib is loaded when a chart is drawn.

Figures are made without pyplot. Their colours are those of the light palette.
"""

from __future__ import annotations

import math
import re
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from lostmotion.printed import factor_of
from lostmotion.reporting.chart_settings import SMALL, settings
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.spatial import Floats


WIDTH: Final = 130.0
_TITLE: Final = 10.5
_MM: Final = 1 / 25.4
# Widths in a legend, mm: of a letter, and of what stands beside an entry's name.
_LETTER: Final = 1.65
_ENTRY: Final = 9.0
_LONGEST_LABEL: Final = 36
_BAND: Final = 0.18
# Drawn before all words, which cover it.
_BELOW_WORDS: Final = 2.5
# Of the axes' width, from where on words stand to the left of what they mark.
_ROOM_LEFT: Final = 0.45


def figure(height: float, width: float = WIDTH) -> Figure:
    """Return an empty figure of this size (mm) whose axes are placed so that nothing overlaps."""
    from matplotlib.figure import Figure

    from lostmotion.reporting.chart_margins import Margins

    with settings():
        return Figure(figsize=(width * _MM, height * _MM), layout=Margins())


def axes(on: Figure, title: str = "", *, rows: int = 1, columns: int = 1, **how: Any) -> np.ndarray:  # noqa: ANN401 - options of Figure.subplots
    """Return new axes (rows, columns) on a figure, the title above the first."""
    from lostmotion.reporting.chart_margins import corner

    with settings():
        made: np.ndarray = on.subplots(rows, columns, squeeze=False, **how)
        for each in made.flat:
            each.tick_params(which="both", colors=LIGHT["quiet"], labelsize=SMALL, width=0.8)
            each.tick_params(length=3)
            each.set_axisbelow(True)
        if title:
            where: dict[str, Any] = {
                "x": 0,
                "y": 1,
                "ha": "left",
                "va": "top",
                "transform": corner(on, above=True),
            }
            _place(on, head=on.suptitle(title, fontsize=_TITLE, parse_math=False, **where))
    return made


def _place(on: Figure, **parts: Any) -> None:  # noqa: ANN401 - artists of matplotlib
    """Keep the place of a title or legend free: `head` above all axes, `foot` below."""
    layout = on.get_layout_engine()
    if layout is not None:
        layout.set(**parts)


def one(title: str, height: float, *, width: float = WIDTH) -> tuple[Figure, Axes]:
    """Return a figure of this height (mm) and its only axes."""
    made = figure(height, width)
    return made, axes(made, title)[0, 0]


def axes_by_unit(
    title: str, counts: Mapping[str, int], *, bar: float = 9.0
) -> tuple[Figure, dict[str, Axes]]:
    """Return a figure with axes for each unit that has bars, one below the other, as high as its
    bars (mm each).
    """
    shown = {unit: count for unit, count in counts.items() if count}
    made = figure(20 + sum(count * bar + 13 for count in shown.values()))
    panels = axes(made, title, rows=len(shown), height_ratios=list(shown.values()))[:, 0]
    return made, dict(zip(shown, panels, strict=True))


def grid(on: Axes, axis: Literal["x", "y", "both"] = "y") -> None:
    """Draw thin lines at the ticks of an axis, "x", "y" or "both", behind everything else."""
    on.grid(visible=True, axis=axis, color=LIGHT["line"], linewidth=0.6)


def logarithmic(on: Axes) -> None:
    """Make the horizontal axis logarithmic, with plain numbers at its main marks."""
    from matplotlib.ticker import FuncFormatter, NullFormatter

    on.set_xscale("log")
    on.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    on.xaxis.set_minor_formatter(NullFormatter())


def label_axes(on: Axes, x: str = "", y: str = "") -> None:
    """Name both axes with their units, in the axis colour."""
    if x:
        on.set_xlabel(x, color=LIGHT["quiet"])
    if y:
        on.set_ylabel(y, color=LIGHT["quiet"])


def text(
    on: Axes,
    x: float,
    y: float,
    words: str,
    *,
    colour: str = LIGHT["ink"],
    size: float = SMALL,
    **how: Any,  # noqa: ANN401
) -> None:
    """Write words at a point of the axes, without any markup in them. Shifts in pt: `xytext`."""
    where: dict[str, Any] = {
        "textcoords": "offset points",
        "xytext": (0, 0),
        "annotation_clip": False,
    } | how
    on.annotate(
        re.sub(r"(?<![\w.])-(?=\d)", "−", words),
        (x, y),
        color=colour,
        fontsize=size,
        parse_math=False,
        **where,
    )


def legend(on: Figure, *, extra: Iterable[Any] = ()) -> None:
    """Draw one legend between the title and the axes: every name once, in as many columns as
    fit.
    """
    found: dict[str, Any] = {}
    for each in on.axes:
        for handle, name in zip(*each.get_legend_handles_labels(), strict=True):
            found.setdefault(name, handle)
    found |= {str(handle.get_label()): handle for handle in extra}
    if not found:
        return
    place_legend(on, found, len(found))


def _columns(names: Sequence[str], width: float, most: int) -> int:
    """Return in how many columns, at most so many, these names of a legend fit into a width (mm);
    names fill the columns from the left.
    """
    for count in range(min(most, len(names)), 1, -1):
        full, short = divmod(len(names), count)
        starts = np.cumsum([0, *[full + 1] * short, *[full] * (count - short)])
        if sum(_LETTER * max(map(len, names[a:b])) + _ENTRY for a, b in pairwise(starts)) <= width:
            return count
    return 1


def place_legend(
    on: Figure, entries: dict[str, Any], most: int, title: str = "", *, above: bool = True
) -> None:
    """Draw a legend above or below all axes. Above, the figure's title becomes the legend's:
    matplotlib would draw one over the other.
    """
    from lostmotion.reporting.chart_margins import corner

    columns = _columns(list(entries), on.get_figwidth() / _MM, most)
    heading = on.get_suptitle() if above else title
    size, colour = (_TITLE, LIGHT["ink"]) if above else (SMALL, LIGHT["quiet"])
    if above:
        on.suptitle("")
    with settings():
        made = on.legend(
            list(entries.values()),
            list(entries),
            loc="upper left" if above else "lower left",
            bbox_to_anchor=(0, 1 if above else 0),
            bbox_transform=corner(on, above=above),
            borderaxespad=0.0,
            ncols=columns,
            title=heading,
            title_fontsize=size,
            alignment="left",
            borderpad=0.1,
            handlelength=1.2,
            columnspacing=1.4,
        )
    made.get_title().set_color(colour)
    _place(on, **{"head" if above else "foot": made})
    for each in (*made.get_texts(), made.get_title()):
        each.set_parse_math(False)


def swatch(name: str, colour: str) -> Any:  # noqa: ANN401 - an artist of matplotlib
    """Return a legend entry of one colour."""
    from matplotlib.patches import Patch

    return Patch(facecolor=colour, label=name)


def named_rows(on: Axes, names: Sequence[str]) -> None:
    """Write names beside bars at 0, 1, 2 …, the first on top, without a line or ticks."""
    on.set_yticks(
        range(len(names)), [label(name) for name in names], color=LIGHT["ink"], parse_math=False
    )
    on.set_ylim(len(names) - 0.5, -0.5)
    on.spines["left"].set_visible(False)
    on.tick_params(axis="y", length=0)


def stacked(
    on: Axes, rows: Sequence[tuple[str, str, Floats]], *, height: float = 0.62
) -> tuple[Floats, Floats]:
    """Draw horizontal bars stacked by name and colour, negative parts to the left of zero; return
    both ends of each bar.

    `rows` are (name, colour, values), one value for each bar.
    """
    count = len(rows[0][2]) if rows else 0
    low, high = np.zeros(count), np.zeros(count)
    for name, colour, values in rows:
        starts = np.where(values < 0, low, high)
        drawn = np.flatnonzero(values)
        if len(drawn):
            on.barh(
                drawn,
                values[drawn],
                left=starts[drawn],
                height=height,
                color=colour,
                label=name,
                linewidth=0,
            )
        low, high = low + np.minimum(values, 0), high + np.maximum(values, 0)
    if (low < 0).any():
        zero_line(on)
    return low, high


def grouped(on: Axes, rows: Sequence[tuple[str, str, Floats]], *, height: float = 0.74) -> None:
    """Draw horizontal bars side by side: `rows` are (name, colour, values), one value for each
    group.
    """
    thick = height / len(rows)
    for k, (name, colour, values) in enumerate(rows):
        middles = np.arange(len(values)) + (k - (len(rows) - 1) / 2) * thick
        on.barh(middles, values, height=0.92 * thick, color=colour, label=name, linewidth=0)
    if any((values < 0).any() for _, _, values in rows):
        zero_line(on)


def zero_line(on: Axes, axis: str = "x") -> None:
    """Draw a line at zero, from which bars extend to both sides."""
    (on.axvline if axis == "x" else on.axhline)(0.0, color=LIGHT["quiet"], linewidth=0.8)


def histogram(
    on: Axes, edges: Floats, counts: np.ndarray, colour: str = LIGHT["robot"], name: str = ""
) -> None:
    """Draw counts between edges as one outline filled with a colour."""
    on.stairs(counts, edges, fill=True, color=colour, label=name or None, linewidth=0)
    on.set_xlim(edges[0], edges[-1])
    on.set_ylim(bottom=0)


def mark(on: Axes, estimate: Estimate, name: str, unit: str, *, row: int = 0) -> None:
    """Draw a line at an estimate over its whole shaded interval, and its value above the axes,
    `row` lines up. Set the limits first.
    """
    factor = factor_of(unit)
    value, low, high = (end * factor for end in (estimate.value, estimate.low, estimate.high))
    if math.isfinite(high - low) and high > low:
        left, right = on.get_xlim()
        on.set_xlim(min(left, low), max(right, high))
        on.axvspan(low, high, color=LIGHT["warn"], alpha=_BAND, linewidth=0)
    words = f"{name} {length(estimate.value, estimate.low, estimate.high)}".strip()
    mark_at(on, value, words, row=row)


def mark_at(on: Axes, value: float, words: str, *, row: int = 0) -> None:
    """Draw a dotted line at a value, and words above the axes, `row` lines up, on that side of the
    line that has room. Set the limits first.
    """
    low, high = on.get_xlim()
    low, high = on.set_xlim(min(low, value), max(high, value))
    leftwards = value - low > _ROOM_LEFT * (high - low)
    top = 12.0 * row + 2
    on.axvline(value, color=LIGHT["warn"], linewidth=1.2, linestyle=(0, (1.5, 1.5)))
    if row:
        line = {
            "arrowstyle": "-",
            "color": LIGHT["warn"],
            "linewidth": 0.8,
            "shrinkA": 0,
            "shrinkB": 0,
        }
        on.annotate(
            "",
            (value, 1),
            xytext=(0, top),
            xycoords=on.get_xaxis_transform(),
            textcoords="offset points",
            arrowprops=line,
            zorder=_BELOW_WORDS,
        )
    how: dict[str, Any] = {
        "xytext": (3 if leftwards else -3, top),
        "ha": "right" if leftwards else "left",
        "va": "bottom",
    }
    # over the lines of higher rows
    ground = {"facecolor": LIGHT["paper"], "linewidth": 0, "pad": 0.5}
    text(
        on,
        value,
        1,
        words,
        colour=LIGHT["warn"],
        xycoords=on.get_xaxis_transform(),
        bbox=ground,
        **how,
    )


def dots(on: Axes, x: Floats, y: Floats, colour: str, name: str, size: float = 2.2) -> None:
    """Draw many points as one path of lines without length and with round ends: a tenth of the size
    of as many markers. Set the limits yourself.
    """
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    vertices = np.repeat(np.column_stack([x, y]), 2, axis=0)
    # some renderers draw no line without length
    vertices[1::2, 0] += 1e-9 * max(float(np.abs(vertices).max(initial=0.0)), 1e-9)
    path = Path(vertices, [int(Path.MOVETO), int(Path.LINETO)] * len(x))
    path.should_simplify = False
    # not `add_patch`, which searches each piece for its extremes
    on.add_artist(
        PathPatch(path, facecolor="none", edgecolor=colour, linewidth=size, capstyle="round")
    )
    on.plot(
        [],
        [],
        linestyle="none",
        marker="o",
        markersize=size,
        color=colour,
        markeredgewidth=0,
        label=name,
    )


def ringed(on: Axes, x: float, y: float, name: str) -> None:
    """Draw a ring about a point that the legend names."""
    on.plot(
        [x],
        [y],
        linestyle="none",
        marker="o",
        markersize=8,
        markerfacecolor="none",
        color=LIGHT["warn"],
        markeredgewidth=1.6,
        label=name,
        clip_on=False,
    )


def label(name: str) -> str:
    """Return a name of the arm, cut where it is too long to draw."""
    return name if len(name) <= _LONGEST_LABEL else name[: _LONGEST_LABEL - 1] + "…"
