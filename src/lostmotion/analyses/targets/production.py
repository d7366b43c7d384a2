"""Production yield of an arm or a study."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.analyses.accuracy.answer import Answer
from lostmotion.analyses.arguments import DEFAULT_ROBOTS, DEFAULT_VISITS, arm_of, chosen_poses, poses_of
from lostmotion.analyses.quantities import amounts
from lostmotion.analyses.targets.limits import LENGTH, SHARE
from lostmotion.analyses.targets.yield_ import production_of
from lostmotion.error_model.provenance import refuse_undescribed
from lostmotion.propagation.first_order import refuse_large_errors

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.quantities import Amount
    from lostmotion.analyses.targets.yield_ import Judged, Yield
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


def production_yield(  # noqa: PLR0913 - a production is these numbers
    subject: Arm | str | Path | Answer,
    target: Amount,
    *,
    judged: Judged = "error",
    share: Amount = 0.95,
    poses: int | str | Path | Floats | Poses = 1024,
    robots: int = DEFAULT_ROBOTS,
    visits: int = DEFAULT_VISITS,
    seed: int = 1,
) -> Yield:
    """Return the share of manufactured robots that meet a target, with an exact interval that counts robots.

    Parameters
    ----------
    subject
        An arm, its file, or a study of one: then the study's poses, robots, visits, seed and approach count, and none of those here.
    target
        "0.5 mm", or a number in m.
    judged
        What each robot is judged by: "error", which `share` of its own positions do not exceed; "worst accuracy", its AP at its worst pose;
        "repeatability", its RP averaged over the poses; "worst repeatability", its RP at its worst pose.
    share
        Share of a robot's positions.
    poses, robots, visits, seed
        As in `study`.

    Returns
    -------
    Yield
        `share`, `interval`, and `curve()` of the yield against the target.

    Raises
    ------
    InputError
        For arguments that cannot be used.

    """
    read = amounts({"target": target, "share": share}, {"target": LENGTH, "share": SHARE}, needed=True)
    value, of = read["target"], read["share"]
    if not isinstance(subject, Answer):
        arm = arm_of("subject", subject, {})
        refuse_undescribed(arm)
        refuse_large_errors(arm)
        chosen = chosen_poses(arm, poses_of("poses", poses, {"arm": arm}), "sobol", seed)
        return production_of(arm, chosen, value, judged=judged, share=of, robots=robots, visits=visits, seed=seed)
    built = subject.sampled
    return production_of(
        subject.arm,
        subject.poses,
        value,
        judged=judged,
        share=of,
        robots=built.robots,
        visits=built.visits,
        seed=subject.seed,
        approach=subject.approach,
    )
