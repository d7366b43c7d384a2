"""Read an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm


def read(path: str | Path, sidecar: str | Path | None = None) -> Arm:
    """Return the arm that a file describes: native TOML, URDF, xacro or MJCF.

    Parameters
    ----------
    path
        The arm's file.
    sidecar
        TOML that states what the other formats cannot: gearboxes, bearings, sections, tolerances.
        Default: the one of the same name beside it.

    Raises
    ------
    InputError
        With every mistake in the files.

    """
    from lostmotion.analyses.arguments import path_of
    from lostmotion.io import read as read_file

    return read_file(
        path_of("path", path), None if sidecar is None else path_of("sidecar", sidecar)
    )
