"""Ask what a target requires of an arm's parts."""

from __future__ import annotations

import os
from functools import partial
from typing import TYPE_CHECKING, Annotated

from lostmotion.analyses.arguments import (
    DEFAULT_ROBOTS,
    DEFAULT_VISITS,
    ApproachArgument,
    ArmArgument,
    CalibrationArgument,
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
from lostmotion.analyses.quantities import SHARE, TARGET, Amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import Mistakes, refuse_argument

if TYPE_CHECKING:
    from lostmotion.analyses.arguments import Ends
    from lostmotion.analyses.targets.targets import Target


def _one_of(**targets: Amount | None) -> None:
    """Raise InputError unless exactly one target is stated."""
    stated = [name for name, value in targets.items() if value is not None]
    if len(stated) != 1:
        raise refuse_argument(
            "error, rp_iso, rp_any",
            " and ".join(stated) or "none of them",
            "one of them",
            error=TARGET.example,
        )


def _arriving(approach: float, *, rp_iso: bool, rp_any: bool, repeatability: bool) -> float:
    """Return how joints arrive for a target on RP: `approach`, or what the target's name requires
    where that is not stated.

    Raises InputError where the two contradict each other, and for `repeatability` without a stated
    side, which does not say which RP is meant.
    """
    if rp_any and approach:
        raise refuse_argument(
            "approach",
            "one side, with rp_any",
            '"random" with rp_any, or rp_iso',
            approach="random",
        )
    if repeatability and not approach:
        expected = (
            "rp_iso (joints arrive from one side, as in ISO 9283) or rp_any (from either side at "
            "random)"
        )
        raise refuse_argument(
            "repeatability", "joints that arrive from either side", expected, rp_iso="0.1 mm"
        )
    return approach or (1.0 if rp_iso else 0.0)


@question(folder="target")
def target(
    arm: ArmArgument,
    *,
    error: Annotated[
        Amount | None,
        Argument(
            (
                "Target: `share` of all positions over the workspace have at most this error, "
                "'0.5 mm'."
            ),
            TARGET,
        ),
    ] = None,
    repeatability: Annotated[
        Amount | None,
        Argument("Former name of `rp_iso`, with an `approach` of up or down.", TARGET),
    ] = None,
    rp_iso: Annotated[
        Amount | None,
        Argument(
            "Target instead: `share` of the robots have at most this RP in the ISO cycle "
            "(every joint arrives from one side), averaged over the "
            "poses, '0.1 mm'.",
            TARGET,
        ),
    ] = None,
    rp_any: Annotated[
        Amount | None,
        Argument(
            (
                "Target instead: the same RP of any approach: joints arrive from either side at "
                "random, '0.1 mm'."
            ),
            TARGET,
        ),
    ] = None,
    share: Annotated[
        Amount, Argument("Share of positions, or of robots, 50 % to 99.9 %.", SHARE)
    ] = 0.95,
    poses: PosesArgument = 1024,
    pose_law: PoseLawArgument = "sobol",
    zone: Annotated[
        "Ends | None",
        Argument(
            (
                "Only poses with the tool in this zone, in the base's axes: 'x 0.2..0.5 m, z "
                "0..300 mm'."
            ),
            zone_of,
            metavar="ZONE",
        ),
    ] = None,
    robots: RobotsArgument = DEFAULT_ROBOTS,
    visits: VisitsArgument = DEFAULT_VISITS,
    seed: SeedArgument = 1,
    approach: ApproachArgument = "random",
    sidecar: SidecarArgument = None,
    calibration: CalibrationArgument = None,
    threads: ThreadsArgument = None,
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> Target:
    """Allocate a target on the tool to all parts: allowances for one error at a time and for all
    together, and the production yield.

    Every answer is verified by a Monte Carlo run with `robots` and `visits`.

    Raises
    ------
    InputError
        With every mistake in the arguments and the arm's file.

    """
    with Mistakes() as mistakes:
        mistakes.of(
            partial(_one_of, error=error, repeatability=repeatability, rp_iso=rp_iso, rp_any=rp_any)
        )
        asked = mistakes.of(read_arguments, target, locals())
    from lostmotion.analyses.targets.targets import targets
    from lostmotion.error_model.pose_selection import poses_in_zone
    from lostmotion.error_model.provenance import refuse_undescribed
    from lostmotion.error_model.trust import with_figures
    from lostmotion.propagation.first_order import refuse_large_errors

    if asked.zone is not None and not isinstance(asked.poses, int):
        raise refuse_argument(
            "zone", "with poses that are given", "a zone, or poses", zone="x 0.2..0.5 m"
        )
    of_repeats = {name: getattr(asked, name) for name in ("rp_iso", "rp_any", "repeatability")}
    arriving = _arriving(
        asked.approach, **{name: value is not None for name, value in of_repeats.items()}
    )
    repeats = next((value for value in of_repeats.values() if value is not None), None)
    refuse_undescribed(asked.arm)
    refuse_large_errors(asked.arm)
    asked.ready()
    chosen, name = chosen_poses(asked.arm, asked.poses, asked.pose_law, asked.seed), ""
    if asked.zone is not None:
        inside = poses_in_zone(asked.arm, len(chosen), asked.zone, asked.seed, asked.pose_law)
        chosen, name = inside.poses, inside.name
    chosen = with_figures(asked.arm, chosen)
    return targets(
        asked.arm,
        chosen,
        "error" if repeats is None else "repeatability",
        asked.error if repeats is None else repeats,
        share=asked.share,
        robots=asked.robots,
        visits=asked.visits,
        seed=asked.seed,
        approach=arriving,
        threads=asked.threads or os.cpu_count() or 1,
        zone=name,
        progress=progress,
    )
