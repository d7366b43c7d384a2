"""Designs of a sweep by mass, price and repeatability, and the cards of the first screen."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.error_model.arrival import rp_name
from lostmotion.printed import stated_text
from lostmotion.reporting.arm_sheet import bounded_cards, sign_of
from lostmotion.reporting.sheet import Card, Cell, Row, Section, in_words, length, several
from lostmotion.runs.design_names import design_name

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.provenance import States
    from lostmotion.runs.job import Order
    from lostmotion.runs.summary import Outcome

LEVEL: Final = 0.95


def as_length(estimate: Estimate, samples: str) -> Cell:
    """Return an estimate (m) in the unit that suits its size."""
    return length(estimate.value, estimate.low, estimate.high, samples)


def known_of(each: Outcome) -> States:
    """Return the states of the kinds of error of a design, with the makers' limits that count in
    it.
    """
    return replace(each.known, limits=each.limits)


def as_error(each: Outcome, estimate: Estimate, samples: str) -> Cell:
    """Return an error of a design, as a lower bound where kinds of error are missing."""
    return replace(as_length(estimate, samples), bound=sign_of(known_of(each)))


def _bounded(each: Outcome, card: Card) -> Card:
    """Return a card of a design's error with the sign of a bound where it is one."""
    return bounded_cards([card], known_of(each), (card.title,))[0]


def masses(order: Order, chosen: Sequence[Outcome]) -> Section:
    """Return the mass of each design, and its price where any is stated."""
    priced = any(each.price is not None for each in chosen)
    rows = []
    for each in chosen:
        price = (
            ()
            if not priced
            else (
                in_words("not stated")
                if each.price is None
                else Cell(each.price, "1", stated=True),
            )
        )
        notes = (
            [f"mass of {', '.join(each.gearboxes_without_mass)} not stated: counted as zero"]
            if each.gearboxes_without_mass
            else []
        )
        notes += (
            [f"no price of {', '.join(each.joints_without_price)}"]
            if priced and each.joints_without_price
            else []
        )
        rows.append(
            Row(
                design_name(order.axes, each.design),
                (Cell(each.mass, "kg"), *price),
                "; ".join(notes),
            )
        )
    about = "joints with their gearboxes, links and tool, where stated; without the payload"
    if priced:
        return Section(
            "masses",
            "Mass and price of the arm",
            ("mass", "price"),
            tuple(rows),
            f"{about}. Prices in the currency of the file",
        )
    return Section("masses", "Mass of the arm", ("mass",), tuple(rows), about)


def _best_of_other_figures(order: Order, ranked: Sequence[Outcome]) -> Iterator[Card]:
    """Yield the designs with the smallest repeatability, mass and price, where designs differ in
    it.
    """
    repeats = {each.design: each.rp[1] for each in ranked if each.rp is not None}
    if len({each.value for each in repeats.values()}) > 1:
        best = min(repeats, key=lambda design: repeats[design].value)
        of = next(each for each in ranked if each.design == best)
        yield _bounded(
            of,
            Card(
                f"{rp_name(order.approach)}, best design",
                str(as_length(repeats[best], "")),
                design_name(order.axes, best),
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


def cards(order: Order, ranked: Sequence[Outcome], outcomes: Sequence[Outcome]) -> list[Card]:
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
        figure = as_length(each.quantiles[LEVEL], "")
        named = title if len(ranked) > 1 else "95th percentile of the error"
        out.append(_bounded(each, Card(named, str(figure), design_name(order.axes, each.design))))
    if len(ranked) > 1:
        out += _best_of_other_figures(order, ranked)
    largest, of = max(((each.worst[0], each) for each in outcomes), key=lambda pair: pair[0].error)
    out.append(
        _bounded(
            of,
            Card(
                "largest error",
                str(length(largest.error)),
                f"pose {largest.pose}, robot {largest.robot}, visit {largest.visit}",
            ),
        )
    )
    samples = order.designs * order.poses * order.robots * order.visits
    count = f"{samples / 1e6:.4g} million" if samples >= 1e6 else f"{samples:,}".replace(",", " ")  # noqa: PLR2004 - from here in words
    out.append(Card("samples", count, f"in {several(order.designs * order.blocks, 'block')}"))
    return out
