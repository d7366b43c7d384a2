"""A gearbox by stated figures: its headline, cards and tables, each figure with the limits that are
stated.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.gearbox.tables.units import STATED
from lostmotion.catalogue.gearboxes import find_rows
from lostmotion.errors import InputError
from lostmotion.laws.gears import wind_up
from lostmotion.parts.error_source import FRICTION_SCATTER_TEXT
from lostmotion.printed import stated_text
from lostmotion.reporting.sheet import Card, Cell, Row, Section

if TYPE_CHECKING:
    from lostmotion.analyses.gearbox.gear import GearStudy
    from lostmotion.analyses.gearbox.tables.units import Units
    from lostmotion.laws.torque_angle import Readings
    from lostmotion.parts.error_source import Friction, PartFigure
    from lostmotion.parts.gearbox.kinds import AnyGearbox, StatedGearbox

# Fields that determine the play, and the hysteresis.
OF_PLAY: Final = ("backlash", "lost_motion")
OF_LOOP: Final = ("hysteresis",)


def doubts_of_figures(study: GearStudy, gearbox: StatedGearbox, units: Units) -> tuple[str, ...]:
    """Return what limits the figures: no rated torque, or a torque that does not overcome
    friction.
    """
    if study.read is None or study.torque is None:
        return (
            (
                f"no rated {units.what} is stated, so that no figures under load are shown: state "
                "one with --torque"
            ),
        )
    notes = []
    if study.loop is None and study.torque <= gearbox.friction.load.nominal:
        notes.append(
            f"{stated_text(study.torque)} {units.torque} do not overcome the friction: no "
            "hysteresis is shown"
        )
    if study.read.lost_motion is None or study.read.slope is None:
        notes.append(
            f"no rated {units.what} is stated, so no lost motion at a share of it and no slope "
            "of the stiffness are shown: state rated_torque, or "
            f"{units.what}s with --lost-motion-torque and --slope-range"
        )
    return tuple(notes)


def verdict_of_figures(study: GearStudy, gearbox: StatedGearbox, units: Units) -> str:
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
    if study.loop is not None:
        sentences.append(f"Play {play_figure(gearbox, units)}.")
    if study.read is not None and study.read.lost_motion is not None:
        sentences.append(
            f"Lost motion {lost_motion_figure(gearbox, study.read, units)} at ± "
            f"{study.read.asked.small:.4g} {units.torque}."
        )
    if study.wind_up and study.read is not None:
        wound, displacement = (
            wind_up_figure(gearbox, study.wind_up, units),
            displacement_figure(gearbox, study.read, units),
        )
        sentences.append(
            f"Under {load_text(study, units)} the output is {displacement} from the middle of "
            f"its play; {wound} of that is wind-up."
        )
    return " ".join(sentences)


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


def cards_of_figures(study: GearStudy, gearbox: StatedGearbox, units: Units) -> list[Card]:
    """Return the main figures: ratio, play, lost motion, displacement and wind-up."""
    ratio, read = ratio_figure(gearbox), study.read
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
    if study.wind_up and read is not None:
        load = load_text(study, units)
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
                str(wind_up_figure(gearbox, study.wind_up, units)),
                f"at {load}, beyond the play",
            )
        )
    return cards


def play_figure(gearbox: StatedGearbox, units: Units) -> Cell:
    """Return the play with its stated limits."""
    return at_most(_limited(gearbox.play.nominal, gearbox.play.tolerance, units), gearbox, OF_PLAY)


def wind_up_figure(gearbox: StatedGearbox, wound: float, units: Units) -> Cell:
    """Return a wind-up with the limits from the stated scatter of the stiffness."""
    return _limited(wound, gearbox.stiffness_scatter * wound, units)


def lost_motion_figure(gearbox: StatedGearbox, read: Readings, units: Units) -> Cell:
    """Return the lost motion with its limits: those of play and wind-up, independent of each other,
    by the root of their squares.
    """
    value = math.nan if read.lost_motion is None else float(read.lost_motion[0])
    tolerance = math.hypot(
        gearbox.play.tolerance, gearbox.stiffness_scatter * (value - gearbox.play.nominal)
    )
    return at_most(_limited(value, tolerance, units), gearbox, OF_PLAY)


def displacement_figure(gearbox: StatedGearbox, read: Readings, units: Units) -> Cell:
    """Return the displacement from the middle of the play with its limits: those of half the play
    and of the wind-up, independent of each other.
    """
    value = float(read.displacement[0])
    tolerance = math.hypot(
        gearbox.play.tolerance / 2, gearbox.stiffness_scatter * float(read.wind_up[0])
    )
    return at_most(_limited(value, tolerance, units), gearbox, OF_PLAY)


def at_most(figure: Cell, gearbox: StatedGearbox, rests_on: tuple[str, ...]) -> Cell:
    """Mark a figure as an upper limit where it depends on a maker's upper limit."""
    return (
        replace(figure, bound="upper")
        if any(name in gearbox.upper_limits for name in rests_on)
        else figure
    )


def _limited(value: float, tolerance: float, units: Units) -> Cell:
    ends = (value - tolerance, value + tolerance) if tolerance else (math.nan, math.nan)
    return units.of_angle(value, STATED, *ends, ends="stated limits")


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
    ratio = ratio_figure(gearbox)
    opposite = (
        "below zero: input and output turn in opposite directions" if gearbox.ratio < 0 else ""
    )
    rows = [] if ratio is None else [Row("ratio", (ratio,), opposite)]
    if gearbox.rated_torque is not None:
        rows.append(Row(f"rated {units.what}", (units.of_torque(gearbox.rated_torque, STATED),)))
    play = gearbox.play
    from_lost_motion = "follows from the lost motion" if gearbox.lost_motion is not None else ""
    if play.nominal or gearbox.backlash is not None:
        rows.append(Row("play", (play_figure(gearbox, units),), from_lost_motion))
    if gearbox.lost_motion is not None:
        note = f"between ± {100 * gearbox.lost_motion_torque:.3g} % of the rated {units.what}"
        rows.append(
            Row(
                "lost motion",
                (at_most(units.of_angle(gearbox.lost_motion, STATED), gearbox, OF_PLAY),),
                note,
            )
        )
    if gearbox.loop_width is not None:
        width = at_most(units.of_angle(gearbox.loop_width, STATED), gearbox, OF_LOOP)
        rows.append(
            Row("friction's loop, full width", (width,), f"at zero {units.what}, without the play")
        )
    load = gearbox.friction.load
    if load.nominal:
        limits = (
            (load.nominal - load.tolerance, load.nominal + load.tolerance)
            if load.tolerance
            else (math.nan, math.nan)
        )
        value = units.of_torque(
            load.nominal,
            STATED,
            *limits,
            ends="assumed limits" if gearbox.friction.scatter_assumed else "stated limits",
        )
        rows.append(
            Row(
                f"friction without load, as {units.what}",
                (value,),
                friction_note(gearbox.friction, units),
            )
        )
    rows += [Row(own.label, (_own_figure(own, units),), own.note) for own in gearbox.own_figures]
    return Section("stated", "What is stated", ("value",), tuple(rows))


def _own_figure(own: PartFigure, units: Units) -> Cell:
    if own.unit == "rad":
        return Cell(own.value, "°", samples=STATED)
    return units.of_stiffness(own.value, STATED) if own.unit == "N/m" else _pure(own.value)


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
    rows = []
    for k, stiffness in enumerate(zones):
        start = f"from {stated_text(limits[k - 1])} {units.torque}" if k else "from zero"
        label = f"zone {k + 1}, {start}" if len(zones) > 1 else "stiffness"
        rows.append(Row(label, (units.of_stiffness(stiffness, STATED),)))
    rows += [
        Row(
            f"wind-up at {stated_text(limit)} {units.torque}",
            (units.of_angle(float(wind_up(np.asarray(limit), zones, limits)), STATED),),
            f"end of zone {k}",
        )
        for k, limit in enumerate(limits, 1)
    ]
    note = (
        f"± {100 * gearbox.stiffness_scatter:.3g} % over gearboxes"
        if gearbox.stiffness_scatter
        else ""
    )
    return (Section("zones", "Stiffness", ("value",), tuple(rows), note),)


def harmonics_sections(gearbox: StatedGearbox, units: Units) -> tuple[Section, ...]:
    """Return the table of the harmonics of the transmission error; none without them."""
    rows = tuple(
        Row(name, (units.of_angle(size, STATED), _pure(cycles)))
        for name, size, cycles in gearbox.harmonics
    )
    if not rows:
        return ()
    note = "amplitude is half of peak to peak; each gearbox has its own phase"
    return (
        Section(
            "transmission",
            "Transmission error",
            ("amplitude", f"cycles per {units.limit}"),
            rows,
            note,
        ),
    )


def load_text(study: GearStudy, units: Units) -> str:
    """Return the torque or force as text."""
    return (
        f"no {units.what} stated"
        if study.torque is None
        else f"{stated_text(study.torque)} {units.torque}"
    )
