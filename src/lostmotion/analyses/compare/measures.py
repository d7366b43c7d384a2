"""Figures by which arms are compared: the value of each for one arm, and its paired difference
between two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from lostmotion.error_model.arrival import rp_key, rp_name
from lostmotion.error_model.differences import (
    mean_difference,
    quantile_difference,
    robots_quantile_difference,
    root_mean_square_difference,
    sets_difference,
)
from lostmotion.error_model.few_poses import ERROR, RP, ap_weights, known_ends
from lostmotion.error_model.intervals import (
    Estimate,
    pooled_mean,
    pooled_quantile,
    pooled_robots_quantile,
    root_mean_square,
)
from lostmotion.propagation.montecarlo import kernel

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.analyses.compare.compared_arm import ComparedArm
    from lostmotion.spatial import Floats

Group: TypeAlias = Literal["accuracy", "levels", "arm"]
LEVEL: Final = 0.95
_ALL_LEVELS: Final = (0, 1, 2)


@dataclass(frozen=True)
class Measure:
    """A figure by which arms are compared.

    key     of its row
    name    of its row
    unit    "m", "rad", "kg", "price" in the currency of the files, or "1" for a share
    value   its value for one arm, with its interval
    change  its difference, after minus before, with its paired interval
    group   of the table that it stands in
    exact   whether it follows from the description alone, without an interval
    weights of the mean squares by design, by robot and by visit in it; None for a figure of another
    kind
    """

    key: str
    name: str
    unit: str
    value: Callable[[ComparedArm], Estimate]
    change: Callable[[ComparedArm, ComparedArm], Estimate]
    group: Group = "accuracy"
    exact: bool = False
    weights: tuple[float, float, float] | None = None


def measures(arms: Sequence[ComparedArm]) -> tuple[Measure, ...]:
    """Return the figures by which these arms are compared."""
    out = [_quantile(level) for level in (LEVEL, 0.99)]
    out.append(
        Measure(
            "mean",
            "mean position error",
            "m",
            lambda each: pooled_mean(each.sampled.robot_means[:, :, 0], each.sampled.of_poses(0)),
            lambda one, other: mean_difference(
                one.sampled.robot_means[:, :, 0], other.sampled.robot_means[:, :, 0]
            ),
            weights=ERROR,
        )
    )
    if arms[0].sampled.visits > 1:
        out += [
            _of_robots("ap", 1, ap_weights(arms[0].sampled.visits), "AP"),
            _of_robots(rp_key(arms[0].approach).lower(), 2, RP, rp_name(arms[0].approach)),
        ]
    out += [
        _rms("rms", "r.m.s. error", _ALL_LEVELS),
        _rms("rms_design", "r.m.s., follows load and pose", (0,)),
        _rms("rms_robot", "r.m.s., differs between robots", (1,)),
        _rms("rms_visit", "r.m.s., differs between visits", (2,)),
    ]
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
    out += [
        Measure(
            "rotation_rms",
            "rotation of the tool, r.m.s.",
            "rad",
            lambda each: root_mean_square(_rotations(each)),
            lambda one, other: root_mean_square_difference(_rotations(one), _rotations(other)),
        ),
        _exact("mass", "mass of the arm", "kg", lambda each: each.arm.mass),
    ]
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
            _exact("load", "most loaded drive, of its rated load", "1", lambda each: each.load)
        )
    return tuple(_checked(each) for each in out) if all(each.many for each in arms) else tuple(out)


def _checked(measure: Measure) -> Measure:
    """Return a figure whose ends are unknown where the poses are too few for it, or for its
    difference (`known_ends`).
    """
    if measure.weights is None:
        return measure
    of_levels, weights = measure.weights, np.array(measure.weights)

    def value(each: ComparedArm) -> Estimate:
        return known_ends(measure.value(each), *each.beside_many(of_levels))

    def changed(one: ComparedArm, other: ComparedArm) -> Estimate:
        visited = root_mean_square_difference(one.squares @ weights, other.squares @ weights)
        many = root_mean_square_difference(
            one.squares_of_many @ weights, other.squares_of_many @ weights
        )
        size = max(each.beside_many(of_levels)[1].value for each in (one, other))
        return known_ends(measure.change(one, other), visited, many, size)

    return replace(measure, value=value, change=changed)


def _quantile(level: float) -> Measure:
    def value(each: ComparedArm) -> Estimate:
        largest = float(each.sampled.per_pose[:, kernel.LARGEST].max())
        return pooled_quantile(each.sampled.group_hist, each.sampled.replicate_hist, level, largest)

    def changed(before: ComparedArm, after: ComparedArm) -> Estimate:
        hists = [(each.sampled.group_hist, each.sampled.replicate_hist) for each in (before, after)]
        return quantile_difference(
            hists[0], hists[1], level, (value(before).value, value(after).value)
        )

    return Measure(
        f"p{100 * level:.0f}",
        f"{100 * level:.0f} % of positions within",
        "m",
        value,
        changed,
        weights=ERROR,
    )


def _of_robots(key: str, column: int, weights: tuple[float, float, float], name: str) -> Measure:
    """Return the 95th percentile over robots of AP or RP, which is in this column of the robots'
    means.
    """
    return Measure(
        f"{key}_p95",
        f"{name}, 95 % of robots within",
        "m",
        lambda each: pooled_robots_quantile(
            each.sampled.robot_means[:, :, column], of_poses=each.sampled.of_poses(column)
        ),
        lambda one, other: robots_quantile_difference(
            one.sampled.robot_means[:, :, column], other.sampled.robot_means[:, :, column]
        ),
        weights=weights,
    )


def _rms(key: str, name: str, levels: tuple[int, ...]) -> Measure:
    design, robot, visit = (float(level in levels) for level in _ALL_LEVELS)

    def squares(each: ComparedArm) -> Floats:
        return np.asarray(each.squares[:, list(levels)].sum(axis=1))

    return Measure(
        key,
        name,
        "m",
        lambda each: root_mean_square(squares(each)),
        lambda one, other: root_mean_square_difference(squares(one), squares(other)),
        "accuracy" if levels == _ALL_LEVELS else "levels",
        weights=(design, robot, visit),
    )


def _rotations(each: ComparedArm) -> Floats:
    return np.asarray(each.sampled.rotation_ms.reshape(each.poses.replicates, -1).mean(axis=1))


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
