"""Tables of a comparison: changes, shares of parts, states, figures, drives, arms and checks."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.compare.page.figures import (
    counted,
    figure,
    remark,
)
from lostmotion.analyses.compare.page.headline import (
    within_of,
)
from lostmotion.comparison.description import ABSENT
from lostmotion.error_model.overload import rated_torques
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.propagation.exact import share_neglected
from lostmotion.reporting.arm_sheet import sign_of
from lostmotion.reporting.arm_summary import about_arm
from lostmotion.reporting.chance_levels import REMEDIES
from lostmotion.reporting.first_order import judged
from lostmotion.reporting.layout import key_of
from lostmotion.reporting.sheet import (
    Cell,
    Row,
    Section,
    in_words,
    length,
    several,
)

if TYPE_CHECKING:
    from lostmotion.comparison.compared_arm import ComparedArm, Group, Grouping
    from lostmotion.comparison.comparison import Change, Comparison, PartChange

_EXACT: Final = "Exact sum over terms; the interval shows what the choice of poses leaves"


GROUPS: Final[dict[Group, tuple[str, str, str]]] = {
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


def changes_section(comparison: Comparison, group: Group) -> Section:
    """Return the main tables: every figure of the first arm of this group, and its change in the
    others.
    """
    first, *others = comparison.arms
    two = len(others) == 1
    rows = []
    for measure in (each for each in comparison.measures if each.group == group):
        before = measure.value(first)
        figures = (
            [figure(before, measure.unit)]
            if measure.exact
            else [_alone(figure(before, measure.unit, counted(first)), first)]
        )
        if two:
            other = figure(measure.value(others[0]), measure.unit, counted(others[0]))
            figures.append(_alone(other, None if measure.exact else others[0]))
        estimates = [change.figures[measure.key] for change in comparison.changes]
        figures += [
            figure(each, measure.unit, counted(change.arm))
            for each, change in zip(estimates, comparison.changes, strict=True)
        ]
        remarks = [remark(each, exact=measure.exact) for each in estimates]
        note = (
            remarks[0]
            if two
            else "; ".join(
                f"{change.arm.label}: {text}"
                for text, change in zip(remarks, comparison.changes, strict=True)
                if text
            )
        )
        rows.append(Row(measure.name, tuple(figures), note, measure.key))
    columns = (
        (first.label, others[0].label, "change")
        if two
        else (first.label, *(f"{other.label}, change" for other in others))
    )
    key, title, note = GROUPS[group]
    return Section(key, title, columns, tuple(rows), note)


def _alone(cell: Cell, of: ComparedArm | None) -> Cell:
    """Return a figure without its interval, which stands in another table; an error of an arm that
    misses kinds of error as a bound.
    """
    sign = sign_of(of.known) if of is not None and cell.unit == "m" else ""
    return replace(cell.alone, bound=sign)


def values_section(comparison: Comparison) -> Section:
    """Return the table of the values in which the files differ."""
    rows = tuple(
        Row(
            each.name,
            tuple(in_words(text) for text in each.texts),
            key=key_of(f"{each.parts[0]} {each.key}"),
        )
        for each in comparison.values
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
        "values", "What differs", tuple(each.label for each in comparison.arms), rows, note, folded
    )


def parts_sections(comparison: Comparison, change: Change, index: int) -> list[Section]:
    """Return the error of each part, and of each kind of error, in both arms, and their shares in
    the change of one arm.
    """
    end, of = (
        ("", "") if len(comparison.changes) == 1 else (f"_{index + 2}", f": {change.arm.label}")
    )
    columns = (comparison.arms[0].label, change.arm.label, "change")
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


def states_sections(comparison: Comparison) -> list[Section]:
    """Return the table of joints whose errors are stated, assumed or ideal in only some arms."""
    if not comparison.states:
        return []
    rows = tuple(
        Row(f"{each.place}, {each.kind}", tuple(map(in_words, each.states)))
        for each in comparison.states
    )
    note = (
        "ideal: nothing is described, taken as perfect; assumed: some value behind it is; -: "
        "there is none"
    )
    return [
        Section(
            "states",
            "What is not equally well known",
            tuple(each.label for each in comparison.arms),
            rows,
            note,
        )
    ]


def figures_section(comparison: Comparison) -> Section:
    """Return the table of the errors of each arm."""
    rows = tuple(
        Row(
            measure.name,
            tuple(
                figure(measure.value(each), measure.unit, counted(each)) for each in comparison.arms
            ),
            key=measure.key,
        )
        for measure in comparison.measures
    )
    return Section(
        "figures",
        "Every arm by itself",
        tuple(each.label for each in comparison.arms),
        rows,
        "as a study of each arm reports them",
    )


def drives_section(comparison: Comparison) -> Section:
    """Return the table of the torques that the drives hold."""
    names = list(dict.fromkeys(joint.name for each in comparison.arms for joint in each.arm.driven))
    rows = []
    for name in names:
        cells, shares = [], []
        for each in comparison.arms:
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
        tuple(each.label for each in comparison.arms),
        tuple(rows),
        "largest over the poses, base as stated",
    )


def arms_section(comparison: Comparison) -> Section:
    """Return the table of the number of moving joints, mass and payload of each arm."""
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
        for each in comparison.arms
    )
    return Section("arms", "The arms", ("moving joints", "mass", "payload"), rows)


def check_section(comparison: Comparison) -> Section:
    """Return the table of the difference between first order and exact composition."""
    rows = []
    for each in comparison.arms:
        check, error = each.sampled.exact, within_of(comparison, each)
        sizes = (length(check.largest), Cell(share_neglected(check, error), "%"))
        rows.append(Row(each.label, sizes, judged(check, error)))
    return Section(
        "exact_check",
        "First order against exact composition",
        ("largest difference", "of the 95 % error"),
        tuple(rows),
    )
