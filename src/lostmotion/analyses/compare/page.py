"""Sheet of a comparison."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.compare.description import ABSENT, WHOLE_JOINT
from lostmotion.analyses.compare.figures import (
    bars,
    commanded_tool_points,
    counted,
    distance_facts,
    ends,
    figure,
    measure_of,
    remark,
)
from lostmotion.analyses.compare.headline import brief, failing, verdict, warnings, within_of
from lostmotion.error_model.arrival import arriving
from lostmotion.error_model.overload import rated_torques
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.propagation.exact import share_neglected
from lostmotion.reporting.arm_sheet import sign_of
from lostmotion.reporting.arm_summary import about_arm
from lostmotion.reporting.chance_levels import REMEDIES
from lostmotion.reporting.first_order import checked, judged
from lostmotion.reporting.layout import key_of
from lostmotion.reporting.not_counted import NOT_COUNTED, without_mass
from lostmotion.reporting.provenance import provenance_facts
from lostmotion.reporting.sheet import (
    Cell,
    Row,
    Section,
    Sheet,
    in_words,
    length,
    several,
)

if TYPE_CHECKING:
    from lostmotion.analyses.compare.compared_arm import ComparedArm, Group, Grouping
    from lostmotion.analyses.compare.comparison import Change, Comparison, PartChange


_EXACT: Final = "Exact sum over terms; the interval shows what the choice of poses leaves"


_GROUPS: Final[dict[Group, tuple[str, str, str]]] = {
    "accuracy": ("changes", "Accuracy", "change: against the first arm, with its paired interval"),
    "levels": (
        "changes_by_level",
        "What can be compensated",
        f"load and pose: {REMEDIES[0]}. Robots: {REMEDIES[1]}. Visits: {REMEDIES[2]}",
    ),
    "arm": (
        "changes_of_arm",
        "Mass, price and drives",
        "as far as stated; loads of the drives: largest over the poses, standing still",
    ),
}


# Groupings of the error terms, as the tables name them; rows that a table shows.
_GROUPINGS: Final[dict[Grouping, str]] = {
    "parts": "part",
    "members": "member of a part",
    "causes": "kind of error",
}


_MOST_ROWS: Final = 30


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


def compare_sheet(found: Comparison) -> Sheet:
    """Return the sheet of a comparison."""
    first = found.arms[0]
    labels = [each.label for each in found.arms]
    poses = (
        several(len(first.poses), "pose")
        if len({len(each.poses) for each in found.arms}) == 1
        else "poses of their own"
    )
    counts = (
        f"{poses} x {several(first.sampled.robots, 'robot')} x "
        f"{several(first.sampled.visits, 'visit')}, same draws"
    )
    sheet = Sheet(
        name=" and ".join([", ".join(labels[:-1]), labels[-1]]),
        subject="comparison",
        verdict=verdict(found),
        cards=(),
        sections=(
            *(_changes(found, group) for group in _GROUPS),
            *commanded_tool_points(found),
            _values(found),
            *(
                section
                for k, change in enumerate(found.changes)
                for section in _parts(found, change, k)
            ),
            *_states(found),
            _figures(found),
            _drives(found),
            _arms(found),
            _check(found),
        ),
        counts=counts,
        warnings=warnings(found),
        notes=(
            (
                "not counted: "
                f"{NOT_COUNTED}{'' if measure_of(found, 'price') else ', prices (none is stated)'}{_without_mass(found)}"  # noqa: E501
            ),
            *_notes(found),
        ),
        words=_WORDS,
        source=_source(found, counts),
        seed=found.seed,
        facts=_facts(found),
        bars=bars(found),
        brief=brief(found),
    )
    for each in failing(found):  # without intervals, and with the failure as the headline
        sheet = replace(
            checked(sheet, each.sampled.exact, within_of(found, each), each.arm),
            verdict=sheet.verdict,
            cards=(),
        )
    return sheet


def _without_mass(found: Comparison) -> str:
    return without_mass(model for each in found.arms for model in each.arm.gearboxes_without_mass)


def _changes(found: Comparison, group: Group) -> Section:
    """Return the main tables: every figure of the first arm of this group, and its change in the
    others.
    """
    first, *others = found.arms
    two = len(others) == 1
    rows = []
    for measure in (each for each in found.measures if each.group == group):
        before = measure.value(first)
        figures = (
            [figure(before, measure.unit)]
            if measure.exact
            else [_alone(figure(before, measure.unit, counted(first)), first)]
        )
        if two:
            other = figure(measure.value(others[0]), measure.unit, counted(others[0]))
            figures.append(_alone(other, None if measure.exact else others[0]))
        estimates = [change.figures[measure.key] for change in found.changes]
        figures += [
            figure(each, measure.unit, counted(change.arm))
            for each, change in zip(estimates, found.changes, strict=True)
        ]
        remarks = [remark(each, exact=measure.exact) for each in estimates]
        note = (
            remarks[0]
            if two
            else "; ".join(
                f"{change.arm.label}: {text}"
                for text, change in zip(remarks, found.changes, strict=True)
                if text
            )
        )
        rows.append(Row(measure.name, tuple(figures), note, measure.key))
    columns = (
        (first.label, others[0].label, "change")
        if two
        else (first.label, *(f"{other.label}, change" for other in others))
    )
    key, title, note = _GROUPS[group]
    return Section(key, title, columns, tuple(rows), note)


def _alone(found: Cell, of: ComparedArm | None) -> Cell:
    """Return a figure without its interval, which stands in another table; an error of an arm that
    misses kinds of error as a bound.
    """
    sign = sign_of(of.known) if of is not None and found.unit == "m" else ""
    return replace(found.alone, bound=sign)


def _values(found: Comparison) -> Section:
    rows = tuple(
        Row(
            each.name,
            tuple(in_words(text) for text in each.texts),
            key=key_of(f"{each.parts[0]} {each.key}"),
        )
        for each in found.values
    )
    note = (
        "in brackets why a value is not a stated fact; -: the arm has none"
        if rows
        else "no value differs"
    )
    folded = (
        f"{len(rows)} values differ; result.json lists them as well"
        if len(rows) > _MOST_ROWS
        else ""
    )
    return Section(
        "values", "What differs", tuple(each.label for each in found.arms), rows, note, folded
    )


def _parts(found: Comparison, change: Change, index: int) -> list[Section]:
    """Return the error of each part, and of each kind of error, in both arms, and their shares in
    the change of one arm.
    """
    end, of = ("", "") if len(found.changes) == 1 else (f"_{index + 2}", f": {change.arm.label}")
    columns = (found.arms[0].label, change.arm.label, "change")
    sections = []
    for key, title in _GROUPINGS.items():
        items = change.by[key]
        if key == "members" and {each.part for each in items} == {
            each.part for each in change.parts
        }:
            continue
        # what is equal but for rounding stays in the order of the arms
        ranked = sorted(
            items, key=lambda each: -float(f"{max(each.before or 0.0, each.after or 0.0):.9g}")
        )
        shortened = (
            f"the {_MOST_ROWS} largest of {len(ranked)}, all of them in result.json. "
            if len(ranked) > _MOST_ROWS
            else ""
        )
        note = f"{shortened}R.m.s. error of each by itself. {_EXACT}"
        sections.append(
            Section(
                f"{key}{end}",
                f"Error by {title}{of}",
                columns,
                tuple(_row(each, change.arm) for each in ranked[:_MOST_ROWS]),
                note,
            )
        )
        sections.append(_shares(f"{key}_shares{end}", f"Change by {title}{of}", change, key))
    return sections


def _row(each: PartChange, arm: ComparedArm) -> Row:
    own = [
        in_words(ABSENT) if value is None else length(value) for value in (each.before, each.after)
    ]
    return Row(
        short_name(each.part),
        (*own, figure(each.alone, "m")),
        remark(each.alone, exact=len(arm.tallies) == 1),
    )


def _shares(key: str, title: str, change: Change, grouping: Grouping) -> Section:
    """Return the shares of parts, or kinds of error, in the change of the r.m.s. error, and their
    sum; those that change nothing are omitted.
    """
    exact = len(change.arm.tallies) == 1
    items, moved = change.by[grouping], change.moving(grouping)
    rows = [
        Row(short_name(each.part), (figure(each.share, "m"),), remark(each.share, exact=exact))
        for each in moved[:_MOST_ROWS]
    ]
    if len(moved) > _MOST_ROWS:
        rest = sum(each.share.value for each in moved[_MOST_ROWS:])
        rows.append(Row(several(len(moved) - _MOST_ROWS, "other"), (length(rest),), key="others"))
    rows.append(
        Row(
            "all", (figure(change.figures["rms"], "m"),), remark(change.figures["rms"], exact=exact)
        )
    )
    omitted = len(items) - len(moved)
    note = (
        f"{omitted} without a share, or with less than 0.01 % of the largest one. "
        if omitted
        else ""
    )
    return Section(
        key,
        title,
        ("of the change of the r.m.s. error",),
        tuple(rows),
        f"{note}Shares add to the change. {_EXACT}",
    )


def _states(found: Comparison) -> list[Section]:
    if not found.states:
        return []
    rows = tuple(
        Row(f"{each.place}, {each.kind}", tuple(map(in_words, each.states)))
        for each in found.states
    )
    note = (
        "ideal: nothing is described, taken as perfect; assumed: some value behind it is; -: "
        "there is none"
    )
    return [
        Section(
            "states",
            "What is not equally well known",
            tuple(each.label for each in found.arms),
            rows,
            note,
        )
    ]


def _figures(found: Comparison) -> Section:
    rows = tuple(
        Row(
            measure.name,
            tuple(figure(measure.value(each), measure.unit, counted(each)) for each in found.arms),
            key=measure.key,
        )
        for measure in found.measures
    )
    return Section(
        "figures",
        "Every arm by itself",
        tuple(each.label for each in found.arms),
        rows,
        "as a study of each arm reports them",
    )


def _drives(found: Comparison) -> Section:
    names = list(dict.fromkeys(joint.name for each in found.arms for joint in each.arm.driven))
    rows = []
    for name in names:
        cells, shares = [], []
        for each in found.arms:
            at = next((k for k, joint in enumerate(each.arm.driven) if joint.name == name), None)
            if at is None:
                cells.append(in_words(ABSENT))
                continue
            joint, held, rated = (
                each.arm.driven[at],
                float(each.held[at]),
                float(rated_torques(each.arm)[at]),
            )
            cells.append(Cell(held, joint.load_unit))
            shares.append(
                str(Cell(held / rated, "%")) if math.isfinite(rated) and rated > 0 else "not rated"
            )
        rows.append(Row(name, tuple(cells), f"of the rated load: {', '.join(shares)}"))
    return Section(
        "drives",
        "Static load of each drive",
        tuple(each.label for each in found.arms),
        tuple(rows),
        "largest over the poses, base as stated",
    )


def _arms(found: Comparison) -> Section:
    rows = tuple(
        Row(
            each.label,
            (
                Cell(len(each.arm.moving), "1"),
                Cell(each.arm.mass, "kg"),
                Cell(each.arm.payload.mass, "kg", stated=True),
            ),
            f"{each.arm.name}: {about_arm(each.arm)}; {counted(each)}",
        )
        for each in found.arms
    )
    return Section("arms", "The arms", ("moving joints", "mass", "payload"), rows)


def _check(found: Comparison) -> Section:
    rows = []
    for each in found.arms:
        check, error = each.sampled.exact, within_of(found, each)
        sizes = (length(check.largest), Cell(share_neglected(check, error), "%"))
        rows.append(Row(each.label, sizes, judged(check, error)))
    return Section(
        "exact_check",
        "First order against exact composition",
        ("largest difference", "of the 95 % error"),
        tuple(rows),
    )


def _notes(found: Comparison) -> list[str]:
    """Return the notes of all arms, those of some only with their labels."""
    remarks = [each.arm.remarks for each in found.arms]
    out = []
    for text in dict.fromkeys(text for each in remarks for text in each):
        having = [each.label for each, own in zip(found.arms, remarks, strict=True) if text in own]
        out.append(text if len(having) == len(found.arms) else f"{', '.join(having)}: {text}")
    return out


def _source(found: Comparison, counts: str) -> str:
    return (
        f"seed {found.seed}: {counts}; poses: {found.arms[0].poses.law}; joints arrive "
        f"{arriving(found.approach)}. {_SAME}"
    )


def _facts(found: Comparison) -> dict[str, Any]:
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
            for each in found.arms
        ],
        "seed": found.seed,
        "robots": found.arms[0].sampled.robots,
        "visits": found.arms[0].sampled.visits,
        "same_joint_values": found.paired,
        "same_errors": [change.same for change in found.changes],
        "changes": [_plain(change) for change in found.changes],
        "commanded_tool_points": [distance_facts(found, change) for change in found.changes],
        "differences": [
            {
                "parts": list(each.parts),
                "key": "" if each.key == WHOLE_JOINT else each.key,
                "values": list(each.texts),
            }
            for each in found.values
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
