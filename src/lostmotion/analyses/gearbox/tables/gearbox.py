"""The figures of a gearbox of any kind: ratio, hysteresis loop, and stated values."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.gearbox.tables.cycloidal import (
    Bound,
    cards_of_drawing,
    doubts_of_drawing,
    over_samples,
    sections_of_drawing,
    verdict_of_drawing,
)
from lostmotion.catalogue.gearboxes import find_rows
from lostmotion.errors import InputError
from lostmotion.laws.gears import wind_up
from lostmotion.parts.gearbox.kinds import is_drawn, is_sliding
from lostmotion.reporting.provenance import with_assumed
from lostmotion.reporting.sheet import ARCMIN, Card, Figure, Row, Section, Sheet

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.analyses.gearbox.cycloidal import Drawn
    from lostmotion.analyses.gearbox.gear import GearStudy, Loop
    from lostmotion.analyses.gearbox.readings import Readings
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.kinds import AnyGearbox, StatedGearbox
    from lostmotion.spatial import Floats

_STATED: Final = "the values stated"
# Fields that the play, and friction's loop, come from.
_OF_PLAY: Final = ("backlash", "lost_motion")
_OF_LOOP: Final = ("hysteresis",)
_WORDS: Final = (
    ("play", "how far the output turns freely. A load above friction holds it on one side."),
    ("lost motion", "how far the output turns between the middles of the loop at a small torque one way and the other: play, and elastic wind-up."),
    ("wind-up", "how far the output turns under the torque with the input held, play not counted."),
    ("torsion", "the same from the middle of the play: half the play and the wind-up."),
    ("secant, slope", "stiffness as torque over wind-up, and as the rise of the torque-angle curve between two torques. Makers print either."),
    ("friction's loop", "hysteresis: with friction the output stands elsewhere when the torque rises than when it falls. Play comes on top."),
    ("transmission error", "how far the output runs ahead or behind an even ratio as it turns."),
)


@dataclass(frozen=True, slots=True)
class Units:
    """In which units people read a gearbox: of a turning joint, or of a drive that slides. Each with what SI is multiplied by."""

    angle: str
    angle_factor: float
    torque: str
    stiffness: str
    stiffness_factor: float
    what: str
    limit: str

    def of_angle(self, value: float, samples: str, low: float = math.nan, high: float = math.nan, ends: str = "95 % interval") -> Figure:
        """Return an angle, or a length of a drive that slides."""
        factor = self.angle_factor
        return Figure(value * factor, self.angle, low * factor, high * factor, samples, ends)

    def of_torque(self, value: float, samples: str) -> Figure:
        """Return a torque, or a force."""
        return Figure(value, self.torque, samples=samples, stated=samples == _STATED)

    def of_stiffness(self, value: float, samples: str) -> Figure:
        """Return a stiffness."""
        return Figure(value * self.stiffness_factor, self.stiffness, samples=samples, stated=samples == _STATED)


TURNING: Final = Units("arcmin", 1 / ARCMIN, "N m", "N m/arcmin", ARCMIN, "torque", "turn of the output")
SLIDING: Final = Units("µm", 1e6, "N", "N/µm", 1e-6, "force", "turn of the screw or pulley")


def units_of(gearbox: object) -> Units:
    """Return the units of this gearbox."""
    return SLIDING if is_sliding(gearbox) else TURNING


def gearbox_sheet(name: str, study: GearStudy, notes: tuple[str, ...] = ()) -> Sheet:
    """Return the sheet of a gearbox."""
    gearbox, drawn = study.gearbox, study.drawn
    if not is_drawn(gearbox):
        return with_assumed(_of_figures(name, study, gearbox, notes), gearbox, "gearbox")
    if drawn is None:
        raise ValueError("a gearbox by its drawing without the results of its drawing")
    return with_assumed(_of_drawing(name, study, gearbox, drawn, notes), gearbox, "gearbox")


def _of_figures(name: str, study: GearStudy, gearbox: StatedGearbox, notes: tuple[str, ...]) -> Sheet:
    units = units_of(gearbox)
    loop = () if study.loop is None or study.read is None else (_loop(study.loop, study.read, study, units),)
    return Sheet(
        name=name,
        subject="gearbox",
        verdict=_verdict(study, gearbox, units),
        cards=tuple(_cards(study, gearbox, units)),
        sections=(_stated(gearbox, units), *_zones(gearbox, units), *loop, *_waves(gearbox, units)),
        notes=(*notes, *_doubts(study, gearbox, units)),
        words=_WORDS,
        source=f"{units.what}: {_load_text(study, units)}",
        facts=_facts(name, study, units),
    )


def _of_drawing(name: str, study: GearStudy, gearbox: CycloidalGearbox, drawn: Drawn, notes: tuple[str, ...]) -> Sheet:
    units = TURNING
    load = _load_text(study, units)
    geometry, lobes, built, *others = sections_of_drawing(gearbox, drawn, study.count)
    loop = () if study.loop is None else (_loop(study.loop, drawn.read, study, units),)
    return Sheet(
        name=name,
        subject="gearbox",
        counts=f"{load}; {study.count} simulated gearboxes, seed {study.seed}",
        verdict=verdict_of_drawing(gearbox, drawn, load, study.count),
        cards=cards_of_drawing(gearbox, drawn, load),
        sections=(geometry, lobes, built, *loop, *others),
        notes=(*notes, *doubts_of_drawing(gearbox, drawn, study.torque or gearbox.rated_torque)),
        words=_WORDS,
        source=f"seed {study.seed}, {study.count} simulated gearboxes; torque: {load}. The same file, version, torque and seed give the same bytes.",
        seed=study.seed,
        facts={**_facts(name, study, units), "seed": study.seed, "built": study.count, "taken_as_rigid": list(gearbox.rigid)},
    )


def _load_text(study: GearStudy, units: Units) -> str:
    return f"no {units.what} stated" if study.torque is None else f"{study.torque:.4g} {units.torque}"


def _facts(name: str, study: GearStudy, units: Units) -> dict[str, Any]:
    gearbox, ratio = study.gearbox, _ratio(study.gearbox)
    return {
        "gearbox": name,
        "kind": gearbox.kind,
        "ratio": ratio and ratio.value,
        f"{units.what}_{units.torque.replace(' ', '')}": study.torque,
    }


def _doubts(study: GearStudy, gearbox: StatedGearbox, units: Units) -> tuple[str, ...]:
    if study.read is None or study.torque is None:
        return (f"no rated {units.what} is stated, so nothing under load is shown: give one with --torque",)
    notes = []
    if study.loop is None and study.torque <= gearbox.friction:
        notes.append(f"{study.torque:.4g} {units.torque} do not overcome the friction: no hysteresis is shown")
    if study.read.lost_motion is None or study.read.slope is None:
        notes.append(
            f"no rated {units.what} is stated, so no lost motion at a share of it and no slope of the stiffness are shown: state rated_torque, or "
            f"give {units.what}s with --lost-motion-torque and --slope-range"
        )
    return tuple(notes)


def _verdict(study: GearStudy, gearbox: StatedGearbox, units: Units) -> str:
    errors = [name for name in gearbox.model_fields_set if name.endswith("_error") and getattr(gearbox, name) is not None]
    named = {
        "stiffness": bool(gearbox.zones),
        "play": _states_play(gearbox),
        "hysteresis": gearbox.hysteresis is not None,
        "transmission error": bool(errors),
    }
    silent = ", ".join(name for name, stated in named.items() if not stated)
    kind = "" if gearbox.kind == "catalogue" and not _of_catalogue(gearbox) else f"{gearbox.kind} "
    sentences = [f"A {kind}gearbox by stated figures" + (f"; not specified and taken as ideal: {silent}." if silent else ".")]
    if study.loop is not None:
        sentences.append(f"Play {_play(gearbox, units)}.")
    if study.read is not None and study.read.lost_motion is not None:
        sentences.append(f"Lost motion {_lost_motion(gearbox, study.read, units)} at ± {study.read.asked.small:.4g} {units.torque}.")
    if study.wind_up and study.read is not None:
        wound, torsion = _wound(gearbox, study.wind_up, units), _torsion(gearbox, study.read, units)
        sentences.append(f"Under {_load_text(study, units)} the output stands {torsion} from the middle of its play; {wound} of that is wind-up.")
    return " ".join(sentences)


def _states_play(gearbox: StatedGearbox) -> bool:
    """Return whether the play is stated, be it as zero."""
    return gearbox.backlash is not None or gearbox.lost_motion is not None


def _of_catalogue(gearbox: StatedGearbox) -> bool:
    """Return whether its model is one of the catalogue's; a user's own gearbox has another name, or none."""
    try:
        return bool(gearbox.model) and bool(find_rows(gearbox.model))
    except InputError:
        return False


def _cards(study: GearStudy, gearbox: StatedGearbox, units: Units) -> list[Card]:
    ratio, read = _ratio(gearbox), study.read
    cards = [] if ratio is None else [Card("ratio", str(ratio), "turns of the input per turn of the output")]
    cards.append(Card("play", str(_play(gearbox, units)), "" if _states_play(gearbox) else "none is stated"))
    if read is not None and read.lost_motion is not None:
        cards.append(Card("lost motion", str(_lost_motion(gearbox, read, units)), f"at ± {read.asked.small:.4g} {units.torque}"))
    if study.wind_up and read is not None:
        cards.append(Card("torsion", str(_torsion(gearbox, read, units)), f"from the middle of the play at {study.torque:.4g} {units.torque}"))
        cards.append(Card("wind-up", str(_wound(gearbox, study.wind_up, units)), f"at {study.torque:.4g} {units.torque}, play not counted"))
    return cards


def _play(gearbox: StatedGearbox, units: Units) -> Figure:
    return _at_most(_limited(gearbox.play.nominal, gearbox.play.tolerance, units), gearbox, _OF_PLAY)


def _wound(gearbox: StatedGearbox, wound: float, units: Units) -> Figure:
    """Return a wind-up with the limits that the stated scatter of the stiffness sets."""
    return _limited(wound, gearbox.stiffness_scatter * wound, units)


def _lost_motion(gearbox: StatedGearbox, read: Readings, units: Units) -> Figure:
    """Return the lost motion with its limits: those of play and wind-up, independent of each other, by the root of their squares."""
    value = math.nan if read.lost_motion is None else float(read.lost_motion[0])
    tolerance = math.hypot(gearbox.play.tolerance, gearbox.stiffness_scatter * (value - gearbox.play.nominal))
    return _at_most(_limited(value, tolerance, units), gearbox, _OF_PLAY)


def _torsion(gearbox: StatedGearbox, read: Readings, units: Units) -> Figure:
    value = float(read.torsion[0])
    tolerance = math.hypot(gearbox.play.tolerance / 2, gearbox.stiffness_scatter * float(read.wind_up[0]))
    return _at_most(_limited(value, tolerance, units), gearbox, _OF_PLAY)


def _at_most(figure: Figure, gearbox: StatedGearbox, rests_on: tuple[str, ...]) -> Figure:
    """Mark a figure as an upper limit where one of the values that it rests on is a maker's upper limit."""
    return replace(figure, bound="upper") if any(name in gearbox.upper_limits for name in rests_on) else figure


def _limited(value: float, tolerance: float, units: Units) -> Figure:
    ends = (value - tolerance, value + tolerance) if tolerance else (math.nan, math.nan)
    return units.of_angle(value, _STATED, *ends, ends="stated limits")


def _ratio(gearbox: AnyGearbox) -> Figure | None:
    """Return the ratio, unless a row of a catalogue leaves it out."""
    return _pure(gearbox.ratio) if gearbox.states_ratio else None


def _pure(value: float) -> Figure:
    """Return a pure number, a whole one as such."""
    return Figure(int(value) if float(value).is_integer() else value, "1", samples=_STATED, stated=True)


def _stated(gearbox: StatedGearbox, units: Units) -> Section:
    ratio = _ratio(gearbox)
    opposite = "below zero: input and output go opposite ways" if gearbox.ratio < 0 else ""
    rows = [] if ratio is None else [Row("ratio", (ratio,), opposite)]
    if gearbox.rated_torque is not None:
        rows.append(Row(f"rated {units.what}", (units.of_torque(gearbox.rated_torque, _STATED),)))
    play = gearbox.play
    from_lost_motion = "follows from the lost motion" if gearbox.lost_motion is not None else ""
    if play.nominal or gearbox.backlash is not None:
        rows.append(Row("play", (_play(gearbox, units),), from_lost_motion))
    if gearbox.lost_motion is not None:
        note = f"between ± {100 * gearbox.lost_motion_torque:.3g} % of the rated {units.what}"
        rows.append(Row("lost motion", (_at_most(units.of_angle(gearbox.lost_motion, _STATED), gearbox, _OF_PLAY),), note))
    if gearbox.hysteresis is not None:
        width = _at_most(units.of_angle(gearbox.hysteresis, _STATED), gearbox, _OF_LOOP)
        rows.append(Row("friction's loop, full width", (width,), f"at zero {units.what}, play not in it"))
    if gearbox.friction:
        assumed = "" if gearbox.friction_torque is not None else f"taken as 1 % of the rated {units.what}, none is stated"
        rows.append(Row(f"friction without load, as {units.what}", (units.of_torque(gearbox.friction, _STATED),), assumed))
    for own in gearbox.own_figures:
        figure = Figure(math.degrees(own.value), "deg", samples=_STATED) if own.unit == "rad" else _pure(own.value)
        rows.append(Row(own.label, (figure,), own.note))
    return Section("stated", "What is stated", ("value",), tuple(rows))


def _zones(gearbox: StatedGearbox, units: Units) -> tuple[Section, ...]:
    zones, limits = gearbox.zones, gearbox.zone_torques
    if not zones:
        return ()
    rows = []
    for k, stiffness in enumerate(zones):
        start = f"from {limits[k - 1]:.4g} {units.torque}" if k else "from zero"
        label = f"zone {k + 1}, {start}" if len(zones) > 1 else "stiffness"
        rows.append(Row(label, (units.of_stiffness(stiffness, _STATED),)))
    rows += [
        Row(
            f"wind-up at {limit:.4g} {units.torque}", (units.of_angle(float(wind_up(np.asarray(limit), zones, limits)), _STATED),), f"end of zone {k}"
        )
        for k, limit in enumerate(limits, 1)
    ]
    note = f"scatters by ± {100 * gearbox.stiffness_scatter:.3g} % over gearboxes" if gearbox.stiffness_scatter else ""
    return (Section("zones", "Stiffness", ("value",), tuple(rows), note),)


def _loop(loop: Loop, read: Readings, study: GearStudy, units: Units) -> Section:
    gearbox, torque = study.gearbox, study.gearbox.rated_torque
    show = _Shown(study, units)
    rows = [*_stiffnesses(read, study, show)]
    assumed = "" if gearbox.friction_torque is not None else f" (taken as 1 % of the rated {units.what})"
    crossed = f"traversed once {loop.rest:.3g} {units.torque} overcome friction{assumed}" if loop.rest else "traversed by any load"
    rows.append(Row("play", (show.play,), crossed))
    rows.append(Row("friction's loop alone", (show.angle(read.friction_width, rests_on=_OF_LOOP),), f"width at zero {units.what}"))
    if study.drawn is not None and study.drawn.rubbing is not None:
        half = f"width at {read.asked.torque / 2:.4g} {units.torque}"
        rows.append(Row("friction's loop under load", (show.angle(read.friction_under_load),), half))
    rows.append(Row(f"whole loop at zero {units.what}", (show.angle(read.width, rests_on=_OF_PLAY + _OF_LOOP),), "play and friction"))
    if read.lost_motion is not None and read.asked.small is not None:
        share = "" if torque is None else f", {100 * read.asked.small / torque:.3g} % of the rated {units.what}"
        note = f"between the middles of the loop at ± {read.asked.small:.4g} {units.torque}{share}"
        rows.append(Row("lost motion", (show.lost_motion(read),), note))
    return Section("loop", "Stiffness and hysteresis", ("value",), tuple(rows), "loaded and unloaded both ways, input held")


def _stiffnesses(read: Readings, study: GearStudy, show: _Shown) -> Iterator[Row]:
    """Yield the rows of torsion and stiffness, each with its definition."""
    units, torque = show.units, f"{read.asked.torque:.4g} {show.units.torque}"
    if study.wind_up:
        yield Row(f"torsion at {torque}", (show.torsion(read),), "from the middle of the play: half the play and the wind-up")
        yield Row(f"wind-up at {torque}", (show.wound(read),), "either way, play not counted")
        yield Row("stiffness, secant", (show.stiffness(read.secant),), f"{torque} over the wind-up there")
    if read.slope is not None and read.asked.slope is not None and np.isfinite(read.slope).all():
        low, high = read.asked.slope
        rated = study.gearbox.rated_torque
        share = "" if rated is None else f", {100 * low / rated:.3g} to {100 * high / rated:.3g} % of the rated {units.what}"
        yield Row("stiffness, slope", (show.stiffness(read.slope),), f"from {low:.4g} to {high:.4g} {units.torque}{share}, on the middle of the loop")


class _Shown:
    """How readings become figures: of manufactured samples their mean with its interval, of stated figures the value with its limits.

    Where members are not specified, wind-up is a lower and stiffness an upper limit.
    """

    def __init__(self, study: GearStudy, units: Units) -> None:
        self.units = units
        self._drawn = study.drawn
        self._stated = None if is_drawn(study.gearbox) else study.gearbox
        self._bounded = is_drawn(study.gearbox) and bool(study.gearbox.rigid)
        self.samples = _STATED if self._stated is not None else f"{study.count} simulated gearboxes"

    @property
    def play(self) -> Figure:
        if self._stated is not None:
            return _play(self._stated, self.units)
        return self.angle(self._drawn.play if self._drawn is not None else np.zeros(2))

    def angle(self, values: Floats, bound: Bound = "", rests_on: tuple[str, ...] = ()) -> Figure:
        if self._stated is not None:
            return _at_most(self.units.of_angle(float(values[0]), _STATED), self._stated, rests_on)
        return over_samples(values, self.units.angle, self.units.angle_factor, self.samples, bound)

    def stiffness(self, values: Floats) -> Figure:
        factor, unit = self.units.stiffness_factor, self.units.stiffness
        if self._stated is None:
            return over_samples(values, unit, factor, self.samples, "upper" if self._bounded else "")
        value, share = float(values[0]) * factor, self._stated.stiffness_scatter
        ends = (value / (1 + share), value / (1 - share)) if 0 < share < 1 else (math.nan, math.nan)
        return Figure(value, unit, *ends, _STATED, "stated limits")

    def wound(self, read: Readings) -> Figure:
        if self._stated is not None:
            return _wound(self._stated, float(read.wind_up[0]), self.units)
        return self.angle(read.wind_up, "lower" if self._bounded else "")

    def torsion(self, read: Readings) -> Figure:
        return _torsion(self._stated, read, self.units) if self._stated is not None else self.angle(read.torsion, "lower" if self._bounded else "")

    def lost_motion(self, read: Readings) -> Figure:
        if self._stated is not None:
            return _lost_motion(self._stated, read, self.units)
        return self.angle(np.zeros(2) if read.lost_motion is None else read.lost_motion)


def _waves(gearbox: StatedGearbox, units: Units) -> tuple[Section, ...]:
    rows = tuple(Row(name, (units.of_angle(size, _STATED), _pure(cycles))) for name, size, cycles in gearbox.harmonics)
    if not rows:
        return ()
    note = "amplitude is half of peak to peak; each gearbox has its own phase"
    return (Section("transmission", "Transmission error", ("amplitude", f"cycles per {units.limit}"), rows, note),)
