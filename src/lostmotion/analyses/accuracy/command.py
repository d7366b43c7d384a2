"""Ask how accurate an arm is."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypedDict, Unpack, overload

from lostmotion.accuracy import Method
from lostmotion.analyses.arguments import (
    DEFAULT_POSES,
    DEFAULT_ROBOTS,
    DEFAULT_VISITS,
    Approach,
    ApproachArgument,
    ArmArgument,
    CalibrationArgument,
    PoseChoice,
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
    poses_at,
    zones_of,
)
from lostmotion.analyses.quantities import TARGET, Amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import InputError, refuse_argument

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.analyses.accuracy.result import AnalyticStudy, Study
    from lostmotion.analyses.arguments import At, Zone
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.montecarlo.stopping import Tolerance
    from lostmotion.spatial import Floats


def _precision_of(_name: str, value: float | str, _given: object) -> Tolerance:
    from lostmotion.propagation.montecarlo.stopping import Tolerance

    return Tolerance.of(value)


class Settings(TypedDict, total=False):
    """Arguments of `study` by keyword."""

    pose_law: PoseChoice
    approach: Approach
    at: At | list[At] | None
    zone: Zone | Sequence[Zone] | None
    until: float | str | None
    target: Amount | None
    most_robots: int
    sidecar: str | Path | None
    threads: int | None
    device: Literal["cpu", "gpu"]
    progress: Callable[[str, int, int], None] | None
    ready: Callable[[], object] | None


@overload
def study(
    arm: Arm | str | Path,
    poses: int | str | Path | Floats | Poses = ...,
    robots: int = ...,
    visits: int = ...,
    seed: int = ...,
    *,
    method: Literal["montecarlo", "both"] = "montecarlo",
    **more: Unpack[Settings],
) -> Study: ...


@overload
def study(
    arm: Arm | str | Path,
    poses: int | str | Path | Floats | Poses = ...,
    robots: int = ...,
    visits: int = ...,
    seed: int = ...,
    *,
    method: Literal["analytic"],
    **more: Unpack[Settings],
) -> AnalyticStudy: ...


@question(folder="accuracy")
def study(
    arm: ArmArgument,
    poses: PosesArgument = DEFAULT_POSES,
    robots: RobotsArgument = DEFAULT_ROBOTS,
    visits: VisitsArgument = DEFAULT_VISITS,
    seed: SeedArgument = 1,
    *,
    pose_law: PoseLawArgument = "sobol",
    approach: ApproachArgument = "random",
    method: Annotated[
        Method,
        Argument("Monte Carlo samples; sums over terms without sampling; or both, compared."),
    ] = "montecarlo",
    at: Annotated[
        "At | list[At] | None",
        Argument(
            (
                "Error budget at a pose as well: its number, or every joint, 'A=30deg B=-10deg'. "
                "Repeatable; in Python a list of several."
            ),
            poses_at,
            metavar="POSE",
            repeats=True,
        ),
    ] = None,
    zone: Annotated[
        "Zone | Sequence[Zone] | None",
        Argument(
            "Error and error budget in a zone as well, in the base's axes: 'x 0.2..0.5 m, z "
            "0..300 mm'. Repeatable. In Python also ends, "
            '{"x": (0.2, 0.5)}, or which of the poses are in it.',
            zones_of,
            metavar="ZONE",
            repeats=True,
        ),
    ] = None,
    until: Annotated[
        "float | str | None",
        Argument(
            "Continue with more robots and poses until the 95 % intervals of mean, 95 % "
            "error, AP and RP are this narrow: "
            "'1 %' of each figure, or '2 digits' of it.",
            _precision_of,
            metavar="PRECISION",
        ),
    ] = None,
    target: Annotated[
        Amount | None,
        Argument(
            (
                "Largest acceptable error, '0.5 mm': the share of positions within it, and its "
                "contour in the sections of the workspace."
            ),
            TARGET,
        ),
    ] = None,
    most_robots: Annotated[
        int, Argument("How many robots are simulated at most, with `until`.", least=1)
    ] = 10_000,
    sidecar: SidecarArgument = None,
    calibration: CalibrationArgument = None,
    threads: ThreadsArgument = None,
    device: Annotated[
        Literal["cpu", "gpu"],
        Argument(
            "Where samples are computed; gpu needs pip install 'lostmotion[gpu]' and gives "
            "the same figures but for rounding."
        ),
    ] = "cpu",
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> Study | AnalyticStudy:
    """Predict how accurate an arm is before it is built: its error over the workspace, AP and RP,
    and the error budget by part.

    The same robots visit every pose. With a zone, as many poses of the same law are chosen in it;
    of poses that are given or on a grid, those in it.

    Raises
    ------
    InputError
        With every mistake in the arguments and the files; for an arm without any error source, and
        a zone that no pose reaches.
    LostmotionError
        For a GPU where JAX or the GPU is missing.

    """
    asked = read_arguments(study, locals())
    from lostmotion.accuracy.route import Route
    from lostmotion.analyses.accuracy.study import carry_out, undescribed
    from lostmotion.analyses.result import PartialResultError
    from lostmotion.error_model.provenance import refuse_undescribed
    from lostmotion.propagation.montecarlo.blocks import check_device

    if until is not None and method == "analytic":
        raise refuse_argument(
            "until",
            until,
            "a method that draws robots: without sampling there are none",
            method="both",
        )
    if target is not None and method == "analytic":
        raise refuse_argument(
            "target",
            target,
            "a method that draws robots: the share within a target is counted",
            method="both",
        )
    if device != "cpu" and method == "analytic":
        raise refuse_argument(
            "device",
            device,
            '"cpu": without sampling there is nothing for a GPU to do',
            device="cpu",
        )
    check_device(device)
    asked.ready()
    try:
        refuse_undescribed(asked.arm)
    except InputError as error:
        file = arm if isinstance(arm, str | os.PathLike) else None
        left = partial(
            undescribed,
            asked.arm,
            asked.poses,
            pose_law,
            asked.seed,
            None if file is None else Path(file),
            asked.sidecar,
        )
        raise PartialResultError(error.problems, left) from None
    chosen = chosen_poses(asked.arm, asked.poses, pose_law, asked.seed)
    route = Route(
        method,
        asked.robots,
        asked.visits,
        asked.seed,
        asked.most_robots,
        asked.until,
        asked.approach,
        asked.threads or os.cpu_count() or 1,
        device=device,
        progress=progress,
    )
    law = pose_law if isinstance(asked.poses, int) and pose_law != "grid" else None
    return carry_out(asked.arm, chosen, law, route, asked.at or [], asked.zone or [], asked.target)
