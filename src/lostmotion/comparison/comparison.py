"""Arms studied with the same draws, and what is different in each from the first."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.comparison.compared_arm import GROUPINGS, Measure, measures
from lostmotion.comparison.description import (
    Difference,
    StateChange,
    state_changes,
    value_differences,
)
from lostmotion.error_model.budget import NOTHING, budget_changes
from lostmotion.error_model.differences import (
    ZERO,
    root_mean_square_difference,
    sets_difference,
    share_of_difference,
)
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.comparison.compared_arm import ComparedArm, Grouping
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


# A distance below this share of the distance of the tool from the base is rounding.
_ROUNDING: Final = 1e-12


@dataclass(frozen=True)
class ToolDistance:
    """Distance between the tool points that two arms command at the same joint values.

    tool       (pose, 3) tool points of the first arm in the base's frame, m
    vectors    (pose, 3) from these to the tool points of the other arm, m
    distances  (pose,) their lengths, m
    mean, p95  mean and 95th percentile over the poses, m; the intervals are due to the choice of
               poses
    """

    tool: Floats
    vectors: Floats
    distances: Floats
    mean: Estimate
    p95: Estimate

    @property
    def largest_at(self) -> int:
        """Return the number of the pose with the largest distance."""
        return int(self.distances.argmax())

    @property
    def largest(self) -> float:
        """Return the largest distance over the poses, m."""
        return float(self.distances.max())

    @property
    def is_zero(self) -> bool:
        """Return whether both arms command the same tool point at every pose, but for rounding."""
        return self.largest <= _ROUNDING * float(np.linalg.norm(self.tool, axis=1).max())


def tool_distance(before: Arm, after: Arm, poses: Poses) -> ToolDistance:
    """Return the distance between the commanded tool points of two arms at the same poses. Valid
    for arms with as many driven joints.
    """
    tool = tool_points(before, poses.q)
    vectors = tool_points(after, poses.q) - tool
    distances = np.linalg.norm(vectors, axis=1)
    of_sets = distances.reshape(poses.replicates, -1)
    nothing = np.zeros(poses.replicates)
    mean, p95 = (
        sets_difference(nothing, each)
        for each in (of_sets.mean(axis=1), np.quantile(of_sets, 0.95, axis=1))
    )
    return ToolDistance(tool, vectors, distances, mean, p95)


# Share of the largest one below which a change by part is none of its own: a part that is the same
# is turned by the other parts' errors.
_LEAST: Final = 1e-4


@dataclass(frozen=True)
class PartChange:
    """One part, or kind of error, in two arms; all in m.

    before, after  its own r.m.s. error in each; None in an arm without it
    alone          the difference of the two
    share          its share of the difference of the arms' r.m.s. errors
    """

    part: str
    before: float | None
    after: float | None
    alone: Estimate
    share: Estimate


@dataclass(frozen=True)
class Change:
    """What is different in one arm from the first one.

    figures  difference of every figure by the key of its `Measure`, after minus before
    by       differences by grouping, the largest share of the difference first: "parts", "members"
             (of parts that consist of several), "causes"
    same     whether every robot of both has the same errors, to the last bit
    apart    distance between the tool points that both command at the same joint values; None where
             they stand at different ones
    """

    arm: ComparedArm
    figures: dict[str, Estimate]
    by: dict[Grouping, tuple[PartChange, ...]]
    same: bool
    apart: ToolDistance | None = None

    def moving(self, grouping: Grouping) -> list[PartChange]:
        """Return the entries with a share that a table shows, the largest first: one far below the
        others is what couples it to them.
        """
        largest = max((abs(each.share.value) for each in self.by[grouping]), default=0.0)
        return [each for each in self.by[grouping] if abs(each.share.value) > _LEAST * largest]

    @property
    def parts(self) -> tuple[PartChange, ...]:
        """Return the differences by part."""
        return self.by["parts"]


@dataclass(frozen=True, repr=False)
class Comparison:
    """Arms compared with the first of them.

    values   values that are not the same in all arms; states: kinds of error that are not equally
             well known
    paired   whether all arms stand at the same joint values
    """

    arms: tuple[ComparedArm, ...]
    measures: tuple[Measure, ...]
    changes: tuple[Change, ...]
    values: tuple[Difference, ...]
    states: tuple[StateChange, ...]
    paired: bool
    seed: int
    approach: float


def comparison(arms: Sequence[ComparedArm], seed: int, approach: float) -> Comparison:
    """Return what differs between these arms and what it did, all against the first."""
    first, *others = arms
    figures = measures(arms)
    return Comparison(
        tuple(arms),
        figures,
        tuple(_change(first, other, figures) for other in others),
        value_differences([each.arm for each in arms]),
        state_changes([each.known for each in arms]),
        all(_stand_at_the_same(first, other) for other in others),
        seed,
        approach,
    )


def _change(before: ComparedArm, after: ComparedArm, figures: Sequence[Measure]) -> Change:
    same = same_errors(before, after)
    found = {
        each.key: ZERO if same and not each.exact else each.change(before, after)
        for each in figures
    }
    contributions = _contributions(before, after)
    by = {
        grouping: _part_changes(before, after, grouping, contributions[grouping], same=same)
        for grouping in GROUPINGS
    }
    apart = (
        tool_distance(before.arm, after.arm, before.poses)
        if _stand_at_the_same(before, after)
        else None
    )
    return Change(after, found, by, same, apart)


def same_errors(before: ComparedArm, after: ComparedArm) -> bool:
    """Return whether every robot of both arms has the same errors, to the last bit, by their mean
    squares also at the poses of the check.
    """
    one, other = before.sampled, after.sampled
    return all(
        np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)
        for name in ("robot_means", "group_hist", "per_pose", "bias")
    ) and all(
        np.array_equal(getattr(before.squares, name), getattr(after.squares, name))
        for name in ("visited", "many")
    )


def _part_changes(
    before: ComparedArm,
    after: ComparedArm,
    grouping: Grouping,
    changes: list[dict[str, float]],
    *,
    same: bool,
) -> tuple[PartChange, ...]:
    """Return the changes of one grouping, the largest share of the difference first; `changes` of
    the mean square over each set of poses, m^2.
    """
    found = [each.contributions[grouping] for each in (before, after)]
    totals = [each.squares.visited.sum(axis=1) for each in (before, after)]
    nothing = NOTHING * float(sum(total.mean() for total in totals))
    without = np.zeros(len(before.tallies))
    out = []
    for part in dict.fromkeys((*found[0], *found[1])):
        own = [each[part][:, 1] if part in each else without for each in found]
        one, other = (
            math.sqrt(float(alone.mean())) if part in each else None
            for alone, each in zip(own, found, strict=True)
        )
        of_sets = np.array([each.get(part, 0.0) for each in changes])
        moved = np.abs(of_sets).max() > nothing and not same
        alone = ZERO if same else root_mean_square_difference(own[0], own[1])
        out.append(
            PartChange(
                part, one, other, alone, share_of_difference(of_sets, *totals) if moved else ZERO
            )
        )
    # what is equal but for rounding stays in the order of the arms
    return tuple(sorted(out, key=lambda each: -float(f"{abs(each.share.value):.9g}")))


def _contributions(
    before: ComparedArm, after: ComparedArm
) -> dict[Grouping, list[dict[str, float]]]:
    """Return the contributions to the change of the mean square over each set of poses, by
    grouping.

    At the same joint values errors are compared pose by pose; else the contribution that a part has
    in one arm is taken from that in the other.
    """
    if _stand_at_the_same(before, after):
        found = budget_changes(
            before.arm,
            after.arm,
            before.poses.q,
            tuple(GROUPINGS.values()),
            approach=before.approach,
            replicates=before.poses.replicates,
        )
        return {grouping: [each[k] for each in found] for k, grouping in enumerate(GROUPINGS)}
    out: dict[Grouping, list[dict[str, float]]] = {}
    for grouping in GROUPINGS:
        one, other = before.contributions[grouping], after.contributions[grouping]
        nothing = np.zeros((len(before.tallies), 2))
        changes = {
            name: other.get(name, nothing)[:, 0] - one.get(name, nothing)[:, 0]
            for name in dict.fromkeys((*one, *other))
        }
        out[grouping] = [
            {name: float(change[k]) for name, change in changes.items()}
            for k in range(len(before.tallies))
        ]
    return out


def _stand_at_the_same(before: ComparedArm, after: ComparedArm) -> bool:
    return np.array_equal(before.poses.q, after.poses.q)
