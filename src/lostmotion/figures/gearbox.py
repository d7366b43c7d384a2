"""The figures of a gearbox of any kind: what it reduces, how its output turns as the torque goes to and fro, what is stated of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from lostmotion.figures import ARCMIN, Card, Figure, Row, Section, Sheet
from lostmotion.figures.cycloidal import cards_of_drawing, doubts_of_drawing, sections_of_drawing, verdict_of_drawing
from lostmotion.laws.gears import wind_up
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.parts.gearbox.cycloidal_behaviour import GEARBOXES
from lostmotion.parts.gearbox.kinds import SlidingDrive
from lostmotion.parts.gearbox.wolfrom import WolfromGearbox
from lostmotion.parts.gearbox.worm import WormGearbox

if TYPE_CHECKING:
    from lostmotion.studies.gearbox.gear import AnyGearbox, GearStudy, Loop, StatedGearbox
    from lostmotion.studies.gearbox.gear_drawn import Drawn

_STATED: Final = "the values stated"
_WORDS: Final = (
    ("play", "how far the output turns freely. A load above friction holds it on one side."),
    ("lost motion", "how far the output turns between a small torque one way and the other: play, and what gives under that torque."),
    ("wind-up", "how far the output turns under the torque with the input held, play not counted."),
    ("friction's loop", "with friction the output stands elsewhere when the torque rises than when it falls. Play comes on top."),
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
        """Give an angle, or a length of a drive that slides."""
        factor = self.angle_factor
        return Figure(value * factor, self.angle, low * factor, high * factor, samples, ends)

    def of_torque(self, value: float, samples: str) -> Figure:
        """Give a torque, or a force."""
        return Figure(value, self.torque, samples=samples, stated=samples == _STATED)

    def of_stiffness(self, value: float, samples: str) -> Figure:
        """Give a stiffness."""
        return Figure(value * self.stiffness_factor, self.stiffness, samples=samples, stated=samples == _STATED)


TURNING: Final = Units("arcmin", 1 / ARCMIN, "N m", "N m/arcmin", ARCMIN, "torque", "turn of the output")
SLIDING: Final = Units("µm", 1e6, "N", "N/µm", 1e-6, "force", "turn of the screw or pulley")


# Of lengths and forces: a class of its own, though it shares its code with the turning one.
_SLIDES: Final[type[Any]] = SlidingDrive


def units_of(gearbox: object) -> Units:
    """In which units is this gearbox read?"""
    return SLIDING if isinstance(gearbox, _SLIDES) else TURNING


def gearbox_sheet(name: str, study: GearStudy, notes: tuple[str, ...] = ()) -> Sheet:
    """What is there to say about a gearbox?"""
    gearbox, drawn = study.gearbox, study.drawn
    if not isinstance(gearbox, CycloidalGearbox):
        return _of_figures(name, study, gearbox, notes)
    if drawn is None:
        raise ValueError("a gearbox by its drawing without what its drawing tells")
    return _of_drawing(name, study, gearbox, drawn, notes)


def _of_figures(name: str, study: GearStudy, gearbox: StatedGearbox, notes: tuple[str, ...]) -> Sheet:
    units = units_of(gearbox)
    loop = () if study.loop is None else (_loop(study.loop, study, units),)
    return Sheet(
        name=name,
        subject="gearbox",
        verdict=_verdict(study, gearbox, units),
        cards=tuple(_cards(study, gearbox, units)),
        sections=(_stated(gearbox, units), *_zones(gearbox, units), *loop, *_waves(gearbox, units)),
        notes=(*notes, *_doubts(study, gearbox, units)),
        words=_WORDS,
        source=f"{units.what}: {_said(study, units)}",
        facts=_facts(name, study, units),
    )


def _of_drawing(name: str, study: GearStudy, gearbox: CycloidalGearbox, drawn: Drawn, notes: tuple[str, ...]) -> Sheet:
    units, wound = TURNING, study.wind_up or math.nan
    said = _said(study, units)
    geometry, lobes, built, *others = sections_of_drawing(gearbox, drawn, study.count)
    loop = () if study.loop is None else (_loop(study.loop, study, units),)
    return Sheet(
        name=name,
        subject="gearbox",
        counts=f"{said}; {study.count} gearboxes built, seed {study.seed}",
        verdict=verdict_of_drawing(drawn, wound, said, study.count),
        cards=cards_of_drawing(gearbox, drawn, wound, said),
        sections=(geometry, lobes, built, *loop, *others),
        notes=(*notes, *doubts_of_drawing(gearbox, drawn, study.torque or gearbox.rated_torque)),
        words=_WORDS,
        source=f"seed {study.seed}, {study.count} gearboxes built; torque: {said}. The same file, version, torque and seed give the same bytes.",
        seed=study.seed,
        facts={**_facts(name, study, units), "seed": study.seed, "built": study.count, "taken_as_rigid": list(gearbox.rigid)},
    )


def _said(study: GearStudy, units: Units) -> str:
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
    if study.torque is None:
        return (f"no rated {units.what} is stated, so nothing under load is shown: give one with --torque",)
    if study.loop is None and study.torque <= gearbox.friction:
        return (f"{study.torque:.4g} {units.torque} do not overcome the friction: no hysteresis is shown",)
    return ()


def _verdict(study: GearStudy, gearbox: StatedGearbox, units: Units) -> str:
    said = [f"A {gearbox.kind} gearbox by stated figures; what is not stated is taken as none."]
    if study.loop is not None:
        play, lost = (units.of_angle(each, _STATED) for each in (study.loop.play, study.loop.lost_motion))
        said.append(f"Play {play}, lost motion {lost} between ± {study.loop.small:.4g} {units.torque}.")
    if study.wind_up:
        said.append(f"Under {_said(study, units)} the output winds up by {units.of_angle(study.wind_up, _STATED)}.")
    return " ".join(said)


def _cards(study: GearStudy, gearbox: StatedGearbox, units: Units) -> list[Card]:
    ratio = _ratio(gearbox)
    cards = [] if ratio is None else [Card("ratio", str(ratio), "turns of the input per turn of the output")]
    cards.append(Card("play", str(units.of_angle(gearbox.play.nominal, _STATED)), "" if gearbox.play.nominal else "none is stated"))
    if study.loop is not None:
        between = f"between ± {study.loop.small:.4g} {units.torque}"
        cards.append(Card("lost motion", str(units.of_angle(study.loop.lost_motion, _STATED)), between))
    if study.wind_up:
        cards.append(Card("wind-up", str(units.of_angle(study.wind_up, _STATED)), f"at {study.torque:.4g} {units.torque}"))
    return cards


def _ratio(gearbox: AnyGearbox) -> Figure | None:
    """Give the ratio, unless a row of a catalogue leaves it out."""
    stated = gearbox.kind != "catalogue" or "ratio" in gearbox.model_fields_set
    return _pure(gearbox.ratio) if stated else None


def _pure(value: float) -> Figure:
    """Give a pure number, a whole one as such."""
    return Figure(int(value) if float(value).is_integer() else value, "1", samples=_STATED, stated=True)


def _stated(gearbox: StatedGearbox, units: Units) -> Section:
    ratio = _ratio(gearbox)
    opposite = "below zero: input and output go opposite ways" if gearbox.ratio < 0 else ""
    rows = [] if ratio is None else [Row("ratio", (ratio,), opposite)]
    if isinstance(gearbox, WolfromGearbox):
        rows.append(Row("turns of the carrier per turn of the output", (_pure(gearbox.carrier_turns),)))
    if gearbox.rated_torque is not None:
        rows.append(Row(f"rated {units.what}", (units.of_torque(gearbox.rated_torque, _STATED),)))
    play = gearbox.play
    limits = (play.nominal - play.tolerance, play.nominal + play.tolerance) if play.tolerance else (math.nan, math.nan)
    from_lost_motion = "follows from the lost motion" if gearbox.lost_motion is not None else ""
    if play.nominal or gearbox.backlash is not None:
        rows.append(Row("play", (units.of_angle(play.nominal, _STATED, *limits, ends="stated limits"),), from_lost_motion))
    if gearbox.lost_motion is not None:
        note = f"between ± {100 * gearbox.lost_motion_torque:.3g} % of the rated {units.what}"
        rows.append(Row("lost motion", (units.of_angle(gearbox.lost_motion, _STATED),), note))
    if gearbox.hysteresis is not None:
        rows.append(Row("friction's loop, full width", (units.of_angle(gearbox.hysteresis, _STATED),), f"at zero {units.what}, play not in it"))
    if gearbox.friction:
        assumed = "" if gearbox.friction_torque is not None else f"taken as 1 % of the rated {units.what}, none is stated"
        rows.append(Row(f"friction without load, as {units.what}", (units.of_torque(gearbox.friction, _STATED),), assumed))
    if isinstance(gearbox, WormGearbox) and gearbox.locking_reserve is not None:
        note = "friction angle less lead angle: above zero the wheel cannot drive the worm at rest"
        rows.append(Row("locking reserve", (Figure(math.degrees(gearbox.locking_reserve), "deg", samples=_STATED),), note))
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
        Row(f"wind-up at {limit:.4g} {units.torque}", (units.of_angle(float(wind_up(limit, zones, limits)), _STATED),), f"end of zone {k}")
        for k, limit in enumerate(limits, 1)
    ]
    note = f"scatters by ± {100 * gearbox.stiffness_scatter:.3g} % over gearboxes" if gearbox.stiffness_scatter else ""
    return (Section("zones", "Stiffness", ("value",), tuple(rows), note),)


def _loop(loop: Loop, study: GearStudy, units: Units) -> Section:
    drawn = study.drawn
    exact = _STATED if drawn is None else f"the average of {GEARBOXES} gearboxes built, play of {study.count}"
    most = float(loop.torque[-1])
    rows = []
    if study.wind_up:
        rows.append(Row(f"wind-up at {most:.4g} {units.torque}", (units.of_angle(study.wind_up, exact),), "either way, play not counted"))
        rows.append(Row("stiffness up to there", (units.of_stiffness(most / study.wind_up, exact),), f"{units.what} over wind-up"))
    assumed = "" if study.gearbox.friction_torque is not None else f" (taken as 1 % of the rated {units.what})"
    crossed = f"crossed once {loop.rest:.3g} {units.torque} overcome friction{assumed}" if loop.rest else "crossed by any load"
    rows.append(Row("play", (units.of_angle(loop.play, exact),), crossed))
    rows.append(Row("friction's loop alone", (units.of_angle(loop.friction_width, exact),), f"width at zero {units.what}"))
    rows.append(Row(f"whole loop at zero {units.what}", (units.of_angle(loop.width, exact),), "play and friction"))
    note = f"between the middles of the loop at ± {loop.small:.4g} {units.torque}"
    note += "" if study.gearbox.rated_torque is not None else f", for want of a rated {units.what} a share of the one given"
    rows.append(Row("lost motion", (units.of_angle(loop.lost_motion, exact),), note))
    return Section("loop", "Hysteresis", ("value",), tuple(rows), f"output under a {units.what} that goes to and fro, input held")


def _waves(gearbox: StatedGearbox, units: Units) -> tuple[Section, ...]:
    rows = tuple(Row(name, (units.of_angle(size, _STATED), _pure(cycles))) for name, size, cycles in gearbox.waves)
    if not rows:
        return ()
    note = "amplitude is half of peak to peak; each gearbox has its own phase"
    return (Section("transmission", "Transmission error", ("amplitude", f"cycles per {units.limit}"), rows, note),)
