"""Ask which robot was measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from lostmotion.analyses.arguments import (
    ArmArgument,
    ProgressArgument,
    ReadyArgument,
    SeedArgument,
    SidecarArgument,
    Zone,
    path_of,
    paths_of,
    zone_of,
)
from lostmotion.analyses.quantities import Amount
from lostmotion.analyses.signature import Argument, question, question_of, read_arguments
from lostmotion.errors import InputError, Problem, refuse_argument, shown
from lostmotion.io.measured.instrument import Instrument
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from lostmotion.analyses.calibrate.result import Calibrated, CalibrationPlan, MakerCalibration
    from lostmotion.io.measured.calibration_visits import CalibrationVisits
    from lostmotion.mechanism.arm import Arm


# Standard deviation of a coordinate by which poses are planned, m: of a laser tracker with what the
# model lacks.
DEFAULT_NOISE: Final = 70e-6


# Arguments that are without a use where poses are planned, where a maker's file is read, and where
# errors are estimated.
_UNUSED: Final = {
    "plan": ("terms", "prior", "hold_out"),
    "maker": (
        *("measured", "mapping", "terms", "prior", "noise", "instrument", "hold_out", "plan"),
        "zone",
    ),
    "measured": ("zone",),
}


def _refuse_unused(asked: Any) -> None:  # noqa: ANN401 - one attribute per argument
    """Raise InputError with every argument that the others leave without a use."""
    mode = next(name for name in ("maker", "plan", "measured") if getattr(asked, name) is not None)
    unused = dict.fromkeys(_UNUSED[mode], f"nothing beside {mode}, which does not use it")
    if asked.measured is None and mode == "plan":
        unused |= dict.fromkeys(("mapping", "instrument"), "the measured file that it belongs to")
    defaults = {each.name: each.default for each in question_of(calibrate).parameters}
    passing = {"maker": "calibration.conf", "plan": 30, "measured": "visits.csv"}[mode]
    wrong = [
        Problem("", name, _in_words(value), expected, passing=((mode, passing),))
        for name, expected in unused.items()
        for value in [getattr(asked, name)]
        if value not in (defaults[name], [], ())
    ]
    if wrong:
        raise InputError(wrong)


def _in_words(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else shown(value)


def _visits_of(name: str, value: Any, given: object) -> Any:  # noqa: ANN401 - whatever a user passes
    return value if hasattr(value, "difference") else paths_of(name, value, given)


def _of_maker(arm: Arm, file: Path, seed: int) -> MakerCalibration:
    """Return a maker's calibration as errors of the arm."""
    import hashlib

    from lostmotion.analyses.calibrate.result import MakerCalibration
    from lostmotion.calibration.chain import errors_of_chain
    from lostmotion.io.maker_calibration import read_maker_calibration

    bare = arm.calibrated(None)
    chain = read_maker_calibration(file, bare)
    found = errors_of_chain(bare, chain.tool, with_tool=chain.with_tool, seed=seed)
    digest = hashlib.blake2b(file.read_bytes(), digest_size=16).hexdigest()
    return MakerCalibration(**vars(found), robot=bare, file=file, digest=digest)


@question(folder="calibrate")
def calibrate(
    arm: ArmArgument,
    measured: Annotated[
        "str | Path | Sequence[str | Path] | CalibrationVisits | None",
        Argument(
            "CSV of visits: joint values, A [deg], ..., and the tool point, x [mm], y [mm], "
            "z [mm], or its difference, dx [mm], ... Repeatable, in Python a list. With `plan`: "
            "what was measured already.",
            _visits_of,
            metavar="CSV",
            repeats=True,
        ),
    ] = None,
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
    prior: Annotated[
        Literal["release", "student-t"],
        Argument(
            "Prior of the robot's errors: normal, and wider where an error is out of tolerance "
            '("release"); or Student-t with two degrees of freedom.'
        ),
    ] = "release",
    noise: Annotated[
        Amount | None,
        Argument(
            "Standard deviation of a measured coordinate, '70 µm', with what the model lacks. "
            "Default: estimated.",
            Quantity("m", "70 µm", low=1e-9, high=1),
        ),
    ] = None,
    instrument: Annotated[
        Instrument | None,
        Argument("What was measured, where the file has columns of several instruments."),
    ] = None,
    hold_out: Annotated[
        Amount,
        Argument(
            "Share of the poses, chosen at random, whose rows no estimate uses and against which "
            "the predictions are compared, '20 %'.",
            Quantity("", "20 %", low=0, high=0.9),
        ),
    ] = 0.0,
    plan: Annotated[
        int | None,
        Argument("Choose so many poses to measure next, in place of estimates.", least=1, most=200),
    ] = None,
    maker: Annotated[
        "str | Path | None",
        Argument(
            "Calibration by the arm's maker, in place of measurements: calibration.conf of "
            "Universal Robots, or the kinematics YAML of its ROS driver.",
            path_of,
            metavar="FILE",
            aliases=("--import",),
        ),
    ] = None,
    zone: Annotated[
        "Zone | None",
        Argument(
            "Where the robot will work, 'x 0.2..0.5 m, z 0..300 mm', for `plan`. Default: its "
            "whole workspace.",
            zone_of,
            metavar="ZONE",
        ),
    ] = None,
    seed: SeedArgument = 1,
    sidecar: SidecarArgument = None,
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> Calibrated | CalibrationPlan | MakerCalibration:
    """Estimate the errors of one robot from measured poses, with the tolerances of its parts as
    prior, and predict the accuracy that remains.

    With `plan` the poses to measure are chosen, and the accuracy that they will lead to is
    predicted before anything is measured. The report's folder holds robot.toml, which every other
    command takes as `--calibration`.

    Raises
    ------
    InputError
        With every mistake in the arguments and the files; for rows that belong to another arm.

    """
    if measured is None and plan is None and maker is None:
        nothing = "neither measurements, nor a number of poses to plan, nor a maker's file"
        raise refuse_argument("measured, plan", nothing, "one of them", measured="visits.csv")
    asked = read_arguments(calibrate, locals())
    _refuse_unused(asked)
    from lostmotion.analyses.calibrate.answer import calibrated, planned_poses
    from lostmotion.analyses.calibrate.result import Calibrated, CalibrationPlan
    from lostmotion.calibration.alignment import WrongArmError
    from lostmotion.calibration.validation import numbered
    from lostmotion.io.measured.calibration_checks import FEWEST
    from lostmotion.io.measured.calibration_visits import read_calibration_visits
    from lostmotion.reporting.sheet import several

    visits = (
        asked.measured
        if asked.measured is None or hasattr(asked.measured, "difference")
        else read_calibration_visits(asked.measured, asked.arm, asked.mapping, asked.instrument)
    )
    asked.ready()
    if asked.maker is not None:
        return _of_maker(asked.arm, asked.maker, asked.seed)
    try:
        if asked.plan is None:
            poses = int(numbered(visits.q).max()) + 1
            left = poses - round(asked.hold_out * poses)
            if poses < FEWEST:
                few = f"{several(len(visits), 'row')} at {several(poses, 'pose')}"
                expected = f"rows at {FEWEST} poses or more; 10 to 50 calibrate an arm"
                raise InputError([Problem(visits.file, "", few, expected)])
            if asked.hold_out and left < FEWEST:
                expected = f"a share that leaves at least {FEWEST} of {poses} poses"
                raise refuse_argument("hold_out", asked.hold_out, expected, hold_out="20 %")
            found = calibrated(
                asked.arm,
                visits,
                terms=asked.terms,
                prior=asked.prior,
                noise=asked.noise,
                hold_out=asked.hold_out,
                seed=asked.seed,
                progress=progress,
            )
            return Calibrated(**vars(found))
        stated = None if visits is None else visits.noise
        least = asked.noise or stated or DEFAULT_NOISE
        chosen = planned_poses(asked.arm, asked.plan, asked.zone, visits, least, asked.seed)
    except WrongArmError as error:
        expected = "measurements of this arm with this tool"
        raise InputError([Problem(visits.file, "", str(error), expected)]) from None
    return CalibrationPlan(**vars(chosen))
