"""The figures that only the drawing of a cycloidal gearbox tells: its geometry, its lobes' loads, gearboxes as built, springs, evenness, friction."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.figures import ARCMIN, ARCSEC, Card, Figure, Row, Section, length
from lostmotion.laws.cycloid import flank, play, pressure_angles, smallest_convex_radius
from lostmotion.laws.cycloid import ratio as ratio_of
from lostmotion.parts.gearbox.cycloidal_behaviour import GEARBOXES, LEVELS, LOST_MOTION
from lostmotion.studies.gearbox.gear_drawn import FOLLOWED, LIGHT
from lostmotion.studies.intervals import robots_quantile, share_interval, student

if TYPE_CHECKING:
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal_stage import CycloidalStage
    from lostmotion.spatial import Floats
    from lostmotion.studies.gearbox.gear_drawn import Drawn

_DRAWING: Final = "the drawing"
_AS_DRAWN: Final = "the stage as drawn, without tolerances"
_LEVELS: Final = ((0.05, "5 % below"), (0.5, "50 % below"), (0.95, "95 % below"))
_MOST_WAVES: Final = 8
# Of the largest wave: smaller ones are not listed.
_SMALLEST_WAVE: Final = 0.01
# Above it the loads, taken without friction, no longer hold.
_RUBS: Final = 0.2
_NEVER_TOUCHING: Final = 1e-12


def sections_of_drawing(gearbox: CycloidalGearbox, drawn: Drawn, count: int) -> list[Section]:
    """Which figures belong to the drawing? Geometry, loads, gearboxes built, springs, transmission error, friction where it is stated."""
    friction = [] if drawn.rubbing is None else [_friction(drawn)]
    return [_geometry(gearbox), _lobes(gearbox, drawn), _built(drawn, count), _members(gearbox, drawn), _transmission(drawn), *friction]


def verdict_of_drawing(drawn: Drawn, wound: float, said: str, count: int) -> str:
    """What is the answer in a few sentences?"""
    free, lost = (float(each.mean()) / ARCMIN for each in (drawn.play, drawn.lost_motion))
    most = float(robots_quantile(drawn.lost_motion)[0]) / ARCMIN
    out = [f"Play {free:.3g}′ and lost motion {lost:.3g}′ on average over {count} gearboxes built; lost motion below {most:.3g}′ in 95 % of them."]
    if drawn.members:
        name, angle = next(iter(drawn.members.items()))
        out.append(f"Under {said} the output winds up by {wound / ARCMIN:.3g}′, {100 * angle / wound:.0f} % of it through the {name}.")
    if drawn.jammed:
        out.append(f"{100 * drawn.jammed / count:.3g} % of the gearboxes jam.")
    return " ".join(out)


def cards_of_drawing(gearbox: CycloidalGearbox, drawn: Drawn, wound: float, said: str) -> tuple[Card, ...]:
    """Which figures are asked for first?"""
    free, lost = (float(robots_quantile(each)[0]) for each in (drawn.play, drawn.lost_motion))
    hardest = drawn.lobes[0]
    span = drawn.transmission.peak_to_peak.mean(axis=1)
    return (
        Card("ratio", f"{gearbox.ratio:g}", "turns of the input per turn of the output"),
        Card("play", str(_mean(drawn.play, "")), f"95 % below {free / ARCMIN:.3g} arcmin"),
        Card("lost motion", str(_mean(drawn.lost_motion, "")), f"at ± {100 * LOST_MOTION:.3g} %; 95 % below {lost / ARCMIN:.3g} arcmin"),
        Card("wind-up", f"{wound / ARCMIN:.3g} arcmin", f"at {said}, play not counted"),
        Card("hardest pressed lobe", f"{hardest.largest_peak / 1e9:.3g} GPa", f"{hardest.largest_force:.4g} N at {said}"),
        Card("transmission error", f"{span[-1] / ARCSEC:.3g} arcsec", f"peak to peak at {said}, mean of {FOLLOWED} gearboxes"),
    )


def doubts_of_drawing(gearbox: CycloidalGearbox, drawn: Drawn, torque: float) -> tuple[str, ...]:
    """What should the reader be warned of?"""
    said = []
    if gearbox.rigid:
        said.append(f"taken as rigid: {gearbox.rigid_said}. The drawing says nothing of them, so the wind-up leaves them out")
    if drawn.jammed:
        said.append("gearboxes that jam have flanks that interfere: no play is counted for them, and their lost motion is that of a preload")
    if drawn.rubbing is not None and drawn.rubbing.friction[-1] > _RUBS * drawn.rubbing.loads[-1]:
        said.append("friction takes more than a fifth of the torque: loads are worked out without it, so efficiency is a rough estimate")
    if torque <= gearbox.friction_at_rest:
        said.append(f"{torque:.4g} N m do not overcome the friction: no hysteresis is shown")
    if torque > LEVELS[-1] * gearbox.rated_torque:
        said.append(f"wind-up is worked out up to {LEVELS[-1]:g} times the rated torque and goes on straight beyond")
    return tuple(said)


def _angle(value: float, samples: str) -> Figure:
    return Figure(value / ARCMIN, "arcmin", samples=samples)


def _fine(value: float, samples: str) -> Figure:
    return Figure(value / ARCSEC, "arcsec", samples=samples)


def _mean(values: Floats, samples: str, unit: str = "arcmin") -> Figure:
    """Give the mean over gearboxes with Student's interval."""
    one = ARCMIN if unit == "arcmin" else ARCSEC
    mean, half = float(values.mean()), student(len(values) - 1) * float(values.std(ddof=1)) / math.sqrt(len(values))
    return Figure(mean / one, unit, (mean - half) / one, (mean + half) / one, samples)


def _geometry(gearbox: CycloidalGearbox) -> Section:
    """Put the stage at the output and a cycloidal stage before it side by side."""
    stages: list[CycloidalStage] = [gearbox]
    if gearbox.first_stage is not None and gearbox.first_stage.kind == "cycloidal":
        stages.insert(0, gearbox.first_stage)
    found = [_stage_rows(stage, ratio_of(stage.stage, gearbox.fixed if stage is gearbox else "ring")) for stage in stages]
    rows = [Row(label, tuple(each[k][1] for each in found), note) for k, (label, _, note) in enumerate(found[0])]
    columns = ("value",) if len(stages) == 1 else ("first stage", "stage at the output")
    whole = f"the whole gearbox: {gearbox.ratio:g} turns of the input per turn of the output" + (", the other way" if gearbox.ratio < 0 else "")
    return Section("geometry", "Geometry", columns, tuple(rows), whole)


def _stage_rows(part: CycloidalStage, steps: int) -> list[tuple[str, Figure, str]]:
    stage, drive = part.stage, part.drive
    wheel = "ring" if stage.twin else "disc"
    ends = np.linalg.norm(flank(stage, np.array([0.0, math.pi / stage.lobes]), drive.made)[0], axis=-1)
    working = np.linspace(0, math.pi, 2001)[1:-1]
    longest = pressure_angles(stage, np.array(math.acos(stage.shortening)))
    sharpest = smallest_convex_radius(stage)
    between = 2 * (stage.ring_radius * math.sin(math.pi / stage.pins) - stage.pin_radius)
    no_convex = "the flank is nowhere convex towards the pins: no pin undercuts it"

    def of_length(value: float) -> Figure:
        found = length(value)
        return Figure(found.value, found.unit, samples=_DRAWING, stated=True)

    def of_angle(value: float) -> Figure:
        return Figure(math.degrees(value), "deg", samples=_DRAWING, stated=True)

    return [
        ("ratio of the stage", Figure(steps, "1", samples=_DRAWING, stated=True), "turns of the crank per turn of its output; negative: opposite"),
        ("K1 = e N/R", Figure(stage.shortening, "1", samples=_DRAWING, stated=True), "at 1 the profile would loop"),
        ("lobes", Figure(stage.lobes, "1", samples=_DRAWING, stated=True), f"of the {wheel}, on {stage.pins} pins or lobes of the other wheel"),
        (f"tip radius of the {wheel}", of_length(float(ends[1])), "with what is ground off"),
        (f"root radius of the {wheel}", of_length(float(ends[0])), "with what is ground off"),
        (
            "smallest convex radius of the flank",
            of_length(sharpest) if math.isfinite(sharpest) else Figure(math.inf, "mm", samples=_DRAWING),
            "so much larger a pin would undercut it" if math.isfinite(sharpest) else no_convex,
        ),
        ("room between neighbouring pins", of_length(between), ""),
        ("smallest pressure angle", of_angle(float(pressure_angles(stage, working).min())), ""),
        ("pressure angle at the longest arm", of_angle(float(longest)), "where cos θ = K1"),
        ("play by the relief alone", _angle(play(stage, drive.made), _DRAWING), "first order, without tolerances and bearing clearances"),
    ]


def _lobes(gearbox: CycloidalGearbox, drawn: Drawn) -> Section:
    """Say what each loaded lobe carries, and the hardest over a pitch of the crank."""
    cases = drawn.lobes
    columns = tuple(name for case in cases for name in (f"load at share {case.share:.3g}" if len(cases) > 1 else "load", "peak pressure"))
    rows = [
        Row("hardest over a pitch of the crank", tuple(figure for case in cases for figure in _pair(case.largest_force, case.largest_peak))),
    ]
    loaded = np.flatnonzero(np.max([case.force for case in cases], axis=0) > _NEVER_TOUCHING)
    for k in sorted(loaded, key=lambda k: cases[0].theta[k]):
        label = f"θ = {math.degrees(cases[0].theta[k]):.1f}°"
        note = f"pressure angle {math.degrees(cases[0].pressure_angle[k]):.1f}°"
        rows.append(Row(label, tuple(figure for case in cases for figure in _pair(float(case.force[k]), float(case.peak[k]))), note))
    said = "; ".join(
        f"share {case.share:.3g}: {case.carrying[0]} to {case.carrying[1]} of {gearbox.pins} carry, {case.bearing:.4g} N on each eccentric bearing"
        for case in cases
    )
    customary = "; a share of 0.5 is what discs alike take, 0.55 the customary allowance" if len(cases) > 1 else ""
    note = (
        f"one of {gearbox.discs} discs, crank at zero, θ from the line of centres"
        if gearbox.discs > 1
        else "crank at zero, θ from the line of centres"
    )
    return Section("lobes", "Load of the lobes", columns, tuple(rows), f"{note}; {said}{customary}")


def _pair(force: float, peak: float) -> tuple[Figure, Figure]:
    return Figure(force, "N", samples=_AS_DRAWN), Figure(peak / 1e9, "GPa", samples=_AS_DRAWN)


def _built(drawn: Drawn, count: int) -> Section:
    counted = f"{count} gearboxes built"
    rows = []
    for name, values in (("play", drawn.play), ("lost motion", drawn.lost_motion)):
        rows.append(Row(f"{name}: mean", (_mean(values, counted),)))
        for level, label in _LEVELS:
            value, low, high = (float(end) / ARCMIN for end in robots_quantile(values, level))
            rows.append(Row(f"{name}: {label}", (Figure(value, "arcmin", low, high, counted),)))
    low, high = (100 * end for end in share_interval(drawn.jammed, count))
    rows.append(Row("gearboxes that jam", (Figure(100 * drawn.jammed / count, "%", low, high, counted),), "flanks interfere all the way round"))
    note = f"lost motion between ± {drawn.small:.4g} N m; each on average over a turn of the crank"
    return Section("built", "Gearboxes as built", ("value",), tuple(rows), note)


def _members(gearbox: CycloidalGearbox, drawn: Drawn) -> Section:
    counted = f"the average of {GEARBOXES} gearboxes built"
    whole = sum(drawn.members.values())
    torque = float(drawn.transmission.loads[-1])
    rows = [
        Row(
            name,
            (
                _angle(angle, counted),
                Figure(100 * angle / whole, "%", samples=counted),
                Figure(torque / angle * ARCMIN, "N m/arcmin", samples=counted),
            ),
        )
        for name, angle in drawn.members.items()
    ]
    if whole:
        stiffness = Figure(torque / whole * ARCMIN, "N m/arcmin", samples=counted)
        rows.append(Row("all together", (_angle(whole, counted), Figure(100.0, "%", samples=counted), stiffness)))
    rigid = f"taken as rigid: {gearbox.rigid_said}" if gearbox.rigid else "nothing is taken as rigid"
    note = f"under {torque:.4g} N m at the output, play not counted; stiffness: torque over wind-up; {rigid}"
    return Section("members", "What gives way", ("wind-up", "share", "stiffness"), tuple(rows), note)


def _transmission(drawn: Drawn) -> Section:
    counted = f"{FOLLOWED} gearboxes built"
    found = drawn.transmission
    rows = [
        Row("peak to peak", tuple(_mean(each, counted, "arcsec") for each in found.peak_to_peak)),
        Row("root mean square", tuple(_fine(float(np.sqrt((each**2).mean())), counted) for each in found.errors[:, :-1])),
    ]
    strongest = np.argsort(-(found.amplitude**2).sum(axis=0), kind="stable")[:_MOST_WAVES]
    rows += [
        Row(f"{found.cycles[k]:g} per turn", tuple(_fine(float(each), counted) for each in found.amplitude[:, k]))
        for k in sorted(strongest)
        if found.amplitude[:, k].max() > _SMALLEST_WAVE * found.amplitude.max()
    ]
    columns = tuple(f"at {load:.4g} N m" for load in found.loads)
    note = (
        f"peak to peak: mean over gearboxes; waves per turn of the output: amplitude, root mean square over gearboxes, the largest {_MOST_WAVES}; "
        f"loads: {100 * LIGHT:.0f} % and all of the torque"
    )
    return Section("transmission", "Transmission error", columns, tuple(rows), note)


def _friction(drawn: Drawn) -> Section:
    rows: list[Row] = []
    if drawn.rubbing is not None:
        for load, friction, share in zip(drawn.rubbing.loads, drawn.rubbing.friction, drawn.rubbing.efficiency, strict=True):
            figures = (Figure(float(friction), "N m", samples=_AS_DRAWN), Figure(100 * float(share), "%", samples=_AS_DRAWN))
            rows.append(Row(f"at {load:.4g} N m", figures))
    note = (
        "an estimate: Coulomb friction of flanks, eccentric and output pins of the stage at the output; seals, grease and a first stage come on top"
    )
    return Section("friction", "Friction", ("felt at the output", "efficiency"), tuple(rows), note)
