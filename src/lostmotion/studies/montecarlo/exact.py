"""How much does the first-order sum leave out? The same errors composed exactly, as a product of exponentials."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.arm import steps_of
from lostmotion.spatial import exp
from lostmotion.studies.draws import Stream, robot_draws, visit_draws

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.spatial import Floats
    from lostmotion.studies.screws import Screws


@dataclass(frozen=True, slots=True)
class ExactCheck:
    """First order against exact composition on a sample: largest and mean distance between the two (m), and how many were compared."""

    largest: float
    mean: float
    samples: int


def draws_of(matrix: Screws, seed: int, pose: int, robots: NDArray[np.int64], visits: NDArray[np.int64]) -> Floats:
    """What multiplies each term at these returns to pose number `pose` of the study? (term, sample); 1 for design terms."""
    out = np.ones((len(matrix.infos), len(robots)))
    built = int(robots.max()) + 1
    visiting = [(k, info.visit) for k, info in enumerate(matrix.infos) if info.visit is not None]
    out[[k for k, _ in visiting]] = visit_draws(seed, [stream for _, stream in visiting], pose, robots, visits)
    for k, info in enumerate(matrix.infos):
        if info.robot is not None:
            out[k] *= _first_robots(seed, info.robot, built)[robots]
    return out


@functools.lru_cache(maxsize=1024)
def _first_robots(seed: int, stream: Stream, count: int) -> Floats:
    return np.asarray(robot_draws(seed, [stream], count)[:, 0, :].ravel())


def compose(matrix: Screws, row: int, draws: Floats) -> Floats:
    """Where does the tool really go at the pose in this row? Poses (sample, 4, 4) for draws (term, sample).

    Every place turns and shifts by the exponential of the sum of its own terms; the chain is multiplied out. Exact in the
    errors' geometry at any size.
    """
    places = np.unique(matrix.place)
    # From each place that moves to the next, and at last to the tool.
    *steps, last = steps_of(matrix.at[[*places, -1], row : row + 1])[:, 0]
    twists = np.empty((len(places), draws.shape[1], 6))
    for twist, place in zip(twists, places, strict=True):
        own = matrix.place == place
        twist[:] = (matrix.local[row][:, own] @ draws[own]).T
    here = np.broadcast_to(np.eye(4), (draws.shape[1], 4, 4))
    for step, moved in zip(steps, exp(twists), strict=True):
        here = here @ (step @ moved)
    return np.asarray(here @ last)


def check(matrix: Screws, first_pose: int, rows: NDArray[np.int64], seed: int, robots: int, visits: int) -> ExactCheck:
    """How far apart are the first-order sum and the exact composition?

    Compared on these rows of the matrix (whose first is pose `first_pose` of the study), for robots x visits draws each. No rows, no samples.
    """
    robot, visit = (axis.ravel() for axis in np.meshgrid(np.arange(robots), np.arange(visits), indexing="ij"))
    apart = []
    for row in rows:
        draws = draws_of(matrix, seed, first_pose + int(row), robot, visit)
        linear = (matrix.tool[row, 3:] @ draws).T
        exactly = compose(matrix, int(row), draws)[:, :3, 3] - matrix.at[-1, row, :3, 3]
        apart.append(np.linalg.norm(exactly - linear, axis=1))
    if not apart:
        return ExactCheck(0.0, 0.0, 0)
    distances = np.concatenate(apart)
    return ExactCheck(float(distances.max()), float(distances.mean()), len(distances))
