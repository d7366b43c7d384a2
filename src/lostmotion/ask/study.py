"""Study an arm."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from numbers import Integral
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypedDict, Unpack, overload

from lostmotion.ask.settings import DEFAULT_POSES, DEFAULT_ROBOTS, DEFAULT_VISITS, chosen_poses, sign_of, whole_seed
from lostmotion.ask.shown import Shown
from lostmotion.errors import refuse_argument
from lostmotion.studies.answer import Answer, answer
from lostmotion.studies.budget import budget, costs, tally
from lostmotion.studies.montecarlo.montecarlo import Device, check_device, run
from lostmotion.studies.montecarlo.stopping import MOST_ROBOTS, Tolerance, run_until
from lostmotion.studies.places import in_zone, one_pose
from lostmotion.studies.poses import PoseLaw, Poses, sample_poses

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    import numpy as np
    import xarray

    from lostmotion.arm import Arm
    from lostmotion.ask.settings import Approach
    from lostmotion.figures import Sheet
    from lostmotion.spatial import Floats
    from lostmotion.studies.analytic.analytic import Analytic, Pooled
    from lostmotion.studies.budget import By, Cost
    from lostmotion.studies.montecarlo.montecarlo import Sampled

Zone: TypeAlias = "Mapping[str, tuple[float, float]] | np.ndarray"
Method = Literal["montecarlo", "analytic", "both"]
_METHODS: tuple[Method, ...] = ("montecarlo", "analytic", "both")


class Settings(TypedDict, total=False):
    """What a study may be told besides its counts: see `study`."""

    pose_law: PoseLaw
    approach: Approach
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
    method    "montecarlo": samples; "analytic": sums over terms and quadrature, milliseconds, no robots or visits drawn, gives an `AnalyticStudy`;
              "both": all of the first, the figures of the second, and how far the two differ
    until     how sure mean, 95 % error, AP and RP are to be: 0.01 or "1 %", half of each 95 % interval as a share of the figure, or "2 digits".
              Begins with `poses` and `robots` and takes more, poses only where it chooses them, in two stages or a few; says whether that was reached
    most_robots  how many are built at most, with `until`
    threads   left out: one per processor
    device    "gpu": the samples are formed by JAX on its graphics processor, with the same draws; the same figures but for rounding

    Raises InputError (a ValueError) for counts out of range, an unknown law, approach or device, and for q of another shape or not finite;
    LostmotionError for a GPU where JAX or the GPU is missing.
    """
    sign, seed = sign_of(approach), whole_seed(seed)
    if method not in _METHODS:
        raise refuse_argument("method", method, "one of " + ", ".join(_METHODS), 'method = "both"')
    tolerance = None if until is None else Tolerance.of(until)
    if tolerance is not None and method == "analytic":
        raise refuse_argument("until", until, "a method that draws robots: without sampling there are none", 'method = "both"')
    if device != "cpu" and method == "analytic":
        raise refuse_argument("device", device, '"cpu": without sampling there is nothing for a GPU to do', 'device = "cpu"')
    check_device(device)
    chosen = chosen_poses(arm, poses, pose_law, seed)
    workers = threads or os.cpu_count() or 1
    common: dict[str, Any] = {"approach": sign, "threads": workers, "progress": progress}
    besides: dict[str, Any] = {}
    sampled: Sampled | None = None
    if tolerance is not None:
        more = (lambda count: sample_poses(arm, count, pose_law, seed)) if isinstance(poses, Integral) and pose_law != "grid" else None
        chosen, sampled, besides["stopping"] = run_until(
            arm, chosen, robots, visits, seed, tolerance, most_robots=most_robots, more=more, tile=tile, device=device, **common
        )
        robots = sampled.robots
    elif method != "analytic":
        sampled = run(arm, chosen, robots, visits, seed, tile=tile, device=device, **common)
    if method != "montecarlo":
        from lostmotion.studies.analytic.analytic import analytic, pooled

        every = analytic(arm, chosen, **common)
        besides |= {"analytic": every, "pooled": pooled(every, chosen.replicates, workers)}
        if method == "analytic":
            return AnalyticStudy(arm, chosen, **besides)
    found = answer(arm, chosen, robots=robots, visits=visits, seed=seed, tile=tile, sampled=sampled, **common)
    return Study(**{name: getattr(found, name) for name in Answer.__dataclass_fields__} | besides)


class Study(Answer, Shown):
    """A study that can be looked at: `summary()`, `report("out/")`, `arrays()`, `result()`; every attribute of `Answer` besides."""

    @property
    def sheet(self) -> Sheet:
        """Give what an engineer asks for: workspace, error, AP and RP, budget, torques, each with its interval and sample."""
        from lostmotion.figures.arm import sheet

        return sheet(self)

    def costs(self, by: By = "part", *, pose: int | Floats | None = None, zone: Zone | None = None) -> list[Cost]:
        """Which part, cause, level or term costs how much, the dearest first: over all poses, at one of them, or in a zone? Exact, no sampling.

        pose  its number in the study, or joint values (joint,) in rad and m
        zone  ends along the base's axes in m, {"x": (0.2, 0.5)}, or which poses are in it (pose,)

        Shares add to one. Raises InputError for a pose that there is not or a zone that no pose reaches.
        """
        q, _ = self._where(pose, zone)
        return costs(tally(self.arm, q, by, approach=self.approach))

    def blaming(self, *, pose: int | Floats | None = None, zone: Zone | None = None) -> Study:
        """Give the same study that also says who is to blame at a pose or in a zone; arguments and errors as `costs`."""
        q, where = self._where(pose, zone)
        found = budget(self.arm, q, where, approach=self.approach)
        return replace(self, budgets=(*self.budgets, found))

    def _where(self, pose: int | Floats | None, zone: Zone | None) -> tuple[Floats, str]:
        if pose is not None and zone is not None:
            raise refuse_argument("pose, zone", "both", "one of them, or none for all poses", "pose = 0")
        if pose is not None:
            q, name = one_pose(self.poses.q, pose)
            from lostmotion.figures.arm import joint_values

            return q, f"{name}, {joint_values(self, q[0])}"
        if zone is not None:
            mask, name = in_zone(self.tool, zone)
            return self.poses.q[mask], f"{name}, {int(mask.sum())} of {len(mask)} poses"
        return self.poses.q, f"over {len(self.poses)} poses"

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html, result.json and arrays.nc into the folder `out`, whole or not at all; gives the folder.

        Raises OutputExistsError where the folder exists and `force` is not set.
        """
        from lostmotion.report.arm import write_folder

        return write_folder(self, out, force=force)

    def arrays(self) -> xarray.Dataset:
        """Give every result per pose and per robot with its name, unit and coordinates."""
        from lostmotion.arrays import dataset

        return dataset(self)

    def __repr__(self) -> str:
        """Tell the result in a few lines."""
        from lostmotion.figures.arm import sections

        wanted = {"error": 4, "iso9283": 4, "budget": 3}
        lines = [
            f"<Study of '{self.arm.name}': {len(self.poses)} poses x {self.sampled.robots} robots x {self.sampled.visits} visits, seed {self.seed}"
        ]
        for section in sections(self):
            for row in section.rows[: wanted.get(section.key, 0)]:
                interval = f"  ({row.figures[0].interval})" if row.figures[0].interval else ""
                share = f", {row.figures[1]} of the mean square" if section.key == "budget" else ""
                lines.append(f"  {row.label:32} {row.figures[0]}{interval}{share}")
        return "\n".join(lines) + ">"


@dataclass(frozen=True, repr=False)
class AnalyticStudy(Shown):
    """A study without sampling: `analytic` holds every pose, `pooled` all of them; `summary()`, `report("out/")`, `result()`."""

    arm: Arm
    poses: Poses
    analytic: Analytic
    pooled: Pooled

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.figures.analytic import analytic_sheet

        return analytic_sheet(self.arm, self.poses, self.analytic, self.pooled)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html and result.json into the folder `out`, whole or not at all; gives the folder.

        Raises OutputExistsError where the folder exists and `force` is not set.
        """
        from lostmotion.report.folder import write_whole
        from lostmotion.report.page import contents

        return write_whole(contents(self.sheet, ()), out, force=force)

    def __repr__(self) -> str:
        """Tell in a line what was studied."""
        return f"<AnalyticStudy of '{self.arm.name}': {len(self.poses)} poses; mean {self.pooled.mean.value:.4g} m>"
