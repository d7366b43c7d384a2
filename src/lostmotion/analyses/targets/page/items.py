"""Tables of the items of a target: allowances one at a time, items that do not limit it, and
allocations to all items.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.intervals import Estimate
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import suited
from lostmotion.reporting.layout import key_of
from lostmotion.reporting.sheet import Cell, Row, cell, length, several, table

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.analyses.targets.targets import Target
    from lostmotion.error_model.items import Item, StatedSize
    from lostmotion.reporting.sheet import Section
    from lostmotion.sizing.allowances import Allocation, Allowance

# An item whose removal changes the figure by less is only counted.
_SMALLEST_CHANGE: Final = 0.002
_NOT_LIMITING: Final = "not limiting"


def item_sections(result: Target) -> list[Section]:
    """Return the tables of all items, each item in one table of allowances."""
    single = (
        "all other items unchanged; tightest first. Verified: error or RP with that size, by "
        "Monte Carlo. ?: end of an interval without a solution"
    )
    shared = (
        "the same cause in all parts of a kind, all other items unchanged; a size where all parts "
        "have the same"
    )
    of_kinds = "Allowance for one cause in all parts of a kind"
    sections = [
        _allowed(
            result, "single", "Allowance for one item at a time", result.allowances, note=single
        ),
        _allowed(result, "kinds", of_kinds, result.shared_allowances, note=shared),
        *_out_of_reach(result),
        _usual(result),
        _any(result),
        *_allocations(result),
    ]
    return [section for section in sections if section.rows or section.key == "none"]


def ordered(allowances: Iterable[Allowance]) -> list[Allowance]:
    """Return those with an allowed size, the tightest first."""
    return sorted(
        (each for each in allowances if each.verdict == "sized"), key=lambda each: each.factor.value
    )


def solver_samples(result: Target) -> str:
    """Return the samples that allowances were solved with, as text."""
    if result.kind == "error":
        return (
            f"{several(result.solved_samples, 'sample')} at "
            f"{several(result.solved_poses, 'pose')}, each with its own robot and visit"
        )
    return (
        f"{several(result.solved_samples, 'sample')}: robots x visits x "
        f"{several(result.solved_poses, 'pose')}"
    )


def verification_samples(result: Target) -> str:
    """Return the samples of the Monte Carlo study that verifies, as text."""
    return (
        f"{several(result.robots, 'robot')} x {several(result.verified_visits, 'visit')} x "
        f"{several(len(result.poses), 'pose')} ({result.poses.law})"
    )


def _allowed(
    result: Target, key: str, title: str, allowances: Sequence[Allowance], *, note: str
) -> Section:
    solved, verified = solver_samples(result), verification_samples(result)
    rows = (
        _row(
            each.item,
            replace(size_at(each.item, each.factor), samples=solved),
            Cell(math.nan, "mm") if each.verified is None else cell(each.verified, "m", verified),
            note=_note(each),
        )
        for each in ordered(allowances)
    )
    return table(key, title, ["allowed", "verified"], rows, note)


def _row(item: Item, *figures: Cell, note: str = "") -> Row:
    """Return the row of an item, under the full name of its part in result.json."""
    return Row(short_name(item.name), figures, note, key_of(item.name))


def _note(each: Allowance) -> str:
    factor = f"error {times(each.factor.value)} as large"
    if each.item.size is not None:
        notes = [f"as stated {stated_size(each.item)}; {factor}"]
    else:
        notes = [
            f"of its stated stiffness; {factor}" if each.item.stiff else "of its present error"
        ]
    if each.item.size is not None and each.item.size.zones > 1:
        notes.append(f"first of {each.item.size.zones} zones, all scaled by one factor")
    if len(each.ranges) > 1 or each.ranges[0][0] > 0:
        spans = " and ".join(
            f"{low:.3g} to {'any' if math.isinf(high) else f'{high:.3g}'}"
            for low, high in each.ranges
        )
        notes.append(f"it cancels other items: only factors from {spans} meet the target")
    return "; ".join(notes)


def _out_of_reach(result: Target) -> list[Section]:
    every = sorted(
        (
            each
            for each in (*result.allowances, *result.shared_allowances)
            if each.verdict == "none"
        ),
        key=lambda each: each.without.value,
    )
    listed = [
        each
        for each in every
        if each.without.value < (1 - _SMALLEST_CHANGE) * result.current_by_solver.value
    ]
    solved, exact = solver_samples(result), _exact(result)
    rows = (
        _row(
            each.item,
            stated_size(each.item),
            cell(each.without, "m", solved),
            Cell(each.share, "%", samples=exact),
        )
        for each in listed
    )
    note = (
        "without the item (zero size, or infinite stiffness) the remaining items exceed the "
        f"target of {length(result.target, stated=True)}"
    )
    if len(every) > len(listed):
        note += (
            f". The same holds for {several(len(every) - len(listed), 'more item')}, each with an "
            f"effect below {100 * _SMALLEST_CHANGE:g} %"
        )
    title = "Items that cannot meet the target alone"
    columns = ["as stated", "without it", "share"]
    return [table("none", title, columns, rows, note)] if every else []


def _exact(result: Target) -> str:
    return f"exact sum over terms, {several(len(result.poses), 'pose')}"


def _any(result: Target) -> Section:
    """Return the items of any size, those of a kind in one row."""
    groups: dict[tuple[str, str], list[Allowance]] = {}
    for each in result.allowances:
        if each.verdict == "any":
            groups.setdefault((each.item.kind, each.item.cause), []).append(each)
    rows = (
        (
            f"{kind} {cause}",
            sum(each.share for each in members),
            ", ".join(_where(each.item) for each in members),
        )
        for (kind, cause), members in groups.items()
    )
    note = (
        "they do not differ between the visits of a robot"
        if result.kind == "repeatability"
        else "they do not move the tool, or too rarely to affect the target"
    )
    return table(
        "any", "Any size meets the target", {"share": "%"}, rows, note, samples=_exact(result)
    )


def _usual(result: Target) -> Section:
    """Return the items that meet the target at every usual size, those of a kind in one row."""
    groups: dict[tuple[str, str, float], list[Allowance]] = {}
    for each in (*result.allowances, *result.shared_allowances):
        if each.verdict == "usual":
            alone = each in result.allowances
            named = (each.item.kind, each.item.cause) if alone else (each.item.name, "")
            groups.setdefault((*named, usual_limit(each.item).value), []).append(each)
    exact = _exact(result)
    rows = (
        (
            f"{kind} {cause}".strip(),
            usual_limit(members[0].item),
            Cell(sum(each.share for each in members), "%", samples=exact),
            ", ".join(_where(each.item) for each in members) if cause else "all of them",
        )
        for (kind, cause, _), members in groups.items()
    )
    title = "Not limiting: any usual value meets the target"
    note = "all other items unchanged, the target is met even at the largest usual size"
    return table("usual", title, ["usual up to", "share"], rows, note)


def _where(item: Item) -> str:
    """Return the joint of an item, or the base."""
    return short_name(item.owner).rpartition(".")[0] or "base"


def _allocations(result: Target) -> list[Section]:
    factor, effect = result.equal_factor, result.equal_effect
    if factor is None:
        return []
    shares = {each.item.name: each.share for each in result.allowances}
    rows = (
        _row(
            item,
            stated_size(item),
            size_at(item, exactly(float(factor.factors[k]))),
            _of_equal_effect(item, k, effect),
            Cell(shares[item.name], "%", samples=_exact(result)),
            note=""
            if item.size is not None
            else f"of its present {'stiffness' if 'stiffness' in item.cause else 'error'}",
        )
        for k, item in sorted(enumerate(result.items), key=lambda one: -shares[one[1].name])
        if np.isfinite(factor.factors[k])
    )
    of = "the mean square" if result.kind == "error" else "the mean square between visits"
    note = f"share: of {of} as stated; {_allocation_note(factor, effect)}"
    columns = ["as stated", "equal factor", "equal effect", "share"]
    return [table("together", "Allocation to all items", columns, rows, note)]


def _of_equal_effect(item: Item, k: int, effect: Allocation | None) -> Cell:
    if effect is None:
        return Cell(math.nan, "1")
    size = size_at(item, exactly(float(effect.factors[k])))
    return replace(size, value=math.nan, words=_NOT_LIMITING) if effect.not_limiting[k] else size


def _allocation_note(factor: Allocation, effect: Allocation | None) -> str:
    note = (
        f"equal factor: {float(np.nanmax(factor.factors)):.3g} on all errors, "
        f"{_uncertainty(factor)}"
    )
    if effect is None:
        return f"{note}. No sizes have equal effect, because items cancel each other at every size"
    limiting = np.isfinite(effect.factors) & ~effect.not_limiting
    if not limiting.any():
        return f"{note}. Equal effect: every item may have its largest usual size"
    each = float(np.sqrt(effect.mean_squares[limiting].mean()))
    rest = (
        f"; {_NOT_LIMITING}: any usual value, counted at the largest"
        if effect.not_limiting.any()
        else ""
    )
    return (
        f"{note}. Equal effect: {length(each)} r.m.s. from each item, {_uncertainty(effect)}{rest}"
    )


def _uncertainty(allocation: Allocation) -> str:
    """Return the relative uncertainty of allocated sizes as text."""
    relative = allocation.value.half / allocation.value.value
    return (
        f"uncertainty {float(f'{100 * relative:.1g}'):g} %"
        if math.isfinite(relative)
        else "uncertainty not known from so few robots"
    )


def in_unit(size: StatedSize, factor: float) -> Cell:
    """Return the size with which the errors are `factor` times as large, in a practical unit."""
    value = size.at(factor)
    return Cell(value, "N/µm" if size.unit == "N/m" else suited(value, size.unit))


def size_at(item: Item, factor: Estimate) -> Cell:
    """Return an item's size at a factor with its interval; for an item without a size, its error or
    stiffness in per cent of the present one.
    """
    stiff = item.stiff
    if item.size is None:
        values = [
            1 / each if stiff and each else math.inf if stiff else each
            for each in (factor.value, factor.low, factor.high)
        ]
        low, high = (values[2], values[1]) if stiff else (values[1], values[2])
        return Cell(values[0], "%", low, high)
    one = in_unit(item.size, factor.value)
    ends = [in_unit(item.size, each) for each in (factor.low, factor.high)]
    low, high = (each.value for each in (ends[::-1] if item.size.divides else ends))
    return replace(one, low=low, high=high)


def stated_size(item: Item) -> Cell:
    """Return an item's size as stated; 100 % for an item without a size."""
    return replace(Cell(1.0, "%") if item.size is None else in_unit(item.size, 1.0), stated=True)


def times(factor: float) -> str:
    """Return a factor as text, with three digits or whole."""
    return f"{factor:.3g} times" if factor < 1000 else f"{factor:.0f} times"  # noqa: PLR2004 - no powers of ten among words


def usual_limit(item: Item) -> Cell:
    """Return the largest usual size of an item (the smallest stiffness), in the form of
    `size_at`.
    """
    figure = size_at(item, exactly(item.most))
    return replace(figure, stated=True)


def exactly(factor: float) -> Estimate:
    """Return a factor without an interval."""
    return Estimate(factor, math.nan, math.nan)
