"""One ISO 9283 sheet: test cube, predicted robots, measured robot, and their comparison."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lostmotion.analyses.iso9283.result import Iso9283

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.analyses.iso9283.comparison import ComparedFigure
    from lostmotion.analyses.iso9283.cube import Cube
    from lostmotion.analyses.iso9283.measured import MeasuredRobot
    from lostmotion.analyses.iso9283.warm_up import WarmUp
    from lostmotion.io.measured.visits import Visits
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


def commanded(
    visits: Visits,
    side: float | None,
    centre: Sequence[float] | None,
    tool_rpy: Sequence[float] | None,
    *,
    predicted: bool,
) -> Visits:
    """Return the visits with the commands of the stated cube where their files state none.

    Raises InputError for missing commands where predicted robots are compared with them.
    """
    import numpy as np

    from lostmotion.analyses.iso9283.comparison import poses_of_cube, refuse_missing_commands
    from lostmotion.spatial import pose_of

    if side is not None and centre is not None:
        orientation = None if tool_rpy is None else pose_of(rpy=tuple(tool_rpy))[:3, :3]
        visits = visits.commanded(poses_of_cube(np.asarray(centre, dtype=float), side, orientation))
    if predicted:
        refuse_missing_commands(visits)
    return visits


def ends_of(path: tuple[str, str] | None, measured: MeasuredRobot | None) -> tuple[int, int]:
    """Return the two of P1 to P5 that the line joins: those requested, else of the first measured
    line, else P2 and P4.
    """
    from lostmotion.analyses.iso9283.cube import NAMES
    from lostmotion.analyses.iso9283.measured_paths import path_ends
    from lostmotion.analyses.iso9283.predicted import DISTANCE

    if path is not None:
        return NAMES.index(path[0]), NAMES.index(path[1])
    for line in (
        (each for load in measured.loads for each in load.paths) if measured is not None else ()
    ):
        if (ends := path_ends(line.name, NAMES)) is not None:
            return NAMES.index(ends[0]), NAMES.index(ends[1])
    return DISTANCE


def cube_of(
    arm: Arm,
    side: float | None,
    centre: Sequence[float] | None,
    tool_rpy: Sequence[float] | None,
    floor: float | None,
    visits: Visits | None,
    progress: Callable[[str, int, int], None] | None,
) -> Cube:
    """Return the test cube: the stated one, else that of the measured commands, else the largest
    found.
    """
    import numpy as np

    from lostmotion.analyses.iso9283.comparison import commanded_cube, unreachable_command
    from lostmotion.analyses.iso9283.cube import cube_from_arguments, cube_in_reach
    from lostmotion.analyses.iso9283.largest_cube import largest_cube
    from lostmotion.spatial import pose_of

    orientation: Floats | None = None if tool_rpy is None else pose_of(rpy=tuple(tool_rpy))[:3, :3]
    if side is not None and centre is not None:
        return cube_from_arguments(arm, np.asarray(centre, dtype=float), side, orientation)
    if visits is not None and (stated := commanded_cube(visits)) is not None:
        rotation = (
            orientation
            if orientation is not None or len(arm.tree.tool_joints) < _FULL
            else stated[2]
        )
        cube = cube_in_reach(arm, stated[0], stated[1], rotation)
        if cube is None:
            raise unreachable_command(arm, visits, stated[0], stated[1], rotation)
        return cube
    return largest_cube(arm, orientation, floor, progress=progress)


# Fewest joints for any orientation of the tool.
_FULL = 6


def sheet_of(  # noqa: PLR0913, PLR0917 - an ISO sheet is these numbers
    arm: Arm | None,
    cube: Cube | None,
    measured: MeasuredRobot | None,
    cycles: int,
    robots: int,
    seed: int,
    ends: tuple[int, int],
    warm_up: WarmUp | None,
    progress: Callable[[str, int, int], None] | None,
) -> Iso9283:
    """Return the sheet of an arm, of a measured robot, or of both."""
    from lostmotion.analyses.iso9283.commanded_poses import commanded_poses
    from lostmotion.analyses.iso9283.comparison import compare, compare_at
    from lostmotion.analyses.iso9283.predicted import (
        LOADS,
        MOST_CYCLES,
        PATH_CYCLES,
        PATH_POINTS,
        predict_at,
        predict_robots,
    )
    from lostmotion.analyses.iso9283.warm_up import drift

    predicted = drifted = at = None
    both: list[ComparedFigure] = []
    if arm is not None and cube is not None:
        predicted = predict_robots(
            arm, cube, cycles=cycles, robots=robots, seed=seed, path=ends, progress=progress
        )
        if warm_up is not None:
            drifted = drift(arm, cube.q[0], predicted.loads[0].barycentre[0], warm_up)
        if measured is not None:
            seen = predicted
            # Simulated robots have the measured number of visits, instrument and loads.
            arguments = _as_measured(measured, cycles, ends)
            if arguments != {
                "cycles": cycles,
                "path_cycles": PATH_CYCLES,
                "path_points": PATH_POINTS,
                "loads": LOADS,
                "instrument": 0.0,
            }:
                seen = predict_robots(
                    arm, cube, robots=robots, seed=seed, path=ends, progress=progress, **arguments
                )
            both = compare(seen, measured)
            if not both and (at := commanded_poses(arm, measured.visits)) is not None:
                visited = [
                    pose.visits
                    for load in measured.loads
                    for pose in load.poses
                    if pose.name in at.names
                ]
                loads = tuple(dict.fromkeys(load.load for load in measured.loads))
                cycles = min(max(min(visited), 2), MOST_CYCLES)
                sheets = predict_at(
                    arm,
                    at,
                    cycles=cycles,
                    robots=robots,
                    seed=seed,
                    loads=loads,
                    instrument=measured.visits.instrument,
                )
                both = compare_at(at, sheets, measured)
    return Iso9283(predicted, drifted, measured, tuple(both), at)


def _as_measured(measured: MeasuredRobot, cycles: int, ends: tuple[int, int]) -> dict[str, Any]:
    """Return the arguments that predict robots as the measured one was measured: fewest visits and
    cycles, its loads and its instrument.
    """
    from lostmotion.analyses.iso9283.cube import NAMES
    from lostmotion.analyses.iso9283.measured_paths import MOST_PLANES
    from lostmotion.analyses.iso9283.predicted import LOADS, MOST_CYCLES, PATH_CYCLES, PATH_POINTS

    visited = [pose.visits for load in measured.loads for pose in load.poses if pose.name in NAMES]
    name = "-".join(NAMES[k] for k in ends)
    paths = [path for load in measured.loads for path in load.paths if path.name == name]
    return {
        "cycles": min(max(min(visited, default=cycles), 2), MOST_CYCLES),
        "path_cycles": min((path.cycles for path in paths), default=PATH_CYCLES),
        "path_points": min(
            (min(len(path.places), MOST_PLANES) for path in paths), default=PATH_POINTS
        ),
        "loads": (*LOADS, *(load.load for load in measured.loads if load.load not in LOADS)),
        "instrument": measured.visits.instrument,
    }
