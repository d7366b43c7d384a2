"""Study an arm."""

from __future__ import annotations

import functools
import os
from dataclasses import dataclass, replace
from numbers import Integral
from typing import TYPE_CHECKING, Literal, TypedDict, Unpack, overload

import numpy as np

from lostmotion.analyses.accuracy.answer import Answer, answer
from lostmotion.analyses.accuracy.attribution import Blamed
from lostmotion.analyses.accuracy.route import METHODS, Method, Route
from lostmotion.analyses.arguments import DEFAULT_POSES, DEFAULT_ROBOTS, DEFAULT_VISITS, an_arm, chosen_poses, sign_of, whole_seed, zone_of
from lostmotion.analyses.result import Shown
from lostmotion.error_model.budget import budget
from lostmotion.error_model.pose_selection import among, poses_in_zone
from lostmotion.error_model.poses import PoseLaw, Poses, sample_poses
from lostmotion.error_model.provenance import refuse_undescribed
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.serial import tool_points
from lostmotion.propagation.montecarlo.blocks import Device, check_device
from lostmotion.propagation.montecarlo.stopping import MOST_POSES, MOST_ROBOTS, Tolerance

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    import xarray

    from lostmotion.analyses.accuracy.route import FoundInZone
    from lostmotion.analyses.arguments import Approach, Zone
    from lostmotion.error_model.budget import Budget, Halving
    from lostmotion.error_model.pose_selection import InZone
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.analytic import Analytic, Pooled
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.spatial import Floats


class Settings(TypedDict, total=False):
    """What a study may be told besides its counts: see `study`."""

    pose_law: PoseLaw
    approach: Approach
    zone: Zone | Sequence[Zone] | None
    until: float | str | None
    most_robots: int
    threads: int | None
    tile: int
    device: Device
    progress: Callable[[str, int, int], None] | None


@overload
def study(
    arm: Arm,
    poses: int | Floats | Poses = ...,
    robots: int = ...,
    visits: int = ...,
    seed: int = ...,
    *,
    method: Literal["montecarlo", "both"] = "montecarlo",
    **more: Unpack[Settings],
) -> Study: ...


@overload
def study(
    arm: Arm,
    poses: int | Floats | Poses = ...,
    robots: int = ...,
    visits: int = ...,
    seed: int = ...,
    *,
    method: Literal["analytic"],
    **more: Unpack[Settings],
) -> AnalyticStudy: ...


@overload
def study(
    arm: Arm,
    poses: int | Floats | Poses = ...,
    robots: int = ...,
    visits: int = ...,
    seed: int = ...,
    *,
    method: Method,
    **more: Unpack[Settings],
) -> Study | AnalyticStudy: ...


def study(  # noqa: PLR0913 - a study is these numbers
    arm: Arm,
    poses: int | Floats | Poses = DEFAULT_POSES,
    robots: int = DEFAULT_ROBOTS,
    visits: int = DEFAULT_VISITS,
    seed: int = 1,
    *,
    pose_law: PoseLaw = "sobol",
    approach: Approach = "random",
    method: Method = "montecarlo",
    zone: Zone | Sequence[Zone] | None = None,
    until: float | str | None = None,
    most_robots: int = MOST_ROBOTS,
    threads: int | None = None,
    tile: int = 1,
    device: Device = "cpu",
    progress: Callable[[str, int, int], None] | None = None,
) -> Study | AnalyticStudy:
    """How accurate is this arm before it is built, where in its workspace, and which part is to blame?

    poses     how many to choose by `pose_law` within the joint limits, or an array q (pose, joint) in rad and m
    robots    how many are built; each is drawn once and visits every pose
    visits    how often each returns to each pose (ISO 9283 asks for 30)
    seed      same seed, same bits, whatever the threads
    approach  how every joint's last motion before it stops goes: "up", "down", or "random", either way from visit to visit
    method    "montecarlo": samples; "analytic": sums over terms and quadrature, no robots or visits drawn; gives an `AnalyticStudy`;
              "both": all of the first, the figures of the second, and how far the two differ
    zone      the same figures, and who is to blame, in a zone as well, or in each of several: "x 0.2..0.5 m, z 0..300 mm" in the base's axes, ends
              in m, {"x": (0.2, 0.5)}, or which of the poses are in it (pose,). By the same robots, at as many poses of the same law in the zone
              as in the workspace; of poses that are given or gridded, those in the zone
    until     how sure mean, 95 % error, AP and RP are to be: 0.01 or "1 %", half of each 95 % interval as a share of the figure, or "2 digits".
              Begins with `poses` and `robots` and takes more, poses only where it chooses them, in two stages or a few; says whether that was
              reached. With a zone, watches the figures over the workspace and those in the zone, each in stages of their own
    most_robots  how many are built at most, with `until`
    threads   left out: one per processor
    device    "gpu": the samples are formed by JAX on its graphics processor, with the same draws; the same figures but for rounding

    Raises InputError (a ValueError) for counts out of range, an unknown law, approach or device, a zone that no pose reaches, and for q of another
    shape or not finite, and for an arm of which no error source is described; LostmotionError for a GPU where JAX or the GPU is missing.
    """
    arm, sign, seed = an_arm(arm), sign_of(approach), whole_seed(seed)
    if method not in METHODS:
        raise refuse_argument("method", method, "one of " + ", ".join(METHODS), 'method = "both"')
    tolerance = None if until is None else Tolerance.of(until)
    if tolerance is not None and method == "analytic":
        raise refuse_argument("until", until, "a method that draws robots: without sampling there are none", 'method = "both"')
    if device != "cpu" and method == "analytic":
        raise refuse_argument("device", device, '"cpu": without sampling there is nothing for a GPU to do', 'device = "cpu"')
    check_device(device)
    refuse_undescribed(arm)
    chosen = chosen_poses(arm, poses, pose_law, seed)
    route = Route(method, robots, visits, seed, most_robots, tolerance, sign, threads or os.cpu_count() or 1, tile, device, progress)
    drawn = pose_law if isinstance(poses, Integral) and pose_law != "grid" else None
    rooms = [_Room.of(arm, chosen, each, drawn, seed) for each in _several(zone)]  # before the work: a zone may be out of reach
    found = route.over(arm, chosen, None if drawn is None else lambda count: sample_poses(arm, count, drawn, seed))
    zones = tuple(room.looked_at(route) for room in rooms)
    if found.sampled is None:
        if found.analytic is None or found.pooled is None:
            raise ValueError("a study by no route")
        blame = budget(arm, found.poses.q, f"over {len(found.poses)} poses", approach=sign, replicates=found.poses.replicates)
        return AnalyticStudy(arm, found.poses, sign, found.analytic, found.pooled, blame, zones=zones, seed=seed, threads=route.threads)
    told = answer(arm, found.poses, found.sampled, seed, approach=sign, threads=route.threads, progress=progress)
    besides = {"analytic": found.analytic, "pooled": found.pooled, "stopping": found.stopping, "zones": zones}
    return Study(**{name: getattr(told, name) for name in Answer.__dataclass_fields__} | besides)


def _several(zone: Zone | Sequence[Zone] | None) -> list[Zone]:
    """Give the zones that are meant by none, one or several."""
    if zone is None:
        return []
    several = isinstance(zone, list | tuple) and not any(isinstance(each, bool | np.bool_) for each in zone)
    return list(zone) if several else [zone]  # type: ignore[list-item]


@dataclass(frozen=True)
class _Room:
    """A zone that is to be looked at: its first poses, and where poses are drawn, from what more of them come."""

    arm: Arm
    zone: InZone
    more: Callable[[int], InZone] | None = None

    @classmethod
    def of(cls, arm: Arm, chosen: Poses, zone: Zone, law: PoseLaw | None, seed: int) -> _Room:
        """Find the poses in a zone: drawn for it where a law draws them and the zone has ends, else those among the study's own."""
        ends = zone_of(zone, of_poses=len(chosen))
        if law is None or not isinstance(ends, dict):
            return cls(arm, among(chosen, tool_points(arm, chosen.q), ends))

        def more(count: int) -> InZone:
            return poses_in_zone(arm, count, ends, seed, law)

        return cls(arm, more(len(chosen)), more)

    def looked_at(self, route: Route) -> FoundInZone:
        """Look at the zone by the study's route."""
        if self.more is None or route.tolerance is None:
            return route.within(self.arm, self.zone)
        more = self.more
        return route.within(self.arm, self.zone, lambda count: more(count).poses, len(more(MOST_POSES).poses))


class Study(Answer, Blamed, Shown):
    """A study that can be looked at: `summary()`, `report("out/")`, `arrays()`, `result()`; every attribute of `Answer` besides."""

    @property
    def sheet(self) -> Sheet:
        """Give what an engineer asks for: workspace, error, AP and RP, budget, torques, each with its interval and sample."""
        from lostmotion.analyses.accuracy.tables.study import sheet

        return sheet(self)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html, result.json and arrays.nc into the folder `out`, whole or not at all; gives the folder.

        Raises OutputExistsError where the folder exists and `force` is not set.
        """
        from lostmotion.analyses.accuracy.report import write_folder

        return write_folder(self, out, force=force)

    def arrays(self) -> xarray.Dataset:
        """Give every result per pose and per robot with its name, unit and coordinates."""
        from lostmotion.analyses.accuracy.arrays import dataset

        return dataset(self)

    def __repr__(self) -> str:
        """Tell the result in a few lines."""
        from lostmotion.analyses.accuracy.tables.study import sections
        from lostmotion.reporting.provenance import ideal_said

        wanted = {"error": 4, "iso9283": 4, "budget": 3}
        lines = [
            f"<Study of '{self.arm.name}': {len(self.poses)} poses x {self.sampled.robots} robots x {self.sampled.visits} visits, seed {self.seed}"
        ]
        for section in sections(self):
            for row in section.rows[: wanted.get(section.key, 0)]:
                interval = f"  ({row.figures[0].interval})" if row.figures[0].interval else ""
                share = f", {row.figures[1]} of the mean square" if section.key == "budget" else ""
                lines.append(f"  {row.label:32} {row.figures[0]}{interval}{share}")
        ideal = ideal_said(self.states)
        return "\n".join([*lines, *([f"  at least: {ideal}"] if ideal else [])]) + ">"


@dataclass(frozen=True, repr=False)
class AnalyticStudy(Blamed, Shown):
    """A study without sampling: `analytic` holds every pose, `pooled` all of them, `budget` who is to blame, `budgets` the same where it was asked.

    `summary()`, `report("out/")`, `arrays()`, `result()`.
    """

    arm: Arm
    poses: Poses
    approach: float
    analytic: Analytic
    pooled: Pooled
    budget: Budget
    budgets: tuple[Budget, ...] = ()
    zones: tuple[FoundInZone, ...] = ()
    seed: int = 1
    threads: int = 1

    @functools.cached_property
    def halving(self) -> Halving:
        """What would halving each part's errors, or each kind of error, take off the 95 % error over the workspace? By a second's paired samples."""
        from lostmotion.propagation.montecarlo.sensitivity import halving_at

        return halving_at(self.arm, self.poses, self.seed, approach=self.approach, threads=self.threads)

    @property
    def places(self) -> tuple[Budget, ...]:
        """Who is to blame at every pose and in every zone that was asked about?"""
        return (*self.budgets, *(zone.budget for zone in self.zones))

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.analyses.accuracy.tables.analytic import analytic_sheet

        blame = replace(self.budget, halving=self.halving)
        return analytic_sheet(self.arm, self.poses, self.analytic, self.pooled, blame, self.places, self.zones, approach=self.approach)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html, result.json and arrays.nc into the folder `out`, whole or not at all; gives the folder.

        Raises OutputExistsError where the folder exists and `force` is not set.
        """
        from lostmotion.analyses.accuracy.plots.budget import of_budget
        from lostmotion.analyses.accuracy.report import write_analytic

        return write_analytic(self.sheet, of_budget(self.budget, self.places), self.arrays(), out, force=force)

    def arrays(self) -> xarray.Dataset:
        """Give every figure per pose with its uncertainty, name, unit and coordinates."""
        from lostmotion.analyses.accuracy.arrays import analytic_dataset

        return analytic_dataset(self.arm, self.poses, self.analytic, self.zones)

    def __repr__(self) -> str:
        """Tell in a line what was studied."""
        return f"<AnalyticStudy of '{self.arm.name}': {len(self.poses)} poses; mean {self.pooled.mean.value:.4g} m>"
