"""Sheet of a selection of parts for a target on the tool: parts, error, effect of each choice, and
trade-off.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.sizing.plots import selection_plots as plots
from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.reporting.arm_sheet import bounded_cards, bounded_sections
from lostmotion.reporting.not_counted import NOT_COUNTED, without_mass
from lostmotion.reporting.provenance import (
    at_least,
    by_what_is_described,
    caveats,
    provenance_facts,
    provenance_sections,
)
from lostmotion.reporting.sheet import Card, Cell, Row, Section, Sheet, length, several
from lostmotion.reporting.warnings import arm_warnings
from lostmotion.sizing.error_cache import approach_for

if TYPE_CHECKING:
    from lostmotion.analyses.sizing.selection import SelectedPart, Selection
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.provenance import States
    from lostmotion.sizing.candidates import Candidate

_MOST_HALVED: Final = 10
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
    known = with_limits(
        states(result.sized), result.sized, result.poses.q, approach_for(result.study_size.of)
    )
    small = (
        "{} poses x {} robots x {} visits".format(*result.small_study)
        + f", seed {result.study_size.seed}"
    )
    return Sheet(
        name=result.arm.name,
        subject="parts selected for a target on the tool",
        verdict=" ".join([_verdict(result, known), *caveats(known)]),
        cards=bounded_cards(_cards(result), known, (result.quantity, "as stated")),
        sections=(
            *bounded_sections(
                [section for section in _sections(result, counted, small) if section.rows],
                known,
                ("error",),
            ),
            *provenance_sections(known),
        ),
        counts=f"search at {result.search_poses} poses; full study: {counted}",
        warnings=arm_warnings(result.sized),
        notes=(not_counted(result), *result.arm.remarks, *_remarks(result), *result.notes),
        words=_WORDS,
        source=f"{counted}. The same files, version and seed give the same bytes.",
        seed=result.study_size.seed,
        facts={**_facts(result), "not_counted": not_counted(result), **provenance_facts(known)},
    )


def _sections(result: Selection, counted: str, small: str) -> tuple[Section, ...]:
    return (
        _parts(result),
        _errors(result, counted),
        _savings(result, small),
        _trade_off(result, small),
        _halving(result),
        _torques(result),
        _searched(result),
    )


def _estimate(estimate: Estimate, samples: str = "") -> Cell:
    return length(estimate.value, estimate.low, estimate.high, samples)


def _kg(value: float) -> Cell:
    return Cell(value, "kg")


def _price(value: float) -> Cell:
    return Cell(value, "1", stated=True)


def candidate_name(each: SelectedPart, candidate: Candidate) -> str:
    """Return the name of a candidate."""
    return f"{each.slot.present.name}, unchanged" if candidate.part is None else candidate.name


def _verdict(result: Selection, known: States) -> str:
    target, error = length(result.target, stated=True), at_least(_estimate(result.error), known)
    if not result.meets_target:
        text = (
            f"No selection meets the target of {target}; the most accurate has a {result.quantity} "
            f"of {error} ({_interval(result.error)})."
        )
        gain = max(result.halving.gains.items(), key=lambda pair: pair[1].value, default=None)
        if not result.is_feasible:
            text = (
                "No selection meets the constraints: a reducer is rated below its holding torque, "
                "or a link exceeds its limits."
            )
        elif gain is not None:
            text += (
                f" Largest effect: {gain[0]}; halving its errors reduces the 95 % error by "
                f"{_estimate(gain[1])}."
            )
        return text
    before = at_least(_estimate(result.error_before), known)
    met = f"within the target of {target}{by_what_is_described(known)}"
    text = (
        f"The {result.quantity} is {error} ({_interval(result.error)}), {met}; as stated it is "
        f"{before}."
    )
    text += (
        f" The mass of the selected parts is {_kg(result.mass)}, as stated "
        f"{_kg(result.mass_before)}"
    )
    if result.objective.has_price:
        text += f", their price {_price(result.price)}" + (
            f", as stated {_price(result.price_before)}"
            if math.isfinite(result.price_before)
            else ""
        )
    better = _better(result)
    text += (
        f". All {better} selections miss the target."
        if result.proven
        else f". No exchange of one or two parts is {better}."
    )
    return text


def _better(result: Selection) -> str:
    """Return what a better selection is called: by its mass, or where the objective has a price."""
    return "cheaper" if result.objective.per_price else "lighter"


def _interval(estimate: Estimate) -> str:
    return f"95 % interval {_estimate(estimate).between}"


def _cards(result: Selection) -> list[Card]:
    cards = [
        Card(
            result.quantity,
            str(_estimate(result.error)),
            f"target {length(result.target, stated=True)}"
            + ("" if result.meets_target else ", not met"),
        ),
        Card("as stated", str(_estimate(result.error_before)), result.quantity),
        Card("selected parts", str(_kg(result.mass)), f"as stated {_kg(result.mass_before)}"),
    ]
    if result.objective.has_price:
        before = (
            f"as stated {_price(result.price_before)}"
            if math.isfinite(result.price_before)
            else "as stated: not known"
        )
        cards.append(Card("price", str(_price(result.price)), before))
    return cards


def _parts(result: Selection) -> Section:
    rows = []
    for each in result.parts:
        figures = [_kg(each.slot.present.mass), _kg(each.selected.mass)]
        if result.objective.has_price:
            figures += [_price(each.slot.present.price), _price(each.selected.price)]
        note = (
            f"{each.slot.present.name} -> {each.selected.name}"
            if each.selected.part is not None
            else f"{each.slot.present.name}, unchanged"
        )
        rows.append(Row(each.slot.label, tuple(figures), note))
    figures = [_kg(result.mass_before), _kg(result.mass)]
    if result.objective.has_price:
        figures += [_price(result.price_before), _price(result.price)]
    rows.append(Row("total", tuple(figures)))
    columns = ("mass now", "mass", *(("price now", "price") if result.objective.has_price else ()))
    return Section(
        "parts",
        "Selected parts",
        columns,
        tuple(rows),
        f"minimised: {result.objective.text}; now: as the file states; masses in kg, of the "
        "selected parts only; free sizes of links are usual ones "
        "of tubes, bars and profiles, or multiples of the step that was asked for",
    )


def _errors(result: Selection, counted: str) -> Section:
    rows = (
        Row(
            "target",
            (length(result.target, stated=True),),
            "for the upper end of the confidence interval",
        ),
        Row("as stated", (_estimate(result.error_before, counted),), "full study"),
        Row(
            "selected parts",
            (_estimate(result.error, counted),),
            "full study; target met" if result.meets_target else "full study; target not met",
        ),
    )
    return Section(
        "error",
        f"{result.quantity} of the tool" if result.study_size.of == "error" else result.quantity,
        ("value",),
        rows,
        "over the workspace",
    )


def _savings(result: Selection, small: str) -> Section:
    rows = []
    for each in result.parts:
        if each.error_with_cheapest is not None:
            figures = (
                Cell(each.saving, "kg" if result.objective.text == "mass" else "1"),
                _estimate(each.error_with_cheapest, small),
            )
            rows.append(
                (
                    each.error_with_cheapest.value,
                    Row(
                        each.slot.label,
                        figures,
                        (
                            f"{candidate_name(each, each.selected)} instead of "
                            f"{candidate_name(each, each.cheapest)}"
                        ),
                    ),
                )
            )
    note = (
        f"each part in turn replaced by the cheapest candidate: saving ({result.objective.text}) "
        f"and resulting {result.quantity}"
    )
    ordered = tuple(row for _, row in sorted(rows, key=lambda pair: -pair[0]))
    return Section(
        "buys",
        "Effect of each choice",
        ("saving", f"{result.quantity} with the cheapest"),
        ordered,
        note,
    )


def _trade_off(result: Selection, small: str) -> Section:
    rows = []
    both = result.objective.has_price and result.objective.per_kg > 0
    for point in result.trade_off:
        cost = [_price(point.cost)] if both else []
        figures = [
            *cost,
            _kg(point.mass),
            *([_price(point.price)] if result.objective.has_price else []),
            _estimate(point.error, small),
        ]
        note = "" if point.meets_target else "cannot be met"
        if point.target == result.target:
            note = "stated target"
        elif not result.meets_target and point.target == result.error.high:
            note = "most accurate"
        rows.append(Row(str(length(point.target, stated=True)), tuple(figures), note))
    columns = (
        *(("cost",) if both else ()),
        "mass",
        *(("price",) if result.objective.has_price else ()),
        result.quantity,
    )
    note = "" if result.meets_target else "around the most accurate selection; "
    note += f"cost: {result.objective.text}; " if both else ""
    return Section(
        "trade",
        "Cost against target",
        columns,
        tuple(rows),
        f"{note}other targets by exchange of single parts",
    )


def _halving(result: Selection) -> Section:
    gains = sorted(result.halving.gains.items(), key=lambda pair: -pair[1].value)[:_MOST_HALVED]
    counted = f"{result.halving.samples} paired samples"
    rows = tuple(Row(name, (_estimate(gain, counted),)) for name, gain in gains)
    return Section(
        "halving",
        "Effect of halving a part's errors",
        ("reduction of the 95 % error",),
        rows,
        "of the arm with the selected parts, the largest first",
    )


def _torques(result: Selection) -> Section:
    rows = []
    for each in result.parts:
        rated = getattr(_gearbox(result, each), "rated_torque", None)
        if each.slot.kind == "gearbox":
            torque = result.torques[each.slot.joint]
            share = Cell(torque / rated if rated else math.nan, "%")
            rows.append(
                Row(
                    each.slot.joint,
                    (
                        Cell(torque, "N m"),
                        Cell(math.nan if rated is None else rated, "N m", stated=True),
                        share,
                    ),
                    candidate_name(each, each.selected),
                )
            )
    tilt = (
        "base as stated"
        if result.constraints.tilt is None
        else f"base tilt up to {math.degrees(result.constraints.tilt):.3g}°"
    )
    note = (
        f"largest over the poses of the search and the corners of the joint ranges, {tilt}, with "
        "the selected parts"
    )
    return Section(
        "torques",
        "Holding torque of the selected gearboxes",
        ("holding torque", "rated", "of rated"),
        tuple(rows),
        note,
    )


def _searched(result: Selection) -> Section:
    better = _better(result)
    status = (
        f"all {better} selections evaluated"
        if result.proven
        else f"no exchange of one or two parts is {better}"
    )
    status = (
        status if result.meets_target else "none meets the target; the most accurate is reported"
    )
    rows = (
        Row(
            "possible selections",
            (
                Cell(float(result.combinations), "1")
                if result.combinations > 10**9
                else Cell(result.combinations, "1"),
            ),
        ),
        Row("evaluated", (Cell(result.evaluated, "1"),), status),
        Row(
            "pairs predicted",
            (Cell(result.predicted, "1"),),
            "error predicted from the single exchanges",
        ),
        *(
            Row(
                f"search target {k}",
                (length(inner),),
                "corrected so that the full study meets the target",
            )
            for k, inner in enumerate(result.search_targets, 1)
        ),
    )
    return Section(
        "search",
        "The search",
        ("value",),
        rows,
        f"at {result.search_poses} poses, from exact mean and covariance of the error",
    )


def _remarks(result: Selection) -> list[str]:
    out = [each.selected.note for each in result.parts if each.selected.note]
    unrated = [
        each.slot.joint
        for each in result.parts
        if each.slot.kind == "gearbox"
        and getattr(_gearbox(result, each), "rated_torque", None) is None
    ]
    if unrated:
        out.append(
            f"rated torque not stated for the gearboxes of {', '.join(unrated)}: their load is "
            "not checked"
        )
    heaviest = [
        each.slot.joint
        for each in result.parts
        if each.slot.kind == "link"
        and len(each.slot.candidates) > 1
        and each.selected.mass >= max(one.mass for one in each.slot.candidates)
    ]
    if heaviest:
        out.append(
            f"the heaviest candidate was selected for {', '.join(heaviest)}: a wider family "
            f"may be {_better(result)}"
        )
    return list(dict.fromkeys(out))


def _gearbox(result: Selection, each: SelectedPart) -> Any:  # noqa: ANN401 - any kind of gearbox
    return next(
        getattr(joint, "gearbox", None)
        for joint in result.sized.joints
        if joint.name == each.slot.joint
    )


def _facts(result: Selection) -> dict[str, Any]:
    def known(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return {
        "arm": result.arm.name,
        "target_m": result.target,
        "holds": result.meets_target,
        "minimise": {"per_kg": result.objective.per_kg, "per_price": result.objective.per_price},
        "error_95_m": [result.error.value, known(result.error.low), known(result.error.high)],
        "error_95_before_m": [
            result.error_before.value,
            known(result.error_before.low),
            known(result.error_before.high),
        ],
        "proven": result.proven,
        "parts": [
            {
                "joint": each.slot.joint,
                "part": each.slot.kind,
                "chosen": each.selected.name,
                "before": each.slot.present.name,
                "mass_kg": known(each.selected.mass),
                "price": known(each.selected.price),
            }
            for each in result.parts
        ],
    }


def not_counted(result: Selection) -> str:
    """Return what a selection of parts does not count."""
    kinds = {each.slot.kind for each in result.parts}
    selected = [
        name
        for name, kind in (
            ("links", "link"),
            ("gearboxes", "gearbox"),
            ("bearing clearances", "bearing"),
        )
        if kind in kinds
    ]
    prices = "" if result.objective.per_price else ", prices"
    bearings = "" if "bearing" in kinds else ", other bearing clearances than the arm's"
    without = [
        *(
            each.selected.name
            for each in result.parts
            if each.slot.kind == "gearbox"
            and not each.slot.has_masses
            and each.selected.part is not None
        ),
        *result.sized.gearboxes_without_mass,
    ]
    return (
        f"not counted: {NOT_COUNTED}, stresses and buckling of links, moment ratings of "
        f"gearbox bearings{prices}{bearings}"
        f"{without_mass(without)}; selected are {', '.join(selected) or 'no parts'} only; "
        "gearboxes are checked against static torques"
    )
