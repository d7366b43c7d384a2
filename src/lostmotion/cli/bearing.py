"""`lostmotion bearing`: look at one bearing."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final

import typer

from lostmotion.cli.app import amount, app
from lostmotion.cli.terminal import say

# N or N m: no bearing of a robot carries more.
_MOST: Final = 1e9


@app.command()
def bearing(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="TOML with [bearing], or an arm file with --joint.")],
    joint: Annotated[str | None, typer.Option(help="Which joint's bearing, of an arm.")] = None,
    force_radial: Annotated[str | None, typer.Option(help="Load across the axis, '2 kN'. Default: 1 kN where no load is stated.")] = None,
    force_axial: Annotated[str | None, typer.Option(help="Load along the axis, '500 N'; below zero the other way.")] = None,
    moment: Annotated[str | None, typer.Option(help="Moment in the plane of both, '30 N m'.")] = None,
    built: Annotated[int, typer.Option(min=1, help="How many bearings are built.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same bits.")] = 1,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html and result.json. Default: NAME-bearing.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Look at one bearing: its clearance from delivery to work, the load of each element, how far the shaft gives, how stiff it is."""
    from lostmotion.analyses.bearing.bearing import BearingLoad, examine
    from lostmotion.analyses.bearing.report import write_bearing
    from lostmotion.analyses.bearing.tables import bearing_sheet
    from lostmotion.errors import Mistakes
    from lostmotion.io.part_file import read_bearing
    from lostmotion.parts.bearing.rolling_contact import DrawnBearing
    from lostmotion.reporting.folder import refuse_existing
    from lostmotion.reporting.screen import print_sheet

    folder = out or Path(f"{file.stem}-bearing")
    with Mistakes() as mistakes:
        stated = (
            mistakes.of(amount, "--force-radial", force_radial, "N", "2 kN", low=-_MOST, high=_MOST),
            mistakes.of(amount, "--force-axial", force_axial, "N", "500 N", low=-_MOST, high=_MOST),
            mistakes.of(amount, "--moment", moment, "N m", "30 N m", low=-_MOST, high=_MOST),
        )
        found = mistakes.of(read_bearing, file, joint)
    assumed = all(each is None for each in stated)
    load = BearingLoad(1000.0) if assumed else BearingLoad(*(each or 0.0 for each in stated))
    refuse_existing(folder, force=force)
    notes = (*found.notes, "no load was stated: 1 kN across is assumed") if assumed else found.notes
    examined = examine(found.part, load, built, seed) if isinstance(found.part, DrawnBearing) else None
    sheet = bearing_sheet(found.name, found.part, load, examined, notes)
    written = write_bearing(sheet, examined, folder, force=force)
    print_sheet(sheet)
    say(f"\nReport: {written / 'report.html'}")
