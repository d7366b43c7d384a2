"""Figures of a cycloidal gearbox by its drawing: geometry, lobe loads, manufactured samples,
compliance by member, transmission error, friction.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from lostmotion.analyses.gearbox.tables.definition import definition_text
from lostmotion.analyses.gearbox.tables.envelope import OVERSTATED, branches_sections
from lostmotion.analyses.gearbox.tables.friction import (
    AS_DRAWN,
    friction_sections,
    notes_on_friction,
)
from lostmotion.analyses.gearbox.tables.units import TURNING
from lostmotion.error_model.intervals import robots_quantile, root_mean_square_of_samples, student
from lostmotion.error_model.share_intervals import share_interval
from lostmotion.laws.cycloid.geometry import (
    flank,
    play,
    pressure_angles,
    smallest_convex_radius,
    valley_radius,
)
from lostmotion.laws.cycloid.geometry import ratio as ratio_of
from lostmotion.parts.gearbox.cycloidal.examined import LIGHT
from lostmotion.parts.gearbox.cycloidal.names import BOUNDED
from lostmotion.parts.gearbox.cycloidal.springs import BOUNDS
from lostmotion.parts.gearbox.cycloidal.temperature import note_on_temperature
from lostmotion.printed import digits, stated_text
from lostmotion.reporting.sheet import Card, Cell, Row, Section, length

if TYPE_CHECKING:
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal.examined import Drawn, Lobes
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.spatial import Floats

Bound: TypeAlias = Literal["", "upper", "lower"]
_DRAWING: Final = "the drawing"
_LEVELS: Final = ((0.05, "5th percentile"), (0.5, "median"), (0.95, "95th percentile"))
_MOST_HARMONICS: Final = 8
# Of the largest harmonic: smaller ones are not listed.
_SMALLEST_HARMONIC: Final = 0.01
_NEVER_TOUCHING: Final = 1e-12


def sections_of_drawing(gearbox: CycloidalGearbox, drawn: Drawn, count: int) -> list[Section]:
    """Return the sections of the drawing: geometry, loads, manufactured samples, compliance,
    transmission error, friction where it is stated.
    """
    first = gearbox.first_stage
    both = branches_sections(
        gearbox, first if first is not None and first.kind == "cycloidal" else None, drawn
    )
    lobes = _lobes(gearbox, drawn)
    return [
        _geometry(gearbox),
        lobes,
        samples_section(drawn, count),
        _members(gearbox, drawn, count),
        _transmission(drawn),
        *friction_sections(drawn),
        *both,
    ]


def verdict_of_drawing(gearbox: CycloidalGearbox, drawn: Drawn, load: str, count: int) -> str:
    """Return the answer in a few sentences."""
    free, lost, wound = (
        _mean(each, "") for each in (drawn.play, drawn.lost_motion, drawn.read.wind_up)
    )
    most = _quantile(drawn.lost_motion, 0.95, "")
    out = [
        (
            f"Play {free} and lost motion {lost} on average over {count} simulated gearboxes; 95 % "
            f"have a lost motion below {most}."
        )
    ]
    if drawn.members:
        name, angle = next(iter(drawn.members.items()))
        share = 100 * angle / float(drawn.read.wind_up.mean())
        out.append(
            f"Under {load} the output winds up by {wound} beyond its play, {share:.0f} % of it "
            f"through the {name}."
        )
    if gearbox.bounded:
        out.append(
            f"Not specified and only bounded, {_bounded_share(drawn)} of it: "
            f"{gearbox.not_specified}."
        )
    if gearbox.rigid:
        out.append(f"At most this stiff: declared rigid are {', '.join(gearbox.rigid)}.")
    if drawn.jammed:
        out.append(f"{100 * drawn.jammed / count:.3g} % of the gearboxes jam.")
    return " ".join(out)


def cards_of_drawing(gearbox: CycloidalGearbox, drawn: Drawn, load: str) -> tuple[Card, ...]:
    """Return the cards of the sheet."""
    read, hardest = drawn.read, drawn.lobes[0]
    free, lost = (_quantile(each, 0.95, "") for each in (drawn.play, drawn.lost_motion))
    span = drawn.transmission.peak_to_peak[-1]
    bounded = f"; {_bounded_share(drawn)} of the wind-up only bounded" if gearbox.bounded else ""
    cards = [
        Card("ratio", f"{gearbox.ratio:g}", "turns of the input per turn of the output"),
        Card("play", str(_mean(drawn.play, "")), f"mean; 95th percentile {free}"),
        Card(
            "lost motion",
            str(_mean(drawn.lost_motion, "")),
            f"mean at ± {read.asked.small:.3g} N m; 95th percentile {lost}",
        ),
        Card("wind-up", str(_mean(read.wind_up, "")), f"mean at {load}, beyond the play"),
        _peak_card(drawn, hardest, load),
        Card(
            "transmission error",
            str(_mean(span, "", "arcsec")),
            f"peak to peak at {load}, mean of {len(span)} gearboxes",
        ),
    ]
    if read.stiffness is not None and np.isfinite(read.stiffness).all():
        stiff = _stiffness(read.stiffness, "", "upper" if gearbox.rigid else "")
        cards.insert(
            4, Card("stiffness", str(stiff), f"{definition_text(read.asked, TURNING)}{bounded}")
        )
    return tuple(cards)


def _peak_card(drawn: Drawn, hardest: Lobes, load: str) -> Card:
    """Return the card of the peak pressure; of an envelope ring with a rigid disc and ring an upper
    limit, unless it is solved along the flank.
    """
    both = drawn.branches
    if both is not None and both.solved is not None:
        return Card(
            "peak contact pressure",
            f"{float(both.solved.peak.max()) / 1e9:.3g} GPa",
            f"along the whole flank at {load}",
        )
    alone = both is not None and not both.elastic
    found = Cell(hardest.largest_peak, "GPa", bound="upper" if alone else "")
    first = (
        f"; by the first branch alone, {OVERSTATED} too large"
        if alone
        else ""
        if both is None
        else ", a share of it on the second branch"
    )
    return Card(
        "peak contact pressure",
        str(found),
        f"most heavily loaded lobe, {digits(hardest.largest_force)} N at {load}{first}",
    )


def doubts_of_drawing(gearbox: CycloidalGearbox, drawn: Drawn, torque: float) -> tuple[str, ...]:
    """Return the warnings of the sheet."""
    notes = [*note_on_temperature(gearbox)]
    if gearbox.bounded:
        low, high = BOUNDS
        notes.append(
            f"not specified: {gearbox.not_specified}; each is a line of its own, with the "
            f"geometric mean of its bounds: {low:g} to {high:g} times "
            "all computed members; before the eccentric at most 1 % of them at a ratio of 15, "
            "less at larger ones"
        )
    if gearbox.rigid:
        notes.append(
            f"declared rigid: {', '.join(gearbox.rigid)}; a real gearbox winds up more, so "
            "that every stiffness here is an upper limit"
        )
    if drawn.jammed:
        notes.append(
            "gearboxes that jam have flanks that interfere without torque; their wind-up is "
            "relative to their position at rest"
        )
    notes += notes_on_friction(drawn, torque)
    if torque <= gearbox.friction_at_rest.load.nominal:
        notes.append(
            f"{stated_text(torque)} N m do not overcome the friction: no hysteresis is shown"
        )
    return tuple(notes)


def _bounded_share(drawn: Drawn) -> str:
    """Return the share of the wind-up that is due to bounded members, in whole per cent."""
    bounded = sum(angle for name, angle in drawn.members.items() if name.endswith(BOUNDED))
    share = 100 * bounded / sum(drawn.members.values())
    return f"{share:.0f} %" if share >= 1 else "less than 1 %"


def _angle(value: float, samples: str) -> Cell:
    return Cell(value, "arcmin", samples=samples)


def _rms(squares: Floats, samples: str) -> Cell:
    """Return the root of the mean of squares (sample,), rad^2, with its interval."""
    found = root_mean_square_of_samples(squares)
    return Cell(found.value, "arcsec", found.low, found.high, samples)


def over_samples(values: Floats, unit: str, samples: str, bound: Bound = "") -> Cell:
    """Return the mean over independent samples (sample,) of a size, none below zero, with Student's
    interval, shown in `unit`.
    """
    mean, half = (
        float(values.mean()),
        student(len(values) - 1) * float(values.std(ddof=1)) / math.sqrt(len(values)),
    )
    return Cell(mean, unit, max(mean - half, 0.0), mean + half, samples, bound=bound)


def _mean(values: Floats, samples: str, unit: str = "arcmin") -> Cell:
    return over_samples(values, unit, samples)


def _stiffness(values: Floats, samples: str, bound: Bound = "") -> Cell:
    return over_samples(values, "N m/arcmin", samples, bound)


def _quantile(values: Floats, level: float, samples: str, unit: str = "arcmin") -> Cell:
    value, low, high = (float(end) for end in robots_quantile(values, level))
    return Cell(value, unit, low, high, samples)


def _geometry(gearbox: CycloidalGearbox) -> Section:
    """Return the geometry of the output stage, beside that of a cycloidal first stage."""
    stages: list[CycloidalStage] = [gearbox]
    if gearbox.first_stage is not None and gearbox.first_stage.kind == "cycloidal":
        stages.insert(0, gearbox.first_stage)
    found = [
        _stage_rows(stage, ratio_of(stage.stage, gearbox.fixed if stage is gearbox else "ring"))
        for stage in stages
    ]
    rows = [
        Row(label, tuple(each[k][1] for each in found), note)
        for k, (label, _, note) in enumerate(found[0])
    ]
    columns = ("value",) if len(stages) == 1 else ("first stage", "stage at the output")
    whole = f"the whole gearbox: {gearbox.ratio:g} turns of the input per turn of the output" + (
        ", the other way" if gearbox.ratio < 0 else ""
    )
    return Section("geometry", "Geometry", columns, tuple(rows), whole)


def _stage_rows(part: CycloidalStage, steps: int) -> list[tuple[str, Cell, str]]:
    stage, drive = part.stage, part.drive
    wheel = "ring" if stage.has_planet_pins else "disc"
    ends = np.linalg.norm(
        flank(stage, np.array([0.0, math.pi / stage.lobes]), drive.relief)[0], axis=-1
    )
    working = np.linspace(0, math.pi, 2001)[1:-1]
    longest = pressure_angles(stage, np.array(math.acos(stage.shortening)))
    sharpest = smallest_convex_radius(stage)
    valley = valley_radius(stage) + stage.pin_radius
    between = 2 * (stage.ring_radius * math.sin(math.pi / stage.pins) - stage.pin_radius)
    no_convex = "the flank is nowhere convex: no pin size undercuts it"

    def of_length(value: float) -> Cell:
        found = length(value)
        return Cell(value, found.shown, samples=_DRAWING, stated=True)

    def of_angle(value: float) -> Cell:
        return Cell(value, "°", samples=_DRAWING, stated=True)

    return [
        (
            "ratio of the stage",
            Cell(steps, "1", samples=_DRAWING, stated=True),
            "turns of the crank per turn of its output; negative: opposite",
        ),
        (
            "K1 = e N/R",
            Cell(stage.shortening, "1", samples=_DRAWING, stated=True),
            "at 1 the profile would loop",
        ),
        (
            "lobes",
            Cell(stage.lobes, "1", samples=_DRAWING, stated=True),
            f"of the {wheel}, on {stage.pins} pins or lobes of the other wheel",
        ),
        (f"tip radius of the {wheel}", of_length(float(ends[1])), "with what is ground off"),
        (f"root radius of the {wheel}", of_length(float(ends[0])), "with what is ground off"),
        (
            "smallest convex radius of the flank",
            of_length(sharpest)
            if math.isfinite(sharpest)
            else Cell(math.inf, "mm", samples=_DRAWING),
            "increase of the pin radius at which undercutting begins"
            if math.isfinite(sharpest)
            else no_convex,
        ),
        (
            "radius of the flank's valley",
            of_length(valley) if math.isfinite(valley) else Cell(math.inf, "mm", samples=_DRAWING),
            "a cutter that mills the profile must be smaller, before relief"
            if math.isfinite(valley)
            else "the flank is nowhere concave",
        ),
        ("room between neighbouring pins", of_length(between), ""),
        ("smallest pressure angle", of_angle(float(pressure_angles(stage, working).min())), ""),
        ("pressure angle at the longest arm", of_angle(float(longest)), "where cos θ = K1"),
        (
            "play by the relief alone",
            _angle(play(stage, drive.relief), _DRAWING),
            "first order, without tolerances and clearances; negative: flanks interfere",
        ),
    ]


def _lobes(gearbox: CycloidalGearbox, drawn: Drawn) -> Section:
    """Return the load of each loaded lobe, and the largest over a pitch of the crank."""
    cases = drawn.lobes
    columns = tuple(
        name
        for case in cases
        for name in (
            f"load at share {case.share:.3g}" if len(cases) > 1 else "load",
            "peak pressure",
        )
    )
    rows = [
        Row(
            "most heavily loaded lobe, over a pitch of the crank",
            tuple(
                figure for case in cases for figure in _pair(case.largest_force, case.largest_peak)
            ),
            key="hardest_over_a_pitch_of_the_crank",
        ),
    ]
    loaded = np.flatnonzero(np.max([case.force for case in cases], axis=0) > _NEVER_TOUCHING)
    for k in sorted(loaded, key=lambda k: cases[0].theta[k]):
        label = f"θ = {math.degrees(cases[0].theta[k]):.1f}°"
        note = f"pressure angle {math.degrees(cases[0].pressure_angle[k]):.1f}°"
        rows.append(
            Row(
                label,
                tuple(
                    figure
                    for case in cases
                    for figure in _pair(float(case.force[k]), float(case.peak[k]))
                ),
                note,
            )
        )
    cases_text = "; ".join(
        (
            f"share {case.share:.3g}: {_carrying(case)} of {gearbox.pins} lobes carry load, "
            f"{digits(case.bearing)} N on each eccentric bearing"
        )
        for case in cases
    )
    alone = (
        ""
        if drawn.branches is None
        else "; loads and pressures are those of the first branch alone"
    )
    if drawn.branches is not None and drawn.branches.elastic:
        alone = (
            "; a load includes the lobe's share of the second branch, a pressure is that of the "
            "first branch"
        )
    customary = (
        "; equal discs take a share of 0.5, 0.55 the customary allowance" if len(cases) > 1 else ""
    )
    note = (
        f"one of {gearbox.discs} discs, crank at zero, θ from the line of centres"
        if gearbox.discs > 1
        else "crank at zero, θ from the line of centres"
    )
    return Section(
        "lobes",
        "Load of the lobes",
        columns,
        tuple(rows),
        f"{note}; {cases_text}{customary}{alone}",
    )


def _carrying(case: Lobes) -> str:
    """Return how many lobes carry load over a pitch of the crank."""
    fewest, most = case.carrying
    return f"{fewest}" if fewest == most else f"{fewest} to {most}"


def _pair(force: float, peak: float) -> tuple[Cell, Cell]:
    return Cell(force, "N", samples=AS_DRAWN), Cell(peak, "GPa", samples=AS_DRAWN)


def samples_section(drawn: Drawn, count: int) -> Section:
    """Return the scatter over manufactured samples: mean and percentiles of play, lost motion,
    wind-up and stiffness, and how many jam.
    """
    counted, read = f"{count} simulated gearboxes", drawn.read
    quantities = [
        ("play", drawn.play, "arcmin", ""),
        ("lost motion", drawn.lost_motion, "arcmin", ""),
    ]
    quantities.append(
        (
            "wind-up",
            read.wind_up,
            "arcmin",
            f"at {stated_text(read.asked.torque)} N m, beyond the play",
        )
    )
    if read.stiffness is not None and np.isfinite(read.stiffness).all():
        quantities.append(
            (
                "stiffness",
                read.stiffness,
                "N m/arcmin",
                definition_text(read.asked, TURNING),
            )
        )
    rows = []
    for name, values, unit, note in quantities:
        rows.append(Row(f"{name}: mean", (over_samples(values, unit, counted),), note))
        rows += [
            Row(f"{name}: {label}", (_quantile(values, level, counted, unit),))
            for level, label in _LEVELS
        ]
    low, high = share_interval(drawn.jammed, count)
    rows.append(
        Row(
            "gearboxes that jam",
            (Cell(drawn.jammed / count, "%", low, high, counted),),
            "flanks interfere over the whole circumference, by more than the clearances",
        )
    )
    note = (
        f"lost motion between ± {read.asked.small:.4g} N m; each sample on average over a turn of "
        "the crank"
    )
    return Section("built", "Manufactured samples", ("value",), tuple(rows), note)


def _members(gearbox: CycloidalGearbox, drawn: Drawn, count: int) -> Section:
    counted = f"mean of {count} simulated gearboxes"
    whole = sum(drawn.members.values())
    torque = float(drawn.transmission.loads[-1])
    rows = [
        Row(
            name,
            (
                _angle(angle, counted),
                Cell(angle / whole, "%", samples=counted),
                Cell(torque / angle, "N m/arcmin", samples=counted),
            ),
            str(gearbox.states.get(name.removesuffix(BOUNDED), "")),
        )
        for name, angle in drawn.members.items()
    ]
    if whole:
        mean = float((torque / drawn.read.wind_up).mean())
        together = (
            _angle(float(drawn.read.wind_up.mean()), counted),
            Cell(1.0, "%", samples=counted),
            Cell(mean, "N m/arcmin", samples=counted),
        )
        rows.append(Row("all together", together))
    kinds = {"ideal": "declared rigid", "absent": "absent"}
    others = [
        f"{words}: {', '.join(each)}"
        for kind, words in kinds.items()
        if (each := _of_kind(gearbox, kind))
    ]
    note = "; ".join(
        [
            (
                f"under {stated_text(torque)} N m at the output, beyond the play; stiffness: "
                "torque over wind-up"
            ),
            *others,
        ]
    )
    return Section(
        "members", "Compliance by member", ("wind-up", "share", "stiffness"), tuple(rows), note
    )


def _of_kind(gearbox: CycloidalGearbox, kind: str) -> list[str]:
    return [name for name, state in gearbox.states.items() if state.kind == kind]


def _transmission(drawn: Drawn) -> Section:
    found = drawn.transmission
    counted = f"{found.errors.shape[-1]} simulated gearboxes"
    rows = [
        Row("peak to peak", tuple(_mean(each, counted, "arcsec") for each in found.peak_to_peak)),
        Row("root mean square", tuple(_rms(each, counted) for each in found.mean_square)),
    ]
    strongest = np.argsort(-(found.amplitude**2).sum(axis=0), kind="stable")[:_MOST_HARMONICS]
    rows += [
        Row(
            f"{found.cycles[k]:g} per turn",
            tuple(_rms(each, counted) for each in found.power[:, k]),
        )
        for k in sorted(strongest)
        if found.amplitude[:, k].max() > _SMALLEST_HARMONIC * found.amplitude.max()
    ]
    columns = tuple(f"at {stated_text(load)} N m" for load in found.loads)
    note = (
        "peak to peak: mean over gearboxes; per turn of the output: root mean square "
        f"amplitude of each of the {_MOST_HARMONICS} largest harmonics; "
        f"loads: {100 * LIGHT:.0f} % and all of the torque"
    )
    return Section("transmission", "Transmission error", columns, tuple(rows), note)
