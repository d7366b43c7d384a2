"""Headline and first cards of a predicted ISO 9283 sheet."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.iso9283.comparison import over_robots
from lostmotion.analyses.iso9283.tables.labels import estimate_figure, scatter_figure
from lostmotion.error_model.arrival import ANY_APPROACH, ISO_CYCLE
from lostmotion.reporting.arm_sheet import bounded_cards
from lostmotion.reporting.provenance import at_least, caveats, repeats_bounded
from lostmotion.reporting.sheet import Card, Cell

if TYPE_CHECKING:
    from lostmotion.error_model.provenance import States
    from lostmotion.propagation.iso9283.robots import PredictedRobots
    from lostmotion.spatial import Floats

# Scatter from one side that is a smaller share of that from either side is little.
_LITTLE: Final = 0.1


def predicted_verdict(found: PredictedRobots, known: States, either_known: States) -> str:
    """Return the headline: 95th percentile over arms of RP_l and AP_p at the worst pose, with
    bounds where values are limits.

    `known` holds the makers' limits that count in the standard's cycle, `either_known` those for
    joints arriving from either side. Where no described error varies with one side, the figure for
    either side comes first, since zero is no prediction.
    """
    sheet = found.loads[0]
    one, either = _worst_scatter(sheet.repeatability), _worst_scatter(sheet.random_approach)
    accurate, fitted = (
        estimate_figure(over_robots(values.max(axis=0)).high)
        for values in (sheet.accuracy, sheet.fitted)
    )
    from_either = f"{repeats_bounded(either, either_known)}{_interval(either)}"
    worst = "worst of five poses, full payload"
    if not one.words and describes_little_scatter(found):
        text = (
            f"RP_l, {ISO_CYCLE}, of 95 % of arms is at least {one}{_interval(one)}, {worst}: "
            "friction, control and temperature add to "
            f"what is described. RP_l, {ANY_APPROACH}: {from_either}."
        )
    elif not one.words:
        within = _repeats(f"{repeats_bounded(one, known)}{_interval(one)}", ISO_CYCLE, worst)
        text = f"{within}. RP_l, {ANY_APPROACH}: {from_either}."
    elif not either.words:
        text = (
            f"{_repeats(from_either, ANY_APPROACH, worst)}. "
            "In the ISO cycle no described error varies from visit to visit, so no "
            "repeatability is predicted."
        )
    else:
        text = (
            "No described error varies from visit to visit, from either side of approach, so no "
            "repeatability is predicted."
        )
    bound = at_least(accurate, known)
    place = (
        f"{bound}{_interval(accurate)} from"
        if bound.startswith("at least")
        else f"within {bound}{_interval(accurate)} of"
    )
    text += (
        f" AP_p of 95 % of arms is {place} the commanded point at its worst pose, "
        f"{at_least(fitted, known)}{_interval(fitted)} with best-fit frames."
    )
    return " ".join([text, *caveats(known)])


def _repeats(bound: str, arriving: str, worst: str) -> str:
    """Return the clause on RP_l of arms that arrive this way, by its bound with interval."""
    if bound.startswith("at least"):
        return f"RP_l, {arriving}, of 95 % of arms is {bound}, {worst}"
    return f"95 % of arms repeat within {bound}: RP_l, {arriving}, {worst}"


def describes_little_scatter(found: PredictedRobots) -> bool:
    """Return whether the described errors of one side scatter so little that what no file describes
    decides the repeatability.
    """
    sheet = found.loads[0]
    return bool(sheet.repeatability.max() < _LITTLE * sheet.random_approach.max())


def predicted_cards(
    found: PredictedRobots, known: States, either_known: States
) -> tuple[Card, ...]:
    """Return the first cards; arguments as for `predicted_verdict`. A repeatability with a number
    comes first.
    """
    sheet = found.loads[0]
    one = Card(
        f"RP_l, {ISO_CYCLE}",
        str(_worst_scatter(sheet.repeatability)),
        "95 % of arms, worst of five poses",
    )
    either = Card(
        f"RP_l, {ANY_APPROACH}",
        str(_worst_scatter(sheet.random_approach)),
        "95 % of arms, worst pose",
    )
    repeats = (
        *bounded_cards([one], known, ("RP_l",)),
        *bounded_cards([either], either_known, ("RP_l",)),
    )
    if describes_little_scatter(found):
        repeats = (replace(repeats[0], number=_at_least(repeats[0].number)), repeats[1])
    others = [
        Card(
            "AP_p, 95 % of arms",
            str(estimate_figure(over_robots(sheet.accuracy.max(axis=0)).high)),
            "worst of five poses",
        ),
        Card(
            "AP_p, best-fit frames",
            str(estimate_figure(over_robots(sheet.fitted.max(axis=0)).high)),
            "95 % of arms, worst pose",
        ),
        Card("test cube", f"{found.cube.side * 1e3:.0f} mm", "side"),
    ]
    accuracy = bounded_cards(others, known, ("AP_p",))
    numbers, without = (
        [card for card in repeats if (card.number == "none described") == none]
        for none in (False, True)
    )
    return (
        *numbers,
        *(without if numbers else ()),
        *accuracy[:2],
        *(() if numbers else without),
        *accuracy[2:],
    )


def _at_least(number: str) -> str:
    """Return the number of a card as a lower bound; words stay."""
    bare = number.removeprefix("≤ ").removeprefix("≥ ")
    return f"≥ {bare}" if bare[:1].isdigit() else number


def _worst_scatter(values: Floats) -> Cell:
    """Return the 95th percentile over robots of the worst pose, of values (pose, robot) in m."""
    return scatter_figure(over_robots(values.max(axis=0)).high)


def _interval(figure: Cell) -> str:
    """Return the interval of a figure in brackets."""
    return f" ({figure.interval})" if figure.interval else ""
