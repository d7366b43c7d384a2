"""Check a file before any study: what it states, what is assumed, what is ideal."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from lostmotion.analyses.arguments import CalibrationArgument, SidecarArgument, arm_of, path_of
from lostmotion.analyses.result import Result
from lostmotion.analyses.signature import Argument, question, read_arguments

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.figure_files import FigureKind
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.reporting.table_files import TableKind


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

    part = _kind_of_part(asked.file)
    if part:
        from lostmotion.analyses.check.page import part_sheet
        from lostmotion.io.part_file import read_bearing, read_gearbox

        return Check(
            asked.file,
            part_sheet(
                read_gearbox(asked.file) if part == "gearbox" else read_bearing(asked.file), part
            ),
        )
    from lostmotion.analyses.check.page import arm_sheet

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


@dataclass(frozen=True, repr=False)
class Check(Result):
    """What a file describes: `summary()`, `result()`, and `picture`, an SVG text that is empty for
    a part by itself.
    """

    file: Path
    printed: Sheet
    arm: Arm | None = None
    out: Path | None = None

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed and written."""
        return self.printed

    @property
    def picture(self) -> str:
        """Return the arm from the side, from the front and from above, as SVG text."""
        from lostmotion.reporting.arm_picture import arm_picture

        return arm_picture(self.arm) if self.arm is not None else ""

    def report(
        self,
        out: str | Path | None = None,
        *,
        force: bool = False,
        figures: FigureKind | None = None,  # noqa: ARG002 - of a report with plots
        tables: TableKind | None = None,  # noqa: ARG002 - the same
    ) -> Path:
        """Write the picture as an SVG file and return its path; nothing is written for a part by
        itself. It is the only file of a check.

        Default: the path that the check was given, or NAME.svg in the current folder. An earlier
        picture of this kind is replaced, any other file only with `force`. Raises
        OutputExistsError, and LostmotionError where the file cannot be written.
        """
        from lostmotion.reporting.arm_picture import write_picture

        target = Path(out or self.out or f"{self.file.stem}.svg")
        if self.arm is not None:
            write_picture(self.picture, target, force=force)
        return target

    def outcome(self, written: Path) -> str:
        """Return the line that names the picture; empty where there is none."""
        return f"Picture: {written}" if self.arm is not None else ""
