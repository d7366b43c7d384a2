"""The method of a study: by samples, by sums over terms, or by both; over the workspace and in
zones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from lostmotion.error_model.budget import Budget, budget
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.propagation.montecarlo.repeatability import both_repeatabilities
from lostmotion.propagation.montecarlo.sensitivity import halving_at
from lostmotion.propagation.montecarlo.stopping import run_until

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.accuracy import Method
    from lostmotion.error_model.pose_selection import InZone
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.analytic import Analytic
    from lostmotion.propagation.montecarlo.blocks import Device
    from lostmotion.propagation.montecarlo.montecarlo import Sampled
    from lostmotion.propagation.montecarlo.repeatability import Repeatability
    from lostmotion.propagation.montecarlo.stopping import Stopping, Tolerance
    from lostmotion.propagation.pooled import Pooled


@dataclass(frozen=True)
class Found:
    """What a route finds over these poses; None what it does not ask."""

    poses: Poses
    sampled: Sampled | None = None
    analytic: Analytic | None = None
    pooled: Pooled | None = None
    stopping: Stopping | None = None


@dataclass(frozen=True, kw_only=True)
class FoundInZone(Found):
    """The same in a zone, with its error budget. name: its name; tried: number of poses among which
    those in it were found; repeats as `Answer`.
    """

    name: str
    tried: int
    budget: Budget
    repeats: tuple[Repeatability, ...] = ()


@dataclass(frozen=True)
class Route:
    """The method, the robots, and, with a tolerance, the precision asked for. Other fields as
    `montecarlo.run`, `run_until`.
    """

    method: Method
    robots: int
    visits: int
    seed: int
    most_robots: int
    tolerance: Tolerance | None = None
    approach: float = 0.0
    threads: int = 1
    tile: int = 1
    device: Device = "cpu"
    progress: Callable[[str, int, int], None] | None = None

    def over(
        self,
        arm: Arm,
        poses: Poses,
        more: Callable[[int], Poses] | None = None,
        most_poses: int | None = None,
        prefix: str = "",
    ) -> Found:
        """Return the errors over these poses. `more` and `most_poses` as `run_until`; `prefix`
        precedes the text of `progress`.
        """
        progress = self.progress
        if progress is not None and prefix:
            report = progress

            def progress(what: str, done: int, of: int) -> None:
                report(f"{prefix}: {what}", done, of)

        sampled, stopping, every, pool = None, None, None, None
        if self.tolerance is not None:
            poses, sampled, stopping = run_until(
                arm,
                poses,
                self.robots,
                self.visits,
                self.seed,
                self.tolerance,
                most_robots=self.most_robots,
                more=more,
                most_poses=most_poses,
                approach=self.approach,
                threads=self.threads,
                tile=self.tile,
                device=self.device,
                progress=progress,
            )
        elif self.method != "analytic":
            sampled = run(
                arm,
                poses,
                self.robots,
                self.visits,
                self.seed,
                approach=self.approach,
                threads=self.threads,
                tile=self.tile,
                device=self.device,
                progress=progress,
            )
        if self.method != "montecarlo":
            from lostmotion.propagation.analytic import analytic
            from lostmotion.propagation.pooled import pooled

            every = analytic(
                arm, poses, approach=self.approach, threads=self.threads, progress=progress
            )
            pool = pooled(arm, poses, every, approach=self.approach, threads=self.threads)
        return Found(poses, sampled, every, pool, stopping)

    def within(
        self,
        arm: Arm,
        zone: InZone,
        more: Callable[[int], Poses] | None = None,
        most_poses: int | None = None,
    ) -> FoundInZone:
        """Return errors and error budget in a zone, of the same robots, over the zone's poses."""
        found = self.over(arm, zone.poses, more, most_poses, zone.name)
        where = f"{zone.name}, {len(found.poses)} pose{'s' if len(found.poses) > 1 else ''}"
        blame = budget(
            arm, found.poses.q, where, approach=self.approach, replicates=found.poses.replicates
        )
        gains = halving_at(
            arm, found.poses, self.seed, approach=self.approach, threads=self.threads
        )
        repeats: tuple[Repeatability, ...] = ()
        if found.sampled is not None:
            repeats = both_repeatabilities(
                arm,
                found.poses,
                found.sampled,
                blame,
                self.seed,
                approach=self.approach,
                threads=self.threads,
            )
        return FoundInZone(
            **vars(found),
            name=zone.name,
            tried=zone.tried,
            budget=replace(blame, halving=gains),
            repeats=repeats,
        )
