"""Bars of a comparison's first screen: the error of each arm, and the change of the r.m.s. error by
part.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.compare.description import ABSENT
from lostmotion.analyses.compare.tables.figures import figure, measure_of
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import digits, factor_of, unit_of_length
from lostmotion.reporting.arm_sheet import sign_of
from lostmotion.reporting.sheet import Bar, Bars, Cell, in_words, length

if TYPE_CHECKING:
    from lostmotion.analyses.compare.comparison import Change, Comparison, PartChange

# Parts with a bar of their own; further arms whose change is drawn by part; share of the largest
# bar below which a part has none of its own.
_MOST_BARS: Final = 6
_MOST_ARMS: Final = 2
_LEAST: Final = 0.005


def bars(found: Comparison) -> tuple[Bars, ...]:
    """Return the blocks of bars."""
    return (
        *_of_arms(found),
        *(
            block
            for k, change in enumerate(found.changes[:_MOST_ARMS])
            for block in _of_parts(found, change, k)
        ),
    )


def _of_arms(found: Comparison) -> list[Bars]:
    within = measure_of(found, "p95")
    if within is None:
        return []
    sizes = [within.value(each) for each in found.arms]
    effects: list[Cell | None] = [
        None,
        *(figure(change.figures["p95"], "m") for change in found.changes),
    ]
    drawn = tuple(
        Bar(each.label, replace(length(size.value), bound=sign_of(each.known)), size.value, effect)
        for each, size, effect in zip(found.arms, sizes, effects, strict=True)
    )
    return [Bars("changes", "Position error", within.name, drawn, "change")]


def _of_parts(found: Comparison, change: Change, index: int) -> list[Bars]:
    """Return the bars of one arm's change by part; none where no part changes it."""
    largest = max((abs(each.share.value) for each in change.parts), default=0.0)
    if not largest > 0:
        return []
    own = [each for each in change.parts if abs(each.share.value) >= _LEAST * largest]
    own = own if len(own) <= _MOST_BARS + 1 else own[:_MOST_BARS]
    others = [each for each in change.parts if each not in own]
    drawn = [
        Bar(short_name(each.part), length(each.share.value), each.share.value, _sizes(each))
        for each in own
    ]
    rest = sum(each.share.value for each in others)
    if abs(rest) >= _LEAST * largest:
        drawn.append(
            Bar(f"{len(others)} other{'s' if len(others) > 1 else ''}", length(rest), rest)
        )
    several = len(found.changes) > 1
    title = f"What changed the r.m.s. error{f' of {change.arm.label}' if several else ''}"
    return [
        Bars(
            f"parts_shares_{index + 2}" if several else "parts_shares",
            title,
            "change by part",
            tuple(drawn),
            "alone, before → after",
        )
    ]


def _sizes(each: PartChange) -> Cell:
    """Return the r.m.s. error of a part by itself, before and after, in words and in the unit of
    the larger one.
    """
    if each.before is None or each.after is None:
        return in_words(
            " → ".join(
                ABSENT if size is None else str(length(size)) for size in (each.before, each.after)
            )
        )
    unit = unit_of_length(max(each.before, each.after))
    return in_words(
        f"{' → '.join(digits(size * factor_of(unit)) for size in (each.before, each.after))} {unit}"
    )
