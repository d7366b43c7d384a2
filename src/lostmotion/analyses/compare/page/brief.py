"""Statements of the first screen of a comparison."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from lostmotion.analyses.compare.page.figures import (
    SMALLEST,
    as_compared,
    figure,
    is_decided,
    measure_of,
)
from lostmotion.analyses.compare.page.headline import NAMED, signed
from lostmotion.comparison.description import ABSENT, WHOLE_JOINT
from lostmotion.error_model.arrival import rp_key, rp_name
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import stated_text
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.provenance import (
    assumed_drives_sentences,
    missing_sentences,
    repeats_bounded,
    upper_limit_sentences,
)
from lostmotion.reporting.sheet import Cell, length, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.comparison.compared_arm import ComparedArm
    from lostmotion.comparison.comparison import Comparison
    from lostmotion.comparison.description import Difference
    from lostmotion.error_model.intervals import Estimate


def brief(comparison: Comparison) -> tuple[tuple[str, str], ...]:
    """Return the statements of the first screen, each a word and a sentence or two."""
    out = [
        ("Differs", _differs(comparison.values)),
        ("Tool points", _tool_points(comparison)),
        (
            "Repeatability",
            _changed(
                comparison,
                f"{rp_key(comparison.approach)}_p95",
                f"{rp_name(comparison.approach)}: 95 % of the robots repeat within",
                repeats=True,
            ),
        ),
        ("Sag", _changed(comparison, "sag", "Mean displacement along gravity")),
        ("Mass", _masses(comparison)),
        ("Price", _prices(comparison.arms)),
        ("Drives", _drives(comparison)),
        ("Largest", _largest(comparison.arms)),
        ("Poses", _poses(comparison)),
        ("Trust", _trust(comparison.arms)),
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
        for each in values[:NAMED]
    ]
    left = len(values) - NAMED
    return (
        "; ".join(texts) + (f"; and {several(left, 'more difference')}" if left > 0 else "") + "."
    )


def _tool_points(comparison: Comparison) -> str:
    """Return how far the commanded tool points are apart at the same joint values, and where
    most.
    """
    if all(change.apart is None for change in comparison.changes):
        return ""
    texts = []
    for change in comparison.changes:
        of = f"{change.arm.label}: " if len(comparison.changes) > 1 else ""
        if change.apart is None:
            texts.append(f"{of}not compared, because the joint values differ")
        elif change.apart.is_zero:
            texts.append(f"{of}equal")
        else:
            apart = change.apart
            where = joint_values(
                comparison.arms[0].arm, comparison.arms[0].poses.q[apart.largest_at]
            )
            sizes = (
                f"mean {length(apart.mean.value)}, 95th percentile {length(apart.p95.value)}, "
                f"largest {length(apart.largest)}"
            )
            texts.append(f"{of}{sizes} at {where}")
    return f"Distance of the commanded tool points at the same joint values: {'; '.join(texts)}."


def _changed(comparison: Comparison, key: str, what: str, *, repeats: bool = False) -> str:
    """Return a figure of every arm with its change."""
    measure = measure_of(comparison, key)
    if measure is None or not any(measure.value(each).value for each in comparison.arms):
        return ""

    def shown_as(size: Estimate) -> Cell:
        return as_compared(comparison, figure(size, measure.unit))

    first = shown_as(measure.value(comparison.arms[0]))
    texts = [
        repeats_bounded(first.alone, comparison.arms[0].known) if repeats else str(first.alone)
    ]
    for change in comparison.changes:
        size = change.figures[key]
        value = shown_as(measure.value(change.arm))
        shown = repeats_bounded(value.alone, change.arm.known) if repeats else str(value.alone)
        made = shown_as(size)
        seen = (
            "equal"
            if not size.value and size.low == size.high
            else "change below 0.001 µm"
            if measure.unit == "m" and max(abs(size.low), abs(size.high)) < SMALLEST
            else f"{signed(made)}{f', {made.interval}' if made.interval else ''}"
            if is_decided(size)
            else "no difference seen"
        )
        texts.append(f"{shown} ({seen})")
    return f"{what} {' → '.join(texts)}."


def _masses(comparison: Comparison) -> str:
    masses = [each.arm.mass for each in comparison.arms]
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


def _drives(comparison: Comparison) -> str:
    shares = [each.load for each in comparison.arms]
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


def _poses(comparison: Comparison) -> str:
    first = comparison.arms[0]
    if comparison.paired:
        return (
            f"All arms stand at the same {several(len(first.poses), 'set')} of joint values."
            if len(first.poses) > 1
            else "All arms stand at the same pose."
        )
    kinds = [[(joint.name, joint.type) for joint in each.arm.driven] for each in comparison.arms]
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
        text = " ".join(
            [
                *assumed_drives_sentences(each.known),
                *missing_sentences(each.known),
                *upper_limit_sentences(each.known),
            ]
        )
        if text:
            texts.setdefault(text, []).append(each.label)
    return " ".join(
        text if len(labels) == len(arms) else f"{', '.join(labels)}: {text}"
        for text, labels in texts.items()
    )
