"""Plot of a cycloidal gearbox at true scale: discs, ring, pitch point, and the force on each
lobe.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.laws.cycloid.envelope import second_contact_places
from lostmotion.laws.cycloid.geometry import normals, pin_angles, planet_pose
from lostmotion.laws.cycloid.outline import ring_outline, wheel_outline
from lostmotion.parts.gearbox.kinds import is_drawn
from lostmotion.reporting.chart import label_axes, legend, one, text
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.sheet import Cell

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.analyses.gearbox.gear import Gear
    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.parts.gearbox.cycloidal.examined import Lobes
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.spatial import Floats

_MM: Final = 1e3
# Largest chord error of the plot, and the length of the largest force, as shares of the ring's
# radius.
_FINE: Final = 8e-4
_LONGEST: Final = 0.3
# Points of a small circle, and of one as large as a wheel.
_SMALL: Final = 24
_LARGE: Final = 120
_LINES: Final = (LIGHT["robot"], LIGHT["design"], LIGHT["visit"], LIGHT["warn"])
_FILL: Final = 0.1
_THIN: Final = 0.6
# Length of an arrow's head, of the arrow's.
_HEAD: Final = 0.22
_HEIGHT: Final = 160.0
_GAP: Final = complex(math.nan, math.nan)


def profile(gear: Gear) -> Figure:
    """Draw discs, ring and pins of the output stage at crank angle zero, and the forces on the
    lobes of the first disc.
    """
    part, drawn = gear.gearbox, gear.drawn
    if not is_drawn(part) or drawn is None:
        raise ValueError("a gearbox by stated figures has no profile")
    stage, lobes = part.stage, drawn.lobes[0]
    figure, on = one("Profile and forces on the ring", _HEIGHT)
    _ring(on, part)
    for disc in range(part.discs):
        _planet(on, part, disc)
    _circles(on, part)
    _centres(on, stage)
    _contacts(on, stage)
    _forces(on, stage, lobes)
    _places(on, stage)
    on.set_aspect("equal")
    label_axes(on, "x, along the line of centres [mm]", "y [mm]")
    legend(figure)
    return figure


def _line(
    on: Axes,
    points: np.ndarray,
    name: str,
    colour: str,
    width: float = 0.9,
    line: str = "-",
    fill: float = 0.0,
) -> None:
    """Draw complex points as a line in mm, with gaps where they are not numbers; `fill`: opacity of
    what it encloses.
    """
    x, y = points.real * _MM, points.imag * _MM
    on.plot(x, y, color=colour, linewidth=width, linestyle=line, label=name or None)
    if fill:
        on.fill(x, y, color=colour, alpha=fill, linewidth=0)


def _complex(points: Floats) -> np.ndarray:
    return np.asarray(points[:, 0] + 1j * points[:, 1])


def _closed(points: np.ndarray) -> np.ndarray:
    return np.concatenate([points, points[:1]])


def _round(places: np.ndarray, radius: float) -> np.ndarray:
    """Return circles around centres, separated by gaps in the line."""
    corners = _SMALL if len(places) > 1 else _LARGE
    ring = radius * np.exp(2j * math.pi * np.arange(corners + 1) / corners)
    gap = np.full((len(places), 1), _GAP)
    return np.concatenate([places[:, None] + ring, gap], axis=1).ravel()


def _around(count: int, radius: float) -> np.ndarray:
    return np.asarray(radius * np.exp(2j * math.pi * np.arange(count) / count))


def _ring(on: Axes, part: CycloidalStage) -> None:
    stage = part.stage
    if stage.kind == "ring pins":
        _line(
            on,
            _round(_around(stage.pins, stage.ring_radius), stage.pin_radius),
            "pins of the ring",
            LIGHT["ink"],
        )
        return
    fine = _FINE * stage.ring_radius
    outline = (
        wheel_outline(stage, part.drive.relief, fine)
        if stage.has_planet_pins
        else ring_outline(stage, fine)
    )
    _line(on, _closed(_complex(outline.points)), "ring", LIGHT["ink"])


def _planet(on: Axes, part: CycloidalStage, disc: int) -> None:
    stage = part.stage
    centre, turned = planet_pose(stage, np.array(2 * math.pi * disc / part.discs))
    middle, turn = complex(*centre), np.exp(1j * float(turned))
    name = "planet" if stage.has_planet_pins else "disc"
    name = f"{name} {disc + 1}" if part.discs > 1 else name
    if stage.has_planet_pins:
        pins = _round(middle + _around(stage.pins, stage.ring_radius) * turn, stage.pin_radius)
        _line(on, pins, f"pins of {name}", _LINES[disc])
        return
    outline = wheel_outline(stage, part.drive.relief, _FINE * stage.ring_radius)
    _line(on, _closed(middle + _complex(outline.points) * turn), name, _LINES[disc], fill=_FILL)


def _circles(on: Axes, part: CycloidalStage) -> None:
    """Draw the details of the first disc in thin lines: bore, output pins in their holes or
    crankshafts; and the outside of the ring.
    """
    stage = part.stage
    middle = np.array([complex(stage.eccentricity, 0.0)])
    if part.disc_bore_radius is not None:
        _line(on, _round(middle, part.disc_bore_radius), "", _LINES[0], _THIN)
    if part.ring_outer_radius is not None:
        _line(on, _round(np.zeros(1), part.ring_outer_radius), "", LIGHT["ink"], _THIN)
    pins = part.output_pins
    if pins is not None and pins.outer_diameter is not None:
        places = _around(pins.count, pins.circle_radius)
        holes = (pins.outer_diameter + pins.clearance.nominal) / 2 + stage.eccentricity
        _line(on, _round(places, pins.outer_diameter / 2), "output pins", LIGHT["visit"], _THIN)
        _line(on, _round(places + middle, holes), "", _LINES[0], _THIN)
    circle, stated = part.eccentric.circle_radius, part.disc.holes
    if circle is not None and stated is not None:
        _line(
            on,
            _round(_around(part.eccentric.cranks, circle) + middle, stated.diameter / 2),
            "",
            _LINES[0],
            _THIN,
        )


def _centres(on: Axes, stage: Stage) -> None:
    """Draw the line of centres and the pin circle."""
    pitch, reach = stage.ring_pitch_radius, 1.02 * stage.ring_radius
    gap = np.array([_GAP])
    middle = complex(stage.eccentricity, 0.0) if stage.has_planet_pins else 0j
    around = middle + stage.ring_radius * np.exp(2j * math.pi * np.arange(181) / 180)
    line = np.array([-reach, max(reach, pitch)], dtype=complex)
    cross = np.array([-0.06j, 0.06j]) * stage.ring_radius
    points = np.concatenate([line, gap, cross, gap, cross + stage.eccentricity, gap, around])
    _line(on, points, "centres, pin circle", LIGHT["quiet"], _THIN, "-.")


def _touching(stage: Stage, lobes: Lobes) -> tuple[np.ndarray, np.ndarray]:
    """Return the point of contact and the direction of the force of each lobe."""
    normal = _complex(normals(stage, lobes.theta))
    middle, out = (stage.eccentricity, 1) if stage.has_planet_pins else (0.0, -1)
    return middle + stage.ring_radius * np.exp(
        1j * lobes.theta
    ) + out * stage.pin_radius * normal, normal


def _contacts(on: Axes, stage: Stage) -> None:
    """Mark the contacts of both branches of an envelope ring."""
    if stage.kind != "lobe envelope":
        return
    theta = pin_angles(stage, np.zeros(1))[0]
    first = stage.ring_radius * np.exp(1j * theta) - stage.pin_radius * _complex(
        normals(stage, theta)
    )
    second = _complex(second_contact_places(stage, 0.0))
    colour = LIGHT["visit"]
    for places, name, inside in (
        (first, "contacts, first branch", colour),
        (second, "contacts, second branch", LIGHT["paper"]),
    ):
        how: dict[str, Any] = {
            "markerfacecolor": inside,
            "markeredgecolor": colour,
            "markeredgewidth": 1.0,
            "markersize": 3.5,
        }
        on.plot(
            places.real * _MM, places.imag * _MM, linestyle="none", marker="o", label=name, **how
        )


def _forces(on: Axes, stage: Stage, lobes: Lobes) -> None:
    """Draw the force on each loaded lobe as an arrow, and the contact normals, all through the
    pitch point.
    """
    loaded = np.flatnonzero(lobes.force > 0)
    if not len(loaded):
        return
    place, normal = (each[loaded] for each in _touching(stage, lobes))
    pitch = np.full(len(loaded), complex(stage.ring_pitch_radius, 0.0))
    _line(
        on,
        np.stack([place, pitch, np.full(len(loaded), _GAP)], axis=1).ravel(),
        "contact normals",
        LIGHT["warn"],
        0.5,
        ":",
    )
    force = _MM * _LONGEST * stage.ring_radius * lobes.force[loaded] / lobes.force.max() * normal
    ends = place * _MM + force
    _line(
        on,
        np.stack([place, ends / _MM, np.full(len(loaded), _GAP)], axis=1).ravel(),
        f"forces, largest {_newtons(lobes)}",
        LIGHT["warn"],
        1.3,
    )
    tip, across = (
        -_HEAD * np.minimum(np.abs(force), _MM * stage.ring_radius) * np.exp(1j * np.angle(force)),
        0.4j,
    )
    heads = np.stack([ends, ends + tip * (1 + across), ends + tip * (1 - across)], axis=1)
    for head in heads:
        on.fill(head.real, head.imag, color=LIGHT["warn"], linewidth=0)


def _newtons(lobes: Lobes) -> str:
    return str(Cell(float(lobes.force.max()), "N"))


def _places(on: Axes, stage: Stage) -> None:
    """Mark the centres and the pitch point."""
    pitch = stage.ring_pitch_radius * _MM
    on.plot(
        [0.0, stage.eccentricity * _MM],
        [0.0, 0.0],
        linestyle="none",
        marker="+",
        color=LIGHT["ink"],
        markersize=6,
    )
    on.plot([pitch], [0.0], linestyle="none", marker="o", color=LIGHT["ink"], markersize=4)
    text(on, pitch, 0.0, "pitch point", xytext=(0, -6), ha="center", va="top")
