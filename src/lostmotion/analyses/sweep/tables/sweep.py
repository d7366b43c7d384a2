"""Sheet of a run: error, AP and RP of each design, differences from the first, largest contributors
and largest errors.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.sweep.tables.designs import (
    LEVEL,
    as_error,
    as_length,
    cards,
    known_of,
    masses,
)
from lostmotion.error_model.arrival import rp_key, rp_name
from lostmotion.error_model.provenance import states
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.propagation.exact import share_neglected
from lostmotion.reporting.arm_sheet import sign_of
from lostmotion.reporting.chance_levels import INTERVAL_OF_POSES, REMEDIES
from lostmotion.reporting.first_order import failed, failure, judged, unsure
from lostmotion.reporting.joint_values import joint_value
from lostmotion.reporting.not_counted import NOT_COUNTED, without_mass
from lostmotion.reporting.provenance import (
    assumed_value_sentences,
    at_least,
    bound,
    caveats,
    error_sentence,
    provenance_facts,
    provenance_sections,
    repeatability_sentence,
    upper_limit_sentences,
)
from lostmotion.reporting.sheet import Cell, Row, Section, Sheet, length, several
from lostmotion.reporting.warnings import overload_warnings
from lostmotion.runs.design_names import design_name, short_labels

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.overload import Overload
    from lostmotion.mechanism.arm import Arm
    from lostmotion.runs.job import Order
    from lostmotion.runs.summary import Outcome

# Longer tables are shortened; result.json has every design.
_MOST_ROWS: Final = 60
_MOST_EXTREMES: Final = 10
_MOST_PARTS: Final = 3
_RESOLUTION: Final = "quantiles by linear interpolation in bins at most 0.4 % wide"
_WORDS: Final = (
    (
        "design",
        "one combination of the swept values; all designs share poses and random draws.",
    ),
    (
        "95th percentile",
        (
            "of the position error over all poses, robots and visits; its interval counts robots "
            "and independent sets of poses."
        ),
    ),
    (
        "AP, RP",
        (
            "ISO 9283 pose accuracy and repeatability, predicted: 95th percentile over robots of "
            "each robot's mean over the poses."
        ),
    ),
    (
        "difference",
        (
            "of the 95th percentile from that of the first design, with common random numbers: "
            "more precise than the two intervals suggest."
        ),
    ),
    (
        "largest",
        (
            "the largest error of these samples; it grows with their number. `lostmotion replay` "
            "lists its terms."
        ),
    ),
)


def sweep_sheet(arm: Arm, order: Order, outcomes: Sequence[Outcome]) -> Sheet:
    """Return the sheet of a run of one or many designs."""
    counted = (
        f"{several(order.poses, 'pose')} ({order.law}) x {several(order.robots, 'robot')} x "
        f"{several(order.visits, 'visit')}"
    )
    failing = [each.design for each in outcomes if failure(each.check, each.quantiles[LEVEL].value)]
    outcomes = [unsure(each) if each.design in failing else each for each in outcomes]
    ranked = sorted(
        outcomes, key=lambda each: (each.design in failing, each.quantiles[LEVEL].value)
    )
    sound = ranked[: len(ranked) - len(failing)]
    wrong = failed(
        [outcomes[design] for design in failing],
        len(outcomes),
        lambda design: design_name(order.axes, design),
    )
    chosen = list(outcomes)
    if len(outcomes) > _MOST_ROWS:
        chosen = ranked[: _MOST_ROWS // 2] + ranked[-_MOST_ROWS // 2 :]
    sections = [_designs(order, outcomes, chosen, counted), *_iso(order, chosen, counted)]
    if len(outcomes) > 1:
        sections += [_differences(order, chosen, counted), masses(order, chosen)]
    sections += [
        _parts(order, chosen),
        _levels(order, chosen),
        _extremes(order, outcomes, counted),
        _check(order, chosen),
    ]
    known = states(arm)
    each = f"{several(len(outcomes), 'design')}, each of " if len(outcomes) > 1 else ""
    return Sheet(
        name=arm.name,
        subject="a sweep of designs" if len(outcomes) > 1 else "a large run",
        verdict=" ".join([*wrong, *([_verdict(order, sound)] if sound else [])]),
        cards=tuple(cards(order, sound, outcomes)),
        sections=(*sections, *provenance_sections(known)),
        counts=each + counted,
        warnings=(*arm.warnings, *_overloaded(order, outcomes)),
        notes=(not_counted(outcomes), *arm.remarks) if len(outcomes) > 1 else arm.remarks,
        words=_WORDS,
        source=_source(order, counted),
        seed=order.seed,
        facts={
            **_facts(arm, order, outcomes),
            "not_counted": not_counted(outcomes),
            **provenance_facts(known),
        },
    )


def _overloaded(order: Order, outcomes: Sequence[Outcome]) -> tuple[str, ...]:
    """Return a warning per overloaded drive, or for many designs the number of those in which it is
    overloaded.
    """
    if len(outcomes) == 1:
        return overload_warnings(outcomes[0].overloads)
    worst: dict[str, tuple[Overload, Outcome]] = {}
    counts: Counter[str] = Counter()
    for outcome in outcomes:
        for each in outcome.overloads:
            counts[each.joint] += 1
            if (
                each.joint not in worst
                or each.held / each.rated > worst[each.joint][0].held / worst[each.joint][0].rated
            ):
                worst[each.joint] = each, outcome
    return tuple(
        (
            f"in {several(counts[joint], 'design')} of {len(outcomes)}, the worst "
            f"{design_name(order.axes, outcome.design)}: {sentence}"
        )
        for joint, (each, outcome) in worst.items()
        for sentence in overload_warnings([each])
    )


def _designs(
    order: Order, outcomes: Sequence[Outcome], chosen: Sequence[Outcome], counted: str
) -> Section:
    figures = [(each, (each.quantiles[LEVEL], each.mean, each.deviation)) for each in chosen]
    rows = tuple(
        Row(
            design_name(order.axes, each.design),
            tuple(as_error(each, one, counted) for one in three),
        )
        for each, three in figures
    )
    keys = [
        axis.key if len(axis.values) > 1 else f"{axis.key} = {axis.labels[0]} in all"
        for axis in order.axes
    ]
    swept = f"; swept: {', '.join(keys)}" if keys else ""
    omitted = (
        ""
        if len(chosen) == len(outcomes)
        else (
            f"; the {len(chosen) // 2} best and worst of {len(outcomes)}, all of them in "
            "result.json"
        )
    )
    is_short = any(
        short != text
        for axis in order.axes
        for short, text in zip(short_labels(axis), axis.labels, strict=True)
    )
    shortened = (
        "; names omit shared tolerances and shorten long values: result.json has every value"
        if is_short
        else ""
    )
    return Section(
        "designs",
        "Position error",
        ("95th percentile", "mean", "standard deviation"),
        rows,
        _RESOLUTION + swept + shortened + omitted,
    )


def _iso(order: Order, chosen: Sequence[Outcome], counted: str) -> list[Section]:
    rows = tuple(
        Row(
            design_name(order.axes, each.design),
            tuple(as_error(each, pair[1], counted) for pair in (each.ap, each.rp)),
        )
        for each in chosen
        if each.ap is not None and each.rp is not None
    )
    if not rows:
        return [
            Section("iso9283", "ISO 9283, predicted", ("value",), (), "needs at least 2 visits")
        ]
    note = (
        f"95th percentile over robots of each robot's mean over the poses; n = {order.visits} "
        f"visits; {_approach(order)}"
    )
    return [Section("iso9283", "ISO 9283, predicted", ("AP", rp_name(order.approach)), rows, note)]


def _differences(order: Order, chosen: Sequence[Outcome], counted: str) -> Section:
    rows = []
    for each in chosen:
        if each.lower is None:
            continue
        significant = each.lower.low > 0 or each.lower.high < 0
        difference = length(-each.lower.value, -each.lower.high, -each.lower.low, counted)
        rows.append(
            Row(
                design_name(order.axes, each.design),
                (difference,),
                "" if significant else "not significant: the interval contains zero",
            )
        )
    note = (
        f"against {design_name(order.axes, 0)}; negative: this design is more accurate. Same poses "
        "and draws"
    )
    return Section(
        "differences",
        "Difference from the first design",
        ("of the 95th percentile",),
        tuple(rows),
        note,
    )


def _parts(order: Order, chosen: Sequence[Outcome]) -> Section:
    """Return the shares of the largest contributors over the listed designs, a column for each."""
    exact = f"exact sum over terms, {several(order.poses, 'pose')}"
    shares = [{short_name(cost.part): cost.share for cost in each.costs} for each in chosen]
    names = sorted(
        {name for each in shares for name in each},
        key=lambda name: (-sum(each.get(name, 0.0) for each in shares), name),
    )
    shown = [name for name in names if any(each.get(name, 0.0) > 0 for each in shares)][
        :_MOST_PARTS
    ]
    rows = []
    for each, of in zip(chosen, shares, strict=True):
        if not shown:
            break
        rest = sum(share for name, share in of.items() if name not in shown)
        figures = (
            Cell(share, "%", samples=exact)
            for share in (*(of.get(name, 0.0) for name in shown), rest)
        )
        largest = max(of, key=lambda name: of[name])
        rows.append(
            Row(
                design_name(order.axes, each.design),
                tuple(figures),
                "" if largest == shown[0] else f"largest contributor here: {largest}",
            )
        )
    note = "shares of the mean square error; largest contributor over these designs first"
    return Section("parts", "Largest contributors", (*shown, "all others"), tuple(rows), note)


def _levels(order: Order, chosen: Sequence[Outcome]) -> Section:
    exact = f"exact sum over terms, {several(order.poses, 'pose')}"
    rows = tuple(
        Row(
            design_name(order.axes, each.design),
            (
                length(
                    each.rms_with_poses.value,
                    each.rms_with_poses.low,
                    each.rms_with_poses.high,
                    exact,
                ),
                *(
                    Cell(float(level) / each.rms**2 if each.rms else 0.0, "%", samples=exact)
                    for level in each.levels
                ),
            ),
        )
        for each in chosen
    )
    columns = ("r.m.s. error", "load and pose", "robot", "visit")
    return Section(
        "levels",
        "What can be compensated",
        columns,
        rows,
        (
            f"shares of the mean square. Load and pose: {REMEDIES[0]}. Robot: {REMEDIES[1]}. "
            f"Visit: {REMEDIES[2]}"
        )
        + (f"; {INTERVAL_OF_POSES}" if order.sets > 1 else ""),
    )


def _extremes(order: Order, outcomes: Sequence[Outcome], counted: str) -> Section:
    """Return the largest errors of all designs; result.json has those of each design."""
    largest = sorted(
        (each for outcome in outcomes for each in outcome.worst), key=lambda each: -each.error
    )[:_MOST_EXTREMES]
    rows = tuple(
        Row(
            (f"{design_name(order.axes, each.design)}, " if order.axes else "")
            + f"pose {each.pose}",
            (
                replace(
                    length(each.error, samples=f"{counted} each" if order.axes else counted),
                    bound=sign_of(known_of(outcomes[each.design])),
                ),
            ),
            (
                f"robot {each.robot}, visit {each.visit}: "
                f"{_joints(outcomes[each.design].joints, each.q)}"
            )
            + (f"; --design {each.design}" if order.axes else ""),
        )
        for each in largest
    )
    return Section(
        "extremes",
        "Largest errors",
        ("error",),
        rows,
        "one per pose; `lostmotion replay FOLDER` lists the terms of one",
    )


def _joints(joints: Sequence[tuple[str, str]], q: Any) -> str:  # noqa: ANN401 - an array
    return ", ".join(
        joint_value(name, kind, value) for (name, kind), value in zip(joints, q, strict=True)
    )


def _check(order: Order, chosen: Sequence[Outcome]) -> Section:
    each = max(chosen, key=lambda each: share_neglected(each.check, each.quantiles[LEVEL].value))
    counted = several(each.check.samples, "sample")
    error = each.quantiles[LEVEL].value
    share, warn = share_neglected(each.check, error), judged(each.check, error)
    rows = (
        Row(
            "largest difference",
            (length(each.check.largest, samples=counted),),
            design_name(order.axes, each.design) if order.axes else "",
        ),
        Row("largest, of the 95th percentile", (Cell(share, "%", samples=counted),), warn),
    )
    return Section("exact_check", "First order against exact composition", ("value",), rows)


def _approach(order: Order) -> str:
    return (
        "each joint approaches from either side at random"
        if not order.approach
        else f"every joint approaches moving {'up' if order.approach > 0 else 'down'}"
    )


def _verdict(order: Order, ranked: Sequence[Outcome]) -> str:
    best, worst = ranked[0], ranked[-1]
    other = [
        each
        for each in worst.limits
        if (each.joint, each.model, each.key)
        not in {(one.joint, one.model, one.key) for one in best.limits}
    ]
    of_best, of_worst = (known_of(each) for each in (best, worst))
    known = replace(
        of_best if of_best.lower_bound or not of_worst.lower_bound else of_worst,
        limits=(*best.limits, *other),
    )
    best_figure, worst_figure = (as_length(each.quantiles[LEVEL], "") for each in (best, worst))
    if len(ranked) == 1:
        repeats = (
            (
                " "
                f"{repeatability_sentence(rp_name(order.approach), str(as_length(best.rp[1], '')), known)}"  # noqa: E501
            )
            if best.rp is not None
            else ""
        )
        within = f"{best_figure} ({best_figure.interval or 'no interval'})"
        return " ".join(
            [
                error_sentence(within, known) + repeats,
                *upper_limit_sentences(known),
                *assumed_value_sentences(known),
            ]
        )
    text = (
        f"Of {several(len(ranked), 'design')} the smallest 95th percentile of the position "
        f"error is {at_least(best_figure, of_best)}, "
        f"with {design_name(order.axes, best.design)}. "
        f"The largest is {at_least(worst_figure, of_worst)}, with "
        f"{design_name(order.axes, worst.design)}."
    )
    return " ".join([text, *caveats(known)])


def _source(order: Order, counted: str) -> str:
    versions = ", ".join(
        f"{name} {version}" for name, version in order.made_with.items() if name != "lostmotion"
    )
    return (
        f"seed {order.seed}: {counted}, in blocks of {several(order.block, 'pose')}; "
        f"{_approach(order)}. "
        f"The same arm, values, counts, seed and versions ({versions}) "
        "on the same kind of processor give the same bytes, for any number of workers and "
        "interruptions."
    )


def _facts(arm: Arm, order: Order, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    return {
        "arm": arm.name,
        "seed": order.seed,
        "poses": {"count": order.poses, "law": order.law, "independent_sets": order.sets},
        "robots": order.robots,
        "visits": order.visits,
        "axes": [{"key": axis.key, "values": list(axis.values)} for axis in order.axes],
        "designs": [
            {"name": design_name(order.axes, each.design), **_plain(each, order.approach)}
            for each in outcomes
        ],
    }


def _plain(outcome: Outcome, approach: float) -> dict[str, Any]:
    """Return a design as plain data, in m; `approach` of the joints names its repeatability."""
    spread = {
        name: pair
        for name, pair in (("ap", outcome.ap), (rp_key(approach), outcome.rp))
        if pair is not None
    }
    of_robots = {
        f"{name}{level}_m": estimate
        for name, pair in spread.items()
        for level, estimate in zip(("", "95"), pair, strict=True)
    }
    lower = {} if outcome.lower is None else {"q95_lower_than_first_m": outcome.lower}
    overall = {"mean_m": outcome.mean, "standard_deviation_m": outcome.deviation}
    estimates = {
        **overall,
        **{f"q{100 * level:.0f}_m": estimate for level, estimate in outcome.quantiles.items()},
        **of_robots,
        **lower,
    }
    return {
        "design": outcome.design,
        "stated": outcome.stated,
        **{
            name: [_finite(each.value), _finite(each.low), _finite(each.high)]
            for name, each in estimates.items()
        },
        "rms_m": outcome.rms,
        "bound": bound(known_of(outcome)),
        "missing": {joint: list(kinds) for joint, kinds in outcome.known.missing.items()},
        "mass_kg": outcome.mass,
        "mass_not_stated": list(outcome.gearboxes_without_mass),
        "price": outcome.price,
        "price_not_stated": list(outcome.joints_without_price),
        "parts": [
            {"part": cost.part, "alone_m": cost.alone, "share": cost.share}
            for cost in outcome.costs
        ],
        "worst": [each.facts() for each in outcome.worst],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def not_counted(outcomes: Sequence[Outcome]) -> str:
    """Return what a sweep of designs does not count."""
    prices = "" if any(each.price is not None for each in outcomes) else ", prices (none is stated)"
    without = list(
        dict.fromkeys(model for each in outcomes for model in each.gearboxes_without_mass)
    )
    return (
        f"not counted: {NOT_COUNTED}, strength of parts{prices}{without_mass(without)}; "
        "each design is compared by its position error at rest, its "
        f"mass{'' if prices else ' and its price'}"
    )
