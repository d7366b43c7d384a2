"""Figures of a stage by finite elements."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.printed import stated_text
from lostmotion.reporting.sheet import Card, Cell, Row, Section

if TYPE_CHECKING:
    from lostmotion.parts.gearbox.cycloidal.finite_elements import FiniteElements

_COLUMNS: Final = (
    "rotation, plane strain",
    "rotation, plane stress",
    "stiffness",
    "peak pressure",
    "largest von Mises stress",
    "equivalent strain",
    "strain as an angle, the paper's conversion",
)
_COLUMN_3D: Final = "rotation, 3-D"
_SOURCE: Final = "finite elements of the stage as drawn"


def fem_key(found: FiniteElements) -> str:
    """Return the key of a stage's section."""
    return "fem-first" if found.name == "first stage" else "fem"


def fem_sentences(stages: tuple[FiniteElements, ...]) -> list[str]:
    """Return a sentence of the headline for each stage by finite elements: rotation, and where
    pressure and stress are largest.
    """
    return [
        f"By finite elements the {found.name} turns by {_rotation(found)} beyond its play "
        f"under {_torque(found)}; the peak pressure is "
        f"{_pressure(found)} at θ = {_hardest(found):.1f}°, the largest von Mises stress "
        f"{_stress(found)} in the {found.most_stressed.body} at "
        f"{place_text(found.most_stressed.place)}."
        for found in stages
    ]


def fem_cards(stages: tuple[FiniteElements, ...]) -> tuple[Card, ...]:
    """Return the cards of each stage by finite elements."""
    out = []
    for found in stages:
        of = "" if len(stages) == 1 else f", {found.name}"
        out += [
            Card(
                f"rotation by finite elements{of}",
                _rotation(found),
                f"at {_torque(found)}, beyond the play; {_planes(found)}",
            ),
            Card(
                f"peak pressure by finite elements{of}",
                str(_pressure(found)),
                f"at {_torque(found)}, lobe at θ = {_hardest(found):.1f}°",
            ),
            Card(
                f"largest von Mises stress{of}",
                str(_stress(found)),
                (
                    f"at {_torque(found)}, {found.most_stressed.body}, "
                    f"{place_text(found.most_stressed.place)}"
                ),
            ),
        ]
    return tuple(out)


def place_text(place: complex) -> str:
    """Return a place in the plane of the stage (m) as text, from the ring's centre."""
    return f"x {place.real * 1e3:.3g} mm, y {place.imag * 1e3:.3g} mm".replace("-", "−")


def _torque(found: FiniteElements) -> str:
    return f"{stated_text(float(found.torque[-1]))} N m"


def _rotation(found: FiniteElements) -> str:
    """Return the rotation at the largest torque: in three dimensions, or the range from plane
    strain to plane stress.
    """
    if found.rotation_3d is not None:
        return str(Cell(float(found.rotation_3d[-1]), "arcmin"))
    low, high = (Cell(float(each), "arcmin") for each in found.rotation[:, -1])
    return f"{low.number} to {high}"


def _planes(found: FiniteElements) -> str:
    return "plane strain to plane stress" if found.rotation_3d is None else "3-D"


def _pressure(found: FiniteElements) -> Cell:
    return Cell(float(found.loaded.peak[-1].max()), "GPa")


def _hardest(found: FiniteElements) -> float:
    """Return the angle of the contact with the largest pressure, degrees."""
    return math.degrees(found.loaded.theta[int(found.loaded.peak[-1].argmax())])


def _stress(found: FiniteElements) -> Cell:
    return Cell(found.most_stressed.value, "MPa")


def fem_sections(stages: tuple[FiniteElements, ...]) -> tuple[Section, ...]:
    """Return the sections of the finite elements by stage: figures over the torque, and the loads
    of the lobes.
    """
    return tuple(section for found in stages for section in _of_stage(found))


def _of_stage(found: FiniteElements) -> tuple[Section, Section]:
    rows = [
        Row(f"{stated_text(float(torque))} N m", _figures(found, k))
        for k, torque in enumerate(found.torque)
    ]
    columns = _COLUMNS if found.rotation_3d is None else (*_COLUMNS[:2], _COLUMN_3D, *_COLUMNS[2:])
    off = 100 * float(found.error[-1] / found.rotation[0, -1])
    branch = (
        "; contacts of both branches of the envelope ring"
        if found.stage.kind == "lobe envelope"
        else ""
    )
    unmeshed = f"; not meshed: the {found.not_meshed}" if found.not_meshed else ""
    note = (
        f"{found.name}, crank at zero, equal discs; torque, rotation beyond the play and "
        "stiffness at the output of the gearbox; the true disc is "
        "between plane strain and plane stress, stresses are those of plane strain; without "
        "bearings, output pins and frame; at the largest torque "
        f"two meshes differ by {off:.2g} % in rotation, below it by more. A strain is no "
        "rotation: the last column is the conversion of "
        f"S. Strutynskyi and R. Semenchuk (2021), for comparison{branch}{_note_3d(found)}{unmeshed}"
    )
    theta = found.loaded.theta
    loads = [
        Row(
            f"θ = {math.degrees(theta[k]):.1f}°",
            (
                Cell(float(found.loaded.forces[-1, k]), "N", samples=_SOURCE),
                Cell(float(found.loaded.peak[-1, k]), "GPa", samples=_SOURCE),
                Cell(float(found.loaded.half_width[-1, k]), "µm", samples=_SOURCE),
            ),
        )
        for k in sorted(np.flatnonzero(found.loaded.forces[-1] > 0), key=lambda k: theta[k])
    ]
    per_disc = (
        f"one disc of the {found.name}, under its share of {stated_text(float(found.torque[-1]))} "
        "N m at the output, plane strain"
    )
    key, of_stage = fem_key(found), ", first stage" if fem_key(found) != "fem" else ""
    return (
        Section(key, f"Finite elements{of_stage}", columns, tuple(rows), note),
        Section(
            f"{key}-lobes",
            f"Load of the lobes by finite elements{of_stage}",
            ("load", "peak pressure", "half-width"),
            tuple(loads),
            per_disc,
        ),
    )


def _note_3d(found: FiniteElements) -> str:
    """Return what three dimensions assume, and their error."""
    if found.rotation_3d is None or found.error_3d is None:
        return ""
    return (
        "; 3-D is coarse: disc and its share of the ring over the width, with free faces and "
        "bonded fixed circles, displacements in the plane equal "
        "over the width and linear across it, up to 1 % too stiff; two meshes differ by "
        f"{100 * float(found.error_3d[-1] / found.rotation_3d[-1]):.2g} % "
        f"({found.unknowns:_} unknowns)"
    ).replace("_", " ")


def _figures(found: FiniteElements, k: int) -> tuple[Cell, ...]:
    strain = float(found.strain[k])
    solid = () if found.rotation_3d is None else ((float(found.rotation_3d[k]), "arcmin"),)
    return tuple(
        Cell(value, unit, samples=_SOURCE)
        for value, unit in (
            (float(found.rotation[0, k]), "arcmin"),
            (float(found.rotation[1, k]), "arcmin"),
            *solid,
            (float(found.stiffness[k]), "N m/arcmin"),
            (float(found.loaded.peak[k].max()), "GPa"),
            (float(found.stress[k]), "MPa"),
            (strain, "1"),
            (strain, "arcmin"),
        )
    )
