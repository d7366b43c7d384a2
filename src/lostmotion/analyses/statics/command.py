"""Ask what every joint carries and how compliant the arm is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from lostmotion.analyses.arguments import (
    ArmArgument,
    PoseLawArgument,
    PosesArgument,
    ReadyArgument,
    ReducersArgument,
    SeedArgument,
    SidecarArgument,
    chosen_poses,
    reducers_beside,
)
from lostmotion.analyses.quantities import Amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.analyses.statics.result import Statics


@question(folder="statics")
def statics(
    arm: ArmArgument,
    *,
    tilt: Annotated[
        Amount | None,
        Argument("Tilt of the base from level, towards any side, '10 deg'.", Quantity("rad", "10 deg", low=0, high=math.pi)),
    ] = None,
    poses: PosesArgument = 4096,
    pose_law: PoseLawArgument = "sobol",
    seed: SeedArgument = 1,
    reducers: ReducersArgument = (),
    sidecar: SidecarArgument = None,
    ready: ReadyArgument = None,
) -> Statics:
    """Report what every joint carries, which reducers are rated for it, and the arm's compliance: where, in which direction, by which part.

    Raises
    ------
    InputError
        With every mistake in the arguments and files.

    """
    asked = read_arguments(statics, locals())
    asked.ready()
    from lostmotion.analyses.statics.result import Statics
    from lostmotion.analyses.statics.survey import survey

    found = survey(asked.arm, chosen_poses(asked.arm, asked.poses, asked.pose_law, asked.seed), asked.tilt)
    return Statics(**vars(found), reducers=reducers_beside(arm, asked.reducers))
