"""Read an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm


def read(path: str | Path, sidecar: str | Path | None = None) -> Arm:
    """Which arm does this file describe? Native TOML or URDF, by its ending.

    `sidecar` is the TOML that says what a URDF cannot (gearboxes, bearings, sections, tolerances). Raises InputError with every mistake in the file.
    """
    from lostmotion.analyses.arguments import a_path
    from lostmotion.io import read as read_file

    return read_file(a_path("path", path), None if sidecar is None else a_path("sidecar", sidecar))
