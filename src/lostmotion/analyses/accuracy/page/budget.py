"""The error budget: by part, by kind of error and by level."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.error_model.budget import costs
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import digits
from lostmotion.reporting.chance_levels import INTERVAL_OF_POSES, REMEDIES
from lostmotion.reporting.palette import LEVEL_NAMES
from lostmotion.reporting.sheet import Cell, Row, Section, in_one_unit, length, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.accuracy.answer import Answer
    from lostmotion.error_model.budget import Budget, Cost, Halving
    from lostmotion.error_model.intervals import Estimate

_OFF: Final = "effect of halving on the 95th percentile"
_CANCELLING: Final = "cancels part of the others"
_CANCELS: Final = -5e-4  # shows as -0.1 % or more


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
