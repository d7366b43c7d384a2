"""Headline of a comparison and its warnings."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.compare.page.figures import (
    as_compared,
    figure,
    is_decided,
    measure_of,
    with_interval,
)
from lostmotion.error_model.differences import ZERO
from lostmotion.error_model.few_poses import weights_of
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import stated_text
from lostmotion.propagation.exact import FAILS, share_neglected
from lostmotion.reporting.first_order import failure
from lostmotion.reporting.provenance import (
    at_least,
)
from lostmotion.reporting.sheet import Cell, length, several
from lostmotion.reporting.warnings import few_poses_warnings, overload_warnings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.comparison.compared_arm import ComparedArm
    from lostmotion.comparison.comparison import Change, Comparison
    from lostmotion.comparison.description import StateChange


# Values and states that the first screen names; of more it says how many.
NAMED: Final = 3


# Share of the change of the r.m.s. error from which a part is named in the headline.
_MOST_OF_IT: Final = 0.5


# Distances that differ by less than this share are equal.
_EQUAL: Final = 1e-6


def verdict(comparison: Comparison) -> str:
    """Return the headline: how much more or less accurate the other arms are than the first, the
    part that made most of it, and the mass.
    """
    wrong = failing(comparison)
    if wrong:
        return " ".join(
            f"{each.label}: {failure(each.sampled.exact, within_of(comparison, each))}"
            for each in wrong
        )
    if len(comparison.changes) > 1:
        return _of_many(comparison)
    change = comparison.changes[0]
    return " ".join(
        text
        for text in (
            _answer(comparison, change),
            _apart(comparison),
            _due_to(comparison, change),
            _heavier(change),
            _rests(comparison),
        )
        if text
    )


def failing(comparison: Comparison) -> list[ComparedArm]:
    """Return the arms in which the first-order sum of errors fails."""
    return [
        each
        for each in comparison.arms
        if share_neglected(each.sampled.exact, within_of(comparison, each)) > FAILS
    ]


def within_of(comparison: Comparison, each: ComparedArm) -> float:
    """Return the error that 95 % of the positions of an arm stay within, m."""
    measure = measure_of(comparison, "p95")
    return math.nan if measure is None else measure.value(each).value


def _answer(comparison: Comparison, change: Change) -> str:
    first, other = comparison.arms[0], change.arm
    before, after = (
        at_least(length(within_of(comparison, each)), each.known) for each in (first, other)
    )
    size = change.figures["p95"]
    if change.same:
        return (
            f"No difference: {other.label} and {first.label} have the same error in every sample, "
            f"95 % of positions within {after}."
        )
    if not is_decided(size):
        interval = figure(size, "m").interval
        seen = (
            f"the change lies in {interval} {figure(size, 'm').shown}"
            if interval
            else "too few robots or sets of poses for an interval"
        )
        return (
            f"No difference seen between {other.label} and {first.label}: 95 % of positions within "
            f"{after} and {before}; {seen}."
        )
    better = size.value < 0
    ends = (-size.high, -size.low) if better else (size.low, size.high)
    apart = as_compared(comparison, length(abs(size.value), *ends))
    word = "more" if better else "less"
    return (
        f"{other.label} is {with_interval(apart)} {word} accurate than {first.label}: 95 % of "
        f"positions within {after} in place of {before}."
    )


def _apart(comparison: Comparison) -> str:
    """Return the sentence on the distance between the tool points that the arms command at the same
    joint values; empty where it is zero.
    """
    of = [
        (change.arm.label, change.apart)
        for change in comparison.changes
        if change.apart is not None and not change.apart.is_zero
    ]
    if not of:
        return ""
    first = comparison.arms[0].label
    if len(comparison.changes) == 1:
        apart = of[0][1]
        mean, largest = (str(length(each)) for each in (apart.mean.value, apart.largest))
        size = (
            f"{mean} apart at every pose"
            if np.ptp(apart.distances) <= _EQUAL * apart.largest
            else f"{mean} apart on average, at most {largest}"
        )
        return (
            f"At the same joint values their commanded tool points are {size}; each arm's error is "
            "the deviation from its own."
        )
    texts = ", ".join(f"{label} {length(apart.mean.value)}" for label, apart in of)
    return (
        f"At the same joint values the commanded tool points are apart from those of {first}, on "
        f"average: {texts}."
    )


def _due_to(comparison: Comparison, change: Change) -> str:
    """Return the sentence on the part that made most of the change; empty where none did, or where
    no change was seen.
    """
    whole = change.figures["rms"]
    if not is_decided(change.figures["p95"]) or not change.parts or not whole.value:
        return ""
    part = change.parts[0]
    share = part.share.value / whole.value
    if share < _MOST_OF_IT:
        return ""
    alone, together = (
        signed(as_compared(comparison, length(size.value))) for size in (part.share, whole)
    )
    return (
        f"{short_name(part.part)} changes the r.m.s. error by {alone}, all parts together by "
        f"{together}."
    )


def signed(cell: Cell) -> str:
    """Return a change with its sign."""
    return f"+{cell}" if cell.value > 0 else str(cell)


def _heavier(change: Change) -> str:
    mass, price = change.figures["mass"].value, change.figures.get("price", ZERO).value
    texts = [f"is {Cell(abs(mass), 'kg')} {'heavier' if mass > 0 else 'lighter'}"] if mass else []
    texts += (
        [f"costs {stated_text(abs(price))} {'more' if price > 0 else 'less'}"]
        if price and math.isfinite(price)
        else []
    )
    return f"It {' and '.join(texts)}." if texts else ""


def _rests(comparison: Comparison) -> str:
    counts = [each.known.assumed_count for each in comparison.arms]
    if not any(counts):
        return ""
    texts = [str(count) for count in counts]
    if len(set(counts)) == 1:
        return f"Each of them rests on {several(counts[0], 'assumed value')}."
    return f"They rest on {', '.join(texts[:-1])} and {several(counts[-1], 'assumed value')}."


def _of_many(comparison: Comparison) -> str:
    """Return the headline of more than two arms: the most accurate one, and the change of each
    against the first.
    """
    best = min(comparison.arms, key=lambda each: within_of(comparison, each))
    first = comparison.arms[0]
    within = at_least(length(within_of(comparison, best)), best.known)
    texts = []
    for change in comparison.changes:
        size = change.figures["p95"]
        shown = as_compared(comparison, figure(size, "m"))
        seen = (
            "equal" if change.same else signed(shown) if is_decided(size) else "no difference seen"
        )
        interval = shown.interval
        texts.append(
            f"{change.arm.label} {seen}{f' ({interval})' if interval and not change.same else ''}"
        )
    near = _not_distinguished(comparison, best)
    if near:
        answer = (
            f"Of {len(comparison.arms)} arms {best.label} has the smallest error, 95 % of "
            "positions "
            f"within {within}; no difference seen from {near}."
        )
    else:
        answer = (
            f"Of {len(comparison.arms)} arms {best.label} is the most accurate: 95 % of positions "
            f"within {within}."
        )
    return " ".join(
        text
        for text in (
            answer,
            f"Against {first.label}: {'; '.join(texts)}.",
            _apart(comparison),
            _rests(comparison),
        )
        if text
    )


def _not_distinguished(comparison: Comparison, best: ComparedArm) -> str:
    """Return the labels of the arms that are not seen to be less accurate than the best one."""
    measure = measure_of(comparison, "p95")
    return (
        ""
        if measure is None
        else ", ".join(
            each.label
            for each in comparison.arms
            if each is not best and not measure.change(best, each).low > 0
        )
    )


def warnings(comparison: Comparison) -> tuple[str, ...]:
    """Return what makes the comparison doubtful: errors that only some arms describe, overloaded
    drives, and what seems wrong in a description.
    """
    out = []
    unequal = [each for each in comparison.states if each.described_in_some_only]
    if unequal:
        out.append(
            f"{_described_unequally(unequal)}: part of the difference is one of the "
            "descriptions, not of the arms"
        )
    for each in comparison.arms:
        weights = weights_of(each.sampled.visits, each.approach) if len(each.squares.many) else {}
        few = few_poses_warnings(
            len(each.poses),
            {name: each.squares.root_mean_squares(of) for name, of in weights.items()},
        )
        out += [
            f"{each.label}: {text}"
            for text in (*each.arm.warnings, *overload_warnings(each.overloads), *few)
        ]
    return tuple(out)


def _described_unequally(unequal: Sequence[StateChange]) -> str:
    """Return the clause that names kinds of error that only some of the arms describe, with their
    joints.
    """
    places: dict[str, list[str]] = {}
    for each in unequal:
        places.setdefault(each.kind, []).append(each.place)
    texts = [f"{kind} of {', '.join(of)}" for kind, of in places.items()]
    left = len(texts) - NAMED
    named = ", ".join(texts[:NAMED]) + (f" and {left} more" if left > 0 else "")
    return f"not every arm describes the same kinds of error ({named})"
