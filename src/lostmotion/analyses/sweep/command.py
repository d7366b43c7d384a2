"""Carry out big runs: many poses, or a grid of designs; and replay their extremes."""

from __future__ import annotations

import os
from contextlib import nullcontext
from dataclasses import dataclass
from operator import index
from pathlib import Path
from typing import TYPE_CHECKING

from lostmotion.analyses.arguments import DEFAULT_POSES, DEFAULT_ROBOTS, DEFAULT_VISITS, a_path, sign_of
from lostmotion.analyses.result import Shown
from lostmotion.error_model.provenance import states
from lostmotion.errors import InputError, Problem, shown

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray

    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.runs.job import Law
    from lostmotion.runs.replay import Replay
    from lostmotion.runs.store import Store
    from lostmotion.runs.summary import Outcome


def sweep(  # noqa: PLR0913 - a run is these numbers
    path: str | Path,
    by: str | Path | None = None,
    poses: int | str | Path = DEFAULT_POSES,
    robots: int = DEFAULT_ROBOTS,
    visits: int = DEFAULT_VISITS,
    seed: int = 1,
    *,
    sidecar: str | Path | None = None,
    pose_law: Law = "sobol",
    approach: str = "random",
    block: int | None = None,
    out: str | Path | None = None,
    workers: int | None = None,
    dask: str | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Sweep:
    """How accurate is every design that an arm file's `[sweep]` asks for, or the one arm at any number of poses?

    path     the arm file: its keys are what a sweep changes, which an arm in memory no longer has; `sidecar` as in `read`
    by       a TOML with [sweep], in place of the arm's own; without either there is one design
    poses    how many of each design, any number up to 8 x 2^30: memory does not grow with it; or a CSV of poses as in `formats.poses`
    robots, visits, seed, pose_law, approach   as in `study`; all designs share poses and draws
    block    poses computed and kept at a time; changes last bits of sums, so it is part of the order. Left out: 1024, fewer with many robots
    out      the folder of the run, NAME-sweep where left out. A run that was killed goes on from what is there, to the same bytes
    workers  threads; left out: one per processor. dask: "local:N" processes, or the address of a scheduler, instead

    Raises InputError with every mistake in the files, for counts out of range, and where no scheduler answers; OutputExistsError where the folder
    holds anything else. Then nothing is written.
    """
    from lostmotion.mechanism.arm import Arm
    from lostmotion.runs.execute import carry_out, check_workers, order
    from lostmotion.runs.store import Store
    from lostmotion.runs.summary import summarise
    from lostmotion.runs.workers import check_address, cluster

    if not isinstance(path, str | os.PathLike):
        found = f"an Arm, {path.name}" if isinstance(path, Arm) else shown(path)
        expected = "the path of an arm file: a sweep changes keys of the file, which an arm in memory no longer has"
        raise InputError([Problem("", "path", found, expected, 'lostmotion.sweep("z-arm.toml")')])
    if dask is not None:
        check_address(dask)
    threads = check_workers(os.cpu_count() or 1 if workers is None else workers)
    sign = int(sign_of(approach))
    path = Path(path)
    asked = order(
        path,
        None if sidecar is None else a_path("sidecar", sidecar),
        None if by is None else a_path("by", by),
        poses=Path(poses) if isinstance(poses, str | Path) else index(poses),
        robots=index(robots),
        visits=index(visits),
        seed=index(seed),
        pose_law=pose_law,
        approach=sign,
        block=block,
        progress=progress,
    )
    with nullcontext() if dask is None else cluster(dask) as connected:  # before anything is written
        store = Store.begin(Path(out or f"{path.stem}-sweep"), asked)
        carry_out(store, threads, connected, progress)
    return Sweep(asked.read(0), store, tuple(summarise(store, progress)))


def replay(
    folder: str | Path,
    design: int | None = None,
    worst: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> list[Replayed]:
    """How did the largest errors of a run come about, term by term? Each of a pose of its own, the largest first.

    folder  the run's; nothing in it is changed
    design  by its number, from 0; left out: of all designs

    Raises LostmotionError for a folder that holds no run or lacks blocks, InputError for a number out of range.
    """
    from lostmotion.runs.replay import replays
    from lostmotion.runs.store import Store

    store = Store.open(a_path("folder", folder))
    return [Replayed(store.order.read(each.found.design).name, store, each) for each in replays(store, design, worst, progress)]


@dataclass(frozen=True, repr=False)
class Sweep(Shown):
    """A run that is done: `outcomes` by design, `arrays()` over the keys swept, `summary()`, `report()`, `result()`; `store` holds every block."""

    arm: Arm
    store: Store
    outcomes: tuple[Outcome, ...]

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values of the first design."""
        return states(self.arm)

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.analyses.sweep.tables.sweep import sweep_sheet

        return sweep_sheet(self.arm, self.store.order, self.outcomes)

    def report(self) -> Path:
        """Write report.html and result.json beside the blocks; gives the folder. Those of an earlier summing up are replaced."""
        from lostmotion.analyses.sweep.plots import sweep_plots
        from lostmotion.reporting.page import contents

        for name, content in contents(self.sheet, sweep_plots(self.store.order, self.outcomes)).items():
            self.store.keep(name, content)
        return self.store.folder

    def arrays(self) -> xarray.Dataset:
        """Give the figures of every design over the keys swept."""
        from lostmotion.runs.arrays import dataset

        return dataset(self.store.order, self.outcomes)

    def __repr__(self) -> str:
        """Tell in a line what was run."""
        order = self.store.order
        return f"<Sweep of '{self.arm.name}': {order.designs} designs x {order.poses} poses x {order.robots} robots x {order.visits} visits>"


@dataclass(frozen=True, repr=False)
class Replayed(Shown):
    """One extreme of a run: `found` holds its pose, draws and terms; `summary()`, `result()`."""

    arm: str
    store: Store
    found: Replay

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed and written."""
        from lostmotion.analyses.sweep.tables.replay import replay_sheet

        return replay_sheet(self.arm, self.store.order, self.found)

    def __repr__(self) -> str:
        """Tell in a line what was replayed."""
        at = self.found.found
        return f"<Replay of design {at.design}, pose {at.pose}, robot {at.robot}, visit {at.visit}: {at.error:.6g} m>"
