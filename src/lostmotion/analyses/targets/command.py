"""Ask what a target requires of an arm's parts."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Annotated

from lostmotion.analyses.arguments import (
    DEFAULT_ROBOTS,
    DEFAULT_VISITS,
    ApproachArgument,
    ArmArgument,
    PoseLawArgument,
    PosesArgument,
    ProgressArgument,
    ReadyArgument,
    RobotsArgument,
    SeedArgument,
    SidecarArgument,
    ThreadsArgument,
    VisitsArgument,
    chosen_poses,
    zone_of,
)
from lostmotion.analyses.quantities import Amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.analyses.targets.limits import LENGTH, SHARE
from lostmotion.errors import Mistakes, refuse_argument

if TYPE_CHECKING:
    from lostmotion.analyses.arguments import Ends
    from lostmotion.analyses.targets.result import Target


def _one_of_two(error: Amount | None, repeatability: Amount | None) -> None:
    if (error is None) == (repeatability is None):
        stated = "neither" if error is None else "both"
        raise refuse_argument("error, repeatability", stated, "one of the two", error=LENGTH.example)


@question(folder="target")
def target(
    arm: ArmArgument,
    *,
    error: Annotated[
        Amount | None, Argument("Target: `share` of all positions over the workspace have at most this error, '0.5 mm'.", LENGTH)
    ] = None,
    repeatability: Annotated[
        Amount | None, Argument("Target instead: `share` of the robots have at most this RP, averaged over the poses, '0.1 mm'.", LENGTH)
    ] = None,
    share: Annotated[Amount, Argument("Share of positions, or of robots, 50 % to 99.9 %.", SHARE)] = 0.95,
    poses: PosesArgument = 1024,
    pose_law: PoseLawArgument = "sobol",
    zone: Annotated[
        "Ends | None",
        Argument("Only poses with the tool in this zone, in the base's axes: 'x 0.2..0.5 m, z 0..300 mm'.", zone_of, metavar="ZONE"),
    ] = None,
    robots: RobotsArgument = DEFAULT_ROBOTS,
    visits: VisitsArgument = DEFAULT_VISITS,
    seed: SeedArgument = 1,
    approach: ApproachArgument = "random",
    sidecar: SidecarArgument = None,
    threads: ThreadsArgument = None,
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> Target:
    """Allocate a target on the tool to all parts: allowances for one error at a time and for all together, and the production yield.

    Every answer is verified by a Monte Carlo run with `robots` and `visits`.

    Raises
    ------
    InputError
        With every mistake in the arguments and the arm's file.

    """
    with Mistakes() as mistakes:
        mistakes.of(_one_of_two, error, repeatability)
        asked = mistakes.of(read_arguments, target, locals())
    from lostmotion.analyses.targets.result import Target
    from lostmotion.analyses.targets.targets import targets
    from lostmotion.error_model.pose_selection import poses_in_zone
    from lostmotion.error_model.provenance import refuse_undescribed
    from lostmotion.propagation.first_order import refuse_large_errors

    if asked.zone is not None and not isinstance(asked.poses, int):
        raise refuse_argument("zone", "with poses that are given", "a zone, or poses", zone="x 0.2..0.5 m")
    refuse_undescribed(asked.arm)
    refuse_large_errors(asked.arm)
    asked.ready()
    chosen, name = chosen_poses(asked.arm, asked.poses, asked.pose_law, asked.seed), ""
    if asked.zone is not None:
        inside = poses_in_zone(asked.arm, len(chosen), asked.zone, asked.seed, asked.pose_law)
        chosen, name = inside.poses, inside.name
    found = targets(
        asked.arm,
        chosen,
        "error" if asked.repeatability is None else "repeatability",
        asked.error if asked.repeatability is None else asked.repeatability,
        share=asked.share,
        robots=asked.robots,
        visits=asked.visits,
        seed=asked.seed,
        approach=asked.approach,
        threads=asked.threads or os.cpu_count() or 1,
        zone=name,
        progress=progress,
    )
    return Target(**vars(found))
