"""Sizes of items in practical units: as stated, as allowed, and the largest usual ones."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from lostmotion.error_model.intervals import Estimate
from lostmotion.reporting.sheet import ARCMIN, Figure, length

if TYPE_CHECKING:
    from lostmotion.analyses.targets.parameters import Item, Size


def in_unit(size: Size, factor: float) -> Figure:
    """Return the size with which the errors are `factor` times as large, in a practical unit."""
    value = size.at(factor)
    if size.unit == "rad":
        return Figure(value / ARCMIN, "arcmin")
    if size.unit == "N m/rad":
        return Figure(value * ARCMIN, "N m/arcmin")
    if size.unit == "K":
        return Figure(value, "K")
    return Figure(value * 1e-6, "N/µm") if size.unit == "N/m" else length(value)


def size_at(item: Item, factor: Estimate) -> Figure:
    """Return an item's size at a factor with its interval; for an item without a size, its error or
    stiffness in per cent of the present one.
    """
    stiff = item.stiff
    if item.size is None:
        values = [
            100 / each if stiff and each else math.inf if stiff else 100 * each
            for each in (factor.value, factor.low, factor.high)
        ]
        low, high = (values[2], values[1]) if stiff else (values[1], values[2])
        return Figure(values[0], "%", low, high)
    one = in_unit(item.size, factor.value)
    ends = [in_unit(item.size, each) for each in (factor.low, factor.high)]
    # The ends take the unit of the value.
    per = {"µm": 1e-6, "mm": 1e-3, "m": 1.0}
    low, high = (
        each.value * per.get(each.unit, 1.0) / per.get(one.unit, 1.0)
        for each in (ends if not item.size.divides else ends[::-1])
    )
    return Figure(one.value, one.unit, low, high)


def stated_size(item: Item) -> Figure:
    """Return an item's size as stated; 100 % for an item without a size."""
    return replace(
        Figure(100.0, "%") if item.size is None else in_unit(item.size, 1.0), stated=True
    )


def times(factor: float) -> str:
    """Return a factor as text, with three digits or whole."""
    return f"{factor:.3g} times" if factor < 1000 else f"{factor:.0f} times"  # noqa: PLR2004 - no powers of ten among words


def usual_limit(item: Item) -> Figure:
    """Return the largest usual size of an item (the smallest stiffness), in the form of
    `size_at`.
    """
    figure = size_at(item, exactly(item.most))
    return replace(figure, stated=True)


def exactly(factor: float) -> Estimate:
    """Return a factor without an interval."""
    return Estimate(factor, math.nan, math.nan)
