"""Figures of the error, each declared once: key, name, SI unit, definition, and how it is estimated
from samples or sums. Tables, result.json, comparisons, sweeps, stopping rule and Python read these
declarations; other packages add theirs (`lostmotion.extensions`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from lostmotion.error_model.arrival import rp_key, rp_name
from lostmotion.error_model.differences import (
    deviation_difference,
    mean_difference,
    quantile_difference,
    robots_quantile_difference,
    root_mean_square_difference,
)
from lostmotion.error_model.few_poses import ERROR, RP, Squares, ap_weights, known_ends
from lostmotion.error_model.intervals import Estimate, Spread, share_spread
from lostmotion.error_model.robot_intervals import (
    mean_spread,
    pooled_mean,
    pooled_robots_quantile,
    quantile_spread,
    root_mean_square,
)
from lostmotion.error_model.small_counts import counting_floor
from lostmotion.extensions import extensions

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.propagation.error_samples import Drawn, Errors, VisitFigures
    from lostmotion.spatial import Floats

# Of the mean squares by design, by robot and by visit in a figure.
Weights: TypeAlias = tuple[float, float, float]
# The table that a figure stands in: the error, its parts by level of chance, AP and RP.
Group: TypeAlias = Literal["error", "levels", "iso9283"]
# Percentile that is asked for first, and its key.
FIRST: Final = 0.95
HEADLINE: Final = "p95"
_NORMAL: Final = 1.96


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
    squares     the mean squares that those weights are for
    group       of the table that it stands in
    title       of a card and beside other arms, where it stands alone; default: its name
    first       whether it is asked for first: it has a card, and a band where values are unknown
    spread      its variance due to poses and to robots, by which a run continues until it is
                precise; None for one that no run waits for
    """

    key: str
    name: str
    unit: str
    definition: str
    estimate: Callable[[Any], Estimate]
    difference: Callable[[Drawn, Drawn], Estimate] | None = None
    weights: Weights | None = None
    squares: Callable[[Any], Squares] = lambda errors: errors.squares
    group: Group = "error"
    title: str = ""
    first: bool = False
    spread: Callable[[Drawn, Estimate], Spread] | None = None

    def of(self, errors: Errors) -> Estimate:
        """Return its value; an end of the interval is NaN where the poses are too few
        (`known_ends`).
        """
        found = replace(self.estimate(errors), unit=self.unit)
        return (
            found if self.weights is None else self.squares(errors).known_ends(found, self.weights)
        )

    def change(self, before: Drawn, after: Drawn) -> Estimate:
        """Return its difference, after minus before; ends as for `of`. Raises ValueError for a
        figure without one.
        """
        if self.difference is None:
            raise ValueError(f"no difference of '{self.key}' is declared")
        found = replace(self.difference(before, after), unit=self.unit)
        both = self.squares(before), self.squares(after)
        weights = self.weights
        if weights is None or not all(len(each.many) for each in both):
            return found
        visited, many = (
            root_mean_square_difference(*(getattr(each, name) @ weights for each in both))
            for name in ("visited", "many")
        )
        size = max(root_mean_square(each.many @ weights).value for each in both)
        return known_ends(found, visited, many, size)


def percentile(level: float) -> Figure:
    """Return the error that this share of all positions stays within."""

    def difference(before: Drawn, after: Drawn) -> Estimate:
        values = before.quantile(level).value, after.quantile(level).value
        return quantile_difference(before.histograms, after.histograms, level, values)

    def spread(errors: Drawn, estimate: Estimate) -> Spread:
        return share_spread(*errors.histograms, estimate.value)

    share = f"{100 * level:.4g}"
    return Figure(
        f"p{share.replace('.', '_')}",
        f"{share}th percentile",
        "m",
        f"position error that {share} % of all positions of all robots stay within",
        lambda errors: errors.quantile(level),
        difference,
        ERROR,
        title=f"{share} % of positions within",
        first=level == FIRST,
        spread=spread if level == FIRST else None,
    )


def _rms(key: str, name: str, definition: str, weights: Weights, group: Group) -> Figure:
    return Figure(
        key,
        name,
        "m",
        definition,
        lambda errors: errors.squares.root_mean_square(weights),
        lambda before, after: root_mean_square_difference(
            *(each.squares.visited @ weights for each in (before, after))
        ),
        weights,
        group=group,
        title="r.m.s. error" if group == "error" else "",
    )


def _of_robots(
    key: str, name: str, visits: Callable[[Any], VisitFigures], weights: Weights, title: str
) -> tuple[Figure, Figure]:
    """Return the mean over poses and robots, and the 95th percentile over robots, of AP or RP."""

    def means(errors: Errors) -> tuple[Floats, Floats | None]:
        return visits(errors).robot_means, visits(errors).of_poses

    def spread_of_percentile(errors: Drawn, estimate: Estimate) -> Spread:
        robot_means, of_poses = means(errors)
        floor = 0.0 if of_poses is None else counting_floor(of_poses, len(robot_means))
        due_to_poses = max(quantile_spread(robot_means), (floor / _NORMAL) ** 2)
        whole = (estimate.half / _NORMAL) ** 2
        return Spread(max(whole - due_to_poses, 0.0), due_to_poses, estimate.half)

    mean = Figure(
        f"{key}_mean",
        f"{name}, mean over poses and robots",
        "m",
        f"{name} of ISO 9283, averaged over poses and robots",
        lambda errors: pooled_mean(*means(errors)),
        lambda one, other: mean_difference(means(one)[0], means(other)[0]),
        weights,
        lambda errors: visits(errors).squares,
        "iso9283",
        spread=lambda errors, _: mean_spread(*means(errors)),
    )
    return mean, replace(
        mean,
        key=f"{key}_p95",
        name=f"{name}, 95th percentile of robots",
        definition=f"{name} of ISO 9283 that 95 % of robots stay within, averaged over poses",
        estimate=lambda errors: pooled_robots_quantile(means(errors)[0], of_poses=means(errors)[1]),
        difference=lambda one, other: robots_quantile_difference(means(one)[0], means(other)[0]),
        title=f"{title}, 95 % of robots within",
        first=True,
        spread=spread_of_percentile,
    )


def accuracy(visits: int) -> tuple[Figure, Figure]:
    """Return the figures of AP at this number of visits."""
    of_visits = ap_weights(visits)
    return _of_robots("ap", "AP", lambda errors: errors.accuracy, of_visits, "accuracy AP")


def repeatability(approach: float) -> tuple[Figure, Figure]:
    """Return the figures of RP of joints that arrive this way (`arrival.rp_name`)."""
    name = rp_name(approach)
    return _of_robots(rp_key(approach), name, lambda errors: errors.repeats[approach], RP, name)


def _deviations(before: Drawn, after: Drawn) -> Estimate:
    both = (before, after)
    return deviation_difference(
        before.histograms,
        after.histograms,
        (before.mean().value, after.mean().value),
        (both[0].deviation().value, both[1].deviation().value),
    )


MEAN: Final = Figure(
    "mean",
    "mean",
    "m",
    "mean position error over all positions of all robots",
    lambda errors: errors.mean(),
    lambda one, other: mean_difference(one.robot_means, other.robot_means),
    ERROR,
    title="mean position error",
    first=True,
    spread=lambda errors, _: mean_spread(errors.robot_means, errors.of_poses),
)
DEVIATION: Final = Figure(
    "standard_deviation",
    "standard deviation",
    "m",
    "of the position error about its mean, over all robots, poses and visits",
    lambda errors: errors.deviation(),
    _deviations,
    ERROR,
    title="standard deviation of the error",
)
RMS: Final = _rms("rms", "r.m.s.", "root mean square of the position error", ERROR, "error")
ROTATION: Final = Figure(
    "rotation_rms",
    "rotation of the tool, r.m.s.",
    "rad",
    "root mean square of the angle by which the tool is turned; exact at the visited poses",
    lambda errors: root_mean_square(errors.rotation.mean(axis=1), errors.rotation.ravel()),
    lambda one, other: root_mean_square_difference(
        *(each.rotation.mean(axis=1) for each in (one, other))  # type: ignore[union-attr] # `figures_of`
    ),
)
# Figures of every run, but for the percentiles, which stand before the last: of the position error
# in the order of tables, of its levels, of the rotation.
_EVERY: Final = (
    MEAN,
    DEVIATION,
    RMS,
    _rms(
        "rms_design",
        "r.m.s., follows load and pose",
        "root mean square of the error that load and pose cause in every robot",
        (1, 0, 0),
        "levels",
    ),
    _rms(
        "rms_robot",
        "r.m.s., differs between robots",
        "root mean square of the error that differs from robot to robot",
        (0, 1, 0),
        "levels",
    ),
    _rms(
        "rms_visit",
        "r.m.s., differs between visits",
        "root mean square of the error that differs from visit to visit of a robot",
        (0, 0, 1),
        "levels",
    ),
    ROTATION,
)


def figures_of(errors: Errors) -> dict[str, Figure]:
    """Return the figures that a run has, by key: AP and RP need two visits. Raises InputError for
    one of another package that cannot be used.
    """
    found = [each for each in _EVERY if each is not ROTATION or errors.rotation is not None]
    found[3:3] = map(percentile, errors.levels)
    if errors.accuracy is not None:
        found += accuracy(errors.visits)
    found += [each for approach in errors.repeats for each in repeatability(approach)]
    out = {each.key: each for each in found}
    for extension in extensions("figures").values():
        figure: Figure = extension.load("a Figure", lambda each: isinstance(each, Figure))
        if figure.key in out:
            raise extension.refusal(f"the key '{figure.key}', which is in use", "a key of its own")
        out[figure.key] = figure
    return out


def estimates(errors: Errors) -> dict[str, Estimate]:
    """Return every figure that a run has by key, in SI with its interval."""
    return {key: each.of(errors) for key, each in figures_of(errors).items()}
