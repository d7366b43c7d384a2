"""The sheet of ISO 9283: of robots built to a design, of a measured one, or both side by side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.arguments import whole_seed
from lostmotion.analyses.quantities import Three, amount, amounts
from lostmotion.analyses.result import Shown
from lostmotion.error_model.provenance import refuse_undescribed, states
from lostmotion.errors import refuse_argument
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from lostmotion.analyses.iso9283.comparison import ComparedFigure
    from lostmotion.analyses.iso9283.cube import Cube
    from lostmotion.analyses.iso9283.measured import MeasuredRobot
    from lostmotion.analyses.iso9283.predicted import PredictedRobots
    from lostmotion.analyses.iso9283.visits import Visits
    from lostmotion.analyses.iso9283.warm_up import Drift, WarmUp
    from lostmotion.analyses.quantities import Amount, Amounts
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.spatial import Floats

DEFAULT_ISO_ROBOTS = 1000
# An arm and its test cube are no larger than this, m.
_MOST: Final = 1000.0
AMOUNTS: Final[dict[str, Quantity | Three]] = {
    "cube": Quantity("m", "400 mm", above=0, high=_MOST),
    "centre": Three(Quantity("m", "600 mm", low=-_MOST, high=_MOST), "600 mm, 0 mm, 400 mm"),
    "tool_rpy": Three(Quantity("rad", "180 deg"), "180 deg, 0 deg, 0 deg"),
    "floor": Quantity("m", "0 mm", low=-_MOST, high=_MOST),
    "instrument": Quantity("m", "10 µm", low=0, high=1),
    "warm_up": Quantity("K", "25 K", low=-1000, high=1000),
}


def iso9283(  # noqa: PLR0913 - an ISO sheet is these numbers
    arm: Arm | None = None,
    measured: str | Path | Sequence[str | Path] | None = None,
    *,
    cycles: int = 30,
    robots: int = DEFAULT_ISO_ROBOTS,
    seed: int = 1,
    cube: Amount | None = None,
    centre: Amounts | str | None = None,
    tool_rpy: Amounts | str | None = None,
    floor: Amount | None = 0.0,
    path: tuple[str, str] | None = None,
    warm_up: WarmUp | Amount | None = None,
    load: Amount | Sequence[Amount] = (),
    mapping: Sequence[str] = (),
    commands: str | Path | None = None,
    instrument: Amount = 0.0,
    progress: Callable[[str, int, int], None] | None = None,
    ready: Callable[[], object] | None = None,
) -> Iso9283:
    """What would ISO 9283 say of robots built to this design, what does it say of a measured one, and do the two agree? Never 'certified'.

    arm         the design; left out: the measured robot alone
    measured    CSV of measured visits and paths (`formats.measured`), or several of one robot, with `mapping` of their columns, `commands` in a
                file of their own, and the standard deviation of one reading of the `instrument`, "10 µm"
    load        share of the payload that each file was measured under, "10 %" or 0.1; left out: what its column says, else the full one
    cycles      visits to each of the five poses
    cube        side of the test cube, "400 mm", with its `centre`, ("600 mm", 0, "400 mm"): where P1 to P5 were commanded, if the measured file does
                not say; left out: as the measured file says, else the largest found, which nothing measured is judged by
    tool_rpy    how the tool is held in the cube, ("180 deg", 0, 0) about the fixed x, y, z; left out: what allows the largest cube
    floor       height below which the cube must not reach, "0 mm"; None: no floor
    path        the poses whose joining line is followed for AT and RT; left out: the one measured, else P2 and P4
    ready       called once all that is asked and measured is read and holds, before the cube is looked for and robots are built
    warm_up     by how much the links warm, "25 K", 63 % of it within an hour, or a `WarmUp`; left out: no drift

    Lengths, angles and the rise are amounts: text with a unit, or numbers in SI.
    Raises InputError for what cannot be asked, with every mistake in the measured file.
    """
    from lostmotion.analyses.iso9283.measured import evaluate
    from lostmotion.analyses.iso9283.measured_file import read_measured
    from lostmotion.analyses.iso9283.predicted import MOST_LOAD
    from lostmotion.analyses.iso9283.warm_up import WarmUp

    asked = {"cube": cube, "centre": centre, "tool_rpy": tool_rpy, "floor": floor, "instrument": instrument}
    if not isinstance(warm_up, WarmUp):
        asked["warm_up"] = warm_up
    read = amounts(asked, AMOUNTS)
    side, middle, held = read.get("cube"), read.get("centre"), read.get("tool_rpy")
    warmth = warm_up if isinstance(warm_up, WarmUp) else WarmUp(read["warm_up"]) if warm_up is not None else None
    share = Quantity("", "10 %", low=0.0, high=MOST_LOAD)
    shares = tuple(amount("load", each, share) for each in ([load] if isinstance(load, int | float | str) else load))
    if arm is None and measured is None:
        raise refuse_argument("arm, measured", "neither", "an arm, a CSV of measured visits, or both", 'lostmotion.iso9283(arm, "visits.csv")')
    if shares and measured is None:
        stated = ", ".join(f"{100 * each:g} %" for each in shares)
        raise refuse_argument("load", stated, "a measured file that it belongs to", 'measured = "visits.csv", load = "10 %"')
    _refuse_places(side, middle, path)
    if arm is not None:
        refuse_undescribed(arm)
    visits = None if measured is None else read_measured(measured, mapping, commands, read.get("instrument", 0.0), shares)
    if visits is not None:
        visits = _commanded(visits, side, middle, held, predicted=arm is not None)
    judged = None if visits is None else evaluate(visits)
    if ready is not None:
        ready()
    chosen = None if arm is None else _cube(arm, side, middle, held, read.get("floor"), visits, progress)
    return _sheet_of(arm, chosen, judged, cycles, robots, whole_seed(seed), _ends(path, judged), warmth, progress)


def _refuse_places(cube: float | None, centre: Sequence[float] | None, path: tuple[str, str] | None) -> None:
    """Refuse places that are none before anything long begins."""
    from lostmotion.analyses.iso9283.cube import NAMES

    if (cube is None) != (centre is None):
        raise refuse_argument("cube, centre", "one without the other", "both, or neither", 'cube = "400 mm", centre = "600 mm, 0 mm, 400 mm"')
    if path is not None and (len(path) != 2 or not set(path) <= set(NAMES)):  # noqa: PLR2004 - from one to another
        raise refuse_argument("path", " ".join(path), "two different ones of " + ", ".join(NAMES), '--path "P2 P4"')


def _commanded(visits: Visits, side: float | None, centre: Sequence[float] | None, tool_rpy: Sequence[float] | None, *, predicted: bool) -> Visits:
    """Give the visits with the commands of the cube that is stated, where their files state none; refuse to set them beside a cube not stated."""
    import numpy as np

    from lostmotion.analyses.iso9283.comparison import poses_of_cube, refuse_missing_commands
    from lostmotion.spatial import pose_of

    if side is not None and centre is not None:
        held = None if tool_rpy is None else pose_of(rpy=tuple(tool_rpy))[:3, :3]
        visits = visits.commanded(poses_of_cube(np.asarray(centre, dtype=float), side, held))
    if predicted:
        refuse_missing_commands(visits)
    return visits


def _ends(path: tuple[str, str] | None, judged: MeasuredRobot | None) -> tuple[int, int]:
    """Which two of P1 to P5 does the line join? Those asked for; else of the first line that was measured; P2 and P4 where none was."""
    from lostmotion.analyses.iso9283.cube import NAMES
    from lostmotion.analyses.iso9283.measured_paths import path_ends
    from lostmotion.analyses.iso9283.predicted import DISTANCE

    if path is not None:
        return NAMES.index(path[0]), NAMES.index(path[1])
    for measured in (each for load in judged.loads for each in load.paths) if judged is not None else ():
        if (ends := path_ends(measured.name, NAMES)) is not None:
            return NAMES.index(ends[0]), NAMES.index(ends[1])
    return DISTANCE


def _cube(
    arm: Arm,
    side: float | None,
    centre: Sequence[float] | None,
    tool_rpy: Sequence[float] | None,
    floor: float | None,
    visits: Visits | None,
    progress: Callable[[str, int, int], None] | None,
) -> Cube:
    import numpy as np

    from lostmotion.analyses.iso9283.comparison import commanded_cube, unreachable_command
    from lostmotion.analyses.iso9283.cube import cube_from_arguments, cube_in_reach
    from lostmotion.analyses.iso9283.largest_cube import largest_cube
    from lostmotion.spatial import pose_of

    held: Floats | None = None if tool_rpy is None else pose_of(rpy=tuple(tool_rpy))[:3, :3]
    if side is not None and centre is not None:
        return cube_from_arguments(arm, np.asarray(centre, dtype=float), side, held)
    if visits is not None and (stated := commanded_cube(visits)) is not None:
        turned = held if held is not None or len(arm.tree.drives) < _HOLDS else stated[2]
        cube = cube_in_reach(arm, stated[0], stated[1], turned)
        if cube is None:
            raise unreachable_command(arm, visits, stated[0], stated[1], turned)
        return cube
    return largest_cube(arm, held, floor, progress=progress)


# Joints with which an arm holds its tool in any orientation.
_HOLDS = 6


def _sheet_of(  # noqa: PLR0913, PLR0917 - an ISO sheet is these numbers
    arm: Arm | None,
    cube: Cube | None,
    judged: MeasuredRobot | None,
    cycles: int,
    robots: int,
    seed: int,
    ends: tuple[int, int],
    warm_up: WarmUp | None,
    progress: Callable[[str, int, int], None] | None,
) -> Iso9283:
    from lostmotion.analyses.iso9283.comparison import compare
    from lostmotion.analyses.iso9283.predicted import LOADS, PATH_CYCLES, PATH_POINTS, predict_robots
    from lostmotion.analyses.iso9283.warm_up import drift

    predicted = drifted = None
    both: list[ComparedFigure] = []
    if arm is not None and cube is not None:
        predicted = predict_robots(arm, cube, cycles=cycles, robots=robots, seed=seed, path=ends, progress=progress)
        if warm_up is not None:
            drifted = drift(arm, cube.q[0], predicted.loads[0].barycentre[0], warm_up)
        if judged is not None:
            seen = predicted
            # The robots built are visited as often, read with the same instrument, and carry the loads that were measured.
            asked = _as_measured(judged, cycles, ends)
            if asked != {"cycles": cycles, "path_cycles": PATH_CYCLES, "path_points": PATH_POINTS, "loads": LOADS, "instrument": 0.0}:
                seen = predict_robots(arm, cube, robots=robots, seed=seed, path=ends, progress=progress, **asked)
            both = compare(seen, judged)
    return Iso9283(predicted, drifted, judged, tuple(both))


def _as_measured(judged: MeasuredRobot, cycles: int, ends: tuple[int, int]) -> dict[str, Any]:
    """How must robots be predicted to be seen as the measured one was? Fewest visits and cycles over poses, paths and loads."""
    from lostmotion.analyses.iso9283.cube import NAMES
    from lostmotion.analyses.iso9283.measured_paths import MOST_PLANES
    from lostmotion.analyses.iso9283.predicted import LOADS, MOST_CYCLES, PATH_CYCLES, PATH_POINTS

    visited = [pose.visits for load in judged.loads for pose in load.poses if pose.name in NAMES]
    name = "-".join(NAMES[k] for k in ends)
    paths = [path for load in judged.loads for path in load.paths if path.name == name]
    return {
        "cycles": min(max(min(visited, default=cycles), 2), MOST_CYCLES),
        "path_cycles": min((path.cycles for path in paths), default=PATH_CYCLES),
        "path_points": min((min(len(path.places), MOST_PLANES) for path in paths), default=PATH_POINTS),
        "loads": (*LOADS, *(load.load for load in judged.loads if load.load not in LOADS)),
        "instrument": judged.visits.instrument,
    }


@dataclass(frozen=True)
class Iso9283(Shown):
    """An ISO 9283 sheet: `summary()`, `report("out/")`, `result()`; `predicted`, `drift`, `measured`, `compared` hold every number."""

    predicted: PredictedRobots | None
    drift: Drift | None
    measured: MeasuredRobot | None
    compared: tuple[ComparedFigure, ...]

    @property
    def states(self) -> States | None:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values; None without a prediction."""
        return None if self.predicted is None else states(self.predicted.arm)

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.analyses.iso9283.tables.sheet import iso_sheet

        notes: tuple[str, ...] = ()
        if self.predicted is not None and self.measured is not None and not self.compared:
            notes = (
                "not compared: the measured poses are not P1 to P5 of the cube; name and command them so, or state the cube they were measured in",
            )
        return iso_sheet(self.predicted, self.drift, self.measured, list(self.compared), notes)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html and result.json into the folder `out`, whole or not at all; gives the folder.

        Raises OutputExistsError where the folder exists and `force` is not set.
        """
        from lostmotion.analyses.iso9283.report import write_iso_report

        return write_iso_report(self.sheet, self.predicted, self.drift, self.measured, list(self.compared), out, force=force)
