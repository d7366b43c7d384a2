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
from lostmotion.reporting.layout import key_of
from lostmotion.reporting.sheet import Cell, Row, Section, length, several

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.analyses.targets.solver import Allocation, Allowance
    from lostmotion.analyses.targets.targets import Target
    from lostmotion.error_model.items import Item, Size

# An item whose removal changes the figure by less is only counted.
_SMALLEST_CHANGE: Final = 0.002
_NOT_LIMITING: Final = "not limiting"


def item_sections(result: Target) -> list[Section]:
    """Return the tables of all items, each item in one table of allowances."""
    return [
        *_one_at_a_time(result),
        *_shared(result),
        *_out_of_reach(result),
        *_usual(result),
        *_any(result),
        *_allocations(result),
    ]


def ordered(allowances: Iterable[Allowance]) -> list[Allowance]:
    """Return those with an allowed size, the tightest first."""
    return sorted(
        (each for each in allowances if each.verdict == "sized"), key=lambda each: each.factor.value
    )


def figure_of(estimate: Estimate, samples: str = "") -> Cell:
    """Return a length with its interval."""
    return length(estimate.value, estimate.low, estimate.high, samples)


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


def _one_at_a_time(result: Target) -> list[Section]:
    note = (
        "all other items unchanged; tightest first. Verified: error or RP with that size, by "
        "Monte Carlo. ?: end of an interval without a solution"
    )
    return _allowance_section(
        result, "single", "Allowance for one item at a time", result.allowances, note
    )


def _shared(result: Target) -> list[Section]:
    note = (
        "the same cause in all parts of a kind, all other items unchanged; a size where all parts "
        "have the same"
    )
    return _allowance_section(
        result,
        "kinds",
        "Allowance for one cause in all parts of a kind",
        result.shared_allowances,
        note,
    )


def _allowance_section(
    result: Target, key: str, title: str, allowances: Sequence[Allowance], note: str
) -> list[Section]:
    rows = []
    for each in ordered(allowances):
        verified = (
            Cell(math.nan, "mm")
            if each.verified is None
            else figure_of(each.verified, verification_samples(result))
        )
        figures = (
            replace(size_at(each.item, each.factor), samples=solver_samples(result)),
            verified,
        )
        rows.append(_row(each.item, figures, _note(each)))
    return [Section(key, title, ("allowed", "verified"), tuple(rows), note)] if rows else []


def _row(item: Item, figures: tuple[Cell, ...], note: str = "") -> Row:
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
    rows = []
    for each in listed:
        figures = (
            stated_size(each.item),
            figure_of(each.without, solver_samples(result)),
            Cell(each.share, "%", samples=_exact(result)),
        )
        rows.append(_row(each.item, figures))
    note = (
        "without the item (zero size, or infinite stiffness) the remaining items exceed the "
        f"target of {length(result.target, stated=True)}"
    )
    if len(every) > len(listed):
        note += (
            f". The same holds for {several(len(every) - len(listed), 'more item')}, each with an "
            f"effect below {100 * _SMALLEST_CHANGE:g} %"
        )
    columns = ("as stated", "without it", "share")
    return (
        [Section("none", "Items that cannot meet the target alone", columns, tuple(rows), note)]
        if every
        else []
    )


def _exact(result: Target) -> str:
    return f"exact sum over terms, {several(len(result.poses), 'pose')}"


def _any(result: Target) -> list[Section]:
    """Return the items of any size, those of a kind in one row."""
    groups: dict[tuple[str, str], list[Allowance]] = {}
    for each in result.allowances:
        if each.verdict == "any":
            groups.setdefault((each.item.kind, each.item.cause), []).append(each)
    rows = []
    for (kind, cause), members in groups.items():
        names = ", ".join(_where(each.item) for each in members)
        rows.append(
            Row(
                f"{kind} {cause}",
                (Cell(sum(each.share for each in members), "%", samples=_exact(result)),),
                names,
            )
        )
    note = "they do not move the tool, or too rarely to affect the target"
    if result.kind == "repeatability":
        note = "they do not differ between the visits of a robot"
    return (
        [Section("any", "Any size meets the target", ("share",), tuple(rows), note)] if rows else []
    )


def _usual(result: Target) -> list[Section]:
    """Return the items that meet the target at every usual size, those of a kind in one row."""
    groups: dict[tuple[str, str, float], list[Allowance]] = {}
    for each in (*result.allowances, *result.shared_allowances):
        if each.verdict == "usual":
            limit = usual_limit(each.item).value
            key = (
                (each.item.kind, each.item.cause, limit)
                if each in result.allowances
                else (each.item.name, "", limit)
            )
            groups.setdefault(key, []).append(each)
    rows = []
    for (kind, cause, _), members in groups.items():
        names = ", ".join(_where(each.item) for each in members) if cause else "all of them"
        share = Cell(sum(each.share for each in members), "%", samples=_exact(result))
        rows.append(Row(f"{kind} {cause}".strip(), (usual_limit(members[0].item), share), names))
    note = "all other items unchanged, the target is met even at the largest usual size"
    return (
        [
            Section(
                "usual",
                "Not limiting: any usual value meets the target",
                ("usual up to", "share"),
                tuple(rows),
                note,
            )
        ]
        if rows
        else []
    )


def _where(item: Item) -> str:
    """Return the joint of an item, or the base."""
    return short_name(item.owner).rpartition(".")[0] or "base"


def _allocations(result: Target) -> list[Section]:
    factor, effect = result.equal_factor, result.equal_effect
    if factor is None:
        return []
    rows = []
    shares = {each.item.name: each.share for each in result.allowances}
    for k, item in sorted(enumerate(result.items), key=lambda one: -shares[one[1].name]):
        if np.isfinite(factor.factors[k]):
            figures = (
                stated_size(item),
                size_at(item, exactly(float(factor.factors[k]))),
                _of_equal_effect(item, k, effect),
                Cell(shares[item.name], "%", samples=_exact(result)),
            )
            rows.append(
                _row(
                    item,
                    figures,
                    ""
                    if item.size is not None
                    else f"of its present {'stiffness' if 'stiffness' in item.cause else 'error'}",
                )
            )
    of = "the mean square" if result.kind == "error" else "the mean square between visits"
    note = f"share: of {of} as stated; {_allocation_note(factor, effect)}"
    return [
        Section(
            "together",
            "Allocation to all items",
            ("as stated", "equal factor", "equal effect", "share"),
            tuple(rows),
            note,
        )
    ]


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


def in_unit(size: Size, factor: float) -> Cell:
    """Return the size with which the errors are `factor` times as large, in a practical unit."""
    value = size.at(factor)
    if size.unit == "rad":
        return Cell(value, "arcmin")
    if size.unit == "N m/rad":
        return Cell(value, "N m/arcmin")
    if size.unit == "K":
        return Cell(value, "K")
    return Cell(value, "N/µm") if size.unit == "N/m" else length(value)


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
