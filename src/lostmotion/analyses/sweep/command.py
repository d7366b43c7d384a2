"""Ask for many poses, or a grid of designs, block by block."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from lostmotion.analyses.arguments import (
    DEFAULT_POSES,
    DEFAULT_ROBOTS,
    DEFAULT_VISITS,
    ApproachArgument,
    CalibrationArgument,
    PoseLawArgument,
    ProgressArgument,
    RobotsArgument,
    SeedArgument,
    SidecarArgument,
    VisitsArgument,
    path_of,
    path_or_mapping,
)
from lostmotion.analyses.signature import Argument, question, read_arguments, results_folder
from lostmotion.errors import refuse_argument, shown

if TYPE_CHECKING:
    from lostmotion.analyses.sweep.page import Sweep


def _file_of(name: str, value: object, _given: object) -> Path | Mapping[str, Any]:
    """Return the path of the arm's file, or its dictionary: a sweep changes their keys, which an
    arm in memory no longer has.
    """
    if isinstance(value, Mapping):
        return value
    if not isinstance(value, str | os.PathLike):
        found = (
            "nothing"
            if value is None
            else f"an Arm, {value.name}"
            if hasattr(value, "name")
            else shown(value)
        )
        expected = (
            "the path of an arm file, or a dictionary: a sweep changes their keys, which an arm in "
            "memory no longer has"
        )
        raise refuse_argument(name, found, expected, **{name: "arm.toml"})
    return Path(value)


def _poses_of(name: str, value: Any, _given: Mapping[str, Any]) -> int | Path:  # noqa: ANN401 - whatever a user passes
    """Return how many poses each design visits, or the CSV file of them, which the run reads with
    the arm.
    """
    try:
        return (
            int(value)
            if isinstance(value, int | str) and not isinstance(value, bool)
            else path_of(name, value)
        )
    except ValueError:
        return path_of(name, value)


@question(folder="sweep")
def sweep(
    arm: Annotated[
        "str | Path | Mapping[str, Any]",
        Argument(
            (
                "Arm file: native TOML, or URDF with its sidecar TOML; its [sweep] states which "
                "keys take which values. In Python also a dictionary."
            ),
            _file_of,
            metavar="FILE",
        ),
    ],
    by: Annotated[
        "str | Path | Mapping[str, Any] | None",
        Argument(
            "TOML with [sweep], in place of the arm's own; in Python also the keys of that table. "
            "Without either there is one design.",
            path_or_mapping,
            metavar="SWEEP",
        ),
    ] = None,
    poses: Annotated[
        "int | str | Path",
        Argument(
            "How many poses each design visits, any number, rounded up to 8 x a power of two "
            "for sobol; or a CSV file of poses, one column per "
            "joint with a header like 'A [deg]'.",
            _poses_of,
            metavar="COUNT|CSV",
            aliases=("--poses-file",),
        ),
    ] = DEFAULT_POSES,
    robots: RobotsArgument = DEFAULT_ROBOTS,
    visits: VisitsArgument = DEFAULT_VISITS,
    seed: SeedArgument = 1,
    *,
    pose_law: PoseLawArgument = "sobol",
    approach: ApproachArgument = "random",
    block: Annotated[
        int | None,
        Argument(
            (
                "Poses computed and stored at a time; part of the job, for sums differ in their "
                "last bits. Default: 1024, fewer with many robots."
            ),
            least=1,
        ),
    ] = None,
    sidecar: SidecarArgument = None,
    calibration: CalibrationArgument = None,
    out: Annotated[
        "str | Path | None",
        Argument(
            "Folder of the run; a run that was stopped continues there. Default: NAME-sweep.",
            path_of,
            metavar="FOLDER",
        ),
    ] = None,
    force: Annotated[
        bool,
        Argument(
            "Replace an earlier run of another arm, values or counts; the same run is continued."
        ),
    ] = False,
    workers: Annotated[
        int | None,
        Argument("Number of threads; no byte depends on it. Default: one per processor.", least=1),
    ] = None,
    dask: Annotated[
        str | None,
        Argument(
            (
                "Compute on Dask instead: local:N processes, or a scheduler's address. No byte "
                "depends on it."
            ),
            metavar="ADDRESS",
        ),
    ] = None,
    progress: ProgressArgument = None,
) -> Sweep:
    """Study an arm at any number of poses, or a grid of designs, block by block; stopped or killed,
    the same command continues.

    All designs share poses and draws. Memory does not grow with the number of poses.

    Raises
    ------
    InputError
        With every mistake in the arguments and the files, and where no scheduler answers. Then
        nothing is written.
    OutputExistsError
        Where the folder holds anything but this run; with `force`, anything but a run.

    """
    asked = read_arguments(sweep, locals())
    from lostmotion.analyses.sweep.page import Sweep
    from lostmotion.runs.execute import carry_out, check_workers, order
    from lostmotion.runs.store import Store
    from lostmotion.runs.summary import summarise
    from lostmotion.runs.workers import check_address, cluster

    if dask is not None:
        check_address(dask)
    threads = check_workers(os.cpu_count() or 1 if asked.workers is None else asked.workers)
    job = order(
        asked.arm,
        asked.sidecar,
        asked.by,
        None if calibration is None else path_of("calibration", calibration),
        poses=asked.poses,
        robots=asked.robots,
        visits=asked.visits,
        seed=asked.seed,
        pose_law=pose_law,
        approach=int(asked.approach),
        block=asked.block,
        progress=progress,
    )
    file = asked.arm if isinstance(asked.arm, Path) else job.arm
    folder = asked.out or Path(results_folder(file, "sweep"))
    # before anything is written
    with nullcontext() if dask is None else cluster(dask) as connected:
        store = Store.begin(folder, job, force=asked.force)
        try:
            carry_out(store, threads, connected, progress)
        except KeyboardInterrupt as stop:
            stop.add_note(
                f"the blocks that are done are stored in '{folder}'; the same command continues"
            )
            raise
    return Sweep(job.read(0), store, tuple(summarise(store, progress)))
