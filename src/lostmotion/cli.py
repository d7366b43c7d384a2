"""The command line: one function here per command, `lostmotion run FILE` and the others that `lostmotion --help` lists."""

from __future__ import annotations

import math
import os
import signal
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lostmotion import __version__
from lostmotion.errors import LostmotionError

if TYPE_CHECKING:
    from types import FrameType

    from lostmotion.studies.poses import Poses

_stopped: list[bool] = []
_STOPPED = 130  # the shell's own code for it

app = typer.Typer(
    help="How accurate will this robot arm be before it is built, where in its workspace, and which part is to blame?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(wanted: bool) -> None:  # noqa: FBT001 - typer hands the switch over
    if wanted:
        typer.echo(f"lostmotion {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[bool, typer.Option("--version", help="Print the version and stop.", is_eager=True, callback=_print_version)] = False,  # noqa: FBT002
) -> None:
    """Take the options that go before a command."""


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


class Method(StrEnum):
    """Routes to the position error."""

    montecarlo = "montecarlo"
    analytic = "analytic"
    both = "both"


@app.command()
def run(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="Arm: native TOML, or URDF with its sidecar TOML.")],
    poses: Annotated[
        int,
        typer.Option(min=1, help="How many poses to visit; rounded up to 8 x a power of two for sobol, to a multiple of 8 for uniform and normal."),
    ] = 2048,
    pose_law: Annotated[PoseChoice, typer.Option(help="How poses are chosen within the joint limits; 'normal' is the paper's.")] = PoseChoice.sobol,
    poses_file: Annotated[Path | None, typer.Option(help="CSV of poses to visit instead: one column per joint, header like 'A [deg]'.")] = None,
    robots: Annotated[int, typer.Option(min=1, help="How many robots are built.")] = 1000,
    visits: Annotated[int, typer.Option(min=1, help="How often each returns to each pose; ISO 9283 asks for 30.")] = 30,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same bits.")] = 1,
    approach: Annotated[Approach, typer.Option(help="Sign of every joint's last motion.")] = Approach.random,
    method: Annotated[Method, typer.Option(help="By samples, by sums over terms without sampling, or both, compared.")] = Method.montecarlo,
    sidecar: Annotated[Path | None, typer.Option(help="Sidecar TOML of a URDF, where it does not lie beside it.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html, result.json and arrays.nc. Default: NAME-accuracy.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")] = False,  # noqa: FBT002 - a switch
    threads: Annotated[int | None, typer.Option(min=1, help="Default: one per processor. Changes no result.")] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but where the report is.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Study an arm: print its accuracy, and write the report, the figures and the arrays."""
    from lostmotion.ask import read, study
    from lostmotion.report.folder import refuse_existing
    from lostmotion.screen import ProgressBar

    folder = out or Path(f"{file.stem}-accuracy")
    refuse_existing(folder, force=force)  # before the work, not after it
    arm = read(file, sidecar)
    chosen: int | Poses = poses
    if poses_file is not None:
        from lostmotion.formats.poses import read_poses
        from lostmotion.studies.poses import Poses

        chosen = Poses(read_poses(poses_file, arm), "given")
    with ProgressBar() as bar:
        answer = study(
            arm, chosen, robots, visits, seed, pose_law=pose_law.value, approach=approach.value, method=method.value, threads=threads, progress=bar
        )
    if _stopped:
        raise typer.Exit(_STOPPED)
    written = answer.report(folder, force=force)  # before anything is printed: a closed pipe must not cost the results
    if not quiet:
        answer.summary()
    typer.echo(f"\nReport: {written / 'report.html'}")


class CatalogueKind(StrEnum):
    """What the catalogue holds."""

    gearbox = "gearbox"
    bearing = "bearing"
    material = "material"


@app.command()
def catalog(  # noqa: PLR0913, PLR0917 - options of a command line
    name: Annotated[str | None, typer.Argument(help="One entry whole: a reducer with or without its ratio, a material, a table of bearings.")] = None,
    kind: Annotated[CatalogueKind | None, typer.Option(help="Only these.")] = None,
    maker: Annotated[str, typer.Option(help="Part of the maker's name.")] = "",
    ratio: Annotated[str | None, typer.Option(help="A ratio of which the figures hold.")] = None,
    min_torque: Annotated[str | None, typer.Option(help="Least rated torque, '300 N m'.")] = None,
    max_lost_motion: Annotated[str | None, typer.Option(help="Most lost motion as printed, '1 arcmin'.")] = None,
    min_stiffness: Annotated[str | None, typer.Option(help="Least stiffness, of the softest zone, '50 N m/arcmin'.")] = None,
    file: Annotated[Path | None, typer.Option(help="TOML with [[reducers]] of your own, looked through as well.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print data for machines.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Search the catalogue of reducers, bearings and materials; every figure with its source and how sure it is."""
    from lostmotion.catalogue.search import Wanted
    from lostmotion.figures.catalogue import catalogue_sheet
    from lostmotion.formats.own_reducers import read_reducers

    wanted = Wanted(
        maker,
        _amount("--ratio", ratio, "", "100"),
        _amount("--min-torque", min_torque, "N m", "300 N m"),
        _amount("--max-lost-motion", max_lost_motion, "rad", "1 arcmin"),
        _amount("--min-stiffness", min_stiffness, "N m/rad", "50 N m/arcmin"),
    )
    sheet = catalogue_sheet(wanted, kind.value if kind else None, name, read_reducers(file) if file else ())
    if as_json:
        import json

        typer.echo(json.dumps({"lostmotion": __version__, **sheet.facts}, indent=2, ensure_ascii=False))
    else:
        from lostmotion.screen import print_sheet

        print_sheet(sheet)


@app.command()
def gear(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="TOML with [gearbox], or an arm file with --joint.")],
    joint: Annotated[str | None, typer.Option(help="Which joint's gearbox, of an arm.")] = None,
    torque: Annotated[
        str | None, typer.Option(help="Torque at the output, '200 N m'; '500 N' for a drive that slides. Default: the rated one.")
    ] = None,
    gearboxes: Annotated[int, typer.Option(min=2, help="How many gearboxes of a drawing are built.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same bits.")] = 1,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html, result.json and profile.dxf. Default: NAME-gearbox.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder, or the file of --dxf.")] = False,  # noqa: FBT002 - a switch
    dxf: Annotated[Path | None, typer.Option(help="Write the profiles to this DXF file too (cycloidal; needs ezdxf).")] = None,
) -> None:
    """Look at one gearbox: play and lost motion as built, what gives way, hysteresis, lobe loads, transmission error, profile."""
    from lostmotion.figures.gearbox import units_of
    from lostmotion.formats.dxf import CHORD_ERROR, can_draw
    from lostmotion.formats.part_file import read_gearbox
    from lostmotion.report.folder import refuse_existing
    from lostmotion.report.gearbox import refuse_existing_file, write_drawing
    from lostmotion.shown import Gear
    from lostmotion.studies.gear import gear as look_at

    folder = out or Path(f"{file.stem}-gearbox")
    refuse_existing(folder, force=force)
    if dxf is not None:
        refuse_existing_file(dxf, force=force)
    found = read_gearbox(file, joint)
    units = units_of(found.part)
    asked = _amount("--torque", torque, units.torque, "200 N m" if units.torque == "N m" else "500 N")
    answer = Gear(found.name, found.notes, look_at(found.part, asked, gearboxes, seed))
    drawing = None if dxf is None else answer.drawing()
    written = answer.report(folder, force=force)
    if dxf is not None and drawing is not None:
        write_drawing(drawing, dxf, force=force)
    answer.summary()
    typer.echo(f"\nReport: {written / 'report.html'}")
    if answer.study.drawn is not None:
        drawn = f"{dxf or written / 'profile.dxf'} (mm, chords within {CHORD_ERROR * 1e6:g} µm of the profile)"
        typer.echo(f"Drawing: {drawn}" if can_draw() else "Drawing: none, for want of ezdxf: pip install 'lostmotion[dxf]'")


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
    from lostmotion.figures.bearing import bearing_sheet
    from lostmotion.formats.part_file import read_bearing
    from lostmotion.parts.bearing.drawn import DrawnBearing
    from lostmotion.parts.bearing.examined import BearingLoad, examine
    from lostmotion.report.bearing import write_bearing
    from lostmotion.report.folder import refuse_existing
    from lostmotion.screen import print_sheet

    folder = out or Path(f"{file.stem}-bearing")
    refuse_existing(folder, force=force)
    stated = (
        _amount("--force-radial", force_radial, "N", "2 kN", above=-math.inf),
        _amount("--force-axial", force_axial, "N", "500 N", above=-math.inf),
        _amount("--moment", moment, "N m", "30 N m", above=-math.inf),
    )
    assumed = all(each is None for each in stated)
    load = BearingLoad(1000.0) if assumed else BearingLoad(*(each or 0.0 for each in stated))
    found = read_bearing(file, joint)
    notes = (*found.notes, "no load was stated: 1 kN across is assumed") if assumed else found.notes
    examined = examine(found.part, load, built, seed) if isinstance(found.part, DrawnBearing) else None
    sheet = bearing_sheet(found.name, found.part, load, examined, notes)
    written = write_bearing(sheet, examined, folder, force=force)
    print_sheet(sheet)
    typer.echo(f"\nReport: {written / 'report.html'}")


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
    from lostmotion.ask import read
    from lostmotion.figures.statics import statics_sheet
    from lostmotion.formats.own_reducers import read_reducers
    from lostmotion.report.folder import refuse_existing
    from lostmotion.studies.poses import sample_poses
    from lostmotion.studies.survey import survey

    folder = out or Path(f"{file.stem}-statics")
    if not as_json:
        refuse_existing(folder, force=force)
    leaning = _amount("--tilt", tilt, "rad", "10 deg", above=-sys.float_info.min)
    arm = read(file, sidecar)
    found = survey(arm, sample_poses(arm, poses, seed=seed), leaning)
    sheet = statics_sheet(found, read_reducers(file) if file.suffix == ".toml" else ())
    if as_json:
        import json

        from lostmotion.figures import plain

        typer.echo(json.dumps(plain(sheet, __version__), indent=2, ensure_ascii=False, allow_nan=False))
        return
    from lostmotion.report.statics import write_statics
    from lostmotion.screen import print_sheet

    written = write_statics(sheet, found, folder, force=force)
    print_sheet(sheet)
    typer.echo(f"\nReport: {written / 'report.html'}")


@app.command()
def size(  # noqa: PLR0913, PLR0917 - options of a command line
    file: Annotated[Path, typer.Argument(help="Arm: native TOML, or URDF with its sidecar TOML.")],
    by: Annotated[
        Path | None, typer.Option(help="TOML with [sizing]: limits, and what each link may be made of. Default: sections like its own.")
    ] = None,
    slope: Annotated[str | None, typer.Option(help="Most slope of a link's tip, '0.5 arcmin'. Default: that, the paper's.")] = None,
    deflection: Annotated[
        str | None, typer.Option(help="Most deflection of a link's tip: its length over this, '2500'. Default: that, the paper's.")
    ] = None,
    family: Annotated[str | None, typer.Option(help="Kind of section for every link, 'tube', with --outer and --wall; others by --by.")] = None,
    outer: Annotated[str | None, typer.Option(help="Outside diameter of the tubes, '30 mm .. 200 mm'.")] = None,
    wall: Annotated[str | None, typer.Option(help="Wall of the tubes, '3 mm', '2 mm .. 6 mm' or '5 %' of the outside diameter.")] = None,
    tilt: Annotated[str | None, typer.Option(help="By how much the base may lean from level, towards any side, '10 deg'.")] = None,
    poses: Annotated[int, typer.Option(min=1, help="How many poses to look at; rounded up to 8 x a power of two.")] = 1024,
    poses_file: Annotated[Path | None, typer.Option(help="CSV of poses to look at besides: one column per joint, header like 'A [deg]'.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same poses.")] = 1,
    sidecar: Annotated[Path | None, typer.Option(help="Sidecar TOML of a URDF, where it does not lie beside it.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html, result.json and sized.toml. Default: NAME-sized.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Choose the lightest sections of an arm's links that keep slope and deflection within limits, and say what other limits would cost."""
    from lostmotion import ask
    from lostmotion.formats.poses import read_poses
    from lostmotion.formats.sized import reads_back
    from lostmotion.report.folder import refuse_existing
    from lostmotion.screen import ProgressBar

    folder = out or Path(f"{file.stem}-sized")
    refuse_existing(folder, force=force)
    tube = {name: text for name, text in (("kind", family), ("outer", outer), ("wall", wall)) if text is not None}
    words = {"slope": slope, "deflection": deflection, "tilt": tilt, "family": {"kind": "tube", **tube} if tube else None}
    arm = ask.read(file, sidecar)
    also = None if poses_file is None else read_poses(poses_file, arm)
    with ProgressBar() as bar:
        answer = ask.size(arm, by, poses, seed, also=also, progress=bar, **{name: word for name, word in words.items() if word is not None})
    if _stopped:
        raise typer.Exit(_STOPPED)
    written = answer.report(folder, file, sidecar, force=force)
    answer.summary()
    typer.echo(f"\nReport: {written / 'report.html'}")
    if not answer.found.holds:
        typer.echo(f"lostmotion: {answer.sheet.verdict}", err=True)
        raise typer.Exit(1)
    doubt = reads_back(file, written / "sized.toml", answer.found)
    typer.echo(f"Sized arm: {written / 'sized.toml'}" + (f"; {doubt}" if doubt else ""))


def _amount(option: str, text: str | None, si: str, example: str, above: float = 0.0) -> float | None:
    """Read what an option asks for, in SI; raises InputError for another dimension, no unit, or an amount that is not above `above`."""
    from pydantic_core import PydanticCustomError

    from lostmotion.errors import InputError, Problem, shown
    from lostmotion.units import Quantity, Toleranced

    if text is None:
        return None
    field = Quantity(si, example, above=above)
    try:
        amount = field(text)
    except PydanticCustomError as error:
        why = (error.context or {})["why"]
        raise InputError([Problem("", option, f"{shown(text)} ({why})", field.expected, f'{option} "{example}"')]) from None
    return amount.nominal if isinstance(amount, Toleranced) else amount


@app.command()
def schema() -> None:
    """Print the JSON Schema of the native TOML, for editors."""
    import json

    from lostmotion.formats.schema import json_schema

    typer.echo(json.dumps(json_schema(), indent=2, ensure_ascii=False))


def main() -> None:
    """Run the command line; a mistake in the input is one message and exit code 2, never a traceback."""
    signal.signal(signal.SIGINT, _stop)
    try:
        app()
    except LostmotionError as error:
        code, message = 2, str(error)
    except MemoryError:
        code, message = 2, "not enough memory for that many poses, robots or visits; nothing was written"
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or Python complains once more when it closes the pipe
        code, message = 1, "the output was closed before all was printed; the results are written"
    typer.echo(f"lostmotion: {message}", err=True)
    sys.exit(code)


def _stop(_signal: int, _frame: FrameType | None) -> None:
    """Remember that the user wants to stop: compiled code may swallow the exception and go on with half a result."""
    _stopped.append(True)
    typer.echo("\nlostmotion: stopped", err=True)
    raise KeyboardInterrupt
