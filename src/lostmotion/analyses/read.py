"""Read an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm


def read(path: str | Path | Mapping[str, Any], sidecar: str | Path | None = None) -> Arm:
    """Return the arm that a file describes: native TOML, URDF, xacro, MJCF or SDF.

    Parameters
    ----------
    path
        The arm's file, or a dictionary with what the TOML would hold.
    sidecar
        TOML that states what the other formats cannot: gearboxes, bearings, sections, tolerances.
        Default: the one of the same name beside it.

    Raises
    ------
    InputError
        With every mistake in the files.

    """
    from lostmotion.analyses.arguments import path_of, path_or_mapping
    from lostmotion.io import read as read_file

    return read_file(
        path_or_mapping("path", path), None if sidecar is None else path_of("sidecar", sidecar)
    )
