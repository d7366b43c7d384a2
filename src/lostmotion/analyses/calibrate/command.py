"""Ask which robot was measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from lostmotion.analyses.arguments import (
    ArmArgument,
    ProgressArgument,
    ReadyArgument,
    SeedArgument,
    SidecarArgument,
    paths_of,
)
from lostmotion.analyses.quantities import Amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import InputError, Problem
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from lostmotion.analyses.calibrate.result import Calibrated
    from lostmotion.io.measured.calibration_visits import CalibrationVisits


def _visits_of(name: str, value: Any, given: object) -> Any:  # noqa: ANN401 - whatever a user passes
    return value if hasattr(value, "difference") else paths_of(name, value, given)


@question(folder="calibrate")
def calibrate(
    arm: ArmArgument,
    measured: Annotated[
        "str | Path | Sequence[str | Path] | CalibrationVisits",
        Argument(
            "CSV of visits: joint values, A [deg], ..., and the tool point, x [mm], y [mm], "
            "z [mm], or its difference, dx [mm], ... Repeatable, in Python a list.",
            _visits_of,
            metavar="CSV",
            repeats=True,
        ),
    ],
    *,
    mapping: Annotated[
        "Sequence[str]",
        Argument(
            "What a column of that CSV is, 'dx = x_dif [mm], joint_1 = q1 [deg]'. Repeatable.",
            metavar="COLUMNS",
            repeats=True,
            aliases=("--map",),
        ),
    ] = (),
    terms: Annotated[
        Literal["geometry", "waves", "all"],
        Argument(
            "Errors that are estimated: constant ones of the chain; also periodic ones of the "
            'joints ("waves"); all that the measurement supports.'
        ),
    ] = "all",
    noise: Annotated[
        Amount | None,
        Argument(
            "Standard deviation of a measured coordinate, '70 µm', with what the model lacks. "
            "Default: estimated.",
            Quantity("m", "70 µm", above=0, high=1),
        ),
    ] = None,
    seed: SeedArgument = 1,
    sidecar: SidecarArgument = None,
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> Calibrated:
    """Estimate the errors of one robot from measured poses, with the tolerances of its parts as
    prior, and predict the accuracy that remains.

    The report's folder holds robot.toml, which every other command takes as `--calibration`.

    Raises
    ------
    InputError
        With every mistake in the arguments and the files; for rows that belong to another arm.

    """
    asked = read_arguments(calibrate, locals())
    from lostmotion.analyses.calibrate.answer import calibrated
    from lostmotion.analyses.calibrate.result import Calibrated
    from lostmotion.calibration.robot import WrongArmError
    from lostmotion.io.measured.calibration_visits import read_calibration_visits

    visits = (
        asked.measured
        if hasattr(asked.measured, "difference")
        else read_calibration_visits(asked.measured, asked.arm, asked.mapping)
    )
    asked.ready()
    try:
        found = calibrated(asked.arm, visits, asked.terms, asked.noise, asked.seed, progress)
    except WrongArmError as error:
        expected = "measurements of this arm with this tool"
        raise InputError([Problem(visits.file, "", str(error), expected)]) from None
    return Calibrated(**vars(found))
