"""The table of classes of drive, and the headline of an arm whose drives are all assumed, from
classes or presets: figures of one digit.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.accuracy.drive_classes import ClassFigures
from lostmotion.error_model.arrival import rp_key, rp_name
from lostmotion.printed import rounded_length
from lostmotion.reporting.arm_sheet import bars_as_known
from lostmotion.reporting.provenance import at_least, missing_sentences, rests_on_sentences
from lostmotion.reporting.sheet import Cell, Row, Section, length

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.error_model.provenance import States
    from lostmotion.reporting.sheet import Sheet

KEY: Final = "drive_classes"
# The standard's cycle visits every pose from one side.
_RP: Final = rp_name(1.0)
_RP_KEY: Final = rp_key(1.0)
_ANY: Final = rp_name(0.0)
_ANY_KEY: Final = rp_key(0.0)
_HEADS: Final = ("95 % within", _RP, _ANY)
_NOTE: Final = (
    "the same arm with drives of its class and of the neighbouring ones, each joint's drive "
    "for its load; one digit, because every value is "
    "assumed. RP: pose repeatability of ISO 9283, each joint arriving from one side in its "
    "cycle, or from either side at random"
)


def class_section(figures: Sequence[ClassFigures]) -> Section:
    """Return the table of the classes, the arm's own marked."""
    rows = [
        Row(
            f"as {each.name} arm",
            tuple(map(_figure, (each.within, each.repeatability, each.any_approach))),
            "the class of this arm's drives" if each.default else "",
            each.name.replace(" ", "_"),
        )
        for each in figures
    ]
    return Section(KEY, "By class of drive, assumed", _HEADS, tuple(rows), _NOTE)


def class_sentence(figures: Sequence[ClassFigures]) -> str:
    """Return the headline: the range of accuracy and of repeatability between the classes, and the
    figures of the arm's own class.
    """
    own = next(each for each in figures if each.default)
    within, repeats = (
        _range(*ClassFigures.ends(figures, key)) for key in ("within", "repeatability")
    )
    first, last = figures[0].name, figures[-1].name
    return (
        f"Assumed by class of drive, {first} to {last}: expect 95 % of positions within "
        f"{within}, repeatability ({_RP}) of {repeats}; "
        f"as {own.name} arm {rounded_length(own.within)} and {rounded_length(own.repeatability)}."
    )


def with_classes(sheet: Sheet, figures: Sequence[ClassFigures], known: States) -> Sheet:
    """Return the sheet of a study with the table of the classes and their headline, without figures
    of more digits beside it.
    """
    if not figures:
        return sheet
    return replace(
        sheet,
        verdict=" ".join(
            [class_sentence(figures), *missing_sentences(known), *rests_on_sentences(known)]
        ),
        cards=tuple(card for card in sheet.cards if not card.key),
        bars=bars_as_known(sheet.bars, known),
        brief=(
            *class_brief(figures),
            *(each for each in sheet.brief if not each[0].startswith("RP")),
        ),
        sections=(class_section(figures), *sheet.sections),
        facts={**sheet.facts, **class_facts(figures)},
    )


def with_presets(sheet: Sheet, within: float, known: States) -> Sheet:
    """Return the sheet of a study with a headline and bars of one digit (`within`, m), where every
    drive is a preset.
    """
    names = known.presets
    if not names:
        return sheet
    of = f"preset, {names[0]}" if len(names) == 1 else f"presets, {', '.join(names)}"
    expected = at_least(length(within), known)
    sentence = (
        f"Assumed by {of}: expect 95 % of positions within {expected}. It has one digit, because "
        "no drive is stated."
    )
    return replace(
        sheet,
        verdict=" ".join([sentence, *missing_sentences(known), *rests_on_sentences(known)]),
        cards=tuple(card for card in sheet.cards if not card.key),
        bars=bars_as_known(sheet.bars, known),
    )


def class_brief(figures: Iterable[ClassFigures]) -> list[tuple[str, str]]:
    """Return the statements of the first screen: one line for each class."""
    return [("Class", _of_class(each)) for each in figures]


def _of_class(each: ClassFigures) -> str:
    own = " (this one)" if each.default else ""
    return (
        f"as {each.name} arm{own}: 95 % within {rounded_length(each.within)}, {_RP}: "
        f"{rounded_length(each.repeatability)}, {_ANY}: {rounded_length(each.any_approach)}"
    )


def class_facts(figures: Sequence[ClassFigures]) -> dict[str, Any]:
    """Return what result.json holds of the classes, m."""
    return {
        KEY: [
            {
                "class": each.name,
                "within_95": each.within,
                _RP_KEY: each.repeatability,
                _ANY_KEY: each.any_approach,
                "default": each.default,
            }
            for each in figures
        ]
    }


def _figure(value: float) -> Cell:
    return Cell(value, "m", words=rounded_length(value))


def _range(least: float, most: float) -> str:
    """Return the range of lengths with one digit, rounded outward, in one unit where both ends have
    it.
    """
    low, high = rounded_length(least, -1.0), rounded_length(most, 1.0)
    return (
        f"{low.removesuffix(' mm') if high.endswith(' mm') and low.endswith(' mm') else low} to "
        f"{high}"
    )
