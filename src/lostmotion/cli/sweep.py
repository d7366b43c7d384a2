"""`lostmotion sweep`: carry out a big run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lostmotion.cli.app import STOPPED, app, stopped
from lostmotion.cli.run import Approach, PoseChoice
from lostmotion.cli.terminal import say


@app.command()
def sweep(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="Arm: native TOML, or URDF with its sidecar TOML; its [sweep] says which keys take which values.")],
    by: Annotated[Path | None, typer.Option(help="TOML with [sweep], in place of the arm's own. Without either, one design.")] = None,
    poses: Annotated[
        int, typer.Option(min=1, help="How many poses each design visits, any number; rounded up to 8 x a power of two for sobol.")
    ] = 2048,
    pose_law: Annotated[PoseChoice, typer.Option(help="How poses are chosen within the joint limits; 'normal' is the paper's.")] = PoseChoice.sobol,
    poses_file: Annotated[Path | None, typer.Option(help="CSV of poses to visit instead: one column per joint, header like 'A [deg]'.")] = None,
    robots: Annotated[int, typer.Option(min=1, help="How many robots are built of each design.")] = 1000,
    visits: Annotated[int, typer.Option(min=1, help="How often each returns to each pose; ISO 9283 asks for 30.")] = 30,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same bytes.")] = 1,
    approach: Annotated[Approach, typer.Option(help="Sign of every joint's last motion.")] = Approach.random,
    block: Annotated[int | None, typer.Option(min=1, help="Poses computed and kept at a time. Default: 1024, fewer with many robots.")] = None,
    sidecar: Annotated[Path | None, typer.Option(help="Sidecar TOML of a URDF, where it does not lie beside it.")] = None,
    out: Annotated[Path | None, typer.Option(help="The run's folder; a run that was stopped goes on there. Default: NAME-sweep.")] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads. Default: one per processor. Changes no byte.")] = None,
    dask: Annotated[str | None, typer.Option(help="Compute on Dask instead: local:N processes, or a scheduler's address. Changes no byte.")] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but where the report is.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Study an arm at any number of poses, or a grid of designs, block by block; stopped or killed, the same command goes on."""
    from lostmotion.analyses.sweep.command import sweep as carry_out
    from lostmotion.reporting.screen import ProgressBar

    folder = out or Path(f"{file.stem}-sweep")
    kept = f"what is done is kept in '{folder}'; the same command goes on"
    try:
        with ProgressBar() as bar:
            answer = carry_out(
                file,
                by,
                poses_file or poses,
                robots,
                visits,
                seed,
                sidecar=sidecar,
                pose_law=pose_law.value,
                approach=approach.value,
                block=block,
                out=folder,
                workers=workers,
                dask=dask,
                progress=bar,
            )
    except KeyboardInterrupt:
        say(f"lostmotion: {kept}", error=True)
        raise typer.Exit(STOPPED) from None
    if stopped:
        say(f"lostmotion: {kept}", error=True)
        raise typer.Exit(STOPPED)
    written = answer.report()
    if not quiet:
        answer.summary()
    say(f"\nReport: {written / 'report.html'}")
