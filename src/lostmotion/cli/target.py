"""`lostmotion target`: what a target asks of an arm's parts."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lostmotion.cli.app import STOPPED, app, stopped
from lostmotion.cli.terminal import say

if TYPE_CHECKING:
    from lostmotion.error_model.poses import Poses


class Arrival(StrEnum):
    """From which side the joints arrive."""

    random = "random"
    up = "up"
    down = "down"


@app.command()
def target(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="Arm: native TOML, or URDF with its sidecar TOML.")],
    error: Annotated[str | None, typer.Option(help="Target: so far may 95 % of all positions over the workspace be off, '0.5 mm'.")] = None,
    repeatability: Annotated[str | None, typer.Option(help="Target instead: within this do 95 % of the robots repeat (RP), '0.1 mm'.")] = None,
    share: Annotated[str, typer.Option(help="Share of positions, or of robots, 50 % to 99.9 %.")] = "0.95",
    poses: Annotated[int, typer.Option(min=1, help="How many poses to visit; rounded up to 8 x a power of two.")] = 1024,
    poses_file: Annotated[Path | None, typer.Option(help="CSV of poses to visit instead: one column per joint, header like 'A [deg]'.")] = None,
    zone: Annotated[str | None, typer.Option(help="Only poses with the tool in this zone, in the base's axes: 'x 0.2..0.5 m, z 0..300 mm'.")] = None,
    robots: Annotated[int, typer.Option(min=1, help="How many robots are built to verify, and to count the yield.")] = 1000,
    visits: Annotated[int, typer.Option(min=1, help="How often each returns to each pose; ISO 9283 asks for 30.")] = 30,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same bits.")] = 1,
    approach: Annotated[Arrival, typer.Option(help="Sign of every joint's last motion.")] = Arrival.random,
    sidecar: Annotated[Path | None, typer.Option(help="Sidecar TOML of a URDF, where it does not lie beside it.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html and result.json. Default: NAME-target.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")] = False,  # noqa: FBT002 - a switch
    threads: Annotated[int | None, typer.Option(min=1, help="Default: one per processor. Changes no result.")] = None,
) -> None:
    """Say how large play, clearance, tolerances and all else may be for a target, part by part and all together, and how many robots keep it."""
    from lostmotion.analyses.read import read
    from lostmotion.analyses.targets.command import target as ask
    from lostmotion.errors import Mistakes
    from lostmotion.io.pose_and_zone_text import read_zone
    from lostmotion.reporting.folder import refuse_existing
    from lostmotion.reporting.screen import ProgressBar

    folder = out or Path(f"{file.stem}-target")
    with Mistakes() as mistakes:
        arm = mistakes.of(read, file, sidecar)
        within = None if zone is None else mistakes.of(read_zone, zone)
    refuse_existing(folder, force=force)
    chosen: int | Poses = poses
    if poses_file is not None:
        from lostmotion.error_model.poses import Poses
        from lostmotion.io.poses import read_poses

        chosen = Poses(read_poses(poses_file, arm), "given")
    with ProgressBar() as bar:
        answer = ask(
            arm,
            error=error,
            repeatability=repeatability,
            share=share,
            poses=chosen,
            zone=within,
            robots=robots,
            visits=visits,
            seed=seed,
            approach=approach.value,
            threads=threads,
            progress=bar,
        )
    if stopped:
        raise typer.Exit(STOPPED)
    written = answer.report(folder, force=force)
    answer.summary()
    say(f"\nReport: {written / 'report.html'}")
