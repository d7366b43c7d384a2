"""ISO 9283 sheet: headline, cards, tables and notes of predicted robots, of a measured one, or of
both.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.iso9283.page.labels import (
    NO_SCATTER,
    WORDS,
    estimate_figure,
    scatter_figure,
)
from lostmotion.analyses.iso9283.page.measured import measured_facts, measured_sections
from lostmotion.analyses.iso9283.page.measured_figures import comparison_sections
from lostmotion.analyses.iso9283.page.measured_headline import (
    measured_cards,
    measured_counts,
    measured_notes,
    measured_verdict,
    measured_warnings,
)
from lostmotion.analyses.iso9283.page.predicted import predicted_sections
from lostmotion.error_model.arrival import ANY_APPROACH, ISO_CYCLE
from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.propagation.iso9283.cube import NAMES
from lostmotion.reporting.arm_sheet import bounded_cards, with_arm
from lostmotion.reporting.first_order import checked, failure
from lostmotion.reporting.provenance import as_known, at_least, caveats, repeats_bounded
from lostmotion.reporting.sheet import Card, Cell, Sheet, several
from lostmotion.standards.comparison import over_robots

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.warm_up import Drift
    from lostmotion.propagation.iso9283.cube import CommandedPoses
    from lostmotion.propagation.iso9283.robots import PredictedRobots
    from lostmotion.spatial import Floats
    from lostmotion.standards.comparison import ComparedFigure
    from lostmotion.standards.measured_robot import MeasuredRobot

# Scatter from one side that is a smaller share of that from either side is little.
_LITTLE: Final = 0.1
# Sections of which every length is an error of the predicted robots.
_BOUNDED: Final = ("ap", "fitted", "rp", "either", "axes", "positioning", "vap", "distance", "path")
# With fewer robots than this, fewer than three lie above the 95th percentile.
_FEW: Final = 60
_CUBE: Final = "test cube"
_SAME: Final = "The same files, version and seed give the same bytes."


def iso_sheet(
    predicted: PredictedRobots | None,
    drifted: Drift | None,
    measured: MeasuredRobot | None,
    compared: Sequence[ComparedFigure],
    commanded: CommandedPoses | None,
) -> Sheet:
    """Return the sheet of predicted robots, of a measured one, or of both side by side; arguments
    as the members of `Iso9283`.
    """
    both = None
    if measured is not None:
        both = _measured_sheet(measured, predicted, compared, commanded)
    if predicted is None:
        return both or Sheet(subject="ISO 9283 sheet")
    arm, check, side = predicted.arm, predicted.check, predicted.approach
    known = with_limits(states(arm), arm, predicted.cube.q, side)
    # More limits count in the scatter from either side than in that from one side.
    either_known = with_limits(states(arm), arm, predicted.cube.q)
    failed = failure(check, check.length)
    counted = (
        f"{several(predicted.robots, 'robot')} x {several(predicted.cycles, 'cycle')} x 5 "
        f"poses, seed {predicted.seed}"
    )
    sheet = Sheet(
        subject="ISO 9283 sheet",
        verdict=_predicted_verdict(predicted, known, either_known),
        cards=_predicted_cards(predicted, known, either_known),
        sections=tuple(predicted_sections(predicted, drifted)),
        counts=counted,
        notes=tuple(_remarks(predicted)),
        words=WORDS,
        source=f"{counted}. {_SAME}",
        seed=predicted.seed,
        facts=_facts(predicted),
    )
    if both is None:
        sheet = with_arm(sheet, arm, known, sections=_BOUNDED)
        return checked(sheet, check, check.length, arm)
    counted = f"{counted}; {both.counts}"
    sheet = with_arm(
        replace(
            sheet,
            verdict=f"{both.verdict} {_beside(predicted, commanded)}: {sheet.verdict}",
            cards=(
                *both.cards,
                *(
                    card
                    if commanded is None or card.title == _CUBE
                    else replace(card, title=f"{card.title}, {_CUBE}")
                    for card in sheet.cards
                ),
            ),
            sections=(*both.sections, *sheet.sections),
            counts=counted,
            warnings=both.warnings,
            notes=(*sheet.notes, *both.notes),
            source=f"{counted}. {_SAME}",
            facts={**sheet.facts, **both.facts},
        ),
        arm,
        known,
        sections=_BOUNDED,
    )
    return replace(sheet, notes=(failed, *sheet.notes)) if failed else sheet


def _measured_sheet(
    measured: MeasuredRobot,
    predicted: PredictedRobots | None,
    compared: Sequence[ComparedFigure],
    commanded: CommandedPoses | None,
) -> Sheet:
    """Return the sheet of a measured robot, with the comparison where there is one."""
    counted = measured_counts(measured)
    return Sheet(
        subject="ISO 9283 sheet",
        name="Measured robot",
        verdict=measured_verdict(measured, compared, commanded),
        cards=tuple(measured_cards(measured, compared)),
        sections=(*comparison_sections(compared), *measured_sections(measured)),
        counts=counted,
        warnings=measured_warnings(measured, predicted),
        notes=measured_notes(measured, predicted, commanded, compared=bool(compared)),
        words=WORDS,
        source=f"{counted}. {_SAME}",
        facts=measured_facts(measured, compared),
    )


def _beside(predicted: PredictedRobots, commanded: CommandedPoses | None) -> str:
    """Return what leads to the predicted figures beside measured ones: they are those of a test
    cube, which need not have the poses of the measured file.
    """
    where = "Predicted in the" if commanded is None else "Not compared, predicted in a"
    return f"{where} test cube of {predicted.cube.side * 1e3:.0f} mm"


def _predicted_verdict(predicted: PredictedRobots, known: States, either_known: States) -> str:
    """Return the headline: 95th percentile over arms of RP_l and AP_p at the worst pose, with
    bounds where values are limits.

    `known` holds the makers' limits that count in the standard's cycle, `either_known` those for
    joints arriving from either side. Where no described error varies with one side, the figure for
    either side comes first, since zero is no prediction.
    """
    sheet = predicted.loads[0]
    one, either = (
        _worst_scatter(values, known) for values in (sheet.repeatability, sheet.random_approach)
    )
    accurate, fitted = (
        as_known(estimate_figure(over_robots(values.max(axis=0)).high), known)
        for values in (sheet.accuracy, sheet.fitted)
    )
    from_either = f"{repeats_bounded(either, either_known)}{_interval(either)}"
    worst = "worst of five poses, full payload"
    if not one.words and _describes_little_scatter(predicted):
        text = (
            f"RP_l, {ISO_CYCLE}, of 95 % of arms is at least {one}{_interval(one)}, {worst}: "
            "friction, control and temperature add to "
            f"what is described. RP_l, {ANY_APPROACH}: {from_either}."
        )
    elif not one.words:
        within = _repeats(f"{repeats_bounded(one, known)}{_interval(one)}", ISO_CYCLE, worst)
        text = f"{within}. RP_l, {ANY_APPROACH}: {from_either}."
    elif not either.words:
        text = (
            f"{_repeats(from_either, ANY_APPROACH, worst)}. "
            "In the ISO cycle no described error varies from visit to visit, so no "
            "repeatability is predicted."
        )
    else:
        text = (
            "No described error varies from visit to visit, from either side of approach, so no "
            "repeatability is predicted."
        )
    bound = at_least(accurate, known)
    place = (
        f"{bound}{_interval(accurate)} from"
        if bound.startswith("at least")
        else f"within {bound}{_interval(accurate)} of"
    )
    text += (
        f" AP_p of 95 % of arms is {place} the commanded point at its worst pose, "
        f"{at_least(fitted, known)}{_interval(fitted)} with best-fit frames."
    )
    return " ".join([text, *caveats(known)])


def _repeats(bound: str, arriving: str, worst: str) -> str:
    """Return the clause on RP_l of arms that arrive this way, by its bound with interval."""
    if bound.startswith("at least"):
        return f"RP_l, {arriving}, of 95 % of arms is {bound}, {worst}"
    return f"95 % of arms repeat within {bound}: RP_l, {arriving}, {worst}"


def _describes_little_scatter(predicted: PredictedRobots) -> bool:
    """Return whether the described errors of one side scatter so little that what no file describes
    decides the repeatability.
    """
    sheet = predicted.loads[0]
    return bool(sheet.repeatability.max() < _LITTLE * sheet.random_approach.max())


def _predicted_cards(
    predicted: PredictedRobots, known: States, either_known: States
) -> tuple[Card, ...]:
    """Return the first cards; arguments as for `_predicted_verdict`. A repeatability with a number
    comes first.
    """
    sheet = predicted.loads[0]
    one, either = (
        Card(
            f"RP_l, {arriving}",
            str(_worst_scatter(values, known)),
            f"95 % of arms, {pose}",
            limited_as="repeatability",
        )
        for arriving, values, pose in (
            (ISO_CYCLE, sheet.repeatability, "worst of five poses"),
            (ANY_APPROACH, sheet.random_approach, "worst pose"),
        )
    )
    repeats = (*bounded_cards([one], known), *bounded_cards([either], either_known))
    if _describes_little_scatter(predicted):
        repeats = (replace(repeats[0], number=_at_least(repeats[0].number)), repeats[1])
    accurate, fitted = (
        str(as_known(estimate_figure(over_robots(values.max(axis=0)).high), known))
        for values in (sheet.accuracy, sheet.fitted)
    )
    accuracy = bounded_cards(
        [
            Card("AP_p, 95 % of arms", accurate, "worst of five poses", limited_as="error"),
            Card("AP_p, best-fit frames", fitted, "95 % of arms, worst pose", limited_as="error"),
            Card(_CUBE, f"{predicted.cube.side * 1e3:.0f} mm", "side"),
        ],
        known,
    )
    numbers, without = (
        [card for card in repeats if (card.number == "none described") == none]
        for none in (False, True)
    )
    return (
        *numbers,
        *(without if numbers else ()),
        *accuracy[:2],
        *(() if numbers else without),
        *accuracy[2:],
    )


def _at_least(number: str) -> str:
    """Return the number of a card as a lower bound; words stay."""
    bare = number.removeprefix("≤ ").removeprefix("≥ ")
    return f"≥ {bare}" if bare[:1].isdigit() else number


def _worst_scatter(values: Floats, known: States) -> Cell:
    """Return the 95th percentile over robots of the worst pose, of values (pose, robot) in m."""
    return as_known(scatter_figure(over_robots(values.max(axis=0)).high), known)


def _interval(figure: Cell) -> str:
    """Return the interval of a figure in brackets."""
    return f" ({figure.interval})" if figure.interval else ""


def _remarks(predicted: PredictedRobots) -> list[str]:
    """Return the notes on the prediction."""
    out = []
    if predicted.robots < _FEW:
        out.append(
            f"{several(predicted.robots, 'robot')}: too few for a 95th percentile, which depends "
            "on the largest one or two"
        )
    if predicted.still:
        out.append(
            f"joints that do not move in the cycle: {', '.join(predicted.still)}; their backlash "
            "is assumed to stay on one side"
        )
    sheet = predicted.loads[0]
    if sheet.repeatability.max() < NO_SCATTER:
        out.append(
            "from one side no described error varies from visit to visit, so no repeatability "
            "is predicted; a real arm adds friction, "
            "control and temperature"
        )
    elif _describes_little_scatter(predicted):
        out.append(
            "RP_l from one side is small because the parts describe little scatter from visit "
            "to visit; a real arm adds friction, control "
            "and temperature. See 'from either side' for the effect of backlash"
        )
    return out


def _facts(predicted: PredictedRobots) -> dict[str, Any]:
    cube = predicted.cube
    return {
        "robots": predicted.robots,
        "cycles": predicted.cycles,
        "seed": predicted.seed,
        "cube": {
            "side_m": cube.side,
            "centre_m": cube.centre.tolist(),
            "tool_rotation": None if cube.rotation is None else cube.rotation.tolist(),
            "poses_m": {name: cube.poses[k, :3, 3].tolist() for k, name in enumerate(NAMES)},
            "q": {name: cube.q[k].tolist() for k, name in enumerate(NAMES)},
            "found_by": cube.method,
        },
        "approach": {name: predicted.approach[k].tolist() for k, name in enumerate(NAMES)},
    }
