"""Check a file before any study: what it states, what is assumed, what is ideal."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from lostmotion.analyses.arguments import CalibrationArgument, SidecarArgument, arm_of, path_of
from lostmotion.analyses.signature import Argument, question, read_arguments

if TYPE_CHECKING:
    from lostmotion.analyses.check.result import Check


@question(folder="")
def check(
    file: Annotated[
        "str | Path",
        Argument(
            "Arm, gearbox or bearing: TOML, or a robot description with its sidecar.",
            path_of,
            metavar="FILE",
        ),
    ],
    *,
    sidecar: SidecarArgument = None,
    calibration: CalibrationArgument = None,
    out: Annotated[
        "str | Path | None",
        Argument("SVG with the picture of the arm. Default: NAME.svg.", path_of, metavar="SVG"),
    ] = None,
) -> Check:
    """Report what a file states, assumes and leaves ideal, per joint, with the static load of each
    drive and a picture of the arm.

    Nothing is sampled, so the answer comes at once. Every mistake is reported with its file and
    line.

    Raises
    ------
    InputError
        With every mistake in the files.

    """
    asked = read_arguments(check, locals())
    from lostmotion.analyses.check.result import Check

    part = _kind_of_part(asked.file)
    if part:
        from lostmotion.analyses.check.tables import part_sheet
        from lostmotion.io.part_file import read_bearing, read_gearbox

        return Check(
            asked.file,
            part_sheet(
                read_gearbox(asked.file) if part == "gearbox" else read_bearing(asked.file), part
            ),
        )
    from lostmotion.analyses.check.tables import arm_sheet

    arm = arm_of("file", asked.file, vars(asked))
    return Check(
        asked.file,
        arm_sheet(arm, str(asked.file), "" if asked.sidecar is None else str(asked.sidecar)),
        arm,
        asked.out,
    )


def _kind_of_part(file: Path) -> str:
    """Return "gearbox" or "bearing" for a file that describes one by itself; empty for an arm, and
    for a file that cannot be read.
    """
    if file.suffix.lower() != ".toml" or not file.is_file():
        return ""
    from lostmotion.errors import InputError
    from lostmotion.io.toml import read_toml

    try:
        tree: dict[str, Any] = read_toml(file)
    except InputError:
        return ""  # its reader reports it
    return (
        ""
        if "joints" in tree
        else next((kind for kind in ("gearbox", "bearing") if kind in tree), "")
    )
