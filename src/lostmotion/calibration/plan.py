"""Which poses to measure next: those that most reduce the mean predicted variance of the tool over
the poses where the robot will work.

Sources: T. Mitchell, Technometrics 16 (1974) 203 (exchanges); A. Klimchik et al., arXiv 1211.5739
(test poses); Y. Sun, J. Hollerbach, ICRA 2008, 831 (observability indices).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.model import model_of
from lostmotion.controller_model.percentile import percentile95

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.calibration.model import RobotModel
    from lostmotion.calibration.robot import Robot
    from lostmotion.spatial import Floats

_PASSES: Final = 2
# Smallest relative decrease per pose, over five poses, for which more poses are worth measuring.
_WORTH: Final = 0.02
_AHEAD: Final = 5
# Singular values below this share of the largest are of combinations that no measurement resolves.
_RANK: Final = 1e-7
# Poses that a calibration proposes to measure next, and the candidates for them.
_NEXT_POSES: Final = 5
_NEXT: Final = 400


@dataclass(frozen=True, eq=False)
class PosePlan:
    """Poses to measure, in the order of a short tour of the joints.

    chosen  (pose,) rows of the candidates
    radius  (count + 1,) mean 95 % radius of the tool over the working poses after so many of the
            poses that were chosen first, m
    enough  number of poses after which five more reduce it by less than 2 % each; None: more
    indices observability O1 to O5 of the chosen poses
    """

    chosen: NDArray[np.int64]
    radius: Floats
    enough: int | None
    indices: tuple[float, ...]


def plan(
    candidates: RobotModel,
    working: RobotModel,
    count: int,
    covariance: Floats,
    *,
    noise: float,
) -> PosePlan:
    """Return `count` of the candidate poses, one after another, then by exchanges.

    working     model at the poses where the robot will work, with the same draws
    covariance  (stream, stream) of the estimates before the measurement
    noise       standard deviation of a measured coordinate, m
    """
    white = _white(candidates, noise)
    wanted = working.columns[:, 3:]
    values, vectors = np.linalg.eigh(_weight(wanted))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    chosen, radius = _greedy(white, wanted, root, covariance, count)
    chosen = _exchanged(white, root, covariance, chosen)
    whole = _posterior(covariance, white[chosen])
    radius[-1] = min(radius[-1], _radius(wanted, whole))
    return PosePlan(
        _tour(candidates.matrix.state.q, chosen),
        radius,
        _enough(radius),
        observability(candidates.columns[chosen, 3:]),
    )


def _white(model: RobotModel, noise: float) -> Floats:
    """Return the columns of the tool point (pose, 3, stream) in deviations of a measurement."""
    lower = np.linalg.cholesky(model.scatter[:, 3:, 3:] + noise**2 * np.eye(3))
    return np.asarray(np.linalg.solve(lower, model.columns[:, 3:]))


def _weight(columns: Floats) -> Floats:
    return np.asarray(np.einsum("pik,pil->kl", columns, columns) / len(columns))


def _greedy(
    white: Floats, wanted: Floats, root: Floats, covariance: Floats, count: int
) -> tuple[list[int], Floats]:
    """Return the poses that reduce the variance most, one after another, and the radius after each.

    The gain of a pose with rows B is tr((B P B' + 1)^-1 B P W P B').
    """
    spread = white @ covariance  # B P of each candidate
    moved = spread @ root
    chosen: list[int] = []
    radius = [_radius(wanted, covariance)]
    for _ in range(count):
        best = int(np.argmax(_gains(white, spread, moved, chosen)))
        chosen.append(best)
        inner = np.linalg.cholesky(np.eye(3) + spread[best] @ white[best].T)
        gain = np.linalg.solve(inner, spread[best]).T  # P' = P - gain gain'
        covariance = covariance - gain @ gain.T
        along = white @ gain
        spread = spread - along @ gain.T
        moved = moved - along @ (gain.T @ root)
        radius.append(_radius(wanted, covariance))
    return chosen, np.array(radius)


def _gains(white: Floats, spread: Floats, moved: Floats, taken: list[int]) -> Floats:
    inner = np.eye(3) + spread @ white.transpose(0, 2, 1)
    across = moved @ moved.transpose(0, 2, 1)
    gains = np.einsum("pii->p", np.linalg.solve(inner, across))
    gains[taken] = -np.inf
    return np.asarray(gains)


def _exchanged(white: Floats, root: Floats, covariance: Floats, chosen: list[int]) -> list[int]:
    """Return the poses after exchanges of each for the best candidate without it."""
    for _ in range(_PASSES):
        changed = False
        for k in range(len(chosen)):
            rest = chosen[:k] + chosen[k + 1 :]
            without = _posterior(covariance, white[rest])
            spread = white @ without
            best = int(np.argmax(_gains(white, spread, spread @ root, rest)))
            if best != chosen[k]:
                chosen, changed = [*chosen[:k], best, *chosen[k + 1 :]], True
        if not changed:
            break
    return chosen


def _posterior(covariance: Floats, white: Floats) -> Floats:
    """Return the covariance after measurements with whitened columns (pose, 3, stream)."""
    rows = white.reshape(-1, white.shape[2])
    spread = rows @ covariance
    inner = np.linalg.cholesky(np.eye(len(rows)) + spread @ rows.T)
    gain = np.linalg.solve(inner, spread)
    return np.asarray(covariance - gain.T @ gain)


def _radius(columns: Floats, covariance: Floats) -> float:
    spread = columns @ covariance @ columns.transpose(0, 2, 1)
    return float(percentile95(np.zeros((len(columns), 3)), spread).mean())


def _enough(radius: Floats) -> int | None:
    for n in range(1, len(radius) - _AHEAD):
        if radius[n + _AHEAD] > radius[n] * (1 - _WORTH) ** _AHEAD:
            return n
    return None


def _tour(q: Floats, chosen: list[int]) -> NDArray[np.int64]:
    """Return the poses in an order in which each is near the one before, by joint values."""
    left, out = list(chosen[1:]), [chosen[0]]
    while left:
        away = np.abs(q[left] - q[out[-1]]).max(axis=1)
        out.append(left.pop(int(np.argmin(away))))
    return np.array(out)


def observability(columns: Floats) -> tuple[float, ...]:
    """Return the indices O1 to O5 of poses with these columns (pose, 3, stream), in prior
    deviations.

    O1 is the geometric mean of the k singular values over the square root of the number of poses,
    O2 the smallest over the largest, O3 the smallest, O4 O3 O2, O5 one over the sum of inverses.
    """
    values = np.linalg.svd(columns.reshape(-1, columns.shape[2]), compute_uv=False)
    values = values[values > _RANK * values[0]]
    first = float(np.exp(np.log(values).mean()) / np.sqrt(len(columns)))
    least = float(values[-1])
    return (
        first,
        least / float(values[0]),
        least,
        least**2 / float(values[0]),
        float(1 / (1 / values).sum()),
    )


def next_poses(robot: Robot, q: Floats, seed: int) -> tuple[Floats, Floats]:
    """Return the poses (pose, joint) within the measured joint ranges that would most improve a
    calibration, and the mean 95 % radius of the tool, m, after each number of them.

    q  (pose, joint) the measured poses
    """
    low, high = q.min(axis=0), q.max(axis=0)
    every = low + np.random.default_rng(seed).random((_NEXT, q.shape[1])) * (high - low)
    best, streams = robot.climb.kept.fit, robot.climb.model.streams
    kept = np.flatnonzero(best.variances[: len(streams)])
    model = model_of(robot.arm, every, robot.calibration.added)
    model = model.keeping(model.numbers([streams[k] for k in kept]))
    covariance = robot.inflation * best.covariance[np.ix_(kept, kept)]
    found = plan(
        model, model.rows(np.arange(_NEXT // 4)), _NEXT_POSES, covariance, noise=robot.noise(best)
    )
    return every[found.chosen], found.radius
