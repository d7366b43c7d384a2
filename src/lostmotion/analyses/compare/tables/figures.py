"""Figures of a comparison as people read them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from lostmotion.reporting.sheet import Cell, cell, several

if TYPE_CHECKING:
    from lostmotion.analyses.compare.compared_arm import ComparedArm
    from lostmotion.analyses.compare.comparison import Comparison
    from lostmotion.analyses.compare.measures import Measure
    from lostmotion.error_model.intervals import Estimate

NO_DIFFERENCE_SEEN: Final = "no difference seen"
EQUAL: Final = "equal"


def figure(found: Estimate, unit: str, samples: str = "") -> Cell:
    """Return an estimate as people read it (`printed.suited`); a price has no unit."""
    if unit == "price":
        return Cell(found.value, "1", samples=samples, stated=True)
    return cell(found, unit, samples)


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


def with_interval(found: Cell) -> str:
    """Return a figure with its interval in brackets, where it has one."""
    return f"{found} ({found.interval})" if found.interval else str(found)


def counted(each: ComparedArm) -> str:
    """Return what the figures of an arm were counted from."""
    return (
        f"{several(len(each.poses), 'pose')} ({each.poses.law}) x "
        f"{several(each.sampled.robots, 'robot')} x {several(each.sampled.visits, 'visit')}"
    )


def measure_of(found: Comparison, key: str) -> Measure | None:
    """Return the figure of this key; None where these arms do not have it."""
    return next((each for each in found.measures if each.key == key), None)


def ends(found: Estimate) -> list[float | None]:
    """Return a value and the ends of its interval as plain data; None for what is not known."""
    return [each if math.isfinite(each) else None for each in (found.value, found.low, found.high)]
