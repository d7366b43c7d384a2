"""A comparison of arms with its sheet and its plots."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.compare.page.brief import brief
from lostmotion.analyses.compare.page.figures import (
    bars,
    commanded_tool_points,
    distance_facts,
    ends,
    measure_of,
)
from lostmotion.analyses.compare.page.headline import (
    failing,
    verdict,
    warnings,
    within_of,
)
from lostmotion.analyses.compare.page.tables import (
    GROUPS,
    arms_section,
    changes_section,
    check_section,
    drives_section,
    figures_section,
    parts_sections,
    states_sections,
    values_section,
)
from lostmotion.analyses.result import Result
from lostmotion.comparison.comparison import Comparison
from lostmotion.comparison.description import WHOLE_JOINT
from lostmotion.error_model.arrival import arriving
from lostmotion.error_model.trust import error_remarks
from lostmotion.reporting.arm_sheet import sections_as_known
from lostmotion.reporting.first_order import checked, with_falls
from lostmotion.reporting.not_counted import NOT_COUNTED, without_mass
from lostmotion.reporting.provenance import provenance_facts
from lostmotion.reporting.sheet import (
    Sheet,
    several,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.comparison.comparison import Change
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Section

_SAME: Final = "The same arms, version, seed and counts give the same bytes."


_WORDS: Final = (
    (
        "change",
        (
            "the arm's figure less that of the first arm, from the same robots, visits and sets "
            "of poses: more precise than the two intervals suggest."
        ),
    ),
    (
        "no difference seen",
        (
            "the interval of the change contains zero: these poses and robots do not show whether "
            "there is a difference."
        ),
    ),
    (
        "commanded tool point",
        "where the nominal geometry of the arm puts the tool; errors are deviations from it.",
    ),
    ("equal", "the same to the last digit of the computation, or of the description."),
    (
        "share of the change",
        "contributions of the parts to the change of the r.m.s. error; they add to it.",
    ),
    (
        "sag",
        (
            "displacement along gravity that all robots share, mean over the poses; a controller "
            "that knows the load can compensate it."
        ),
    ),
    (
        "stated, assumed, ideal",
        "known from a file or a maker, assumed, or not described and taken as perfect.",
    ),
)


def compare_sheet(comparison: Comparison) -> Sheet:
    """Return the sheet of a comparison."""
    first = comparison.arms[0]
    labels = [each.label for each in comparison.arms]
    poses = (
        several(len(first.poses), "pose")
        if len({len(each.poses) for each in comparison.arms}) == 1
        else "poses of their own"
    )
    counts = (
        f"{poses} x {several(first.sampled.robots, 'robot')} x "
        f"{several(first.sampled.visits, 'visit')}, same draws"
    )
    headline = verdict(comparison)
    for each in reversed(comparison.arms):
        headline = with_falls(headline, each.arm, each.label)
    sheet = Sheet(
        name=" and ".join([", ".join(labels[:-1]), labels[-1]]),
        subject="comparison",
        verdict=headline,
        cards=(),
        sections=(
            *_of_errors(comparison, (changes_section(comparison, group) for group in GROUPS)),
            *commanded_tool_points(comparison),
            values_section(comparison),
            *_of_errors(
                comparison,
                (
                    section
                    for k, change in enumerate(comparison.changes)
                    for section in parts_sections(comparison, change, k)
                ),
            ),
            *states_sections(comparison),
            *_of_errors(comparison, [figures_section(comparison)]),
            drives_section(comparison),
            arms_section(comparison),
            *_of_errors(comparison, [check_section(comparison)]),
        ),
        counts=counts,
        warnings=warnings(comparison),
        notes=(
            (
                "not counted: "
                f"{NOT_COUNTED}{'' if measure_of(comparison, 'price') else ', prices (none is stated)'}{_without_mass(comparison)}"  # noqa: E501
            ),
            *_notes(comparison),
        ),
        words=_WORDS,
        source=_source(comparison, counts),
        seed=comparison.seed,
        facts=_facts(comparison),
        bars=bars(comparison),
        brief=brief(comparison),
    )
    for each in failing(comparison):  # without intervals, and with the failure as the headline
        sheet = replace(
            checked(sheet, each.sampled.exact, within_of(comparison, each), each.arm),
            verdict=sheet.verdict,
            cards=(),
        )
    return sheet


def _of_errors(comparison: Comparison, sections: Iterable[Section]) -> tuple[Section, ...]:
    """Return tables of errors, with one digit where every drive of one of the arms is assumed."""
    for each in comparison.arms:
        sections = sections_as_known(sections, each.known)
    return tuple(sections)


def _notes(comparison: Comparison) -> list[str]:
    """Return the notes of all arms, those of some only with their labels."""
    remarks = [error_remarks(each.arm) for each in comparison.arms]
    out = []
    for text in dict.fromkeys(text for each in remarks for text in each):
        having = [
            each.label for each, own in zip(comparison.arms, remarks, strict=True) if text in own
        ]
        out.append(text if len(having) == len(comparison.arms) else f"{', '.join(having)}: {text}")
    return out


def _source(comparison: Comparison, counts: str) -> str:
    return (
        f"seed {comparison.seed}: {counts}; poses: {comparison.arms[0].poses.law}; joints arrive "
        f"{arriving(comparison.approach)}. {_SAME}"
    )


def _facts(comparison: Comparison) -> dict[str, Any]:
    return {
        "arms": [
            {
                "label": each.label,
                "arm": each.arm.name,
                "mass_kg": each.arm.mass,
                "mass_not_stated": list(each.arm.gearboxes_without_mass),
                "price": each.arm.price,
                "price_not_stated": list(each.arm.joints_without_price),
                "poses": {
                    "count": len(each.poses),
                    "law": each.poses.law,
                    "independent_sets": each.poses.replicates,
                },
                **provenance_facts(each.known),
            }
            for each in comparison.arms
        ],
        "seed": comparison.seed,
        "robots": comparison.arms[0].sampled.robots,
        "visits": comparison.arms[0].sampled.visits,
        "same_joint_values": comparison.paired,
        "same_errors": [change.same for change in comparison.changes],
        "changes": [_plain(change) for change in comparison.changes],
        "commanded_tool_points": [
            distance_facts(comparison, change) for change in comparison.changes
        ],
        "differences": [
            {
                "parts": list(each.parts),
                "key": "" if each.key == WHOLE_JOINT else each.key,
                "values": list(each.texts),
            }
            for each in comparison.values
        ],
    }


def _plain(change: Change) -> dict[str, Any]:
    """Return all changes of one arm as plain data, in SI; each as value and the ends of its
    interval.
    """
    return {
        "arm": change.arm.label,
        "figures": {key: ends(each) for key, each in change.figures.items()},
        **{
            grouping: [
                {
                    "name": each.part,
                    "before_m": each.before,
                    "after_m": each.after,
                    "alone_m": ends(each.alone),
                    "share_m": ends(each.share),
                }
                for each in items
            ]
            for grouping, items in change.by.items()
        },
    }


def _without_mass(comparison: Comparison) -> str:
    return without_mass(
        model for each in comparison.arms for model in each.arm.gearboxes_without_mass
    )


@dataclass(frozen=True, repr=False)
class Compare(Comparison, Result):
    """What differs between arms and what it does: every attribute of `Comparison`."""

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        return compare_sheet(self)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.compare.page.plots import compare_plots

        return compare_plots(self)
