"""The study by Monte Carlo: robots x visits at every pose, in fixed blocks of poses, on threads.

The result of a block does not depend on the thread that computes it, and blocks are summed in
order, so results do not depend on threads or tiling.
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
from lostmotion.error_model.bounds import bounds
from lostmotion.error_model.budget import Tally
from lostmotion.error_model.pose_matrix import PoseMatrix, pose_matrix
from lostmotion.error_model.pose_sets import together
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.state import BLOCK as MATRIX_BLOCK
from lostmotion.propagation import exact
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.blocks import BlockPlan, Device, sample_blocks

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

BLOCK: Final = 1280
# A block stores AP and RP of every robot at each of its poses. With many robots it has fewer poses,
# so that memory stays bounded.
_MOST_PAIRS: Final = 2_000_000
# Small blocks share one pose matrix, of as many poses as other figures ask for at a time, which so
# find it kept, up to this number of samples: each matrix is the work of one thread.
_FEW_SAMPLES: Final = 16_000_000


@dataclass(frozen=True)
class Sampled:
    """Figures of every pose and pooled counts of a run; all lengths in m.

    per_pose      (pose, kernel.COLUMNS) mean, mean square, largest error and quantiles; columns as
                  in `kernel`
    accuracy      (pose, 4) AP over robots: mean, 95th percentile, and the interval of the latter;
                  NaN where visits < 2
    repeatability (pose, 4) RP likewise
    worst, rss    (pose,) worst case and root-sum-square bound
    bias          (pose, 6) mean error, the same in every robot and visit, rad and m
    rotation_ms   (pose,) mean square of the tool's rotation, rad^2
    robot_means   (replicate, robot, 3) mean error, AP and RP of each robot over each independent
                  set of poses
    group_hist    (group, bin) counts of samples by group of robots; bins as `error_bins`
    replicate_hist (replicate, bin) counts of samples by independent set of poses
    tally         error budget over all poses
    exact         comparison with exact composition
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

    def of_poses(self, column: int) -> Floats:
        """Return the mean over robots at each pose (pose,), m, of the figure in this column of
        `robot_means`.
        """
        return (self.per_pose[:, kernel.MEAN], self.accuracy[:, 0], self.repeatability[:, 0])[
            column
        ]


@dataclass(frozen=True)
class _Block:
    """Reduced sample of one block: `spread` (pose, 2, 4) as `BlockSample.over_robots`, `sums`
    (robot, 3) as `BlockSample.over_poses`.
    """

    first: int
    last: int
    per_pose: Floats
    bins: slice
    hist: np.ndarray
    spread: Floats
    sums: Floats


@dataclass(frozen=True)
class _Batch:
    """Results of a few blocks that share one pose matrix; arrays of all their poses as in
    `Sampled`.
    """

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
    compared: int = exact.POSES,
    progress: Callable[[str, int, int], None] | None = None,
) -> Sampled:
    """Return the errors of these robots at these poses.

    robots, visits  1 to 1 000 000 robots, and 1 to 10 000 visits of each robot to each pose
    seed            of all draws
    approach        sign of the joints' last motion, -1 or 1; 0: drawn at every visit
    threads, tile   number of threads, and of batches of blocks per task of a thread; neither
                    changes a bit of the result
    device          "gpu" computes the errors with JAX on its graphics processor: the same figures
                    except for rounding
    compared        number of poses at which first order is compared with exact composition; 0 where
                    that is not asked for
    progress        called with the name of the step, the number of poses done, and the number of
                    all poses

    Raises InputError for robots, visits, threads, tile, approach or device out of range,
    LostmotionError for a GPU that is not available.
    """
    if threads < 1 or tile < 1:
        raise refuse_argument(
            "threads, tile", f"{threads}, {tile}", "at least 1 of each", threads=2
        )
    plan = BlockPlan.of(arm, poses, robots, visits, seed, approach, device)
    out = _empty(plan)
    total: Tally | None = None
    checks = []
    for batch in _batches(plan, threads, tile, compared):
        rows = slice(batch.blocks[0].first, batch.blocks[-1].last)
        for name in ("worst", "rss", "bias", "rotation_ms"):
            out[name][rows] = getattr(batch, name)
        for block in batch.blocks:
            out["per_pose"][block.first : block.last] = block.per_pose
            out["ap_rp"][block.first : block.last] = block.spread
            replicate = block.first * poses.replicates // len(poses)
            out["robot_means"][replicate] += block.sums
            out["replicate_hist"][replicate, block.bins] += block.hist
        out["group_hist"][:, batch.bins] += batch.group_hist
        total = batch.tally if total is None else total + batch.tally
        checks.append(batch.check)
        if progress is not None:
            progress("visiting poses", rows.stop, len(poses))
    if total is None:
        raise ValueError("no poses: a run needs at least one block of poses")
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


def _empty(plan: BlockPlan) -> dict[str, np.ndarray]:
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


def _batches(plan: BlockPlan, threads: int, tile: int, compared: int) -> Iterator[_Batch]:
    """Yield the batches in order, computed on these threads; only a bounded number is in memory."""
    most = max(min(MATRIX_BLOCK, _FEW_SAMPLES // (plan.robots * plan.visits)), 1)
    batches = together(_spans(plan), most)
    if threads == 1:
        yield from (_batch(plan, spans, compared) for spans in batches)
        return
    pool = ThreadPoolExecutor(threads)
    waiting: deque[Future[list[_Batch]]] = deque()
    try:
        for of_tile in (batches[k : k + tile] for k in range(0, len(batches), tile)):
            waiting.append(
                pool.submit(lambda some: [_batch(plan, spans, compared) for spans in some], of_tile)
            )
            if len(waiting) > 2 * threads:
                yield from waiting.popleft().result()
        while waiting:
            yield from waiting.popleft().result()
    finally:
        # a run that is stopped waits for what is being computed, and begins nothing more
        pool.shutdown(cancel_futures=True)


def _spans(plan: BlockPlan) -> list[tuple[int, int]]:
    """Return the first and last pose (exclusive) of every block; all poses of a block are of one
    replicate.
    """
    replicates = plan.poses.replicates
    each = len(plan.poses) // replicates
    # With one visit no AP and RP are stored, and longer blocks save time for the layout of the
    # robots' draws.
    pairs = _MOST_PAIRS if plan.visits > 1 else 10 * _MOST_PAIRS
    parts = math.ceil(each / max(min(BLOCK, pairs // plan.robots), 1))
    ends = [each * k // parts for k in range(parts + 1)]
    return [(k * each + a, k * each + b) for k in range(replicates) for a, b in pairwise(ends)]


def _batch(plan: BlockPlan, spans: list[tuple[int, int]], compared: int) -> _Batch:
    first, last = spans[0][0], spans[-1][1]
    matrix = pose_matrix(plan.arm, plan.poses.q[first:last], approach=plan.approach)
    checked = np.unique(np.linspace(0, len(plan.poses) - 1, compared).astype(int))
    rows = checked[(checked >= first) & (checked < last)] - first
    blocks = []
    for span, sample in zip(spans, sample_blocks(plan, matrix, spans), strict=True):
        blocks.append(
            _Block(
                *span,
                sample.per_pose,
                sample.bins,
                sample.hist,
                sample.over_robots(),
                sample.over_poses(),
            )
        )
    return _Batch(
        blocks,
        sample.bins,
        sample.group_hist,
        *bounds(matrix),
        matrix.bias,
        _rotation_ms(matrix),
        Tally.of(matrix),
        exact.check(
            matrix,
            first,
            rows,
            plan.seed,
            min(plan.robots, exact.ROBOTS),
            min(plan.visits, exact.VISITS),
        ),
    )


def _rotation_ms(matrix: PoseMatrix) -> Floats:
    """Return the mean square of the tool's rotation (pose,), rad^2: the square of the bias plus the
    variances of all draws.
    """
    turn = matrix.merged.along_poses[:3]
    return np.asarray(sum(turn[c, k] ** 2 for k in range(turn.shape[1]) for c in range(3)))
