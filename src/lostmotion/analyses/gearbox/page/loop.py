"""Stiffness and hysteresis of a gearbox under its torque, and how far its figures depend on the
values that are only known to lie in a range.

Stated figures have their limits, simulated samples their interval.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias, TypeGuard

import numpy as np

from lostmotion.analyses.gearbox.page.stated import (
    OF_LOOP,
    OF_PLAY,
    OF_STIFFNESS,
    STATED,
    bounded,
    displacement_figure,
    friction_note,
    lost_motion_figure,
    play_figure,
    wind_up_figure,
)
from lostmotion.error_model.intervals import student
from lostmotion.error_model.provenance import part_states
from lostmotion.parts.bands import band, influence
from lostmotion.parts.gearbox.bands import LARGE
from lostmotion.parts.gearbox.kinds import is_drawn
from lostmotion.printed import stated_text
from lostmotion.reporting.layout import key_of
from lostmotion.reporting.sheet import Card, Cell, Row, several, table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.analyses.gearbox.gear import Gear, Loop
    from lostmotion.analyses.gearbox.page.stated import Units
    from lostmotion.laws.torque_angle import CurveReadings
    from lostmotion.parts.gearbox.bands import GearBands
    from lostmotion.reporting.sheet import Section
    from lostmotion.spatial import Floats

Bound: TypeAlias = Literal["", "upper", "lower"]
OPEN: Final = "5-95 % of what the drawing leaves open"
# Smallest share of a member that has a row of its own, in some draw.
_SMALLEST: Final = 0.01


def over_samples(values: Floats, unit: str, samples: str = "", bound: Bound = "") -> Cell:
    """Return the mean over independent samples (sample,) of a size, none below zero, with Student's
    interval, shown in `unit`.
    """
    mean, half = (
        float(values.mean()),
        student(len(values) - 1) * float(values.std(ddof=1)) / math.sqrt(len(values)),
    )
    return Cell(mean, unit, max(mean - half, 0.0), mean + half, samples, bound=bound)


def is_known(values: Floats | None) -> TypeGuard[Floats]:
    """Return whether there are values, all of them finite."""
    return values is not None and bool(np.isfinite(values).all())


def loop_section(loop: Loop, read: CurveReadings, gear: Gear, units: Units) -> Section:
    """Return the table of stiffness, play, friction loop and lost motion."""
    rows = [*_stiffnesses(read, gear, units), *_loop_rows(loop, read, gear, units)]
    return table(
        "loop",
        "Stiffness and hysteresis",
        ["value"],
        rows,
        "loading and unloading in both directions, input held",
        samples=Shown(gear, units).samples,
    )


def _loop_rows(
    loop: Loop, read: CurveReadings, gear: Gear, units: Units
) -> Iterator[tuple[str, Cell, str]]:
    gearbox, drawn, show = gear.gearbox, gear.drawn, Shown(gear, units)
    note = friction_note(gearbox.friction_at_rest if is_drawn(gearbox) else gearbox.friction, units)
    crossed = (
        f"traversed once {loop.rest:.3g} {units.torque} overcome friction{note and f' ({note})'}"
        if loop.rest
        else "traversed by any load"
    )
    yield "play", show.play, crossed
    kept = (
        ""
        if drawn is None or drawn.friction.drives
        else ": the drive does not unload, so that friction keeps the whole wind-up"
    )
    yield (
        "friction's loop alone",
        show.angle(read.friction_width, OF_LOOP),
        f"width at zero {units.what}{kept}",
    )
    if drawn is not None and drawn.friction.any:
        half = f"width at {stated_text(read.asked.torque / 2)} {units.torque}"
        yield "friction's loop under load", show.angle(read.friction_under_load, OF_LOOP), half
    whole = show.angle(read.width, OF_PLAY + OF_LOOP)
    yield f"whole loop at zero {units.what}", whole, "play and friction"
    small, rated = read.asked.small, gearbox.rated_torque
    if read.lost_motion is not None and small is not None:
        share = "" if rated is None else f", {100 * small / rated:.3g} % of the rated {units.what}"
        yield (
            "lost motion",
            show.lost_motion(read),
            (
                f"play and wind-up between ± {stated_text(small)} {units.torque}{share}, "
                "without friction"
            ),
        )


def _stiffnesses(read: CurveReadings, gear: Gear, units: Units) -> Iterator[tuple[str, Cell, str]]:
    """Yield the rows of displacement, wind-up and stiffness, each with its definition."""
    asked, show, torque = (
        read.asked,
        Shown(gear, units),
        f"{stated_text(read.asked.torque)} {units.torque}",
    )
    if gear.wind_up:
        yield (
            f"displacement at {torque}",
            show.displacement(read),
            "from the middle of the play: half the play and the wind-up",
        )
        yield f"wind-up at {torque}", show.wind_up(read), "in both directions, beyond the play"
        yield (
            "stiffness, secant",
            show.stiffness(read.secant),
            f"from the middle of the play to {torque}, without friction",
        )
    if asked.slope is not None and is_known(read.slope):
        (low, high), rated = asked.slope, gear.gearbox.rated_torque
        share = ""
        if rated is not None:
            ends = f"{100 * low / rated:.3g} to {100 * high / rated:.3g}"
            share = f", {ends} % of the rated {units.what}"
        yield (
            "stiffness, slope",
            show.stiffness(read.slope),
            (
                f"from {stated_text(low)} to {stated_text(high)} {units.torque}{share}, "
                "without friction"
            ),
        )
    if asked.stiffness in {"b/a", "tangent"} and is_known(read.stiffness):
        note = f"{units.definition(asked)}, without friction"
        yield f"stiffness, {asked.stiffness}", show.stiffness(read.stiffness), note
    if gear.drawn is not None and gear.drawn.friction.any and is_known(read.loading):
        yield (
            "stiffness of the loading branch",
            show.stiffness(read.loading),
            (
                "what a bench test reads as the torque rises, with the input held: "
                f"{units.definition(asked)}, with friction"
            ),
        )


@dataclass(frozen=True)
class Shown:
    """Conversion of readings to figures: the mean of manufactured samples with its interval, or a
    stated value with its limits.

    Where members are declared rigid, wind-up is a lower and stiffness an upper limit; where a
    drawing describes nothing that opens play, or no friction, so are play, lost motion and loop.
    """

    gear: Gear
    units: Units

    @property
    def samples(self) -> str:
        """Return what the figures were counted from."""
        return STATED if self.gear.drawn is None else f"{self.gear.count} simulated gearboxes"

    def angle(self, values: Floats, rests_on: tuple[str, ...]) -> Cell:
        """Return an angle of the samples, or the stated one, as a bound where kinds of error that
        it rests on are not described.
        """
        gearbox, drawn, angle = self.gear.gearbox, self.gear.drawn, self.units.angle
        if not is_drawn(gearbox):
            return bounded(Cell(float(values[0]), angle), gearbox, rests_on)
        known = part_states(gearbox, "gearbox")
        least = (
            (any(name in OF_PLAY for name in rests_on) and drawn is not None and drawn.without_play)
            or (any(name in OF_LOOP for name in rests_on) and known["hysteresis"] == "ideal")
            or (any(name in OF_STIFFNESS for name in rests_on) and bool(gearbox.rigid))
        )
        return over_samples(values, angle, bound="lower" if least else "")

    def stiffness(self, values: Floats) -> Cell:
        """Return a stiffness."""
        gearbox, unit = self.gear.gearbox, self.units.stiffness
        if is_drawn(gearbox):
            return over_samples(values, unit, bound="upper" if gearbox.rigid else "")
        value, share = float(values[0]), gearbox.stiffness_scatter
        ends = (value / (1 + share), value / (1 - share)) if 0 < share < 1 else (math.nan, math.nan)
        return Cell(value, unit, *ends, ends="stated limits")

    @property
    def play(self) -> Cell:
        """Return the play."""
        gearbox, drawn = self.gear.gearbox, self.gear.drawn
        if is_drawn(gearbox):
            return self.angle(np.zeros(2) if drawn is None else drawn.play, OF_PLAY)
        return play_figure(gearbox, self.units)

    def wind_up(self, read: CurveReadings) -> Cell:
        """Return the wind-up."""
        gearbox = self.gear.gearbox
        if is_drawn(gearbox):
            return self.angle(read.wind_up, OF_STIFFNESS)
        return wind_up_figure(gearbox, float(read.wind_up[0]), self.units)

    def displacement(self, read: CurveReadings) -> Cell:
        """Return the displacement."""
        gearbox = self.gear.gearbox
        if is_drawn(gearbox):
            return self.angle(read.displacement, OF_PLAY + OF_STIFFNESS)
        return displacement_figure(gearbox, read, self.units)

    def lost_motion(self, read: CurveReadings) -> Cell:
        """Return the lost motion."""
        gearbox = self.gear.gearbox
        if is_drawn(gearbox):
            lost = np.zeros(2) if read.lost_motion is None else read.lost_motion
            return self.angle(lost, OF_PLAY + OF_STIFFNESS)
        return lost_motion_figure(gearbox, read, self.units)


def bands_sections(
    bands: GearBands | None, read: CurveReadings, show: Shown
) -> tuple[Section, ...]:
    """Return the table of the bands, and that of the ranges behind them; none without ranges."""
    if bands is None:
        return ()
    drawn = f"{len(bands.shares)} draws of {several(len(bands.unknown), 'range')}"
    whole = sum(bands.middle.values())
    rows = [
        *_band_rows(bands, read, show),
        *(
            (f"share of {name}", *_figures(bands.middle.get(name, 0.0) / whole, "%", share))
            for name, share in bands.member_shares.items()
            if share.max() >= _SMALLEST
        ),
    ]
    explained = influence(bands.shares, np.asarray(bands.read.wind_up))
    ranges = sorted(zip(bands.unknown, explained.tolist(), strict=True), key=lambda pair: -pair[1])
    return (
        table(
            "bands",
            "What the ranges leave open",
            ["5th percentile", "middle", "95th percentile"],
            rows,
            f"over {drawn}, without the scatter between gearboxes; middle: mean of the gearboxes "
            "with the middle of each range; shares: of the wind-up",
            samples=drawn,
        ),
        table(
            "ranges",
            "Ranges",
            ["share of variance"],
            (
                Row(each.name, (Cell(share, "%", samples=drawn),), key=key_of(each.key))
                for each, share in ranges
            ),
            "share of the variance of the wind-up that each range explains by itself; the largest "
            "is the first to measure",
        ),
    )


def _band_rows(
    bands: GearBands, read: CurveReadings, show: Shown
) -> Iterator[tuple[str, Cell, Cell, Cell, str]]:
    torque = f"{stated_text(read.asked.torque)} {show.units.torque}"
    of_play = partial(show.angle, rests_on=OF_PLAY + OF_STIFFNESS)
    for label, name, figure, note in (
        ("stiffness, slope", "slope", show.stiffness, ""),
        (
            "stiffness, secant",
            "secant",
            show.stiffness,
            f"from the middle of the play to {torque}",
        ),
        (
            f"wind-up at {torque}",
            "wind_up",
            partial(show.angle, rests_on=OF_STIFFNESS),
            "beyond the play",
        ),
        (f"displacement at {torque}", "displacement", of_play, "from the middle of the play"),
        ("lost motion", "lost_motion", of_play, ""),
    ):
        middle, values = getattr(read, name), getattr(bands.read, name)
        if is_known(middle) and is_known(values):
            mean = figure(middle)
            yield label, *_figures(mean.value, mean.shown, values, mean.bound), note


def _figures(
    middle: float, unit: str, values: Floats, bound: Bound = ""
) -> tuple[Cell, Cell, Cell]:
    low, high = (Cell(end, unit, bound=bound) for end in band(values))
    return low, Cell(middle, unit, bound=bound), high


def stiffness_band(
    bands: GearBands | None, read: CurveReadings | None, units: Units
) -> tuple[Cell, Cell, Cell] | None:
    """Return the stiffness by its definition, or else as secant, with the limits of its band: 5th
    percentile, middle, 95th percentile.

    None where no more than a fifth of the compliance depends on ranges.
    """
    if bands is None or read is None or bands.unknown_share <= LARGE:
        return None
    name = "secant" if read.stiffness is None else "stiffness"
    middle, values = getattr(read, name), getattr(bands.read, name)
    if not (is_known(middle) and is_known(values)):
        return None
    return _figures(float(middle.mean()), units.stiffness, values)


def first_sentence(figures: tuple[Cell, Cell, Cell] | None) -> str:
    """Return the sentence that begins a headline with the band of the stiffness; empty without
    one.
    """
    if figures is None:
        return ""
    low, middle, high = (each.number for each in figures)
    return f"Stiffness {low} .. {high} {figures[0].shown} ({OPEN}), middle {middle}. "


def with_band(card: Card, figures: tuple[Cell, Cell, Cell] | None) -> Card:
    """Return the card of the stiffness with its band before the value of the middle."""
    if figures is None or card.title != "stiffness":
        return card
    low, middle, high = (each.number for each in figures)
    return Card(
        card.title, f"{low} .. {high} {figures[0].shown}", f"{OPEN}; middle {middle}; {card.quiet}"
    )


def bands_facts(bands: GearBands | None) -> dict[str, Any]:
    """Return what result.json holds of the ranges besides the figures: their limits in SI, and the
    share of the compliance that depends on them.
    """
    if bands is None:
        return {}
    ranges = [
        {"key": each.name, "low": each.band.low, "high": each.band.high, "law": each.band.law}
        for each in bands.unknown
    ]
    return {"ranges": ranges, "share_of_compliance_in_ranges": bands.unknown_share}
