"""One block of poses: the draws of the robots that visit them, and the sample that the kernel
computes.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from numbers import Integral
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, Self, TypeAlias, get_args

import numpy as np

from lostmotion.error_model import draw_kernel, error_bins
from lostmotion.error_model.calibrated import correlated_draws
from lostmotion.error_model.closing import standardised
from lostmotion.error_model.draws import Stream, robot_draws, visit_key, visit_table
from lostmotion.error_model.intervals import student
from lostmotion.error_model.robot_intervals import robots_quantile
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


# Factor of a robot on a column: the sum over (stream, weight) of weight times the robot's draw; for
# the stream None the draw is one.
Factor: TypeAlias = "tuple[tuple[Stream | None, float], ...]"


@dataclass(frozen=True)
class BlockPlan:
    """The arguments of a run, as for `montecarlo.run`; `groups` is the number of groups of robots
    for the intervals of pooled quantiles.
    """

    arm: Arm
    poses: Poses
    robots: int
    visits: int
    seed: int
    approach: float
    groups: int
    device: Device = "cpu"
    # Draws of all robots by stream, and tables of draws in the layout of the kernel: nearly all
    # blocks use the same ones.
    _robot_draws: dict[Stream, Floats] = field(default_factory=dict, init=False)
    _laid_out: dict[str, tuple[list[Any], Floats]] = field(default_factory=dict, init=False)

    @classmethod
    def of(
        cls,
        arm: Arm,
        poses: Poses,
        robots: int,
        visits: int,
        seed: int,
        approach: float,
        device: Device = "cpu",
    ) -> Self:
        """Return the plan of a run.

        Raises InputError for robots, visits, approach or device out of range, LostmotionError for a
        GPU that is not available.
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
        """Return these factors of each robot (tile, factor, LANES); with `pad`, zeros fill it up to
        a multiple of four factors.

        The result is cached under the name `what` until it is called with other factors.
        """

        def laid_out() -> Floats:
            out = np.zeros(
                (
                    -(-self.robots // draw_kernel.LANES),
                    len(factors) + (-len(factors) % 4 if pad else 0),
                    draw_kernel.LANES,
                )
            )
            for row, factor in enumerate(factors):
                for stream, weight in factor:
                    out[:, row] += weight * (1.0 if stream is None else self._drawn(stream))
            return out

        return self._cached(what, factors, laid_out)

    def _drawn(self, stream: Stream) -> Floats:
        if stream not in self._robot_draws:
            correlations = self.arm.correlations
            if correlations is not None and stream.name in correlations.row:
                drawn = correlated_draws(self.seed, correlations, self.robots)
                self._robot_draws.update(
                    {replace(stream, name=name): draws for name, draws in drawn.items()}
                )
            else:
                self._robot_draws[stream] = robot_draws(self.seed, [stream], self.robots)[:, 0]
        return self._robot_draws[stream]

    def tables(self, streams: list[Stream | None]) -> Floats:
        """Return the tables of visit draws of these streams, one after another (stream x ROW,); for
        None all draws are one.
        """

        def laid_out() -> Floats:
            rows = [
                np.ones(draw_kernel.ROW) if stream is None else visit_table(self.seed, stream)
                for stream in streams
            ]
            return np.concatenate(rows or [np.zeros(draw_kernel.ROW)])

        return self._cached("visits", streams, laid_out)

    def frictions(self, closings: list[Closing | None]) -> Floats:
        """Return the uniform of each robot that decides whether its play is closed (tile, closing,
        LANES); zeros for None.
        """

        def laid_out() -> Floats:
            out = np.zeros((-(-self.robots // draw_kernel.LANES), len(closings), draw_kernel.LANES))
            for row, closing in enumerate(closings):
                if closing is not None:
                    out[:, row] = self._drawn(closing.stream)
            return out

        return self._cached("frictions", closings, laid_out)

    def _cached(self, what: str, of: list[Any], laid_out: Callable[[], Floats]) -> Floats:
        known = self._laid_out.get(what)
        if known is None or known[0] != of:
            known = self._laid_out[what] = of, laid_out()
        return known[1]


@dataclass(frozen=True)
class BlockSample:
    """The sample of one block, reduced by the kernel; lengths in m.

    per_pose    (pose, kernel.COLUMNS)
    ap_rp       (pose, 2, robot) AP and RP; no robots where there is one visit
    robot_sums  (robot,) sum over poses of each robot's mean error
    bins        range of the histogram's bins that are in `hist` and `group_hist`; all other bins
                are empty
    hist        (bin,) counts of the samples of this block
    group_hist  (group, bin) counts by group of robots, summed over all blocks of the batch up to
                this one
    """

    per_pose: Floats
    ap_rp: Floats
    robot_sums: Floats
    bins: slice
    hist: np.ndarray
    group_hist: np.ndarray

    def over_robots(self) -> Floats:
        """Return the mean of AP and RP over robots, their 95th percentile and its interval (pose,
        2, 4), m; NaN where there is one visit.
        """
        if not self.ap_rp.shape[2]:
            return np.full((len(self.per_pose), 2, 4), np.nan)
        return np.concatenate(
            [self.ap_rp.mean(axis=2)[..., None], robots_quantile(self.ap_rp)], axis=-1
        )

    def over_poses(self) -> Floats:
        """Return the sums over poses of each robot's mean error, AP and RP (robot, 3), m; AP and RP
        are NaN where there is one visit.
        """
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
    """Raise InputError for an unknown device, and LostmotionError for "gpu" without a GPU or
    without JAX.
    """
    if device not in DEVICES:
        raise refuse_argument("device", device, "one of " + ", ".join(DEVICES), device="cpu")
    if device == "gpu":
        from lostmotion.propagation.montecarlo.jax_kernel import refuse_without_gpu

        refuse_without_gpu()


def sample_block(plan: BlockPlan, matrix: PoseMatrix, first: int) -> BlockSample:
    """Return the sample of one block of poses; the first pose of the matrix is number `first` of
    the study.
    """
    return next(sample_blocks(plan, matrix, [(first, first + len(matrix.tool))]))


def sample_blocks(
    plan: BlockPlan, matrix: PoseMatrix, spans: list[tuple[int, int]]
) -> Iterator[BlockSample]:
    """Yield the sample of each block of poses; `spans` are first and last (exclusive) poses in the
    study, and the matrix begins at the first one.
    """
    summed = matrix.summed
    robot = [
        k
        for k in summed.columns("robot")
        if summed.infos[k].closing is None and summed.along_poses[3:, k].any()
    ]
    changing = [each for each in _changing(matrix) if each.screw.any()]
    visit, both = (
        [each for each in changing if (each.factor == ALWAYS and each.closing is None) == plain]
        for plain in (True, False)
    )
    tables: dict[Stream | None, int] = {}
    for each in (*visit, *both):
        tables.setdefault(each.stream, len(tables))
    work = _kernel(plan, moves=any(each.stream is not None for each in changing))
    shift = np.concatenate(
        [summed.along_poses[3:, robot], *(each.screw[:, None] for each in (*visit, *both))], axis=1
    )
    columns = np.arange(shift.shape[1])
    first_visit, first_both = len(robot), len(robot) + len(visit)
    drawn = (
        _padded(columns[:first_visit]),
        plan.of_robots("robots", [((summed.infos[k].robot, 1.0),) for k in robot], pad=True),
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
        low, high = work(
            first, bias, moves, plays[here], *drawn, per_pose, ap_rp, robot_sums, counts
        )
        lowest, highest = min(lowest, low), max(highest, high)
        bins = slice(lowest, highest + 1)
        counted = counts[:, bins].sum(axis=0)
        yield BlockSample(
            per_pose, ap_rp, robot_sums, bins, counted - before[bins], counts[:, bins]
        )
        before[bins] = counted


def _kernel(plan: BlockPlan, *, moves: bool) -> Callable[..., Any]:
    """Return the kernel for this device and number of visits; `moves`: whether any error changes
    between visits.
    """
    if plan.device == "gpu":
        from lostmotion.propagation.montecarlo import jax_kernel

        return jax_kernel.run_block
    return kernel.run_block if moves and plan.visits > 1 else single_visit_kernel.run_once


ALWAYS: Final[Factor] = ((None, 1.0),)


class Changing(NamedTuple):
    """An error that changes with every visit, or with the plays that are closed at a pose.

    screw    (3, pose) displacement of the tool point per unit draw, m
    stream   draw per visit; None: one
    factor   factor of each robot
    closing  decides whether its play is closed; None: it does not depend on a play
    whole    True where some robots have the screw and others do not; False where it is multiplied
             by `closing.standardised`
    """

    screw: Floats
    stream: Stream | None
    factor: Factor
    closing: Closing | None
    whole: bool


def _changing(matrix: PoseMatrix) -> Iterator[Changing]:
    """Yield the errors that change with every visit or with the closed plays; columns of one form
    and the same visit draw are one error.

    Such columns, for example a play and its scatter, differ only in size and in the robot's draw,
    so their sum is one column with a factor per robot. The two columns of a play that a load closes
    in some robots (mean and deviation) are one error too, unless their scales differ.
    """
    found: dict[tuple[Stream | None, int, Form], dict[Closing | None, list[int]]] = {}
    for k, info in enumerate(matrix.infos):
        if (info.visit is not None or info.closing is not None) and matrix.scale[k] != 0:
            found.setdefault((info.visit, info.of.place, info.of.term.form), {}).setdefault(
                info.closing, []
            ).append(k)
    shift = matrix.along_poses[3:]
    for (stream, _, _), members in found.items():
        factors = {
            closing: tuple(
                (matrix.infos[k].robot, float(matrix.scale[k] / matrix.scale[first]))
                for k in (first, *others)
            )
            for closing, (first, *others) in members.items()
        }
        closing = next(reversed(members))
        if closing is not None and len(members) > 1:
            (mean, *_), (changed, *_) = members.values()
            if matrix.scale[mean] == matrix.scale[changed] and factors[None] == factors[closing]:
                draw = standardised(0.0 if closing.above else 1.0, matrix.closed[closing.row])
                yield Changing(
                    shift[:, mean] + draw * shift[:, changed],
                    stream,
                    factors[closing],
                    closing,
                    whole=True,
                )
                continue
        for each, (first, *_) in members.items():
            yield Changing(shift[:, first], stream, factors[each], each, whole=False)


def _plays(matrix: PoseMatrix, both: list[Changing]) -> Floats:
    """Return (pose, column, 3): the share of robots whose play is closed, the factor of a closed
    play, and the factor of an open play.
    """
    out = np.ones((len(both), 3, len(matrix.tool)))
    for (closed, if_closed, if_open), each in zip(out, both, strict=True):
        if each.closing is not None:
            closed[:] = matrix.closed[each.closing.row]
            if_closed[:] = each.closing.above if each.whole else standardised(0.0, closed)
            if_open[:] = not each.closing.above if each.whole else standardised(1.0, closed)
    return np.ascontiguousarray(out.transpose(2, 0, 1))


def _padded(columns: np.ndarray) -> np.ndarray:
    """Return the columns, filled up to a multiple of four with -1, which stands for a term without
    effect.
    """
    return np.concatenate([columns, np.full(-len(columns) % 4, -1)])


def _reading(
    seed: int, columns: list[Changing], tables: dict[Stream | None, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the number of the table of each visit stream and the key of its positions, padded with
    zeros to a multiple of four.
    """
    rows = [tables[each.stream] for each in columns]
    keys = [
        np.uint64(0) if each.stream is None else visit_key(seed, each.stream.name)
        for each in columns
    ]
    pad = [0] * (-len(rows) % 4)
    return np.array(rows + pad, dtype=np.int64), np.array(keys + pad, dtype=np.uint64)
