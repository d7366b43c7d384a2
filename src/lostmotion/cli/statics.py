"""`lostmotion statics`: what every joint carries and how much the arm gives."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from lostmotion.cli.app import amount, app
from lostmotion.cli.terminal import say, say_json
from lostmotion.version import __version__


@app.command()
def statics(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="Arm: native TOML, or URDF with its sidecar TOML.")],
    tilt: Annotated[str | None, typer.Option(help="By how much the base may lean from level, towards any side, '10 deg'.")] = None,
    poses: Annotated[int, typer.Option(min=1, help="How many poses to visit; rounded up to 8 x a power of two.")] = 4096,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same poses.")] = 1,
    sidecar: Annotated[Path | None, typer.Option(help="Sidecar TOML of a URDF, where it does not lie beside it.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print data for machines, and write nothing.")] = False,  # noqa: FBT002 - a switch
    out: Annotated[Path | None, typer.Option(help="Folder for report.html and result.json. Default: NAME-statics.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Say what every joint carries and which reducers do, and how much the arm gives: where, in which direction, by which part."""
    from lostmotion.analyses.read import read
    from lostmotion.analyses.statics.survey import survey
    from lostmotion.analyses.statics.tables import statics_sheet
    from lostmotion.error_model.poses import sample_poses
    from lostmotion.errors import Mistakes
    from lostmotion.io.own_reducers import read_reducers
    from lostmotion.reporting.folder import refuse_existing

    folder = out or Path(f"{file.stem}-statics")
    with Mistakes() as mistakes:
        leaning = mistakes.of(amount, "--tilt", tilt, "rad", "10 deg", low=0, high=math.pi)
        arm = mistakes.of(read, file, sidecar)
    if not as_json:
        refuse_existing(folder, force=force)
    found = survey(arm, sample_poses(arm, poses, seed=seed), leaning)
    sheet = statics_sheet(found, read_reducers(file) if file.suffix == ".toml" else ())
    if as_json:
        from lostmotion.reporting.sheet import plain

        say_json(plain(sheet, __version__))
        return
    from lostmotion.analyses.statics.report import write_statics
    from lostmotion.reporting.screen import print_sheet

    written = write_statics(sheet, found, folder, force=force)
    print_sheet(sheet)
    say(f"\nReport: {written / 'report.html'}")
