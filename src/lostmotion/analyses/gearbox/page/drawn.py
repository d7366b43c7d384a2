"""A cycloidal gearbox by its drawing: headline, cards, notes, manufactured samples, compliance by
member, transmission error.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.gearbox.page.contacts import OVERSTATED, notes_on_friction
from lostmotion.analyses.gearbox.page.loop import is_known, over_samples
from lostmotion.analyses.gearbox.page.stated import TURNING
from lostmotion.error_model.robot_intervals import robots_quantile, root_mean_square_of_samples
from lostmotion.error_model.share_intervals import share_interval
from lostmotion.parts.gearbox.cycloidal.examined import LIGHT
from lostmotion.parts.gearbox.cycloidal.names import BOUNDED
from lostmotion.parts.gearbox.cycloidal.springs import BOUNDS
from lostmotion.parts.gearbox.cycloidal.temperature import note_on_temperature
from lostmotion.printed import digits, stated_text
from lostmotion.reporting.sheet import Card, Cell, table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.analyses.gearbox.page.loop import Bound
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal.examined import ExaminedDrawing, Lobes
    from lostmotion.reporting.sheet import Section
    from lostmotion.spatial import Floats

_LEVELS: Final = ((0.05, "5th percentile"), (0.5, "median"), (0.95, "95th percentile"))
_MOST_HARMONICS: Final = 8
# Of the largest harmonic: smaller ones are not listed.
_SMALLEST_HARMONIC: Final = 0.01


def verdict_of_drawing(
    gearbox: CycloidalGearbox, drawn: ExaminedDrawing, load: str, count: int
) -> str:
    """Return the answer in a few sentences."""
    free, lost, wound = (
        over_samples(each, "arcmin") for each in (drawn.play, drawn.lost_motion, drawn.read.wind_up)
    )
    most = _quantile(drawn.lost_motion, 0.95)
    average = f"Play {free} and lost motion {lost} on average over {count} simulated gearboxes"
    out = [
        f"Play is at least {free} and lost motion at least {lost}: no relief, clearance or "
        "tolerance is described."
        if drawn.without_play
        else f"{average}; 95 % have a lost motion below {most}."
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


def cards_of_drawing(
    gearbox: CycloidalGearbox, drawn: ExaminedDrawing, load: str
) -> Iterator[Card]:
    """Yield the cards of the sheet."""
    read, span = drawn.read, drawn.transmission.peak_to_peak[-1]
    free, lost = (_quantile(each, 0.95) for each in (drawn.play, drawn.lost_motion))

    def mean(values: Floats, unit: str = "arcmin", bound: Bound = "") -> str:
        return str(over_samples(values, unit, "", bound))

    least: Bound = "lower" if drawn.without_play else ""
    wound: Bound = "lower" if gearbox.rigid else ""
    yield Card("ratio", f"{gearbox.ratio:g}", "turns of the input per turn of the output")
    yield Card("play", mean(drawn.play, bound=least), f"mean; 95th percentile {free}")
    yield Card(
        "lost motion",
        mean(drawn.lost_motion, bound=least or wound),
        f"mean at ± {read.asked.small:.3g} N m; 95th percentile {lost}",
    )
    yield Card("wind-up", mean(read.wind_up, bound=wound), f"mean at {load}, beyond the play")
    if is_known(read.stiffness):
        bounded = f"; {_bounded_share(drawn)} of the wind-up only bounded"
        yield Card(
            "stiffness",
            str(over_samples(read.stiffness, "N m/arcmin", "", "upper" if gearbox.rigid else "")),
            TURNING.definition(read.asked) + (bounded if gearbox.bounded else ""),
        )
    yield _peak_card(drawn, drawn.lobes[0], load)
    yield Card(
        "transmission error",
        mean(span, "arcsec", least),
        f"peak to peak at {load}, mean of {len(span)} gearboxes",
    )


def _peak_card(drawn: ExaminedDrawing, hardest: Lobes, load: str) -> Card:
    """Return the card of the peak pressure; of an envelope ring with a rigid disc and ring an upper
    limit, unless it is solved along the flank.
    """
    both, title = drawn.branches, "peak contact pressure"
    if both is not None and both.solved is not None:
        peak = f"{float(both.solved.peak.max()) / 1e9:.3g} GPa"
        return Card(title, peak, f"along the whole flank at {load}")
    alone = both is not None and not both.elastic
    first = (
        f"; by the first branch alone, {OVERSTATED} too large"
        if alone
        else ""
        if both is None
        else ", a share of it on the second branch"
    )
    return Card(
        title,
        str(Cell(hardest.largest_peak, "GPa", bound="upper" if alone else "")),
        f"most heavily loaded lobe, {digits(hardest.largest_force)} N at {load}{first}",
    )


def doubts_of_drawing(
    gearbox: CycloidalGearbox, drawn: ExaminedDrawing, torque: float
) -> Iterator[str]:
    """Yield the warnings of the sheet."""
    yield from note_on_temperature(gearbox)
    if gearbox.bounded:
        low, high = BOUNDS
        yield (
            f"not specified: {gearbox.not_specified}; each is a line of its own, with the "
            f"geometric mean of its bounds: {low:g} to {high:g} times "
            "all computed members; before the eccentric at most 1 % of them at a ratio of 15, "
            "less at larger ones"
        )
    if gearbox.rigid:
        yield (
            f"declared rigid: {', '.join(gearbox.rigid)}; a real gearbox winds up more, so "
            "that every stiffness here is an upper limit"
        )
    if drawn.jammed:
        yield (
            "gearboxes that jam have flanks that interfere without torque; their wind-up is "
            "relative to their position at rest"
        )
    yield from notes_on_friction(drawn, torque)
    if torque <= gearbox.friction_at_rest.load.nominal:
        yield f"{stated_text(torque)} N m do not overcome the friction: no hysteresis is shown"


def _bounded_share(drawn: ExaminedDrawing) -> str:
    """Return the share of the wind-up that is due to bounded members, in whole per cent."""
    bounded = sum(angle for name, angle in drawn.members.items() if name.endswith(BOUNDED))
    share = 100 * bounded / sum(drawn.members.values())
    return f"{share:.0f} %" if share >= 1 else "less than 1 %"


def _quantile(values: Floats, level: float, unit: str = "arcmin") -> Cell:
    value, low, high = (float(end) for end in robots_quantile(values, level))
    return Cell(value, unit, low, high)


def scatter(values: Floats, unit: str, bound: Bound = "") -> dict[str, Cell]:
    """Return mean and percentiles of manufactured samples (sample,), by name."""
    quantiles = {
        label: replace(_quantile(values, level, unit), bound=bound) for level, label in _LEVELS
    }
    return {"mean": over_samples(values, unit, bound=bound), **quantiles}


def samples_section(gearbox: CycloidalGearbox, drawn: ExaminedDrawing, count: int) -> Section:
    """Return the scatter over manufactured samples: mean and percentiles of play, lost motion,
    wind-up and stiffness, and how many jam.
    """
    read = drawn.read
    least: Bound = "lower" if drawn.without_play else ""
    wound: Bound = "lower" if gearbox.rigid else ""
    quantities: list[tuple[str, Floats, str, Bound, str]] = [
        ("play", drawn.play, "arcmin", least, ""),
        ("lost motion", drawn.lost_motion, "arcmin", least or wound, ""),
        (
            "wind-up",
            read.wind_up,
            "arcmin",
            wound,
            f"at {stated_text(read.asked.torque)} N m, beyond the play",
        ),
    ]
    if is_known(read.stiffness):
        definition = TURNING.definition(read.asked)
        most: Bound = "upper" if gearbox.rigid else ""
        quantities.append(("stiffness", read.stiffness, "N m/arcmin", most, definition))
    rows = [
        (f"{name}: {label}", figure, note if label == "mean" else "")
        for name, values, unit, bound, note in quantities
        for label, figure in scatter(values, unit, bound).items()
    ]
    rows.append(
        (
            "gearboxes that jam",
            Cell(drawn.jammed / count, "%", *share_interval(drawn.jammed, count)),
            "flanks interfere over the whole circumference, by more than the clearances",
        )
    )
    note = (
        f"lost motion between ± {read.asked.small:.4g} N m; each sample on average over a turn of "
        "the crank"
    )
    counted = f"{count} simulated gearboxes"
    return table("built", "Manufactured samples", ["value"], rows, note, samples=counted)


def members_section(gearbox: CycloidalGearbox, drawn: ExaminedDrawing, count: int) -> Section:
    """Return the wind-up through each member."""
    whole, wound = sum(drawn.members.values()), drawn.read.wind_up
    torque = float(drawn.transmission.loads[-1])
    rows = [
        (
            name,
            angle,
            angle / whole,
            torque / angle,
            str(gearbox.states.get(name.removesuffix(BOUNDED), "")),
        )
        for name, angle in drawn.members.items()
    ]
    if whole:
        rows.append(("all together", float(wound.mean()), 1.0, float((torque / wound).mean()), ""))
    others = [
        f"; {words}: {', '.join(names)}"
        for kind, words in (("ideal", "declared rigid"), ("absent", "absent"))
        if (names := [name for name, state in gearbox.states.items() if state.kind == kind])
    ]
    return table(
        "members",
        "Compliance by member",
        {"wind-up": "arcmin", "share": "%", "stiffness": "N m/arcmin"},
        rows,
        f"under {stated_text(torque)} N m at the output, beyond the play; stiffness: "
        f"torque over wind-up{''.join(others)}",
        samples=f"mean of {count} simulated gearboxes",
    )


def transmission_section(drawn: ExaminedDrawing) -> Section:
    """Return the transmission error: peak to peak, root mean square, largest harmonics."""
    error = drawn.transmission
    least: Bound = "lower" if drawn.without_play else ""

    def rms(squares: Floats) -> list[Cell]:
        means = map(root_mean_square_of_samples, squares)
        return [Cell(each.value, "arcsec", each.low, each.high, bound=least) for each in means]

    strongest = np.argsort(-(error.amplitude**2).sum(axis=0), kind="stable")[:_MOST_HARMONICS]
    rows = [
        (
            "peak to peak",
            *(over_samples(each, "arcsec", bound=least) for each in error.peak_to_peak),
        ),
        ("root mean square", *rms(error.mean_square)),
        *(
            (f"{error.cycles[k]:g} per turn", *rms(error.power[:, k]))
            for k in sorted(strongest)
            if error.amplitude[:, k].max() > _SMALLEST_HARMONIC * error.amplitude.max()
        ),
    ]
    return table(
        "transmission",
        "Transmission error",
        [f"at {stated_text(load)} N m" for load in error.loads],
        rows,
        "peak to peak: mean over gearboxes; per turn of the output: root mean square "
        f"amplitude of each of the {_MOST_HARMONICS} largest harmonics; "
        f"loads: {100 * LIGHT:.0f} % and all of the torque",
        samples=f"{error.errors.shape[-1]} simulated gearboxes",
    )
