"""The wording of a sheet of each question, with its numbers replaced by #, kept as text.

    python -m tests.reporting.snapshots [NAME ...]

rewrites the texts in tests/reporting/snapshots/ after a change of words; `git diff` shows what a
reader will see. Figures are tested by their keys elsewhere, so no text here depends on them.
"""

from __future__ import annotations

import io
import re
import sys
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Final
from unittest import mock

from rich.console import Console

import lostmotion
from lostmotion.maps import validation_points
from lostmotion.reporting.screen import print_sheet

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.reporting.sheet import Sheet

ROOT: Final = Path(__file__).parents[2]
EXAMPLES: Final = ROOT / "examples"
FOLDER: Final = Path(__file__).with_suffix("")
Z_ARM: Final = EXAMPLES / "z-arm.toml"
_SMALL: Final = {"poses": 64, "robots": 40, "visits": 4, "seed": 1}
_NUMBER: Final = re.compile(r"\d+(?:[ .]\d+)*(?:e[-−+]?\d+)?")


def _of_map() -> Sheet:
    """Return the sheet of a map that is validated at few points, from few sampled poses."""
    with (
        mock.patch.object(validation_points, "SAMPLED", 2048),
        mock.patch.object(validation_points, "_POWER", 8),
    ):
        return lostmotion.map(Z_ARM, cell="200 mm", poses=256, target="1 mm").sheet


SHEETS: Final[dict[str, Callable[[], Sheet]]] = {
    "study": lambda: lostmotion.study(Z_ARM, **_SMALL).sheet,
    "map": _of_map,
    "iso9283": lambda: (
        lostmotion.iso9283(
            Z_ARM, measured=EXAMPLES / "measured" / "z-arm.csv", robots=40, instrument="5 µm"
        ).sheet
    ),
    "target": lambda: (
        lostmotion.target(
            EXAMPLES / "planar-2r.toml", error="1 mm", poses=64, robots=40, visits=4
        ).sheet
    ),
    "size": lambda: lostmotion.size(Z_ARM, poses=64).sheet,
    "statics": lambda: lostmotion.statics(Z_ARM, poses=64, tilt="10 deg").sheet,
    "task": lambda: (
        lostmotion.task(
            EXAMPLES / "six-axis.toml", EXAMPLES / "tasks" / "peg-in-hole.toml", robots=40, runs=4
        ).sheet
    ),
    "gear": lambda: lostmotion.gear(EXAMPLES / "gearbox" / "printed.toml", gearboxes=10).sheet,
    "bearing": lambda: (
        lostmotion.bearing(EXAMPLES / "bearing" / "6209-pair.toml", bearings=20).sheet
    ),
    "compare": lambda: lostmotion.compare(Z_ARM, EXAMPLES / "gantry.toml", **_SMALL).sheet,
}


def wording(sheet: Sheet) -> str:
    """Return the whole sheet as `--full` prints it, without numbers and the widths that follow from
    them.
    """
    printed = io.StringIO()
    print_sheet(sheet, Console(file=printed, width=2000))
    lines = []
    for line in printed.getvalue().replace(f"{ROOT}/", "").splitlines():
        masked = re.sub(r"[█-▏]+", "█", re.sub(r"[─━]+", "─", _NUMBER.sub("#", line)))
        lines += textwrap.wrap(re.sub(r"\s+", " ", masked).strip(), 100) or [""]
    return re.sub(r"\n{2,}", "\n\n", "\n".join(lines)).strip() + "\n"


def main(names: list[str]) -> None:
    """Rewrite the texts of these sheets, or of all."""
    FOLDER.mkdir(exist_ok=True)
    for name in names or SHEETS:
        (FOLDER / f"{name}.txt").write_text(wording(SHEETS[name]()), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
