"""Sheet of a selection of parts for a target on the tool: parts, error, effect of each choice, and
trade-off.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, Literal

from lostmotion.analyses.sizing.page.plots import selection_plots as plots
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.reporting.arm_sheet import sections_as_known, with_arm
from lostmotion.reporting.not_counted import NOT_COUNTED, without_mass
from lostmotion.reporting.provenance import as_known, at_least, by_what_is_described, caveats
from lostmotion.reporting.sheet import Card, Cell, Section, Sheet, cell, length, several, table
from lostmotion.sizing.error_cache import approach_for

if TYPE_CHECKING:
    from lostmotion.analyses.sizing.selection import SelectedPart, Selection
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.provenance import States
    from lostmotion.sizing.candidates import PartCandidate

__all__ = ["plots", "sheet"]
_WORDS: Final = (
    (
        "95 % error",
        (
            "95th percentile of the position error of the tool over poses of the workspace, "
            "robots and visits."
        ),
    ),
    (
        "full study",
        (
            "as `lostmotion study` with its default sizes; the small study has fewer poses, "
            "robots and visits."
        ),
    ),
    (
        "replaced by the cheapest",
        (
            "this part is the candidate with the least of what is minimised (mass, price or "
            "both), all others are as selected."
        ),
    ),
    ("price", "from the sizing file, in its currency."),
    ("evaluated", "selections whose masses, loads and errors were computed in full."),
)


def sheet(result: Selection) -> Sheet:
    """Return the sheet of a selection of parts."""
    size = result.study_size
    counted = (
        f"{several(len(result.poses), 'pose')} x {several(size.robots, 'robot')} x "
        f"{several(size.visits, 'visit')}, seed {size.seed}"
    )
    known = with_limits(result.states, result.sized, result.poses.q, approach_for(size.of))
    poses, robots, visits = result.small_study
    small = f"{poses} poses x {robots} robots x {visits} visits, seed {size.seed}"
    sections = (
        _parts(result),
        _errors(result, counted),
        *sections_as_known(
            (_savings(result, small), _trade_off(result, small), _halving(result)), known
        ),
        _torques(result),
        _searched(result),
    )
    return with_arm(
        Sheet(
            subject="parts selected for a target on the tool",
            verdict=" ".join([_verdict(result, known), *caveats(known)]),
            cards=tuple(_cards(result, known)),
            sections=tuple(section for section in sections if section.rows),
            counts=f"search at {result.search_poses} poses; full study: {counted}",
            notes=(*_remarks(result), *result.notes),
            words=_WORDS,
            source=f"{counted}. The same files, version and seed give the same bytes.",
            seed=size.seed,
            facts=_facts(result),
        ),
        result.sized,
        known,
        sections=("error",),
        not_counted=not_counted(result),
    )


def _kg(value: float) -> Cell:
    return Cell(value, "kg")


def _price(value: float) -> Cell:
    return Cell(value, "1", stated=True)


def candidate_name(each: SelectedPart, candidate: PartCandidate) -> str:
    """Return the name of a candidate."""
    return f"{each.slot.present.name}, unchanged" if candidate.part is None else candidate.name


def _verdict(result: Selection, known: States) -> str:
    target, error = length(result.target, stated=True), at_least(cell(result.error, "m"), known)
    between = as_known(cell(result.error, "m"), known).between
    within = f" (95 % interval {between})" if between else ""
    if not result.is_feasible:
        return (
            "No selection meets the constraints: a reducer is rated below its holding torque, "
            "or a link exceeds its limits."
        )
    if not result.meets_target:
        text = (
            f"No selection meets the target of {target}; the most accurate has a {result.quantity} "
            f"of {error}{within}."
        )
        gain = max(result.halving.gains.items(), key=lambda pair: pair[1].value, default=None)
        if gain is not None:
            less = as_known(cell(gain[1], "m"), known)
            text += (
                f" Largest effect: {gain[0]}; halving its errors reduces the 95 % error by {less}."
            )
        return text
    before = at_least(cell(result.error_before, "m"), known)
    met = f"within the target of {target}{by_what_is_described(known)}"
    text = (
        f"The {result.quantity} is {error}{within}, {met}; as stated it is {before}. The mass "
        f"of the selected parts is {_kg(result.mass)}, as stated {_kg(result.mass_before)}"
    )
    if result.objective.has_price:
        text += f", their price {_price(result.price)}"
        if math.isfinite(result.price_before):
            text += f", as stated {_price(result.price_before)}"
    better = _better(result)
    if result.proven:
        return f"{text}. All {better} selections miss the target."
    return f"{text}. No exchange of one or two parts is {better}."


def _better(result: Selection) -> str:
    """Return what a better selection is called: by its mass, or where the objective has a price."""
    return "cheaper" if result.objective.per_price else "lighter"


def _cards(result: Selection, known: States) -> list[Card]:
    met = "" if result.meets_target else ", not met"
    target = f"target {length(result.target, stated=True)}{met}"
    error, before = (as_known(cell(e, "m"), known) for e in (result.error, result.error_before))
    of_error = result.study_size.of == "error"
    limited: Literal["error", "repeatability"] = "error" if of_error else "repeatability"
    cards = [
        Card(result.quantity, str(error), target, "", limited),
        Card("as stated", str(before), result.quantity, "", limited),
        Card("selected parts", str(_kg(result.mass)), f"as stated {_kg(result.mass_before)}"),
    ]
    if result.objective.has_price:
        priced = math.isfinite(result.price_before)
        stated = f"as stated {_price(result.price_before)}" if priced else "as stated: not known"
        cards.append(Card("price", str(_price(result.price)), stated))
    return cards


def _parts(result: Selection) -> Section:
    price = result.objective.has_price

    def figures(mass: tuple[float, float], prices: tuple[float, float]) -> list[Cell]:
        return [*map(_kg, mass), *(map(_price, prices) if price else ())]

    rows = []
    for each in result.parts:
        now, new = each.slot.present, each.selected
        change = "unchanged" if new.part is None else new.name
        note = f"{now.name}{', ' if new.part is None else ' -> '}{change}"
        cells = figures((now.mass, new.mass), (now.price, new.price))
        rows.append((each.slot.label, *cells, note))
    total = figures((result.mass_before, result.mass), (result.price_before, result.price))
    return table(
        "parts",
        "Selected parts",
        ["mass now", "mass", *(["price now", "price"] if price else [])],
        [*rows, ("total", *total)],
        f"minimised: {result.objective.text}; now: as the file states; masses in kg, of the "
        "selected parts only; free sizes of links are usual ones "
        "of tubes, bars and profiles, or multiples of the step that was asked for",
    )


def _errors(result: Selection, counted: str) -> Section:
    met = "target met" if result.meets_target else "target not met"
    return table(
        "error",
        f"{result.quantity} of the tool" if result.study_size.of == "error" else result.quantity,
        {"value": "m"},
        [
            (
                "target",
                length(result.target, stated=True),
                "for the upper end of the confidence interval",
            ),
            ("as stated", cell(result.error_before, "m", counted), "full study"),
            ("selected parts", cell(result.error, "m", counted), f"full study; {met}"),
        ],
        "over the workspace",
    )


def _savings(result: Selection, small: str) -> Section:
    rows: list[tuple[str, Cell, Cell, str]] = [
        (
            each.slot.label,
            Cell(each.saving, "kg" if result.objective.text == "mass" else "1"),
            cell(each.error_with_cheapest, "m", small),
            " instead of ".join(
                candidate_name(each, one) for one in (each.selected, each.cheapest)
            ),
        )
        for each in result.parts
        if each.error_with_cheapest is not None
    ]
    rows.sort(key=lambda row: -row[2].value)
    return table(
        "buys",
        "Effect of each choice",
        ["saving", f"{result.quantity} with the cheapest"],
        rows,
        f"each part in turn replaced by the cheapest candidate: saving ({result.objective.text}) "
        f"and resulting {result.quantity}",
    )


def _trade_off(result: Selection, small: str) -> Section:
    price = result.objective.has_price
    both = price and result.objective.per_kg > 0
    rows = []
    for point in result.trade_off:
        note = "" if point.meets_target else "cannot be met"
        if point.target == result.target:
            note = "stated target"
        elif not result.meets_target and point.target == result.error.high:
            note = "most accurate"
        figures = [
            *([_price(point.cost)] if both else []),
            _kg(point.mass),
            *([_price(point.price)] if price else []),
            cell(point.error, "m", small),
        ]
        rows.append((str(length(point.target, stated=True)), *figures, note))
    columns = ["cost"] * both + ["mass"] + ["price"] * price + [result.quantity]
    note = "" if result.meets_target else "around the most accurate selection; "
    note += f"cost: {result.objective.text}; " if both else ""
    note += "other targets by exchange of single parts"
    return table("trade", "Cost against target", columns, rows, note)


def _halving(result: Selection) -> Section:
    gains = sorted(result.halving.gains.items(), key=lambda pair: -pair[1].value)
    return table(
        "halving",
        "Effect of halving a part's errors",
        {"reduction of the 95 % error": "m"},
        gains[:10],
        "of the arm with the selected parts, the largest first",
        samples=f"{result.halving.samples} paired samples",
    )


def _torques(result: Selection) -> Section:
    rows = []
    for each in result.parts:
        if each.slot.kind == "gearbox":
            rated = _rated(result, each)
            stated = Cell(math.nan if rated is None else rated, "N m", stated=True)
            for joint in each.slot.joints:
                torque = result.torques[joint]
                of_rated = torque / rated if rated else None
                selected = candidate_name(each, each.selected)
                rows.append((joint, torque, stated, of_rated, selected))
    tilt = (
        "base as stated"
        if result.constraints.tilt is None
        else f"base tilt up to {math.degrees(result.constraints.tilt):.3g}°"
    )
    return table(
        "torques",
        "Holding torque of the selected gearboxes",
        {"holding torque": "N m", "rated": "N m", "of rated": "%"},
        rows,
        f"largest over the poses of the search and the corners of the joint ranges, {tilt}, with "
        "the selected parts",
    )


def _searched(result: Selection) -> Section:
    better, count = _better(result), result.combinations
    status = (
        "none meets the target; the most accurate is reported"
        if not result.meets_target
        else f"all {better} selections evaluated"
        if result.proven
        else f"no exchange of one or two parts is {better}"
    )
    corrected = "corrected so that the full study meets the target"
    rows = [
        ("possible selections", float(count) if count > 10**9 else count, ""),
        ("evaluated", result.evaluated, status),
        ("pairs predicted", result.predicted, "error predicted from the single exchanges"),
        *(
            (f"search target {k}", length(inner), corrected)
            for k, inner in enumerate(result.search_targets, 1)
        ),
    ]
    note = f"at {result.search_poses} poses, from exact mean and covariance of the error"
    return table("search", "The search", ["value"], rows, note)


def _remarks(result: Selection) -> list[str]:
    out = [each.selected.note for each in result.parts if each.selected.note]
    unrated = [
        name
        for each in result.parts
        if each.slot.kind == "gearbox" and _rated(result, each) is None
        for name in each.slot.joints
    ]
    if unrated:
        out.append(
            f"rated torque not stated for the gearboxes of {', '.join(unrated)}: their load is "
            "not checked"
        )
    heaviest = [
        name
        for each in result.parts
        if each.slot.kind == "link"
        and len(each.slot.candidates) > 1
        and each.selected.mass >= max(one.mass for one in each.slot.candidates)
        for name in each.slot.joints
    ]
    if heaviest:
        out.append(
            f"the heaviest candidate was selected for {', '.join(heaviest)}: a wider family "
            f"may be {_better(result)}"
        )
    return list(dict.fromkeys(out))


def _rated(result: Selection, each: SelectedPart) -> float | None:
    joint = next(joint for joint in result.sized.joints if joint.name == each.slot.joint)
    return getattr(getattr(joint, "gearbox", None), "rated_torque", None)


def _facts(result: Selection) -> dict[str, Any]:
    def known(value: float) -> float | None:
        return value if math.isfinite(value) else None

    def ends(error: Estimate) -> list[float | None]:
        return [error.value, known(error.low), known(error.high)]

    return {
        "target_m": result.target,
        "holds": result.meets_target,
        "minimise": {"per_kg": result.objective.per_kg, "per_price": result.objective.per_price},
        "error_95_m": ends(result.error),
        "error_95_before_m": ends(result.error_before),
        "proven": result.proven,
        "parts": [
            {
                "joint": name,
                "part": each.slot.kind,
                "chosen": each.selected.name,
                "before": each.slot.present.name,
                "mass_kg": known(each.selected.mass / len(each.slot.joints)),
                "price": known(each.selected.price / len(each.slot.joints)),
            }
            for each in result.parts
            for name in each.slot.joints
        ],
    }


def not_counted(result: Selection) -> str:
    """Return what a selection of parts does not count."""
    kinds = {each.slot.kind for each in result.parts}
    names = {"link": "links", "gearbox": "gearboxes", "bearing": "bearing clearances"}
    selected = [name for kind, name in names.items() if kind in kinds]
    prices = "" if result.objective.per_price else ", prices"
    bearings = "" if "bearing" in kinds else ", other bearing clearances than the arm's"
    without = [
        each.selected.name
        for each in result.parts
        if each.slot.kind == "gearbox" and not each.slot.has_masses and each.selected.part
    ] + [*result.sized.gearboxes_without_mass]
    return (
        f"not counted: {NOT_COUNTED}, stresses and buckling of links, moment ratings of "
        f"gearbox bearings{prices}{bearings}"
        f"{without_mass(without)}; selected are {', '.join(selected) or 'no parts'} only; "
        "gearboxes are checked against static torques"
    )
