"""Ask what every joint carries and how compliant the arm is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from lostmotion.analyses.arguments import (
    ArmArgument,
    CalibrationArgument,
    PoseLawArgument,
    PosesArgument,
    ReadyArgument,
    ReducersArgument,
    SeedArgument,
    SidecarArgument,
    chosen_poses,
    reducers_beside,
)
from lostmotion.analyses.quantities import TARGET, Amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.units import Quantity

# Limits of sag and accuracy.

if TYPE_CHECKING:
    from lostmotion.analyses.statics.page import Statics


@question(folder="statics")
def statics(
    arm: ArmArgument,
    *,
    tilt: Annotated[
        Amount | None,
        Argument(
            "Tilt of the base from level, towards any side, '10 deg'.",
            Quantity("rad", "10 deg", low=0, high=math.pi),
        ),
    ] = None,
    poses: PosesArgument = 4096,
    pose_law: PoseLawArgument = "sobol",
    seed: SeedArgument = 1,
    max_payload: Annotated[
        bool, Argument("Also find the largest payload at every pose by the drives' rated torques.")
    ] = False,
    sag_limit: Annotated[
        Amount | None,
        Argument(
            (
                "As `max_payload`, and by this largest sag of the tool under the weights of arm "
                "and payload, '0.5 mm'."
            ),
            TARGET,
        ),
    ] = None,
    accuracy_limit: Annotated[
        Amount | None,
        Argument(
            (
                "As `max_payload`, and by this largest error of 95 % of the positions at a pose, "
                "'1 mm'."
            ),
            TARGET,
        ),
    ] = None,
    reducers: ReducersArgument = (),
    sidecar: SidecarArgument = None,
    calibration: CalibrationArgument = None,
    ready: ReadyArgument = None,
) -> Statics:
    """Report what every joint carries, which reducers are rated for it, and how stiff the arm is:
    where, in which direction, by which part.

    With `max_payload` also the largest payload: by drives, sag and accuracy.

    Raises
    ------
    InputError
        With every mistake in the arguments and files.

    """
    asked = read_arguments(statics, locals())
    asked.ready()
    from lostmotion.analyses.statics.page import Statics
    from lostmotion.error_model.trust import where_it_stands

    visited = where_it_stands(
        asked.arm, chosen_poses(asked.arm, asked.poses, asked.pose_law, asked.seed)
    )
    payload = None
    if asked.max_payload or asked.sag_limit is not None or asked.accuracy_limit is not None:
        from lostmotion.loads.payload import max_payload as largest

        payload = largest(asked.arm, visited, asked.tilt, asked.sag_limit, asked.accuracy_limit)
    return Statics.of(
        asked.arm,
        visited,
        asked.tilt,
        reducers=reducers_beside(arm, asked.reducers),
        payload=payload,
    )
