"""Allowances for the parts of an arm that meet a target on the tool: for one item at a time, and
allocated to all items together; and the production yield of an arm or a study.

Each item of `error_model.items` has a factor on its terms. Bias is linear in them and variance
quadratic, so the mean square error is a quadratic form from which allocations of equal effect
follow exactly. Error quantiles and RP are solved for the factor numerically (`factor_metrics`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.accuracy.answer import Answer
from lostmotion.analyses.arguments import (
    DEFAULT_ROBOTS,
    DEFAULT_VISITS,
    arm_of,
    chosen_poses,
    poses_of,
)
from lostmotion.analyses.quantities import SHARE, TARGET, read_quantities
from lostmotion.analyses.result import Result
from lostmotion.error_model.allocation import (
    moving,
)
from lostmotion.error_model.items import Item, shared_items
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.provenance import States, refuse_undescribed, states
from lostmotion.error_model.trust import with_figures
from lostmotion.error_model.visit_scatter import refuse_without_scatter
from lostmotion.errors import refuse_argument
from lostmotion.propagation.first_order import refuse_large_errors
from lostmotion.propagation.montecarlo.blocks import BlockPlan
from lostmotion.propagation.production_yield import (
    MOST_ROBOTS,
    Yield,
    compute_yield,
)
from lostmotion.sizing.allowances import Allocation, Allowance, Kind, Solver

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from lostmotion.analyses.quantities import Amount
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.production_yield import Criterion
    from lostmotion.spatial import Floats

MOST_POSES: Final = 16_384
# Largest pose matrix, poses x terms, of 100 bytes each.
_MOST_CELLS: Final = 8_000_000


@dataclass(frozen=True, repr=False)
class Target(Result):
    """What a target requires of an arm's parts: allowances and allocations that meet it.

    zone                name of the poses' part of the workspace; empty for all of it
    kind                "error" (m, quantile `share` over positions) or "repeatability" (m, quantile
                        `share` over robots of RP)
    robots, visits      of the Monte Carlo study; `verified_visits` of the one that verifies
                        allowances
    solved_poses, solved_samples  of the solution; for repeatability the samples are robots x visits
                                  x poses
    current             error or RP of the arm as stated, m, by Monte Carlo
    current_by_solver   the same from the samples that the allowances were solved with
    allowances          one item at a time
    shared_allowances   one cause at a time, in all parts of a kind
    form                (item, item) m^2: factors @ form @ factors is the mean square
    equal_factor, equal_effect  allocations to all items; None where none exists
    yields              of the arm as stated, by two criteria
    """

    arm: Arm
    poses: Poses
    zone: str
    seed: int
    approach: float
    kind: Kind
    target: float
    share: float
    robots: int
    visits: int
    verified_visits: int
    solved_poses: int
    solved_samples: int
    current: Estimate
    current_by_solver: Estimate
    items: tuple[Item, ...]
    allowances: tuple[Allowance, ...]
    shared_allowances: tuple[Allowance, ...]
    form: Floats
    equal_factor: Allocation | None
    equal_effect: Allocation | None
    yields: tuple[Yield, ...]

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values."""
        return states(self.arm)


def targets(  # noqa: PLR0913 - arguments of a target
    arm: Arm,
    poses: Poses,
    kind: Kind,
    target: float,
    *,
    share: float = 0.95,
    robots: int = 1000,
    visits: int = 30,
    seed: int = 1,
    approach: float = 0.0,
    threads: int = 1,
    zone: str = "",
    progress: Callable[[str, int, int], None] | None = None,
) -> Target:
    """Return the allowances with which a share of all positions, or of the robots, is within the
    target (m).

    kind     "error": position error over all robots, poses and visits; "repeatability": RP of each
             robot, averaged over the poses, of joints that arrive as `approach` states: ISO cycle
             or any approach
    robots, visits, seed, approach, threads, progress  of the Monte Carlo study that verifies, as
                                                       for `montecarlo.run`
    zone     name of the poses' part of the workspace; empty for all of it

    First order in the errors, at constant loads and masses. Raises InputError for numbers out of
    range, and for a repeatability of an arm without any error that differs between visits.
    """
    if not 1 <= len(poses) <= MOST_POSES:
        raise refuse_argument("poses", len(poses), f"from 1 to {MOST_POSES}", poses=1024)
    if not 20 <= robots <= MOST_ROBOTS:  # noqa: PLR2004 - 95 % of fewer is all of them
        raise refuse_argument("robots", robots, f"from 20 to {MOST_ROBOTS}", robots=1000)
    if visits < 2:  # noqa: PLR2004 - a scatter needs two
        raise refuse_argument("visits", visits, "at least 2", visits=30)
    if kind == "repeatability":
        refuse_without_scatter(arm, poses.q, approach)
    plan = BlockPlan.of(arm, poses, robots, visits, seed, approach)
    matrix = pose_matrix(arm, poses.q, approach=approach)
    if len(poses) * len(matrix.infos) > _MOST_CELLS:
        most = _MOST_CELLS // len(matrix.infos)
        raise refuse_argument(
            "poses",
            len(poses),
            f"at most {most} with the {len(matrix.infos)} terms of this arm",
            poses=most // 2,
        )
    solver = Solver(plan, matrix, kind, target, share, threads, progress or (lambda *_: None))
    ones = np.ones(len(matrix.infos))
    allowances = solver.allowances((*solver.items, *shared_items(solver.items)))
    return Target(
        arm=arm,
        poses=poses,
        zone=zone,
        seed=seed,
        approach=approach,
        kind=kind,
        target=target,
        share=share,
        robots=robots,
        visits=visits,
        verified_visits=solver.verification.visits,
        solved_poses=solver.metric.poses,
        solved_samples=solver.metric.samples,
        current=solver.verified(ones),
        current_by_solver=solver.current,
        items=solver.items,
        allowances=tuple(allowances[: len(solver.items)]),
        shared_allowances=tuple(allowances[len(solver.items) :]),
        form=solver.form,
        equal_factor=solver.scaled(np.where(moving(solver.form), 1.0, np.nan)),
        equal_effect=solver.equal_effect(),
        yields=solver.yields(ones),
    )


def production_yield(  # noqa: PLR0913 - arguments of a production
    subject: Arm | str | Path | Answer,
    target: Amount,
    *,
    criterion: Criterion = "error",
    share: Amount = 0.95,
    poses: int | str | Path | Floats | Poses = 1024,
    robots: int = DEFAULT_ROBOTS,
    visits: int = DEFAULT_VISITS,
    seed: int = 1,
) -> Yield:
    """Return the share of simulated robots that meet a target, with an exact interval that counts
    robots.

    Parameters
    ----------
    subject
        An arm, its file, or a study of one: then the study's poses, robots, visits, seed and
        approach are used instead of these.
    target
        "0.5 mm", or a number in m.
    criterion
        Figure of each robot that is compared with the target: "error", the quantile `share` of its
        position error; "worst accuracy", AP at its worst pose; "repeatability", RP averaged over
        the poses; "worst repeatability", RP at its worst pose.
    share
        Share of a robot's positions.
    poses
        How many poses each robot visits, a CSV file of poses, or joint values, as in `study`.
    robots
        How many manufactured robots are simulated.
    visits
        How often each robot visits each pose.
    seed
        Seed of the random draws: same seed, same result.

    Returns
    -------
    Yield
        `share`, `interval`, and `curve()` of the yield against the target.

    Raises
    ------
    InputError
        For arguments that cannot be used.

    """
    read = read_quantities(
        {"target": target, "share": share}, {"target": TARGET, "share": SHARE}, needed=True
    )
    value, of = read["target"], read["share"]
    if not isinstance(subject, Answer):
        arm = arm_of("subject", subject, {})
        refuse_undescribed(arm)
        refuse_large_errors(arm)
        chosen = chosen_poses(arm, poses_of("poses", poses, {"arm": arm}), "sobol", seed)
        chosen = with_figures(arm, chosen)
        return compute_yield(
            arm,
            chosen,
            value,
            criterion=criterion,
            share=of,
            robots=robots,
            visits=visits,
            seed=seed,
        )
    study = subject.sampled
    return compute_yield(
        subject.arm,
        subject.poses,
        value,
        criterion=criterion,
        share=of,
        robots=study.robots,
        visits=study.visits,
        seed=subject.seed,
        approach=subject.approach,
    )
