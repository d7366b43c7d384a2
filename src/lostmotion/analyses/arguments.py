"""What several verbs are told alike: poses, a zone, seed, and from which side joints arrive."""

from __future__ import annotations

import os
from collections.abc import Mapping
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias, overload

import numpy as np

from lostmotion.analyses.quantities import amounts, each_of
from lostmotion.error_model.poses import PoseLaw, Poses, sample_poses
from lostmotion.errors import InputError, Problem, refuse_argument
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.analyses.quantities import Amount
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

DEFAULT_POSES = 2048
DEFAULT_ROBOTS = 1000
DEFAULT_VISITS = 30
Approach = Literal["random", "up", "down"]
# A zone of the workspace: as on the command line, ends along the base's axes in m, or which poses are in it.
Ends: TypeAlias = "str | Mapping[str, tuple[Amount, Amount]]"
Zone: TypeAlias = "Ends | np.ndarray"
_END: Final = Quantity("m", "200 mm")
_TURNS: Final = Quantity("rad", "30 deg")
_SLIDES: Final = Quantity("m", "200 mm")
_SIGNS: Final = {"random": 0.0, "up": 1.0, "down": -1.0}


def an_arm(arm: object) -> Arm:
    """Which arm is meant? Raises InputError for anything else, above all the path of one, which `lostmotion.read` reads."""
    from lostmotion.mechanism.arm import Arm

    if not isinstance(arm, Arm):
        raise refuse_argument("arm", arm, "an arm, as lostmotion.read gives it", 'lostmotion.read("z-arm.toml")')
    return arm


def a_path(name: str, path: object) -> Path:
    """Which file or folder is meant? Raises InputError for what is neither text nor a path."""
    if not isinstance(path, str | os.PathLike):
        raise refuse_argument(name, path, "the path of it, as text or pathlib.Path", f'{name} = "z-arm.toml"')
    return Path(path)


def sign_of(approach: str) -> float:
    """Which sign has every joint's last motion? Zero where it differs from visit to visit. Raises InputError for another word."""
    if approach not in _SIGNS:
        raise refuse_argument("approach", approach, "one of " + ", ".join(_SIGNS), 'approach = "random"')
    return _SIGNS[approach]


def whole_seed(seed: object) -> int:
    """Which seed is this? Raises InputError for anything but a whole number, zero or more."""
    if not isinstance(seed, Integral) or seed < 0:
        raise refuse_argument("seed", seed, "a whole number, zero or more", "seed = 1")
    return int(seed)


def chosen_poses(arm: Arm, poses: int | Floats | Poses, law: PoseLaw, seed: int) -> Poses:
    """Which poses are meant: so many by this law, or those given, as `Poses` or as q (pose, joint) in rad and m? Raises InputError."""
    if isinstance(poses, Integral):
        return sample_poses(arm, int(poses), law, seed)
    if isinstance(poses, Poses):
        return poses
    from lostmotion.mechanism.serial import as_poses

    try:
        return Poses(as_poses(arm, np.asarray(poses, dtype=float)), "given")
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        expected = f"how many, or joint values q (pose, {len(arm.moving)}) in rad and m"
        raise InputError([Problem("", "poses", str(error), expected, "poses = 2048")]) from None


@overload
def zone_of(zone: Any) -> dict[str, tuple[float, float]]: ...  # noqa: ANN401 - whatever a user names it by


@overload
def zone_of(zone: Any, *, of_poses: int) -> dict[str, tuple[float, float]] | np.ndarray: ...  # noqa: ANN401 - whatever a user names it by


def zone_of(zone: Any, *, of_poses: int | None = None) -> dict[str, tuple[float, float]] | np.ndarray:
    """Which zone is meant: by text as on the command line, "x 0.2..0.5 m", or by ends along the base's axes in m, {"x": (0.2, 0.5)}?

    With `of_poses`, also by a truth value for each of so many poses. Raises InputError with every mistake, and for anything else.
    """
    from lostmotion.error_model.pose_selection import checked_ends
    from lostmotion.io.pose_and_zone_text import read_zone

    if isinstance(zone, str):
        return read_zone(zone, "zone")
    if isinstance(zone, Mapping):
        return checked_ends(_read_ends(zone))
    expected = 'text, "x 0.2..0.5 m, z 0..300 mm", or ends along the base\'s axes in m, {"x": (0.2, 0.5), "z": (0, 0.3)}'
    if of_poses is not None:
        mask = np.asarray(zone)
        if mask.shape == (of_poses,) and mask.dtype == bool:
            return mask
        expected += f", or a truth value for each of the {of_poses} poses"
    raise refuse_argument("zone", zone, expected, 'zone = "x 0.2..0.5 m"')


def _read_ends(zone: Mapping[Any, Any]) -> dict[Any, Any]:
    """Read the ends that are text, in m; whatever is none of text and numbers is left for `checked_ends` to refuse."""
    pairs = {axis: pair for axis, pair in zone.items() if isinstance(pair, tuple | list)}
    texts = {(axis, k): end for axis, pair in pairs.items() for k, end in enumerate(pair) if isinstance(end, str)}
    read = amounts(texts, dict.fromkeys(texts, _END), lambda _: "zone")
    return {**zone, **{axis: tuple(read.get((axis, k), end) for k, end in enumerate(pair)) for axis, pair in pairs.items()}}


def pose_of(arm: Arm, pose: Any) -> Any:  # noqa: ANN401 - whatever a user names it by
    """Which pose is meant: by text as on the command line, "A=30deg B=-10deg", or by joint values of which some are text, "30 deg"?

    Gives its number, or joint values in rad and m; anything else as it is. Raises InputError with every mistake.
    """
    from lostmotion.io.pose_and_zone_text import read_pose

    if isinstance(pose, str):
        return read_pose(pose, arm, "pose")
    if isinstance(pose, tuple | list) and any(isinstance(value, str) for value in pose):
        fields = [_SLIDES if joint.type == "prismatic" else _TURNS for joint in arm.moving]
        if len(pose) != len(fields):
            raise refuse_argument("pose", pose, f"{len(fields)} joint values, or a number", 'pose = "A=30deg B=-10deg"')
        return np.array(each_of("pose", pose, fields))
    return pose
