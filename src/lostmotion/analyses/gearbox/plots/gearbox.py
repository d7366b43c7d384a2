"""The plots of a gearbox of any kind: its hysteresis, and its stated harmonics; those of a drawing are in `plots.cycloidal`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.analyses.gearbox.plots.cycloidal import drawing_plots
from lostmotion.analyses.gearbox.tables.units import units_of
from lostmotion.parts.gearbox.kinds import is_drawn
from lostmotion.reporting.plot import BLUE, GREEN, LEGEND, ORANGE, RED, Plot, framed, label

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.gearbox.gear import GearStudy, Loop
    from lostmotion.analyses.gearbox.tables.units import Units


def gearbox_plots(study: GearStudy) -> list[Plot]:
    """Return the plots of a gearbox in reading order."""
    units = units_of(study.gearbox)
    drawn = []
    if study.loop is not None:
        words = "Torque-angle hysteresis of the output, with the play and the lost motion marked."
        drawn.append(Plot("hysteresis", "loop", hysteresis(study.loop, units), words))
        near = max(4 * (study.loop.small or 0.0), 6 * study.loop.rest)
        if 0 < near < study.loop.torque[-1]:
            drawn.append(Plot("hysteresis-near-zero", "loop", hysteresis(study.loop, units, near), f"{words} Only near zero."))
    if is_drawn(study.gearbox):
        return [*drawing_plots(study), *drawn]
    if study.gearbox.harmonics:
        words = "Amplitude of each harmonic of the transmission error over its cycles."
        drawn.append(Plot("harmonics", "transmission", stated_harmonics(study.gearbox.harmonics, units), words))
    return drawn


def hysteresis(loop: Loop, units: Units, near: float = math.inf) -> go.Figure:
    """Return the plot of the output's angle under loading and unloading: the whole loop, the friction loop alone, and the points of the lost motion.

    Only torques up to `near` (N m) are shown.
    """
    import plotly.graph_objects as go

    factor = units.angle_factor
    there_and_back = np.concatenate([loop.torque, loop.torque[::-1], loop.torque[:1]])
    traces = []
    for name, rising, falling, line in (
        ("with play", loop.rising, loop.falling, {"color": BLUE, "width": 2}),
        ("friction's loop alone", loop.friction_rising, loop.friction_falling, {"color": ORANGE, "width": 1.5, "dash": "dash"}),
    ):
        angle = np.concatenate([rising, falling[::-1], rising[:1]])
        hover = f"{name}<br>%{{x:.4~g}} {units.torque}: %{{y:.4~g}} {units.angle}<extra></extra>"
        traces.append(go.Scatter(x=_short(there_and_back), y=_short(angle * factor), mode="lines", name=name, line=line, hovertemplate=hover))
    if loop.small is not None and len(loop.ends):
        ends = loop.ends * factor
        hover = f"lost motion, read at %{{x:.4~g}} {units.torque}: %{{y:.4~g}} {units.angle}<extra></extra>"
        name = f"lost motion {ends[1] - ends[0]:.3g} {units.angle}"
        marker = {"color": RED, "size": 8}
        traces.append(go.Scatter(x=[-loop.small, loop.small], y=ends, mode="markers", name=name, marker=marker, hovertemplate=hover))
    if loop.play:
        half = loop.play / 2 * factor
        name, hover = f"play {2 * half:.3g} {units.angle}", f"play at zero {units.what}<extra></extra>"
        traces.append(go.Scatter(x=[0, 0], y=[-half, half], mode="lines", name=name, line={"color": GREEN, "width": 5}, hovertemplate=hover))
    zoomed = math.isfinite(near)
    figure = framed("The same near zero" if zoomed else "Torque-angle hysteresis", *traces, height=460)
    figure.update_xaxes(title_text=f"{units.what} on the output [{units.torque}]")
    if zoomed:
        highest = 1.08 * float(np.interp(near, loop.torque, loop.falling)) * factor
        figure.update_xaxes(range=[-near, near])
        figure.update_yaxes(range=[-highest, highest])
    figure.update_yaxes(title_text=f"{'shift' if units.angle == 'µm' else 'angle'} of the output [{units.angle}]")
    figure.update_layout(legend=LEGEND, margin_t=96)
    return figure


def stated_harmonics(harmonics: list[tuple[str, float, float]], units: Units) -> go.Figure:
    """Draw the stated harmonics over their cycles."""
    import plotly.graph_objects as go

    bars = go.Bar(
        x=[f"{cycles:g}" for _, _, cycles in harmonics],
        y=[size * units.angle_factor for _, size, _ in harmonics],
        text=[label(name) for name, _, _ in harmonics],
        textposition="outside",
        marker={"color": BLUE},
        hovertemplate=f"%{{text}}<br>%{{x}} cycles: %{{y:.3~g}} {units.angle}<extra></extra>",
    )
    figure = framed("Transmission error by harmonic", bars, height=340)
    figure.update_xaxes(title_text=f"cycles per {units.limit} [1]", type="category", showgrid=False)
    figure.update_yaxes(title_text=f"amplitude [{units.angle}]", rangemode="tozero")
    return figure


def _short(values: np.ndarray) -> np.ndarray:
    """Return values rounded for the plot, to keep the page small."""
    return np.asarray(np.round(values, 6))
