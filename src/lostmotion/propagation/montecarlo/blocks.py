"""One block of poses: what is drawn for the robots that visit them, and what the kernel makes of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from numbers import Integral
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, Self, TypeAlias, get_args

import numpy as np

from lostmotion.error_model import draw_kernel, error_bins
from lostmotion.error_model.closing import standardised
from lostmotion.error_model.draws import Stream, robot_draws, visit_key, visit_table
from lostmotion.error_model.intervals import robots_quantile, student
from lostmotion.errors import refuse_argument
from lostmotion.propagation.montecarlo import kernel, single_visit_kernel
from lostmotion.propagation.montecarlo.memory import keep_freed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from lostmotion.error_model.closing import Closing
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.term import Form
    from lostmotion.spatial import Floats

Device = Literal["cpu", "gpu"]
DEVICES: Final = get_args(Device)

MOST_ROBOTS: Final = 1_000_000
MOST_VISITS: Final = 10_000
# Robots are split into groups for the intervals of pooled quantiles.
_MOST_GROUPS: Final = 32


# What a robot multiplies a column by: the sum of weights times what is drawn for it, or times one where the stream is None.
Factor: TypeAlias = "tuple[tuple[Stream | None, float], ...]"


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
    # What was drawn for every robot, by stream, and the tables of draws laid out for the kernel: the same in nearly all blocks.
    _robot_draws: dict[Stream, Floats] = field(default_factory=dict, init=False)
    _laid_out: dict[str, tuple[list[Any], Floats]] = field(default_factory=dict, init=False)

    @classmethod
    def of(cls, arm: Arm, poses: Poses, robots: int, visits: int, seed: int, approach: float, device: Device = "cpu") -> Self:
        """Check the numbers and split the robots into groups.

        device "gpu": errors are formed by JAX on its graphics processor; LostmotionError where there is none.
        """
        for name, value, most in (("robots", robots, MOST_ROBOTS), ("visits", visits, MOST_VISITS)):
            if not isinstance(value, Integral) or not 1 <= value <= most:
                raise refuse_argument(name, value, f"a whole number from 1 to {most}", **{name: 30})
        if approach not in (-1, 0, 1):
            raise refuse_argument("approach", approach, "-1, 0 or 1", approach=0)
        check_device(device)
        keep_freed()
        groups = min(_MOST_GROUPS, robots)
        return cls(arm, poses, robots, visits, seed, approach, groups, device)

    def of_robots(self, what: str, factors: list[Factor], *, pad: bool = False) -> Floats:
        """Return these factors for each robot (tile, factor, LANES); with `pad`, filled up to a multiple of four factors with zeros.

        Kept under the name `what` until it is asked for with other factors.
        """

        def laid_out() -> Floats:
            out = np.zeros((-(-self.robots // draw_kernel.LANES), len(factors) + (-len(factors) % 4 if pad else 0), draw_kernel.LANES))
            for row, factor in enumerate(factors):
                for stream, weight in factor:
                    out[:, row] += weight * (1.0 if stream is None else self._drawn(stream))
            return out

        return self._kept(what, factors, laid_out)

    def _drawn(self, stream: Stream) -> Floats:
        if stream not in self._robot_draws:
            self._robot_draws[stream] = robot_draws(self.seed, [stream], self.robots)[:, 0]
        return self._robot_draws[stream]

    def tables(self, streams: list[Stream | None]) -> Floats:
        """Return the tables that these streams' visits read, one after another (stream x ROW); of None all draws are one."""

        def laid_out() -> Floats:
            rows = [np.ones(draw_kernel.ROW) if stream is None else visit_table(self.seed, stream) for stream in streams]
            return np.concatenate(rows or [np.zeros(draw_kernel.ROW)])

        return self._kept("visits", streams, laid_out)

    def frictions(self, closings: list[Closing | None]) -> Floats:
        """Return the uniform of each robot that decides whether its play is closed (tile, closing, LANES); zeros for None."""

        def laid_out() -> Floats:
            out = np.zeros((-(-self.robots // draw_kernel.LANES), len(closings), draw_kernel.LANES))
            for row, closing in enumerate(closings):
                if closing is not None:
                    out[:, row] = self._drawn(closing.stream)
            return out

        return self._kept("frictions", closings, laid_out)

    def _kept(self, what: str, of: list[Any], laid_out: Callable[[], Floats]) -> Floats:
        known = self._laid_out.get(what)
        if known is None or known[0] != of:
            known = self._laid_out[what] = of, laid_out()
        return known[1]


@dataclass(frozen=True)
class BlockSample:
    """What the kernel makes of one block: the table per pose, AP and RP by robot, each robot's summed mean error, and histograms.

    hist (bin,) counts the block's samples. group_hist (group, bin) counts those of each group of robots, and where several blocks are walked
    together, of all blocks up to this one. Both hold those bins that `bins` cuts out of the histogram: there are no errors beside them.
    """

    per_pose: Floats
    ap_rp: Floats
    robot_sums: Floats
    bins: slice
    hist: np.ndarray
    group_hist: np.ndarray

    def over_robots(self) -> Floats:
        """Sum AP and RP up (pose, 2, 4): mean, 95 % quantile over robots, and its interval; NaN where there is one visit."""
        if not self.ap_rp.shape[2]:
            return np.full((len(self.per_pose), 2, 4), np.nan)
        return np.concatenate([self.ap_rp.mean(axis=2)[..., None], robots_quantile(self.ap_rp)], axis=-1)

    def over_poses(self) -> Floats:
        """Sum each robot's mean error, AP and RP (robot, 3); NaN for the latter where there is one visit."""
        out = np.column_stack([self.robot_sums, np.full((len(self.robot_sums), 2), np.nan)])
        if self.ap_rp.shape[2]:
            out[:, 1:] = self.ap_rp.sum(axis=0).T
        return out

    def whole_hist(self) -> np.ndarray:
        """Return the histogram of each group with all its bins (group, error_bins.BINS)."""
        out = np.zeros((len(self.group_hist), error_bins.BINS), np.int64)
        out[:, self.bins] = self.group_hist
        return out


def check_device(device: str) -> None:
    """Refuse a device that is not known (InputError), or a GPU that is not there or that JAX is not there for (LostmotionError)."""
    if device not in DEVICES:
        raise refuse_argument("device", device, "one of " + ", ".join(DEVICES), device="cpu")
    if device == "gpu":
        from lostmotion.propagation.montecarlo.jax_kernel import refuse_without_gpu

        refuse_without_gpu()


def sample_block(plan: Plan, matrix: PoseMatrix, first: int) -> BlockSample:
    """Run the kernel on one block of poses, the first of which is number `first` of the study."""
    return next(sample_blocks(plan, matrix, [(first, first + len(matrix.tool))]))


def sample_blocks(plan: Plan, matrix: PoseMatrix, spans: list[tuple[int, int]]) -> Iterator[BlockSample]:
    """Run the kernel on one block of poses after the other; `spans` are their numbers in the study, which the matrix holds from the first on."""
    merged = matrix.merged
    robot = [k for k in merged.columns("robot") if merged.square_sums[k] != 0 and merged.infos[k].closing is None]
    changing = [each for each in _changing(matrix) if each.screw.any()]
    visit, both = ([each for each in changing if (each.factor == ALWAYS and each.closing is None) == plain] for plain in (True, False))
    tables: dict[Stream | None, int] = {}
    for each in (*visit, *both):
        tables.setdefault(each.stream, len(tables))
    work = _kernel(plan, moves=any(each.stream is not None for each in changing))
    shift = np.concatenate([merged.along_poses[3:, robot], *(each.screw[:, None] for each in (*visit, *both))], axis=1)
    columns = np.arange(shift.shape[1])
    first_visit, first_both = len(robot), len(robot) + len(visit)
    drawn = (
        _padded(columns[:first_visit]),
        plan.of_robots("robots", [((merged.infos[k].robot, 1.0),) for k in robot], pad=True),
        _padded(columns[first_visit:first_both]),
        *_reading(plan.seed, visit, tables),
        columns[first_both:],
        *_reading(plan.seed, both, tables),
        plan.of_robots("robots x visits", [each.factor for each in both]),
        plan.frictions([each.closing for each in both]),
        plan.tables(list(tables)),
        plan.robots,
        plan.visits,
        plan.groups,
        student(plan.robots - 1),
    )
    plays = _plays(matrix, both)
    counts = np.zeros((plan.groups, error_bins.ROW_OF_BINS), np.int64)
    lowest, highest, before = error_bins.BINS, -1, np.zeros(error_bins.BINS, np.int64)
    for first, last in spans:
        here = slice(first - spans[0][0], last - spans[0][0])
        per_pose = np.zeros((last - first, kernel.COLUMNS))
        ap_rp = np.zeros((last - first, 2, plan.robots if plan.visits > 1 else 0))
        robot_sums = np.zeros(plan.robots)
        bias, moves = (np.ascontiguousarray(x) for x in (matrix.bias[here, 3:], shift[:, :, here]))
        low, high = work(first, bias, moves, plays[here], *drawn, per_pose, ap_rp, robot_sums, counts)
        lowest, highest = min(lowest, low), max(highest, high)
        bins = slice(lowest, highest + 1)
        counted = counts[:, bins].sum(axis=0)
        yield BlockSample(per_pose, ap_rp, robot_sums, bins, counted - before[bins], counts[:, bins])
        before[bins] = counted


def _kernel(plan: Plan, *, moves: bool) -> Callable[..., Any]:
    """Choose who forms the errors; `moves`: whether anything changes between visits."""
    if plan.device == "gpu":
        from lostmotion.propagation.montecarlo import jax_kernel

        return jax_kernel.run_block
    return kernel.run_block if moves and plan.visits > 1 else single_visit_kernel.run_once


ALWAYS: Final[Factor] = ((None, 1.0),)


class Changing(NamedTuple):
    """What changes with every visit, or with the plays that are closed at a pose.

    screw    (3, pose) what it does to the tool point per unit drawn, m
    stream   what is drawn per visit
    factor   what each robot multiplies it by
    closing  what decides whether its play is closed
    whole    whether the screw is there in some robots and not in others; else it is multiplied by `closing.standardised`
    """

    screw: Floats
    stream: Stream | None
    factor: Factor
    closing: Closing | None
    whole: bool


def _changing(matrix: PoseMatrix) -> Iterator[Changing]:
    """Yield what changes with every visit, or with the plays that are closed at a pose; columns of one form and the same draws together.

    They differ only in size and in the robot's draw, such as a play and its scatter, so that one column with a robot's sum of both stands for all.
    The mean over robots of what a load closes in some of them, and what that changes, are one column too, unless they are scaled apart.
    """
    found: dict[tuple[Stream | None, int, Form], dict[Closing | None, list[int]]] = {}
    for k, info in enumerate(matrix.infos):
        if (info.visit is not None or info.closing is not None) and matrix.scale[k] != 0:
            found.setdefault((info.visit, info.of.place, info.of.term.form), {}).setdefault(info.closing, []).append(k)
    shift = matrix.along_poses[3:]
    for (stream, _, _), members in found.items():
        factors = {
            closing: tuple((matrix.infos[k].robot, float(matrix.scale[k] / matrix.scale[first])) for k in (first, *others))
            for closing, (first, *others) in members.items()
        }
        closing = next(reversed(members))
        if closing is not None and len(members) > 1:
            (mean, *_), (changed, *_) = members.values()
            if matrix.scale[mean] == matrix.scale[changed] and factors[None] == factors[closing]:
                there = standardised(0.0 if closing.above else 1.0, matrix.closed[closing.row])
                yield Changing(shift[:, mean] + there * shift[:, changed], stream, factors[closing], closing, whole=True)
                continue
        for each, (first, *_) in members.items():
            yield Changing(shift[:, first], stream, factors[each], each, whole=False)


def _plays(matrix: PoseMatrix, both: list[Changing]) -> Floats:
    """Return for each column (pose, column, 3) the share of robots whose play is closed, and by what those with it closed and open are multiplied."""
    out = np.ones((len(both), 3, len(matrix.tool)))
    for (closed, shut, opened), each in zip(out, both, strict=True):
        if each.closing is not None:
            closed[:] = matrix.closed[each.closing.row]
            shut[:] = each.closing.above if each.whole else standardised(0.0, closed)
            opened[:] = not each.closing.above if each.whole else standardised(1.0, closed)
    return np.ascontiguousarray(out.transpose(2, 0, 1))


def _padded(columns: np.ndarray) -> np.ndarray:
    """Fill up to a multiple of four terms; -1 stands for one that does nothing."""
    return np.concatenate([columns, np.full(-len(columns) % 4, -1)])


def _reading(seed: int, columns: list[Changing], tables: dict[Stream | None, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the table of each visit stream and the key of its position, padded like the screws."""
    rows = [tables[each.stream] for each in columns]
    keys = [np.uint64(0) if each.stream is None else visit_key(seed, each.stream.name) for each in columns]
    pad = [0] * (-len(rows) % 4)
    return np.array(rows + pad, dtype=np.int64), np.array(keys + pad, dtype=np.uint64)
