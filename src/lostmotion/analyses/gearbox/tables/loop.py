"""Stiffness and hysteresis of a gearbox under its torque: of stated figures with their limits, of
simulated samples with their interval.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.analyses.gearbox.tables.cycloidal import over_samples
from lostmotion.analyses.gearbox.tables.definition import definition_text
from lostmotion.analyses.gearbox.tables.stated import (
    OF_LOOP,
    OF_PLAY,
    at_most,
    displacement_figure,
    friction_note,
    lost_motion_figure,
    play_figure,
    wind_up_figure,
)
from lostmotion.analyses.gearbox.tables.units import STATED
from lostmotion.parts.gearbox.kinds import is_drawn
from lostmotion.printed import stated_text
from lostmotion.reporting.sheet import Cell, Row, Section

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.analyses.gearbox.gear import GearStudy, Loop
    from lostmotion.analyses.gearbox.tables.cycloidal import Bound
    from lostmotion.analyses.gearbox.tables.units import Units
    from lostmotion.laws.torque_angle import Readings
    from lostmotion.spatial import Floats


def loop_section(loop: Loop, read: Readings, study: GearStudy, units: Units) -> Section:
    """Return the table of stiffness, play, friction loop and lost motion."""
    gearbox, torque = study.gearbox, study.gearbox.rated_torque
    show = _Shown(study, units)
    rows = [*_stiffnesses(read, study, show)]
    note = friction_note(gearbox.friction_at_rest if is_drawn(gearbox) else gearbox.friction, units)
    crossed = (
        f"traversed once {loop.rest:.3g} {units.torque} overcome friction{note and f' ({note})'}"
        if loop.rest
        else "traversed by any load"
    )
    rows.append(Row("play", (show.play,), crossed))
    kept = (
        ""
        if study.drawn is None or study.drawn.friction.drives
        else ": the drive does not unload, so that friction keeps the whole wind-up"
    )
    rows.append(
        Row(
            "friction's loop alone",
            (show.angle(read.friction_width, rests_on=OF_LOOP),),
            f"width at zero {units.what}{kept}",
        )
    )
    if study.drawn is not None and study.drawn.friction.any:
        half = f"width at {stated_text(read.asked.torque / 2)} {units.torque}"
        rows.append(
            Row("friction's loop under load", (show.angle(read.friction_under_load),), half)
        )
    rows.append(
        Row(
            f"whole loop at zero {units.what}",
            (show.angle(read.width, rests_on=OF_PLAY + OF_LOOP),),
            "play and friction",
        )
    )
    if read.lost_motion is not None and read.asked.small is not None:
        share = (
            ""
            if torque is None
            else f", {100 * read.asked.small / torque:.3g} % of the rated {units.what}"
        )
        note = (
            f"play and wind-up between ± {stated_text(read.asked.small)} {units.torque}{share}, "
            "without friction"
        )
        rows.append(Row("lost motion", (show.lost_motion(read),), note))
    return Section(
        "loop",
        "Stiffness and hysteresis",
        ("value",),
        tuple(rows),
        "loading and unloading in both directions, input held",
    )


def _stiffnesses(read: Readings, study: GearStudy, show: _Shown) -> Iterator[Row]:
    """Yield the rows of displacement, wind-up and stiffness, each with its definition."""
    units, torque = show.units, f"{stated_text(read.asked.torque)} {show.units.torque}"
    if study.wind_up:
        yield Row(
            f"displacement at {torque}",
            (show.displacement(read),),
            "from the middle of the play: half the play and the wind-up",
        )
        yield Row(
            f"wind-up at {torque}", (show.wind_up(read),), "in both directions, beyond the play"
        )
        yield Row(
            "stiffness, secant",
            (show.stiffness(read.secant),),
            f"from the middle of the play to {torque}, without friction",
        )
    if read.slope is not None and read.asked.slope is not None and np.isfinite(read.slope).all():
        low, high = read.asked.slope
        rated = study.gearbox.rated_torque
        share = (
            ""
            if rated is None
            else (
                f", {100 * low / rated:.3g} to {100 * high / rated:.3g} % of the rated {units.what}"
            )
        )
        between = f"{stated_text(low)} to {stated_text(high)}"
        yield Row(
            "stiffness, slope",
            (show.stiffness(read.slope),),
            f"from {between} {units.torque}{share}, without friction",
        )
    if (
        read.asked.stiffness in {"b/a", "tangent"}
        and read.stiffness is not None
        and np.isfinite(read.stiffness).all()
    ):
        note = f"{definition_text(read.asked, units)}, without friction"
        yield Row(f"stiffness, {read.asked.stiffness}", (show.stiffness(read.stiffness),), note)
    if (
        study.drawn is not None
        and study.drawn.friction.any
        and read.loading is not None
        and np.isfinite(read.loading).all()
    ):
        note = (
            "what a bench test reads as the torque rises, with the input held: "
            f"{definition_text(read.asked, units)}, with friction"
        )
        yield Row("stiffness of the loading branch", (show.stiffness(read.loading),), note)


class _Shown:
    """Conversion of readings to figures: the mean of manufactured samples with its interval, or a
    stated value with its limits.

    Where members are declared rigid, wind-up is a lower and stiffness an upper limit.
    """

    def __init__(self, study: GearStudy, units: Units) -> None:
        self.units = units
        self._drawn = study.drawn
        self._stated = None if is_drawn(study.gearbox) else study.gearbox
        self._at_most_as_stiff = is_drawn(study.gearbox) and bool(study.gearbox.rigid)
        self.samples = STATED if self._stated is not None else f"{study.count} simulated gearboxes"

    @property
    def play(self) -> Cell:
        if self._stated is not None:
            return play_figure(self._stated, self.units)
        return self.angle(self._drawn.play if self._drawn is not None else np.zeros(2))

    def angle(self, values: Floats, bound: Bound = "", rests_on: tuple[str, ...] = ()) -> Cell:
        if self._stated is not None:
            return at_most(self.units.of_angle(float(values[0]), STATED), self._stated, rests_on)
        return over_samples(values, self.units.angle, self.samples, bound)

    def stiffness(self, values: Floats) -> Cell:
        unit = self.units.stiffness
        if self._stated is None:
            return over_samples(
                values, unit, self.samples, "upper" if self._at_most_as_stiff else ""
            )
        value, share = float(values[0]), self._stated.stiffness_scatter
        ends = (value / (1 + share), value / (1 - share)) if 0 < share < 1 else (math.nan, math.nan)
        return Cell(value, unit, *ends, STATED, "stated limits")

    def wind_up(self, read: Readings) -> Cell:
        if self._stated is not None:
            return wind_up_figure(self._stated, float(read.wind_up[0]), self.units)
        return self.angle(read.wind_up, "lower" if self._at_most_as_stiff else "")

    def displacement(self, read: Readings) -> Cell:
        if self._stated is not None:
            return displacement_figure(self._stated, read, self.units)
        return self.angle(read.displacement, "lower" if self._at_most_as_stiff else "")

    def lost_motion(self, read: Readings) -> Cell:
        if self._stated is not None:
            return lost_motion_figure(self._stated, read, self.units)
        return self.angle(np.zeros(2) if read.lost_motion is None else read.lost_motion)
