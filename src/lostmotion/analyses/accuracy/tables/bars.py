"""Bars of a study's first screen: the largest contributors, and what each remedy leaves."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.error_model.remedies import (
    MEASURED,
    OUTPUT_ENCODERS,
    SIDE_AND_LOAD,
    SIDE_KNOWN,
    STAGES,
)
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.palette import LEVEL_NAMES
from lostmotion.reporting.sheet import Bar, Bars, Cell, in_one_unit, length, several

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.error_model.budget import Cost
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.propagation.montecarlo.waterfall import Waterfall

# Parts with a bar of their own; the others share one.
_MOST_BARS: Final = 5
_HALVING: Final = "reduction if halved"
# Real remedies leave more.
_IDEAL: Final = "ideal remedies"
# Each stage of the waterfall as a bar names it, in the waterfall's order; then those that have one
# only where they help.
_STAGES: Final = dict(
    zip(
        STAGES,
        ("as manufactured", "calibrated", "load compensated", "both", "and each robot mapped"),
        strict=True,
    )
)
_WHERE_THEY_HELP: Final = {
    SIDE_KNOWN: "side of arrival known",
    SIDE_AND_LOAD: "side and load known",
    OUTPUT_ENCODERS: "output encoders",
}
_HELPS: Final = 0.05


def blame_bars(
    found: Sequence[Cost], gains: Mapping[str, Estimate], counted: str
) -> tuple[Bars, ...]:
    """Return the bars of the largest contributors, with the effect of halving each; none where
    nothing errs.

    found    contributions of all parts
    gains    reduction of the 95th percentile by halving each part, m; empty where it was not
             computed
    counted  what the shares were counted from
    """
    erring = [cost for cost in found if cost.alone > 0]
    if not erring:
        return ()
    own = sorted(erring, key=lambda cost: -abs(cost.share))[
        : _MOST_BARS if len(erring) > _MOST_BARS + 1 else len(erring)
    ]
    named = {cost.part for cost in own}
    others = [cost for cost in erring if cost.part not in named]
    own.sort(key=lambda cost: -cost.share)
    taken = _gains([gains.get(cost.part) for cost in own])
    bars = [
        Bar(short_name(cost.part), _share(cost.share, counted), cost.share, gain, cost.levels)
        for cost, gain in zip(own, taken, strict=True)
    ]
    if others:
        together = sum(cost.share for cost in others)
        levels = tuple(sum(cost.levels[k] for cost in others) for k in range(len(LEVEL_NAMES)))
        bars.append(
            Bar(
                f"{several(len(others), 'other')}",
                _share(together, counted),
                together,
                None,
                levels,
            )
        )
    note = (
        "a negative share cancels part of the others" if any(bar.size < 0 for bar in bars) else ""
    )
    return (
        Bars(
            "budget",
            "Which part is to blame",
            "share of the mean square",
            tuple(bars),
            _HALVING if gains else "",
            LEVEL_NAMES,
            note,
        ),
    )


def remedy_bars(found: Waterfall) -> tuple[Bars, ...]:
    """Return the bars of what calibration, compensation and a map of each robot leave of the 95th
    percentile, and other remedies where they help.
    """
    counted = (
        f"{several(found.poses, 'pose')} x {several(found.robots, 'robot')} x "
        f"{several(found.visits, 'visit')}"
    )
    # a part of the study's, so the first bar may differ from the answer
    note = f"{_IDEAL}, {several(found.poses, 'pose')}"
    return _remedy_bars(
        "waterfall",
        "95 % of positions within",
        {stage.name: stage.q95 for stage in found.stages},
        counted,
        note,
    )


def rms_bars(found: Mapping[str, Estimate], poses: int) -> tuple[Bars, ...]:
    """Return the bars of what the same remedies leave of the root mean square (m) over so many
    poses, without sampling.
    """
    return _remedy_bars(
        "remedies",
        "root mean square error",
        found,
        f"exact sum over terms, {several(poses, 'pose')}",
        _IDEAL,
    )


def _remedy_bars(
    key: str, column: str, left: Mapping[str, Estimate], counted: str, note: str
) -> tuple[Bars, ...]:
    """Return the bars of what remains at each stage, m, those of other remedies where they help;
    none where nothing errs.
    """
    if not left[STAGES[0]].value > 0:
        return ()
    first, *others = _STAGES
    measured = {MEASURED: MEASURED} if MEASURED in left else {}
    names = {
        first: _STAGES[first],
        **measured,
        **{stage: _STAGES[stage] for stage in others},
        **{name: text for name, text in _WHERE_THEY_HELP.items() if _helps(left, name)},
    }
    figures = in_one_unit(
        [length(left[name].value, left[name].low, left[name].high, counted) for name in names]
    )
    bars = tuple(
        # a zero is one of the errors that the file describes, not of the arm
        Bar(
            label, figure if figure.value else replace(figure, words="none described"), figure.value
        )
        for label, figure in zip(names.values(), figures, strict=True)
    )
    return (Bars(key, "What can be done about it", column, bars, note=note),)


def _helps(left: Mapping[str, Estimate], name: str) -> bool:
    """Return whether a remedy leaves a twentieth less of the error than those that it adds to, or
    would replace, do.
    """
    instead = {
        SIDE_KNOWN: STAGES[:1],
        SIDE_AND_LOAD: ("load compensated", SIDE_KNOWN),
        OUTPUT_ENCODERS: STAGES[:-1],
    }[name]
    return (
        min(left[each].value for each in instead) - left[name].value
        >= _HELPS * left[STAGES[0]].value
    )


def _share(share: float, counted: str) -> Cell:
    return Cell(share, "%", samples=counted)


def _gains(found: Sequence[Estimate | None]) -> list[Cell | None]:
    """Return reductions (m) in one unit; none where one was not computed."""
    known = [gain for gain in found if gain is not None and math.isfinite(gain.value)]
    shown = iter(in_one_unit([length(gain.value, gain.low, gain.high) for gain in known]))
    return [
        next(shown) if gain is not None and math.isfinite(gain.value) else None for gain in found
    ]
