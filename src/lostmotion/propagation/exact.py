"""Comparison of the first-order sum of errors with their exact composition: for each drawn robot
the equilibrium of its own parts under their loads.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.calibrated import correlated_draws
from lostmotion.error_model.closing import standardised
from lostmotion.error_model.draws import Stream, robot_draws, visit_draws
from lostmotion.error_model.pose_matrix import last_motion_at
from lostmotion.mechanism.equilibrium import settle
from lostmotion.mechanism.state import DesignDeflection

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.closing import Closing
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.mechanism.calibration import Correlations
    from lostmotion.spatial import Floats

# The first-order sum is refused where it differs from exact composition by a larger share of the
# error.
FAILS: Final = 0.1
# Differences below a nanometre do not count, for any size of the error.
_NOTHING: Final = 1e-9
# Poses of a study at which it is compared, evenly spread; robots at each, and visits of each.
POSES: Final = 12
ROBOTS: Final = 16
VISITS: Final = 4


@dataclass(frozen=True, slots=True)
class ExactCheck:
    """Differences between the first-order sum and the exact composition on a sample.

    largest, mean  distance between the two tool positions, m
    samples        number of samples
    turn, length   largest first-order rotation of the tool (rad) and largest first-order error (m)
                   of these samples
    """

    largest: float
    mean: float
    samples: int
    turn: float = 0.0
    length: float = 0.0


def share_neglected(check: ExactCheck, error: float) -> float:
    """Return the largest share of an error (m) that the first-order sum neglects on the sample;
    infinite for an error that is not finite.
    """
    if not math.isfinite(error) or not math.isfinite(check.largest):
        return math.inf
    if check.largest <= _NOTHING:
        return 0.0
    return check.largest / error if error > 0 else math.inf


def join(checks: Sequence[ExactCheck]) -> ExactCheck:
    """Return the check over all of these samples."""
    samples = sum(check.samples for check in checks)
    mean = sum(check.mean * check.samples for check in checks) / max(samples, 1)
    return ExactCheck(
        max(check.largest for check in checks),
        mean,
        samples,
        max(check.turn for check in checks),
        max(check.length for check in checks),
    )


def draws_of(
    matrix: PoseMatrix,
    row: int | NDArray[np.int64],
    seed: int,
    pose: int | NDArray[np.int64],
    robots: NDArray[np.int64],
    visits: NDArray[np.int64],
) -> Floats:
    """Return the draws of each column for these samples (column, sample); 1 for design terms.

    row, pose       row of the matrix, and number of the pose in the study: one for all samples, or
                    one for each (sample,)
    robots, visits  numbers of the robot and of the visit of each sample (sample,)
    """
    out = np.ones((len(matrix.infos), len(robots)))
    count = int(robots.max()) + 1
    correlated = _first_correlated(seed, matrix.correlations, count)
    visiting = [(k, info.visit) for k, info in enumerate(matrix.infos) if info.visit is not None]
    # columns share streams and closings: each is drawn once
    streams = {stream: at for at, stream in enumerate(dict.fromkeys(each for _, each in visiting))}
    drawn = visit_draws(seed, list(streams), pose, robots, visits)
    out[[k for k, _ in visiting]] = drawn[[streams[stream] for _, stream in visiting]]
    closed: dict[Closing, Floats] = {}
    for k, info in enumerate(matrix.infos):
        if info.robot is not None:
            own = correlated.get(info.robot.name)
            out[k] *= (_first_robots(seed, info.robot, count) if own is None else own)[robots]
        if info.closing is not None:
            if info.closing not in closed:
                closed[info.closing] = standardised(
                    _first_robots(seed, info.closing.stream, count)[robots],
                    matrix.closed[info.closing.row, row],
                )
            out[k] *= closed[info.closing]
    return out


@functools.lru_cache(maxsize=1024)
def _first_robots(seed: int, stream: Stream, count: int) -> Floats:
    return np.asarray(robot_draws(seed, [stream], count)[:, 0, :].ravel())


@functools.lru_cache(maxsize=8)
def _first_correlated(
    seed: int, correlations: Correlations | None, count: int
) -> dict[str, Floats]:
    drawn = {} if correlations is None else correlated_draws(seed, correlations, count)
    return {name: draws.ravel() for name, draws in drawn.items()}


class _DrawnRobots:
    """How the robots of samples deflect: each with its own stiffness and geometry."""

    def __init__(self, matrix: PoseMatrix, sample: NDArray[np.int64], draws: Floats) -> None:
        """Take the row of the matrix of each sample, and its draws (column, sample)."""
        self._place, self._draws = matrix.place, draws
        self._columns = columns = matrix.columns_of
        self._closed = matrix.closed[:, sample]
        self._last_motion = last_motion_at(matrix.last_motion, sample)
        self._mean = DesignDeflection(matrix.state.rows(sample))
        self.freedoms, self.tangent = self._mean.freedoms, self._mean.tangent
        self._fixed = np.zeros((len(matrix.state.frames), len(sample), 6))
        local = np.ascontiguousarray(matrix.local.transpose(1, 2, 0)[:, :, sample])
        self._sum(columns.fixed, local, draws, self._fixed)

    def twists(
        self, frames: Floats, rows: NDArray[np.int64], *, play: bool = True
    ) -> tuple[Floats, Floats]:
        """Return the twists of the parts (place, sample, 6), rad and m: without those within plays,
        and of those, which are zero without `play`. Plays stay open or closed as at the mean of all
        robots.
        """
        columns = self._columns
        local = columns.local(
            *self._mean.within(frames, rows),
            last_motion_at(self._last_motion, rows),
            self._closed[:, rows],
            play=play,
            loads_alone=True,
        )
        smooth, in_play = self._fixed[:, rows], np.zeros((len(frames), len(rows), 6))
        self._sum(~columns.fixed & ~columns.jumps, local, self._draws[:, rows], smooth)
        if play:
            self._sum(columns.jumps, local, self._draws[:, rows], in_play)
        return smooth, in_play

    def _sum(self, of: NDArray[np.bool_], local: Floats, draws: Floats, out: Floats) -> None:
        """Add the twists of these columns to `out` (place, sample, 6)."""
        for k in np.flatnonzero(of):
            out[self._place[k]] += (local[:, k] * draws[k]).T


def compose(matrix: PoseMatrix, rows: NDArray[np.int64], draws: Floats) -> Floats:
    """Return the exact frames of the tool (row, sample, 4, 4) at the poses in these rows of the
    matrix, for draws (row, column, sample).

    Of a settled arm every robot stands in the equilibrium of its own parts: the exact geometry,
    with the loads and springs of the deflected robot. Frames are NaN where there is none. In any
    other state every place moves by the exponential of the sum of its own columns.
    """
    found, count = matrix.state.equilibrium, draws.shape[2]
    if found is not None:
        sample = np.repeat(rows, count)
        drawn = _DrawnRobots(
            matrix, sample, draws.transpose(1, 0, 2).reshape(draws.shape[1], len(sample))
        )
        settled = settle(matrix.state.arm.tree, found.command[:, sample], drawn)
        return np.asarray(settled.frames[-1].reshape(len(rows), count, 4, 4))
    places = np.unique(matrix.place)
    local = matrix.local[rows]
    twists = np.empty((len(places), len(rows), count, 6))
    for twist, place in zip(twists, places, strict=True):
        own = matrix.place == place
        twist[:] = (local[:, :, own] @ draws[:, own]).transpose(0, 2, 1)
    return matrix.state.rows(rows).composed(places.tolist(), twists)


def check(
    matrix: PoseMatrix,
    first_pose: int,
    rows: NDArray[np.int64],
    seed: int,
    robots: int,
    visits: int,
) -> ExactCheck:
    """Return the differences between the first-order sum and the exact composition of the same
    draws.

    first_pose       number in the study of the first pose of the matrix
    rows             rows of the matrix that are compared; none: no samples
    robots, visits   numbers of robots and of visits that are compared at each pose
    """
    if not len(rows):
        return ExactCheck(0.0, 0.0, 0)
    row, robot, visit = (
        axis.ravel()
        for axis in np.meshgrid(rows, np.arange(robots), np.arange(visits), indexing="ij")
    )
    draws = (
        draws_of(matrix, row, seed, first_pose + row, robot, visit)
        .reshape(len(matrix.infos), len(rows), robots * visits)
        .transpose(1, 0, 2)
    )
    turns, linear = np.split((matrix.tool[rows] @ draws).transpose(0, 2, 1), 2, axis=-1)
    wanted = matrix.state.commanded[-1, rows, None, :3, 3]
    exactly = compose(matrix, rows, draws)[..., :3, 3] - wanted
    distances = np.linalg.norm(exactly - linear, axis=-1)
    distances = np.where(np.isnan(distances), math.inf, distances)  # a robot that falls
    turn, length = (float(np.linalg.norm(each, axis=-1).max()) for each in (turns, linear))
    return ExactCheck(float(distances.max()), float(distances.mean()), distances.size, turn, length)
