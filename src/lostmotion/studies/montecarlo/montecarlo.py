"""Robots x visits at every pose: the study by Monte Carlo, in fixed logical blocks of poses, on threads.

A block is computed the same way whoever computes it and blocks are summed in order, so results do not depend on threads or tiling.
"""

from __future__ import annotations

import math
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import pairwise
from numbers import Integral
from typing import TYPE_CHECKING, Any, Final, Literal, Self, get_args

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.studies.budget import Tally
from lostmotion.studies.draws import Stream, robot_draws, visit_key, visit_table
from lostmotion.studies.intervals import robots_quantile, student
from lostmotion.studies.montecarlo import exact, kernel, once_kernel
from lostmotion.studies.screws import Screws, root_sum_square, screws, worst_case

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from lostmotion.arm import Arm
    from lostmotion.spatial import Floats
    from lostmotion.studies.poses import Poses

Device = Literal["cpu", "gpu"]
DEVICES: Final = get_args(Device)

BLOCK: Final = 1280
MOST_ROBOTS: Final = 1_000_000
MOST_VISITS: Final = 10_000
# A block holds AP and RP of every robot at every pose of it: fewer poses where there are many robots, so that memory stays bounded.
_MOST_PAIRS: Final = 2_000_000
# Intervals are stated at 95 %; robots are split into groups of at least eight for the intervals of pooled quantiles.
_MOST_GROUPS: Final = 32
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
class Plan:
    """What a run consists of; `groups` of robots, for the intervals of pooled quantiles."""

    arm: Arm
    poses: Poses
    robots: int
    visits: int
    seed: int
    approach: float
    groups: int
    device: Device = "cpu"
    # What was drawn for every robot, by stream: the same in all blocks, so drawn once.
    robot_draws: dict[Stream, Floats] = field(default_factory=dict)

    @classmethod
    def of(cls, arm: Arm, poses: Poses, robots: int, visits: int, seed: int, approach: float, device: Device = "cpu") -> Self:
        """Check the numbers and split the robots into groups.

        device "gpu": errors are formed by JAX on its graphics processor; LostmotionError where there is none.
        """
        for name, value, most in (("robots", robots, MOST_ROBOTS), ("visits", visits, MOST_VISITS)):
            if not isinstance(value, Integral) or not 1 <= value <= most:
                raise refuse_argument(name, value, f"a whole number from 1 to {most}", f"{name} = 30")
        if approach not in (-1, 0, 1):
            raise refuse_argument("approach", approach, "-1, 0 or 1", "approach = 0")
        check_device(device)
        groups = min(_MOST_GROUPS, robots)
        return cls(arm, poses, robots, visits, seed, approach, groups, device)


@dataclass(frozen=True)
class BlockSample:
    """What the kernel makes of one block: the table per pose, AP and RP by robot, each robot's summed mean error, and the histogram of each group."""

    per_pose: Floats
    ap_rp: Floats
    robot_sums: Floats
    group_hist: np.ndarray


@dataclass(frozen=True)
class _Block:
    first: int
    per_pose: Floats
    group_hist: np.ndarray
    ap_rp: Floats
    robot_sums: Floats
    worst: Floats
    rss: Floats
    bias: Floats
    rotation_ms: Floats
    tally: Tally
    check: exact.ExactCheck


def check_device(device: str) -> None:
    """Refuse a device that is not known (InputError), or a GPU that is not there or that JAX is not there for (LostmotionError)."""
    if device not in DEVICES:
        raise refuse_argument("device", device, "one of " + ", ".join(DEVICES), 'device = "cpu"')
    if device == "gpu":
        from lostmotion.studies.montecarlo.jax_kernel import refuse_without_gpu

        refuse_without_gpu()


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
    """How far off is the tool, for these robots returning to these poses?

    `tile` blocks of poses are handed to a thread at a time; neither it nor `threads` changes a bit of the result.
    device "gpu" forms the errors by JAX on its graphics processor: the same figures but for rounding.
    `progress` is called with what is being done, how much of it is done, and how much there is.
    Raises InputError for robots, visits, threads, tile, approach or device out of range, LostmotionError for a GPU that is not there.
    """
    if threads < 1 or tile < 1:
        raise refuse_argument("threads, tile", f"{threads}, {tile}", "at least 1 of each", "threads = 2")
    plan = Plan.of(arm, poses, robots, visits, seed, approach, device)
    out = _empty(plan)
    total: Tally | None = None
    checks = []
    for block in _blocks(plan, threads, tile):
        rows = slice(block.first, block.first + len(block.bias))
        for name in ("per_pose", "ap_rp", "worst", "rss", "bias", "rotation_ms"):
            out[name][rows] = getattr(block, name)
        replicate = block.first * poses.replicates // len(poses)
        out["robot_means"][replicate] += block.robot_sums
        out["group_hist"] += block.group_hist
        out["replicate_hist"][replicate] += block.group_hist.sum(axis=0)
        total = block.tally if total is None else total + block.tally
        checks.append(block.check)
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
        _join(checks),
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
        "group_hist": np.zeros((plan.groups, kernel.BINS), np.int64),
        "replicate_hist": np.zeros((plan.poses.replicates, kernel.BINS), np.int64),
    }


def _join(checks: list[exact.ExactCheck]) -> exact.ExactCheck:
    samples = sum(check.samples for check in checks)
    mean = sum(check.mean * check.samples for check in checks) / samples
    return exact.ExactCheck(max(check.largest for check in checks), mean, samples)


def _blocks(plan: Plan, threads: int, tile: int) -> Iterator[_Block]:
    """Compute the blocks on a few threads and hand them on in order; only a bounded number waits."""
    spans = _spans(plan)
    tiles = [spans[k : k + tile] for k in range(0, len(spans), tile)]
    if threads == 1:
        yield from (_block(plan, *span) for span in spans)
        return
    with ThreadPoolExecutor(threads) as pool:
        waiting: deque[Future[list[_Block]]] = deque()
        for spans_of_tile in tiles:
            waiting.append(pool.submit(lambda mine: [_block(plan, *span) for span in mine], spans_of_tile))
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


def _block(plan: Plan, first: int, last: int) -> _Block:
    matrix = screws(plan.arm, plan.poses.q[first:last], approach=plan.approach)
    sample = sample_block(plan, matrix, first)
    checked = np.unique(np.linspace(0, len(plan.poses) - 1, _CHECKED_POSES).astype(int))
    rows = checked[(checked >= first) & (checked < last)] - first
    spread = np.full((last - first, 2, 4), np.nan)
    sums = np.column_stack([sample.robot_sums, np.full((plan.robots, 2), np.nan)])
    if plan.visits > 1:
        spread = _over_robots(sample.ap_rp)
        sums[:, 1:] = sample.ap_rp.sum(axis=0).T
    return _Block(
        first,
        sample.per_pose,
        sample.group_hist,
        spread,
        sums,
        worst_case(matrix),
        root_sum_square(matrix),
        matrix.bias,
        _rotation_ms(matrix),
        Tally.of(matrix),
        exact.check(matrix, first, rows, plan.seed, min(plan.robots, _CHECKED_ROBOTS), min(plan.visits, _CHECKED_VISITS)),
    )


def _rotation_ms(matrix: Screws) -> Floats:
    """Give the mean square of the tool's rotation (pose,), rad^2: of the bias, and the variances of all that is drawn."""
    turn = matrix.along_poses[:3]
    drawn = np.ones(len(matrix.infos))
    drawn[matrix.columns("design")] = 0
    return np.asarray((matrix.bias[:, :3] ** 2).sum(axis=1) + drawn @ np.einsum("ctp,ctp->tp", turn, turn))


def _over_robots(values: Floats) -> Floats:
    """Sum values (pose, 2, robot) up: mean, 95 % quantile over robots, and its interval (pose, 2, 4)."""
    return np.concatenate([values.mean(axis=2)[..., None], robots_quantile(values)], axis=-1)


def sample_block(plan: Plan, matrix: Screws, first: int) -> BlockSample:
    """Run the kernel on one block of poses, the first of which is number `first` of the study."""
    poses = len(matrix.tool)
    robot = _alive(matrix, "robot")
    visit = _alive(matrix, "visit")
    both = _alive(matrix, "robot x visit")
    tables: dict[Stream, int] = {}
    for k in (*visit, *both):
        tables.setdefault(_known(matrix.infos[k].visit), len(tables))
    counts = np.zeros((plan.groups, kernel.ROW_OF_BINS), np.int64)
    out = BlockSample(
        np.zeros((poses, kernel.COLUMNS)),
        np.zeros((poses, 2, plan.robots if plan.visits > 1 else 0)),
        np.zeros(plan.robots),
        counts[:, : kernel.BINS],
    )
    _kernel(plan, moves=len(visit) + len(both) > 0)(
        first,
        np.ascontiguousarray(matrix.bias[:, 3:]),
        matrix.along_poses[3:],
        _padded(robot),
        _drawn(plan, [_known(matrix.infos[k].robot) for k in robot], pad=True),
        _padded(visit),
        *_reading(plan.seed, matrix, visit, tables),
        both,
        *_reading(plan.seed, matrix, both, tables),
        _drawn(plan, [_known(matrix.infos[k].robot) for k in both]),
        np.concatenate([visit_table(plan.seed, stream) for stream in tables] or [np.zeros(kernel.ROW)]),
        plan.robots,
        plan.visits,
        plan.groups,
        student(plan.robots - 1),
        out.per_pose,
        out.ap_rp,
        out.robot_sums,
        counts,
    )
    return out


def _kernel(plan: Plan, *, moves: bool) -> Callable[..., Any]:
    """Choose who forms the errors; `moves` tells whether anything changes from visit to visit."""
    if plan.device == "gpu":
        from lostmotion.studies.montecarlo import jax_kernel

        return jax_kernel.run_block
    return kernel.run_block if moves and plan.visits > 1 else once_kernel.run_once


def _alive(matrix: Screws, level: str) -> np.ndarray:
    """Give the terms of a level that move the tool at some pose of the block; leaving out the others changes no bit."""
    columns = matrix.columns(level)  # type: ignore[arg-type]
    return np.asarray(columns[matrix.square_sums[columns] != 0])


def _known(stream: Stream | None) -> Stream:
    if stream is None:
        raise ValueError("a term without a draw reached the kernel")
    return stream


def _drawn(plan: Plan, streams: list[Stream], *, pad: bool = False) -> Floats:
    """Give the robots' draws (tile, stream, LANES); with `pad`, filled up to a multiple of four streams with zeros."""
    out = np.zeros((-(-plan.robots // kernel.LANES), len(streams) + (-len(streams) % 4 if pad else 0), kernel.LANES))
    for row, stream in enumerate(streams):
        if stream not in plan.robot_draws:
            plan.robot_draws[stream] = robot_draws(plan.seed, [stream], plan.robots)[:, 0]
        out[:, row] = plan.robot_draws[stream]
    return out


def _padded(columns: np.ndarray) -> np.ndarray:
    """Fill up to a multiple of four terms; -1 stands for one that does nothing."""
    return np.concatenate([columns, np.full(-len(columns) % 4, -1)])


def _reading(seed: int, matrix: Screws, columns: np.ndarray, tables: dict[Stream, int]) -> tuple[np.ndarray, np.ndarray]:
    """Tell the kernel which table each visit stream reads and which key steers it, padded like the screws."""
    streams = [_known(matrix.infos[k].visit) for k in columns]
    rows = [tables[stream] for stream in streams]
    keys = [visit_key(seed, stream.name) for stream in streams]
    pad = [0] * (-len(rows) % 4)
    return np.array(rows + pad, dtype=np.int64), np.array(keys + pad, dtype=np.uint64)
