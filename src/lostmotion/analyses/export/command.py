"""Export the model of an arm for its controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, TypeAlias

from lostmotion.analyses.arguments import (
    ArmArgument,
    CalibrationArgument,
    SidecarArgument,
    out_argument,
)
from lostmotion.analyses.quantities import Amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import OutputExistsError, refuse_argument
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from lostmotion.controller_model.controller import Controller

# By this file an earlier export is recognised.
_MARKS: Final = ("src/lm_model.h", "model/src/lm_model.h")


def write_files(files: Mapping[str, str], out: Path, *, force: bool) -> Path:
    """Write files, by their path within the folder `out`, and return the folder.

    Raises OutputExistsError where the folder has files and `force` is not set or they are no
    earlier export, LostmotionError where it cannot be written. With `force` files of other names
    stay.
    """
    from lostmotion.reporting.folder import write_file

    if not force and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise OutputExistsError(
            f"'{out}' exists\n  replace its files with --force (force=True in Python), or name "
            "another folder with --out"
        )
    if out.is_dir() and any(out.iterdir()) and not any((out / mark).exists() for mark in _MARKS):
        raise OutputExistsError(
            f"'{out}' has files that are no export\n  name another folder with --out"
        )
    for name, content in files.items():
        write_file(content.encode(), out / name, force=True)
    return out


def write_fmu(out: Path, content: bytes, *, force: bool) -> Path:
    """Write an FMU and return its path.

    Raises InputError for a name without .fmu, OutputExistsError where it exists and `force` is not
    set, LostmotionError as `write_files`.
    """
    from lostmotion.reporting.folder import write_file

    if out.suffix.lower() != ".fmu":
        raise refuse_argument("out", str(out), "a file that ends in .fmu", out="arm.fmu")
    return write_file(content, out, force=force)


_LargestPayload: TypeAlias = Annotated[
    Amount | None,
    Argument(
        "Largest payload for which the model answers. Default: twice that of the file.",
        Quantity("kg", "10 kg", above=0),
    ),
]


def _input_in_words(written: dict[str, Any]) -> list[str]:
    """Return the lines about the input of any export: its hash and the remarks."""
    return [
        f"SHA-256 of the input: {written['sha256'][:16]}…",
        *(f"note: {each}" for each in written["remarks"]),
    ]


def _c_in_words(written: dict[str, Any]) -> str:
    """Return what was written as C source, and how it is built."""
    from lostmotion.reporting.sheet import several

    folder = written["folder"]
    return "\n".join(
        [
            (
                f"C source of a model with {several(len(written['joints']), 'joint')}, "
                f"{several(len(written['files']), 'file')}."
            ),
            *_input_in_words(written),
            "Build and test:",
            f"  cmake -S {folder} -B build && cmake --build build && ctest --test-dir build",
            f"Folder: {folder}   begin with its README.md.",
        ]
    )


def _ros2_in_words(written: dict[str, Any]) -> str:
    """Return what was written as a package for ROS 2, and how it is started."""
    return "\n".join(
        [
            f"Package {written['package']} for ROS 2, joints {', '.join(written['joints'])}.",
            *_input_in_words(written),
            "Build and start, in a workspace:",
            f"  colcon build && ros2 launch {written['package']} compensation.launch.py",
            f"Folder: {written['folder']}   begin with its README.md.",
        ]
    )


def _fmu_in_words(written: dict[str, Any]) -> str:
    """Return what was written as an FMU."""
    library = written["library"]
    return "\n".join(
        [
            f"FMU for co-simulation, FMI {written['version']}, library: {library}.",
            *_input_in_words(written),
            f"File: {written['fmu']}",
        ]
    )


def _sources(
    asked: Any,  # noqa: ANN401 - the arguments of any export
    *,
    single: bool = False,
    unroll: bool = False,
) -> tuple[Controller, dict[str, str], dict[str, Any]]:
    """Return the controller of the arm, its C sources by path, and what every export reports: hash
    of the input and remarks.
    """
    from lostmotion.analyses.export.model import c_files, controller, input_hash, remarks_on

    model = controller(asked.arm, largest_payload=asked.largest_payload)
    sha256, remarks = input_hash(asked.arm), remarks_on(asked.arm)
    files = c_files(model, asked.arm, remarks, sha256, single=single, unroll=unroll)
    return model, files, {"sha256": sha256, "remarks": remarks}


@question(folder=None, in_words=_c_in_words)
def export_c(
    arm: ArmArgument,
    *,
    out: Annotated["str | Path", out_argument("Folder for the sources.", "model", "FOLDER")],
    sidecar: SidecarArgument = None,
    precision: Annotated[
        Literal["double", "float"], Argument("Type of all numbers in C.")
    ] = "double",
    unroll: Annotated[
        bool,
        Argument("Write the prediction out for this arm, without loops: faster, with more code."),
    ] = False,
    largest_payload: _LargestPayload = None,
    calibration: CalibrationArgument = None,
    force: Annotated[bool, Argument("Replace files of an earlier export.")] = False,
) -> dict[str, Any]:
    """Write the error model of an arm as C source that predicts and compensates in fixed time,
    without allocation.

    Raises
    ------
    InputError
        With every mistake in the arguments and the file.
    OutputExistsError
        Where the folder has files, unless `force` is set.

    """
    asked = read_arguments(export_c, locals())
    model, files, about = _sources(asked, single=asked.precision == "float", unroll=asked.unroll)
    folder = write_files(files, asked.out, force=asked.force)
    return {
        "folder": str(folder),
        "files": sorted(files),
        "joints": list(model.tables.joints),
        **about,
    }


@question(folder=None, in_words=_ros2_in_words)
def export_ros2(
    arm: ArmArgument,
    *,
    out: Annotated[
        "str | Path", out_argument("Folder for the package.", "my_robot_compensation", "FOLDER")
    ],
    sidecar: SidecarArgument = None,
    largest_payload: _LargestPayload = None,
    calibration: CalibrationArgument = None,
    force: Annotated[bool, Argument("Replace files of an earlier export.")] = False,
) -> dict[str, Any]:
    """Write a package for ROS 2: a chainable controller of ros2_control that sends corrected joint
    commands, with the model of the arm, names and limits of its joints, and a launch file.

    Raises
    ------
    InputError
        With every mistake in the arguments and the file.
    OutputExistsError
        Where the folder has files, unless `force` is set.

    """
    asked = read_arguments(export_ros2, locals())
    from lostmotion.analyses.export.model import bulleted, markdown
    from lostmotion.io.ros2_package import package_name, ros2_files

    model, sources, about = _sources(asked)
    title, remarks = markdown(model.tables.name), bulleted(about["remarks"])
    files = ros2_files(model, sources, title, remarks)
    folder = write_files(files, asked.out, force=asked.force)
    return {
        "folder": str(folder),
        "package": package_name(model.tables.name),
        "files": sorted(files),
        "joints": list(model.tables.joints),
        **about,
    }


@question(folder=None, in_words=_fmu_in_words)
def export_fmu(
    arm: ArmArgument,
    *,
    out: Annotated["str | Path", out_argument("The FMU to write.", "arm.fmu", "FILE.fmu")],
    sidecar: SidecarArgument = None,
    version: Annotated[Literal["3.0", "2.0"], Argument("Version of the FMI standard.")] = "3.0",
    largest_payload: _LargestPayload = None,
    calibration: CalibrationArgument = None,
    force: Annotated[bool, Argument("Replace an earlier export.")] = False,
) -> dict[str, Any]:
    """Write the error model of an arm as an FMU for co-simulation: C sources, and a library for
    this platform where it has a C compiler.

    Raises
    ------
    InputError
        With every mistake in the arguments and the file.
    OutputExistsError
        Where the file exists, unless `force` is set.

    """
    asked = read_arguments(export_fmu, locals())
    from lostmotion.io.fmu import fmu

    model, sources, about = _sources(asked)
    content, folder = fmu(model, sources, asked.version)
    path = write_fmu(asked.out, content, force=asked.force)
    return {
        "fmu": str(path),
        "version": asked.version,
        "library": folder or "none: no C compiler found",
        **about,
    }
