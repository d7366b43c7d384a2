"""Figures of the error, each declared once: key, name, SI unit, definition, and how it is estimated
from a run. Tables, result.json, comparisons and Python read these declarations.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from lostmotion.error_model.arrival import rp_key, rp_name
from lostmotion.error_model.differences import (
    mean_difference,
    quantile_difference,
    robots_quantile_difference,
    root_mean_square_difference,
)
from lostmotion.error_model.few_poses import ERROR, RP, ap_weights, known_ends
from lostmotion.error_model.intervals import (
    Estimate,
    pooled_mean,
    pooled_quantile,
    pooled_robots_quantile,
    root_mean_square,
    standard_deviation,
)
from lostmotion.propagation.montecarlo import kernel

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.budget import Budget
    from lostmotion.propagation.montecarlo.montecarlo import Sampled
    from lostmotion.spatial import Floats

# Of the mean squares by design, by robot and by visit in a figure.
Weights: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True)
class VisitFigures:
    """AP or RP of every robot, over poses that need not be those of the position error.

    robot_means      (set, robot) m, averaged over each independent set of poses
    of_poses         (pose,) m, averaged over robots
    squares          (set, 3) mean squares by design, by robot and by visit over each set, m^2
    squares_of_many  the same over each set of many poses; no sets where nothing is checked
    """

    robot_means: Floats
    of_poses: Floats
    squares: Floats
    squares_of_many: Floats


@dataclass(frozen=True)
class Errors:
    """What figures of the error are estimated from: a run of robots over poses.

    sampled          the run
    squares          (set, 3) exact mean squares by design, by robot and by visit over each
                     independent set of its poses, m^2
    squares_of_many  the same over each set of many poses, to check whether the poses are too few;
                     no sets where nothing is checked
    repeats          RP by the sign of the joints' last motion, 0 where it is drawn; empty for a
                     single visit
    """

    sampled: Sampled
    squares: Floats
    squares_of_many: Floats
    repeats: dict[float, VisitFigures]

    @property
    def accuracy(self) -> VisitFigures:
        """Return AP of every robot."""
        means = self.sampled.robot_means[:, :, 1]
        return VisitFigures(means, self.sampled.of_poses(1), self.squares, self.squares_of_many)


def squares_of(budget: Budget) -> tuple[Floats, Floats]:
    """Return the mean squares by level over each set of a budget's poses, and of the many (set, 3),
    m^2.
    """
    return np.array(budget.of_sets), np.array(budget.of_many).reshape(-1, 3)


@dataclass(frozen=True)
class Figure:
    """A figure of the error.

    key         of its row in result.json, and its attribute in Python
    name        as printed
    unit        SI
    definition  what it is, in a sentence
    estimate    its value with its 95 % interval
    difference  of two runs of the same draws, after minus before, with its paired interval
    weights     of the mean squares by design, by robot and by visit in it; None for one of another
                kind
    squares     the mean squares over sets of poses and of many poses that those weights are for
    """

    key: str
    name: str
    unit: str
    definition: str
    estimate: Callable[[Errors], Estimate]
    difference: Callable[[Errors, Errors], Estimate] | None = None
    weights: Weights | None = None
    squares: Callable[[Errors], tuple[Floats, Floats]] = lambda of: (of.squares, of.squares_of_many)

    def of(self, errors: Errors) -> Estimate:
        """Return its value; an end of the interval is NaN where the poses are too few
        (`known_ends`).
        """
        found = replace(self.estimate(errors), unit=self.unit)
        squares, of_many = self.squares(errors)
        if self.weights is None or not len(of_many):
            return found
        visited, many = (root_mean_square(each @ self.weights) for each in (squares, of_many))
        return known_ends(found, visited, many)

    def change(self, before: Errors, after: Errors) -> Estimate:
        """Return its difference, after minus before; ends as for `of`. Raises ValueError for a
        figure without one.
        """
        if self.difference is None:
            raise ValueError(f"no difference of '{self.key}' is declared")
        found = replace(self.difference(before, after), unit=self.unit)
        squares, of_many = zip(self.squares(before), self.squares(after), strict=True)
        if self.weights is None or not all(len(each) for each in of_many):
            return found
        visited, many = (
            root_mean_square_difference(*(each @ self.weights for each in of))
            for of in (squares, of_many)
        )
        size = max(root_mean_square(each @ self.weights).value for each in of_many)
        return known_ends(found, visited, many, size)


def _largest(errors: Errors) -> float:
    return float(errors.sampled.per_pose[:, kernel.LARGEST].max())


def _mean(errors: Errors) -> Estimate:
    return pooled_mean(errors.sampled.robot_means[:, :, 0], errors.sampled.of_poses(0))


def _deviation(errors: Errors) -> Estimate:
    sampled = errors.sampled
    return standard_deviation(
        sampled.group_hist,
        sampled.replicate_hist,
        _mean(errors).value,
        float(sampled.per_pose[:, kernel.MEAN_SQUARE].mean()),
    )


def percentile(level: float) -> Figure:
    """Return the error that this share of all positions stays within."""

    def estimate(errors: Errors) -> Estimate:
        sampled = errors.sampled
        return pooled_quantile(sampled.group_hist, sampled.replicate_hist, level, _largest(errors))

    def difference(before: Errors, after: Errors) -> Estimate:
        hists = [(each.sampled.group_hist, each.sampled.replicate_hist) for each in (before, after)]
        values = (estimate(before).value, estimate(after).value)
        return quantile_difference(hists[0], hists[1], level, values)

    share = f"{100 * level:.0f}"
    return Figure(
        f"p{share}",
        f"{share}th percentile",
        "m",
        f"position error that {share} % of all positions of all robots stay within",
        estimate,
        difference,
        ERROR,
    )


def _rms(key: str, name: str, definition: str, weights: Weights) -> Figure:
    chosen = np.array(weights)
    return Figure(
        key,
        name,
        "m",
        definition,
        lambda errors: root_mean_square(errors.squares @ chosen),
        lambda before, after: root_mean_square_difference(
            before.squares @ chosen, after.squares @ chosen
        ),
        weights,
    )


def _of_robots(
    key: str, name: str, visits: Callable[[Errors], VisitFigures], weights: Weights
) -> tuple[Figure, Figure]:
    """Return the mean over poses and robots, and the 95th percentile over robots, of AP or RP."""

    def squares(errors: Errors) -> tuple[Floats, Floats]:
        return visits(errors).squares, visits(errors).squares_of_many

    def means(errors: Errors) -> tuple[Floats, Floats]:
        return visits(errors).robot_means, visits(errors).of_poses

    return (
        Figure(
            f"{key}_mean",
            f"{name}, mean over poses and robots",
            "m",
            f"{name} of ISO 9283, averaged over poses and robots",
            lambda errors: pooled_mean(*means(errors)),
            lambda one, other: mean_difference(means(one)[0], means(other)[0]),
            weights,
            squares,
        ),
        Figure(
            f"{key}_p95",
            f"{name}, 95th percentile of robots",
            "m",
            f"{name} of ISO 9283 that 95 % of robots stay within, averaged over poses",
            lambda errors: pooled_robots_quantile(means(errors)[0], of_poses=means(errors)[1]),
            lambda one, other: robots_quantile_difference(means(one)[0], means(other)[0]),
            weights,
            squares,
        ),
    )


def accuracy(visits: int) -> tuple[Figure, Figure]:
    """Return the figures of AP at this number of visits."""
    return _of_robots("ap", "AP", lambda errors: errors.accuracy, ap_weights(visits))


def repeatability(approach: float) -> tuple[Figure, Figure]:
    """Return the figures of RP of joints that arrive this way (`arrival.rp_name`)."""
    key = rp_key(approach)
    return _of_robots(key, rp_name(approach), lambda errors: errors.repeats[approach], RP)


def _rotation(errors: Errors) -> Floats:
    sets = len(errors.sampled.replicate_hist)
    return np.asarray(errors.sampled.rotation_ms.reshape(sets, -1).mean(axis=1))


MEAN: Final = Figure(
    "mean",
    "mean",
    "m",
    "mean position error over all positions of all robots",
    _mean,
    lambda one, other: mean_difference(
        one.sampled.robot_means[:, :, 0], other.sampled.robot_means[:, :, 0]
    ),
    ERROR,
)
DEVIATION: Final = Figure(
    "standard_deviation",
    "standard deviation",
    "m",
    "of the position error about its mean, over all robots, poses and visits",
    _deviation,
    weights=ERROR,
)
RMS: Final = _rms("rms", "r.m.s.", "root mean square of the position error", ERROR)
RMS_BY_LEVEL: Final = (
    _rms("rms_design", "r.m.s., follows load and pose", "of the same error of all", (1, 0, 0)),
    _rms("rms_robot", "r.m.s., differs between robots", "of manufacture", (0, 1, 0)),
    _rms("rms_visit", "r.m.s., differs between visits", "of each visit to a pose", (0, 0, 1)),
)
PERCENTILES: Final = {level: percentile(level) for level in kernel.QUANTILES}
ROTATION: Final = Figure(
    "rotation_rms",
    "rotation of the tool, r.m.s.",
    "rad",
    "root mean square of the angle by which the tool is turned; exact at the visited poses",
    lambda errors: root_mean_square(_rotation(errors)),
    lambda one, other: root_mean_square_difference(_rotation(one), _rotation(other)),
)
# Of the position error, in the order of tables.
OF_POSITION: Final = (
    MEAN,
    DEVIATION,
    RMS,
    *PERCENTILES.values(),
)


def figures_of(errors: Errors) -> dict[str, Figure]:
    """Return the figures that a run has, by key: AP and RP need two visits."""
    found = [*OF_POSITION, *RMS_BY_LEVEL, ROTATION]
    if errors.repeats:
        found += accuracy(errors.sampled.visits)
        found += [each for approach in errors.repeats for each in repeatability(approach)]
    return {each.key: each for each in found}
