"""First screen of a study besides its headline: statements, bars of contributors and remedies."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.accuracy.page.budget import repeatability_statement
from lostmotion.analyses.accuracy.page.error import WITHIN_TARGET
from lostmotion.analyses.accuracy.page.zone import WHOLE, outcome, stopped_in
from lostmotion.error_model.remedies import (
    MEASURED,
    OUTPUT_ENCODERS,
    SIDE_AND_LOAD,
    SIDE_KNOWN,
    STAGES,
)
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.propagation.figures import HEADLINE
from lostmotion.propagation.montecarlo import kernel
from lostmotion.reporting.layout import row_at
from lostmotion.reporting.palette import LEVEL_NAMES
from lostmotion.reporting.provenance import (
    as_known,
    at_least,
    headline_names_all,
    missing_kinds,
    share_within_bounded,
    upper_limit_sentences,
)
from lostmotion.reporting.sheet import Bar, Bars, Cell, in_one_unit, length, several

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from lostmotion.accuracy.answer import Answer
    from lostmotion.error_model.budget import Cost
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.holding_torques import HoldingTorque
    from lostmotion.propagation.montecarlo.waterfall import Waterfall
    from lostmotion.reporting.sheet import Section
    from lostmotion.spatial import Floats

# Drives that are named; and a share of the rated torque below which none is.
_MOST_DRIVES: Final = 3
_LEAST_SHARE: Final = 0.1
# Mean length of joint names above which a pose is printed without them.
_LONG_NAMES: Final = 6
_ROUNDING: Final = 1e-9
# µm; a smaller error of adding up is rounding, and its digits say nothing.
_NANOMETRE: Final = 1e-9


def brief_of(
    sections: Sequence[Section], answer: Answer, known: States
) -> tuple[tuple[str, str], ...]:
    """Return the statements of a study by Monte Carlo, each a word and a sentence or two."""
    out = [
        ("RP", repeatability_statement(sections, answer.repeats, answer.arm, known)),
        ("Target", _within_target(sections, answer, known)),
    ]
    for k, zone in enumerate(answer.zones, 1):
        row = row_at(sections, f"zone_{k}", HEADLINE)
        out += (
            [("Zone", zone_sentence(zone.name, as_known(row.cells[0], known), known))]
            if row is not None
            else []
        )
    out += [
        (
            "Where",
            where(answer.arm, answer.poses.q, answer.sampled.per_pose[:, kernel.MEAN], known),
        ),
        ("Drives", drives(answer.arm, answer.worst_torques)),
    ]
    stopped = (
        []
        if answer.stopping is None
        else [f"{outcome(answer.stopping, WHOLE if answer.zones else '')}."]
    )
    out.append(
        (
            "Precision",
            " ".join([*stopped, *(f"{sentence}." for sentence in stopped_in(answer.zones))]),
        )
    )
    checked = answer.sampled.exact
    return tuple(
        (word, text)
        for word, text in (
            *out,
            *trust(known, length(checked.largest) if checked.samples else None),
        )
        if text
    )


def _within_target(sections: Sequence[Section], answer: Answer, known: States) -> str:
    """Return the sentence on the share of positions within the target; empty without one."""
    row = row_at(sections, "error", WITHIN_TARGET)
    if row is None or answer.target is None:
        return ""
    share = row.cells[0]
    counted = f"{share}{f' ({share.interval})' if share.interval else ''} of positions"
    text = share_within_bounded(counted, known)
    return f"{text[0].upper()}{text[1:]} are within {length(answer.target, stated=True)}."


def zone_sentence(name: str, inside: Cell, known: States) -> str:
    """Return the sentence on the error in a zone."""
    within = f"{inside}{f' ({inside.interval})' if inside.interval else ''}"
    return f"In the zone {name} expect 95 % within {at_least(within, known)}."


def where(arm: Arm, q: Floats, mean: Floats, known: States) -> str:
    """Return the mean error (m) at the best and at the worst of the poses q (pose, joint), rad and
    m; empty where all are equal.
    """
    if not np.ptp(mean) > 0:
        return ""
    best, worst = int(mean.argmin()), int(mean.argmax())
    at_best, at_worst = (
        f"{at_least(length(float(mean[k])), known)} at {_joints(arm, q[k])}" for k in (best, worst)
    )
    in_order = "" if _named(arm) else " (joints in order)"
    return f"Best pose: mean {at_best}; worst: {at_worst}{in_order}."


def _named(arm: Arm) -> bool:
    """Return whether joint values are printed with the names of their joints: long names would fill
    the screen.
    """
    return sum(len(joint.name) for joint in arm.driven) <= _LONG_NAMES * len(arm.driven)


def _joints(arm: Arm, q: Floats) -> str:
    """Return joint values to whole degrees and millimetres."""
    texts = []
    named = _named(arm)
    for joint, value in zip(arm.driven, q, strict=True):
        turns = joint.type == "revolute"
        # as a whole number, so that nothing is -0
        whole = round(math.degrees(value) if turns else 1e3 * value)
        texts.append(f"{f'{joint.name} ' if named else ''}{whole}{'°' if turns else ' mm'}")
    return " ".join(texts)


def drives(arm: Arm, worst: Sequence[HoldingTorque]) -> str:
    """Return what the most heavily loaded drives hold, and the share of their rated torque where it
    is stated.
    """
    held = [
        (abs(each.worst) / rated if rated else math.nan, each)
        for each, rated in zip(worst, _ratings(arm), strict=True)
    ]
    known = sorted((each for each in held if math.isfinite(each[0])), key=lambda each: -each[0])
    loaded = [each for each in known if each[0] > _ROUNDING]
    named = [each for each in loaded if each[0] >= _LEAST_SHARE][:_MOST_DRIVES] or loaded[:1]
    texts = [
        f"{_held(each, first=k == 0)}, {Cell(share, '%')}{'' if k else ' of rated'}"
        for k, (share, each) in enumerate(named)
    ]
    rest = [(share, each.joint) for share, each in known if (share, each) not in named]
    least = _ROUNDING * max((abs(each.worst) for each in worst), default=0.0)
    unrated = sorted(
        (each for share, each in held if math.isnan(share) and abs(each.worst) > least),
        key=lambda each: -abs(each.worst),
    )
    if rest and (texts or unrated):
        most = max(share for share, _ in rest)
        others = (
            rest[0][1]
            if len(rest) == 1
            else ("other rated drives" if texts else "rated drives")
            if unrated
            else "others"
        )
        none = f"{others} holds no load" if len(rest) == 1 else f"the {others} hold no load"
        texts.append(f"{others} ≤ {Cell(most, '%')}" if most > _ROUNDING else none)
    if not (texts or unrated):
        return "No drive holds a static load."
    if unrated:
        loads = [_held(each, first=k == 0) for k, each in enumerate(unrated[:_MOST_DRIVES])]
        more = (
            [f"{len(unrated) - _MOST_DRIVES} more with less"] if len(unrated) > _MOST_DRIVES else []
        )
        texts.append(f"{', '.join([*loads, *more])}, no rated torque stated")
    return f"At the poses studied {'; '.join(texts)}."


def _held(drive: HoldingTorque, *, first: bool) -> str:
    return f"{drive.joint}{' holds' if first else ''} {Cell(abs(drive.worst), drive.unit)}"


def _ratings(arm: Arm) -> Iterable[float | None]:
    return (None if joint.gearbox is None else joint.gearbox.rated_torque for joint in arm.driven)


def trust(known: States, first_order: Cell | None = None) -> list[tuple[str, str]]:
    """Return what is stated, assumed and ideal, the makers' limits, and the error (largest of a
    sample) of adding errors to first order.
    """
    stated, assumed = sum(each.state == "stated" for each in known.given), known.assumed_count
    text = (
        f"{several(stated, 'value')} stated, {assumed} "
        f"assumed{'; intervals cover sampling, not what is assumed' if assumed else ''}."
    )
    if not headline_names_all(known):
        text += f" Taken as perfect: {', '.join(missing_kinds(known))}."
    if first_order is not None:
        small = first_order.value < _NANOMETRE
        text += f" First order: exact to {'less than 0.001 µm' if small else first_order}."
    return [("Trust", text), ("Limits", " ".join(upper_limit_sentences(known)))]


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
    costs: Sequence[Cost], gains: Mapping[str, Estimate], counted: str
) -> tuple[Bars, ...]:
    """Return the bars of the largest contributors, with the effect of halving each; none where
    nothing errs.

    costs    contributions of all parts
    gains    reduction of the 95th percentile by halving each part, m; empty where it was not
             computed
    counted  what the shares were counted from
    """
    erring = [cost for cost in costs if cost.alone > 0]
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


def remedy_bars(waterfall: Waterfall) -> tuple[Bars, ...]:
    """Return the bars of what calibration, compensation and a map of each robot leave of the 95th
    percentile, and other remedies where they help.
    """
    counted = (
        f"{several(waterfall.poses, 'pose')} x {several(waterfall.robots, 'robot')} x "
        f"{several(waterfall.visits, 'visit')}"
    )
    # a part of the study's, so the first bar may differ from the answer
    note = f"{_IDEAL}, {several(waterfall.poses, 'pose')}"
    return _remedy_bars(
        "waterfall",
        "95 % of positions within",
        {stage.name: stage.q95 for stage in waterfall.stages},
        counted,
        note,
    )


def rms_bars(estimates: Mapping[str, Estimate], poses: int) -> tuple[Bars, ...]:
    """Return the bars of what the same remedies leave of the root mean square (m) over so many
    poses, without sampling.
    """
    return _remedy_bars(
        "remedies",
        "root mean square error",
        estimates,
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


def _gains(estimates: Sequence[Estimate | None]) -> list[Cell | None]:
    """Return reductions (m) in one unit; none where one was not computed."""
    known = [gain for gain in estimates if gain is not None and math.isfinite(gain.value)]
    shown = iter(in_one_unit([length(gain.value, gain.low, gain.high) for gain in known]))
    return [
        next(shown) if gain is not None and math.isfinite(gain.value) else None
        for gain in estimates
    ]
