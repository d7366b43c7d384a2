"""The figures of an arm whose parts were chosen for a target on the tool: which, what they buy, what other targets would cost."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.reporting.not_counted import NOT_COUNTED, without_mass
from lostmotion.reporting.provenance import at_least, caveats, provenance_facts, provenance_sections
from lostmotion.reporting.sheet import Card, Figure, Row, Section, Sheet, length
from lostmotion.reporting.warnings import arm_warnings

if TYPE_CHECKING:
    from lostmotion.analyses.sizing.candidates import Candidate
    from lostmotion.analyses.sizing.target_study import Aimed, Bought
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.provenance import States

_MOST_HALVED: Final = 10
_WORDS: Final = (
    ("95 % error", "what 95 % of all position errors of the tool stay below, over the poses of the workspace, the robots built and their visits."),
    ("full study", "the same as lostmotion run makes with its own counts; the smaller study takes fewer poses, robots and visits."),
    ("put back", "this one part made in the cheapest way offered, all others as chosen."),
    ("price", "by the sizing file, in its currency."),
    ("looked at", "allocations whose loads and errors were worked out part by part; nothing is fitted."),
)


def aimed_sheet(found: Aimed, notes: tuple[str, ...] = ()) -> Sheet:
    """What is there to say about an arm whose parts were chosen for a target?"""
    counted = f"{len(found.poses)} poses x {found.counts.robots} robots x {found.counts.visits} visits, seed {found.counts.seed}"
    known = with_limits(states(found.sized), found.sized, found.poses.q)
    small = "{} poses x {} robots x {} visits".format(*found.small) + f", seed {found.counts.seed}"
    return Sheet(
        name=found.arm.name,
        subject="parts for a target on the tool",
        verdict=" ".join([_verdict(found, known), *caveats(known)]),
        cards=tuple(_cards(found)),
        sections=(*(section for section in _sections(found, counted, small) if section.rows), *provenance_sections(known)),
        counts=f"search at {found.searched} poses; full study: {counted}",
        warnings=arm_warnings(found.sized),
        notes=(not_counted(found), *found.arm.remarks, *_remarks(found), *notes),
        words=_WORDS,
        source=f"{counted}. The same files, version and seed give the same bytes.",
        seed=found.counts.seed,
        facts={**_facts(found), "not_counted": not_counted(found), **provenance_facts(known)},
    )


def _sections(found: Aimed, counted: str, small: str) -> tuple[Section, ...]:
    return (
        _parts(found),
        _result(found, counted),
        _buys(found, small),
        _trade(found, small),
        _halving(found),
        _torques(found),
        _searched(found),
    )


def _estimate(estimate: Estimate, samples: str = "") -> Figure:
    return length(estimate.value, estimate.low, estimate.high, samples)


def _kg(value: float) -> Figure:
    return Figure(value, "kg")


def _price(value: float) -> Figure:
    return Figure(value, "1", stated=True)


def priced(found: Aimed) -> bool:
    """Tell whether prices count."""
    return found.worth.price > 0


def small_said(found: Aimed) -> str:
    """Say what is to be small."""
    parts = []
    for factor, name in ((found.worth.price, "price"), (found.worth.mass, "mass")):
        if factor:
            parts.append(name if factor == 1 else f"{factor:g} * {name}")
    return " + ".join(parts)


def name_of(each: Bought, candidate: Candidate) -> str:
    """Name a candidate; the present one by what it is."""
    return f"{each.slot.present.name}, as it is" if candidate.part is None else candidate.name


def _verdict(found: Aimed, known: States) -> str:
    target, error = length(found.target, stated=True), at_least(_estimate(found.error), known)
    if not found.holds:
        text = f"No allocation was found whose 95 % error is within {target}: the nearest has {error} ({_interval(found.error)})."
        gain = max(found.halving.gains.items(), key=lambda pair: pair[1].value, default=None)
        if not found.allowed:
            text = "With these candidates no allocation is allowed: a reducer is rated below what its joint holds, or a link bends beyond its limits."
        elif gain is not None:
            text += f" Most binds {gain[0]}: halving its errors would take {_estimate(gain[1])} off the 95 % error."
        return text
    text = f"95 % of all errors stay below {error} ({_interval(found.error)}), within the target of {target}; as stated it is"
    text += f" {_estimate(found.error_before)}."
    text += f" The chosen parts come to {_kg(found.mass)}, now {_kg(found.mass_before)}"
    if priced(found):
        text += f", and to a price of {_price(found.price)}" + (f", now {_price(found.price_before)}" if math.isfinite(found.price_before) else "")
    text += ". All cheaper allocations miss the target." if found.proven else ". No exchange of one or two parts was found cheaper."
    return text


def _interval(estimate: Estimate) -> str:
    return f"95 % interval {_estimate(estimate).between}"


def _cards(found: Aimed) -> list[Card]:
    cards = [
        Card("95 % error", str(_estimate(found.error)), f"target {length(found.target, stated=True)}" + ("" if found.holds else ", not reached")),
        Card("as stated", str(_estimate(found.error_before)), "95 % error"),
        Card("chosen parts", str(_kg(found.mass)), f"now {_kg(found.mass_before)}"),
    ]
    if priced(found):
        now = f"now {_price(found.price_before)}" if math.isfinite(found.price_before) else "now not known"
        cards.append(Card("price", str(_price(found.price)), now))
    return cards


def _parts(found: Aimed) -> Section:
    rows = []
    for each in found.bought:
        figures = [_kg(each.slot.present.mass), _kg(each.chosen.mass)]
        if priced(found):
            figures += [_price(each.slot.present.price), _price(each.chosen.price)]
        note = f"{each.slot.present.name} -> {each.chosen.name}" if each.chosen.part is not None else f"{each.slot.present.name}, as it is"
        rows.append(Row(each.slot.label, tuple(figures), note))
    figures = [_kg(found.mass_before), _kg(found.mass)]
    if priced(found):
        figures += [_price(found.price_before), _price(found.price)]
    rows.append(Row("all of them", tuple(figures)))
    columns = ("mass now", "mass", *(("price now", "price") if priced(found) else ()))
    return Section("parts", "Parts chosen", columns, tuple(rows), f"as small as can be: {small_said(found)}; masses in kg, of the chosen parts alone")


def _result(found: Aimed, counted: str) -> Section:
    rows = (
        Row("target", (length(found.target, stated=True),), "for the upper end of the interval"),
        Row("as stated", (_estimate(found.error_before, counted),), "full study"),
        Row("parts chosen", (_estimate(found.error, counted),), "full study; within the target" if found.holds else "full study; target not reached"),
    )
    return Section("error", "95 % error of the tool", ("value",), rows, f"over the workspace; {counted}")


def _buys(found: Aimed, small: str) -> Section:
    rows = []
    for each in found.bought:
        if each.without is not None:
            figures = Figure(each.saved, "kg" if small_said(found) == "mass" else "1"), _estimate(each.without, small)
            rows.append((each.without.value, Row(each.slot.label, figures, f"{name_of(each, each.chosen)}, not {name_of(each, each.cheapest)}")))
    note = f"put back one by one to the cheapest way offered: what that saves ({small_said(found)}), and the 95 % error it leaves"
    ordered = tuple(row for _, row in sorted(rows, key=lambda pair: -pair[0]))
    return Section("buys", "What each choice buys", ("saved", "95 % error without it"), ordered, note)


def _trade(found: Aimed, small: str) -> Section:
    rows = []
    both = priced(found) and found.worth.mass > 0
    for point in found.trade:
        cost = [_price(point.cost)] if both else []
        figures = [*cost, _kg(point.mass), *([_price(point.price)] if priced(found) else []), _estimate(point.error, small)]
        note = "" if point.holds else "cannot be reached"
        if point.target == found.target:
            note = "asked for"
        elif not found.holds and point.target == found.error.high:
            note = "the nearest"
        rows.append(Row(str(length(point.target, stated=True)), tuple(figures), note))
    columns = (*(("cost",) if both else ()), "mass", *(("price",) if priced(found) else ()), "95 % error")
    note = "" if found.holds else "around what was reached; "
    note += f"cost: {small_said(found)}; " if both else ""
    return Section("trade", "Cost against target", columns, tuple(rows), f"{note}other targets by exchange of single parts")


def _halving(found: Aimed) -> Section:
    gains = sorted(found.halving.gains.items(), key=lambda pair: -pair[1].value)[:_MOST_HALVED]
    counted = f"{found.halving.samples} paired samples"
    rows = tuple(Row(name, (_estimate(gain, counted),)) for name, gain in gains)
    return Section("halving", "What binds now", ("halving it takes off the 95 %",), rows, "of the arm with the parts chosen, the largest first")


def _torques(found: Aimed) -> Section:
    rows = []
    for each in found.bought:
        rated = getattr(_gearbox(found, each), "rated_torque", None)
        if each.slot.what == "gearbox":
            held = found.torques[each.slot.joint]
            share = Figure(100 * held / rated if rated else math.nan, "%")
            rows.append(
                Row(
                    each.slot.joint,
                    (Figure(held, "N m"), Figure(math.nan if rated is None else rated, "N m", stated=True), share),
                    name_of(each, each.chosen),
                )
            )
    leaning = "as the base stands" if found.rules.tilt is None else f"base tilted up to {math.degrees(found.rules.tilt):.3g}°"
    note = f"at worst over the poses of the search and the corners of the joints' ranges, {leaning}, with the weights chosen"
    return Section("torques", "Torque at the gearboxes chosen", ("held at worst", "rated", "of it"), tuple(rows), note)


def _searched(found: Aimed) -> Section:
    sure = "all cheaper allocations were looked at" if found.proven else "no exchange of one or two parts was found cheaper"
    sure = sure if found.holds else "none reaches the target; the nearest is told"
    rows = (
        Row("allocations possible", (Figure(float(found.allocations), "1") if found.allocations > 10**9 else Figure(found.allocations, "1"),)),
        Row("looked at", (Figure(found.looked_at, "1"),), sure),
        Row("pairs foreseen", (Figure(found.foreseen, "1"),), "their error foreseen from both exchanges one by one"),
        *(
            Row(f"inner target {k}", (length(inner),), "given to the search, so that the full study's upper end meets the target")
            for k, inner in enumerate(found.inner, 1)
        ),
    )
    return Section("search", "The search", ("value",), rows, f"at {found.searched} poses, mean and covariance of the error summed exactly over parts")


def _remarks(found: Aimed) -> list[str]:
    out = [each.chosen.note for each in found.bought if each.chosen.note]
    silent = [
        each.slot.joint for each in found.bought if each.slot.what == "gearbox" and getattr(_gearbox(found, each), "rated_torque", None) is None
    ]
    if silent:
        out.append(f"of the gearboxes chosen for {', '.join(silent)} no rated torque is stated: whether they hold their load is not checked")
    largest = [
        each.slot.joint
        for each in found.bought
        if each.slot.what == "link" and len(each.slot.candidates) > 1 and each.chosen.mass >= max(one.mass for one in each.slot.candidates)
    ]
    if largest:
        out.append(f"the heaviest section allowed was chosen for {', '.join(largest)}: a wider family might come cheaper")
    return list(dict.fromkeys(out))


def _gearbox(found: Aimed, each: Bought) -> Any:  # noqa: ANN401 - any kind of gearbox
    return next(getattr(joint, "gearbox", None) for joint in found.sized.joints if joint.name == each.slot.joint)


def _facts(found: Aimed) -> dict[str, Any]:
    def known(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return {
        "arm": found.arm.name,
        "target_m": found.target,
        "holds": found.holds,
        "minimise": {"per_kg": found.worth.mass, "per_price": found.worth.price},
        "error_95_m": [found.error.value, known(found.error.low), known(found.error.high)],
        "error_95_before_m": [found.error_before.value, known(found.error_before.low), known(found.error_before.high)],
        "proven": found.proven,
        "parts": [
            {
                "joint": each.slot.joint,
                "part": each.slot.what,
                "chosen": each.chosen.name,
                "before": each.slot.present.name,
                "mass_kg": known(each.chosen.mass),
                "price": known(each.chosen.price),
            }
            for each in found.bought
        ],
    }


def not_counted(found: Aimed) -> str:
    """Return what a choice of parts for a target does not count."""
    kinds = {each.slot.what for each in found.bought}
    chosen = [name for name, kind in (("links", "link"), ("gearboxes", "gearbox"), ("bearing clearances", "bearing")) if kind in kinds]
    prices = "" if found.worth.price else ", prices"
    bearings = "" if "bearing" in kinds else ", other bearing clearances than the arm's"
    silent = [
        *(each.chosen.name for each in found.bought if each.slot.what == "gearbox" and not each.slot.weighs and each.chosen.part is not None),
        *found.sized.unweighed,
    ]
    return (
        f"not counted: {NOT_COUNTED}, stresses and buckling of links, moment ratings of gearbox bearings{prices}{bearings}"
        f"{without_mass(silent)}; chosen are {', '.join(chosen) or 'no parts'} only, and gearboxes are rated against static torques"
    )
