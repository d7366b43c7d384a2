"""`lostmotion iso9283`: the sheet of ISO 9283, predicted, measured, or side by side."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from lostmotion.cli.app import STOPPED, amount, app, stopped
from lostmotion.cli.terminal import say


@app.command()
def iso9283(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path | None, typer.Argument(help="Arm: native TOML, or URDF with its sidecar TOML. Left out: the measured robot alone.")] = None,
    measured: Annotated[
        list[Path] | None,
        typer.Option(help="CSV of a measured robot: pose, path, cycle, load [%], x [mm], y [mm], z [mm], xc [mm], ... May be repeated."),
    ] = None,
    load: Annotated[
        list[str] | None, typer.Option(help="Share of the payload, '10 %', that a CSV without such a column was measured under; one for each.")
    ] = None,
    mapping: Annotated[
        list[str] | None, typer.Option("--map", help="What a column of that CSV is, 'xc = x_t [mm], dx = -x_dif [mm]'. May be repeated.")
    ] = None,
    commands: Annotated[Path | None, typer.Option(help="CSV of the commanded poses: pose, x [mm], y [mm], z [mm].")] = None,
    instrument: Annotated[str | None, typer.Option(help="Standard deviation of one reading of a coordinate, '10 µm'.")] = None,
    cycles: Annotated[int, typer.Option(min=2, help="Visits to each pose.")] = 30,
    robots: Annotated[int, typer.Option(min=2, help="How many robots to build.")] = 1000,
    cube: Annotated[str | None, typer.Option(help="Side of the test cube, '400 mm', with --centre. Default: the largest found.")] = None,
    centre: Annotated[str | None, typer.Option(help="Its centre in the base frame, '600 mm, 0 mm, 400 mm'.")] = None,
    tool_rpy: Annotated[
        str | None, typer.Option(help="How the tool is held, '180 deg, 0 deg, 0 deg'. Default: what allows the largest cube.")
    ] = None,
    floor: Annotated[str, typer.Option(help="Height that the cube stays above, '0 mm'; 'none' for no floor.")] = "0 mm",
    path: Annotated[str | None, typer.Option(help="The two poses whose joining line is followed. Default: the one measured, else 'P2 P4'.")] = None,
    warm_up: Annotated[str | None, typer.Option(help="By how much the links warm, '25 K', for the drift.")] = None,
    warm_up_time: Annotated[str, typer.Option(help="Within which time 63 % of it.")] = "1 h",
    expansion: Annotated[float, typer.Option(min=0, help="Growth of the links per kelvin.")] = 23e-6,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same robots.")] = 1,
    sidecar: Annotated[Path | None, typer.Option(help="Sidecar TOML of a URDF, where it does not lie beside it.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html and result.json. Default: NAME-iso9283.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Predict the ISO 9283 sheet of an arm before it is built, judge a measured one, and set the two side by side.

    In the CSV, each row is a visit to a pose, or, with a path such as P2-P4 instead of a pose, one reading along it, in the order read.
    """
    from lostmotion.analyses.iso9283.command import AMOUNTS
    from lostmotion.analyses.iso9283.command import iso9283 as ask
    from lostmotion.analyses.iso9283.predicted import MOST_LOAD
    from lostmotion.analyses.iso9283.warm_up import WarmUp
    from lostmotion.analyses.quantities import amounts
    from lostmotion.analyses.read import read
    from lostmotion.errors import InputError, Mistakes, Problem
    from lostmotion.reporting.folder import refuse_existing
    from lostmotion.reporting.screen import ProgressBar

    stem = (file or next(iter(measured or ()), Path("robot"))).stem
    folder = out or Path(f"{stem}-iso9283")
    if file is None and not measured:
        expected = "an arm, a CSV of measured visits, or both"
        raise InputError([Problem("", "FILE, --measured", "neither", expected, 'lostmotion iso9283 arm.toml --measured "visits.csv"')])
    lowest = None if floor.strip().lower() == "none" else floor
    words = {"cube": cube, "centre": centre, "tool_rpy": tool_rpy, "floor": lowest, "instrument": instrument}
    with Mistakes() as mistakes:
        rise = mistakes.of(amount, "--warm-up", warm_up, "K", "25 K")
        constant = mistakes.of(amount, "--warm-up-time", warm_up_time, "s", "1 h") or 0.0
        read_words = mistakes.of(amounts, words, AMOUNTS, lambda name: f"--{name.replace('_', '-')}")
        shares = [mistakes.of(amount, "--load", each, "", "10 %", low=0.0, high=MOST_LOAD) or 0.0 for each in load or ()]
        ends = None if path is None else mistakes.of(_ends, path)
        arm = None if file is None else mistakes.of(read, file, sidecar)
    with ProgressBar() as bar:
        answer = ask(
            arm,
            measured or None,
            cycles=cycles,
            robots=robots,
            seed=seed,
            cube=read_words.get("cube"),
            centre=read_words.get("centre"),
            tool_rpy=read_words.get("tool_rpy"),
            floor=read_words.get("floor"),
            path=ends,
            warm_up=None if rise is None else WarmUp(rise, constant, expansion),
            load=shares,
            mapping=mapping or (),
            commands=commands,
            instrument=read_words.get("instrument", 0.0),
            progress=bar,
            ready=partial(refuse_existing, folder, force=force),
        )
    if stopped:
        raise typer.Exit(STOPPED)
    written = answer.report(folder, force=force)
    answer.summary()
    say(f"\nReport: {written / 'report.html'}")


def _ends(text: str) -> tuple[str, str]:
    """Read two names of poses."""
    from lostmotion.errors import InputError, Problem, shown

    words = text.replace(",", " ").replace("-", " ").upper().split()
    if len(words) != 2:  # noqa: PLR2004 - from one to another
        raise InputError([Problem("", "--path", shown(text), "two of P1 to P5", '--path "P2 P4"')])
    return words[0], words[1]
