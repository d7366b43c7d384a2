"""Figures of a comparison as people read them: cells, bars, and the distance of tool points."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.comparison.description import ABSENT
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import digits, factor_of, unit_of_length
from lostmotion.reporting.arm_sheet import bars_as_known, sign_of
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.provenance import as_known
from lostmotion.reporting.sheet import (
    Bar,
    Bars,
    Cell,
    Row,
    Section,
    cell,
    in_words,
    length,
    several,
)

if TYPE_CHECKING:
    from lostmotion.comparison.compared_arm import ComparedArm, Measure
    from lostmotion.comparison.comparison import Change, Comparison, PartChange, ToolDistance
    from lostmotion.error_model.intervals import Estimate


NO_DIFFERENCE_SEEN: Final = "no difference seen"


EQUAL: Final = "equal"


# Changes of a length (m) below it are not quantified: no parts have such values.
SMALLEST: Final = 1e-9


def figure(estimate: Estimate, unit: str, samples: str = "") -> Cell:
    """Return an estimate as people read it (`printed.suited`); a price has no unit."""
    if unit == "price":
        return Cell(estimate.value, "1", samples=samples, stated=True)
    return cell(estimate, unit, samples)


def as_compared(comparison: Comparison, shown: Cell) -> Cell:
    """Return a length with one digit where every drive of one of the arms is assumed."""
    for each in comparison.arms:
        shown = as_known(shown, each.known)
    return shown


def is_decided(change: Estimate) -> bool:
    """Return whether a difference is distinguished from zero: its interval does not contain
    zero.
    """
    return change.low > 0 or change.high < 0


def remark(change: Estimate, *, exact: bool) -> str:
    """Return what a reader must know of a difference: that it is zero, not distinguished from zero,
    or lacks an end or its interval; else nothing.
    """
    if change.value == 0 and (exact or change.low == change.high == 0):
        return EQUAL
    if exact and math.isnan(change.value):
        return "not stated for all arms"
    if not exact and math.isnan(change.low) != math.isnan(change.high):
        return "one end of the interval is not known: too few poses"
    if exact or is_decided(change):
        return ""
    return (
        NO_DIFFERENCE_SEEN
        if math.isfinite(change.low)
        else "no interval: too few robots or sets of poses"
    )


def with_interval(shown: Cell) -> str:
    """Return a figure with its interval in brackets, where it has one."""
    return f"{shown} ({shown.interval})" if shown.interval else str(shown)


def counted(each: ComparedArm) -> str:
    """Return what the figures of an arm were counted from."""
    return (
        f"{several(len(each.poses), 'pose')} ({each.poses.law}) x "
        f"{several(each.sampled.robots, 'robot')} x {several(each.sampled.visits, 'visit')}"
    )


def measure_of(comparison: Comparison, key: str) -> Measure | None:
    """Return the figure of this key; None where these arms do not have it."""
    return next((each for each in comparison.measures if each.key == key), None)


def ends(estimate: Estimate) -> list[float | None]:
    """Return a value and the ends of its interval as plain data; None for what is not known."""
    return [
        each if math.isfinite(each) else None
        for each in (estimate.value, estimate.low, estimate.high)
    ]


# Parts with a bar of their own; further arms whose change is drawn by part; share of the largest
# bar below which a part has none of its own.
_MOST_BARS: Final = 6


_MOST_ARMS: Final = 2


_LEAST: Final = 0.005


def bars(comparison: Comparison) -> tuple[Bars, ...]:
    """Return the blocks of bars."""
    blocks = (
        *_of_arms(comparison),
        *(
            block
            for k, change in enumerate(comparison.changes[:_MOST_ARMS])
            for block in _of_parts(comparison, change, k)
        ),
    )
    for each in comparison.arms:
        blocks = bars_as_known(blocks, each.known)
    return blocks


def _of_arms(comparison: Comparison) -> list[Bars]:
    within = measure_of(comparison, "p95")
    if within is None:
        return []
    sizes = [within.value(each) for each in comparison.arms]
    effects: list[Cell | None] = [
        None,
        *(figure(change.figures["p95"], "m") for change in comparison.changes),
    ]
    drawn = tuple(
        Bar(each.label, replace(length(size.value), bound=sign_of(each.known)), size.value, effect)
        for each, size, effect in zip(comparison.arms, sizes, effects, strict=True)
    )
    return [Bars("changes", "Position error", within.name, drawn, "change")]


def _of_parts(comparison: Comparison, change: Change, index: int) -> list[Bars]:
    """Return the bars of one arm's change by part; none where no part changes it."""
    largest = max((abs(each.share.value) for each in change.parts), default=0.0)
    if not largest > SMALLEST:
        return []
    own = [each for each in change.parts if abs(each.share.value) >= _LEAST * largest]
    own = own if len(own) <= _MOST_BARS + 1 else own[:_MOST_BARS]
    others = [each for each in change.parts if each not in own]
    drawn = [
        Bar(
            short_name(each.part),
            length(each.share.value),
            each.share.value,
            _sizes(comparison, each),
        )
        for each in own
    ]
    rest = sum(each.share.value for each in others)
    if abs(rest) >= _LEAST * largest:
        drawn.append(
            Bar(f"{len(others)} other{'s' if len(others) > 1 else ''}", length(rest), rest)
        )
    several = len(comparison.changes) > 1
    title = f"What changed the r.m.s. error{f' of {change.arm.label}' if several else ''}"
    return [
        Bars(
            f"parts_shares_{index + 2}" if several else "parts_shares",
            title,
            "change by part",
            tuple(drawn),
            "alone, before → after",
        )
    ]


def _sizes(comparison: Comparison, each: PartChange) -> Cell:
    """Return the r.m.s. error of a part by itself, before and after, in words and in the unit of
    the larger one.
    """
    assumed = as_compared(comparison, length(0.0)).assumed
    if each.before is None or each.after is None or assumed:
        return in_words(
            " → ".join(
                ABSENT if size is None else str(as_compared(comparison, length(size)))
                for size in (each.before, each.after)
            )
        )
    unit = unit_of_length(max(each.before, each.after))
    return in_words(
        f"{' → '.join(digits(size * factor_of(unit)) for size in (each.before, each.after))} {unit}"
    )


def commanded_tool_points(comparison: Comparison) -> list[Section]:
    """Return the table; none where no arm stands at the joint values of the first."""
    known = [
        (change.arm.label, change.apart)
        for change in comparison.changes
        if change.apart is not None
    ]
    if not known:
        return []
    poses = comparison.arms[0].poses
    counted = f"{several(len(poses), 'pose')} ({poses.law}), nominal geometry"
    several_arms = len(known) > 1
    places = [
        f"{f'{label}: ' if several_arms else ''}{_place(comparison, apart)}"
        for label, apart in known
        if not apart.is_zero
    ]
    aparts = [apart for _, apart in known]
    note = EQUAL if all(apart.is_zero for apart in aparts) else ""
    rows = [
        Row("mean", tuple(figure(apart.mean, "m", counted) for apart in aparts), note),
        Row("95th percentile", tuple(figure(apart.p95, "m", counted) for apart in aparts), note),
        Row(
            "largest",
            tuple(length(apart.largest, samples=counted) for apart in aparts),
            note or "; ".join(places),
        ),
    ]
    for k, axis in enumerate("xyz"):
        means = (length(float(apart.vectors[:, k].mean()), samples=counted) for apart in aparts)
        rows.append(Row(f"mean displacement along {axis}", tuple(means), note, f"mean_{axis}"))
    columns = tuple(f"{label} from {comparison.arms[0].label}" for label, _ in known)
    about = (
        "where the nominal geometry puts the tool, without any error, in the axes of the base; "
        "intervals are due to the choice of poses"
    )
    return [
        Section(
            "tool_points",
            "Distance of the commanded tool points at the same joint values",
            columns,
            tuple(rows),
            about,
        )
    ]


def _place(comparison: Comparison, apart: ToolDistance) -> str:
    """Return where the largest distance is: the pose, and the tool point of the first arm."""
    at = ", ".join(
        f"{axis} {length(float(value))}"
        for axis, value in zip("xyz", apart.tool[apart.largest_at], strict=True)
    )
    return (
        "at "
        f"{joint_values(comparison.arms[0].arm, comparison.arms[0].poses.q[apart.largest_at])}, "
        "tool at "
        f"{at}"
    )


def distance_facts(comparison: Comparison, change: Change) -> dict[str, Any] | None:
    """Return the distance of one arm from the first as plain data, in SI; None where they stand at
    different joint values.
    """
    apart = change.apart
    if apart is None:
        return None
    first, at = comparison.arms[0], apart.largest_at
    return {
        "arm": change.arm.label,
        "mean_m": ends(apart.mean),
        "p95_m": ends(apart.p95),
        "largest_m": apart.largest,
        "largest_at_joint_values": dict(
            zip(
                (joint.name for joint in first.arm.driven),
                map(float, first.poses.q[at]),
                strict=True,
            )
        ),
        "largest_at_m": list(map(float, apart.tool[at])),
        "mean_displacement_m": list(map(float, apart.vectors.mean(axis=0))),
    }
