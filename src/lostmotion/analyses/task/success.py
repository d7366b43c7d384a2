"""Probability that simulated robots of a design meet all tolerances of a task, and what decides it.

Each robot is drawn once and carries out the task in every run. The side on which each joint rests
follows from the path: its last motion, at random until it first moves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.arrival import last_motion
from lostmotion.error_model.drawing_tolerances import TaskGeometryError, TaskPlaces, measure
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.joint_path import joint_path
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.small_counts import clustered_share
from lostmotion.errors import InputError, Problem
from lostmotion.mechanism.state import state_of
from lostmotion.propagation import exact
from lostmotion.propagation.tool_errors import tool_errors

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.columns import Column
    from lostmotion.error_model.drawing_tolerances import DrawingTolerance, Feature, ToleranceCheck
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.task import Task
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.exact import ExactCheck
    from lostmotion.spatial import Floats

_FULL: Final = 6
_CHECKED: Final = (8, 8, 4)  # places, robots and runs
LEVEL: Final = 0.95


@dataclass(frozen=True)
class Program:
    """A task as an arm carries it out.

    q         (row, joint) joint values, rad or m
    places    where tolerances apply
    features  with axes in the base's axes
    sides     (place, joint) sign of each joint's last motion, 0 where it is drawn
    since     (place, joint) row at which the joint took that side
    measures  how each tolerance is checked
    """

    arm: Arm
    task: Task
    q: Floats
    places: TaskPlaces
    features: tuple[Feature, ...]
    sides: Floats
    since: NDArray[np.int64]
    measures: tuple[ToleranceCheck, ...]

    @property
    def visited(self) -> Floats:
        """Return the joint values at the places (place, joint)."""
        return np.asarray(self.q[self.task.places])

    def matrix(self) -> PoseMatrix:
        """Return the pose matrix at the places, with the sides of the path."""
        return screws(state_of(self.arm, self.visited), approach=self.sides)


@dataclass(frozen=True)
class Judged:
    """How far the tolerances were used by robots and runs.

    used    (tolerance, robot, run) share of each tolerance that is used
    at      (place, robot, run) largest share at each place; NaN where no tolerance applies
    misses  by tolerance, (output,) number of samples beyond it
    squares by tolerance, (output,) mean square of the share used
    """

    used: Floats
    at: Floats
    misses: tuple[Floats, ...]
    squares: tuple[Floats, ...]

    @property
    def held(self) -> NDArray[np.bool_]:
        """Return whether all tolerances hold (robot, run)."""
        return np.asarray((self.used <= 1).all(axis=0))


@dataclass(frozen=True)
class ToleranceOutcome:
    """How one tolerance fares.

    held   probability that it holds
    used   share of it that 95 % of robots and runs stay within
    worst  number of the place where it is missed most often, and its mean square is largest
    """

    tolerance: DrawingTolerance
    held: Estimate
    used: Estimate
    worst: int


@dataclass(frozen=True, repr=False)
class TaskSuccess:
    """Whether a task succeeds.

    success     probability that all tolerances hold
    outcomes    of each tolerance, as stated
    features    probability that all tolerances of a feature hold, by its name
    place_held  (place,) probability that all tolerances hold at the place; NaN without any
    place_used  (place,) share of the tolerance used there by 95 % of robots and runs
    decisive    number of the tolerance that is missed most often
    parts       share of each part in the mean square of that tolerance at its worst place
    causes      the same by kind of error
    reversal    (place,) displacement of the tool when the path is followed backwards, m
    """

    program: Program
    robots: int
    runs: int
    seed: int
    success: Estimate
    outcomes: tuple[ToleranceOutcome, ...]
    features: dict[str, Estimate]
    place_held: Floats
    place_used: Floats
    decisive: int
    parts: dict[str, float]
    causes: dict[str, float]
    reversal: Floats
    check: ExactCheck

    @property
    def arm(self) -> Arm:
        """Return the arm."""
        return self.program.arm

    @property
    def task(self) -> Task:
        """Return the task as stated."""
        return self.program.task


def program_of(arm: Arm, task: Task, shift: Floats | None = None) -> Program:
    """Return how an arm carries out a task, at its placement or one moved by `shift` (4, 4).

    Raises InputError, with file and row, for a place out of reach and for a tolerance that the
    places of the task cannot have.
    """
    placement = task.placement if shift is None else task.placement @ shift
    q = _joint_values(arm, task, placement)
    places = task.places
    state = state_of(arm, q[places])
    before = last_motion(q)[0][-1] if task.repeated else None
    if task.repeated:
        # A further row at the beginning, the last one of the run before.
        before = last_motion(q[[-1, 0]], before=before)[0][-1]
    sides, since = last_motion(q, task.approach, before)
    turned = placement[:3, :3] if task.q is None else np.eye(3)
    features = tuple(
        each if each.axis is None else replace(each, axis=turned @ each.axis)
        for each in task.features
    )
    frames = np.array(state.frames[-1])
    at = TaskPlaces(frames, _along(frames[:, :3, 3], features), turned)
    return Program(
        arm, task, q, at, features, sides[places], since[places], _measures(task, features, at)
    )


def _joint_values(arm: Arm, task: Task, placement: Floats) -> Floats:
    if task.q is not None:
        return task.q
    if task.poses is None:
        raise ValueError("a task without poses and joint values")
    wanted = placement @ task.poses
    turned = task.turned and len(arm.tree.tool_joints) >= _FULL
    q, count = joint_path(arm, wanted, with_orientation=turned)
    if count < len(wanted):
        file, row = task.where[count]
        point = ", ".join(f"{x * 1e3:.4g}" for x in wanted[count, :3, 3])
        clause = " with the orientation of the tool" if turned else ""
        onward = "" if count == 0 else ", in the configuration of the places before it"
        problem = (
            f"({point}) mm in the base's frame, which {arm.name} does not reach{clause}{onward}"
        )
        expected = "places within reach and the joint limits: another placement or tool_rpy"
        example = 'placement = { xyz = ["600 mm", "0 mm", "400 mm"] }'
        raise InputError([Problem(file, row, problem, expected, example)])
    return q


def _along(points: Floats, features: Sequence[Feature]) -> Floats:
    """Return the unit direction of travel (place, 3) within lines, circles and paths."""
    out = np.zeros_like(points)
    for each in features:
        if each.kind in {"line", "circle", "path"} and len(each.places) > 1:
            way = np.gradient(points[each.places], axis=0)
            size = np.linalg.norm(way, axis=1, keepdims=True)
            out[each.places] = np.divide(way, size, out=np.zeros_like(way), where=size > 0)
    return out


def _measures(
    task: Task, features: Sequence[Feature], places: TaskPlaces
) -> tuple[ToleranceCheck, ...]:
    out, problems = [], []
    for each in task.tolerances:
        try:
            out.append(measure(each, features, places))
        except TaskGeometryError as error:
            problems.append(Problem(*each.where, error.found, error.expected))
    if problems:
        raise InputError(problems)
    return tuple(out)


def judged(program: Program, matrix: PoseMatrix, robots: int, runs: int, seed: int) -> Judged:
    """Return how far these robots use the tolerances in these runs."""
    count = len(matrix.tool)
    used = np.empty((len(program.measures), robots, runs))
    at = np.full((count, robots, runs), np.nan)
    misses = [np.zeros(len(each.outputs)) for each in program.measures]
    squares = [np.zeros(len(each.outputs)) for each in program.measures]
    for here, errors in tool_errors(matrix, seed, robots, runs, program.since):
        shape = errors.shape[2:]
        flat = errors.reshape(count, 6, -1)
        for k, each in enumerate(program.measures):
            whole, by = each.used(flat)
            used[k, here] = whole.reshape(shape)
            misses[k] += (by > 1).sum(axis=1)
            squares[k] += (by**2).sum(axis=1) / (robots * runs)
            for place, values in zip(each.outputs, by.reshape(-1, *shape), strict=True):
                at[place, here] = np.fmax(at[place, here], values)
    return Judged(used, at, tuple(misses), tuple(squares))


def share_of(held: NDArray[np.bool_]) -> Estimate:
    """Return the share of robots and runs (robot, run), with the interval by robots."""
    return Estimate(
        float(held.mean()), *clustered_share(held.mean(axis=1), held.shape[1]), unit="1"
    )


def carry_out(
    arm: Arm,
    task: Task,
    robots: int,
    runs: int,
    seed: int,
    progress: Callable[[str, int, int], None] | None = None,
) -> TaskSuccess:
    """Return whether a task succeeds, over these robots and runs. Errors as `program_of`."""
    report = progress or (lambda _stage, _done, _total: None)
    report("finding the joint values", 0, 3)
    program = program_of(arm, task)
    matrix = program.matrix()
    report("running the task", 1, 3)
    found = judged(program, matrix, robots, runs, seed)
    report("finding what decides it", 2, 3)
    outcomes = tuple(_outcome(program, found, k) for k in range(len(program.measures)))
    decisive = min(
        range(len(outcomes)), key=lambda k: (outcomes[k].held.value, -outcomes[k].used.value)
    )
    output = _worst(found, decisive)
    operator = program.measures[decisive].operator(output, len(matrix.tool))
    rows = np.unique(np.linspace(0, len(matrix.tool) - 1, _CHECKED[0]).astype(int))
    many, often = min(robots, _CHECKED[1]), min(runs, _CHECKED[2])
    with np.errstate(invalid="ignore"):
        within = np.where(np.isnan(found.at), np.nan, found.at <= 1).mean(axis=(1, 2))
        quantiles = np.quantile(found.at.reshape(len(found.at), -1), LEVEL, axis=1)
    return TaskSuccess(
        program,
        robots,
        runs,
        seed,
        share_of(found.held),
        outcomes,
        _by_feature(program, found),
        np.asarray(within, dtype=float),
        np.asarray(quantiles, dtype=float),
        decisive,
        shares(matrix, operator, program.since, lambda column: column.owner),
        shares(
            matrix,
            operator,
            program.since,
            lambda column: f"{column.of.kind} {column.of.term.cause}",
        ),
        _reversal(program, matrix),
        exact.check(matrix, 0, rows, seed, many, often),
    )


def _outcome(program: Program, found: Judged, k: int) -> ToleranceOutcome:
    used = found.used[k]
    value = float(np.quantile(used, LEVEL))
    # Woodruff's interval: the quantiles at the ends of that of the share below.
    ends = clustered_share((used <= value).mean(axis=1), used.shape[1])
    low, high = (math.nan if math.isnan(end) else float(np.quantile(used, end)) for end in ends)
    spread = Estimate(value, min(low, value), max(high, value), unit="1")
    place = int(program.measures[k].outputs[_worst(found, k)])
    return ToleranceOutcome(program.task.tolerances[k], share_of(used <= 1), spread, place)


def _worst(found: Judged, k: int) -> int:
    """Return the output of a tolerance that is missed most often, or else used most."""
    order = np.lexsort((found.squares[k], found.misses[k]))
    return int(order[-1])


def _by_feature(program: Program, found: Judged) -> dict[str, Estimate]:
    """Return the probability that all tolerances of a feature hold, by its name."""
    out = {}
    for number, each in enumerate(program.features):
        own = [k for k, t in enumerate(program.task.tolerances) if number in t.features]
        if own:
            out[each.name] = share_of(np.asarray((found.used[own] <= 1).all(axis=0)))
    return out


def shares(
    matrix: PoseMatrix,
    operator: Floats,
    since: NDArray[np.int64],
    label: Callable[[Column], str],
) -> dict[str, float]:
    """Return the share of each label in the mean square of operator @ errors, the largest first;
    operator (c, place, 6). Exact sums over terms, without sampling; the shares add up to one.

    Plays that a load closes in some robots only count as if the same robots had them closed at all
    places.
    """
    by_place = np.einsum("cpi,pik->pck", operator, matrix.tool)
    names = [label(column) for column in matrix.infos]
    out = dict.fromkeys(names, 0.0)
    for key, members in matrix.groups.items():
        first = matrix.infos[members[0]]
        moved = by_place[:, :, members]
        if first.visit is None:
            drawn = moved.sum(axis=0)[None]
        elif first.of.term.sided and first.of.joint is not None:
            drawn = _together(moved, since[:, first.of.joint])
        else:
            drawn = moved
        if key in matrix.mixtures:
            of_columns = np.einsum("pck,kl,pcl->k", drawn, matrix.mixtures[key].correlation, drawn)
        else:
            of_columns = np.einsum("pck,pc->k", drawn, drawn.sum(axis=2))
        for k, square in zip(members, of_columns, strict=True):
            out[names[k]] += float(square)
    total = sum(out.values())
    ordered = sorted(out.items(), key=lambda item: -abs(item[1]))
    return {name: square / total if total else 0.0 for name, square in ordered}


def _together(moved: Floats, since: NDArray[np.int64]) -> Floats:
    """Return the sums over places (group, c, column) that share a drawn side."""
    groups, index = np.unique(since, return_inverse=True)
    out = np.zeros((len(groups), *moved.shape[1:]))
    np.add.at(out, index, moved)
    return out


def _reversal(program: Program, matrix: PoseMatrix) -> Floats:
    """Return the displacement of the mean tool point (place,), m, between the path and the same
    path followed backwards; zero for joints that rest on a drawn side.
    """
    back = last_motion(program.q[::-1])[0][::-1][program.task.places]
    other = screws(matrix.state, approach=back)
    return np.asarray(np.linalg.norm((other.bias - matrix.bias)[:, 3:], axis=1))
