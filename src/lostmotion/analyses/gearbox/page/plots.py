"""The plots of a gearbox of any kind: its hysteresis, and its stated harmonics; those of a drawing
are in `plots.cycloidal`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.gearbox.page.drawn import scatter
from lostmotion.analyses.gearbox.page.loop import Shown
from lostmotion.analyses.gearbox.page.profile import profile
from lostmotion.analyses.gearbox.page.stated import units_of
from lostmotion.parts.gearbox.cycloidal.examined import SHOWN
from lostmotion.parts.gearbox.kinds import is_drawn
from lostmotion.printed import ARCMIN, ARCSEC, factor_of
from lostmotion.propagation.montecarlo.histogram import binned
from lostmotion.reporting.chart import (
    axes,
    figure,
    grid,
    histogram,
    label,
    label_axes,
    legend,
    mark_at,
    named_rows,
    one,
    text,
)
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Cell

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.figure import Figure

    from lostmotion.analyses.gearbox.gear import Gear, Loop
    from lostmotion.analyses.gearbox.page.stated import Units
    from lostmotion.laws.torque_angle import CurveReadings
    from lostmotion.parts.gearbox.cycloidal.examined import Lobes, Transmission
    from lostmotion.spatial import Floats


def gearbox_plots(gear: Gear) -> list[Plot]:
    """Return the plots of a gearbox in reading order."""
    units, loop, read = units_of(gear.gearbox), gear.loop, gear.read
    plots = [*drawing_plots(gear)] if is_drawn(gear.gearbox) else []
    if loop is not None and read is not None:
        words = "Torque-angle hysteresis of the output, with the play and the lost motion marked."
        plots.append(Plot("hysteresis", "loop", hysteresis(gear, loop, read), words))
        near = max(4 * (loop.small or 0.0), 6 * loop.rest)
        if 0 < near < loop.torque[-1]:
            close = hysteresis(gear, loop, read, near)
            plots.append(Plot("hysteresis-near-zero", "loop", close, f"{words} Only near zero."))
    if not is_drawn(gear.gearbox) and gear.gearbox.harmonics:
        words = "Amplitude of each harmonic of the transmission error over its cycles."
        stated = stated_harmonics(gear.gearbox.harmonics, units)
        plots.append(Plot("harmonics", "transmission", stated, words))
    return plots


def hysteresis(gear: Gear, loop: Loop, read: CurveReadings, near: float = math.inf) -> Figure:
    """Return the plot of the output's angle under loading and unloading: the whole loop, the
    friction loop alone, and the points of the lost motion. Only torques up to `near` (N m) are
    shown.
    """
    units = units_of(gear.gearbox)
    show = Shown(gear, units)
    factor = factor_of(units.angle)
    zoomed = math.isfinite(near)
    figure, on = one("The same near zero" if zoomed else "Torque-angle hysteresis", 92)
    grid(on, "both")
    there_and_back = np.concatenate([loop.torque, loop.torque[::-1], loop.torque[:1]])
    for name, rising, falling, colour, line, width in (
        ("with play", loop.rising, loop.falling, LIGHT["robot"], "-", 1.6),
        (
            "friction's loop alone",
            loop.friction_rising,
            loop.friction_falling,
            LIGHT["design"],
            "--",
            1.2,
        ),
    ):
        angle = np.concatenate([rising, falling[::-1], rising[:1]])
        on.plot(
            there_and_back,
            angle * factor,
            color=colour,
            linestyle=line,
            linewidth=width,
            label=name,
        )
    if loop.play:
        half = loop.play / 2 * factor
        on.plot(
            [0, 0],
            [-half, half],
            color=LIGHT["visit"],
            linewidth=4,
            solid_capstyle="butt",
            label=f"play {show.play}",
        )
    if loop.small is not None and len(loop.ends):
        ends = loop.ends * factor
        name = f"lost motion {show.lost_motion(read)}"
        on.plot(
            [-loop.small, loop.small],
            ends,
            color=LIGHT["warn"],
            linestyle="none",
            marker="o",
            markersize=5,
            label=name,
        )
    if zoomed:
        highest = 1.08 * float(np.interp(near, loop.torque, loop.falling)) * factor
        on.set_xlim(-near, near)
        on.set_ylim(-highest, highest)
    label_axes(
        on,
        f"{units.what} on the output [{units.torque}]",
        f"{'shift' if units.angle == 'µm' else 'angle'} of the output [{units.angle}]",
    )
    legend(figure)
    return figure


def stated_harmonics(harmonics: list[tuple[str, float, float]], units: Units) -> Figure:
    """Draw the stated harmonics over their cycles."""
    figure, on = one("Transmission error by harmonic", 76)
    sizes = [size * factor_of(units.angle) for _, size, _ in harmonics]
    on.bar(range(len(sizes)), sizes, width=0.6, color=LIGHT["robot"], linewidth=0)
    for k, (name, _, _) in enumerate(harmonics):
        text(on, k, sizes[k], label(name), xytext=(0, 3), ha="center", va="bottom")
    on.set_xticks(range(len(sizes)), [f"{cycles:g}" for _, _, cycles in harmonics])
    on.tick_params(axis="x", length=0)
    on.set_xlim(-0.75, len(sizes) - 0.25)
    label_axes(on, f"cycles per {units.limit} [1]", f"amplitude [{units.angle}]")
    return figure


_COLOURS: Final = (LIGHT["robot"], LIGHT["design"], LIGHT["visit"], LIGHT["warn"])
_NAMES: Final = ("first", "second", "third", "fourth")
_MOST_HARMONICS: Final = 24


def drawing_plots(gear: Gear) -> Iterator[Plot]:
    """Yield the plots of the drawing. Raises ValueError for a gearbox without one."""
    drawn = gear.drawn
    if drawn is None:
        raise ValueError("a gearbox by stated figures has no drawing")
    counted = f"{gear.count} simulated gearboxes"
    yield Plot(
        "profile",
        "geometry",
        profile(gear),
        "Discs and ring at true scale, with the pitch point and the force on each lobe as an "
        "arrow.",
    )
    yield Plot(
        "lobe-loads",
        "lobes",
        lobe_loads(drawn.lobes),
        "Load and peak pressure of each lobe over its angle from the line of centres.",
    )
    for key, values, colour in (
        ("play", drawn.play, LIGHT["robot"]),
        ("lost-motion", drawn.lost_motion, LIGHT["visit"]),
    ):
        name = key.replace("-", " ")
        histogram_of = spread(values, name, counted, colour)
        yield Plot(key, "built", histogram_of, f"Histogram of the {name} of {counted}.")
    if drawn.members:
        words = "Bars of the wind-up through each member, the largest first."
        yield Plot("members", "members", members(drawn.members), words)
    if drawn.transmission.amplitude.any():
        yield Plot(
            "error",
            "transmission",
            error(drawn.transmission),
            "Transmission error of a few gearboxes over a turn of the crank.",
        )
        yield Plot(
            "spectrum",
            "transmission",
            spectrum(drawn.transmission),
            "Amplitude of each harmonic over its cycles per turn of the output.",
        )


def lobe_loads(cases: tuple[Lobes, ...]) -> Figure:
    """Draw force and pressure of each lobe over its angle from the line of centres, at crank angle
    zero.
    """
    made = figure(100)
    panels = axes(made, "Load of the lobes of one disc", rows=2, sharex=True)[:, 0]
    step = 360 / len(cases[0].theta)
    thick = 0.8 * step / len(cases)
    for k, (case, colour) in enumerate(zip(cases, _COLOURS, strict=False)):
        order = np.argsort(case.theta)
        at = np.degrees(case.theta[order]) + (k - (len(cases) - 1) / 2) * thick
        name = f"share {case.share:.3g} of the torque" if len(cases) > 1 else None
        for on, values in zip(panels, (case.force, case.peak / 1e9), strict=True):
            seen = np.flatnonzero(values[order] > 0)
            if len(seen):
                on.bar(
                    at[seen],
                    values[order][seen],
                    width=0.94 * thick,
                    color=colour,
                    linewidth=0,
                    label=name,
                )
    loaded = np.abs(np.degrees(cases[0].theta[np.max([case.force for case in cases], axis=0) > 0]))
    middle = 1.0 if cases[0].theta[cases[0].force.argmax()] > 0 else -1.0
    ends = sorted(
        (
            middle * max(float(loaded.min()) - 1.5 * step, -step),
            middle * (float(loaded.max()) + 1.5 * step),
        )
    )
    panels[1].set_xlim(*ends)
    label_axes(panels[0], y="load [N]")
    label_axes(panels[1], "θ, angle from the line of centres [°]", "peak pressure [GPa]")
    legend(made)
    return made


def spread(values: Floats, name: str, counted: str, colour: str) -> Figure:
    """Draw the scatter of manufactured samples (rad): a histogram with the mean and the quantiles
    that the table of samples prints.
    """
    shown = values / ARCMIN
    even = float(np.ptp(shown)) <= 1e-9 * max(float(np.abs(shown).max()), 1.0)
    wide = max(0.01 * abs(float(shown[0])), 1e-3)
    edges, counts = (
        (shown[0] + wide * np.array([-0.5, 0.5]), np.array([len(shown)]))
        if even
        else binned(shown, about=40)
    )
    made, on = one(f"{name[:1].upper()}{name[1:]} of {counted}", 84)
    histogram(on, edges, counts, colour)
    marks = sorted(scatter(values, "arcmin").items(), key=lambda mark: mark[1].value)
    for row, (word, number) in enumerate(marks):
        mark_at(on, number.value, f"{word}  {number}", row=row)
    label_axes(on, f"{name} [arcmin]", f"gearboxes per {float(edges[1] - edges[0]):.3g} arcmin [1]")
    return made


def members(angles: dict[str, float]) -> Figure:
    """Draw the compliance by member."""
    values = np.array([angle / ARCMIN for angle in angles.values()])
    made, on = one("Wind-up by member", 24 + 7 * len(values))
    on.barh(range(len(values)), values, height=0.62, color=LIGHT["robot"], linewidth=0)
    for row, value in enumerate(values):
        text(
            on,
            value,
            row,
            f"{Cell(float(value) * ARCMIN, 'arcmin')}, {Cell(float(value / values.sum()), '%')}",
            xytext=(4, 0),
            va="center",
        )
    named_rows(on, list(angles))
    on.set_xlim(0, 1.6 * max(float(values.max()), 1e-12))
    label_axes(on, "wind-up [arcmin]")
    return made


def error(transmission: Transmission) -> Figure:
    """Draw the transmission error of a few gearboxes over a turn of the crank, under the torque."""
    made, on = one(f"Transmission error, {transmission.loads[-1]:.4g} N m", 80)
    grid(on)
    for k in range(min(SHOWN, transmission.errors.shape[-1])):
        on.plot(
            np.degrees(transmission.crank),
            transmission.errors[-1, :, k] / ARCSEC,
            color=_COLOURS[k],
            linewidth=1.2,
            label=f"{_NAMES[k]} gearbox",
        )
    on.set_xlim(0, 360)
    on.set_xticks(range(0, 361, 60))
    label_axes(on, "crank angle [°]", "error of the output [arcsec]")
    legend(made)
    return made


def spectrum(transmission: Transmission) -> Figure:
    """Draw the lowest harmonics of the transmission error, under a light load and under the
    torque.
    """
    largest = transmission.amplitude.max(axis=0)
    last = int(np.flatnonzero(largest > 0.2 * largest.max())[-1]) + 1
    seen = transmission.cycles[: max(_MOST_HARMONICS, last)]
    made, on = one("Spectrum of the transmission error", 76)
    first = float(transmission.cycles[0])
    for k, load in enumerate(transmission.loads):
        heights = transmission.amplitude[k, : len(seen)] / ARCSEC
        on.bar(
            seen + (k - 0.5) * 0.4 * first,
            heights,
            width=0.4 * first,
            color=_COLOURS[1 - k],
            linewidth=0,
            label=f"{load:.4g} N m",
        )
    step = first * max(1, math.ceil(len(seen) / 10))
    on.set_xticks(np.arange(0, float(seen[-1]) + step, step))
    on.set_xlim(0, float(seen[-1] + first))
    label_axes(on, "cycles per turn of the output [1]", "r.m.s. amplitude [arcsec]")
    legend(made)
    return made
