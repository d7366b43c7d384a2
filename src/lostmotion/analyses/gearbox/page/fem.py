"""Figures of a stage by finite elements."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.finite_elements.raster import outline, raster
from lostmotion.printed import ARCMIN, stated_text
from lostmotion.reporting.chart import (
    grid,
    label_axes,
    legend,
    one,
)
from lostmotion.reporting.map_chart import cells, class_legend, class_of
from lostmotion.reporting.palette import LIGHT, class_limits, round_below
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Card, Cell, table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.parts.gearbox.cycloidal.finite_elements import FiniteElements, Largest
    from lostmotion.reporting.sheet import Section
    from lostmotion.spatial import Floats

_SOURCE: Final = "finite elements of the stage as drawn"
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


def fem_key(stage: FiniteElements) -> str:
    """Return the key of a stage's section."""
    return "fem-first" if stage.name == "first stage" else "fem"


def fem_sentences(stages: tuple[FiniteElements, ...]) -> list[str]:
    """Return a sentence of the headline for each stage by finite elements: rotation, and where
    pressure and stress are largest.
    """
    return [
        f"By finite elements the {stage.name} turns by {_rotation(stage)} beyond its play "
        f"under {_torque(stage)}; the peak pressure is "
        f"{_pressure(stage)} at θ = {_hardest(stage):.1f}°, the largest von Mises stress "
        f"{_stress(stage)} in the {stage.most_stressed.body} at "
        f"{place_text(stage.most_stressed.place)}."
        for stage in stages
    ]


def fem_cards(stages: tuple[FiniteElements, ...]) -> tuple[Card, ...]:
    """Return the cards of each stage by finite elements."""
    out = []
    for stage in stages:
        of = "" if len(stages) == 1 else f", {stage.name}"
        out += [
            Card(
                f"rotation by finite elements{of}",
                _rotation(stage),
                f"at {_torque(stage)}, beyond the play; {_planes(stage)}",
            ),
            Card(
                f"peak pressure by finite elements{of}",
                str(_pressure(stage)),
                f"at {_torque(stage)}, lobe at θ = {_hardest(stage):.1f}°",
            ),
            Card(
                f"largest von Mises stress{of}",
                str(_stress(stage)),
                (
                    f"at {_torque(stage)}, {stage.most_stressed.body}, "
                    f"{place_text(stage.most_stressed.place)}"
                ),
            ),
        ]
    return tuple(out)


def place_text(place: complex) -> str:
    """Return a place in the plane of the stage (m) as text, from the ring's centre."""
    return f"x {place.real * 1e3:.3g} mm, y {place.imag * 1e3:.3g} mm".replace("-", "−")


def _torque(stage: FiniteElements) -> str:
    return f"{stated_text(float(stage.torque[-1]))} N m"


def _rotation(stage: FiniteElements) -> str:
    """Return the rotation at the largest torque: in three dimensions, or the range from plane
    strain to plane stress.
    """
    if stage.rotation_3d is not None:
        return str(Cell(float(stage.rotation_3d[-1]), "arcmin"))
    low, high = (Cell(float(each), "arcmin") for each in stage.rotation[:, -1])
    return f"{low.number} to {high}"


def _planes(stage: FiniteElements) -> str:
    return "plane strain to plane stress" if stage.rotation_3d is None else "3-D"


def _pressure(stage: FiniteElements) -> Cell:
    return Cell(float(stage.loaded.peak[-1].max()), "GPa")


def _hardest(stage: FiniteElements) -> float:
    """Return the angle of the contact with the largest pressure, degrees."""
    return math.degrees(stage.loaded.theta[int(stage.loaded.peak[-1].argmax())])


def _stress(stage: FiniteElements) -> Cell:
    return Cell(stage.most_stressed.value, "MPa")


def fem_sections(stages: tuple[FiniteElements, ...]) -> tuple[Section, ...]:
    """Return the sections of the finite elements by stage: figures over the torque, and the loads
    of the lobes.
    """
    return tuple(section for stage in stages for section in _sections_of(stage))


def _sections_of(stage: FiniteElements) -> tuple[Section, Section]:
    solid = stage.rotation_3d is not None
    columns = {
        "rotation, plane strain": "arcmin",
        "rotation, plane stress": "arcmin",
        **({"rotation, 3-D": "arcmin"} if solid else {}),
        "stiffness": "N m/arcmin",
        "peak pressure": "GPa",
        "largest von Mises stress": "MPa",
        "equivalent strain": "1",
        "strain as an angle, the paper's conversion": "arcmin",
    }
    figures = (
        *stage.rotation,
        *(() if stage.rotation_3d is None else (stage.rotation_3d,)),
        stage.stiffness,
        stage.loaded.peak.max(axis=1),
        stage.stress,
        stage.strain,
        stage.strain,
    )
    rows = (
        (f"{stated_text(float(torque))} N m", *values)
        for torque, *values in zip(stage.torque, *figures, strict=True)
    )
    branch = (
        "; contacts of both branches of the envelope ring"
        if stage.stage.kind == "lobe envelope"
        else ""
    )
    unmeshed = f"; not meshed: the {stage.not_meshed}" if stage.not_meshed else ""
    note = (
        f"{stage.name}, crank at zero, equal discs; torque, rotation beyond the play and "
        "stiffness at the output of the gearbox; the true disc is "
        "between plane strain and plane stress, stresses are those of plane strain; without "
        f"bearings, output pins and frame; in rotation {_differ(stage.error, stage.rotation[0])}. "
        "A strain is no rotation: the last column is the conversion of "
        f"S. Strutynskyi and R. Semenchuk (2021), for comparison{branch}{_note_3d(stage)}{unmeshed}"
    )
    theta, forces = stage.loaded.theta, stage.loaded.forces[-1]
    loads = (
        (
            f"θ = {math.degrees(theta[k]):.1f}°",
            forces[k],
            stage.loaded.peak[-1, k],
            stage.loaded.half_width[-1, k],
        )
        for k in sorted(np.flatnonzero(forces > 0), key=lambda k: theta[k])
    )
    key = fem_key(stage)
    of_stage = ", first stage" if key != "fem" else ""
    return (
        table(key, f"Finite elements{of_stage}", columns, rows, note, samples=_SOURCE),
        table(
            f"{key}-lobes",
            f"Load of the lobes by finite elements{of_stage}",
            {"load": "N", "peak pressure": "GPa", "half-width": "µm"},
            loads,
            f"one disc of the {stage.name}, under its share of {_torque(stage)} "
            "at the output, plane strain",
            samples=_SOURCE,
        ),
    )


def _note_3d(stage: FiniteElements) -> str:
    """Return what three dimensions assume, and their error."""
    if stage.rotation_3d is None or stage.error_3d is None:
        return ""
    return (
        "; 3-D is coarse: disc and its share of the ring over the width, with free faces and "
        "bonded fixed circles, displacements in the plane equal "
        "over the width and linear across it, up to 1 % too stiff; "
        f"{_differ(stage.error_3d, stage.rotation_3d)} ({stage.unknowns:_} unknowns)"
    ).replace("_", " ")


def _differ(errors: Floats, rotations: Floats) -> str:
    """Return by how much the finer mesh changed the rotation under each torque."""
    shares = ", ".join(f"{share:.2g}" for share in 100 * errors / rotations)
    return f"two meshes differ by {shares} % at these torques"


def fem_plots(stages: tuple[FiniteElements, ...]) -> list[Plot]:
    """Return the pictures of all stages by finite elements."""
    return [plot for stage in stages for plot in _plots_of(stage)]


def _plots_of(stage: FiniteElements) -> list[Plot]:
    stress, strain = (
        [each.von_mises / 1e6 for each in stage.fields],
        [1e6 * each.strain for each in stage.fields],
    )
    key, of_stage = fem_key(stage), f"of the {stage.name}"
    outlined = f"of disc and ring {of_stage}, with the deformed outline."
    around = f"Von Mises stress around the contact with the largest pressure {of_stage}."
    read = f"Rotation over torque {of_stage}, with the equivalent strain read as an angle."
    by_stress = whole(stage, stress, "Von Mises stress", "MPa", stage.most_stressed)
    by_strain = whole(stage, strain, "Equivalent strain", "µm/m", stage.most_strained)
    return [
        Plot(f"{key}-stress", key, by_stress, f"Von Mises stress {outlined}"),
        Plot(f"{key}-strain", key, by_strain, f"Equivalent strain {outlined}"),
        Plot(f"{key}-contact", f"{key}-lobes", contact(stage, stress), around),
        Plot(f"{key}-angle", key, angles(stage), read),
    ]


def whole(
    stage: FiniteElements, values: list[Floats], name: str, unit: str, largest: Largest
) -> Figure:
    """Draw a field of both wheels in classes, with undeformed and deformed outlines and a mark
    where it is largest.
    """
    radius = max(float(np.abs(each.points).max()) for each in stage.fields)
    picture = np.fmax.reduce(
        [
            raster(f, v, -radius, -radius, radius, _WHOLE)
            for f, v in zip(stage.fields, values, strict=True)
        ]
    )
    top = float(np.nanquantile(picture, _SHOWN))
    moved = [_moved(stage, k) for k in range(len(stage.fields))]
    scale = round_below(_DRAWN * radius / max(float(np.abs(each).max()) for each in moved))
    figure, on = one(
        f"{name}, {stage.name}, {stated_text(float(stage.torque[-1]))} N m at the output", _HEIGHT
    )
    limits = _picture(on, picture, -radius, -radius, radius, top)
    for colour, width, factor, words in (
        (LIGHT["quiet"], 0.6, 0.0, "unloaded"),
        (LIGHT["ink"], 0.9, scale, f"loaded, displacements x {scale:g}"),
    ):
        parts = [
            outline(each, each.points + factor * by, _SPACING * radius)
            for each, by in zip(stage.fields, moved, strict=True)
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


def contact(stage: FiniteElements, stress: list[Floats]) -> Figure:
    """Draw the stress around the contact with the largest pressure, in classes."""
    k = int(stage.loaded.peak[-1].argmax())
    at = stage.loaded.place[k]
    half = _AROUND * float(stage.loaded.half_width[-1, k])
    pictures = [
        raster(f, v, at.real - half, at.imag - half, at.real + half, _ZOOM)
        for f, v in zip(stage.fields, stress, strict=True)
    ]
    picture = np.fmax.reduce(pictures)
    figure, on = one(
        f"Von Mises stress, {stage.name}, at θ = {math.degrees(stage.loaded.theta[k]):.1f}°",
        _HEIGHT,
    )
    limits = _picture(
        on, picture, at.real - half, at.imag - half, at.real + half, float(np.nanmax(picture))
    )
    _mark(
        on,
        complex(at),
        f"contact as drawn, peak pressure {Cell(float(stage.loaded.peak[-1, k]), 'GPa')}",
        "x",
    )
    largest = stage.most_stressed
    if max(abs(largest.place.real - at.real), abs(largest.place.imag - at.imag)) < half:
        _mark(
            on,
            largest.place,
            f"largest stress, {Cell(largest.value, 'MPa')}, in the {largest.body}",
        )
    _square(on)
    class_legend(figure, limits, "von Mises stress [MPa]", on.get_legend_handles_labels()[0])
    return figure


def angles(stage: FiniteElements) -> Figure:
    """Draw the rotation over the torque, and the equivalent strain as an angle."""
    figure, on = one(f"Rotation, and strain read as an angle, {stage.name}", 84)
    grid(on, "both")
    solid = (
        ()
        if stage.rotation_3d is None
        else (("rotation, 3-D", stage.rotation_3d, LIGHT["ink"], "-"),)
    )
    for name, values, colour, line in (
        ("rotation, plane strain", stage.rotation[0], LIGHT["robot"], "-"),
        ("rotation, plane stress", stage.rotation[1], LIGHT["design"], "-"),
        *solid,
        (
            "largest equivalent strain as an angle, the paper's conversion",
            stage.strain,
            LIGHT["warn"],
            "--",
        ),
    ):
        on.plot(
            stage.torque,
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


def _moved(stage: FiniteElements, k: int) -> Floats:
    """Return the displacement of a wheel's points, m, with the rotation of the disc."""
    field = stage.fields[k]
    if k:
        return field.displacement
    # counter-clockwise, against the loaded contacts; the crank is at zero
    away = field.points @ np.array([1, 1j]) - stage.stage.eccentricity
    turned = 1j * stage.turn * away
    return np.asarray(field.displacement + np.stack([turned.real, turned.imag], axis=-1))


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
