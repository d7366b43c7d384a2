"""Headline of a comparison, the statements of its first screen, and its warnings."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.compare.description import ABSENT, WHOLE_JOINT
from lostmotion.analyses.compare.figures import figure, is_decided, measure_of, with_interval
from lostmotion.error_model.arrival import rp_key, rp_name
from lostmotion.error_model.differences import ZERO
from lostmotion.error_model.few_poses import weights_of
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import stated_text
from lostmotion.propagation.exact import FAILS, share_neglected
from lostmotion.reporting.first_order import failure
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.provenance import (
    at_least,
    missing_sentences,
    repeats_bounded,
    upper_limit_sentences,
)
from lostmotion.reporting.sheet import Cell, length, several
from lostmotion.reporting.warnings import few_poses_warnings, overload_warnings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.compare.compared_arm import ComparedArm
    from lostmotion.analyses.compare.comparison import Change, Comparison
    from lostmotion.analyses.compare.description import Difference, StateChange


# Values and states that the first screen names; of more it says how many.
_NAMED: Final = 3


# Share of the change of the r.m.s. error from which a part is named in the headline.
_MOST_OF_IT: Final = 0.5


# Distances that differ by less than this share are equal.
_EQUAL: Final = 1e-6


def verdict(found: Comparison) -> str:
    """Return the headline: how much more or less accurate the other arms are than the first, the
    part that made most of it, and the mass.
    """
    wrong = failing(found)
    if wrong:
        return " ".join(
            f"{each.label}: {failure(each.sampled.exact, within_of(found, each))}" for each in wrong
        )
    if len(found.changes) > 1:
        return _of_many(found)
    change = found.changes[0]
    return " ".join(
        text
        for text in (
            _answer(found, change),
            _apart(found),
            _due_to(change),
            _heavier(change),
            _rests(found),
        )
        if text
    )


def failing(found: Comparison) -> list[ComparedArm]:
    """Return the arms in which the first-order sum of errors fails."""
    return [
        each
        for each in found.arms
        if share_neglected(each.sampled.exact, within_of(found, each)) > FAILS
    ]


def within_of(found: Comparison, each: ComparedArm) -> float:
    """Return the error that 95 % of the positions of an arm stay within, m."""
    measure = measure_of(found, "p95")
    return math.nan if measure is None else measure.value(each).value


def _answer(found: Comparison, change: Change) -> str:
    first, other = found.arms[0], change.arm
    before, after = (
        at_least(length(within_of(found, each)), each.known) for each in (first, other)
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
    apart = length(abs(size.value), *((-size.high, -size.low) if better else (size.low, size.high)))
    word = "more" if better else "less"
    return (
        f"{other.label} is {with_interval(apart)} {word} accurate than {first.label}: 95 % of "
        f"positions within {after} in place of {before}."
    )


def _apart(found: Comparison) -> str:
    """Return the sentence on the distance between the tool points that the arms command at the same
    joint values; empty where it is zero.
    """
    of = [
        (change.arm.label, change.apart)
        for change in found.changes
        if change.apart is not None and not change.apart.is_zero
    ]
    if not of:
        return ""
    first = found.arms[0].label
    if len(found.changes) == 1:
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


def _due_to(change: Change) -> str:
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
    alone, together = (_signed(length(size.value)) for size in (part.share, whole))
    return (
        f"{short_name(part.part)} changes the r.m.s. error by {alone}, all parts together by "
        f"{together}."
    )


def _signed(found: Cell) -> str:
    return f"+{found}" if found.value > 0 else str(found)


def _heavier(change: Change) -> str:
    mass, price = change.figures["mass"].value, change.figures.get("price", ZERO).value
    texts = [f"is {Cell(abs(mass), 'kg')} {'heavier' if mass > 0 else 'lighter'}"] if mass else []
    texts += (
        [f"costs {stated_text(abs(price))} {'more' if price > 0 else 'less'}"]
        if price and math.isfinite(price)
        else []
    )
    return f"It {' and '.join(texts)}." if texts else ""


def _rests(found: Comparison) -> str:
    counts = [each.known.assumed_count for each in found.arms]
    if not any(counts):
        return ""
    texts = [str(count) for count in counts]
    if len(set(counts)) == 1:
        return f"Each of them rests on {several(counts[0], 'assumed value')}."
    return f"They rest on {', '.join(texts[:-1])} and {several(counts[-1], 'assumed value')}."


def _of_many(found: Comparison) -> str:
    """Return the headline of more than two arms: the most accurate one, and the change of each
    against the first.
    """
    best = min(found.arms, key=lambda each: within_of(found, each))
    first = found.arms[0]
    within = at_least(length(within_of(found, best)), best.known)
    texts = []
    for change in found.changes:
        size = change.figures["p95"]
        seen = (
            "equal"
            if change.same
            else _signed(figure(size, "m"))
            if is_decided(size)
            else "no difference seen"
        )
        interval = figure(size, "m").interval
        texts.append(
            f"{change.arm.label} {seen}{f' ({interval})' if interval and not change.same else ''}"
        )
    near = _not_distinguished(found, best)
    if near:
        answer = (
            f"Of {len(found.arms)} arms {best.label} has the smallest error, 95 % of positions "
            f"within {within}; no difference seen from {near}."
        )
    else:
        answer = (
            f"Of {len(found.arms)} arms {best.label} is the most accurate: 95 % of positions "
            f"within {within}."
        )
    return " ".join(
        text
        for text in (
            answer,
            f"Against {first.label}: {'; '.join(texts)}.",
            _apart(found),
            _rests(found),
        )
        if text
    )


def _not_distinguished(found: Comparison, best: ComparedArm) -> str:
    """Return the labels of the arms that are not seen to be less accurate than the best one."""
    measure = measure_of(found, "p95")
    return (
        ""
        if measure is None
        else ", ".join(
            each.label
            for each in found.arms
            if each is not best and not measure.change(best, each).low > 0
        )
    )


def brief(found: Comparison) -> tuple[tuple[str, str], ...]:
    """Return the statements of the first screen, each a word and a sentence or two."""
    out = [
        ("Differs", _differs(found.values)),
        ("Tool points", _tool_points(found)),
        (
            "Repeatability",
            _changed(
                found,
                f"{rp_key(found.approach)}_p95",
                f"{rp_name(found.approach)}: 95 % of the robots repeat within",
                repeats=True,
            ),
        ),
        ("Sag", _changed(found, "sag", "Mean displacement along gravity")),
        ("Mass", _masses(found)),
        ("Price", _prices(found.arms)),
        ("Drives", _drives(found)),
        ("Largest", _largest(found.arms)),
        ("Poses", _poses(found)),
        ("Trust", _trust(found.arms)),
    ]
    return tuple((word, text) for word, text in out if text)


def _differs(values: Sequence[Difference]) -> str:
    if not values:
        return "No value of the descriptions differs."
    # Of a part of another kind nearly every value differs: these come last.
    replaced = {part for each in values if each.key == "kind" for part in each.parts}
    values = sorted(values, key=lambda each: each.key != "kind" and each.parts[0] in replaced)
    texts = [
        f"{each.name}{':' if each.key == WHOLE_JOINT else ''} {' → '.join(each.texts)}"
        for each in values[:_NAMED]
    ]
    left = len(values) - _NAMED
    return (
        "; ".join(texts) + (f"; and {several(left, 'more difference')}" if left > 0 else "") + "."
    )


def _tool_points(found: Comparison) -> str:
    """Return how far the commanded tool points are apart at the same joint values, and where
    most.
    """
    if all(change.apart is None for change in found.changes):
        return ""
    texts = []
    for change in found.changes:
        of = f"{change.arm.label}: " if len(found.changes) > 1 else ""
        if change.apart is None:
            texts.append(f"{of}not compared, because the joint values differ")
        elif change.apart.is_zero:
            texts.append(f"{of}equal")
        else:
            apart = change.apart
            where = joint_values(found.arms[0].arm, found.arms[0].poses.q[apart.largest_at])
            sizes = (
                f"mean {length(apart.mean.value)}, 95th percentile {length(apart.p95.value)}, "
                f"largest {length(apart.largest)}"
            )
            texts.append(f"{of}{sizes} at {where}")
    return f"Distance of the commanded tool points at the same joint values: {'; '.join(texts)}."


def _changed(found: Comparison, key: str, what: str, *, repeats: bool = False) -> str:
    """Return a figure of every arm with its change."""
    measure = measure_of(found, key)
    if measure is None or not any(measure.value(each).value for each in found.arms):
        return ""
    first = figure(measure.value(found.arms[0]), measure.unit)
    texts = [repeats_bounded(first.alone, found.arms[0].known) if repeats else str(first.alone)]
    for change in found.changes:
        size = change.figures[key]
        value = figure(measure.value(change.arm), measure.unit)
        shown = repeats_bounded(value.alone, change.arm.known) if repeats else str(value.alone)
        made = figure(size, measure.unit)
        seen = (
            "equal"
            if not size.value and size.low == size.high
            else f"{_signed(made)}, {made.interval}"
            if is_decided(size)
            else "no difference seen"
        )
        texts.append(f"{shown} ({seen})")
    return f"{what} {' → '.join(texts)}."


def _masses(found: Comparison) -> str:
    masses = [each.arm.mass for each in found.arms]
    if not any(masses):
        return "No mass is stated."
    if len(set(masses)) == 1:
        return f"{Cell(masses[0], 'kg')}, equal."
    return " → ".join(str(Cell(mass, "kg")) for mass in masses) + "."


def _prices(arms: Sequence[ComparedArm]) -> str:
    """Return the prices of all arms, and what lacks one."""
    if all(each.arm.price is None for each in arms):
        return ""
    missing = [
        f"{', '.join(each.arm.joints_without_price)} in {each.label}"
        for each in arms
        if each.arm.joints_without_price
    ]
    prices = " → ".join(
        "not stated" if each.arm.price is None else stated_text(each.arm.price) for each in arms
    )
    return f"{prices} in the currency of the files" + (
        f"; no price is stated for {'; '.join(missing)}." if missing else "."
    )


def _drives(found: Comparison) -> str:
    shares = [each.load for each in found.arms]
    if not any(math.isfinite(share) for share in shares):
        return ""
    texts = [str(Cell(share, "%")) if math.isfinite(share) else ABSENT for share in shares]
    unrated = "" if all(map(math.isfinite, shares)) else f" ({ABSENT}: none is rated)"
    return (
        f"The most loaded drive holds {' → '.join(texts)} of its rated load standing "
        f"still{unrated}."
    )


def _largest(arms: Sequence[ComparedArm]) -> str:
    """Return the largest contributor of each arm."""
    found = [(each.label, each.largest_contributor) for each in arms]
    texts = [
        f"{short_name(largest[0])} in {label}, {Cell(largest[1], '%')} of its mean square"
        for label, largest in found
        if largest is not None
    ]
    return f"Largest contributor: {'; '.join(texts)}." if texts else ""


def _poses(found: Comparison) -> str:
    first = found.arms[0]
    if found.paired:
        return (
            f"All arms stand at the same {several(len(first.poses), 'set')} of joint values."
            if len(first.poses) > 1
            else "All arms stand at the same pose."
        )
    kinds = [[(joint.name, joint.type) for joint in each.arm.driven] for each in found.arms]
    why = (
        "their joints differ"
        if any(other != kinds[0] for other in kinds[1:])
        else "their joint limits differ"
    )
    return f"Each arm has poses over its own joint limits, since {why}."


def _trust(arms: Sequence[ComparedArm]) -> str:
    """Return what is taken as perfect, and the makers' limits, once where it is the same for all
    arms.
    """
    texts: dict[str, list[str]] = {}
    for each in arms:
        text = " ".join([*missing_sentences(each.known), *upper_limit_sentences(each.known)])
        if text:
            texts.setdefault(text, []).append(each.label)
    return " ".join(
        text if len(labels) == len(arms) else f"{', '.join(labels)}: {text}"
        for text, labels in texts.items()
    )


def warnings(found: Comparison) -> tuple[str, ...]:
    """Return what makes the comparison doubtful: errors that only some arms describe, overloaded
    drives, and what seems wrong in a description.
    """
    out = []
    unequal = [each for each in found.states if each.described_in_some_only]
    if unequal:
        out.append(
            f"{_described_unequally(unequal)}: part of the difference is one of the "
            "descriptions, not of the arms"
        )
    for each in found.arms:
        weights = weights_of(each.sampled.visits, each.approach) if each.many else {}
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
    left = len(texts) - _NAMED
    named = ", ".join(texts[:_NAMED]) + (f" and {left} more" if left > 0 else "")
    return f"not every arm describes the same kinds of error ({named})"
