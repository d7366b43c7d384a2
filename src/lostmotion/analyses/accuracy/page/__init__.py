"""The figures of a study: workspace, position error, ISO 9283, budget, torques, and a headline."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.accuracy.page.arm import (
    bending_sections,
    joints_section,
    servo_sections,
    workspace_section,
)
from lostmotion.analyses.accuracy.page.budget import (
    budget_section,
    by_level_sections,
    causes_section,
    levels_section,
    made_of_sections,
    one_sided_bounded,
    requested_sections,
    with_made_of_bars,
)
from lostmotion.analyses.accuracy.page.error import (
    bands_clause,
    bands_facts,
    bands_sections,
    error_section,
    few_poses,
    iso_section,
    with_band,
)
from lostmotion.analyses.accuracy.page.first_screen import blame_bars, brief_of, remedy_bars
from lostmotion.analyses.accuracy.page.headline import (
    headline,
    remedy_sentence,
    with_classes,
    with_presets,
)
from lostmotion.analyses.accuracy.page.zone import (
    WHOLE,
    stopping_section,
    waterfall_section,
    zone_sections,
    zone_stopping,
)
from lostmotion.error_model.arrival import arriving
from lostmotion.error_model.budget import costs
from lostmotion.error_model.few_poses import RP
from lostmotion.error_model.overload import overloads
from lostmotion.error_model.provenance import states
from lostmotion.error_model.trust import error_remarks
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.propagation.error_samples import Summed
from lostmotion.propagation.exact import share_neglected
from lostmotion.propagation.figures import HEADLINE, figures_of
from lostmotion.reporting.arm_sheet import bounded_bars, bounded_cards, bounded_sections
from lostmotion.reporting.arm_summary import about_arm
from lostmotion.reporting.first_order import checked, judged
from lostmotion.reporting.layout import row_at
from lostmotion.reporting.provenance import provenance_facts, provenance_sections
from lostmotion.reporting.sheet import Card, Cell, Row, Section, Sheet, cell, length, several
from lostmotion.reporting.warnings import overload_warnings

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.accuracy.answer import Answer
    from lostmotion.accuracy.route import FoundInZone
    from lostmotion.error_model.overload import Overload
    from lostmotion.error_model.provenance import States
    from lostmotion.propagation.figures import Figure
    from lostmotion.reporting.sheet import Bars


# What the words mean, for whoever reads the report without the manual.
_WORDS: Final = (
    ("position error", "distance between the commanded and the attained point of the tool."),
    (
        "design, robot, visit",
        (
            "origin of an error: load and pose, the same in every arm of this design; manufacture "
            "of each robot; each visit to a pose."
        ),
    ),
    (
        "AP",
        (
            "pose accuracy of ISO 9283: distance of the mean of a robot's visits from the "
            "commanded point. Predicted here, not certified."
        ),
    ),
    (
        "RP",
        (
            "pose repeatability of ISO 9283: scatter of the visits about their mean, mean "
            "distance plus three standard deviations."
        ),
    ),
    (
        "ISO cycle, any approach",
        (
            "side from which joints arrive at a pose: the same at every visit, as in the "
            "standard; or either side at random."
        ),
    ),
    (
        "interval",
        (
            "95 % confidence interval. It counts robots and independent sets of poses, not "
            "samples. A question mark: too few of them."
        ),
    ),
    (
        "share",
        "of the mean-square error. Shares add to 100 %; a negative one cancels part of the others.",
    ),
    (
        "first order",
        "small errors are added. An exact composition of a sample shows what is neglected.",
    ),
)
# Sections of which every length is an error.
_BOUNDED: Final = ("error", "iso9283", "zone_", "analytic")


def sheet(answer: Answer) -> Sheet:
    """Return the sheet of a study."""
    known = with_limits(states(answer.arm), answer.arm, answer.poses.q, answer.approach)
    found = with_made_of_bars(sections(answer), answer.repeats, answer.arm, known)
    shown = one_sided_bounded(found, answer.arm)
    sampled, poses = answer.sampled, answer.poses
    overloaded = overloads(answer.arm, poses)
    whole = Sheet(
        name=answer.arm.name,
        subject="predicted accuracy",
        counts=(
            f"{several(sampled.robots, 'robot')} x {several(sampled.visits, 'visit')} x "
            f"{several(len(poses), 'pose')}, seed {answer.seed}"
        ),
        verdict=_verdict(answer, known, overloaded),
        cards=bounded_cards(_cards(shown, answer), known),
        sections=(
            *bounded_sections(shown, known, _BOUNDED),
            *servo_sections(answer),
            *provenance_sections(known),
        ),
        warnings=(
            *answer.arm.warnings,
            *overload_warnings(overloaded),
            *few_poses(answer.budget, sampled.visits, answer.approach),
        ),
        notes=error_remarks(answer.arm),
        words=_WORDS,
        source=_source(answer),
        arrays="the results for every pose and robot",
        seed=answer.seed,
        facts={
            "arm": answer.arm.name,
            "seed": answer.seed,
            "poses": {"count": len(poses), "law": poses.law, "independent_sets": poses.replicates},
            "robots": sampled.robots,
            "visits": sampled.visits,
            "intervals": "95 %, counting robots and sets of poses; at a single pose, counting robots",  # noqa: E501
            **_zone_facts(answer),
            **bands_facts(answer.bands),
            **provenance_facts(known),
        },
        about=about_arm(answer.arm),
        bars=bounded_bars(_bars(answer), known, ("waterfall",)),
        brief=brief_of(found, answer, known),
    )
    within = answer.figures[HEADLINE].value
    whole = checked(whole, sampled.exact, within, answer.arm)
    if answer.classes:
        return with_classes(whole, answer.classes, known)
    return with_presets(whole, within, known)


def _bars(answer: Answer) -> tuple[Bars, ...]:
    counted = f"exact sum over terms, {several(len(answer.poses), 'pose')}"
    return (
        *blame_bars(costs(answer.sampled.tally), answer.halving.gains, counted),
        *remedy_bars(answer.waterfall),
    )


def sections(answer: Answer) -> list[Section]:
    """Return the sections of a study in reading order."""
    found = [
        workspace_section(answer.workspace),
        error_section(answer),
        iso_section(answer),
        *bands_sections(answer.bands, figures_of(answer.errors).values(), answer.figures),
        *zone_sections(answer),
        levels_section(answer.budget),
        *made_of_sections(answer.repeats),
        waterfall_section(answer.waterfall, answer.repeats),
        # none where nothing errs
        *(section for section in (budget_section(answer), causes_section(answer)) if section.rows),
        *by_level_sections(answer.budget),
        *requested_sections(answer.places),
        *bending_sections(answer),
        joints_section(answer, states(answer.arm)),
        _check(answer),
    ]
    if answer.stopping is not None:
        found.append(stopping_section(answer.stopping, WHOLE if answer.zones else ""))
        found += zone_stopping(answer.zones)
    if answer.analytic is not None and answer.pooled is not None:
        from lostmotion.analyses.accuracy.page.analytic import (
            analytic_section,
            analytic_zone_sections,
        )
        from lostmotion.analyses.accuracy.page.beside_sampling import comparisons

        errors = Summed.of(answer.pooled, answer.budget.squares)
        whole = analytic_section(answer.arm, answer.poses, answer.analytic, errors)
        found += [
            whole,
            *comparisons(answer.analytic, errors, answer.sampled),
            *analytic_zone_sections(answer.arm, answer.zones, whole),
        ]
    return found


def _check(answer: Answer) -> Section:
    exact, q95 = answer.sampled.exact, answer.figures[HEADLINE].value
    counted = several(exact.samples, "sample")
    rows = (
        Row("largest difference", (length(exact.largest, samples=counted),)),
        Row("mean difference", (length(exact.mean, samples=counted),)),
        Row(
            "largest, share of the 95th percentile",
            (Cell(share_neglected(exact, q95), "%", samples=counted),),
            judged(exact, q95),
        ),
    )
    return Section("exact_check", "First order against exact composition", ("value",), rows)


def _verdict(answer: Answer, known: States, overloaded: Sequence[Overload]) -> str:
    """Return the headline: position error, the remedy that takes most off it, and what is assumed
    or missing.
    """
    remedy = remedy_sentence(
        answer.budget, answer.waterfall, known, temperature=answer.arm.has_temperatures
    )
    within = cell(answer.figures[HEADLINE], "m")
    return headline(within, bands_clause(answer.bands, answer.figures), remedy, known, overloaded)


def _in_zones(tables: Sequence[Section], answer: Answer) -> list[tuple[FoundInZone, Row]]:
    """Return each zone with the row of its 95th percentile."""
    rows = ((zone, row_at(tables, f"zone_{k}", HEADLINE)) for k, zone in enumerate(answer.zones, 1))
    return [(zone, row) for zone, row in rows if row is not None]


def _zone_facts(answer: Answer) -> dict[str, Any]:
    """Return the number of poses of each zone as plain data; nothing without zones."""
    found = [
        {
            "name": zone.name,
            "poses": len(zone.poses),
            "independent_sets": zone.poses.replicates,
            "looked_at": zone.tried,
        }
        for zone in answer.zones
    ]
    return {"zones": found} if found else {}


def _cards(tables: Sequence[Section], answer: Answer) -> list[Card]:
    """Return the main figures and the 95th percentile of each zone, each with its interval."""
    cards = [
        with_band(card, answer.bands, answer.figures)
        for card in first_cards(tables, figures_of(answer.errors).values())
    ]
    reach = row_at(tables, "workspace", "reach_from_the_base")
    if reach is not None and reach.cells[0].value:
        cards.append(Card(reach.label, str(reach.cells[0]), reach.note))
    parts = next((section.rows for section in tables if section.key == "budget"), ())
    if parts:
        cards.append(
            Card(
                "largest contributor, share of mean square",
                str(parts[0].cells[1]),
                parts[0].label,
            )
        )
    for zone, row in _in_zones(tables, answer):
        figure = row.cells[0]
        cards.append(
            Card(
                f"95 % of positions within, {zone.name}",
                str(figure),
                f"interval {figure.interval}" if figure.interval else "",
                HEADLINE,
                "error",
            )
        )
    return cards


def first_cards(tables: Sequence[Section], figures: Iterable[Figure]) -> list[Card]:
    """Return the cards of the figures that are asked for first, of those that are not zero: where
    nothing described errs so, zero is not a prediction.
    """
    chosen = sorted((each for each in figures if each.first), key=lambda of: of.key != HEADLINE)
    rows = ((each, row_at(tables, each.group, each.key)) for each in chosen)
    return [
        Card(
            each.title,
            str(row.cells[0]),
            f"interval {row.cells[0].interval}" if row.cells[0].interval else row.note,
            each.key,
            "repeatability" if each.weights == RP else "error",
        )
        for each, row in rows
        if row is not None and row.cells[0].value
    ]


def _source(answer: Answer) -> str:
    sampled, poses = answer.sampled, answer.poses
    sets = f" in {poses.replicates} independent sets" if poses.replicates > 1 else ""
    samples = len(poses) * sampled.robots * sampled.visits
    drawn = (
        f"{several(sampled.robots, 'robot')} x {several(sampled.visits, 'visit')} = "
        f"{several(samples, 'sample')}"
    )
    counts = f"{several(len(poses), 'pose')} ({poses.law}){sets} x {drawn}"
    return (
        f"seed {answer.seed}: {counts}; joints arrive {arriving(answer.approach)}. The same "
        "arm, version, seed and counts give the same bytes."
    )
