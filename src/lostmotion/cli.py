"""The command line: `lostmotion run FILE`, `lostmotion schema`."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from lostmotion.errors import LostmotionError

app = typer.Typer(
    help="How accurate will this robot arm be before it is built, where in its workspace, and which part is to blame?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


class PoseChoice(StrEnum):
    """Laws by which poses are chosen."""

    sobol = "sobol"
    uniform = "uniform"
    normal = "normal"
    grid = "grid"


class Approach(StrEnum):
    """From which side the joints arrive."""

    random = "random"
    up = "up"
    down = "down"


@app.command()
def run(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="Arm: native TOML, or URDF with its sidecar TOML.")],
    poses: Annotated[int, typer.Option(min=1, help="How many poses to visit.")] = 2048,
    pose_law: Annotated[PoseChoice, typer.Option(help="How poses are chosen within the joint limits; 'normal' is the paper's.")] = PoseChoice.sobol,
    poses_file: Annotated[Path | None, typer.Option(help="CSV of poses to visit instead: one column per joint, header like 'A [deg]'.")] = None,
    robots: Annotated[int, typer.Option(min=1, help="How many robots are built.")] = 1000,
    visits: Annotated[int, typer.Option(min=1, help="How often each returns to each pose; ISO 9283 asks for 30.")] = 30,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same bits.")] = 1,
    approach: Annotated[Approach, typer.Option(help="Sign of every joint's last motion.")] = Approach.random,
    sidecar: Annotated[Path | None, typer.Option(help="Sidecar TOML of a URDF, where it does not lie beside it.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html, result.json and arrays.nc. Default: NAME-accuracy.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")] = False,  # noqa: FBT002 - a switch
    threads: Annotated[int | None, typer.Option(min=1, help="Default: one per processor. Changes no result.")] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but where the report is.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Study an arm: print its accuracy, and write the report, the figures and the arrays."""
    from lostmotion.ask import read, study
    from lostmotion.report import refuse_existing
    from lostmotion.screen import ProgressBar

    folder = out or Path(f"{file.stem}-accuracy")
    refuse_existing(folder, force=force)  # before the work, not after it
    arm = read(file, sidecar)
    chosen: object = poses
    if poses_file is not None:
        from lostmotion.formats.poses import read_poses
        from lostmotion.studies.poses import Poses

        chosen = Poses(read_poses(poses_file, arm), "given")
    sign = {Approach.random: 0.0, Approach.up: 1.0, Approach.down: -1.0}[approach]
    with ProgressBar("visiting poses") as bar:
        answer = study(arm, chosen, robots, visits, seed, pose_law=pose_law.value, approach=sign, threads=threads, progress=bar)  # type: ignore[arg-type]
    if not quiet:
        answer.summary()
    written = answer.report(folder, force=force)
    typer.echo(f"\nReport: {written / 'report.html'}")


@app.command()
def schema() -> None:
    """Print the JSON Schema of the native TOML, for editors."""
    import json

    from lostmotion.formats.schema import json_schema

    typer.echo(json.dumps(json_schema(), indent=2, ensure_ascii=False))


def main() -> None:
    """Run the command line; a mistake in the input is one message and exit code 2, never a traceback."""
    try:
        app()
    except LostmotionError as error:
        typer.echo(f"lostmotion: {error}", err=True)
        sys.exit(2)
    except KeyboardInterrupt:
        typer.echo("lostmotion: stopped; nothing was written", err=True)
        sys.exit(130)
