"""Cards and tables of the designs of a run: error, AP and RP, differences from the first, mass and
price, largest contributors, what can be compensated, and the largest errors.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.error_model.arrival import rp_name
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import stated_text
from lostmotion.propagation.exact import share_neglected
from lostmotion.reporting.arm_sheet import bounded_cards, sign_of
from lostmotion.reporting.chance_levels import INTERVAL_OF_POSES, REMEDIES
from lostmotion.reporting.first_order import judged
from lostmotion.reporting.joint_values import joint_value
from lostmotion.reporting.provenance import as_known
from lostmotion.reporting.sheet import Card, Cell, length, several, table
from lostmotion.runs.design_names import design_name, short_labels

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.provenance import States
    from lostmotion.reporting.sheet import Section
    from lostmotion.runs.job import Order
    from lostmotion.runs.summary import Outcome

_MOST_PARTS: Final = 3
_MOST_EXTREMES: Final = 10
# Figures with their intervals that fit beside the names of designs on paper.
_MOST_FIGURES: Final = 3
_RESOLUTION: Final = "quantiles by linear interpolation in bins at most 0.4 % wide"


def design_sections(
    order: Order, outcomes: Sequence[Outcome], chosen: Sequence[Outcome], counted: str
) -> list[Section]:
    """Return the tables of the chosen designs, all of which stand; those of differences for several
    designs alone.
    """
    several_designs = len(outcomes) > 1
    fallen = [each for each in outcomes if each.falls]
    return [
        *_designs(order, chosen, fallen, counted),
        _iso(order, chosen, counted),
        *(
            [
                *([] if outcomes[0].falls else [_differences(order, chosen, counted)]),
                _masses(order, [*chosen, *fallen]),
            ]
            if several_designs
            else []
        ),
        _parts(order, chosen),
        _levels(order, chosen),
        _extremes(order, outcomes, counted),
        _check(order, chosen),
    ]


def falls_text(each: Outcome) -> str:
    """Return where a design falls, as a headline and a table have it; empty for one that stands."""
    if each.falls is None:
        return ""
    return (
        f"at {each.falls.count} of {each.falls.poses} poses the springs at {each.falls.place} "
        "cannot hold the load"
    )


def as_length(each: Outcome, estimate: Estimate, samples: str = "") -> Cell:
    """Return an estimate (m) of a design, with one digit where every drive is assumed."""
    return as_known(length(estimate.value, estimate.low, estimate.high, samples), each.known)


def known_of(each: Outcome) -> States:
    """Return the states of the kinds of error of a design, with the makers' limits that count in
    it.
    """
    return replace(each.known, limits=each.limits)


def _error(each: Outcome, error: Cell) -> Cell:
    """Return an error of a design, as a lower bound where kinds of error are missing."""
    return replace(as_known(error, each.known), bound=sign_of(known_of(each)))


def _designs(
    order: Order, chosen: Sequence[Outcome], fallen: Sequence[Outcome], counted: str
) -> list[Section]:
    """Return the figures of the error, those that are asked for first in the first table, with the
    designs that fall at its end.
    """
    of_error = [each for each in chosen[0].declared.values() if each.group == "error"]
    of_error.sort(key=lambda each: not each.first)
    keys = [
        axis.key if len(axis.values) > 1 else f"{axis.key} = {axis.labels[0]} in all"
        for axis in order.axes
    ]
    swept = f"; swept: {', '.join(keys)}" if keys else ""
    standing = order.designs - len(fallen)
    omitted = (
        ""
        if len(chosen) == standing
        else f"; the {len(chosen) // 2} best and worst of {standing}, all of them in result.json"
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
    note, out = _RESOLUTION + swept + shortened + omitted, []
    for first in range(0, len(of_error), _MOST_FIGURES):
        columns = of_error[first : first + _MOST_FIGURES]
        rows = [
            (
                design_name(order.axes, each.design),
                *(_error(each, as_length(each, each.figures[of.key], counted)) for of in columns),
            )
            for each in chosen
        ]
        if not first:
            rows += [
                (design_name(order.axes, each.design), *["falls"] * len(columns), falls_text(each))
                for each in fallen
            ]
        out.append(
            table(
                f"designs_{first // _MOST_FIGURES + 1}" if first else "designs",
                "Position error, further figures" if first else "Position error",
                tuple(of.name for of in columns),
                rows,
                "" if first else note,
            )
        )
    return out


def _iso(order: Order, chosen: Sequence[Outcome], counted: str) -> Section:
    title = "ISO 9283, predicted"
    rows = [
        (
            design_name(order.axes, each.design),
            *(_error(each, as_length(each, of, counted)) for of in (each.ap, each.rp) if of),
        )
        for each in chosen
        if each.ap is not None and each.rp is not None
    ]
    if not rows:
        return table("iso9283", title, ("value",), (), "needs at least 2 visits")
    note = (
        f"95th percentile over robots of each robot's mean over the poses; n = {order.visits} "
        f"visits; {approach_text(order)}"
    )
    return table("iso9283", title, ("AP", rp_name(order.approach)), rows, note)


def _differences(order: Order, chosen: Sequence[Outcome], counted: str) -> Section:
    rows = []
    for each in chosen:
        if (lower := each.lower) is None:
            continue
        significant = lower.low > 0 or lower.high < 0
        rows.append(
            (
                design_name(order.axes, each.design),
                as_known(length(-lower.value, -lower.high, -lower.low, counted), each.known),
                "" if significant else "not significant: the interval contains zero",
            )
        )
    return table(
        "differences",
        "Difference from the first design",
        ("of the 95th percentile",),
        rows,
        f"against {design_name(order.axes, 0)}; negative: this design is more accurate. Same poses "
        "and draws",
    )


def _masses(order: Order, chosen: Sequence[Outcome]) -> Section:
    """Return the mass of each design, and its price where any is stated."""
    priced = any(each.price is not None for each in chosen)
    rows = []
    for each in chosen:
        notes = []
        if each.gearboxes_without_mass:
            models = ", ".join(each.gearboxes_without_mass)
            notes.append(f"mass of {models} not stated: counted as zero")
        if priced and each.joints_without_price:
            notes.append(f"no price of {', '.join(each.joints_without_price)}")
        price = "not stated" if each.price is None else Cell(each.price, "1", stated=True)
        name = design_name(order.axes, each.design)
        rows.append((name, each.mass, *([price] if priced else []), "; ".join(notes)))
    return table(
        "masses",
        "Mass and price of the arm" if priced else "Mass of the arm",
        {"mass": "kg", **({"price": "1"} if priced else {})},
        rows,
        "joints with their gearboxes, links and tool, where stated; without the payload"
        + (". Prices in the currency of the file" if priced else ""),
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
        largest = max(of, key=lambda name: of[name])
        rows.append(
            (
                design_name(order.axes, each.design),
                *(of.get(name, 0.0) for name in shown),
                sum(share for name, share in of.items() if name not in shown),
                "" if largest == shown[0] else f"largest contributor here: {largest}",
            )
        )
    note = "shares of the mean square error; largest contributor over these designs first"
    columns = (*shown, "all others")
    title = "Largest contributors"
    return table("parts", title, columns, rows, note, unit="%", samples=exact)


def _levels(order: Order, chosen: Sequence[Outcome]) -> Section:
    exact = f"exact sum over terms, {several(order.poses, 'pose')}"
    return table(
        "levels",
        "What can be compensated",
        {"r.m.s. error": "m", "load and pose": "%", "robot": "%", "visit": "%"},
        [
            (
                design_name(order.axes, each.design),
                as_length(each, each.figures["rms"], exact),
                *(level / each.rms**2 if each.rms else 0.0 for level in each.levels),
            )
            for each in chosen
        ],
        f"shares of the mean square. Load and pose: {REMEDIES[0]}. Robot: {REMEDIES[1]}. "
        f"Visit: {REMEDIES[2]}" + (f"; {INTERVAL_OF_POSES}" if order.sets > 1 else ""),
        samples=exact,
    )


def _extremes(order: Order, outcomes: Sequence[Outcome], counted: str) -> Section:
    """Return the largest errors of all designs; result.json has those of each design."""
    largest = sorted(
        (each for outcome in outcomes for each in outcome.worst), key=lambda each: -each.error
    )[:_MOST_EXTREMES]
    swept = bool(order.axes)
    rows = [
        (
            (f"{design_name(order.axes, each.design)}, " if swept else "") + f"pose {each.pose}",
            _error(outcomes[each.design], length(each.error)),
            f"robot {each.robot}, visit {each.visit}: "
            f"{_joints(outcomes[each.design].joints, each.q)}"
            + (f"; --design {each.design}" if swept else ""),
        )
        for each in largest
    ]
    return table(
        "extremes",
        "Largest errors",
        ("error",),
        rows,
        "one per pose; `lostmotion replay FOLDER` lists the terms of one",
        samples=f"{counted} each" if swept else counted,
    )


def _joints(joints: Sequence[tuple[str, str]], q: Any) -> str:  # noqa: ANN401 - an array
    return ", ".join(
        joint_value(name, kind, value) for (name, kind), value in zip(joints, q, strict=True)
    )


def _check(order: Order, chosen: Sequence[Outcome]) -> Section:
    each = max(chosen, key=lambda each: share_neglected(each.check, each.p95.value))
    counted = several(each.check.samples, "sample")
    error = each.p95.value
    share, warn = share_neglected(each.check, error), judged(each.check, error)
    where = design_name(order.axes, each.design) if order.axes else ""
    return table(
        "exact_check",
        "First order against exact composition",
        ("value",),
        [
            ("largest difference", as_known(length(each.check.largest), each.known), where),
            ("largest, of the 95th percentile", Cell(share, "%"), warn),
        ],
        samples=counted,
    )


def approach_text(order: Order) -> str:
    """Return how the joints approach a pose."""
    return (
        "each joint approaches from either side at random"
        if not order.approach
        else f"every joint approaches moving {'up' if order.approach > 0 else 'down'}"
    )


def design_cards(
    order: Order, ranked: Sequence[Outcome], outcomes: Sequence[Outcome]
) -> list[Card]:
    """Return the cards of the first screen; `ranked` are the designs whose figures are valid, the
    most accurate first.
    """
    out = []
    ends = zip(
        ("95th percentile, best design", "95th percentile, worst design"),
        (*ranked[:1], *ranked[1:][-1:]),
        strict=False,
    )
    for title, each in ends:
        figure = as_length(each, each.p95)
        named = title if len(ranked) > 1 else "95th percentile of the error"
        name = design_name(order.axes, each.design)
        out.append(_bounded(each, Card(named, str(figure), name, limited_as="error")))
    if len(ranked) > 1:
        out += _best_of_other_figures(order, ranked)
    largest, of = max(((each.worst[0], each) for each in outcomes), key=lambda pair: pair[0].error)
    out.append(
        _bounded(
            of,
            Card(
                "largest error",
                str(as_known(length(largest.error), of.known)),
                f"pose {largest.pose}, robot {largest.robot}, visit {largest.visit}",
                limited_as="error",
            ),
        )
    )
    samples = order.designs * order.poses * order.robots * order.visits
    count = f"{samples / 1e6:.4g} million" if samples >= 1e6 else f"{samples:,}".replace(",", " ")  # noqa: PLR2004 - from here in words
    out.append(Card("samples", count, f"in {several(order.designs * order.blocks, 'block')}"))
    return out


def _best_of_other_figures(order: Order, ranked: Sequence[Outcome]) -> Iterator[Card]:
    """Yield the designs with the smallest repeatability, mass and price, where designs differ in
    it.
    """
    repeats = {each.design: each.rp for each in ranked if each.rp is not None}
    if len({each.value for each in repeats.values()}) > 1:
        best = min(repeats, key=lambda design: repeats[design].value)
        of = next(each for each in ranked if each.design == best)
        yield _bounded(
            of,
            Card(
                f"{rp_name(order.approach)}, best design",
                str(as_length(of, repeats[best])),
                design_name(order.axes, best),
                limited_as="repeatability",
            ),
        )
    if len({each.mass for each in ranked}) > 1:
        lightest = min(ranked, key=lambda each: each.mass)
        yield Card(
            "mass, lightest design",
            str(Cell(lightest.mass, "kg")),
            design_name(order.axes, lightest.design),
        )
    prices = {
        each.design: each.price
        for each in ranked
        if each.price is not None and not each.joints_without_price
    }
    if len(set(prices.values())) > 1:
        cheapest = min(prices, key=lambda design: prices[design])
        yield Card(
            "price, cheapest design",
            stated_text(prices[cheapest]),
            design_name(order.axes, cheapest),
        )


def _bounded(each: Outcome, card: Card) -> Card:
    """Return a card of a design's error with the sign of a bound where it is one."""
    return bounded_cards([card], known_of(each))[0]
