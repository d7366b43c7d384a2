"""Sheet of a task: the probability of success, each tolerance, the worst place and the
largest contributor.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.task.page.plots import plots
from lostmotion.analyses.task.page.tables import drift_section, help_sections
from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import in_error, with_limits
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.arm_sheet import sections_as_known, with_arm
from lostmotion.reporting.first_order import checked, judged
from lostmotion.reporting.joint_values import joint_values, tool_place
from lostmotion.reporting.provenance import as_known, at_least, caveats
from lostmotion.reporting.sheet import (
    Bar,
    Bars,
    Card,
    Cell,
    Row,
    Sheet,
    in_words,
    length,
    several,
    table,
)

if TYPE_CHECKING:
    from lostmotion.analyses.task.outcome import TaskResult, ToleranceOutcome
    from lostmotion.error_model.drawing_tolerances import DrawingTolerance
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.provenance import States
    from lostmotion.reporting.sheet import Section

__all__ = ["plots", "sheet"]
_PARTS: Final = 12
_BARS: Final = 5
_PLACES: Final = 40
_LEAST: Final = 0.005
_WORDS: Final = (
    ("probability", "share of simulated robots and runs; each robot carries out every run."),
    (
        "tolerance",
        (
            "cylinder, sphere, box: full width of the zone about the commanded point; orientation "
            "and distance: largest deviation; straightness, roundness, flatness: width of the "
            "zone about the least-squares line, circle or plane (ISO 12780, ISO 12181, ISO 12781)."
        ),
    ),
    ("used, 95 %", "share of the tolerance that 95 % of robots and runs stay within."),
    (
        "side",
        (
            "the side on which a joint rests within its play follows its last motion; it is drawn "
            "at random until the joint first moves. Motions are assumed to traverse the play."
        ),
    ),
    (
        "reversal error",
        "displacement of the mean tool point between the path and the same path backwards.",
    ),
    ("fitted", "relative to a frame fitted to all places of a run by least squares."),
    ("interval", "95 % confidence interval; it counts robots, not runs."),
)


def sheet(outcome: TaskResult) -> Sheet:
    """Return the sheet of a task."""
    arm, task = outcome.arm, outcome.task
    known = with_limits(states(arm), arm, outcome.program.visited, outcome.program.sides)
    counted = f"{several(outcome.robots, 'robot')} x {several(outcome.runs, 'run')}"
    places = several(len(outcome.place_held), "place")
    sheet = Sheet(
        subject=f"task '{task.name}'",
        verdict=_verdict(outcome, known),
        cards=_cards(outcome, known),
        sections=(
            _success(outcome, counted),
            *_placement(outcome),
            _tolerances(outcome, counted),
            _features(outcome, counted),
            _shares("parts", "Contributors to the decisive tolerance", outcome, outcome.parts),
            _shares("causes", "Kinds of error in the decisive tolerance", outcome, outcome.causes),
            *drift_section(outcome),
            *help_sections(outcome),
            _places(outcome, counted),
            _sides(outcome),
        ),
        counts=f"{counted}, {places}, seed {outcome.seed}",
        notes=(_first_order(outcome),),
        words=_WORDS,
        source=f"{counted}, {places}, seed {outcome.seed}. The same files, version and seed give "
        "the "
        "same bytes.",
        seed=outcome.seed,
        facts=outcome.facts,
        bars=_bars(outcome),
    )
    sheet = replace(sheet, sections=sections_as_known(sheet.sections, known))
    sheet = with_arm(sheet, arm, known, sections=("reversal",))
    return checked(sheet, outcome.check, outcome.check.length, arm)


def _bounded(text: object, known: States) -> str:
    """Return a probability as an upper bound where kinds of error are missing, a lower one where
    makers' upper limits count.
    """
    if known.lower_bound:
        return str(text) if in_error(known) else f"at most {text}"
    return f"at least {text}" if in_error(known) and not known.ideal_kinds else str(text)


def _share(estimate: Estimate, samples: str = "") -> Cell:
    return Cell(estimate.value, "%", estimate.low, estimate.high, samples)


def _verdict(outcome: TaskResult, known: States) -> str:
    success = _share(outcome.success)
    interval = f" ({success.interval})" if success.interval else ""
    worst = outcome.outcomes[outcome.decisive]
    part, share = next(iter(outcome.parts.items()), ("", 0.0))
    text = [
        (
            f"All tolerances hold in {_bounded(success, known)}{interval} of robots and runs; "
            f"{Cell(outcome.task.required, '%', stated=True)} are required."
        )
    ]
    if len(outcome.outcomes) > 1 or worst.held.value < 1:
        text.append(
            f"The decisive tolerance is '{worst.tolerance.name}' at {outcome.where(worst.worst)}: "
            f"95 % stay within {at_least(_used(worst), known)} of it."
        )
    if share:
        text.append(f"Largest contributor: {short_name(part)}, {Cell(share, '%')}.")
    if outcome.success.value < outcome.task.required:
        text.append(_remedy(outcome))
    return " ".join([*text, *caveats(known)])


def _remedy(outcome: TaskResult) -> str:
    """Return the sentence on the first remedy that meets the requirement, or else the best one."""
    stages = outcome.helps.stages
    best = max(stages, key=lambda each: each.success.value)
    meets = [each for each in stages if each.success.value >= outcome.task.required]
    if meets:
        share = Cell(meets[0].success.value, "%")
        return f"Of ideal remedies, '{meets[0].name}' raises it to {share}."
    if best.success.value <= outcome.helps.before.success.value:
        return "No ideal remedy raises it: only other parts or tolerances do."
    return f"No ideal remedy suffices; '{best.name}' raises it to {Cell(best.success.value, '%')}."


def _cards(outcome: TaskResult, known: States) -> tuple[Card, ...]:
    worst = outcome.outcomes[outcome.decisive]
    bounded = _bounded("", known).strip()
    sign = {"at most": "≤ ", "at least": "≥ "}.get(bounded, "")
    lower = {"≤ ": "≥ ", "≥ ": "≤ "}.get(sign, "")
    part, share = next(iter(outcome.parts.items()), ("", 0.0))
    cards = [
        Card("all tolerances hold", f"{sign}{_share(outcome.success)}", "of robots and runs"),
        Card("decisive tolerance, used", f"{lower}{_used(worst)}", "95 % stay within"),
        Card("held there", f"{sign}{_share(worst.held)}", worst.tolerance.name),
    ]
    if share:
        cards.append(Card("largest contributor", short_name(part), f"{Cell(share, '%')}"))
    reversal = float(outcome.reversal.max(initial=0.0))
    if reversal:
        figure = as_known(length(reversal), known)
        cards.append(Card("reversal error", str(figure), "largest along the path"))
    return tuple(cards)


def _used(outcome: ToleranceOutcome) -> str:
    return f"{100 * outcome.used.value:.3g} %"


def _limit(stated: DrawingTolerance) -> Cell:
    """Return the size of a tolerance as printed."""
    if stated.kind == "orientation":
        return Cell(stated.size[0], "°", stated=True)
    if stated.kind == "box":
        sizes = " x ".join(f"{1e3 * each:.4g}" for each in stated.size)
        return in_words(f"{sizes} mm")
    return Cell(stated.size[0], "mm", stated=True)


def _bars(outcome: TaskResult) -> tuple[Bars, ...]:
    """Return the bars of the first screen: the largest contributors, and what remedies leave."""
    shown = [each for each in outcome.parts.items() if abs(each[1]) >= _LEAST][:_BARS]
    parts = (Bar(short_name(name), Cell(value, "%"), 100 * value) for name, value in shown)
    lines = (outcome.helps.before, *outcome.helps.stages)
    helps = (Bar(each.name, _share(each.success), 100 * each.success.value) for each in lines)
    blame, held = "Largest contributors to the decisive tolerance", "All tolerances hold with"
    block = Bars("parts", blame, "share of the mean square", tuple(parts))
    gained = Bars("remedies", held, "probability", tuple(helps), note="ideal remedies", most=100.0)
    return (block, gained) if shown else (gained,)


def _success(outcome: TaskResult, counted: str) -> Section:
    return table(
        "task",
        "Success of the task",
        {"value": "%"},
        [
            Row("all tolerances hold", (_share(outcome.success, counted),), key="success"),
            Row("required", (Cell(outcome.task.required, "%", stated=True),), key="required"),
            Row(
                "reversal error, largest",
                (length(float(outcome.reversal.max(initial=0.0)), samples="exact"),),
                key="reversal",
            ),
        ],
    )


def _placement(outcome: TaskResult) -> tuple[Section, ...]:
    """Return the best placement that was found; nothing where it is fixed."""
    placed = outcome.placed
    if placed is None:
        return ()
    x, y, z, yaw = (float(each) for each in placed.moved)
    sizes = (("x", x, "mm"), ("y", y, "mm"), ("z", z, "mm"), ("yaw", yaw, "°"))
    used = (("used there", placed.after, "%"), ("used at the stated one", placed.before, "%"))
    return (
        table(
            "placement",
            "Best placement",
            {"value": ""},
            [(name, Cell(value, unit)) for name, value, unit in (*sizes, *used)],
            "moved from the stated placement, in its axes; used: share of the most used tolerance "
            "that 95 % stay within",
            samples=f"{placed.reached} of {several(placed.tried, 'placement')} within reach",
        ),
    )


def _tolerances(outcome: TaskResult, counted: str) -> Section:
    rows = []
    for each in outcome.outcomes:
        stated = each.tolerance
        datum = (
            stated.datum
            if isinstance(stated.datum, str)
            else ", ".join(outcome.program.features[k].name for k in stated.datum)
        )
        used = Cell(each.used.value, "%", each.used.low, each.used.high, counted)
        cells = (_limit(stated), _share(each.held, counted), used)
        note = f"relative to {datum}; worst at {outcome.where(each.worst)}"
        rows.append(Row(stated.name, cells, note))
    return table(
        "tolerances",
        "Tolerances",
        ("limit", "probability", "used, 95 %"),
        rows,
        "share of robots and runs in which the tolerance holds at all of its places",
    )


def _features(outcome: TaskResult, counted: str) -> Section:
    return table(
        "features",
        "Features",
        {"probability": "%"},
        [Row(name, (_share(held, counted),)) for name, held in outcome.features.items()],
        "share of robots and runs in which all tolerances of the feature hold",
    )


def _shares(key: str, title: str, outcome: TaskResult, shares: dict[str, float]) -> Section:
    worst = outcome.outcomes[outcome.decisive]
    shown = [(name, value) for name, value in shares.items() if abs(value) >= _LEAST][:_PARTS]
    return table(
        key,
        title,
        {"share of mean square": "%"},
        [(short_name(name), Cell(value, "%", samples="exact")) for name, value in shown],
        f"of '{worst.tolerance.name}' at {outcome.where(worst.worst)}; exact sums over terms",
    )


def _places(outcome: TaskResult, counted: str) -> Section:
    """Return the places with the smallest probability, in the order of the path."""
    held, used = outcome.place_held, outcome.place_used
    order = np.lexsort((-np.nan_to_num(used), np.where(np.isnan(held), 2.0, held)))
    kept = np.sort(order[:_PLACES])
    points = outcome.program.places.points
    rows = [
        Row(
            outcome.where(k),
            (
                *(
                    in_words("no zone")
                    if math.isnan(each)
                    else Cell(float(each), "%", samples=counted)
                    for each in (held[k], used[k])
                ),
                length(float(outcome.reversal[k]), samples="exact"),
            ),
            f"{tool_place(points[k])}; {joint_values(outcome.arm, outcome.program.visited[k])}",
            key=f"place_{k + 1}",
        )
        for k in kept
    ]
    left = len(held) - len(kept)
    return table(
        "places",
        "Places",
        ("probability", "used, 95 %", "reversal"),
        rows,
        "share of robots and runs in which all zones hold at the place"
        + (f"; {several(left, 'place')} with a larger share are not listed" if left else ""),
    )


def _sides(outcome: TaskResult) -> Section:
    """Return at how many places each joint rests on either side."""
    sides = outcome.program.sides
    changes = np.abs(np.diff(np.sign(sides), axis=0)) > 0
    return table(
        "sides",
        "Sides of the joints along the path",
        ("after a motion up", "after a motion down", "drawn at random", "changes"),
        [
            (
                joint.name,
                *(int((sides[:, j] * sign > 0).sum()) for sign in (1, -1)),
                int((sides[:, j] == 0).sum()),
                int(changes[:, j].sum()),
            )
            for j, joint in enumerate(outcome.arm.driven)
        ],
        "number of places, by the last motion of each joint",
        samples=several(len(sides), "place"),
    )


def _first_order(outcome: TaskResult) -> str:
    check = outcome.check
    return (
        f"first order differs from exact composition by at most {length(check.largest)} in "
        f"{several(check.samples, 'sample')}: {judged(check, check.length)}"
    )
