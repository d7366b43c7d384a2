"""Production yield of an arm or a study."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.accuracy.answer import Answer
from lostmotion.analyses.arguments import (
    DEFAULT_ROBOTS,
    DEFAULT_VISITS,
    arm_of,
    chosen_poses,
    poses_of,
)
from lostmotion.analyses.quantities import read_quantities
from lostmotion.analyses.targets.command import LENGTH, SHARE
from lostmotion.error_model.provenance import refuse_undescribed
from lostmotion.error_model.trust import with_figures
from lostmotion.propagation.first_order import refuse_large_errors
from lostmotion.propagation.production_yield import compute_yield

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.quantities import Amount
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.production_yield import Criterion, Yield
    from lostmotion.spatial import Floats


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
        {"target": target, "share": share}, {"target": LENGTH, "share": SHARE}, needed=True
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
