"""Pictures of a stage by finite elements: stress and strain of both wheels, their deformed outline,
the most loaded contact, angles over torque.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.gearbox.tables.finite_elements import fem_key
from lostmotion.printed import ARCMIN, stated_text
from lostmotion.reporting.chart import cells, class_legend, class_of, grid, label_axes, legend, one
from lostmotion.reporting.palette import LIGHT, class_limits, round_below
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Cell

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.laws.cycloid.finite_elements.wheel import Field
    from lostmotion.parts.gearbox.cycloidal.finite_elements import FiniteElements, Largest
    from lostmotion.spatial import Floats

_MM: Final = 1e3
# Pixels along each side of a picture.
_WHOLE: Final = 170
_ZOOM: Final = 120
# Height of a picture, mm.
_HEIGHT: Final = 150.0
# Share of the pixels below the end of the colours of the whole stage: contacts exceed it.
_SHOWN: Final = 0.995
# Half a side of the zoom, in half-widths of the contact.
_AROUND: Final = 4.0
# Largest displacement as drawn, and the spacing of outlines, as shares of the stage's radius.
_DRAWN: Final = 0.04
_SPACING: Final = 4e-3
# Pixels on the side of a triangle belong to it.
_EDGE: Final = 1e-9


def fem_plots(stages: tuple[FiniteElements, ...]) -> list[Plot]:
    """Return the pictures of all stages by finite elements."""
    return [plot for found in stages for plot in _of_stage(found)]


def _of_stage(found: FiniteElements) -> list[Plot]:
    stress, strain = (
        [each.von_mises / 1e6 for each in found.fields],
        [1e6 * each.strain for each in found.fields],
    )
    key, of_stage = fem_key(found), f"of the {found.name}"
    pictures = (
        whole(found, stress, "Von Mises stress", "MPa", found.most_stressed),
        whole(found, strain, "Equivalent strain", "µm/m", found.most_strained),
    )
    return [
        Plot(
            f"{key}-stress",
            key,
            pictures[0],
            f"Von Mises stress of disc and ring {of_stage}, with the deformed outline.",
        ),
        Plot(
            f"{key}-strain",
            key,
            pictures[1],
            f"Equivalent strain of disc and ring {of_stage}, with the deformed outline.",
        ),
        Plot(
            f"{key}-contact",
            f"{key}-lobes",
            contact(found, stress),
            f"Von Mises stress around the contact with the largest pressure {of_stage}.",
        ),
        Plot(
            f"{key}-angle",
            key,
            angles(found),
            f"Rotation over torque {of_stage}, with the equivalent strain read as an angle.",
        ),
    ]


def whole(
    found: FiniteElements, values: list[Floats], name: str, unit: str, largest: Largest
) -> Figure:
    """Draw a field of both wheels in classes, with undeformed and deformed outlines and a mark
    where it is largest.
    """
    radius = max(float(np.abs(each.points).max()) for each in found.fields)
    picture = np.fmax.reduce(
        [
            raster(f, v, -radius, -radius, radius, _WHOLE)
            for f, v in zip(found.fields, values, strict=True)
        ]
    )
    top = float(np.nanquantile(picture, _SHOWN))
    moved = [_moved(found, k) for k in range(len(found.fields))]
    scale = round_below(_DRAWN * radius / max(float(np.abs(each).max()) for each in moved))
    figure, on = one(
        f"{name}, {found.name}, {stated_text(float(found.torque[-1]))} N m at the output", _HEIGHT
    )
    limits = _picture(on, picture, -radius, -radius, radius, top)
    for colour, width, factor, words in (
        (LIGHT["quiet"], 0.6, 0.0, "unloaded"),
        (LIGHT["ink"], 0.9, scale, f"loaded, displacements x {scale:g}"),
    ):
        parts = [
            _outline(each, each.points + factor * by, _SPACING * radius)
            for each, by in zip(found.fields, moved, strict=True)
        ]
        on.plot(*(np.concatenate(parts).T * _MM), color=colour, linewidth=width, label=words)
    _mark(on, largest.place, f"largest, {Cell(largest.value, unit)}, in the {largest.body}")
    _square(on)
    class_legend(
        figure,
        limits,
        f"{name[:1].lower()}{name[1:]} [{unit}]; higher at the contacts",
        on.get_legend_handles_labels()[0],
    )
    return figure


def contact(found: FiniteElements, stress: list[Floats]) -> Figure:
    """Draw the stress around the contact with the largest pressure, in classes."""
    k = int(found.loaded.peak[-1].argmax())
    at = found.loaded.place[k]
    half = _AROUND * float(found.loaded.half_width[-1, k])
    pictures = [
        raster(f, v, at.real - half, at.imag - half, at.real + half, _ZOOM)
        for f, v in zip(found.fields, stress, strict=True)
    ]
    picture = np.fmax.reduce(pictures)
    figure, on = one(
        f"Von Mises stress, {found.name}, at θ = {math.degrees(found.loaded.theta[k]):.1f}°",
        _HEIGHT,
    )
    limits = _picture(
        on, picture, at.real - half, at.imag - half, at.real + half, float(np.nanmax(picture))
    )
    _mark(
        on,
        complex(at),
        f"contact as drawn, peak pressure {Cell(float(found.loaded.peak[-1, k]), 'GPa')}",
        "x",
    )
    largest = found.most_stressed
    if max(abs(largest.place.real - at.real), abs(largest.place.imag - at.imag)) < half:
        _mark(
            on,
            largest.place,
            f"largest stress, {Cell(largest.value, 'MPa')}, in the {largest.body}",
        )
    _square(on)
    class_legend(figure, limits, "von Mises stress [MPa]", on.get_legend_handles_labels()[0])
    return figure


def angles(found: FiniteElements) -> Figure:
    """Draw the rotation over the torque, and the equivalent strain as an angle."""
    figure, on = one(f"Rotation, and strain read as an angle, {found.name}", 84)
    grid(on, "both")
    solid = (
        ()
        if found.rotation_3d is None
        else (("rotation, 3-D", found.rotation_3d, LIGHT["ink"], "-"),)
    )
    for name, values, colour, line in (
        ("rotation, plane strain", found.rotation[0], LIGHT["robot"], "-"),
        ("rotation, plane stress", found.rotation[1], LIGHT["design"], "-"),
        *solid,
        (
            "largest equivalent strain as an angle, the paper's conversion",
            found.strain,
            LIGHT["warn"],
            "--",
        ),
    ):
        on.plot(
            found.torque,
            values / ARCMIN,
            label=name,
            color=colour,
            linestyle=line,
            linewidth=1.4,
            marker="o",
            markersize=3,
        )
    on.set_xlim(left=0)
    on.set_ylim(bottom=0)
    label_axes(on, "torque at the output [N m]", "angle [arcmin]")
    legend(figure)
    return figure


def raster(
    field: Field, values: Floats, left: float, low: float, right: float, pixels: int
) -> Floats:
    """Return a field (point,) on a square of pixels (row, column), NaN outside of the body; peaks
    between pixels are kept as their pixel's value.
    """
    step = (right - left) / pixels
    at = (field.points - [left, low]) / step - 0.5
    out = np.full((pixels, pixels), np.nan)
    corners = at[field.triangles]
    inside = (corners.max(axis=1) >= 0).all(axis=1) & (corners.min(axis=1) <= pixels - 1).all(
        axis=1
    )
    for triangle, corner in zip(field.triangles[inside], corners[inside], strict=True):
        (x0, y0), (x1, y1) = (
            np.maximum(np.ceil(corner.min(axis=0)), 0).astype(int),
            np.minimum(np.floor(corner.max(axis=0)), pixels - 1).astype(int),
        )
        if x1 < x0 or y1 < y0:
            continue
        y, x = np.mgrid[y0 : y1 + 1, x0 : x1 + 1]
        a, b, c = corner
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
        third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
        within = (second >= -_EDGE) & (third >= -_EDGE) & (second + third <= 1 + _EDGE)
        first, of_second, of_third = values[triangle]
        out[y[within], x[within]] = (
            first + second * (of_second - first) + third * (of_third - first)
        )[within]
    column, row = np.round(at).astype(int).T
    seen = (column >= 0) & (column < pixels) & (row >= 0) & (row < pixels)
    np.fmax.at(out, (row[seen], column[seen]), values[seen])
    return out


def _moved(found: FiniteElements, k: int) -> Floats:
    """Return the displacement of a wheel's points, m, with the rotation of the disc."""
    field = found.fields[k]
    if k:
        return field.displacement
    # counter-clockwise, against the loaded contacts; the crank is at zero
    away = field.points @ np.array([1, 1j]) - found.stage.eccentricity
    turned = 1j * found.turn * away
    return np.asarray(field.displacement + np.stack([turned.real, turned.imag], axis=-1))


def _outline(field: Field, points: Floats, spacing: float) -> Floats:
    """Return the closed boundaries of a mesh, with points no closer than `spacing`, as lines
    (point, 2) with gaps of NaN.
    """
    sides = np.concatenate([field.triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    _, first, times = np.unique(
        np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True
    )
    after = dict(sides[first[times == 1]].tolist())
    lines = []
    while after:
        start, here = after.popitem()
        line = [points[start]]
        while here != start:
            if float(np.abs(points[here] - line[-1]).max()) > spacing:
                line.append(points[here])
            here = after.pop(here)
        lines += [*line, line[0], np.full(2, np.nan)]
    return np.array(lines)


def _picture(
    on: Axes, values: Floats, left: float, low: float, right: float, top: float
) -> list[float]:
    """Draw values (row, column) on a square in classes from zero to `top`, and return the limits of
    the classes.
    """
    step = (right - left) / len(values)
    x, y = (_MM * (start + step * np.arange(len(values) + 1)) for start in (left, low))
    limits = class_limits(0.0, top)
    cells(on, x, y, class_of(values.T, limits))
    return limits


def _mark(on: Axes, place: complex, words: str, sign: str = "o") -> None:
    """Mark a place (m), named in the legend."""
    at = place.real * _MM, place.imag * _MM
    on.plot(
        *at,
        sign,
        color=LIGHT["warn"],
        markerfacecolor="none",
        markersize=9,
        markeredgewidth=1.8,
        linestyle="none",
        label=words,
    )


def _square(on: Axes) -> None:
    on.set_aspect("equal")
    label_axes(on, "x [mm]", "y [mm]")
