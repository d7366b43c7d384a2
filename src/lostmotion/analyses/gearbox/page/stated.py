"""A gearbox by stated figures: its units, headline, cards and tables, each figure with the limits
that are stated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.catalogue.gearboxes import find_rows
from lostmotion.error_model.provenance import part_states
from lostmotion.errors import InputError
from lostmotion.laws.gears import wind_up
from lostmotion.parts.error_source import FRICTION_SCATTER_TEXT
from lostmotion.parts.gearbox.kinds import is_sliding
from lostmotion.printed import stated_text
from lostmotion.reporting.sheet import Card, Cell, table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.analyses.gearbox.gear import Gear
    from lostmotion.laws.torque_angle import CurveReadings, Definitions
    from lostmotion.parts.error_source import Friction, PartFigure
    from lostmotion.parts.gearbox.kinds import AnyGearbox, StatedGearbox
    from lostmotion.reporting.sheet import Section

# The sample of a figure that was stated.
STATED: Final = "the values stated"
# Kinds of error and fields that determine the play, the wind-up and the hysteresis.
OF_PLAY: Final = ("backlash", "lost_motion")
OF_STIFFNESS: Final = ("stiffness",)
OF_LOOP: Final = ("hysteresis",)


@dataclass(frozen=True, slots=True)
class Units:
    """Units in which a gearbox on a turning joint, or a sliding drive, is shown."""

    angle: str
    torque: str
    stiffness: str
    what: str
    limit: str

    def definition(self, asked: Definitions) -> str:
        """Return the definition of the stiffness asked for, with its torques, as text."""
        load = f"{stated_text(asked.torque)} {self.torque}"
        if asked.stiffness == "secant":
            return f"secant from the middle of the play to {load}"
        if asked.stiffness == "tangent":
            return f"tangent at {load}"
        if asked.span is None:
            raise ValueError("no torques for the stiffness")
        low, high = asked.span
        name = "b/a of the hysteresis curve" if asked.stiffness == "b/a" else "slope"
        return f"{name} from {stated_text(low)} to {stated_text(high)} {self.torque}"


TURNING: Final = Units("arcmin", "N m", "N m/arcmin", "torque", "turn of the output")
SLIDING: Final = Units("µm", "N", "N/µm", "force", "turn of the screw or pulley")


def units_of(gearbox: object) -> Units:
    """Return the units of this gearbox."""
    return SLIDING if is_sliding(gearbox) else TURNING


def load_text(gear: Gear, units: Units) -> str:
    """Return the torque or force as text."""
    if gear.torque is None:
        return f"no {units.what} stated"
    return f"{stated_text(gear.torque)} {units.torque}"


def doubts_of_figures(gear: Gear, gearbox: StatedGearbox, units: Units) -> tuple[str, ...]:
    """Return what limits the figures: no rated torque, or a torque that does not overcome
    friction.
    """
    if gear.read is None or gear.torque is None:
        return (
            (
                f"no rated {units.what} is stated, so that no figures under load are shown: state "
                "one with --torque"
            ),
        )
    notes = []
    if gear.loop is None and gear.torque <= gearbox.friction.load.nominal:
        notes.append(
            f"{stated_text(gear.torque)} {units.torque} do not overcome the friction: no "
            "hysteresis is shown"
        )
    if gear.read.lost_motion is None or gear.read.slope is None:
        notes.append(
            f"no rated {units.what} is stated, so no lost motion at a share of it and no slope "
            "of the stiffness are shown: state rated_torque, or "
            f"{units.what}s with --lost-motion-torque and --slope-range"
        )
    return tuple(notes)


def verdict_of_figures(gear: Gear, gearbox: StatedGearbox, units: Units) -> str:
    """Return the headline."""
    errors = [
        name
        for name in gearbox.model_fields_set
        if name.endswith("_error") and getattr(gearbox, name) is not None
    ]
    named = {
        "stiffness": bool(gearbox.zones),
        "play": _states_play(gearbox),
        "hysteresis": gearbox.loop_width is not None,
        "transmission error": bool(errors),
    }
    silent = ", ".join(name for name, stated in named.items() if not stated)
    kind = "" if gearbox.kind == "catalogue" and not _of_catalogue(gearbox) else f"{gearbox.kind} "
    sentences = [
        f"A {kind}gearbox by stated figures"
        + (f"; not specified and assumed ideal: {silent}." if silent else ".")
    ]
    if gear.loop is not None and named["play"]:
        sentences.append(f"Play {_in_sentence(play_figure(gearbox, units))}.")
    if gear.read is not None and gear.read.lost_motion is not None:
        sentences.append(
            f"Lost motion {_in_sentence(lost_motion_figure(gearbox, gear.read, units))} at ± "
            f"{gear.read.asked.small:.4g} {units.torque}."
        )
    if gear.wind_up and gear.read is not None:
        wound, displacement = (
            wind_up_figure(gearbox, gear.wind_up, units),
            displacement_figure(gearbox, gear.read, units),
        )
        sentences.append(
            f"Under {load_text(gear, units)} the output is {_in_sentence(displacement)} from the "
            f"middle of its play; {wound} of that is wind-up."
        )
    return " ".join(sentences)


def _in_sentence(figure: Cell) -> str:
    """Return a figure with its bound in words."""
    return str(figure).replace("≥", "at least").replace("≤", "at most")


def _states_play(gearbox: StatedGearbox) -> bool:
    """Return whether the play is stated, including a stated zero."""
    return gearbox.backlash is not None or gearbox.lost_motion is not None


def _of_catalogue(gearbox: StatedGearbox) -> bool:
    """Return whether its model is one of the catalogue's; a user's gearbox has another name, or
    none.
    """
    try:
        return bool(gearbox.model) and bool(find_rows(gearbox.model))
    except InputError:
        return False


def cards_of_figures(gear: Gear, gearbox: StatedGearbox, units: Units) -> list[Card]:
    """Return the main figures: ratio, play, lost motion, displacement and wind-up."""
    ratio, read = ratio_figure(gearbox), gear.read
    cards = (
        []
        if ratio is None
        else [Card("ratio", str(ratio), "turns of the input per turn of the output")]
    )
    cards.append(
        Card(
            "play",
            str(play_figure(gearbox, units)),
            "" if _states_play(gearbox) else "none is stated",
        )
    )
    if read is not None and read.lost_motion is not None:
        cards.append(
            Card(
                "lost motion",
                str(lost_motion_figure(gearbox, read, units)),
                f"at ± {read.asked.small:.4g} {units.torque}",
            )
        )
    if gear.wind_up and read is not None:
        load = load_text(gear, units)
        cards.append(
            Card(
                "displacement",
                str(displacement_figure(gearbox, read, units)),
                f"from the middle of the play at {load}",
            )
        )
        cards.append(
            Card(
                "wind-up",
                str(wind_up_figure(gearbox, gear.wind_up, units)),
                f"at {load}, beyond the play",
            )
        )
    return cards


def play_figure(gearbox: StatedGearbox, units: Units) -> Cell:
    """Return the play with its stated limits."""
    play = _limited(gearbox.play.nominal, gearbox.play.tolerance, units)
    return bounded(play, gearbox, OF_PLAY)


def wind_up_figure(gearbox: StatedGearbox, wound: float, units: Units) -> Cell:
    """Return a wind-up with the limits from the stated scatter of the stiffness."""
    return _limited(wound, gearbox.stiffness_scatter * wound, units)


def lost_motion_figure(gearbox: StatedGearbox, read: CurveReadings, units: Units) -> Cell:
    """Return the lost motion with its limits: those of play and wind-up, independent of each other,
    by the root of their squares.
    """
    value = math.nan if read.lost_motion is None else float(read.lost_motion[0])
    tolerance = math.hypot(
        gearbox.play.tolerance, gearbox.stiffness_scatter * (value - gearbox.play.nominal)
    )
    rests_on = OF_PLAY if gearbox.lost_motion is not None else (*OF_PLAY, *OF_STIFFNESS)
    return bounded(_limited(value, tolerance, units), gearbox, rests_on)


def displacement_figure(gearbox: StatedGearbox, read: CurveReadings, units: Units) -> Cell:
    """Return the displacement from the middle of the play with its limits: those of half the play
    and of the wind-up, independent of each other.
    """
    value = float(read.displacement[0])
    tolerance = math.hypot(
        gearbox.play.tolerance / 2, gearbox.stiffness_scatter * float(read.wind_up[0])
    )
    return bounded(_limited(value, tolerance, units), gearbox, OF_PLAY)


def bounded(figure: Cell, gearbox: StatedGearbox, rests_on: tuple[str, ...]) -> Cell:
    """Mark a figure as an upper bound where it depends on a maker's upper limit, as a lower one
    where it depends on a kind of error that nothing describes; neither with both.
    """
    known = part_states(gearbox, "gearbox")
    upper = any(name in gearbox.upper_limits for name in rests_on)
    lower = any(known.get(name) == "ideal" for name in rests_on)
    return figure if upper == lower else replace(figure, bound="upper" if upper else "lower")


def _limited(value: float, tolerance: float, units: Units) -> Cell:
    return Cell(value, units.angle, *_ends(value, tolerance), STATED, "stated limits")


def _ends(value: float, tolerance: float) -> tuple[float, float]:
    return (value - tolerance, value + tolerance) if tolerance else (math.nan, math.nan)


def ratio_figure(gearbox: AnyGearbox) -> Cell | None:
    """Return the ratio, unless a row of a catalogue omits it."""
    return _pure(gearbox.ratio) if gearbox.states_ratio else None


def _pure(value: float) -> Cell:
    """Return a pure number, a whole one as such."""
    return Cell(
        int(value) if float(value).is_integer() else value, "1", samples=STATED, stated=True
    )


def stated_section(gearbox: StatedGearbox, units: Units) -> Section:
    """Return the table of stated figures."""
    return table(
        "stated", "What is stated", ["value"], _stated_rows(gearbox, units), samples=STATED
    )


def _stated_rows(gearbox: StatedGearbox, units: Units) -> Iterator[tuple[str, Cell, str]]:
    if ratio := ratio_figure(gearbox):
        opposite = "below zero: input and output turn in opposite directions"
        yield "ratio", ratio, opposite if gearbox.ratio < 0 else ""
    if gearbox.rated_torque is not None:
        rated = Cell(gearbox.rated_torque, units.torque, stated=True)
        yield f"rated {units.what}", rated, ""
    if gearbox.play.nominal or gearbox.backlash is not None:
        from_lost_motion = "follows from the lost motion" if gearbox.lost_motion is not None else ""
        yield "play", play_figure(gearbox, units), from_lost_motion
    if gearbox.lost_motion is not None:
        note = f"between ± {100 * gearbox.lost_motion_torque:.3g} % of the rated {units.what}"
        yield "lost motion", bounded(Cell(gearbox.lost_motion, units.angle), gearbox, OF_PLAY), note
    if gearbox.loop_width is not None:
        width = bounded(Cell(gearbox.loop_width, units.angle), gearbox, OF_LOOP)
        yield "friction's loop, full width", width, f"at zero {units.what}, without the play"
    friction = gearbox.friction
    if friction.load.nominal:
        assumed = "assumed" if friction.scatter_assumed else "stated"
        load = Cell(
            friction.load.nominal,
            units.torque,
            *_ends(friction.load.nominal, friction.load.tolerance),
            ends=f"{assumed} limits",
            stated=True,
        )
        yield f"friction without load, as {units.what}", load, friction_note(friction, units)
    for own in gearbox.own_figures:
        yield own.label, _own_figure(own, units), own.note


def _own_figure(own: PartFigure, units: Units) -> Cell:
    if own.unit == "rad":
        return Cell(own.value, "°")
    return Cell(own.value, units.stiffness, stated=True) if own.unit == "N/m" else _pure(own.value)


def friction_note(friction: Friction, units: Units) -> str:
    """Return what is assumed of a gearbox's friction: its size and scatter, or its scatter alone;
    empty where both are stated.
    """
    if friction.reason:
        return f"not stated, assumed 1 % of the rated {units.what}, {FRICTION_SCATTER_TEXT}"
    return (
        f"scatter not stated, assumed {FRICTION_SCATTER_TEXT}" if friction.scatter_assumed else ""
    )


def zones_sections(gearbox: StatedGearbox, units: Units) -> tuple[Section, ...]:
    """Return the table of stiffness by zone; none for a rigid gearbox."""
    zones, limits = gearbox.zones, gearbox.zone_torques
    if not zones:
        return ()
    names = [
        f"zone {k + 1}, from {f'{stated_text(limits[k - 1])} {units.torque}' if k else 'zero'}"
        for k in range(len(zones))
    ]
    rows = [
        *(
            (name, Cell(stiffness, units.stiffness, stated=True), "")
            for name, stiffness in zip(
                names if len(zones) > 1 else ["stiffness"], zones, strict=True
            )
        ),
        *(
            (
                f"wind-up at {stated_text(limit)} {units.torque}",
                Cell(float(wind_up(np.asarray(limit), zones, limits)), units.angle),
                f"end of zone {k}",
            )
            for k, limit in enumerate(limits, 1)
        ),
    ]
    scatter = gearbox.stiffness_scatter
    note = f"± {100 * scatter:.3g} % over gearboxes" if scatter else ""
    return (table("zones", "Stiffness", ["value"], rows, note, samples=STATED),)


def harmonics_sections(gearbox: StatedGearbox, units: Units) -> tuple[Section, ...]:
    """Return the table of the harmonics of the transmission error; none without them."""
    rows = [
        (name, Cell(size, units.angle), _pure(cycles)) for name, size, cycles in gearbox.harmonics
    ]
    columns = ["amplitude", f"cycles per {units.limit}"]
    note = "amplitude is half of peak to peak; each gearbox has its own phase"
    title = "Transmission error"
    return (table("transmission", title, columns, rows, note, samples=STATED),) if rows else ()
