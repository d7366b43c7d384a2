"""One arm of a comparison, studied over its poses, and the figures by which arms are compared."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from lostmotion.error_model.budget import Tally, costs, label_of, sums
from lostmotion.error_model.differences import sets_difference
from lostmotion.error_model.few_poses import many_poses
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.overload import Overload, overloads, rated_torques
from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.mechanism.state import states_of
from lostmotion.propagation.error_samples import Drawn
from lostmotion.propagation.figures import figures_of
from lostmotion.propagation.montecarlo.montecarlo import run

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.error_model.columns import Column
    from lostmotion.error_model.few_poses import Squares
    from lostmotion.error_model.poses import Poses
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.figures import Figure
    from lostmotion.propagation.montecarlo.montecarlo import Sampled
    from lostmotion.spatial import Floats


_CHUNK: Final = 4096


Grouping: TypeAlias = Literal["parts", "members", "causes"]


# Labels by which error terms are grouped: whole parts, the members that some parts consist of, and
# kinds of error.
GROUPINGS: Final[dict[Grouping, Callable[[Column], str]]] = {
    "parts": lambda column: column.of.whole_part,
    "members": label_of("part"),
    "causes": label_of("cause"),
}


@dataclass(frozen=True)
class ComparedArm:
    """One arm of a comparison, with what was found over its poses.

    label    its name in tables: that of its file where there is one
    tallies  exact error budget of each independent set of poses, for each of `GROUPINGS`
    squares  mean squares of the error by level over each set of poses, and over many poses
    held     (joint,) largest static load of each drive over the poses, N m or N
    """

    label: str
    arm: Arm
    poses: Poses
    sampled: Sampled
    tallies: tuple[list[Tally], ...]
    squares: Squares
    held: Floats
    known: States
    overloads: tuple[Overload, ...]
    approach: float

    @functools.cached_property
    def errors(self) -> Drawn:
        """Return what the figures of the error are estimated from."""
        return Drawn.of(self.sampled, self.squares, self.approach)

    @functools.cached_property
    def sag(self) -> Floats:
        """Return the mean displacement of the tool along gravity that all robots share, over each
        set of poses (set,), m; zero without gravity.
        """
        down = self.arm.gravity_in_base
        size = float(np.linalg.norm(down))
        along = self.sampled.bias[:, 3:] @ (down / size) if size else np.zeros(len(self.poses))
        return np.asarray(along.reshape(self.poses.replicates, -1).mean(axis=1))

    @property
    def load(self) -> float:
        """Return the largest static load of a drive over the poses as a share of its rated one; NaN
        where none is rated.
        """
        shares = self.held / rated_torques(self.arm)
        return float(np.nanmax(shares)) if np.isfinite(shares).any() else math.nan

    @functools.cached_property
    def contributions(self) -> dict[Grouping, dict[str, Floats]]:
        """Return by grouping, for each entry, its contribution to the mean square and its own mean
        square over each set of poses (set, 2), m^2.
        """
        out: dict[Grouping, dict[str, Floats]] = {}
        for k, grouping in enumerate(GROUPINGS):
            of_sets = [
                {
                    cost.part: (cost.share * each[k].total / each[k].poses, cost.alone**2)
                    for cost in costs(each[k])
                }
                for each in self.tallies
            ]
            out[grouping] = {
                name: np.array([found[name] for found in of_sets]) for name in of_sets[0]
            }
        return out

    @functools.cached_property
    def largest_contributor(self) -> tuple[str, float] | None:
        """Return the part with the largest share of the mean square, and that share; None where
        nothing errs.
        """
        total, of_parts = float(self.squares.visited.sum()), self.contributions["parts"]
        if not total > 0:
            return None
        part = max(of_parts, key=lambda name: float(of_parts[name][:, 0].sum()))
        return part, float(of_parts[part][:, 0].sum()) / total


def compared_arm(  # noqa: PLR0913 - a study is these numbers
    label: str,
    arm: Arm,
    poses: Poses,
    robots: int,
    visits: int,
    seed: int,
    *,
    approach: float = 0.0,
    threads: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> ComparedArm:
    """Return what is compared of one arm; arguments and errors as for `montecarlo.run`."""
    named = (
        None if progress is None else lambda what, done, of: progress(f"{label}: {what}", done, of)
    )
    sampled = run(
        arm, poses, robots, visits, seed, approach=approach, threads=threads, progress=named
    )
    groupings, many = tuple(GROUPINGS.values()), many_poses(arm, poses)
    found, squares = sums(arm, poses.q, groupings, approach, poses.replicates, many)
    held = np.max(
        [np.abs(state.torques).max(axis=0) for _, state in states_of(arm, poses.q, _CHUNK)],
        axis=0,
    )
    known = with_limits(states(arm), arm, poses.q, approach)
    return ComparedArm(
        label,
        arm,
        poses,
        sampled,
        tuple(found),
        squares,
        held,
        known,
        overloads(arm, poses),
        approach,
    )


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
