"""Maps in the seven classes of an error: cells, contours, and the legend of the classes."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from lostmotion.printed import stated_text
from lostmotion.reporting.chart import place_legend, swatch
from lostmotion.reporting.palette import CLASSES, LIGHT

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.spatial import Floats


def class_of(values: Floats, limits: Sequence[float]) -> np.ndarray:
    """Return the class of each value by its limits; -1 where a value is not finite."""
    return np.where(np.isfinite(values), np.searchsorted(limits, values, side="right"), -1)


def class_names(limits: Sequence[float]) -> list[str]:
    """Return the name of each class by its limits: "< 0.4", "0.4 to 0.6", ..., "> 1.4"."""
    ends = [f"{limit:.10g}".replace("-", "−") for limit in limits]
    return [f"< {ends[0]}", *(f"{low} to {high}" for low, high in pairwise(ends)), f"> {ends[-1]}"]


def class_legend(
    on: Figure, limits: Sequence[float], title: str, extra: Iterable[Any] = ()
) -> None:
    """Draw the colours of the seven classes with their limits below all axes, and above them what
    they mean, with its unit.
    """
    entries = [
        *(swatch(name, colour) for name, colour in zip(class_names(limits), CLASSES, strict=True)),
        *extra,
    ]
    place_legend(on, {str(entry.get_label()): entry for entry in entries}, 4, title, above=False)


def cells(
    on: Axes, x: np.ndarray, y: np.ndarray, classes: np.ndarray, colours: Sequence[str] = CLASSES
) -> None:
    """Draw cells between edges x (across + 1,) and y (up + 1,) in the colours of their classes
    (across, up): one path for each class.

    Neighbours in a row of the same class are merged, which keeps the file small; negative classes
    are left empty.
    """
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    for k, colour in enumerate(colours):
        points: list[tuple[float, float]] = []
        codes: list[int] = []
        for row in range(classes.shape[1]):
            ends = np.flatnonzero(
                np.diff(np.concatenate([[0], (classes[:, row] == k).astype(int), [0]]))
            )
            for a, b in ends.reshape(-1, 2):
                points += [
                    (x[a], y[row]),
                    (x[b], y[row]),
                    (x[b], y[row + 1]),
                    (x[a], y[row + 1]),
                    (x[a], y[row]),
                ]
                codes += [int(Path.MOVETO), *3 * [int(Path.LINETO)], int(Path.CLOSEPOLY)]
        if points:
            on.add_artist(  # not `add_patch`, which searches each piece for its extremes
                PathPatch(
                    Path(np.array(points), codes), facecolor=colour, linewidth=0, antialiased=False
                )
            )
    on.set_xlim(x[0], x[-1])
    on.set_ylim(y[0], y[-1])


def contour(
    on: Axes, x: Floats, y: Floats, values: Floats, level: float, name: str, unit: str
) -> None:
    """Draw the line at a level, in `unit`, of the values (across, up) of cells with these centres,
    m, where it crosses them; the legend names it.
    """
    known = values[np.isfinite(values)]
    if min(values.shape) < 2 or not (known < level).any() or not (known > level).any():  # noqa: PLR2004 - a contour needs an area
        return
    for colour, width in ((LIGHT["paper"], 3.0), (LIGHT["ink"], 1.2)):
        on.contour(
            x * 1e3,
            y * 1e3,
            np.ma.masked_invalid(values.T),
            levels=[level],
            colors=[colour],
            linewidths=[width],
        )
    on.plot(
        [],
        [],
        color=LIGHT["ink"],
        linewidth=1.2,
        label=f"{name} {stated_text(level)} {unit}",
    )
