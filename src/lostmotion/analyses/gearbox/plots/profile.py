"""Plot of a cycloidal gearbox at true scale: discs, ring, pitch point, and the force on each lobe."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.laws.cycloid.envelope import second_contact_places
from lostmotion.laws.cycloid.geometry import normals, pin_angles, planet_pose
from lostmotion.laws.cycloid.outline import ring_outline, wheel_outline
from lostmotion.parts.gearbox.kinds import is_drawn
from lostmotion.reporting.plot import BLUE, GREEN, INK, LEGEND, ORANGE, RED, framed

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.gearbox.cycloidal import Lobes
    from lostmotion.analyses.gearbox.gear import GearStudy
    from lostmotion.laws.cycloid.geometry import Stage
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.spatial import Floats

_MM: Final = 1e3
# Largest chord error of the plot, and the length of the largest force, as shares of the ring's radius.
_FINE: Final = 2e-4
_LONGEST: Final = 0.3
# Points of a small circle, and of one as large as a wheel.
_SMALL: Final = 36
_LARGE: Final = 180
_FILLS: Final = ("rgba(0,114,178,0.12)", "rgba(230,159,0,0.10)", "rgba(0,158,115,0.08)", "rgba(178,58,0,0.08)")
_LINES: Final = (BLUE, ORANGE, GREEN, RED)


def profile(study: GearStudy) -> go.Figure:
    """Draw discs, ring and pins of the output stage at crank angle zero, and the forces on the lobes of the first disc."""
    part, drawn = study.gearbox, study.drawn
    if not is_drawn(part) or drawn is None:
        raise ValueError("a gearbox by stated figures has no profile")
    stage, lobes = part.stage, drawn.lobes[0]
    loaded = np.flatnonzero(lobes.force > 0)
    traces = [_ring(part), *(_planet(part, disc) for disc in range(part.discs)), *_circles(part)]
    traces += [*_contacts(stage), _centres(stage), _normals(stage, lobes, loaded), _arrows(stage, lobes, loaded), _places(stage)]
    figure = framed("Profile and forces on the ring", *[each for each in traces if each], height=700)
    figure.update_xaxes(title_text="x, along the line of centres [mm]", showgrid=False, constrain="domain")
    figure.update_yaxes(title_text="y [mm]", showgrid=False, scaleanchor="x", scaleratio=1)
    note = {"text": "pitch point", "showarrow": False, "yanchor": "top", "yshift": -6, "font": {"size": 12}}
    figure.add_annotation(x=stage.ring_pitch_radius * _MM, y=0, **note)
    figure.update_layout(legend={**LEGEND, "font": {"size": 12}}, margin_t=112)
    return figure


def _plane(points: np.ndarray) -> dict[str, list[float | None]]:
    """Return complex points as x and y in mm, to the micrometre; gaps where they are not numbers."""
    shown = np.round(points * _MM, 3)
    return {name: [None if math.isnan(value) else float(value) for value in part] for name, part in (("x", shown.real), ("y", shown.imag))}


def _complex(points: Floats) -> np.ndarray:
    return np.asarray(points[:, 0] + 1j * points[:, 1])


def _closed(points: np.ndarray) -> np.ndarray:
    return np.concatenate([points, points[:1]])


def _round(places: np.ndarray, radius: float) -> np.ndarray:
    """Draw circles around centres, separated by gaps in the line."""
    corners = _SMALL if len(places) > 1 else _LARGE
    ring = radius * np.exp(2j * math.pi * np.arange(corners + 1) / corners)
    gap = np.full((len(places), 1), complex(math.nan, math.nan))
    return np.concatenate([places[:, None] + ring, gap], axis=1).ravel()


def _around(count: int, radius: float) -> np.ndarray:
    return np.asarray(radius * np.exp(2j * math.pi * np.arange(count) / count))


def _scatter(points: np.ndarray, name: str, colour: str, **more: Any) -> go.Scatter:  # noqa: ANN401 - plotly publishes no types
    import plotly.graph_objects as go

    line = {"color": colour, "width": 1.2, **more.pop("line", {})}
    return go.Scatter(**_plane(points), mode="lines", name=name, line=line, **{"hoverinfo": "skip", **more})


def _ring(part: CycloidalStage) -> go.Scatter:
    stage = part.stage
    if stage.kind == "ring pins":
        return _scatter(_round(_around(stage.pins, stage.ring_radius), stage.pin_radius), "pins of the ring", INK)
    fine = _FINE * stage.ring_radius
    outline = wheel_outline(stage, part.drive.relief, fine) if stage.has_planet_pins else ring_outline(stage, fine)
    return _scatter(_closed(_complex(outline.points)), "ring", INK)


def _planet(part: CycloidalStage, disc: int) -> go.Scatter:
    stage = part.stage
    centre, turned = planet_pose(stage, np.array(2 * math.pi * disc / part.discs))
    middle, turn = complex(*centre), np.exp(1j * float(turned))
    name = "planet" if stage.has_planet_pins else "disc"
    name = f"{name} {disc + 1}" if part.discs > 1 else name
    if stage.has_planet_pins:
        return _scatter(_round(middle + _around(stage.pins, stage.ring_radius) * turn, stage.pin_radius), f"pins of {name}", _LINES[disc])
    outline = wheel_outline(stage, part.drive.relief, _FINE * stage.ring_radius)
    return _scatter(_closed(middle + _complex(outline.points) * turn), name, _LINES[disc], fill="toself", fillcolor=_FILLS[disc])


def _circles(part: CycloidalStage) -> list[go.Scatter]:
    """Draw the details of the first disc in thin lines: bore, output pins in their holes or crankshafts; and the outside of the ring."""
    stage, thin = part.stage, {"line": {"width": 0.8}, "showlegend": False, "hoverinfo": "name"}
    middle = np.array([complex(stage.eccentricity, 0.0)])
    out = []
    if part.disc_bore_radius is not None:
        out.append(_scatter(_round(middle, part.disc_bore_radius), "disc bore", BLUE, **thin))
    if part.ring_outer_radius is not None:
        out.append(_scatter(_round(np.zeros(1), part.ring_outer_radius), "ring outside", INK, **thin))
    pins = part.output_pins
    if pins is not None and pins.outer_diameter is not None:
        places = _around(pins.count, pins.circle_radius)
        holes = (pins.outer_diameter + pins.clearance.nominal) / 2 + stage.eccentricity
        out.append(_scatter(_round(places, pins.outer_diameter / 2), "output pins", GREEN, **thin))
        out.append(_scatter(_round(places + middle, holes), "their holes", BLUE, **thin))
    circle, stated = part.eccentric.circle_radius, part.disc.holes
    if circle is not None and stated is not None:
        out.append(_scatter(_round(_around(part.eccentric.cranks, circle) + middle, stated.diameter / 2), "holes for the cranks", BLUE, **thin))
    return out


def _centres(stage: Stage) -> go.Scatter:
    """Draw the line of centres and the pin circle."""
    pitch, reach = stage.ring_pitch_radius, 1.02 * stage.ring_radius
    gap = np.array([complex(math.nan, math.nan)])
    middle = complex(stage.eccentricity, 0.0) if stage.has_planet_pins else 0j
    around = middle + stage.ring_radius * np.exp(2j * math.pi * np.arange(181) / 180)
    line = np.array([-reach, max(reach, pitch)], dtype=complex)
    cross = np.array([-0.06j, 0.06j]) * stage.ring_radius
    points = np.concatenate([line, gap, cross, gap, cross + stage.eccentricity, gap, around])
    return _scatter(points, "centres, pin circle", "#888888", line={"width": 0.8, "dash": "dashdot"})


def _touching(stage: Stage, lobes: Lobes) -> tuple[np.ndarray, np.ndarray]:
    """Return the point of contact and the direction of the force of each lobe."""
    normal = _complex(normals(stage, lobes.theta))
    middle, out = (stage.eccentricity, 1) if stage.has_planet_pins else (0.0, -1)
    return middle + stage.ring_radius * np.exp(1j * lobes.theta) + out * stage.pin_radius * normal, normal


def _contacts(stage: Stage) -> list[go.Scatter]:
    """Mark the contacts of both branches of an envelope ring."""
    import plotly.graph_objects as go

    if stage.kind != "lobe envelope":
        return []
    theta = pin_angles(stage, np.zeros(1))[0]
    first = stage.ring_radius * np.exp(1j * theta) - stage.pin_radius * _complex(normals(stage, theta))
    second = _complex(second_contact_places(stage, 0.0))
    return [
        go.Scatter(**_plane(places), mode="markers", name=name, marker={"color": GREEN, "size": 6, "symbol": symbol}, hoverinfo="name")
        for places, name, symbol in ((first, "contacts, first branch", "circle"), (second, "contacts, second branch", "circle-open"))
    ]


def _normals(stage: Stage, lobes: Lobes, loaded: np.ndarray) -> go.Scatter | None:
    """Draw the contact normals of the loaded lobes, all through the pitch point."""
    if not len(loaded):
        return None
    place, _ = _touching(stage, lobes)
    pitch = complex(stage.ring_pitch_radius, 0.0)
    lines = np.stack([place[loaded], np.full(len(loaded), pitch), np.full(len(loaded), complex(math.nan, math.nan))], axis=1)
    return _scatter(lines.ravel(), "contact normals", RED, line={"width": 0.5, "dash": "dot"})


def _arrows(stage: Stage, lobes: Lobes, loaded: np.ndarray) -> go.Scatter | None:
    import plotly.graph_objects as go

    if not len(loaded):
        return None
    place, normal = _touching(stage, lobes)
    size = _LONGEST * stage.ring_radius * lobes.force / lobes.force.max()
    ends = np.stack([place, place + size * normal, np.full(len(place), complex(math.nan, math.nan))], axis=1)[loaded]
    labels = [text for k in loaded for text in (None, f"θ = {math.degrees(lobes.theta[k]):.1f}°: {lobes.force[k]:.4g} N", None)]
    return go.Scatter(
        **_plane(ends.ravel()),
        mode="lines+markers",
        name=f"forces, largest {lobes.force.max():.4g} N",
        line={"color": RED, "width": 1.6},
        marker={"symbol": "arrow", "angleref": "previous", "size": [0, 9, 0] * len(loaded), "color": RED, "opacity": 1},
        text=labels,
        hovertemplate="%{text}<extra></extra>",
    )


def _places(stage: Stage) -> go.Scatter:
    """Mark the centres and the pitch point."""
    import plotly.graph_objects as go

    points = np.array([0.0, stage.eccentricity, stage.ring_pitch_radius], dtype=complex)
    return go.Scatter(
        **_plane(points),
        mode="markers",
        showlegend=False,
        text=["centre of the ring", "centre of disc 1", "pitch point"],
        marker={"color": INK, "size": 7, "symbol": ["cross-thin", "cross-thin", "circle"], "line": {"color": INK, "width": 1.2}},
        hovertemplate="%{text}<br>x = %{x:.4~g} mm<extra></extra>",
    )
