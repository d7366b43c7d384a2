"""Figures by which arms are compared: those of the error as declared, and others of the arm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from lostmotion.error_model.differences import sets_difference
from lostmotion.error_model.intervals import Estimate
from lostmotion.propagation.figures import figures_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.analyses.compare.compared_arm import ComparedArm
    from lostmotion.propagation.figures import Figure

Group: TypeAlias = Literal["accuracy", "levels", "arm"]


@dataclass(frozen=True)
class Measure:
    """A figure by which arms are compared.

    key     of its row
    name    of its row
    unit    "m", "rad", "kg", "price" in the currency of the files, or "%" for a share
    value   its value for one arm, with its interval
    change  its difference, after minus before, with its paired interval
    group   of the table that it stands in
    exact   whether it follows from the description alone, without an interval
    """

    key: str
    name: str
    unit: str
    value: Callable[[ComparedArm], Estimate]
    change: Callable[[ComparedArm, ComparedArm], Estimate]
    group: Group = "accuracy"
    exact: bool = False


def measures(arms: Sequence[ComparedArm]) -> tuple[Measure, ...]:
    """Return the figures by which these arms are compared."""
    of_error = figures_of(arms[0].errors).values()
    out = [_of_error(each) for each in of_error if each.difference is not None]
    if any(each.sag.any() for each in arms):
        out.append(
            Measure(
                "sag",
                "sag along gravity, mean",
                "m",
                lambda each: sets_difference(np.zeros(len(each.sag)), each.sag),
                lambda one, other: sets_difference(one.sag, other.sag),
                "levels",
            )
        )
    out.append(_exact("mass", "mass of the arm", "kg", lambda each: each.arm.mass))
    if any(each.arm.price is not None for each in arms):
        out.append(
            _exact(
                "price",
                "price of the arm",
                "price",
                lambda each: math.nan if each.arm.price is None else each.arm.price,
            )
        )
    if any(math.isfinite(each.load) for each in arms):
        out.append(
            _exact("load", "most loaded drive, of its rated load", "%", lambda each: each.load)
        )
    return tuple(out)


def _of_error(figure: Figure) -> Measure:
    """Return a declared figure of the error by the name that it has beside other arms."""
    return Measure(
        figure.key,
        figure.title or figure.name,
        figure.unit,
        lambda each: figure.of(each.errors),
        lambda one, other: figure.change(one.errors, other.errors),
        "levels" if figure.group == "levels" else "accuracy",
    )


def _exact(key: str, name: str, unit: str, value: Callable[[ComparedArm], float]) -> Measure:
    """Return a figure that follows from the description, without an interval."""
    return Measure(
        key,
        name,
        unit,
        lambda each: Estimate(value(each), math.nan, math.nan),
        lambda one, other: Estimate(value(other) - value(one), math.nan, math.nan),
        "arm",
        exact=True,
    )
