"""`lostmotion gear`: look at one gearbox."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lostmotion.cli.app import app
from lostmotion.cli.terminal import say


@app.command()
def gear(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="TOML with [gearbox], or an arm file with --joint.")],
    joint: Annotated[str | None, typer.Option(help="Which joint's gearbox, of an arm.")] = None,
    torque: Annotated[
        str | None, typer.Option(help="Torque at the output, '200 N m'; '500 N' for a drive that slides. Default: the rated one.")
    ] = None,
    lost_motion_torque: Annotated[
        str | None, typer.Option(help="Read lost motion at ± this torque: '4 %' of the rated one, or '12 N m'. Default: as stated, or 3 %.")
    ] = None,
    slope_range: Annotated[
        tuple[str, str] | None,
        typer.Option(help="Torques between which the stiffness is a slope. Default: '50 %' '100 %' of the rated one."),
    ] = None,
    gearboxes: Annotated[int, typer.Option(min=2, help="How many samples of a drawing are simulated.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same bits.")] = 1,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html, result.json and profile.dxf. Default: NAME-gearbox.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder, or the file of --dxf.")] = False,  # noqa: FBT002 - a switch
    dxf: Annotated[Path | None, typer.Option(help="Write the profiles to this DXF file too (cycloidal; needs ezdxf).")] = None,
) -> None:
    """Look at one gearbox: play and lost motion, stiffness and compliance by member, hysteresis, lobe loads, transmission error, profile."""
    from lostmotion.analyses.gearbox.command import look_at
    from lostmotion.analyses.gearbox.report import refuse_existing_file, write_drawing
    from lostmotion.io.dxf import CHORD_ERROR, can_draw
    from lostmotion.io.part_file import read_gearbox
    from lostmotion.reporting.folder import refuse_existing

    folder = out or Path(f"{file.stem}-gearbox")
    found = read_gearbox(file, joint)
    refuse_existing(folder, force=force)
    if dxf is not None:
        refuse_existing_file(dxf, force=force)
    names = "--torque", "--lost-motion-torque", "--slope-range"
    answer = look_at(found, names, torque, lost_motion_torque, slope_range, gearboxes, seed)
    drawing = None if dxf is None else answer.drawing()
    written = answer.report(folder, force=force)
    if dxf is not None and drawing is not None:
        write_drawing(drawing, dxf, force=force)
    answer.summary()
    say(f"\nReport: {written / 'report.html'}")
    if answer.study.drawn is not None:
        drawn = f"{dxf or written / 'profile.dxf'} (mm, chords within {CHORD_ERROR * 1e6:g} µm of the profile)"
        say(f"Drawing: {drawn}" if can_draw() else "Drawing: none, for want of ezdxf: pip install 'lostmotion[dxf]'")
