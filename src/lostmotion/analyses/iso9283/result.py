"""An ISO 9283 sheet: predicted robots, the measured robot, and their comparison, with tables and
plots.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.warm_up import Drift, WarmUp
    from lostmotion.propagation.iso9283.cube import CommandedPoses, Cube
    from lostmotion.propagation.iso9283.robots import PredictedRobots
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.standards.comparison import ComparedFigure
    from lostmotion.standards.measured_robot import MeasuredRobot


@dataclass(frozen=True, repr=False)
class Iso9283(Result):
    """An ISO 9283 sheet: `predicted`, `drift`, `measured` and `compared`; None, or empty, where
    there is none.

    commanded  the poses of the measured file at which robots were predicted for the comparison;
               None where they are those of the cube
    """

    predicted: PredictedRobots | None
    drift: Drift | None
    measured: MeasuredRobot | None
    compared: tuple[ComparedFigure, ...]
    commanded: CommandedPoses | None = None

    @property
    def states(self) -> States | None:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values;
        None without a prediction.
        """
        from lostmotion.error_model.provenance import states

        return None if self.predicted is None else states(self.predicted.arm)

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.iso9283.page import iso_sheet

        return iso_sheet(self.predicted, self.drift, self.measured, self.compared, self.commanded)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.iso9283.page.plots import iso_plots

        return iso_plots(self.predicted, self.drift, self.measured, list(self.compared))


def answer(  # noqa: PLR0913 - an ISO sheet is these numbers
    arm: Arm,
    cube: Cube,
    measured: MeasuredRobot | None,
    *,
    cycles: int,
    robots: int,
    seed: int,
    path: tuple[str, str] | None,
    warm_up: WarmUp | None,
    progress: Callable[[str, int, int], None] | None,
) -> Iso9283:
    """Return the sheet of an arm in a test cube, beside a measured robot where there is one.

    `path`: two of P1 to P5; by default those of the first measured line, else P2 and P4. Simulated
    robots that are compared have the measured number of visits, instrument and loads.
    """
    from lostmotion.mechanism.warm_up import drift
    from lostmotion.propagation.iso9283.robots import MOST_CYCLES, predict_at, predict_robots
    from lostmotion.standards.commanded_poses import commanded_poses
    from lostmotion.standards.comparison import compare, compare_at

    ends = _ends(path, measured)
    predicted = predict_robots(
        arm, cube, cycles=cycles, robots=robots, seed=seed, path=ends, progress=progress
    )
    drifted = (
        None
        if warm_up is None
        else drift(arm, cube.q[0], predicted.loads[0].barycentre[0], warm_up)
    )
    if measured is None:
        return Iso9283(predicted, drifted, None, ())
    both = compare(_as_measured(predicted, measured, progress), measured)
    if both or (at := commanded_poses(arm, measured.visits)) is None:
        return Iso9283(predicted, drifted, measured, tuple(both))
    visited = [
        pose.visits for load in measured.loads for pose in load.poses if pose.name in at.names
    ]
    sheets = predict_at(
        arm,
        at,
        cycles=min(max(min(visited), 2), MOST_CYCLES),
        robots=robots,
        seed=seed,
        loads=tuple(dict.fromkeys(load.load for load in measured.loads)),
        instrument=measured.visits.instrument,
    )
    return Iso9283(predicted, drifted, measured, tuple(compare_at(at, sheets, measured)), at)


def _ends(path: tuple[str, str] | None, measured: MeasuredRobot | None) -> tuple[int, int]:
    """Return the two of P1 to P5 that the line joins."""
    from lostmotion.propagation.iso9283.cube import NAMES
    from lostmotion.propagation.iso9283.robots import DISTANCE
    from lostmotion.standards.measured_paths import path_ends

    lines = [] if measured is None else [each for load in measured.loads for each in load.paths]
    named = (path, *(path_ends(line.name, NAMES) for line in lines))
    first = next((each for each in named if each is not None), None)
    return DISTANCE if first is None else (NAMES.index(first[0]), NAMES.index(first[1]))


def _as_measured(
    predicted: PredictedRobots,
    measured: MeasuredRobot,
    progress: Callable[[str, int, int], None] | None,
) -> PredictedRobots:
    """Return the same robots as the measured one was measured, as far as they are compared with it:
    fewest visits and cycles, its loads and its instrument.
    """
    from lostmotion.propagation.iso9283.cube import NAMES
    from lostmotion.propagation.iso9283.experiment import Experiment
    from lostmotion.propagation.iso9283.robots import LOADS, MOST_CYCLES, load_sheets
    from lostmotion.standards.measured_paths import MOST_PLANES

    visited = [pose.visits for load in measured.loads for pose in load.poses if pose.name in NAMES]
    name = "-".join(NAMES[k] for k in predicted.path_ends)
    paths = [path for load in measured.loads for path in load.paths if path.name == name]
    planes = [min(len(path.places), MOST_PLANES) for path in paths]
    cycles = min(max(min(visited, default=predicted.cycles), 2), MOST_CYCLES)
    path_cycles = min((path.cycles for path in paths), default=predicted.path_cycles)
    path_points = min(planes, default=predicted.path_points)
    under = {load.load for load in measured.loads}
    if (
        (cycles, path_cycles, path_points, measured.visits.instrument)
        == (predicted.cycles, predicted.path_cycles, predicted.path_points, 0.0)
    ) and under <= set(LOADS):
        return predicted
    loads = dict.fromkeys([*LOADS, *(load.load for load in measured.loads)])
    sheets = load_sheets(
        predicted.arm,
        predicted.cube,
        Experiment(predicted.seed, predicted.robots, cycles, measured.visits.instrument),
        {number: load for number, load in enumerate(loads) if load in under},
        (*predicted.path_ends, path_points) if paths else None,
        path_cycles,
        progress,
    )
    return replace(
        predicted, cycles=cycles, path_cycles=path_cycles, path_points=path_points, loads=sheets
    )
