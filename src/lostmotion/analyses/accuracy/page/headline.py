"""The headline of a study: the error of 95 % of positions, the remedy that takes most off it, and
what is assumed or missing; of an arm whose drives are all assumed, from classes or presets, figures
of one digit, with the table of classes of drive.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.accuracy.drive_classes import ClassFigures
from lostmotion.error_model.arrival import rp_key, rp_name
from lostmotion.error_model.remedies import ALL_KNOWN, OUTPUT_ENCODERS, SIDE_AND_LOAD, SIDE_KNOWN
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import rounded_length
from lostmotion.reporting.arm_sheet import bars_as_known
from lostmotion.reporting.provenance import (
    at_least,
    error_sentence,
    missing_sentences,
    rests_on_sentences,
    zero_error_sentence,
)
from lostmotion.reporting.sheet import Cell, Row, Section, length

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.error_model.budget import Budget, Cost
    from lostmotion.error_model.overload import Overload
    from lostmotion.error_model.provenance import States
    from lostmotion.propagation.montecarlo.waterfall import Waterfall, WaterfallStep
    from lostmotion.reporting.sheet import Sheet

# Where the mean square comes from, by its largest level.
_ORIGINS: Final = ("follows {}", "differs from robot to robot", "differs from visit to visit")
# A remedy is named where it removes a tenth of the 95 % error, a further one where it removes a
# twentieth more.
_WORTHWHILE: Final = 0.1
_FURTHER: Final = 0.05
_CLASSES: Final = "drive_classes"
# The standard's cycle visits every pose from one side.
_RP: Final = rp_name(1.0)
_RP_KEY: Final = rp_key(1.0)
_ANY: Final = rp_name(0.0)
_ANY_KEY: Final = rp_key(0.0)
_CLASS_HEADS: Final = ("95 % within", _RP, _ANY)
_CLASSES_NOTE: Final = (
    "the same arm with drives of its class and of the neighbouring ones, each joint's drive "
    "for its load; one digit, because every value is "
    "assumed. RP: pose repeatability of ISO 9283, each joint arriving from one side in its "
    "cycle, or from either side at random"
)


def headline(
    within: Cell, bands: str, remedy: str, known: States, overloaded: Sequence[Overload]
) -> str:
    """Return the headline in one to three sentences.

    within      95th percentile of the position error
    bands       the clause on values that are known only as ranges; empty without any
    remedy      the sentence on the remedy that takes most; empty where there is none to name
    overloaded  drives that hold more than they are rated for: the prediction assumes that they hold
    """
    if within.value == 0:
        return " ".join([zero_error_sentence(known), *rests_on_sentences(known)])
    text = f"{within}{f' ({within.interval})' if within.interval else ''}"
    answer = on_condition(error_sentence(text, known), overloaded)
    if bands:
        answer = f"{answer.removesuffix('.')}; {bands}."
    return " ".join(each for each in (answer, remedy, *rests_on_sentences(known)) if each)


def on_condition(sentence: str, overloaded: Sequence[Overload]) -> str:
    """Return a sentence that holds only where overloaded drives hold, with this condition before
    it.
    """
    if not overloaded:
        return sentence
    names = [each.joint for each in overloaded]
    drives = (
        f"drive of {names[0]} holds"
        if len(names) == 1
        else f"drives of {', '.join(names[:-1])} and {names[-1]} hold"
    )
    return f"If the overloaded {drives}, {sentence[0].lower()}{sentence[1:]}"


def remedy_sentence(
    blame: Budget, waterfall: Waterfall, known: States, *, temperature: bool
) -> str:
    """Return where most of the mean square comes from, the largest contributor, and what the best
    remedy leaves of the 95 % error.
    """
    stages = {stage.name: stage for stage in waterfall.stages}
    if not stages["as manufactured"].q95.value > 0:
        return ""
    return (
        f"{_origin(blame, temperature=temperature)}; "
        f"{_remedy(stages, _compensation(blame, temperature=temperature), known)}."
    )


def rms_remedy_sentence(blame: Budget, known: States, *, temperature: bool) -> str:
    """Return the same without sampling: what compensation leaves of the root mean square."""
    if not blame.rms > 0:
        return ""
    left = blame.rms_interval(1, 2).value
    if left > (1 - _FURTHER) * blame.rms:
        return (
            f"{_origin(blame, temperature=temperature)}; compensation of load and pose does not "
            "reduce it."
        )
    of = (
        f"{at_least(length(left), known)} r.m.s. of {length(blame.rms)}"
        if left > 0
        else _nothing(known)
    )
    return (
        f"{_origin(blame, temperature=temperature)}; "
        f"{_compensation(blame, temperature=temperature)} leaves {of}."
    )


def _most(blame: Budget) -> int:
    return max(range(3), key=lambda level: blame.levels[level])


def _origin(blame: Budget, *, temperature: bool) -> str:
    most = _most(blame)
    share = Cell(blame.levels[most], "%")
    return (
        f"{share} of the mean square {_ORIGINS[most].format(_known(temperature=temperature))} "
        f"(largest contributor: {_largest(blame.parts)})"
    )


def _known(*, temperature: bool) -> str:
    return "load, pose and temperature" if temperature else "load and pose"


def _compensation(blame: Budget, *, temperature: bool) -> str:
    """Return the name of the remedy; load and pose are named once, where the sentence begins with
    them.
    """
    return (
        "a controller that knows "
        f"{'them' if _most(blame) == 0 else _known(temperature=temperature)}"
    )


def _largest(parts: Sequence[Cost]) -> str:
    part = parts[0]
    return f"{short_name(part.part)}, {Cell(part.share, '%')}"


def _remedy(stages: dict[str, WaterfallStep], compensation: str, known: States) -> str:
    """Return the clause on the remedies: the best one of a controller or a calibration, what each
    further one removes, or else other parts.
    """
    single = {
        "load compensated": compensation,
        "calibrated": "calibration of each robot",
        SIDE_KNOWN: "a controller that knows the side of arrival",
    }
    best = min(single, key=lambda name: stages[name].q95.value)
    if _taken(stages, stages[best]) >= _WORTHWHILE:
        return ", ".join(
            [f"{single[best]} leaves {_left(stages[best], known)}", *_further(stages, best, known)]
        )
    together = (
        ("both", f"calibration and {compensation} together help: they leave"),
        (SIDE_AND_LOAD, f"{compensation}, and the side of arrival, helps: it leaves"),
        (
            "both, and each robot mapped",
            f"a map of each robot helps: with {compensation} it leaves",
        ),
        (OUTPUT_ENCODERS, "encoders on the outputs help: they leave"),
        (
            ALL_KNOWN,
            f"a map of each robot helps: with {compensation}, and the side of arrival, it leaves",
        ),
    )
    for name, helps in together:
        if _taken(stages, stages[name]) >= _WORTHWHILE:
            return f"only {helps} {_left(stages[name], known)}"
    most = max(_taken(stages, stage) for stage in stages.values())
    if most > 0:
        return (
            "no remedy (calibration, compensation, a known side, output encoders) removes more "
            f"than {Cell(most, '%')} of the 95 % error"
        )
    return "no remedy (calibration, compensation, a known side, output encoders) reduces it"


def _further(stages: dict[str, WaterfallStep], best: str, known: States) -> list[str]:
    """Return the clauses on remedies that remove more after the best one."""
    side = ("the side of arrival", SIDE_AND_LOAD)
    first = {
        "load compensated": (("calibration", "both"), side),
        "calibrated": (("compensation of the load", "both"),),
        SIDE_KNOWN: (("load and pose", SIDE_AND_LOAD),),
    }[best]
    what, name = min(first, key=lambda each: stages[each[1]].q95.value)
    last, out = best, []
    if _gained(stages, stages[last], stages[name]):
        out.append((what, stages[name]))
        last = name
    mapped = stages[
        ALL_KNOWN if last in {SIDE_KNOWN, SIDE_AND_LOAD} else "both, and each robot mapped"
    ]
    before = (
        stages[last]
        if last in {SIDE_KNOWN, SIDE_AND_LOAD}
        else min(stages[last], stages["both"], key=_q95)
    )
    if _gained(stages, before, mapped):
        out.append(("a map of each robot", mapped))
    return [f"with {what} as well {_left(stage, known)}" for what, stage in out]


def _q95(stage: WaterfallStep) -> float:
    return stage.q95.value


def _taken(stages: dict[str, WaterfallStep], stage: WaterfallStep) -> float:
    """Return the share of the 95 % error that is removed at a stage; zero where the interval of the
    reduction contains zero.
    """
    if stage.reduction.low < 0:  # false where few robots determine no interval
        return 0.0
    return stage.reduction.value / stages["as manufactured"].q95.value


def _gained(stages: dict[str, WaterfallStep], before: WaterfallStep, after: WaterfallStep) -> bool:
    return before.q95.value - after.q95.value >= _FURTHER * stages["as manufactured"].q95.value


def _left(stage: WaterfallStep, known: States) -> str:
    """Return what a stage leaves, in three digits, as a bound where kinds of error are missing: its
    interval is in the table.
    """
    value = stage.q95.value
    return at_least(length(value), known) if value > 0 and math.isfinite(value) else _nothing(known)


def _nothing(known: States) -> str:
    """Return what a remedy leaves that removes every error described: errors add to first order,
    and what is not described stays.
    """
    return f"no {'described ' if known.lower_bound else ''}error to first order"


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
    return Section(_CLASSES, "By class of drive, assumed", _CLASS_HEADS, tuple(rows), _CLASSES_NOTE)


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
        _CLASSES: [
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
