"""Robots x visits at every pose: the study by Monte Carlo, in fixed logical blocks of poses, on threads.

A block is computed the same way whoever computes it and blocks are summed in order, so results do not depend on threads or tiling.
"""

from __future__ import annotations

import math
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model import error_bins
from lostmotion.error_model.bounds import root_sum_square, worst_case
from lostmotion.error_model.budget import Tally
from lostmotion.error_model.pose_matrix import PoseMatrix, screws
from lostmotion.errors import refuse_argument
from lostmotion.propagation import exact
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.blocks import Device, Plan, sample_blocks

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

BLOCK: Final = 1280
# A block holds AP and RP of every robot at every pose of it: fewer poses where there are many robots, so that memory stays bounded.
_MOST_PAIRS: Final = 2_000_000
# Blocks of so few samples in all are walked together, by one thread: NumPy's calls for each one's frames and terms take longer than its samples.
_FEW_SAMPLES: Final = 1_000_000
# The exact check looks at this many poses, evenly spread over the study.
_CHECKED_POSES: Final = 12
_CHECKED_ROBOTS: Final = 16
_CHECKED_VISITS: Final = 4


@dataclass(frozen=True)
class Sampled:
    """What the kernel and the pose matrix say of every pose, and pooled counts; all lengths in m.

    per_pose      (pose, kernel.COLUMNS)
    accuracy      (pose, 4) AP over robots: mean, 95 % of robots below, and the interval of the latter; NaN where visits < 2
    repeatability (pose, 4) RP likewise
    worst, rss    (pose,) bounds
    bias          (pose, 6) what every robot does at every visit
    rotation_ms   (pose,) mean square of the tool's rotation, rad^2
    robot_means   (replicate, robot, 3) mean error, AP and RP of each robot over each independent set of poses
    group_hist    (group, bin), replicate_hist (replicate, bin): counts of samples by error
    """

    robots: int
    visits: int
    per_pose: Floats
    accuracy: Floats
    repeatability: Floats
    worst: Floats
    rss: Floats
    bias: Floats
    rotation_ms: Floats
    robot_means: Floats
    group_hist: np.ndarray
    replicate_hist: np.ndarray
    tally: Tally
    exact: exact.ExactCheck


@dataclass(frozen=True)
class _Block:
    """What is kept of one block: as in BlockSample, but AP and RP over all robots, and sums of mean error, AP and RP for each."""

    first: int
    last: int
    per_pose: Floats
    bins: slice
    hist: np.ndarray
    spread: Floats
    sums: Floats


@dataclass(frozen=True)
class _Walk:
    """What is known of a few blocks whose poses were walked together."""

    blocks: list[_Block]
    bins: slice
    group_hist: np.ndarray
    worst: Floats
    rss: Floats
    bias: Floats
    rotation_ms: Floats
    tally: Tally
    check: exact.ExactCheck


def run(  # noqa: PLR0913 - a study is these numbers
    arm: Arm,
    poses: Poses,
    robots: int,
    visits: int,
    seed: int,
    *,
    approach: float = 0.0,
    threads: int = 1,
    tile: int = 1,
    device: Device = "cpu",
    progress: Callable[[str, int, int], None] | None = None,
) -> Sampled:
    """Return the errors of these robots at these poses.

    `tile` walks over one or a few blocks of poses are handed to a thread at a time; neither it nor `threads` changes a bit of the result.
    device "gpu" forms the errors by JAX on its graphics processor: the same figures but for rounding.
    `progress` is called with what is being done, how much of it is done, and how much there is.
    Raises InputError for robots, visits, threads, tile, approach or device out of range, LostmotionError for a GPU that is not there.
    """
    if threads < 1 or tile < 1:
        raise refuse_argument("threads, tile", f"{threads}, {tile}", "at least 1 of each", threads=2)
    plan = Plan.of(arm, poses, robots, visits, seed, approach, device)
    out = _empty(plan)
    total: Tally | None = None
    checks = []
    for walk in _walks(plan, threads, tile):
        rows = slice(walk.blocks[0].first, walk.blocks[-1].last)
        for name in ("worst", "rss", "bias", "rotation_ms"):
            out[name][rows] = getattr(walk, name)
        for block in walk.blocks:
            out["per_pose"][block.first : block.last] = block.per_pose
            out["ap_rp"][block.first : block.last] = block.spread
            replicate = block.first * poses.replicates // len(poses)
            out["robot_means"][replicate] += block.sums
            out["replicate_hist"][replicate, block.bins] += block.hist
        out["group_hist"][:, walk.bins] += walk.group_hist
        total = walk.tally if total is None else total + walk.tally
        checks.append(walk.check)
        if progress is not None:
            progress("visiting poses", rows.stop, len(poses))
    if total is None:
        raise ValueError("no block of poses came back")
    return Sampled(
        robots,
        visits,
        out["per_pose"],
        out["ap_rp"][:, 0],
        out["ap_rp"][:, 1],
        out["worst"],
        out["rss"],
        out["bias"],
        out["rotation_ms"],
        out["robot_means"] * poses.replicates / len(poses),
        out["group_hist"],
        out["replicate_hist"],
        total,
        exact.join(checks),
    )


def _empty(plan: Plan) -> dict[str, np.ndarray]:
    poses = len(plan.poses)
    return {
        "per_pose": np.empty((poses, kernel.COLUMNS)),
        "ap_rp": np.empty((poses, 2, 4)),
        "worst": np.empty(poses),
        "rss": np.empty(poses),
        "bias": np.empty((poses, 6)),
        "rotation_ms": np.empty(poses),
        "robot_means": np.zeros((plan.poses.replicates, plan.robots, 3)),
        "group_hist": np.zeros((plan.groups, error_bins.BINS), np.int64),
        "replicate_hist": np.zeros((plan.poses.replicates, error_bins.BINS), np.int64),
    }


def _walks(plan: Plan, threads: int, tile: int) -> Iterator[_Walk]:
    """Compute the blocks on a few threads and hand them on in order; only a bounded number waits."""
    walks = _together(plan, _spans(plan))
    if threads == 1:
        yield from (_walk(plan, spans) for spans in walks)
        return
    with ThreadPoolExecutor(threads) as pool:
        waiting: deque[Future[list[_Walk]]] = deque()
        for of_tile in (walks[k : k + tile] for k in range(0, len(walks), tile)):
            waiting.append(pool.submit(lambda mine: [_walk(plan, spans) for spans in mine], of_tile))
            if len(waiting) > 2 * threads:
                yield from waiting.popleft().result()
        while waiting:
            yield from waiting.popleft().result()


def _spans(plan: Plan) -> list[tuple[int, int]]:
    """Cut the poses into blocks, none of which reaches over two replicates."""
    replicates = plan.poses.replicates
    each = len(plan.poses) // replicates
    # Where there is one visit no AP and RP are kept, and longer blocks spare laying out the robots' draws.
    pairs = _MOST_PAIRS if plan.visits > 1 else 10 * _MOST_PAIRS
    parts = math.ceil(each / max(min(BLOCK, pairs // plan.robots), 1))
    ends = [each * k // parts for k in range(parts + 1)]
    return [(k * each + a, k * each + b) for k in range(replicates) for a, b in pairwise(ends)]


def _together(plan: Plan, spans: list[tuple[int, int]]) -> list[list[tuple[int, int]]]:
    """Put small neighbouring blocks together."""
    most = max(min(BLOCK, _FEW_SAMPLES // (plan.robots * plan.visits)), 1)
    out: list[list[tuple[int, int]]] = []
    for span in spans:
        if out and span[1] - out[-1][0][0] <= most:
            out[-1].append(span)
        else:
            out.append([span])
    return out


def _walk(plan: Plan, spans: list[tuple[int, int]]) -> _Walk:
    first, last = spans[0][0], spans[-1][1]
    matrix = screws(plan.arm, plan.poses.q[first:last], approach=plan.approach)
    checked = np.unique(np.linspace(0, len(plan.poses) - 1, _CHECKED_POSES).astype(int))
    rows = checked[(checked >= first) & (checked < last)] - first
    blocks = []
    for span, sample in zip(spans, sample_blocks(plan, matrix, spans), strict=True):
        blocks.append(_Block(*span, sample.per_pose, sample.bins, sample.hist, sample.over_robots(), sample.over_poses()))
    return _Walk(
        blocks,
        sample.bins,
        sample.group_hist,
        worst_case(matrix),
        root_sum_square(matrix),
        matrix.bias,
        _rotation_ms(matrix),
        Tally.of(matrix),
        exact.check(matrix, first, rows, plan.seed, min(plan.robots, _CHECKED_ROBOTS), min(plan.visits, _CHECKED_VISITS)),
    )


def _rotation_ms(matrix: PoseMatrix) -> Floats:
    """Return the mean square of the tool's rotation (pose,), rad^2: of the bias, and the variances of all that is drawn."""
    turn = matrix.merged.along_poses[:3]
    return np.asarray(sum(turn[c, k] ** 2 for k in range(turn.shape[1]) for c in range(3)))
