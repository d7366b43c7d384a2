"""Sizes of items in practical units: as stated, as allowed, and the largest usual ones."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from lostmotion.error_model.intervals import Estimate
from lostmotion.reporting.sheet import Cell, length

if TYPE_CHECKING:
    from lostmotion.analyses.targets.parameters import Item, Size


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
