"""What errors are made of: the error budget by part, by kind of error and by level; and the
repeatability, with its sentence on the first screen.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.error_model.arrival import arrival, rp_key, rp_name, undescribed_scatter
from lostmotion.error_model.budget import costs
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import digits
from lostmotion.reporting.chance_levels import INTERVAL_OF_POSES, REMEDIES
from lostmotion.reporting.layout import row_at
from lostmotion.reporting.palette import LEVEL_NAMES
from lostmotion.reporting.provenance import as_known, repeats_bounded
from lostmotion.reporting.sheet import (
    Bar,
    Bars,
    Cell,
    Row,
    Section,
    in_one_unit,
    in_words,
    length,
    several,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.accuracy.answer import Answer
    from lostmotion.error_model.budget import Budget, Cost, Halving
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.montecarlo.repeatability import Repeatability

_OFF: Final = "effect of halving on the 95th percentile"
_CANCELLING: Final = "cancels part of the others"
_CANCELS: Final = -5e-4  # shows as -0.1 % or more
_MADE_OF: Final = "rp_made_of"
_AT_LEAST: Final = "at least "
# Causes that the first screen names, with at least this share.
_MOST_CAUSES: Final = 2
_LEAST_SHARE: Final = 0.05


def levels_section(budget: Budget) -> Section:
    """Return the mean-square error by level, and what remedies leave."""
    counted = f"exact sum over terms, {several(budget.poses, 'pose')}"
    names = (
        ("from load and pose", REMEDIES[0]),
        ("from the manufacture of each robot", REMEDIES[1]),
        ("from visit to visit", REMEDIES[2]),
    )
    lines: list[tuple[str, tuple[int, ...], str]] = [
        (label, (level,), note) for level, (label, note) in enumerate(names)
    ]
    lines += [
        ("all together", (0, 1, 2), ""),
        ("left after compensation of load and pose", (1, 2), ""),
    ]
    rms = in_one_unit([_rms(budget, levels, counted) for _, levels, _ in lines])
    shares = [
        Cell(sum(budget.levels[level] for level in levels), "%", samples=counted)
        for _, levels, _ in lines
    ]
    rows = [
        Row(label, (size, share), note)
        for (label, _, note), size, share in zip(lines, rms, shares, strict=True)
    ]
    note = INTERVAL_OF_POSES if len(budget.squares.visited) > 1 else ""
    return Section(
        "levels",
        "What can be compensated",
        ("r.m.s. error", "share of mean square"),
        tuple(rows),
        note,
    )


def _rms(budget: Budget, levels: tuple[int, ...], counted: str) -> Cell:
    rms = budget.rms_interval(*levels)
    return length(rms.value, rms.low, rms.high, counted)


def budget_section(answer: Answer) -> Section:
    """Return the error budget by part, with the effect of halving each."""
    halving = answer.halving
    found = costs(answer.sampled.tally)
    rows = _halved_rows(
        found, [halving.gains[cost.part] for cost in found], len(answer.poses), halving
    )
    read_on = f"{digits(halving.before * 1e3)} mm on {several(halving.samples, 'sample')}"
    note = (
        "r.m.s. alone: all other parts ideal. Shares of the mean square add to 100 %. "
        "Halving: reduction of the 95th percentile when "
        "this part's errors are halved, its interval counting robots and sets of poses; from "
        f"{read_on}"
    )
    return Section("budget", "Which part is to blame", ("r.m.s. alone", "share", _OFF), rows, note)


def causes_section(answer: Answer) -> Section:
    """Return the error budget by kind of error, at any joint, with the effect of halving it at all
    joints.
    """
    halving, found = answer.halving, answer.budget.causes
    rows = _halved_rows(
        found, [halving.causes[cost.part] for cost in found], answer.budget.poses, halving
    )
    note = (
        "the same mean square, by kind of error instead of part; halving: that kind of error at "
        "every joint"
    )
    return Section(
        "causes", "Error budget by kind of error", ("r.m.s. alone", "share", _OFF), rows, note
    )


def _halved_rows(
    contributions: Sequence[Cost], gains: Sequence[Estimate], poses: int, halving: Halving
) -> tuple[Row, ...]:
    """Return a row for each contributor: its error alone, its share, and what halving it takes
    off.
    """
    exact, counted = (
        f"exact sum over terms, {several(poses, 'pose')}",
        f"{halving.samples} paired samples",
    )
    alone = in_one_unit([length(cost.alone, samples=exact) for cost in contributions])
    taken = in_one_unit([_gain(gain, counted) for gain in gains])
    return tuple(
        Row(
            short_name(cost.part),
            (size, Cell(cost.share, "%", samples=exact), off),
            _CANCELLING if cost.share < _CANCELS else "",
        )
        for cost, size, off in zip(contributions, alone, taken, strict=True)
    )


def by_level_sections(budget: Budget) -> list[Section]:
    """Return the shares of parts and of kinds of error, split by level."""
    return [
        _crossed("budget_levels", "Parts by origin of their error", budget.parts, budget),
        _crossed("causes_levels", "Kinds of error by origin", budget.causes, budget),
    ]


def requested_sections(budgets: Sequence[Budget]) -> list[Section]:
    """Return the error budgets at stated poses and in zones, with the effect of halving there."""
    out = []
    for k, found in enumerate(budgets, start=1):
        out.append(
            _crossed(f"budget_at_{k}", f"Which part is to blame: {found.where}", found.parts, found)
        )
        out.append(
            _crossed(
                f"causes_at_{k}",
                f"Error budget by kind of error: {found.where}",
                found.causes,
                found,
            )
        )
        out += halved_sections(
            f"halving_at_{k}", f"Effect of halving on the 95th percentile: {found.where}", found
        )
    return out


def halved_sections(key: str, title: str, budget: Budget) -> list[Section]:
    """Return the effect of halving each part and each kind of error there; nothing where that was
    not asked or no error is described.
    """
    halving = budget.halving
    if halving is None or not any(cost.alone > 0 for cost in budget.parts):
        return []
    counted = f"{halving.samples} paired samples"
    rows = []
    for erring, gains, everywhere in (
        (budget.parts, halving.gains, ""),
        (budget.causes, halving.causes, ", at every joint"),
    ):
        kept = [
            (gains[cost.part], short_name(cost.part) + everywhere)
            for cost in erring
            if cost.alone > 0
        ]
        kept.sort(key=lambda each: -each[0].value)
        taken = in_one_unit([_gain(gain, counted) for gain, _ in kept])
        rows += [
            Row(name, (off,), _CANCELLING if gain.high < 0 else "")
            for (gain, name), off in zip(kept, taken, strict=True)
        ]
    note = (
        f"parts, then kinds of error; the 95th percentile here is {digits(halving.before * 1e3)} "
        f"mm on {counted}"
    )
    return [Section(key, title, ("taken off",), tuple(rows), note)]


def _crossed(key: str, title: str, contributions: Sequence[Cost], of: Budget) -> Section:
    exact = f"exact sum over terms, {several(of.poses, 'pose')}"
    erring = [cost for cost in contributions if cost.alone > 0]
    *alone, together = in_one_unit(
        [length(size, samples=exact) for size in (*(cost.alone for cost in erring), of.rms)]
    )
    rows = [
        Row(short_name(cost.part), (size, *_shares(cost, exact)))
        for cost, size in zip(erring, alone, strict=True)
    ]
    whole = [sum(cost.levels[k] for cost in contributions) for k in range(3)]
    shares = (
        Cell(share, "%", samples=exact)
        for share in (sum(cost.share for cost in contributions), *whole)
    )
    rows.append(Row("all together", (together, *shares)))
    return Section(
        key,
        title,
        ("r.m.s. alone", "share", *LEVEL_NAMES),
        tuple(rows),
        "shares of the mean square; parts without an error here are omitted",
    )


def _shares(cost: Cost, exact: str) -> tuple[Cell, ...]:
    return tuple(Cell(share, "%", samples=exact) for share in (cost.share, *cost.levels))


def _gain(gain: Estimate, counted: str) -> Cell:
    if gain.low == gain.high == 0:  # of what does not move the tool: known, not estimated
        return length(0.0, samples=counted)
    return length(gain.value, gain.low, gain.high, counted)


def made_of_sections(repeats: Sequence[Repeatability]) -> list[Section]:
    """Return the shares of each kind of error in the mean square between visits, for each way to
    arrive; nothing without scatter.
    """
    shares = [dict(each.causes) for each in repeats]
    names = sorted(
        {name for of in shares for name in of},
        key=lambda name: [-of.get(name, 0.0) for of in shares],
    )
    if not names:
        return []
    rows = []
    for name in names:
        figures = (
            in_words("not predicted")
            if each.none
            else Cell(
                of.get(name, 0.0),
                "%",
                samples=f"exact sum over terms, {several(len(each.poses), 'pose')}",
            )
            for of, each in zip(shares, repeats, strict=True)
        )
        rows.append(Row(short_name(name), tuple(figures)))
    note = (
        "share of the mean square between visits, by kind of error. RP is not a sum of them, "
        "but grows with its root. In the ISO cycle each joint "
        "arrives from one side: the side of backlash and hysteresis adds a constant, and "
        "servo, encoder, friction and open clearances scatter"
    )
    return [
        Section(
            _MADE_OF,
            "What RP is made of",
            tuple(arrival(each.approach) for each in repeats),
            tuple(rows),
            note,
        )
    ]


def with_made_of_bars(
    sections: Sequence[Section], repeats: Sequence[Repeatability], arm: Arm, known: States
) -> tuple[Section, ...]:
    """Return the sections of a study, the table of what RP is made of with a block of bars of each
    of its columns that is predicted.
    """
    made_of = next((section for section in sections if section.key == _MADE_OF), None)
    if made_of is None:
        return tuple(sections)
    blocks = []
    for column, each in enumerate(repeats):
        row = _row_of(sections, each)
        if row is None or each.none:
            continue
        bound = _bounded(row.cells[0], each, arm, known)
        shown = tuple(
            Bar(of.label, of.cells[column], of.cells[column].value) for of in made_of.rows
        )
        note = "shares of what is described" if bound.startswith(_AT_LEAST) else ""
        title = f"{rp_name(each.approach)}: {bound}"
        blocks.append(Bars(_MADE_OF, title, "share of the mean square", shown, note=note, most=1.0))
    return tuple(
        replace(section, bars=tuple(blocks)) if section is made_of else section
        for section in sections
    )


def repeatability_statement(
    sections: Sequence[Section],
    repeats: Sequence[Repeatability],
    arm: Arm,
    known: States,
) -> str:
    """Return the sentence on RP in the standard's cycle and from any approach, each with its
    largest causes; empty for a study of one visit.
    """
    if not repeats:
        return ""
    if all(each.none for each in repeats):
        return "No described error differs between visits, so no repeatability is predicted."
    clauses = []
    for each in repeats:
        row, name = _row_of(sections, each), rp_name(each.approach)
        if row is None or each.none:
            clauses.append(f"{name}: not predicted, no described error differs between visits")
            continue
        causes = "; ".join(filter(None, (_largest(each), _lacking(_missing(each, arm)))))
        clauses.append(
            f"{name} {_bounded(as_known(row.cells[0], known), each, arm, known)} ({causes})"
        )
    return f"{'; '.join(clauses)}, for 95 % of the robots."


def _row_of(sections: Sequence[Section], each: Repeatability) -> Row | None:
    """Return the row of this RP, of which 95 % of the robots are within."""
    return row_at(sections, "iso9283", f"{rp_key(each.approach)}_p95")


def _bounded(figure: Cell, each: Repeatability, arm: Arm, known: States) -> str:
    """Return an RP, as a bound where kinds of error are missing, the scatter that one-sided RP
    comes from among them.
    """
    bound = repeats_bounded(figure, known)
    return (
        f"{_AT_LEAST}{figure}" if _missing(each, arm) and not bound.startswith(_AT_LEAST) else bound
    )


def _missing(each: Repeatability, arm: Arm) -> tuple[str, ...]:
    return undescribed_scatter(arm) if each.approach else ()


def one_sided_bounded(sections: Sequence[Section], arm: Arm) -> tuple[Section, ...]:
    """Return sections, RP in the ISO cycle as a lower bound where a joint describes neither a dead
    band nor a scatter of friction.
    """
    if not undescribed_scatter(arm):
        return tuple(sections)
    return tuple(
        replace(section, rows=tuple(map(_one_sided_bounded, section.rows))) for section in sections
    )


def _one_sided_bounded(row: Row) -> Row:
    if not row.key.startswith(rp_key(1.0)):
        return row
    return replace(
        row,
        cells=tuple(
            figure if figure.words else replace(figure, bound="lower") for figure in row.cells
        ),
    )


def _largest(repeatability: Repeatability) -> str:
    named = [(name, share) for name, share in repeatability.causes if share >= _LEAST_SHARE][
        :_MOST_CAUSES
    ]
    return ", ".join(f"{short_name(name)} {Cell(share, '%')}" for name, share in named)


def _lacking(missing: Sequence[str]) -> str:
    return f"{several(len(missing), 'joint')} without servo or friction scatter" if missing else ""
