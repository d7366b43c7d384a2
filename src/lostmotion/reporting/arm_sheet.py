"""Sheet of results for an arm: what its maker and its file leave open goes with every figure.

The name, the warnings, the remarks and the provenance of an arm's values are the same whatever was
asked of it. So is the sign of a bound at a figure that is one.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from lostmotion.error_model.trust import error_remarks
from lostmotion.error_model.upper_limits import in_error, in_repeats
from lostmotion.reporting.provenance import as_known, provenance_facts, provenance_sections
from lostmotion.reporting.warnings import arm_warnings

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from lostmotion.error_model.poses import Poses
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.sheet import Bars, Card, Cell, Section, Sheet


def with_arm(
    sheet: Sheet,
    arm: Arm,
    known: States,
    *,
    poses: Poses | None = None,
    sections: Sequence[str] = (),
    not_counted: str = "",
) -> Sheet:
    """Return a sheet with what every sheet about an arm has: its name, warnings, remarks, the
    provenance of its values, and the signs of bounds.

    poses        as for `overloads`, which the warnings count
    sections     beginnings of the keys of sections whose figures are bounds where kinds of error
                 are missing
    not_counted  what no figure contains: the first note, and a fact of result.json
    """
    beside = {"not_counted": not_counted} if not_counted else {}
    return replace(
        sheet,
        name=arm.name,
        cards=bounded_cards(sheet.cards, known),
        sections=(
            *bounded_sections(sheet.sections, known, sections),
            *provenance_sections(known),
        ),
        warnings=(*arm_warnings(arm, poses), *sheet.warnings),
        notes=(*beside.values(), *error_remarks(arm), *sheet.notes),
        facts={"arm": arm.name, **sheet.facts, **beside, **provenance_facts(known)},
    )


def bounded_cards(cards: Iterable[Card], known: States) -> tuple[Card, ...]:
    """Return cards, those of errors and of repeatability with the sign of a lower or an upper bound
    where they are one.
    """
    return tuple(
        replace(card, number=_bounded(card, known), limited_as="") if card.limited_as else card
        for card in cards
    )


def bounded_bars(blocks: Iterable[Bars], known: States, keys: Sequence[str]) -> tuple[Bars, ...]:
    """Return blocks of bars, those of these keys with the sign of a lower bound at each figure
    where kinds of error are missing.
    """
    sign = sign_of(known)
    return tuple(_bounded_block(block, sign) if block.key in keys else block for block in blocks)


def bars_as_known(blocks: Iterable[Bars], known: States) -> tuple[Bars, ...]:
    """Return blocks of bars, their lengths with one digit where every drive is assumed."""
    return tuple(
        replace(
            block,
            bars=tuple(
                replace(
                    bar,
                    figure=as_known(bar.figure, known),
                    effect=None if bar.effect is None else as_known(bar.effect, known),
                )
                for bar in block.bars
            ),
        )
        for block in blocks
    )


def _bounded_block(block: Bars, sign: Literal["", "lower"]) -> Bars:
    return replace(
        block,
        bars=tuple(
            bar if bar.figure.words else replace(bar, figure=replace(bar.figure, bound=sign))
            for bar in block.bars
        ),
    )


def bounded_sections(
    sections: Iterable[Section], known: States, keys: Sequence[str]
) -> tuple[Section, ...]:
    """Return sections, those whose keys begin with one of `keys` with one digit where every drive
    is assumed, and as bounds where kinds of error are missing: lengths and angles lower, shares
    upper ones.
    """
    return tuple(
        _bounded_section(section, known) if section.key.startswith(tuple(keys)) else section
        for section in sections
    )


def sections_as_known(
    sections: Iterable[Section],
    known: States,
    shown: Callable[[Cell, States], Cell] = as_known,
) -> tuple[Section, ...]:
    """Return sections, their lengths and angles with one digit where every drive is assumed; with
    `size_as_known`, all their computed figures.
    """
    return tuple(_with_cells(section, lambda each: shown(each, known)) for section in sections)


def _with_cells(section: Section, changed: Callable[[Cell], Cell]) -> Section:
    rows = tuple(replace(row, cells=tuple(map(changed, row.cells))) for row in section.rows)
    return replace(section, rows=rows)


def _bounded_section(section: Section, known: States) -> Section:
    sign = sign_of(known)

    def bounded(figure: Cell) -> Cell:
        figure = as_known(figure, known)
        if not sign or figure.words or figure.stated or not math.isfinite(figure.value):
            return figure
        return (
            replace(figure, bound="lower")
            if figure.unit in {"m", "rad"}
            else replace(figure, bound="upper")
            if figure.shown == "%"
            else figure
        )

    return _with_cells(section, bounded)


def sign_of(known: States) -> Literal["", "lower"]:
    """Return the bound of an error of this arm by what is missing, as a figure has it."""
    return "lower" if known.lower_bound and not in_error(known) else ""


def _bounded(card: Card, known: States) -> str:
    number = card.number.removeprefix("≥ ").removeprefix("≤ ")
    if not number[:1].isdigit():
        return card.number
    counts = in_repeats(known) if card.limited_as == "repeatability" else in_error(known)
    if known.lower_bound:
        return number if counts else f"≥ {number}"
    if counts:
        return number if known.ideal_kinds else f"≤ {number}"
    return card.number
