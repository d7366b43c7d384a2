"""Ask for the accuracy of an arm over its workspace, and for the best place for a task."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Annotated, Final, Literal

from lostmotion.analyses.arguments import (
    ApproachArgument,
    ArmArgument,
    CalibrationArgument,
    ProgressArgument,
    ReadyArgument,
    SeedArgument,
    SidecarArgument,
    ThreadsArgument,
)
from lostmotion.analyses.quantities import Amount, Three
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.workspace_map.page import AccuracyMap

Configuration = Literal["best", "mean", "worst"]
# An arm and its work are no larger than this, m.
_MOST: Final = 1000.0
_LENGTH: Final = Quantity("m", "50 mm", above=0, high=_MOST)
_SIDE: Final = Quantity("m", "300 mm", low=0, high=_MOST)
_COORDINATE: Final = Quantity("m", "500 mm", low=-_MOST, high=_MOST)


@question(folder="map")
def map(  # noqa: A001 - the name on both sides
    arm: ArmArgument,
    *,
    cell: Annotated[
        Amount | None,
        Argument(
            "Edge of the cells, '50 mm'. Default: about a thirtieth of the workspace.", _LENGTH
        ),
    ] = None,
    by: Annotated[
        Configuration,
        Argument("Configuration of the arm that a cell is judged by, of those that reach it."),
    ] = "mean",
    target: Annotated[
        Amount | None,
        Argument(
            "Largest acceptable error, '0.5 mm', for the share of the workspace within it.",
            Quantity("m", "0.5 mm", above=0, high=_MOST),
        ),
    ] = None,
    box: Annotated[
        "str | Sequence[str | float] | None",
        Argument(
            "Work to be placed, along x, y and z: '300 mm x 200 mm x 100 mm'.",
            Three(_SIDE, "300 mm x 200 mm x 100 mm"),
            metavar="BOX",
        ),
    ] = None,
    box_by_mean: Annotated[
        bool, Argument("Judge a place by the mean of its cells, not by the worst one.")
    ] = False,
    turned: Annotated[
        bool, Argument("Try the box at other yaws as well, in steps of 15 deg.")
    ] = False,
    clear: Annotated[
        Amount | None,
        Argument(
            "Distance of the box from the base's z axis, at least, '200 mm'.",
            Quantity("m", "200 mm", low=0, high=_MOST),
        ),
    ] = None,
    floor: Annotated[
        Amount | None,
        Argument(
            "Height in the base frame that the box stays above, '0 mm'.",
            Quantity("m", "0 mm", low=-_MOST, high=_MOST),
        ),
    ] = None,
    at: Annotated[
        "str | Sequence[str | float] | None",
        Argument(
            (
                "Point in the base frame that the slices go through, '500 mm, 0 mm, 300 mm'. "
                "Default: the best place."
            ),
            Three(_COORDINATE, "500 mm, 0 mm, 300 mm"),
            metavar="POINT",
        ),
    ] = None,
    level: Annotated[
        Amount,
        Argument(
            "Share of errors that a cell's figure is not exceeded by.",
            Quantity("", "95 %", low=0.25, high=0.9995),
        ),
    ] = 0.95,
    poses: Annotated[
        int,
        Argument(
            (
                "How many poses to sample, rounded up to 8 x a power of two. Most of the time goes "
                "into the errors in all cells, however many: fewer by `cell` and `per_cell`."
            ),
            least=1,
        ),
    ] = 131_072,
    per_cell: Annotated[
        int,
        Argument("How many configurations of the arm to study in each cell.", least=2, most=1024),
    ] = 8,
    seed: SeedArgument = 1,
    approach: ApproachArgument = "random",
    sidecar: SidecarArgument = None,
    calibration: CalibrationArgument = None,
    threads: ThreadsArgument = None,
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> AccuracyMap:
    """Map the error over the workspace: slices, surfaces, the share within a target, the best
    places for work, the largest contributor where.

    The error in a cell is over all robots and visits, first order, by sums over terms without
    sampling; the tool may have any orientation.

    Raises
    ------
    InputError
        With every mistake in the arguments and the arm's file; for cells too small, and a box with
        a side along an axis that the tool cannot move along.

    """
    asked = read_arguments(map, locals())
    import numpy as np

    from lostmotion.analyses.workspace_map.page import AccuracyMap
    from lostmotion.error_model.provenance import refuse_undescribed
    from lostmotion.error_model.trust import refuse_untrusted
    from lostmotion.maps.accuracy_map import map_workspace
    from lostmotion.maps.request import MapRequest
    from lostmotion.mechanism.even_poses import even_poses
    from lostmotion.propagation.first_order import refuse_large_errors

    stated = {
        name: value
        for name in MapRequest.__dataclass_fields__
        if (value := getattr(asked, name)) is not None
    }
    request = MapRequest(**stated)
    refuse_undescribed(asked.arm)
    refuse_large_errors(asked.arm)
    refuse_untrusted(asked.arm, even_poses(asked.arm))
    asked.ready()
    threads = asked.threads or os.cpu_count() or 1
    found = map_workspace(
        asked.arm,
        request,
        seed=asked.seed,
        approach=asked.approach,
        threads=threads,
        progress=progress,
    )
    return AccuracyMap(**vars(found), at=None if asked.at is None else np.asarray(asked.at))
