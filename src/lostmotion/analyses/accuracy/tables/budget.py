"""The figures of the budget: which part is to blame, and at which level of chance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.error_model.budget import costs
from lostmotion.reporting.chance_levels import INTERVAL_OF_POSES, REMEDIES
from lostmotion.reporting.sheet import Figure, Row, Section, digits, length, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.error_model.budget import Budget, Cost
    from lostmotion.error_model.intervals import Estimate

_LEVELS: Final = ("load and pose", "each robot", "each visit")
_OFF: Final = "halving it takes off the 95 %"
_CANCELS: Final = -5e-4  # shows as -0.1 % or more


def levels_section(found: Budget) -> Section:
    """How much of the mean-square error comes from which level of chance, and what can be done about it?"""
    counted = f"exact sum over terms, {several(found.poses, 'pose')}"
    names = (
        ("from load and pose", REMEDIES[0]),
        ("from how each robot was built", REMEDIES[1]),
        ("from visit to visit", REMEDIES[2]),
    )
    rows = [Row(label, _rms(found, (level,), counted), note) for level, (label, note) in enumerate(names)]
    rows.append(Row("all together", _rms(found, (0, 1, 2), counted)))
    rows.append(Row("left when load and pose are compensated", _rms(found, (1, 2), counted)))
    note = INTERVAL_OF_POSES if len(found.of_sets) > 1 else ""
    return Section("levels", "What can be done about it", ("r.m.s. error", "share of mean square"), tuple(rows), note)


def _rms(found: Budget, levels: tuple[int, ...], counted: str) -> tuple[Figure, Figure]:
    sure = found.sure(*levels)
    share = sum(found.levels[level] for level in levels)
    return length(sure.value, sure.low, sure.high, counted), Figure(100 * share, "%", samples=counted)


def budget_section(answer: Answer) -> Section:
    """Which part is to blame, and what would halving it buy?"""
    halving = answer.halving
    exact = f"exact sum over terms, {several(len(answer.poses), 'pose')}"
    counted = f"{halving.samples} paired samples"
    rows = []
    for cost in costs(answer.sampled.tally):
        gain = halving.gains[cost.part]
        rows.append(
            Row(
                cost.part.removeprefix("joints."),
                (
                    Figure(cost.alone * 1e6, "µm", samples=exact),
                    Figure(100 * cost.share, "%", samples=exact),
                    _gain(gain, counted),
                ),
                "cancels part of the others" if cost.share < _CANCELS else "",
            ),
        )
    read_on = f"{digits(halving.before * 1e3)} mm on the {several(halving.samples, 'sample')} used for it"
    note = (
        "r.m.s. alone: all other parts ideal. Shares of the mean square add to 100 %. Halving: by how much the 95 % error falls when "
        f"this part errs half as much, its interval counting robots and sets of poses; read on {read_on}"
    )
    return Section("budget", "Which part is to blame", ("r.m.s. alone", "share", _OFF), tuple(rows), note)


def causes_section(answer: Answer) -> Section:
    """Which kind of error is to blame, at whichever joint, and what would halving it everywhere buy?"""
    halving = answer.halving
    exact, counted = f"exact sum over terms, {several(answer.budget.poses, 'pose')}", f"{halving.samples} paired samples"
    rows = [
        Row(
            cost.part,
            (Figure(cost.alone * 1e6, "µm", samples=exact), Figure(100 * cost.share, "%", samples=exact), _gain(halving.causes[cost.part], counted)),
            "cancels part of the others" if cost.share < _CANCELS else "",
        )
        for cost in answer.budget.causes
    ]
    note = "the same mean square, put together by kind of error instead of part; halving: that kind of error at every joint"
    return Section("causes", "Which kind of error is to blame", ("r.m.s. alone", "share", _OFF), tuple(rows), note)


def by_level_sections(found: Budget) -> list[Section]:
    """What of each part's share, and of each kind of error's, follows from load and pose, from how a robot was built, from each visit?"""
    return [
        _crossed("budget_levels", "Parts by where their error comes from", found.parts, found),
        _crossed("causes_levels", "Kinds of error by where they come from", found.causes, found),
    ]


def asked_sections(budgets: Sequence[Budget]) -> list[Section]:
    """Which parts and kinds of error are to blame at the poses and in the zones that were asked about, and what would halving them buy there?"""
    out = []
    for k, found in enumerate(budgets, start=1):
        out.append(_crossed(f"budget_at_{k}", f"Which part is to blame: {found.where}", found.parts, found))
        out.append(_crossed(f"causes_at_{k}", f"Which kind of error is to blame: {found.where}", found.causes, found))
        out += halved_sections(f"halving_at_{k}", f"What halving takes off the 95 % error: {found.where}", found)
    return out


def halved_sections(key: str, title: str, found: Budget) -> list[Section]:
    """What would halving each part, and each kind of error, take off the 95 % error there? Nothing where that was not asked or nothing errs."""
    halving = found.halving
    if halving is None or not any(cost.alone > 0 for cost in found.parts):
        return []
    counted = f"{halving.samples} paired samples"
    rows = []
    for erring, gains, everywhere in ((found.parts, halving.gains, ""), (found.causes, halving.causes, ", at every joint")):
        kept = [(gains[cost.part], cost.part.removeprefix("joints.") + everywhere) for cost in erring if cost.alone > 0]
        for gain, name in sorted(kept, key=lambda each: -each[0].value):
            rows.append(Row(name, (_gain(gain, counted),), "cancels part of the others" if gain.high < 0 else ""))
    note = f"parts, then kinds of error; the 95 % error here is {digits(halving.before * 1e3)} mm on {counted}"
    return [Section(key, title, ("taken off",), tuple(rows), note)]


def _crossed(key: str, title: str, found: Sequence[Cost], of: Budget) -> Section:
    exact = f"exact sum over terms, {several(of.poses, 'pose')}"
    rows = [
        Row(cost.part.removeprefix("joints."), (Figure(cost.alone * 1e6, "µm", samples=exact), *_shares(cost, exact)))
        for cost in found
        if cost.alone > 0
    ]
    whole = [sum(cost.levels[k] for cost in found) for k in range(3)]
    shares = (Figure(100 * share, "%", samples=exact) for share in (sum(cost.share for cost in found), *whole))
    rows.append(Row("all together", (Figure(of.rms * 1e6, "µm", samples=exact), *shares)))
    return Section(key, title, ("r.m.s. alone", "share", *_LEVELS), tuple(rows), "shares of the mean square; what makes no error here is left out")


def _shares(cost: Cost, exact: str) -> tuple[Figure, ...]:
    return tuple(Figure(100 * share, "%", samples=exact) for share in (cost.share, *cost.levels))


def _gain(gain: Estimate, counted: str) -> Figure:
    if gain.low == gain.high == 0:  # of what does not move the tool: known, not estimated
        return Figure(0.0, "µm", samples=counted)
    return Figure(gain.value * 1e6, "µm", gain.low * 1e6, gain.high * 1e6, counted)
