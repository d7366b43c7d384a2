"""A task of an arm: the places that the tool visits in their order, the tolerances that hold there,
and how the arm carries it out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.arrival import last_motion
from lostmotion.error_model.drawing_tolerances import TaskGeometryError, TaskPlaces, measure
from lostmotion.error_model.joint_path import joint_path
from lostmotion.error_model.pose_matrix import PoseMatrix, pose_matrix
from lostmotion.error_model.trust import refuse_untrusted
from lostmotion.errors import InputError, Problem
from lostmotion.mechanism.standing import standing
from lostmotion.mechanism.state import state_of
from lostmotion.mechanism.warm_up import link_growth

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.drawing_tolerances import (
        DrawingTolerance,
        Feature,
        ToleranceCheck,
    )
    from lostmotion.error_model.joint_path import Starts
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.state import State
    from lostmotion.mechanism.warm_up import OwnHeat
    from lostmotion.spatial import Floats

# Fewest joints for any orientation of the tool.
_FULL: Final = 6


@dataclass(frozen=True)
class ForceAlong:
    """Force on the tool at the places of a task.

    vector   (place, 3) N, along the axes of the task
    along    (place,) N, along the direction of travel
    scatter  standard deviation from run to run, as a share of the force
    """

    vector: Floats
    along: Floats
    scatter: float


@dataclass(frozen=True)
class Task:
    """A task; its rows are the poses that the arm visits, some of which are places with tolerances.

    poses      (row, 4, 4) of the tool in the frame of the task, m; None where joint values are
               stated
    q          (row, joint) joint values, rad or m; None where poses are stated
    turned     whether the poses state the orientation of the tool
    visited    (row,) whether it is a place; the arm only passes through other rows
    where      file and row of each row
    approach   (row, joint) stated sign of the last motion, NaN where the path decides
    features   in the order in which they are visited; axes in the frame of the task
    placement  (4, 4) frame of the task in the base's frame, m
    search     (4, 2) limits of a shift of the placement along x, y, z (m) and of its yaw (rad),
               within which the best one is to be found; None: it is fixed
    repeated   whether the task runs over and over: the last row comes before the first
    heat       of the joints over the task, which links grow by; None: none stated
    required   share of robots and runs in which all tolerances must hold
    """

    name: str
    poses: Floats | None
    q: Floats | None
    turned: bool
    visited: NDArray[np.bool_]
    where: tuple[tuple[str, str], ...]
    approach: Floats
    features: tuple[Feature, ...]
    tolerances: tuple[DrawingTolerance, ...]
    placement: Floats
    search: Floats | None
    force: ForceAlong | None
    repeated: bool
    required: float
    heat: OwnHeat | None = None

    @property
    def places(self) -> NDArray[np.int64]:
        """Return the rows that are places (place,)."""
        return np.flatnonzero(self.visited)


@dataclass(frozen=True)
class Program:
    """A task as an arm carries it out.

    q         (row, joint) joint values, rad or m
    places    where tolerances apply
    features  with axes in the base's axes
    sides     (place, joint) sign of each joint's last motion, 0 where it is drawn
    since     (place, joint) row at which the joint took that side
    measures  how each tolerance is checked
    placement (4, 4) frame of the task in the base's frame, m
    force     (place, 3) process force along the axes of the tool, N; None without one
    varying   (place, 6) twist of the tool by one standard deviation of the force, rad and m
    growth    (joint, place, 6) twist of the tool by the full temperature rise of each link, rad and
              m; None without own heat
    """

    arm: Arm
    task: Task
    q: Floats
    places: TaskPlaces
    features: tuple[Feature, ...]
    sides: Floats
    since: NDArray[np.int64]
    measures: tuple[ToleranceCheck, ...]
    placement: Floats
    force: Floats | None = None
    varying: Floats | None = None
    growth: Floats | None = None

    @property
    def visited(self) -> Floats:
        """Return the joint values at the places (place, joint)."""
        return np.asarray(self.q[self.task.places])

    def matrix(self, sides: Floats | None = None) -> PoseMatrix:
        """Return the pose matrix at the places under the process force, with the sides of the path
        or others (place, joint). Under several forces only what samples and sums read is joined:
        `tool`, `local`, `closed` and the columns.
        """
        parts = self.parts(sides)
        if len(parts) == 1:
            return parts[0][1]
        order = np.argsort(np.concatenate([rows for rows, _ in parts]))
        matrices = [matrix for _, matrix in parts]
        return replace(
            matrices[0],
            tool=np.concatenate([each.tool for each in matrices])[order],
            local=np.concatenate([each.local for each in matrices])[order],
            closed=np.concatenate([each.closed for each in matrices], axis=1)[:, order],
        )

    def parts(self, sides: Floats | None = None) -> list[tuple[NDArray[np.int64], PoseMatrix]]:
        """Return the places under each process force, and the pose matrix there."""
        approach = self.sides if sides is None else sides
        every = np.arange(len(approach))
        if self.force is None:
            return [(every, pose_matrix(self.arm, self.visited, approach=approach))]
        forces, group = np.unique(np.round(self.force, 6), axis=0, return_inverse=True)
        places = [every[group.ravel() == k] for k in range(len(forces))]
        return [
            (rows, self._under(force, rows, approach))
            for force, rows in zip(forces, places, strict=True)
        ]

    def grown(self, runs: int) -> Floats:
        """Return the twist of the tool by the growth of each link at each place in each run (joint,
        place, 6, run), rad and m; no joints without own heat.
        """
        heat = self.task.heat
        if heat is None or self.growth is None:
            return np.zeros((0, len(self.sides), 6, runs))
        shares = heat.shares(heat.times(len(self.sides), runs))
        return np.asarray(self.growth[..., None] * shares[:, :, None])

    def warmed(self) -> Program:
        """Return the program of an arm that is warm from the start."""
        heat = self.task.heat
        if heat is None:
            return self
        return replace(self, task=replace(self.task, heat=replace(heat, warm=True)))

    def with_payload(self, factor: float) -> Program:
        """Return the program with a payload of another mass by this factor."""
        payload = self.arm.payload
        heavier = payload.model_copy(update={"mass": payload.mass * factor})
        return replace(self, arm=self.arm.with_payload(heavier))

    def _under(self, force: Floats, rows: NDArray[np.int64], approach: Floats) -> PoseMatrix:
        """Return the pose matrix at some places under one force."""
        payload = self.arm.payload
        more = tuple(float(x) for x in np.array(payload.force) + force)
        arm = self.arm.with_payload(payload.model_copy(update={"force": more}))
        # Two further rows, with known and with drawn sides, so that all parts have equal columns.
        padded = np.concatenate([rows, rows[:1], rows[:1]])
        sides = np.vstack([approach[rows], np.ones(approach.shape[1]), np.zeros(approach.shape[1])])
        whole = pose_matrix(arm, self.visited[padded], approach=sides)
        return whole.stretch(0, len(rows))


def program_of(
    arm: Arm, task: Task, shift: Floats | None = None, starts: Starts | None = None
) -> Program:
    """Return how an arm carries out a task, at its placement or one moved by `shift` (4, 4);
    `starts` as in `joint_path`.

    Raises InputError, with file and row, for a place out of reach and for a tolerance that the
    places of the task cannot have.
    """
    placement = task.placement if shift is None else task.placement @ shift
    q = _joint_values(arm, task, placement, starts)
    places = task.places
    refuse_untrusted(arm, q[places], 0.0)
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
    force, varying = _forces(task, at, state)
    checks = _measures(task, features, at)
    sided = (sides[places], since[places])
    return Program(
        arm, task, q, at, features, *sided, checks, placement, force, varying, _growth(task, state)
    )


def _growth(task: Task, state: State) -> Floats | None:
    heat = task.heat
    if heat is None:
        return None
    return link_growth(standing(state), dict(zip(heat.joints, heat.rise.tolist(), strict=True)))


def _forces(task: Task, at: TaskPlaces, state: State) -> tuple[Floats | None, Floats | None]:
    """Return the force along the axes of the tool (place, 3), N, and the twist of the tool (place,
    6) by one standard deviation of it; None where there is none.
    """
    if task.force is None:
        return None, None
    force = task.force.vector @ at.axes.T + task.force.along[:, None] * at.along
    on_tool = np.einsum("pji,pj->pi", at.frames[:, :3, :3], force)
    if not task.force.scatter:
        return on_tool, None
    return on_tool, state.deflection(task.force.scatter * np.hstack([0 * force, force]))


def _joint_values(arm: Arm, task: Task, placement: Floats, starts: Starts | None) -> Floats:
    if task.q is not None:
        return task.q
    if task.poses is None:
        raise ValueError("a task without poses and joint values")
    wanted = placement @ task.poses
    turned = task.turned and len(arm.tree.tool_joints) >= _FULL
    q, count = joint_path(arm, wanted, with_orientation=turned, starts=starts)
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
