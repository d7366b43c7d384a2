"""One block of one design: a record of fixed size, the same bits whoever computes it and when."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.error_model import error_bins
from lostmotion.error_model.bounds import bounds
from lostmotion.error_model.budget import Tally
from lostmotion.error_model.pose_matrix import PoseMatrix, forget_matrices, pose_matrix
from lostmotion.error_model.poses import Poses
from lostmotion.errors import LostmotionError
from lostmotion.mechanism.standing import falls_at
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.blocks import BlockPlan, sample_block
from lostmotion.runs.job import Order, made_with, order_of
from lostmotion.runs.stream import poses_between, steps_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

ZSTD_LEVEL: Final = 3
_INTERVAL: Final = ("", "_low", "_high")
# What is kept of every pose, in m and m^2: the kernel's columns, AP and RP over the robots, exact
# mean squares by level, bounds.
COLUMNS: Final = (
    *("mean", "mean_half_interval", "mean_square", "largest", "largest_robot", "largest_visit"),
    *(f"q{100 * level:.0f}{end}" for level in kernel.QUANTILES for end in _INTERVAL),
    *(
        f"{name}{end}"
        for name in ("ap", "rp")
        for end in ("_mean", *(f"_q95{end}" for end in _INTERVAL))
    ),
    *("bias_square", "robot_square", "visit_square", "worst_case", "root_sum_square"),
)
# Of these, known for every pose however few robots and visits there are.
_ALWAYS: Final = (
    *("mean", "mean_square", "largest", "largest_robot", "largest_visit"),
    *(f"q{100 * level:.0f}" for level in kernel.QUANTILES),
    *("bias_square", "robot_square", "visit_square", "root_sum_square"),
)
PARTS: Final = ("own", "design", "robot", "visit")
OF_ROBOTS: Final = ("mean", "ap", "rp")
_AP: Final = kernel.COLUMNS
_SQUARES: Final = _AP + 8


class BlockRecord(NamedTuple):
    """What is kept of a block.

    poses      (row, len(COLUMNS)) one row per pose, m and m^2; NaN in rows beyond the block's last
               pose
    histogram  (group, error_bins.BINS) how many samples of each group of robots fall into each bin
               of the error
    robots     (robot, 3) mean error, AP and RP of each robot, summed over the block's poses, m; NaN
               for AP and RP of a single visit
    parts      (part, 3) variance, own and shared bias of each part, summed over the poses, m^2, in
               the order of `Order.parts`

    Of a design that falls at some pose of the block there are no figures: NaN, and no counts.
    """

    poses: Floats
    histogram: np.ndarray
    robots: Floats
    parts: Floats

    @property
    def falls(self) -> bool:
        """Return whether the design falls at some pose of the block."""
        return bool(np.isnan(self.poses).all())


class BlockArray(NamedTuple):
    """Shape and type of one array of a record, and what its axes are."""

    shape: tuple[int, int]
    kind: str
    axes: tuple[str, str]
    words: str

    @property
    def size(self) -> int:
        """Count its bytes."""
        return self.shape[0] * self.shape[1] * np.dtype(self.kind).itemsize


def pieces(order: Order) -> dict[str, BlockArray]:
    """Return the arrays of a record of this job."""
    return {
        "poses": BlockArray(
            (order.block, len(COLUMNS)), "<f8", ("row", "of_pose"), ", ".join(COLUMNS)
        ),
        "histogram": BlockArray(
            (design_of(order, 0).plan.groups, error_bins.BINS),
            "<i8",
            ("group", "bin"),
            "samples by size of the error",
        ),
        "robots": BlockArray(
            (order.robots, len(OF_ROBOTS)),
            "<f8",
            ("robot", "of_robot"),
            "sums over the block's poses: " + ", ".join(OF_ROBOTS),
        ),
        "parts": BlockArray(
            (max(len(order.parts), 1), len(PARTS)),
            "<f8",
            ("part", "of_part"),
            "sums over the block's poses: " + ", ".join(PARTS),
        ),
    }


def pack(record: BlockRecord) -> dict[str, bytes]:
    """Return a record as bytes. Each array as a chunk of Zarr: little-endian, Zstandard."""
    from numcodecs.zstd import Zstd

    codec = Zstd(level=ZSTD_LEVEL, checksum=False)
    return {
        name: bytes(codec.encode(np.ascontiguousarray(value)))
        for name, value in record._asdict().items()
    }


def unpack(order: Order, packed: Mapping[str, bytes]) -> BlockRecord:
    """Return the record that these bytes encode. Raises ValueError for bytes that are none of this
    order's, before they take any room.
    """
    from numcodecs.zstd import Zstd

    found = {}
    for name, piece in pieces(order).items():
        if _unpacked_size(packed[name]) != piece.size:
            raise ValueError(f"{name}: bytes of another size")
        found[name] = np.frombuffer(Zstd().decode(packed[name]), piece.kind).reshape(piece.shape)
    return BlockRecord(**found)


def check_record(order: Order, block: int, record: BlockRecord) -> BlockRecord:
    """Refuse a record that no study of this order makes, whatever its checksum says: a store may
    come from a stranger, or from a broken disk.

    Raises ValueError for figures that are not finite or negative, for robots and visits out of
    range, and for counts that do not add up.
    """
    if record.falls and not record.histogram.any():
        return record
    first, last = order.span(block)
    rows = record.poses[: last - first]
    always = rows[:, [COLUMNS.index(name) for name in _ALWAYS]]
    robot, visit = rows[:, kernel.LARGEST_ROBOT], rows[:, kernel.LARGEST_VISIT]
    # Only the worst case may be infinite: where an error has no limits there is none.
    bounded = np.delete(rows, COLUMNS.index("worst_case"), axis=1)
    worst = rows[:, COLUMNS.index("worst_case")]
    if (
        not (np.isfinite(always) & (always >= 0)).all()
        or np.isinf(bounded).any()
        or not (worst >= 0).all()
    ):
        raise ValueError("figures of poses that are no lengths")
    if (
        (robot >= order.robots).any()
        or (visit >= order.visits).any()
        or (robot % 1).any()
        or (visit % 1).any()
    ):
        raise ValueError("a robot or a visit out of range")
    samples = (last - first) * order.robots * order.visits
    if (
        (record.histogram < 0).any()
        or (record.histogram > samples).any()
        or int(record.histogram.sum()) != samples
    ):
        raise ValueError("counts that do not add up")
    if (
        not (np.isfinite(record.robots[:, 0]) & (record.robots[:, 0] >= 0)).all()
        or np.isinf(record.robots).any()
    ):
        raise ValueError("figures of robots that are no lengths")
    if not np.isfinite(record.parts).all():
        raise ValueError("figures of parts that are not finite")
    return record


def _unpacked_size(raw: bytes) -> int:
    """Return the number of bytes that a Zstandard frame declares. -1 where it does not say (RFC
    8878, 3.1.1.1); if it lies, decoding fails.
    """
    if raw[:4] != b"\x28\xb5\x2f\xfd" or len(raw) < 6:  # noqa: PLR2004 - shorter than any frame
        return -1
    flag, alone, dictionary = raw[4] >> 6, raw[4] >> 5 & 1, raw[4] & 3
    width = (1 if alone else 0, 2, 4, 8)[flag]
    at = 5 + (0 if alone else 1) + (0, 1, 2, 4)[dictionary]
    return (
        int.from_bytes(raw[at : at + width], "little") + (256 if flag == 1 else 0) if width else -1
    )


class Design(NamedTuple):
    """An arm of the sweep, the plan of its study with what was drawn for every robot, and its poses
    where they are given.
    """

    arm: Arm
    plan: BlockPlan
    given: Floats | None


def design_of(order: Order, design: int) -> Design:
    """Return the arm of this design and its study. Kept for the next blocks."""
    return _design_of(order.text(), design)


@functools.lru_cache(maxsize=4)
def _design_of(text: bytes, design: int) -> Design:
    order = order_of(text)
    arm = order.read(design)
    # The plan's poses play no part in a block, which is given its own.
    plan = BlockPlan.of(
        arm,
        Poses(np.zeros((1, len(arm.driven))), "given"),
        order.robots,
        order.visits,
        order.seed,
        order.approach,
    )
    given = order.listed(arm)
    if given is not None and len(given) != order.poses:
        raise LostmotionError(f"the order lists {len(given)} poses and speaks of {order.poses}")
    if order.law == "grid":
        steps_of(order.poses, len(arm.driven))  # refuses a count that is no grid's
    return Design(arm, plan, given)


def poses_of(order: Order, design: int, first: int, last: int) -> Floats:
    """Return the poses (pose, joint) from number `first` up to `last`, rad or m. q (pose, joint),
    rad or m; no stretch over two sets.
    """
    arm, _, given = design_of(order, design)
    return (
        poses_between(arm, order.law, order.poses, order.seed, first, last)
        if given is None
        else given[first:last]
    )


def matrix_of(order: Order, design: int, block: int) -> PoseMatrix:
    """Return the pose matrix of this block."""
    return pose_matrix(
        design_of(order, design).arm,
        poses_of(order, design, *order.span(block)),
        approach=order.approach,
    )


def compute(order: Order, design: int, block: int) -> BlockRecord:
    """Return the record of this block of this design. Raises InputError where the arm falls and is
    the only design, with the joint that cannot hold.
    """
    first, last = order.span(block)
    arm, plan, _ = design_of(order, design)
    if order.designs > 1 and (falls_at(arm, poses_of(order, design, first, last)) >= 0).any():
        return BlockRecord(
            np.full((order.block, len(COLUMNS)), np.nan),
            np.zeros((plan.groups, error_bins.BINS), np.int64),
            np.full((order.robots, len(OF_ROBOTS)), np.nan),
            np.zeros((max(len(order.parts), 1), len(PARTS))),
        )
    matrix = matrix_of(order, design, block)
    sample = sample_block(plan, matrix, first)
    rows = np.full((order.block, len(COLUMNS)), np.nan)
    found = rows[: last - first]
    found[:, :_AP] = sample.per_pose
    found[:, _AP:_SQUARES] = sample.over_robots().reshape(last - first, -1)
    found[:, _SQUARES : _SQUARES + 3] = matrix.merged.level_squares
    found[:, _SQUARES + 3 : _SQUARES + 5] = np.transpose(bounds(matrix))
    tally = Tally.of(matrix)
    parts = np.zeros((max(len(order.parts), 1), len(PARTS)))
    at = [order.parts.index(owner) for owner in tally.owners]
    parts[at] = np.column_stack([tally.own, tally.shared])
    return BlockRecord(rows, sample.whole_hist(), sample.over_poses(), parts)


def compute_packed(text: bytes, design: int, block: int) -> tuple[dict[str, bytes], dict[str, str]]:
    """Return the bytes of this block, and the versions that computed them. For workers that know
    nothing but the order's text.
    """
    packed = pack(compute(order_of(text), design, block))
    forget_matrices()
    return packed, made_with()


def parts_of(arm: Arm) -> tuple[str, ...]:
    """Return the parts of this arm with error terms."""
    return tuple(dict.fromkeys(of.owner for of in arm.terms))
