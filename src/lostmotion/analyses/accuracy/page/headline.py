"""The headline of a study: the error of 95 % of positions, the remedy that takes most off it, and
what is assumed or missing.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from lostmotion.error_model.remedies import ALL_KNOWN, OUTPUT_ENCODERS, SIDE_AND_LOAD, SIDE_KNOWN
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.provenance import (
    at_least,
    error_sentence,
    rests_on_sentences,
    zero_error_sentence,
)
from lostmotion.reporting.sheet import Cell, length

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.budget import Budget, Cost
    from lostmotion.error_model.overload import Overload
    from lostmotion.error_model.provenance import States
    from lostmotion.propagation.montecarlo.waterfall import Waterfall, WaterfallStep

# Where the mean square comes from, by its largest level.
_ORIGINS: Final = ("follows {}", "differs from robot to robot", "differs from visit to visit")
# A remedy is named where it removes a tenth of the 95 % error, a further one where it removes a
# twentieth more.
_WORTHWHILE: Final = 0.1
_FURTHER: Final = 0.05


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
