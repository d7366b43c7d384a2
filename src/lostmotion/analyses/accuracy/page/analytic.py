"""The figures of a study without sampling, by themselves or beside those of Monte Carlo."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.accuracy.page.beside_sampling import UNKNOWN, comparisons
from lostmotion.analyses.accuracy.page.budget import (
    by_level_sections,
    halved_sections,
    levels_section,
    requested_sections,
)
from lostmotion.analyses.accuracy.page.error import few_poses, limit_rows
from lostmotion.analyses.accuracy.page.first_screen import (
    blame_bars,
    rms_bars,
    trust,
    where,
    zone_sentence,
)
from lostmotion.analyses.accuracy.page.headline import headline, on_condition, rms_remedy_sentence
from lostmotion.analyses.accuracy.page.zone import BESIDE, OWN, beside, rms_section, sampling_note
from lostmotion.error_model.intervals import Estimate, of_length
from lostmotion.error_model.overload import overloads
from lostmotion.error_model.provenance import states
from lostmotion.error_model.trust import error_remarks
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.propagation.analytic import MOST_UNCERTAIN
from lostmotion.propagation.error_samples import Summed
from lostmotion.propagation.figures import FIRST, HEADLINE, MEAN, RMS, figures_of, percentile
from lostmotion.reporting.arm_sheet import bounded_bars, bounded_cards, bounded_sections
from lostmotion.reporting.arm_summary import about_arm
from lostmotion.reporting.first_order import with_falls
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.layout import row_at
from lostmotion.reporting.provenance import (
    at_least,
    missing_sentences,
    provenance_facts,
    provenance_sections,
    rests_on_sentences,
)
from lostmotion.reporting.sheet import Card, Cell, Row, Section, Sheet, length, several
from lostmotion.reporting.warnings import overload_warnings

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.accuracy.route import FoundInZone
    from lostmotion.error_model.budget import Budget, Cost
    from lostmotion.error_model.overload import Overload
    from lostmotion.error_model.poses import Poses
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.analytic import Analytic


_REMEDY: Final = 'use Monte Carlo (--method montecarlo, in Python method="montecarlo")'
# First order in the errors is no more precise than this share, however small the uncertainty of the
# figures is.
_LEAST_UNCERTAIN: Final = 1e-4
_REMARKS: Final = {
    "standard_deviation": "of the position error about its mean",
    "rms": "exact at the visited poses",
}
_WORDS: Final = (
    (
        "position error",
        (
            "distance between the point the tool was sent to and the point it reaches, over all "
            "robots and visits together."
        ),
    ),
    (
        "without sampling",
        (
            "mean vector and covariance are exact sums over terms; lengths follow by integration, "
            "or from 16 384 Sobol points."
        ),
    ),
    (
        "share",
        (
            "of the mean-square error, exact. Shares add to 100 %; a negative one cancels part of "
            "the others: the arm would be worse without it."
        ),
    ),
    (
        "uncertain",
        (
            "no figure is printed that is uncertain by more than 5 %: a level falls into a gap "
            "between few two-sided errors. Mean squares hold."
        ),
    ),
)


def analytic_sheet(  # noqa: PLR0913 - what one study found
    arm: Arm,
    poses: Poses,
    analytic: Analytic,
    errors: Summed,
    blame: Budget,
    places: Sequence[Budget] = (),
    zones: Sequence[FoundInZone] = (),
    *,
    remedied: Mapping[str, Estimate],
    approach: float = 0.0,
) -> Sheet:
    """Return the sheet of a study without sampling, over all poses, and at the stated poses and in
    the stated zones.

    blame: error budget over all poses; places: at every stated pose and in every zone. remedied:
    r.m.s. error that each
    remedy leaves (`remaining_rms`), m. approach: the sign of the joints' last motion.
    """
    section = analytic_section(arm, poses, analytic, errors)
    known = with_limits(states(arm), arm, poses.q, approach)
    in_zones = analytic_zone_sections(arm, zones, section)
    inside = [
        (zone.name, row_at(in_zones, f"zone_{k}_analytic", HEADLINE))
        for k, zone in enumerate(zones, 1)
    ]
    found_in = {
        name: row.cells[0]
        for name, row in (("", row_at([section], "analytic", HEADLINE)), *inside)
        if row is not None
    }
    overloaded = overloads(arm, poses)
    largest = blame.parts[0] if blame.parts and blame.parts[0].share > 0 else None
    cards = _cards(section, found_in, largest)
    return Sheet(
        name=arm.name,
        subject="predicted accuracy, without sampling",
        counts=f"{several(len(poses), 'pose')}, exact sums over terms",
        verdict=with_falls(_verdict(found_in[""], blame, known, arm, overloaded), arm),
        cards=bounded_cards(cards, known),
        sections=(
            *bounded_sections((section, *in_zones), known, ("analytic", "zone_")),
            levels_section(blame),
            *bounded_sections(
                (rms_section(remedied, len(poses)),) if blame.rms > 0 else (), known, ("remedies",)
            ),
            *by_level_sections(blame),
            *halved_sections("halving", "Effect of halving on the 95th percentile", blame),
            *requested_sections(places),
            *provenance_sections(known),
        ),
        warnings=(*arm.warnings, *overload_warnings(overloaded), *few_poses(blame, 1, approach)),
        notes=error_remarks(arm),
        words=_WORDS,
        source=(
            f"{several(len(poses), 'pose')} ({poses.law}); only the poses were drawn, and samples "
            "for the effect of halving"
        ),
        arrays="the figures of every pose",
        facts={
            "arm": arm.name,
            "method": "analytic",
            "poses": {"count": len(poses), "law": poses.law, "independent_sets": poses.replicates},
            **provenance_facts(known),
        },
        bars=(
            *blame_bars(
                blame.parts,
                {} if blame.halving is None else blame.halving.gains,
                f"exact sum over terms, {several(len(poses), 'pose')}",
            ),
            *bounded_bars(rms_bars(remedied, len(poses)), known, ("remedies",)),
        ),
        about=about_arm(arm),
        brief=_brief(arm, poses, analytic, found_in, known),
    )


def _verdict(
    figure: Cell, blame: Budget, known: States, arm: Arm, overloaded: Sequence[Overload]
) -> str:
    """Return the headline: the error over all poses, what compensation leaves of it, and what is
    assumed or missing.
    """
    remedy = rms_remedy_sentence(blame, known, temperature=arm.has_temperatures)
    if math.isfinite(figure.value):
        return headline(figure, "", remedy, known, overloaded)
    uncertain = f"Without sampling the 95 % error is uncertain by more than 5 %; {_REMEDY}."
    rms = on_condition(
        f"The root mean square over all poses is {at_least(length(blame.rms), known)}.", overloaded
    )
    return " ".join(
        each
        for each in (uncertain, rms, remedy, *missing_sentences(known), *rests_on_sentences(known))
        if each
    )


def _brief(
    arm: Arm, poses: Poses, analytic: Analytic, found_in: dict[str, Cell], known: States
) -> tuple[tuple[str, str], ...]:
    """Return the statements of the first screen besides the headline."""
    out = []
    for zone, figure in found_in.items():
        if zone and math.isfinite(figure.value):
            out.append(("Zone", zone_sentence(zone, figure, known)))
        elif zone:
            out.append(
                (
                    "Zone",
                    (
                        f"Without sampling the 95 % error in the zone {zone} is uncertain by more "
                        f"than 5 %; {_REMEDY}."
                    ),
                )
            )
    out += [("Where", where(arm, poses.q, analytic.mean, known)), *trust(known)]
    return tuple((word, text) for word, text in out if text)


def _cards(section: Section, found_in: dict[str, Cell], largest: Cost | None) -> list[Card]:
    """Show the figures that are asked for first, each with its interval."""
    within = percentile(FIRST)
    wanted = [(each.title, each.key) for each in (within, MEAN, RMS)]
    wanted.append(("worst pose, 95 % within", f"worst_pose_{HEADLINE}"))
    rows = [(title, key, row_at([section], "analytic", key)) for title, key in wanted]
    found = [(title, key, row.cells[0]) for title, key, row in rows if row is not None]
    found += [
        (f"{within.title}, {zone}", HEADLINE, figure) for zone, figure in found_in.items() if zone
    ]
    out = [
        Card(
            title, str(figure), f"interval {figure.between}" if figure.between else "", key, "error"
        )
        for title, key, figure in found
    ]
    if largest is not None:
        out.append(
            Card(
                "largest contributor, share of mean square",
                str(Cell(largest.share, "%")),
                short_name(largest.part),
            )
        )
    return out


def analytic_zone_sections(arm: Arm, zones: Sequence[FoundInZone], whole: Section) -> list[Section]:
    """Return the error in each zone beside that of the whole workspace, and with Monte Carlo their
    difference there.
    """
    out = []
    for k, zone in enumerate(zones, 1):
        if zone.analytic is None or zone.pooled is None:
            continue
        errors = Summed.of(zone.pooled, zone.budget.squares)
        here = analytic_section(arm, zone.poses, zone.analytic, errors, OWN)
        title = f"{whole.title}, in the zone {zone.name}"
        out.append(
            Section(
                f"zone_{k}_analytic",
                title,
                BESIDE,
                beside(here, whole),
                f"{sampling_note(zone)}; {here.note}",
            )
        )
        if zone.sampled is not None:
            out += [
                replace(
                    apart,
                    key=f"zone_{k}_{apart.key}",
                    title=f"{apart.title}, in the zone {zone.name}",
                )
                for apart in comparisons(zone.analytic, errors, zone.sampled)
            ]
    return out


def analytic_section(
    arm: Arm, poses: Poses, analytic: Analytic, errors: Summed, where: str = ""
) -> Section:
    """Return mean and quantiles over all poses and at the worst one, limits, and how many poses are
    valid. `where` follows the number of poses.
    """
    counted = f"sums over terms, {several(len(poses), 'pose')}{where}"
    rows = [
        *(
            replace(_row(each.name, each.of(errors), counted, _REMARKS.get(key, "")), key=key)
            for key, each in figures_of(errors).items()
            if each.group == "error"
        ),
        *_worst_pose(arm, poses, analytic),
    ]
    normal, valid = (
        Cell(float(each.mean()), "%", samples=counted)
        for each in (analytic.nearly_normal, analytic.valid)
    )
    rows += [
        *limit_rows(arm, float(analytic.rss.max()), float(analytic.worst.max()), counted),
        Row(
            "poses with a nearly normal error",
            (normal,),
            "integrated; the others are from Sobol points",
        ),
        Row("poses with every figure to 5 %", (valid,), "at the others a level falls into a gap"),
        Row(
            "excess, median pose",
            (Cell(float(np.median(analytic.excess)), "1", samples=counted),),
            "0 if normal, less if flat or two-sided",
        ),
    ]
    note = (
        "intervals over all poses: what the choice of poses leaves and the uncertainty of the "
        "figures; of the root mean square the former, "
        "at a pose the latter alone"
    )
    return Section("analytic", "Position error without sampling", ("value",), tuple(rows), note)


def _worst_pose(arm: Arm, poses: Poses, analytic: Analytic) -> list[Row]:
    at = int(np.argmax(analytic.mean))
    here = f"pose {at}"
    where = f"{here}, {joint_values(arm, poses.q[at])}"
    figures = (
        ("mean", analytic.mean, analytic.mean_uncertainty, where),
        ("standard deviation", analytic.deviation, analytic.deviation_uncertainty, ""),
        *(
            (
                percentile(level).name,
                analytic.quantiles[:, k],
                analytic.quantiles_uncertainty[:, k],
                "",
            )
            for k, level in enumerate(analytic.levels)
        ),
    )
    return [
        _row(f"worst pose, {name}", _at_pose(float(values[at]), float(off[at])), here, note)
        for name, values, off, note in figures
    ]


def _at_pose(value: float, uncertainty: float) -> Estimate:
    if not uncertainty <= MOST_UNCERTAIN * value:
        return Estimate(math.nan, math.nan, math.nan)
    half = max(uncertainty, _LEAST_UNCERTAIN * value)
    return of_length(value, value - half, value + half)


def _row(label: str, one: Estimate, counted: str, note: str = "") -> Row:
    """Return a line; one without a value says why."""
    if math.isnan(one.value):
        return Row(
            label,
            (Cell(math.nan, "1", samples=counted),),
            "; ".join(each for each in (UNKNOWN, note) if each),
        )
    return Row(label, (length(one.value, one.low, one.high, counted),), note)
