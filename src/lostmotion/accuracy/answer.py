"""One study of one arm, whole: workspace, errors, budget, torques, checks."""

from __future__ import annotations

import functools
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.accuracy.workspace import Workspace, workspace
from lostmotion.error_model.budget import Budget, Halving, budget
from lostmotion.error_model.few_poses import many_poses
from lostmotion.error_model.poses import POSE_LAWS
from lostmotion.mechanism.holding_torques import HoldingTorque, holding_torques
from lostmotion.mechanism.load_causes import LinkBending, bending
from lostmotion.mechanism.state import tool_points
from lostmotion.propagation.error_samples import Drawn, VisitFigures
from lostmotion.propagation.figures import estimates
from lostmotion.propagation.montecarlo.bands import bands
from lostmotion.propagation.montecarlo.repeatability import both_repeatabilities
from lostmotion.propagation.montecarlo.sensitivity import halving
from lostmotion.propagation.montecarlo.waterfall import Waterfall, waterfall

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.accuracy.drive_classes import ClassFigures
    from lostmotion.accuracy.route import FoundInZone
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.analytic import Analytic
    from lostmotion.propagation.montecarlo.bands import Bands
    from lostmotion.propagation.montecarlo.montecarlo import Sampled
    from lostmotion.propagation.montecarlo.repeatability import Repeatability
    from lostmotion.propagation.montecarlo.stopping import Stopping
    from lostmotion.propagation.pooled import Pooled
    from lostmotion.spatial import Floats


@dataclass(frozen=True, repr=False)
class Answer:
    """Everything that a study found, in SI and without a word of text.

    tool (pose, 3) m where each pose puts the tool, torques (pose, joint) what each drive holds
    there. analytic, pooled: the same error without sampling, at each pose and over all, where it
    was asked for. stopping: how it came to so many robots and poses, where it was to say when to
    stop. budget: error budget over all poses, by kind of error too; budgets: the same at stated
    poses and in zones.
    zones: the errors in zones that were asked about, over poses of their own. threads: how many
    there were, for questions still to come. repeats: RP of joints that arrive in the standard's
    cycle, then of joints that arrive from either side; empty for a single visit.
    bands: the same over values that are only known to lie in a range; None where all are known.
    target: largest acceptable error, m, where one was stated. classes: figures by class of drive,
    where all drives are assumed from classes.
    """

    arm: Arm
    poses: Poses
    seed: int
    approach: float
    sampled: Sampled
    tool: Floats
    torques: Floats
    worst_torques: list[HoldingTorque]
    bending: list[LinkBending]
    workspace: Workspace
    halving: Halving
    waterfall: Waterfall
    budget: Budget
    repeats: tuple[Repeatability, ...] = ()
    analytic: Analytic | None = None
    pooled: Pooled | None = None
    stopping: Stopping | None = None
    budgets: tuple[Budget, ...] = ()
    zones: tuple[FoundInZone, ...] = ()
    threads: int = 1
    bands: Bands | None = None
    target: float | None = None
    classes: tuple[ClassFigures, ...] = ()

    @functools.cached_property
    def errors(self) -> Drawn:
        """Return what the figures of the error are estimated from."""
        repeats = {
            each.approach: VisitFigures(each.robot_means, each.per_pose[:, 0], each.budget.squares)
            for each in self.repeats
        }
        return Drawn.of(self.sampled, self.budget.squares, repeats=repeats)

    @functools.cached_property
    def figures(self) -> dict[str, Estimate]:
        """Return every figure of the error by key, in SI with its interval; `rp` and `ap` are those
        of 95 % of robots, RP in the cycle of ISO 9283.
        """
        return estimates(self.errors)

    @property
    def places(self) -> tuple[Budget, ...]:
        """Return the error budgets at every stated pose and in every zone."""
        return (*self.budgets, *(zone.budget for zone in self.zones))


def answer(
    arm: Arm,
    poses: Poses,
    sampled: Sampled,
    seed: int,
    *,
    approach: float = 0.0,
    threads: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Answer:
    """Return the accuracy, workspace, static torques and error budget of this arm over these poses.

    `sampled` is what `montecarlo.run` found at these poses; other arguments as there. The workspace
    is sampled more densely by the same law of poses (Sobol where they were given).
    """
    robots, visits = sampled.robots, sampled.visits
    law = poses.law if poses.law in POSE_LAWS and poses.law != "grid" else "sobol"
    # beside the rest, which needs nothing of it
    beside = ThreadPoolExecutor(1)
    space = beside.submit(workspace, arm, law, seed=seed)
    beside.shutdown(wait=False)
    torques, worst = holding_torques(arm, poses.q)
    bent = bending(arm, poses.q, sampled.bias[:, 3:], sampled.tally.total / sampled.tally.poses)
    gains = halving(
        arm, poses, robots, visits, seed, approach=approach, threads=threads, progress=progress
    )
    remedies = waterfall(
        arm, poses, robots, visits, seed, approach=approach, threads=threads, progress=progress
    )
    open_to = bands(
        arm, poses, robots, visits, seed, approach=approach, threads=threads, progress=progress
    )
    many = many_poses(arm, poses)
    blame = budget(
        arm,
        poses.q,
        f"over {len(poses)} pose{'s' if len(poses) > 1 else ''}",
        approach=approach,
        replicates=poses.replicates,
        many=many,
    )
    repeats = both_repeatabilities(
        arm,
        poses,
        sampled,
        blame,
        seed,
        approach=approach,
        many=many,
        threads=threads,
        progress=progress,
    )
    tool = tool_points(arm, poses.q)
    return Answer(
        arm,
        poses,
        seed,
        approach,
        sampled,
        tool,
        torques,
        worst,
        bent,
        space.result(),
        gains,
        remedies,
        blame,
        repeats,
        threads=threads,
        bands=open_to,
    )
