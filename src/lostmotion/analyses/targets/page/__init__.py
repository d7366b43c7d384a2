"""Sheet of a target: present figure, allowances, allocations and yield."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.targets.page.items import (
    item_sections,
    ordered,
    size_at,
    solver_samples,
    stated_size,
    verification_samples,
)
from lostmotion.analyses.targets.page.plots import plots
from lostmotion.analyses.targets.page.yields import (
    allocated,
    allocated_section,
    yield_facts,
    yield_figure,
    yield_section,
)
from lostmotion.error_model.arrival import rp_name
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.arm_sheet import sections_as_known, with_arm
from lostmotion.reporting.first_order import with_falls
from lostmotion.reporting.provenance import (
    as_known,
    at_least,
    by_what_is_described,
    caveats,
    repeats_bounded,
    share_within_bounded,
    size_as_known,
)
from lostmotion.reporting.sheet import Card, Cell, Section, Sheet, cell, length, several, table

if TYPE_CHECKING:
    from typing import Any

    from lostmotion.analyses.targets.targets import Target
    from lostmotion.error_model.provenance import States
    from lostmotion.sizing.allowances import Allocation, Allowance

__all__ = ["plots", "sheet"]
_WORDS: Final = (
    (
        "item",
        (
            "one cause in one part: the backlash of a gearbox, the clearance of a bearing, the "
            "stiffness of a link. Its ± tolerance scales with it."
        ),
    ),
    (
        "factor",
        "on the item's error, inverse for a stiffness: twice the error is half the stiffness.",
    ),
    ("one item at a time", "all other items, loads and masses are unchanged."),
    ("equal factor", "all errors scaled by the same factor."),
    (
        "equal effect",
        "tolerance allocation in which every item contributes the same part of the mean square.",
    ),
    (
        "not limiting",
        (
            "met even at the largest usual size: 60' of backlash, 100 counts per turn, 200 µm of "
            "clearance, 1 % of a length, a tenth of a stiffness."
        ),
    ),
    (
        "share",
        (
            "of the mean square as stated, for repeatability of its part between visits. Shares "
            "add to 100 %; a negative one cancels others."
        ),
    ),
    (
        "yield",
        (
            "share of robots that meet the target, each judged by its own figure; its confidence "
            "interval is exact and counts robots."
        ),
    ),
    ("verified", "by a Monte Carlo study with the sizes listed, on independent draws."),
)


def sheet(result: Target) -> Sheet:
    """Return the sheet of a target."""
    where = f" in {result.zone}" if result.zone else ""
    counted = (
        f"{several(result.robots, 'robot')} x {several(result.visits, 'visit')} x "
        f"{several(len(result.poses), 'pose')}{where}, seed {result.seed}"
    )
    yields = (yield_section(result, _target(result)), *allocated_section(result, _target(result)))
    known = with_limits(result.states, result.arm, result.poses.q, result.approach)
    return with_arm(
        Sheet(
            subject="allowances of its parts for a target",
            verdict=with_falls(_verdict(result, known), result.arm),
            cards=tuple(_cards(result, known)),
            sections=(
                _whole(result, known),
                *sections_as_known(item_sections(result), known, size_as_known),
                *yields,
            ),
            counts=counted,
            notes=tuple(_remarks(result)),
            words=_WORDS,
            source=(
                f"seed {result.seed}: {counted}, {result.poses.law}. The same arm, version, seed, "
                "counts and target give the same bytes."
            ),
            seed=result.seed,
            facts=_facts(result),
        ),
        result.arm,
        known,
        sections=("target",),
    )


def is_met(result: Target) -> bool:
    """Return whether the arm as stated meets the target."""
    return result.current.value <= result.target


def _quantity(result: Target) -> str:
    """Return the name of the figure that is compared with the target."""
    share = f"{100 * result.share:g} %"
    where = f" in {result.zone}" if result.zone else ""
    return (
        f"error, {share} of positions{where}"
        if result.kind == "error"
        else f"{rp_name(result.approach)}, {share} of robots{where}"
    )


def _whole(result: Target, known: States) -> Section:
    met = (
        f"met {'by what is described' if known.lower_bound else 'as stated'}"
        if is_met(result)
        else "not met as stated"
    )
    verified = verification_samples(result)
    rows = [
        ("target", _target(result), f"{_quantity(result)}; {met}"),
        ("as stated", cell(result.current, "m", verified), "by Monte Carlo"),
        (
            "as stated, by the solver",
            cell(result.current_by_solver, "m", solver_samples(result)),
            "independent estimate, for comparison",
        ),
        *(
            (
                f"allocation by {name.replace('_', ' ')}",
                cell(allocation.verified, "m", verified),
                "verified, sizes below",
            )
            for name, allocation in allocated(result)
        ),
    ]
    return table("target", "Target", ["value"], rows)


def _target(result: Target) -> Cell:
    return length(result.target, stated=True)


def _verdict(result: Target, known: States) -> str:
    figure = as_known(cell(result.current, "m"), known)
    current = f"{figure}{f' ({figure.interval})' if figure.interval else ''}"
    text = (
        f"{100 * result.share:g} % of positions are within {at_least(current, known)}"
        if result.kind == "error"
        else f"{100 * result.share:g} % of robots repeat within {repeats_bounded(current, known)}"
    )
    text += (
        f": the target of {_target(result)} is "
        f"{'met' if is_met(result) else 'not met'}{by_what_is_described(known, met=is_met(result))}."  # noqa: E501
    )
    if known.lower_bound:
        text += " The sizes below leave no room for what is missing."
    if result.equal_factor is not None:
        factor = float(np.nanmax(result.equal_factor.factors))
        text += (
            f" All errors {'may grow' if factor > 1 else 'must shrink'} together to "
            f"{_factor(factor, known)} of their present size."
        )
    single = ordered(result.allowances)
    if is_met(result) and single:
        one = single[0]
        text += (
            f" The tightest item is {short_name(one.item.name)}: stated {stated_size(one.item)}, "
            f"allowed {_allowed(one, known)}."
        )
    elif single:
        alone = ", ".join(
            f"{short_name(each.item.name)} ({stated_size(each.item)} to {_allowed(each, known)})"
            for each in reversed(single[-2:])
        )
        text += (
            f" Or one item alone changes; the smallest change{'s' if len(single) > 1 else ''}: "
            f"{alone}."
        )
    elif not is_met(result):
        rest = min((each.without.value for each in result.allowances), default=result.current.value)
        least = as_known(length(rest), known)
        text += f" No single item is enough: without it the figure is at least {least}."
        if shared := ordered(result.shared_allowances):
            last = shared[-1]
            text += (
                f" One cause in all parts of a kind is enough: {last.item.name} "
                f"({stated_size(last.item)} to {_allowed(last, known)})."
            )
    first = yield_figure(result.yields[0])
    text += f" The yield is {share_within_bounded(first, known)} ({first.interval})."
    if result.equal_effect is not None:
        allocated_yield = yield_figure(result.equal_effect.yields[0])
        text += (
            f" With the sizes of equal effect it is {share_within_bounded(allocated_yield, known)} "
            f"({allocated_yield.interval})."
        )
    return " ".join([text, *caveats(known)])


def _factor(factor: float, known: States) -> str:
    """Return a factor on all errors as text, with one digit where every drive is assumed."""
    return str(size_as_known(Cell(factor, "1"), known)) if known.presets else f"{factor:.3g}"


def _allowed(each: Allowance, known: States) -> Cell:
    """Return the allowed size without its interval."""
    return size_as_known(size_at(each.item, each.factor).alone, known)


def _cards(result: Target, known: States) -> list[Card]:
    current = as_known(cell(result.current, "m"), known)
    out = [
        Card("target", str(_target(result)), _quantity(result)),
        Card(
            "as stated",
            str(current),
            f"interval {current.interval}" if current.interval else "",
            limited_as="error" if result.kind == "error" else "repeatability",
        ),
    ]
    if result.equal_factor is not None:
        factor = float(np.nanmax(result.equal_factor.factors))
        out.append(
            Card(
                "equal factor on all errors",
                f"{_factor(factor, known)} times",
                "their present size",
            )
        )
    single = ordered(result.allowances)
    if single:
        one = single[0] if is_met(result) else single[-1]
        out.append(
            Card(
                "allowed size of the tightest item"
                if is_met(result)
                else "size that one item alone needs",
                str(_allowed(one, known)),
                (
                    f"{short_name(one.item.name)}, stated "
                    f"{stated_size(one.item)}{'' if is_met(result) else '; the smallest change'}"
                ),
            )
        )
    if result.equal_effect is not None:
        figure = yield_figure(result.equal_effect.yields[0])
        out.append(
            Card(
                "yield, sizes of equal effect",
                share_within_bounded(figure, known),
                f"interval {figure.interval}",
            )
        )
    for each, title in zip(result.yields, ("yield", "yield, every pose"), strict=True):
        figure = yield_figure(each)
        out.append(Card(title, share_within_bounded(figure, known), f"interval {figure.interval}"))
    return out


def _remarks(result: Target) -> list[str]:
    out = []
    far = [
        short_name(each.item.name)
        for each in result.allowances
        if each.verified is not None and not _confirmed(result, each)
    ]
    if far:
        out.append(
            "Monte Carlo does not confirm these sizes within its confidence interval: "
            f"{', '.join(far)}; use more poses and robots"
        )
    if any(
        each.item.kind == "gearbox" and each.item.cause == "play" and each.item.size is None
        for each in result.allowances
    ):
        out.append(
            "backlash by drawing is given as a factor; `lostmotion gear` lists the dimensions "
            "that cause it"
        )
    return out


def _confirmed(result: Target, each: Allowance) -> bool:
    """Return whether the verified value agrees with the target within the intervals of both value
    and factor.
    """
    verified, factor = each.verified, each.factor
    if verified is None or not all(
        math.isfinite(end) for end in (verified.low, verified.high, factor.low, factor.high)
    ):
        return True
    half = verified.half + result.target * (factor.high - factor.low) / 2 / factor.value
    return abs(verified.value - result.target) <= half


def _facts(result: Target) -> dict[str, Any]:
    def plain(each: Allowance) -> dict[str, Any]:
        size = each.item.size
        finite = each.verdict == "sized"
        return {
            "part": each.item.owner.rstrip(","),
            "cause": each.item.cause,
            "verdict": each.verdict,
            "factor": each.factor.value if finite else None,
            "unit": None if size is None else size.unit,
            "now": None if size is None else size.value,
            "allowed": size.at(each.factor.value) if size is not None and finite else None,
            "factor_ranges": [
                [low, high if math.isfinite(high) else None] for low, high in each.ranges
            ],
            "without_m": each.without.value if each.verdict == "none" else None,
            "largest_usual": each.item.size.at(each.item.most)
            if each.item.size is not None
            else None,
            "share_of_mean_square": each.share,
        }

    def allocation_facts(allocation: Allocation | None) -> dict[str, Any] | None:
        if allocation is None:
            return None
        columns = (
            allocation.factors.tolist(),
            allocation.mean_squares.tolist(),
            allocation.not_limiting.tolist(),
        )
        return {
            item.name: {
                "factor": None if free else factor,
                "mean_square_m2": part,
                "not_limiting": free,
            }
            for item, factor, part, free in zip(result.items, *columns, strict=True)
            if math.isfinite(factor)
        }

    return {
        "target": {
            "of": result.kind,
            "value_m": result.target,
            "share": result.share,
            "kept": is_met(result),
        },
        "seed": result.seed,
        "poses": {"count": len(result.poses), "law": result.poses.law, "zone": result.zone},
        "robots": result.robots,
        "visits": result.visits,
        "items": [plain(each) for each in result.allowances],
        "kinds": [plain(each) for each in result.shared_allowances],
        "equal_factor": allocation_facts(result.equal_factor),
        "equal_effect": allocation_facts(result.equal_effect),
        "yield": yield_facts(result.yields),
        "yield_allocated": {
            name: yield_facts(allocation.yields) for name, allocation in allocated(result)
        },
    }
