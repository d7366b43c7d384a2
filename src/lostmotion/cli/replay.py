"""`lostmotion replay`: show how the largest errors of a run came about."""

from __future__ import annotations

from pathlib import Path  # noqa: TC003 - typer reads the annotations
from typing import Annotated

import typer

from lostmotion.cli.app import STOPPED, app, stopped
from lostmotion.cli.terminal import say, say_json


@app.command()
def replay(
    folder: Annotated[Path, typer.Argument(help="Folder of a run, as `lostmotion sweep` wrote it.")],
    design: Annotated[int | None, typer.Option(min=0, help="Which design, by its number from 0. Default: all of them.")] = None,
    worst: Annotated[int, typer.Option(min=1, help="How many of the largest errors, each of a pose of its own.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print data for machines.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Show how the largest errors of a run came about: pose, every draw and what it contributes. Exit code 1 where one is not reproduced."""
    from lostmotion.analyses.sweep.command import replay as again
    from lostmotion.reporting.screen import ProgressBar

    with ProgressBar() as bar:
        found = again(folder, design, worst, progress=bar)
    if stopped:
        raise typer.Exit(STOPPED)
    if as_json:
        say_json([each.result() for each in found])
    else:
        for each in found:
            each.summary()
    other = sum(not each.found.reproduced for each in found)
    if other:
        said = f"{other} of {len(found)} errors are not reproduced: the store holds other figures than its order makes"
        say(f"lostmotion: {said}\n  run the same `lostmotion sweep` in another folder", error=True)
        raise typer.Exit(1)
