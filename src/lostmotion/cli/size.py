"""`lostmotion size`: choose the sections of an arm's links by limits, or all its parts for a target on the tool."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from lostmotion.cli.app import STOPPED, app, stopped
from lostmotion.cli.terminal import say


@app.command()
def size(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="Arm: native TOML, or URDF with its sidecar TOML.")],
    by: Annotated[
        Path | None, typer.Option(help="TOML with [sizing]: limits, and what each link may be made of. Default: sections like its own.")
    ] = None,
    target: Annotated[
        str | None,
        typer.Option(help="Most 95 % error of the tool over the workspace, '0.5 mm': links, and what --by offers, are chosen for it."),
    ] = None,
    minimise: Annotated[str | None, typer.Option(help="What is small with a target: 'mass' (default), 'price', 'price + 20 * mass'.")] = None,
    slope: Annotated[str | None, typer.Option(help="Most slope of a link's tip, '0.5 arcmin'. Default: that, the paper's.")] = None,
    deflection: Annotated[
        str | None, typer.Option(help="Most deflection of a link's tip: its length over this, '2500'. Default: that, the paper's.")
    ] = None,
    family: Annotated[str | None, typer.Option(help="Kind of section for every link, 'tube', with --outer and --wall; others by --by.")] = None,
    outer: Annotated[str | None, typer.Option(help="Outside diameter of the tubes, '30 mm .. 200 mm'.")] = None,
    wall: Annotated[str | None, typer.Option(help="Wall of the tubes, '3 mm', '2 mm .. 6 mm' or '5 %' of the outside diameter.")] = None,
    tilt: Annotated[str | None, typer.Option(help="By how much the base may lean from level, towards any side, '10 deg'.")] = None,
    poses: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="How many poses to look at; rounded up to 8 x a power of two. Default: 1024, or 128 in a search for a target.",
        ),
    ] = None,
    poses_file: Annotated[Path | None, typer.Option(help="CSV of poses to look at besides: one column per joint, header like 'A [deg]'.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same poses.")] = 1,
    sidecar: Annotated[Path | None, typer.Option(help="Sidecar TOML of a URDF, where it does not lie beside it.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html, result.json and sized.toml. Default: NAME-sized.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Choose the lightest sections that keep an arm's links within slope and deflection, or the cheapest parts within a target on the tool."""
    from lostmotion.analyses.read import read
    from lostmotion.analyses.sizing.arm_writer import reads_back
    from lostmotion.analyses.sizing.command import size as size_arm
    from lostmotion.errors import refuse_argument
    from lostmotion.io.own_reducers import read_reducers
    from lostmotion.io.poses import read_poses
    from lostmotion.reporting.folder import refuse_existing
    from lostmotion.reporting.screen import ProgressBar

    folder = out or Path(f"{file.stem}-sized")
    tube = {name: text for name, text in (("kind", family), ("outer", outer), ("wall", wall)) if text is not None}
    if family not in {None, "tube"}:
        raise refuse_argument("--family", family, "tube, with --outer and --wall; other kinds in a file, by --by", "--family tube")
    words = {"target": target, "minimise": minimise, "slope": slope, "deflection": deflection, "tilt": tilt}
    arm = read(file, sidecar)
    refuse_existing(folder, force=force)
    own = read_reducers(file) if file.suffix.lower() == ".toml" else ()
    also = None if poses_file is None else read_poses(poses_file, arm)
    with ProgressBar() as bar:
        asked: dict[str, Any] = {name: word for name, word in words.items() if word is not None} | (
            {"family": {"kind": "tube", **tube}} if tube else {}
        )
        answer = size_arm(arm, by, poses, seed, also=also, reducers=own, progress=bar, **asked)
    if stopped:
        raise typer.Exit(STOPPED)
    written = answer.report(folder, file, sidecar, force=force)
    answer.summary()
    say(f"\nReport: {written / 'report.html'}")
    if not answer.found.holds:
        say(f"lostmotion: {answer.sheet.verdict}", error=True)
        raise typer.Exit(1)
    doubt = reads_back(file, written / "sized.toml", answer.found)
    say(f"Sized arm: {written / 'sized.toml'}" + (f"; {doubt}" if doubt else ""))
