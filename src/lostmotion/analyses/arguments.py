"""Arguments that several questions share: each with its documentation, and the function that reads
it.

Importing this file loads neither NumPy nor the arm: `lostmotion --help` needs the texts alone, and
a mistyped word is refused at once.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import partial
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, TypeAlias

from lostmotion.analyses.quantities import each_of, read_quantities
from lostmotion.analyses.signature import Argument, whole_number
from lostmotion.errors import InputError, Mistakes, refuse_argument
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np

    from lostmotion.analyses.quantities import Amount
    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.error_model.poses import PoseLaw, Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.calibration import Calibration
    from lostmotion.spatial import Floats

DEFAULT_POSES: Final = 2048
DEFAULT_ROBOTS: Final = 1000
DEFAULT_VISITS: Final = 30
Approach = Literal["random", "up", "down"]
PoseChoice = Literal["sobol", "uniform", "normal", "grid"]
# The words for `approach`, with the sign of every joint's last motion; zero where it differs from
# visit to visit.
_SIGNS: Final = {"random": 0.0, "up": 1.0, "down": -1.0}
_END: Final = Quantity("m", "200 mm")
_TURNS: Final = Quantity("rad", "30 deg")
_SLIDES: Final = Quantity("m", "200 mm")
_FEWEST_ROBOTS: Final = 1
# Ends along the base's axes: as text, or in m.
Ends: TypeAlias = "str | Mapping[str, tuple[Amount, Amount]]"
# A zone of the workspace: its ends, or which poses are in it.
Zone: TypeAlias = "Ends | np.ndarray"
# A pose: its number, the values of all joints as text, or each of them.
At: TypeAlias = "int | str | Floats | tuple[Amount, ...]"


def path_of(name: str, value: object, _given: object = None, *, example: str = "arm.toml") -> Path:
    """Return the path of a file or folder. Raises InputError for what is neither text nor a
    path.
    """
    if not isinstance(value, str | os.PathLike):
        raise refuse_argument(name, value, "a path, as text or pathlib.Path", **{name: example})
    return Path(value)


def out_argument(text: str, example: str, metavar: str) -> Argument:
    """Return the argument of the file or folder that a question writes, without a default."""
    return Argument(text, partial(path_of, example=example), metavar=metavar, aliases=("-o",))


def path_or_mapping(name: str, value: object, _given: object = None) -> Path | Mapping[str, Any]:
    """Return the path of a file with a request, or its dictionary; errors as `path_of`."""
    return value if isinstance(value, Mapping) else path_of(name, value)


def paths_of(name: str, value: Any, _given: object = None) -> list[Path]:  # noqa: ANN401 - whatever a user passes
    """Return the paths of one file or several. Raises InputError as `path_of`."""
    return [path_of(name, each) for each in (value if isinstance(value, list | tuple) else [value])]


def arm_of(name: str, value: object, given: Mapping[str, Any]) -> Arm:
    """Return an arm, read from its file or a dictionary, calibrated where the question has a
    `calibration`, and with the constraints open that make the larger error (`with_larger_error`).
    Raises InputError with every mistake in the files.
    """
    if isinstance(value, str | os.PathLike | Mapping):
        from lostmotion.io import read

        sidecar = given.get("sidecar")
        beside = Path(sidecar) if isinstance(sidecar, str | os.PathLike) else None
        arm = read(value if isinstance(value, Mapping) else Path(value), beside)
    else:
        from lostmotion.mechanism.arm import Arm

        if not isinstance(value, Arm):
            expected = "an arm, the path of its file, or a dictionary"
            raise refuse_argument(name, value, expected, **{name: "arm.toml"})
        arm = value
    from lostmotion.mechanism.assembly import may_not_assemble

    arm = _calibrated(arm, given.get("calibration"))
    if may_not_assemble(arm):
        from lostmotion.error_model.opened_constraints import with_larger_error

        arm = with_larger_error(arm)
    return arm


def _calibrated(arm: Arm, calibration: object) -> Arm:
    """Return the arm of the robot with these estimates, read from their file where a path is given;
    the arm itself where there are none. Raises InputError with every mistake in the file.
    """
    if calibration is None:
        return arm
    from lostmotion.mechanism.calibration import Calibration

    if isinstance(calibration, str | os.PathLike):
        from lostmotion.io.calibration_file import read_calibration

        calibration = read_calibration(Path(calibration), arm)
    if not isinstance(calibration, Calibration):
        expected = "a calibration, or the path of its file"
        raise refuse_argument("calibration", calibration, expected, calibration="robot-17.toml")
    return arm.calibrated(calibration)


def poses_of(name: str, value: Any, given: Mapping[str, Any]) -> int | Poses:  # noqa: ANN401 - whatever a user passes
    """Return how many poses are wanted, or those given: as `Poses`, as joint values (pose, joint)
    in rad and m, or in a CSV file.

    Raises InputError with every mistake in the file.
    """
    count = whole_number(value)
    if count is not None and count >= 1:
        return count
    is_file = isinstance(value, os.PathLike) or (
        isinstance(value, str) and (value.lower().endswith(".csv") or os.path.exists(value))  # noqa: PTH110
    )
    if not is_file and (value is None or isinstance(value, str | Integral)):
        raise refuse_argument(
            name,
            value,
            "a whole number, at least 1, or a CSV file of poses",
            **{name: DEFAULT_POSES},
        )
    arm = given["arm"]
    if not hasattr(arm, "moving"):  # the arm's own mistakes are reported already
        return value  # type: ignore[no-any-return]
    import numpy as np

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.state import as_poses

    if isinstance(value, Poses):
        return value
    if is_file:
        from lostmotion.io.poses import read_poses

        return Poses(read_poses(Path(value), arm), "given")
    try:
        return Poses(as_poses(arm, np.asarray(value, dtype=float)), "given")
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        expected = f"how many, a CSV file, or joint values q (pose, {len(arm.driven)}) in rad and m"
        raise refuse_argument(name, str(error), expected, **{name: DEFAULT_POSES}) from None


def chosen_poses(arm: Arm, poses: int | Poses, law: PoseLaw, seed: int) -> Poses:
    """Return the poses to visit: as many as wanted by this law, or those given."""
    from lostmotion.error_model.poses import sample_poses

    return sample_poses(arm, poses, law, seed) if isinstance(poses, int) else poses


def sign_of(_name: str, value: object, _given: object = None) -> float:
    """Return the sign of every joint's last motion, zero where it differs from visit to visit.
    Raises InputError for another word.
    """
    if value not in _SIGNS:
        raise refuse_argument("approach", value, "one of " + ", ".join(_SIGNS), approach="random")
    return _SIGNS[str(value)]


def zone_of(name: str, value: Any, _given: object = None) -> dict[str, tuple[float, float]]:  # noqa: ANN401 - whatever a user passes
    """Return the limits (m) of a zone along the base's axes, from text, "x 0.2..0.5 m", or {"x":
    (0.2, "500 mm")}. Raises InputError.
    """
    from lostmotion.error_model.pose_selection import checked_ends
    from lostmotion.io.pose_and_zone_text import read_zone

    if isinstance(value, str):
        return read_zone(value, name)
    if isinstance(value, Mapping):
        return checked_ends(_read_ends(name, value))
    expected = (
        'text, "x 0.2..0.5 m, z 0..300 mm", or limits along the base\'s axes in m, {"x": (0.2, '
        '0.5), "z": (0, 0.3)}'
    )
    raise refuse_argument(name, value, expected, **{name: "x 0.2..0.5 m"})


def zones_of(name: str, value: Any, given: object = None) -> list[Any]:  # noqa: ANN401 - whatever a user passes
    """Return one zone or several: ends as `zone_of`, or which poses are in it (pose,), as given.
    Raises InputError with every mistake.
    """
    with Mistakes() as mistakes:
        return [
            each if _is_mask(each) else mistakes.of(zone_of, name, each, given)
            for each in several(value)
        ]


def several(value: Any) -> list[Any]:  # noqa: ANN401 - whatever a user passes
    """Return what a list or tuple holds; anything else, also one truth value per pose, by
    itself.
    """
    return list(value) if isinstance(value, list | tuple) and not _is_mask(value) else [value]


def _is_mask(value: Any) -> bool:  # noqa: ANN401 - whatever a user passes
    first = value[0] if isinstance(value, list | tuple) and value else value
    return isinstance(first, bool) or hasattr(first, "dtype")


def _read_ends(name: str, zone: Mapping[Any, Any]) -> dict[Any, Any]:
    """Read the ends that are text, in m; whatever is neither text nor a number is left for
    `checked_ends` to refuse.
    """
    pairs = {axis: pair for axis, pair in zone.items() if isinstance(pair, tuple | list)}
    texts = {
        (axis, k): end
        for axis, pair in pairs.items()
        for k, end in enumerate(pair)
        if isinstance(end, str)
    }
    read = read_quantities(texts, dict.fromkeys(texts, _END), lambda _: name)
    return {
        **zone,
        **{
            axis: tuple(read.get((axis, k), end) for k, end in enumerate(pair))
            for axis, pair in pairs.items()
        },
    }


def pose_of(name: str, value: Any, given: Mapping[str, Any]) -> Any:  # noqa: ANN401 - whatever a user passes
    """Return a pose's number, or joint values in rad and m, from text, "A=30deg B=-10deg", or
    values of which some are text. Raises InputError.
    """
    arm = given["arm"]
    # else the arm's own mistakes are reported already
    if isinstance(value, str) and hasattr(arm, "moving"):
        from lostmotion.io.pose_and_zone_text import read_pose

        return read_pose(value, arm, name)
    if (
        isinstance(value, tuple | list)
        and any(isinstance(each, str) for each in value)
        and hasattr(arm, "moving")
    ):
        import numpy as np

        fields = [_SLIDES if joint.type == "prismatic" else _TURNS for joint in arm.driven]
        if len(value) != len(fields):
            raise refuse_argument(
                name,
                value,
                f"{len(fields)} joint values, or a number",
                **{name: "A=30deg B=-10deg"},
            )
        return np.array(each_of(name, value, fields))
    return value


def poses_at(name: str, value: Any, given: Mapping[str, Any]) -> list[Any]:  # noqa: ANN401 - whatever a user passes
    """Return one pose, or a list of several, each as `pose_of`. Raises InputError with every
    mistake.
    """
    with Mistakes() as mistakes:
        return [
            mistakes.of(pose_of, name, each, given)
            for each in (value if isinstance(value, list) else [value])
        ]


def reducers_of(name: str, value: Any, _given: object = None) -> tuple[GearboxRow, ...]:  # noqa: ANN401 - whatever a user passes
    """Return rows of reducers, read from their file where a path is given. Raises InputError with
    every mistake in the file.
    """
    if not isinstance(value, str | os.PathLike):
        return tuple(value)
    from lostmotion.io.own_reducers import read_reducers

    return read_reducers(path_of(name, value))


def reducers_beside(arm: object, rows: Sequence[GearboxRow]) -> tuple[GearboxRow, ...]:
    """Return these rows, and those in the arm's file or dictionary where it may hold some."""
    if isinstance(arm, Mapping):
        from lostmotion.io.own_reducers import take_reducers
        from lostmotion.io.toml import content

        return (*rows, *take_reducers("arm", content("arm", arm))[0])
    file = Path(arm) if isinstance(arm, str | os.PathLike) else None
    return (
        *rows,
        *(reducers_of("arm", file) if file is not None and file.suffix.lower() == ".toml" else ()),
    )


ArmArgument: TypeAlias = Annotated[
    "Arm | str | Path | Mapping[str, Any]",
    Argument(
        "Arm: native TOML; or URDF, xacro, MJCF or SDF with its sidecar TOML. In Python also a "
        "dictionary with what the TOML would hold.",
        arm_of,
        metavar="FILE",
    ),
]
SidecarArgument: TypeAlias = Annotated[
    "str | Path | None",
    Argument(
        "Sidecar TOML of a URDF, xacro, MJCF or SDF file. Default: the one of the same name "
        "beside it.",
        path_of,
        metavar="SIDECAR",
    ),
]
CalibrationArgument: TypeAlias = Annotated[
    "Calibration | str | Path | None",
    Argument(
        "Estimates of the errors of one robot, in TOML: the answer is for that robot. Default: "
        "none, any robot of this kind.",
        lambda _name, value, _given: value,  # read with the arm
        metavar="CALIBRATION",
    ),
]
JointArgument: TypeAlias = Annotated[
    str | None, Argument("Name of the joint, where the file is an arm.", metavar="JOINT")
]
PosesArgument: TypeAlias = Annotated[
    "int | str | Path | Floats | Poses",
    Argument(
        "How many poses to visit, rounded up to 8 x a power of two for sobol, to a multiple "
        "of 8 for uniform and normal; or a CSV file of poses, "
        "one column per joint with a header like 'A [deg]'. In Python also joint values "
        "(pose, joint) in rad and m.",
        poses_of,
        metavar="COUNT|CSV",
        aliases=("--poses-file",),
    ),
]
PoseLawArgument: TypeAlias = Annotated[
    PoseChoice,
    Argument("How poses are chosen within the joint limits; 'normal' is the method of the paper."),
]
RobotsArgument: TypeAlias = Annotated[
    int,
    Argument(
        "How many manufactured robots are simulated; each visits every pose.", least=_FEWEST_ROBOTS
    ),
]
VisitsArgument: TypeAlias = Annotated[
    int, Argument("How often each robot visits each pose; ISO 9283 asks for 30.", least=1)
]
SeedArgument: TypeAlias = Annotated[
    int, Argument("Seed of the random draws: same seed, same result.", least=0)
]
ApproachArgument: TypeAlias = Annotated[
    Approach,
    Argument(
        "Direction of every joint's last motion; 'random': either, from visit to visit.", sign_of
    ),
]
ThreadsArgument: TypeAlias = Annotated[
    int | None,
    Argument("Number of threads; no figure depends on it. Default: one per processor.", least=1),
]
ReducersArgument: TypeAlias = Annotated[
    "str | Path | Sequence[GearboxRow]",
    Argument(
        (
            "TOML with [[reducers]] of your own, used besides the catalogue and those in the "
            "arm's file."
        ),
        reducers_of,
        metavar="REDUCERS",
    ),
]
ProgressArgument: TypeAlias = Annotated[
    "Callable[[str, int, int], None] | None",
    Argument(
        "Called with the step, how many of its parts are done, and of how many.", python_only=True
    ),
]
ReadyArgument: TypeAlias = Annotated[
    "Callable[[], object] | None",
    Argument(
        "Called once all arguments are read and valid, before the computation.", python_only=True
    ),
]
