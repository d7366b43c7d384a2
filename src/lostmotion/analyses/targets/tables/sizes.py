"""Sizes of items in the units that people read: as they are, as they may be, and the largest usual ones."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from lostmotion.error_model.intervals import Estimate
from lostmotion.reporting.sheet import ARCMIN, Figure, length

if TYPE_CHECKING:
    from lostmotion.analyses.targets.parameters import Item, Size


def in_unit(size: Size, factor: float) -> Figure:
    """Return a size at which the errors are `factor` times as large, in the unit that people read."""
    value = size.at(factor)
    if size.unit == "rad":
        return Figure(value / ARCMIN, "arcmin")
    if size.unit == "N m/rad":
        return Figure(value * ARCMIN, "N m/arcmin")
    return Figure(value * 1e-6, "N/µm") if size.unit == "N/m" else length(value)


def sized(item: Item, factor: Estimate) -> Figure:
    """Return an item's size with its interval; of one without a size of its own, its errors or its stiffness in per cent of what they are."""
    stiff = "stiffness" in item.cause
    if item.size is None:
        values = [100 / each if stiff and each else math.inf if stiff else 100 * each for each in (factor.value, factor.low, factor.high)]
        low, high = (values[2], values[1]) if stiff else (values[1], values[2])
        return Figure(values[0], "%", low, high)
    one = in_unit(item.size, factor.value)
    ends = [in_unit(item.size, each) for each in (factor.low, factor.high)]
    # Lengths may come in three units; the value's own counts.
    per = {"µm": 1e-6, "mm": 1e-3, "m": 1.0}
    low, high = (each.value * per.get(each.unit, 1.0) / per.get(one.unit, 1.0) for each in (ends if not item.size.divides else ends[::-1]))
    return Figure(one.value, one.unit, low, high)


def now_sized(item: Item) -> Figure:
    """Return an item's size as it is."""
    return replace(Figure(100.0, "%") if item.size is None else in_unit(item.size, 1.0), stated=True)


def times(factor: float) -> str:
    """Say a factor to three digits, large ones whole."""
    return f"{factor:.3g} times" if factor < 1000 else f"{factor:.0f} times"  # noqa: PLR2004 - no powers of ten among words


def usual_limit(item: Item) -> Figure:
    """Return the largest usual size of an item: of a stiffness the least, of items without a size their errors or stiffness in per cent of now."""
    figure = sized(item, exactly(item.most))
    return replace(figure, stated=True)


def exactly(factor: float) -> Estimate:
    """Return a factor without an interval."""
    return Estimate(factor, math.nan, math.nan)
