"""Result of a check: the sheet of what is known, and the picture of the arm."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.figure_files import FigureKind
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.reporting.table_files import TableKind


@dataclass(frozen=True, repr=False)
class Check(Result):
    """What a file describes: `summary()`, `result()`, and `picture`, an SVG text that is empty for
    a part by itself.
    """

    file: Path
    figures: Sheet
    arm: Arm | None = None
    out: Path | None = None

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed and written."""
        return self.figures

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
