"""Ask for the ISO 9283 sheet of a design, of a measured robot, or of both."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Final

from lostmotion.analyses.arguments import (
    DEFAULT_ROBOTS,
    DEFAULT_VISITS,
    CalibrationArgument,
    ProgressArgument,
    ReadyArgument,
    SeedArgument,
    SidecarArgument,
    arm_of,
    path_of,
    paths_of,
    several,
)
from lostmotion.analyses.quantities import Amount, Three, amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import Mistakes, refuse_argument
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from lostmotion.analyses.iso9283.result import Iso9283
    from lostmotion.mechanism.arm import Arm

# An arm and its test cube are no larger than this, m.
_MOST: Final = 1000.0
_CORNERS: Final = ("P1", "P2", "P3", "P4", "P5")
_CENTRE: Final = Three(Quantity("m", "600 mm", low=-_MOST, high=_MOST), "600 mm, 0 mm, 400 mm")
_RPY: Final = Three(Quantity("rad", "180 deg"), "180 deg, 0 deg, 0 deg")
_FLOOR: Final = Quantity("m", "0 mm", low=-_MOST, high=_MOST)


def _floor_of(name: str, value: Any, _given: object) -> float | None:  # noqa: ANN401 - whatever a user passes
    return (
        None
        if value is None or (isinstance(value, str) and value.strip().lower() == "none")
        else amount(name, value, _FLOOR)
    )


def _loads_of(name: str, value: Any, _given: object) -> tuple[float, ...]:  # noqa: ANN401 - whatever a user passes
    from lostmotion.mechanism.tool import MOST_LOAD

    wanted = Quantity("", "10 %", low=0.0, high=MOST_LOAD)
    with Mistakes() as mistakes:
        return tuple(mistakes.of(amount, name, each, wanted) for each in several(value))


def _path_of(name: str, value: Any, _given: object) -> tuple[str, str]:  # noqa: ANN401 - whatever a user passes
    ends = (
        tuple(value.replace(",", " ").replace("-", " ").upper().split())
        if isinstance(value, str)
        else tuple(value)
    )
    if len(ends) != 2 or not set(ends) <= set(_CORNERS) or ends[0] == ends[1]:  # noqa: PLR2004 - from one to another
        raise refuse_argument(
            name, value, "two different ones of " + ", ".join(_CORNERS), **{name: "P2 P4"}
        )
    return ends[0], ends[1]


def _refuse_together(
    arm: object, measured: object, load: object, cube: object, centre: object
) -> None:
    """Raise InputError where nothing is asked about, and for arguments that lack the one that they
    belong to.
    """
    if arm is None and measured is None:
        raise refuse_argument(
            "arm, measured",
            "neither",
            "an arm, a CSV of measured visits, or both",
            measured="visits.csv",
        )
    if load != () and measured is None:
        stated = ", ".join(map(str, several(load)))
        raise refuse_argument(
            "load", stated, "a measured file that it belongs to", measured="visits.csv", load="10 %"
        )
    if (cube is None) != (centre is None):
        raise refuse_argument(
            "cube, centre",
            "one without the other",
            "both, or neither",
            cube="400 mm",
            centre="600 mm, 0 mm, 400 mm",
        )


@question(folder="iso9283")
def iso9283(
    arm: Annotated[
        "Arm | str | Path | Mapping[str, Any] | None",
        Argument(
            (
                "Arm: native TOML, or URDF with its sidecar TOML. Default: none, the measured "
                "robot alone."
            ),
            arm_of,
            metavar="FILE",
        ),
    ] = None,
    measured: Annotated[
        "str | Path | Sequence[str | Path] | None",
        Argument(
            (
                "CSV of a measured robot: pose, path, cycle, load [%], x [mm], y [mm], z [mm], xc "
                "[mm], ... Repeatable, in Python a list."
            ),
            paths_of,
            metavar="CSV",
            repeats=True,
        ),
    ] = None,
    *,
    load: Annotated[
        "Amount | Sequence[Amount]",
        Argument(
            (
                "Share of the payload, '10 %', that a CSV without such a column was measured "
                "under; one for each. Default: the full payload."
            ),
            _loads_of,
            metavar="SHARE",
            repeats=True,
        ),
    ] = (),
    mapping: Annotated[
        "Sequence[str]",
        Argument(
            "What a column of that CSV is, 'xc = x_t [mm], dx = -x_dif [mm]'. Repeatable.",
            metavar="COLUMNS",
            repeats=True,
            aliases=("--map",),
        ),
    ] = (),
    commands: Annotated[
        "str | Path | None",
        Argument(
            "CSV of the commanded poses: pose, x [mm], y [mm], z [mm].", path_of, metavar="CSV"
        ),
    ] = None,
    instrument: Annotated[
        Amount,
        Argument(
            "Standard deviation of one reading of a coordinate, '10 µm'.",
            Quantity("m", "10 µm", low=0, high=1),
        ),
    ] = 0.0,
    visits: Annotated[
        int,
        Argument(
            "How often each robot visits each of the five poses.",
            least=2,
            most=1000,
            aliases=("--cycles",),
        ),
    ] = DEFAULT_VISITS,
    robots: Annotated[
        int, Argument("How many manufactured robots are simulated.", least=2, most=20_000)
    ] = DEFAULT_ROBOTS,
    cube: Annotated[
        Amount | None,
        Argument(
            (
                "Side of the test cube, '400 mm', with `centre`. Default: as measured, else the "
                "largest found."
            ),
            Quantity("m", "400 mm", above=0, high=_MOST),
        ),
    ] = None,
    centre: Annotated[
        "str | Sequence[str | float] | None",
        Argument(
            "Centre of the cube in the base frame, '600 mm, 0 mm, 400 mm'.",
            _CENTRE,
            metavar="POINT",
        ),
    ] = None,
    tool_rpy: Annotated[
        "str | Sequence[str | float] | None",
        Argument(
            (
                "Orientation of the tool about the fixed x, y, z, '180 deg, 0 deg, 0 deg'. "
                "Default: what allows the largest cube."
            ),
            _RPY,
            metavar="RPY",
        ),
    ] = None,
    floor: Annotated[
        Amount | None,
        Argument(
            "Height that the cube stays above, '0 mm'; 'none' for no floor.",
            _floor_of,
            metavar="LENGTH",
        ),
    ] = "0 mm",
    path: Annotated[
        "str | tuple[str, str] | None",
        Argument(
            (
                "Two poses whose joining line is followed, for AT and RT, 'P2 P4'. Default: the "
                "one measured, else that."
            ),
            _path_of,
            metavar="POSES",
        ),
    ] = None,
    warm_up: Annotated[
        Amount | None,
        Argument(
            "Temperature rise of the links, '25 K', for the drift. Default: no drift.",
            Quantity("K", "25 K", low=-1000, high=1000),
        ),
    ] = None,
    warm_up_time: Annotated[
        Amount,
        Argument(
            "Time within which 63 % of the rise is reached.",
            Quantity("s", "1 h", above=0, high=1e9),
        ),
    ] = "1 h",
    expansion: Annotated[
        Amount,
        Argument(
            "Thermal expansion of the links, per kelvin.",
            Quantity("", "23e-6", low=0, high=1),
            metavar="NUMBER",
        ),
    ] = 23e-6,
    seed: SeedArgument = 1,
    sidecar: SidecarArgument = None,
    calibration: CalibrationArgument = None,
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> Iso9283:
    """Predict the ISO 9283 sheet of an arm before it is built, evaluate a measured one, and compare
    the two.

    In the CSV, each row is a visit to a pose, or, with a path such as P2-P4 instead of a pose, one
    reading along it, in the order read.

    Raises
    ------
    InputError
        With every mistake in the arguments and the files.

    """
    with Mistakes() as mistakes:
        mistakes.of(_refuse_together, arm, measured, load, cube, centre)
        asked = mistakes.of(read_arguments, iso9283, locals())
    import numpy as np

    from lostmotion.analyses.iso9283.result import Iso9283, answer
    from lostmotion.error_model.provenance import refuse_undescribed
    from lostmotion.io.measured.visit_file import read_measured
    from lostmotion.mechanism.warm_up import WarmUp
    from lostmotion.spatial import pose_of
    from lostmotion.standards.commanded_poses import (
        cube_of,
        poses_of_cube,
        refuse_missing_commands,
    )
    from lostmotion.standards.measured_robot import evaluate

    rotation = None if asked.tool_rpy is None else pose_of(rpy=tuple(asked.tool_rpy))[:3, :3]
    stated = None if asked.cube is None else (np.asarray(asked.centre, dtype=float), asked.cube)
    if arm is not None:
        refuse_undescribed(asked.arm)
    visited = evaluated = None
    if measured is not None:
        visited = read_measured(
            asked.measured, asked.mapping, asked.commands, asked.instrument, asked.load
        )
        if stated is not None:
            visited = visited.commanded(poses_of_cube(*stated, rotation))
        if arm is not None:
            refuse_missing_commands(visited)
        evaluated = evaluate(visited)
    asked.ready()
    if arm is None:
        return Iso9283(None, None, evaluated, ())
    return answer(
        asked.arm,
        cube_of(asked.arm, stated, rotation, asked.floor, visited, progress),
        evaluated,
        cycles=asked.visits,
        robots=asked.robots,
        seed=asked.seed,
        path=asked.path,
        warm_up=(
            None
            if asked.warm_up is None
            else WarmUp(asked.warm_up, asked.warm_up_time, asked.expansion)
        ),
        progress=progress,
    )
