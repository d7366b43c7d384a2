"""The plots of a gearbox of any kind: its hysteresis, and its stated harmonics; those of a drawing
are in `plots.cycloidal`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.analyses.gearbox.plots.cycloidal import drawing_plots
from lostmotion.analyses.gearbox.tables.loop import loop_section
from lostmotion.analyses.gearbox.tables.units import units_of
from lostmotion.parts.gearbox.kinds import is_drawn
from lostmotion.printed import factor_of
from lostmotion.reporting.chart import grid, label, label_axes, legend, one, text
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.analyses.gearbox.gear import GearStudy, Loop
    from lostmotion.analyses.gearbox.tables.units import Units
    from lostmotion.reporting.sheet import Section


def gearbox_plots(study: GearStudy) -> list[Plot]:
    """Return the plots of a gearbox in reading order."""
    units = units_of(study.gearbox)
    drawn = []
    if study.loop is not None and study.read is not None:
        words = "Torque-angle hysteresis of the output, with the play and the lost motion marked."
        found = loop_section(study.loop, study.read, study, units)
        drawn.append(Plot("hysteresis", "loop", hysteresis(study.loop, found, units), words))
        near = max(4 * (study.loop.small or 0.0), 6 * study.loop.rest)
        if 0 < near < study.loop.torque[-1]:
            drawn.append(
                Plot(
                    "hysteresis-near-zero",
                    "loop",
                    hysteresis(study.loop, found, units, near),
                    f"{words} Only near zero.",
                )
            )
    if is_drawn(study.gearbox):
        return [*drawing_plots(study), *drawn]
    if study.gearbox.harmonics:
        words = "Amplitude of each harmonic of the transmission error over its cycles."
        drawn.append(
            Plot(
                "harmonics", "transmission", stated_harmonics(study.gearbox.harmonics, units), words
            )
        )
    return drawn


def hysteresis(loop: Loop, found: Section, units: Units, near: float = math.inf) -> Figure:
    """Return the plot of the output's angle under loading and unloading: the whole loop, the
    friction loop alone, and the points of the lost motion.

    Only torques up to `near` (N m) are shown. `found` is the table whose play and lost motion are
    written beside.
    """
    printed = {row.label: str(row.cells[0]) for row in found.rows}
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
            label=f"play {printed['play']}",
        )
    if loop.small is not None and len(loop.ends):
        ends = loop.ends * factor
        name = f"lost motion {printed['lost motion']}"
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
