"""Carry an order out: what is done stays, the rest is computed and kept block by block."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from pydantic import ValidationError

from lostmotion.error_model.poses import REPLICATES
from lostmotion.error_model.provenance import refuse_undescribed
from lostmotion.error_model.trust import refuse_untrusted
from lostmotion.errors import LostmotionError, refuse_argument, shown
from lostmotion.io.calibration_file import read_calibration
from lostmotion.io.poses import read_poses
from lostmotion.io.sweep import designs
from lostmotion.io.sweep_designs import read_sweep, texts
from lostmotion.mechanism.assembly import assembled, may_not_assemble
from lostmotion.mechanism.state import tool_points
from lostmotion.runs.blocks import parts_of
from lostmotion.runs.job import (
    LARGEST_BLOCK,
    MOST_BLOCKS,
    MOST_RETURNS,
    Order,
    check_block,
    made_with,
    usual_block,
)
from lostmotion.runs.stream import poses_between, rounded
from lostmotion.runs.workers import on_dask, on_threads

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from lostmotion.io.sweep_designs import Stated
    from lostmotion.mechanism.arm import Arm
    from lostmotion.runs.job import Law
    from lostmotion.runs.store import Store
    from lostmotion.runs.workers import Cluster

MOST_WORKERS: Final = 1024
# Poses of a closed chain, all of which are checked before a run begins.
_MOST_CLOSED: Final = 65_536
# Where an order keeps the user's poses, so that they have no name of the arm's own files.
_GIVEN: Final = "given"
# Folder of the estimates in an order.
_CALIBRATION: Final = "calibration"


def order(  # noqa: PLR0913 - a run is these numbers
    path: Stated,
    sidecar: Path | None = None,
    by: Stated | None = None,
    calibration: Path | None = None,
    *,
    poses: int | Path,
    robots: int,
    visits: int,
    seed: int,
    pose_law: Law = "sobol",
    approach: int = 0,
    block: int | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Order:
    """Return the job of this run. Reads the arm from its file or dictionary, and every design that
    its `[sweep]`, or that of `by`, asks for.

    `calibration` has estimates of the robot that every design is. `poses` are so many by
    `pose_law`, or those of a CSV, which all designs must be able to take. Raises InputError with
    every mistake in the files, and for counts out of range.
    """
    from lostmotion.error_model.poses import POSE_LAWS, Poses
    from lostmotion.propagation.montecarlo.blocks import BlockPlan

    parts: dict[str, None] = {}
    reaches: dict[tuple[object, ...], Arm] = {}

    def look(each: Arm) -> None:
        refuse_undescribed(each)
        parts.update(dict.fromkeys(parts_of(each)))
        # which poses a closed chain reaches depends on all of its lengths
        own = len(reaches) if may_not_assemble(each) else 0
        reaches.setdefault(
            (*(joint.name for joint in each.driven), each.limits.tobytes(), own), each
        )

    arm, axes = read_sweep(path, sidecar, by, progress, look)
    if calibration is not None:
        arm.calibrated(read_calibration(calibration, arm))  # refused here, before any work
    # checks the counts
    BlockPlan.of(
        arm, Poses(np.zeros((1, len(arm.driven))), "given"), robots, visits, seed, approach
    )
    if not 0 <= seed < 2**63:
        raise refuse_argument("seed", seed, f"a whole number from 0 to {2**63 - 1}", seed=1)
    files = texts(path, sidecar, axes)
    estimates = None if calibration is None else f"{_CALIBRATION}/{calibration.name}"
    if calibration is not None and estimates is not None:
        files[estimates] = calibration.read_text(encoding="utf-8-sig")
    given: str | None = None
    if isinstance(poses, int):
        if pose_law not in POSE_LAWS:
            raise refuse_argument(
                "pose_law", pose_law, "one of " + ", ".join(POSE_LAWS), pose_law="sobol"
            )
        count, sets = rounded(arm, poses, pose_law)
    else:
        # Designs with other joints or limits must be able to take them too.
        count, sets, pose_law, given = (
            min(len(read_poses(poses, each)) for each in reaches.values()),
            1,
            "given",
            f"{_GIVEN}/{poses.name}",
        )
        files[given] = poses.read_text(encoding="utf-8-sig")
    _refuse_excluded(reaches.values(), pose_law, poses if given else count, seed)
    each = min(check_block(block or usual_block(robots), robots), count // sets)
    total = designs(axes) * sets * -(-count // sets // each)
    if total > MOST_BLOCKS:
        raise refuse_argument(
            "block",
            each,
            f"so many poses that the run has at most {MOST_BLOCKS} blocks, not {total}",
            block=LARGEST_BLOCK,
        )
    if robots * visits > MOST_RETURNS:
        raise refuse_argument(
            "robots, visits",
            robots * visits,
            f"at most {MOST_RETURNS}, held by every worker",
            robots=1000,
            visits=30,
        )
    try:
        return Order(
            made_with=made_with(),
            arm=next(iter(files)),
            files=files,
            axes=axes,
            poses=count,
            sets=8 if sets > 1 else 1,
            law=pose_law,
            given=given,
            calibration=estimates,
            robots=robots,
            visits=visits,
            seed=seed,
            approach=-1 if approach < 0 else 1 if approach > 0 else 0,
            block=each,
            parts=tuple(parts),
        )
    except ValidationError as error:
        found = shown(
            ", ".join(files) if error.errors()[0]["loc"] == ("files",) else error.errors()[0]["msg"]
        )
        expected = "at most 50 files, with plain names that end in .toml, .urdf, .xml or .csv"
        raise refuse_argument("arm", found, expected, arm="arm.toml") from None


def carry_out(
    store: Store,
    workers: int = 1,
    cluster: Cluster | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> int:
    """Compute and store every block that is missing, and return how many there were. After an
    interruption the same call computes the rest.

    On `workers` threads, or on the Dask cluster given.
    Raises LostmotionError where the store cannot be written, another process writes to it, or
    workers of other versions compute.
    """
    check_workers(workers)
    with store.locked():
        there = store.done(progress)
        total, done = there.size, int(there.sum())
        todo = (
            (int(k) // store.order.blocks, int(k) % store.order.blocks)
            for k in np.flatnonzero(~there)
        )
        text = store.order.text()
        for design, block, packed, versions in (
            on_threads(text, todo, workers) if cluster is None else on_dask(text, todo, cluster)
        ):
            _refuse_others(store.order.made_with, versions)
            try:
                store.write(design, block, packed)
            except OSError as error:
                raise LostmotionError(
                    f"'{store.folder}' cannot be written: {error.strerror or error}\n  {done} "
                    f"of {total} blocks are kept; the same command goes on"
                ) from error
            done += 1
            if progress is not None:
                progress(f"block {done} of {total}", done, total)
    return total - int(there.sum())


def check_workers(workers: int) -> int:
    """Refuse more threads than make sense, or none."""
    if not 1 <= workers <= MOST_WORKERS:
        raise refuse_argument("workers", workers, f"from 1 to {MOST_WORKERS}", workers=4)
    return workers


def _refuse_others(mine: dict[str, str], theirs: dict[str, str]) -> None:
    other = [
        f"{name} {theirs.get(name)} there, {mine[name]} here"
        for name in mine
        if theirs.get(name) != mine[name]
    ]
    if other:
        raise LostmotionError(
            f"the workers are of other versions: {', '.join(other)}\n  install the same ones: "
            "others might compute other last bits"
        )


def _refuse_excluded(arms: Iterable[Arm], law: Law, poses: int | Path, seed: int) -> None:
    """Refuse closed chains of which some of the poses of a run would have to be excluded, as a
    study does: blocks compute all of their poses.

    poses  how many of this law, or a file of them
    """
    for arm in arms:
        if not may_not_assemble(arm):
            continue
        if not isinstance(poses, int):
            q = read_poses(poses, arm)
            tool_points(arm, q)
            refuse_untrusted(arm, q, 0.0)
            continue
        if poses > _MOST_CLOSED:
            raise refuse_argument(
                "poses", poses, f"at most {_MOST_CLOSED} poses of a closed chain", poses=2048
            )
        each = poses if law == "grid" else poses // REPLICATES
        rows = [
            poses_between(arm, law, poses, seed, first, first + each)
            for first in range(0, poses, each)
        ]
        q = np.concatenate(rows)
        known = np.isfinite(q).all(axis=1)
        excluded = len(q) - np.count_nonzero(assembled(arm, q[known]))
        if excluded:
            raise refuse_argument(
                "poses",
                f"{excluded} of {poses} poses between the limits of the drives at which the closed "
                "chain is not assembled or near a parallel singularity",
                "limits of the drives that exclude them, poses from a file, or a study, which "
                "leaves them out",
                poses="poses.csv",
            )
        refuse_untrusted(arm, q, 0.0)
