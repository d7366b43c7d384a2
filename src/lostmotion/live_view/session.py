"""The arm in the view, changed and moved: its figures, and the error over its workspace."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.error_model.budget import Tally, costs
from lostmotion.error_model.overload import rated_torques
from lostmotion.error_model.pose_matrix import Columns
from lostmotion.error_model.remedies import STAGES, geometry_of, remaining
from lostmotion.errors import LostmotionError
from lostmotion.live_view.choices import Choices, changed
from lostmotion.mechanism.inverse import inverse_kinematics, tool_and_jacobian
from lostmotion.mechanism.standing import standing
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.analytic import Analytic, DrawnColumns, joined, of_screws
from lostmotion.propagation.error_magnitude import LEVELS, TILE
from lostmotion.propagation.pooled import PooledHistogram

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.error_model.budget import Cost
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


_Q95: Final = LEVELS.index(0.95)
# From so many drives on the orientation of the tool stays while its point is dragged.
_ALL: Final = 6


@dataclass(frozen=True)
class Figures:
    """What the view shows at one pose, in SI.

    q           (joint,) rad and m
    at          (place, 4, 4) frames of the arm, m
    error       figures of the error without sampling and without bounds, at this one pose
    costs       contribution of each part, the largest first
    torques     (joint,) torque or force that each drive holds, N m or N
    loads       (joint,) the same as a share of the rated torque; NaN where none is stated
    """

    q: Floats
    at: Floats
    error: Analytic
    costs: list[Cost]
    torques: Floats
    loads: Floats

    @property
    def q95(self) -> float:
        """Return the 95th percentile of the position error, m."""
        return float(self.error.quantiles[0, _Q95])

    @property
    def is_precise(self) -> bool:
        """Return whether the uncertainty of the figures is at most 5 % of them."""
        return bool(self.error.valid[0])


@dataclass(frozen=True)
class ErrorOverWorkspace:
    """The error over the workspace.

    poses   joint values of the poses
    points  (pose, 3) tool points, m
    q95     (pose,) 95th percentile of the position error at each pose, m
    whole   the same over all poses together, m
    """

    poses: Poses
    points: Floats
    q95: Floats
    whole: Estimate


class LiveArm:
    """An arm at one stage of calibration and compensation, for figures at any pose.

    The draws are those of a study without sampling over `poses`. So each figure equals that of
    `propagation.analytic` at poses that begin with these.
    """

    def __init__(self, arm: Arm, poses: Poses, stage: str = STAGES[0]) -> None:
        """Prepare what does not depend on the pose."""
        self.arm, self.poses, self.stage = arm, poses, stage
        self._columns = Columns(arm)
        self._remaining = (
            None if stage == STAGES[0] else remaining(self._columns.infos, stage, geometry_of(arm))
        )
        self._drawn = DrawnColumns(self._screws(poses.q[:TILE]))

    def figures(self, q: Floats) -> Figures:
        """Return the figures at a pose q (joint,), rad and m."""
        pose = np.asarray(q, dtype=float)[None]
        matrix = self._screws(pose)
        torques = matrix.state.torques[0]
        return Figures(
            pose[0],
            matrix.state.commanded[:, 0],
            of_screws(matrix, self._drawn, with_bounds=False),
            costs(Tally.of(matrix)),
            torques,
            np.abs(torques) / rated_torques(self.arm),
        )

    def workspace(self) -> Iterator[ErrorOverWorkspace | None]:
        """Yield None after each part of the work, then the error over the workspace."""
        found, points, histogram = [], [], PooledHistogram(self.poses)
        for block in histogram.blocks(TILE):
            matrix = self._screws(self.poses.q[block])
            found.append(of_screws(matrix, self._drawn, with_bounds=False))
            points.append(matrix.state.commanded[-1, :, :3, 3])
            histogram.add(block, self._drawn.pooled_counts(matrix, histogram.points))
            yield None
        error = joined(found)
        whole = histogram.figures(error).quantiles[_Q95]
        yield ErrorOverWorkspace(
            self.poses, np.concatenate(points), error.quantiles[:, _Q95], whole
        )

    def _screws(self, q: Floats) -> PoseMatrix:
        """Return the pose matrix of the errors that remain, for q (pose, joint)."""
        matrix = self._columns.matrix(standing(state_of(self.arm, q)))
        return matrix if self._remaining is None else matrix.scaled(self._remaining)


@dataclass(frozen=True)
class Refused:
    """Why choices are impossible, or why no figure can be computed; the figures before stay."""

    reason: str


class Session:
    """The state of a view. `move` and `choose` may be called by any thread; one thread calls
    `step`, which computes.
    """

    def __init__(self, arm: Arm, poses: Poses, q: Floats) -> None:
        """Begin with the arm as it is, at the pose q (joint,), rad and m; `poses` are those of the
        workspace.
        """
        self.arm = arm
        self._file, self._poses = arm, poses
        self._lock, self._news = threading.Lock(), threading.Event()
        self._q, self._choices = np.array(q, dtype=float), Choices(arm.payload.mass)
        self._moved, self._chosen = True, True
        self._point: Floats | None = None
        self.led = False  # whether the last pose was found for a point of the tool
        self._live: LiveArm | None = None
        self._workspace: Iterator[ErrorOverWorkspace | None] | None = None
        self._news.set()

    @property
    def q(self) -> Floats:
        """Return the newest pose (joint,), rad and m."""
        with self._lock:
            return self._q.copy()

    @property
    def choices(self) -> Choices:
        """Return the newest choices."""
        with self._lock:
            return self._choices

    def move(self, q: Floats) -> None:
        """Ask for another pose q (joint,), rad and m, within the joint limits; values beyond are
        moved to the limit.

        Raises ValueError for a value that is no finite number.
        """
        low, high = self._file.limits.T
        _require_finite(q)
        with self._lock:
            self._q, self._moved = np.clip(np.asarray(q, dtype=float), low, high), True
        self._news.set()

    def move_joint(self, index: int, value: float) -> None:
        """Ask for another value of one joint, rad or m, within its limits. Raises ValueError for
        one that is no finite number.
        """
        _require_finite(value)
        with self._lock:
            self._q = self._q.copy()
            self._q[index], self._moved = np.clip(value, *self._file.limits[index]), True
        self._news.set()

    def lead(self, point: Floats) -> None:
        """Ask for a pose with the tool at a point (3,), m, in the base's frame. Raises ValueError
        for a value that is no finite number.

        It is the pose in which damped Newton steps from the newest one end, within the joint
        limits: at the point, or where the arm does not get nearer to it. From six drives on the
        tool keeps its orientation.
        """
        _require_finite(point)
        with self._lock:
            self._point = np.asarray(point, dtype=float)
        self._news.set()

    def choose(self, **changes: Any) -> None:  # noqa: ANN401 - fields of Choices
        """Ask for other choices; fields that are not named stay. Raises ValueError for a payload
        that an arm file could not state.
        """
        with self._lock:
            self._choices, self._chosen = replace(self._choices, **changes), True
        self._news.set()

    def choose_gearbox(self, joint: str, name: str) -> None:
        """Ask for another gearbox of a joint, by its name in the catalogue."""
        self.choose(gearboxes={**self.choices.gearboxes, joint: name})

    def choose_section(self, joint: str, name: str) -> None:
        """Ask for another section of the link of a joint, by its name in
        `choices.section_names`.
        """
        self.choose(sections={**self.choices.sections, joint: name})

    def wait(self, seconds: float) -> None:
        """Wait until something is to be computed, at most this long."""
        if self._workspace is None:
            self._news.wait(seconds)

    def step(self) -> Figures | ErrorOverWorkspace | Refused | None:
        """Compute what is asked for next and return it; None where nothing is complete."""
        with self._lock:
            q, choices, moved, chosen = self._q, self._choices, self._moved, self._chosen
            point, self._point = self._point, None
            self._moved = self._chosen = False
            self._news.clear()
        if moved or chosen or point is not None:
            self.led = point is not None
        try:
            if point is not None:
                q, moved = _led(self._file, q, point), True
                with self._lock:
                    if not self._moved:  # a newer pose was asked for meanwhile
                        self._q = q
            return self._compute(q, choices, moved=moved, chosen=chosen)
        except (LostmotionError, ValueError) as error:
            return Refused(str(error))

    def _compute(
        self, q: Floats, choices: Choices, *, moved: bool, chosen: bool
    ) -> Figures | ErrorOverWorkspace | None:
        if chosen:
            arm = changed(self._file, choices)
            live = LiveArm(arm, self._poses, choices.stage)
            found = live.figures(q)
            self.arm, self._live, self._workspace = arm, live, live.workspace()
            return found
        if moved and self._live is not None:
            return self._live.figures(q)
        if self._workspace is None:
            return None
        workspace, self._workspace = self._workspace, None  # work that fails is not repeated
        found_there = next(workspace)
        if found_there is None:
            self._workspace = workspace
        return found_there


def _led(arm: Arm, q: Floats, point: Floats) -> Floats:
    """Return the pose (joint,) with the tool at a point (3,), from the pose q; see `lead`."""
    wanted = np.array(tool_and_jacobian(arm, q)[0])
    wanted[0, :3, 3] = point
    found, _ = inverse_kinematics(arm, wanted, q, with_orientation=len(q) >= _ALL)
    return np.asarray(found[0])


def _require_finite(values: Floats | float) -> None:
    if not np.isfinite(values).all():
        raise ValueError("a value is not a finite number")
