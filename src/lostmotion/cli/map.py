"""`lostmotion map`: map the accuracy of an arm over its workspace."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from lostmotion.cli.app import STOPPED, app, stopped
from lostmotion.cli.run import Approach
from lostmotion.cli.terminal import say


class By(StrEnum):
    """Arm configurations that a cell is judged by."""

    best = "best"
    mean = "mean"
    worst = "worst"


@app.command("map")
def map_(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="Arm: native TOML, or URDF with its sidecar TOML.")],
    cell: Annotated[str | None, typer.Option(help="Edge of the cells, '50 mm'. Default: about a thirtieth of the workspace.")] = None,
    by: Annotated[By, typer.Option(help="Judge a cell by the best, the mean or the worst arm configuration looked at there.")] = By.mean,
    target: Annotated[str | None, typer.Option(help="Error that is good enough, '0.5 mm': which share of the workspace is within it.")] = None,
    box: Annotated[str | None, typer.Option(help="Work to be placed, along x, y and z: '300 mm x 200 mm x 100 mm'.")] = None,
    box_by_mean: Annotated[bool, typer.Option("--box-by-mean", help="Judge a place by the mean of its cells, not by the worst one.")] = False,  # noqa: FBT002
    turned: Annotated[bool, typer.Option("--turned", help="Let the box stand at other yaws as well, in steps of 15 deg.")] = False,  # noqa: FBT002
    clear: Annotated[str | None, typer.Option(help="How far the box keeps off the base's z axis, '200 mm'.")] = None,
    floor: Annotated[str | None, typer.Option(help="Height that the box keeps above, '0 mm', in the base frame.")] = None,
    at: Annotated[str | None, typer.Option(help="Point that the slices go through, '500 mm, 0 mm, 300 mm'. Default: the best place.")] = None,
    level: Annotated[float, typer.Option(min=0.25, max=0.9995, help="Share of errors that a cell's figure stays below.")] = 0.95,
    poses: Annotated[int, typer.Option(min=1, help="How many poses to sample; rounded up to 8 x a power of two.")] = 131_072,
    per_cell: Annotated[int, typer.Option(min=2, max=1024, help="How many arm configurations to look at in each cell.")] = 8,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same bits.")] = 1,
    approach: Annotated[Approach, typer.Option(help="Sign of every joint's last motion.")] = Approach.random,
    sidecar: Annotated[Path | None, typer.Option(help="Sidecar TOML of a URDF, where it does not lie beside it.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html, result.json and arrays.nc. Default: NAME-map.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")] = False,  # noqa: FBT002 - a switch
    threads: Annotated[int | None, typer.Option(min=1, help="Default: one per processor. Changes no result.")] = None,
) -> None:
    """Map the error over the workspace: slices, surfaces, the share within a target, the best places for work, which part is to blame where."""
    from lostmotion.analyses.quantities import amounts
    from lostmotion.analyses.read import read
    from lostmotion.analyses.workspace_map.command import AMOUNTS, zones
    from lostmotion.analyses.workspace_map.tables.placement import boxes_said
    from lostmotion.errors import Mistakes
    from lostmotion.reporting.folder import refuse_existing
    from lostmotion.reporting.screen import ProgressBar

    folder = out or Path(f"{file.stem}-map")
    words = {"cell": cell, "target": target, "box": box, "clear": clear, "floor": floor, "at": at}
    with Mistakes() as mistakes:
        asked = mistakes.of(amounts, words, AMOUNTS, lambda name: f"--{name}")
        arm = mistakes.of(read, file, sidecar)
    refuse_existing(folder, force=force)
    with ProgressBar() as bar:
        answer = zones(
            arm,
            seed=seed,
            approach=approach.value,
            threads=threads,
            progress=bar,
            by=by.value,
            level=level,
            poses=poses,
            per_cell=per_cell,
            box_by_mean=box_by_mean,
            turned=turned,
            **asked,
        )
    if stopped:
        raise typer.Exit(STOPPED)
    written = answer.report(folder, force=force)
    answer.summary()
    say(f"\nReport: {written / 'report.html'}")
    boxes = answer.found.boxes
    if boxes is not None and not boxes.found:
        say(f"lostmotion: {boxes_said(boxes, answer.found)}", error=True)
        raise typer.Exit(1)
