"""The error that the first-order sum neglects: the same errors composed exactly, as a product of exponentials."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.closing import standardised
from lostmotion.error_model.draws import Stream, robot_draws, visit_draws
from lostmotion.mechanism.frames import steps_between
from lostmotion.spatial import exp

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.spatial import Floats

# Beyond this difference from exact composition, as a share of the error, first order fails.
FAILS: Final = 0.1
# A nanometre: what differs by less does not matter, however small the error is.
_NOTHING: Final = 1e-9


@dataclass(frozen=True, slots=True)
class ExactCheck:
    """First order against exact composition on a sample.

    largest, mean  distance between the two, m
    samples        how many were compared
    turn, length   the largest first-order rotation of the tool (rad) and the largest first-order error (m) among them
    """

    largest: float
    mean: float
    samples: int
    turn: float = 0.0
    length: float = 0.0


def share_left_out(check: ExactCheck, error: float) -> float:
    """Return the share of an error (m) that the first-order sum neglects at most, as far as compared; infinite for an error beyond all figures."""
    if not math.isfinite(error) or not math.isfinite(check.largest):
        return math.inf
    if check.largest <= _NOTHING:
        return 0.0
    return check.largest / error if error > 0 else math.inf


def join(checks: Sequence[ExactCheck]) -> ExactCheck:
    """Return the check of several samples together."""
    samples = sum(check.samples for check in checks)
    mean = sum(check.mean * check.samples for check in checks) / max(samples, 1)
    return ExactCheck(
        max(check.largest for check in checks), mean, samples, max(check.turn for check in checks), max(check.length for check in checks)
    )


def draws_of(
    matrix: PoseMatrix, row: int | NDArray[np.int64], seed: int, pose: int | NDArray[np.int64], robots: NDArray[np.int64], visits: NDArray[np.int64]
) -> Floats:
    """Return the draws of each column at these visits (column, sample), for equally long lists of robots and visits; 1 for design terms.

    `row` is the row of the matrix and `pose` the number of the pose in the study: one for all samples, or one for each.
    """
    out = np.ones((len(matrix.infos), len(robots)))
    built = int(robots.max()) + 1
    visiting = [(k, info.visit) for k, info in enumerate(matrix.infos) if info.visit is not None]
    out[[k for k, _ in visiting]] = visit_draws(seed, [stream for _, stream in visiting], pose, robots, visits)
    for k, info in enumerate(matrix.infos):
        if info.robot is not None:
            out[k] *= _first_robots(seed, info.robot, built)[robots]
        if info.closing is not None:
            out[k] *= standardised(_first_robots(seed, info.closing.stream, built)[robots], matrix.closed[info.closing.row, row])
    return out


@functools.lru_cache(maxsize=1024)
def _first_robots(seed: int, stream: Stream, count: int) -> Floats:
    return np.asarray(robot_draws(seed, [stream], count)[:, 0, :].ravel())


def compose(matrix: PoseMatrix, rows: NDArray[np.int64], draws: Floats) -> Floats:
    """Return the exact tool poses at the poses in these rows: (row, sample, 4, 4) for draws (row, term, sample).

    Every place turns and shifts by the exponential of the sum of its own terms; the chain is multiplied out. Exact in the
    errors' geometry at any size.
    """
    # Errors on a branch beside the way to the tool do not move it.
    places = [place for place in matrix.way if place in matrix.place]
    # From each place that moves to the next, and at last to the tool.
    *steps, last = steps_between(matrix.at[[*places, -1]][:, rows])
    local = matrix.local[rows]
    twists = np.empty((len(places), len(rows), draws.shape[2], 6))
    for twist, place in zip(twists, places, strict=True):
        own = matrix.place == place
        twist[:] = (local[:, :, own] @ draws[:, own]).transpose(0, 2, 1)
    here = np.broadcast_to(np.eye(4), (*twists.shape[1:3], 4, 4))
    for step, moved in zip(steps, exp(twists), strict=True):
        here = here @ (step[:, None] @ moved)
    return np.asarray(here @ last[:, None])


def check(matrix: PoseMatrix, first_pose: int, rows: NDArray[np.int64], seed: int, robots: int, visits: int) -> ExactCheck:
    """Return the differences between the first-order sum and the exact composition.

    Compared on these rows of the matrix (whose first is pose `first_pose` of the study), for robots x visits draws each. No rows, no samples.
    """
    if not len(rows):
        return ExactCheck(0.0, 0.0, 0)
    row, robot, visit = (axis.ravel() for axis in np.meshgrid(rows, np.arange(robots), np.arange(visits), indexing="ij"))
    draws = draws_of(matrix, row, seed, first_pose + row, robot, visit).reshape(len(matrix.infos), len(rows), robots * visits).transpose(1, 0, 2)
    turns, linear = np.split((matrix.tool[rows] @ draws).transpose(0, 2, 1), 2, axis=-1)
    exactly = compose(matrix, rows, draws)[..., :3, 3] - matrix.at[-1, rows, None, :3, 3]
    distances = np.linalg.norm(exactly - linear, axis=-1)
    turn, length = (float(np.linalg.norm(each, axis=-1).max()) for each in (turns, linear))
    return ExactCheck(float(distances.max()), float(distances.mean()), distances.size, turn, length)
