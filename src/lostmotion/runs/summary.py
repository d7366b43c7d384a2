"""What a finished run says of each design: merged from its blocks in their order, so that the bits
do not depend on who computed them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.error_model.arrival import rp_key
from lostmotion.error_model.budget import Cost, Tally, costs
from lostmotion.error_model.error_bins import bin_edges
from lostmotion.error_model.few_poses import Squares
from lostmotion.error_model.intervals import Estimate, quantile_drop
from lostmotion.error_model.overload import Overload, overloads
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import limit_shares
from lostmotion.mechanism.standing import cannot_hold, falls_at, refuse_falling
from lostmotion.propagation import exact
from lostmotion.propagation.error_samples import NOT_CHECKED, Drawn, VisitFigures
from lostmotion.propagation.figures import HEADLINE, estimates, figures_of
from lostmotion.runs.blocks import COLUMNS, OF_ROBOTS, BlockRecord, design_of, poses_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from lostmotion.error_model.provenance import LimitShare, States
    from lostmotion.propagation.figures import Figure
    from lostmotion.runs.job import Order
    from lostmotion.runs.store import Store
    from lostmotion.spatial import Floats

MOST_WORST: Final = 10
_LEVEL: Final = 0.95
_CURVE: Final = 200
_LIMIT_POSES: Final = 64
_LARGEST, _ROBOT, _VISIT = (
    COLUMNS.index(name) for name in ("largest", "largest_robot", "largest_visit")
)
_MEAN_SQUARE: Final = COLUMNS.index("mean_square")
_AT_POSES: Final = [COLUMNS.index(name) for name in ("mean", "ap_mean", "rp_mean")]
# Up to this number of poses their figures are kept for the floor by counting of the intervals,
# which is negligible with more.
_MOST_KEPT: Final = 65_536
_SQUARES: Final = slice(COLUMNS.index("bias_square"), COLUMNS.index("visit_square") + 1)


@dataclass(frozen=True, slots=True)
class Worst:
    """The largest error at one pose: its size (m), the pose by number, and which robot at which
    visit made it.
    """

    design: int
    block: int
    pose: int
    robot: int
    visit: int
    error: float
    q: Floats

    def facts(self) -> dict[str, Any]:
        """Return pose, robot, visit, error (m) and joint values (rad, m) as plain data."""
        return {
            "pose": self.pose,
            "robot": self.robot,
            "visit": self.visit,
            "error_m": self.error,
            "q": self.q.tolist(),
        }


@dataclass(frozen=True, slots=True)
class Falls:
    """At how many of its poses a design falls, and where its springs cannot hold the load most
    often.
    """

    count: int
    poses: int
    place: str


@dataclass(frozen=True)
class Outcome:
    """The results of one design; lengths in m.

    falls      where the design falls at some poses: it then has no figures, for it would be
               compared without its worst poses; None where it stands

    declared   the figures of the error by key; figures: their values
    approach   sign of the joints' last motion
    lower      by how much its 95 % error lies below the first design's, from the same draws; None
               for the first
    rms        root of the exact mean square, with the part of it that load and pose, each robot,
               and each visit make (3,), m^2
    worst      the largest errors, each of a pose of its own
    check      first order against exact composition
    overloads  drives that hold more than they are rated for, over the joint limits
    limits     makers' upper limits that count, at some of the poses
    mass       of the arm without its payload, kg, as far as it is stated; gearboxes_without_mass:
               models of gearboxes without a mass
    price      of the arm as far as it is stated, in the currency of the file; None where none is.
               joints_without_price: names of joints without one
    spread     some errors (m), rising, and the share of all samples below each
    known      states of its kinds of error, without the limits
    """

    design: int
    falls: Falls | None
    stated: dict[str, Any]
    joints: tuple[tuple[str, str], ...]
    declared: dict[str, Figure]
    figures: dict[str, Estimate]
    approach: float
    lower: Estimate | None
    rms: float
    levels: Floats
    costs: list[Cost]
    worst: list[Worst]
    check: exact.ExactCheck
    overloads: tuple[Overload, ...]
    limits: tuple[LimitShare, ...]
    mass: float
    gearboxes_without_mass: tuple[str, ...]
    price: float | None
    joints_without_price: tuple[str, ...]
    spread: tuple[Floats, Floats]
    known: States

    @property
    def p95(self) -> Estimate:
        """Return the error that 95 % of all positions stay within."""
        return self.figures[HEADLINE]

    @property
    def ap(self) -> Estimate | None:
        """Return AP that 95 % of the robots stay within; None for a single visit."""
        return self.figures.get("ap_p95")

    @property
    def rp(self) -> Estimate | None:
        """Return RP that 95 % of the robots stay within; None for a single visit."""
        return self.figures.get(f"{rp_key(self.approach)}_p95")


@dataclass
class _Merged:
    """Sums over the blocks of a design; their size does not depend on how many there are."""

    robots: Floats
    groups: np.ndarray
    sets: np.ndarray
    parts: Floats
    levels: Floats
    worst: list[Worst]
    at_poses: list[Floats]
    square: float = 0.0
    falls: bool = False

    def add(self, order: Order, design: int, block: int, record: BlockRecord) -> None:
        """Add one block."""
        self.falls |= record.falls
        of_set = order.set_of(block)
        first, last = order.span(block)
        self.robots[of_set] += record.robots
        self.groups += record.histogram
        self.sets[of_set] += record.histogram.sum(axis=0)
        self.parts += record.parts
        self.levels[of_set] += record.poses[: last - first, _SQUARES].sum(axis=0)
        if order.poses <= _MOST_KEPT:
            rows = record.poses[: last - first]
            self.at_poses.append(np.column_stack([rows[:, _AT_POSES], rows[:, _SQUARES]]))
        self.square += float(record.poses[: last - first, _MEAN_SQUARE].sum())
        self.worst = worst_of(self.worst, order, design, block, record)


def worst_of(
    known: list[Worst],
    order: Order,
    design: int,
    block: int,
    record: BlockRecord,
    most: int = MOST_WORST,
) -> list[Worst]:
    """Return the largest errors of those known and of one more block. The largest first, of equal
    ones the earlier pose.
    """
    first, last = order.span(block)
    rows = record.poses[: last - first]
    ranked = np.argsort(-rows[:, _LARGEST], kind="stable")[:most]
    floor = known[-1].error if len(known) == most else -1.0
    nobody = np.empty(0)  # joint values are looked up once, for those that stay
    new = [
        Worst(
            design,
            block,
            first + int(row),
            int(rows[row, _ROBOT]),
            int(rows[row, _VISIT]),
            float(rows[row, _LARGEST]),
            nobody,
        )
        for row in ranked
        if rows[row, _LARGEST] > floor
    ]
    return sorted([*known, *new], key=lambda each: (-each.error, each.design, each.pose))[:most]


def summarise(
    store: Store, progress: Callable[[str, int, int], None] | None = None
) -> list[Outcome]:
    """Return the summary of every design, in order. Raises LostmotionError where a block is not
    done, or damaged; InputError where all designs fall, with the joint of the first.
    """
    out: list[Outcome] = []
    first: _Merged | None = None
    for design in range(store.order.designs):
        merged = _merged(store, design, progress)
        out.append(
            _fallen(store.order, design) if merged.falls else _outcome(store, design, merged, first)
        )
        if design == 0 and not merged.falls:
            first = merged
    if all(each.falls for each in out):
        refuse_falling(design_of(store.order, 0).arm, *_falls(store.order, 0))
    return out


def _merged(store: Store, design: int, progress: Callable[[str, int, int], None] | None) -> _Merged:
    order = store.order
    merged: _Merged | None = None
    for block in range(order.blocks):
        record = store.read(design, block)
        if merged is None:
            groups, bins = record.histogram.shape
            merged = _Merged(
                np.zeros((order.sets, order.robots, len(OF_ROBOTS))),
                np.zeros((groups, bins), np.int64),
                np.zeros((order.sets, bins), np.int64),
                np.zeros_like(record.parts),
                np.zeros((order.sets, 3)),
                [],
                [],
            )
        merged.add(order, design, block, record)
        if progress is not None:
            progress("summing up", design * order.blocks + block + 1, order.designs * order.blocks)
    if merged is None:
        raise ValueError("an order without blocks")
    return merged


def _falls(order: Order, design: int) -> tuple[Floats, NDArray[np.int64]]:
    """Return the poses (pose, joint) of a design, and where it falls (pose,), as `falls_at`."""
    q = np.concatenate(
        [poses_of(order, design, *order.span(block)) for block in range(order.blocks)]
    )
    return q, falls_at(design_of(order, design).arm, q)


def _fallen(order: Order, design: int) -> Outcome:
    """Return the outcome of a design that falls at some poses: it has no figures."""
    arm, (_, places) = design_of(order, design).arm, _falls(order, design)
    return Outcome(
        design=design,
        falls=Falls(int((places >= 0).sum()), len(places), cannot_hold(arm, places)),
        **_about(order, design),
        declared={},
        figures={},
        lower=None,
        rms=math.nan,
        levels=np.full(3, np.nan),
        costs=[],
        worst=[],
        check=exact.ExactCheck(0.0, 0.0, 0),
        limits=(),
        spread=(np.zeros(0), np.zeros(0)),
    )


def _about(order: Order, design: int) -> dict[str, Any]:
    """Return the fields of an outcome that do not depend on its errors."""
    arm = design_of(order, design).arm
    return {
        "stated": order.stated(design),
        "joints": tuple((joint.name, joint.type) for joint in arm.driven),
        "approach": float(order.approach),
        "overloads": overloads(arm),
        "mass": arm.mass,
        "gearboxes_without_mass": arm.gearboxes_without_mass,
        "price": arm.price,
        "joints_without_price": arm.joints_without_price,
        "known": states(arm),
    }


def _outcome(store: Store, design: int, merged: _Merged, first: _Merged | None) -> Outcome:
    order = store.order
    arm = design_of(order, design).arm
    robots = merged.robots * (order.sets / order.poses)
    kept = np.concatenate(merged.at_poses) if merged.at_poses else None
    at = [None] * len(_AT_POSES) if kept is None else list(kept.T)
    squares = Squares(
        merged.levels * (order.sets / order.poses),
        NOT_CHECKED.many,
        None if kept is None else kept[:, len(_AT_POSES) :],
    )
    ap, rp = (VisitFigures(robots[:, :, k], at[k], squares) for k in (1, 2))
    repeats = order.visits > 1
    errors = Drawn(
        squares=squares,
        visits=order.visits,
        accuracy=ap if repeats else None,
        repeats={float(order.approach): rp} if repeats else {},
        robot_means=robots[:, :, 0],
        of_poses=at[0],
        groups=merged.groups,
        sets=merged.sets,
        largest=merged.worst[0].error,
        mean_square=merged.square / order.poses,
    )
    levels = merged.levels.sum(axis=0)
    total = float(levels.sum())
    own, *shared = merged.parts[: len(order.parts)].T
    tally = Tally(order.parts, order.poses, total, own, np.stack(shared, axis=1))
    return Outcome(
        design=design,
        falls=None,
        **_about(order, design),
        declared=figures_of(errors),
        figures=estimates(errors),
        lower=None
        if first is None
        else quantile_drop((first.groups, first.sets), (merged.groups, merged.sets), _LEVEL),
        rms=float(np.sqrt(total / order.poses)),
        levels=levels / order.poses,
        costs=[cost for cost in costs(tally) if cost.alone or cost.share],
        worst=[with_pose(order, each) for each in merged.worst],
        check=_check(order, design),
        limits=limit_shares(arm, _some_poses(order, design), float(order.approach)),
        spread=_spread(merged.sets.sum(axis=0)),
    )


def _spread(counts: np.ndarray) -> tuple[Floats, Floats]:
    """Thin a histogram out to a curve that can be drawn."""
    edges, below = bin_edges(), np.concatenate([[0], np.cumsum(counts)])
    occupied = np.flatnonzero(counts)
    first, last = int(occupied[0]), int(occupied[-1]) + 1
    at = np.unique(
        np.searchsorted(edges, np.linspace(edges[first], edges[last], _CURVE)).clip(first, last)
    )
    return np.asarray(edges[at]), np.asarray(below[at] / below[-1])


def with_pose(order: Order, worst: Worst) -> Worst:
    """Look the joint values of an extreme up."""
    q = poses_of(order, worst.design, worst.pose, worst.pose + 1)[0]
    return Worst(worst.design, worst.block, worst.pose, worst.robot, worst.visit, worst.error, q)


def _some_poses(order: Order, design: int) -> Floats:
    """Return the first poses of a design (pose, joint): a Sobol sequence or a list covers the
    workspace with few.
    """
    return poses_of(order, design, 0, min(order.poses, _LIMIT_POSES))


def _check(order: Order, design: int) -> exact.ExactCheck:
    """Compare first order with exact composition at a few poses, evenly spread over the run."""
    arm = design_of(order, design).arm
    poses = np.unique(np.linspace(0, order.poses - 1, exact.POSES).astype(int))
    q = np.concatenate([poses_of(order, design, int(pose), int(pose) + 1) for pose in poses])
    matrix = pose_matrix(arm, q, approach=order.approach)
    counts = min(order.robots, exact.ROBOTS), min(order.visits, exact.VISITS)
    found = [
        exact.check(matrix, int(pose) - row, np.array([row]), order.seed, *counts)
        for row, pose in enumerate(poses)
    ]
    return exact.join(found)
