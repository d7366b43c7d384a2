"""`lostmotion run`: study an arm."""

from __future__ import annotations

import logging
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lostmotion.cli.app import STOPPED, app, stopped
from lostmotion.cli.terminal import say

if TYPE_CHECKING:
    from lostmotion.analyses.accuracy.command import AnalyticStudy, Study
    from lostmotion.analyses.accuracy.undescribed import Undescribed


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


class DeviceChoice(StrEnum):
    """Where samples are formed."""

    cpu = "cpu"
    gpu = "gpu"


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
    until: Annotated[
        str | None, typer.Option(help="Go on until mean, 95 % error, AP and RP are this sure: '1 %' of each figure, or '2 digits' of it.")
    ] = None,
    most_robots: Annotated[int, typer.Option(min=1, help="How many robots are built at most, with --until.")] = 10_000,
    at: Annotated[
        list[str] | None, typer.Option(help="Say who is to blame at a pose as well: its number, or every joint, 'A=30deg B=-10deg'. May come again.")
    ] = None,
    zone: Annotated[
        list[str] | None,
        typer.Option(help="The error, and who is to blame, in a zone as well, in the base's axes: 'x 0.2..0.5 m, z 0..300 mm'. May come again."),
    ] = None,
    sidecar: Annotated[Path | None, typer.Option(help="Sidecar TOML of a URDF, where it does not lie beside it.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for report.html, result.json and arrays.nc. Default: NAME-accuracy.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing output folder.")] = False,  # noqa: FBT002 - a switch
    threads: Annotated[int | None, typer.Option(min=1, help="Default: one per processor. Changes no result.")] = None,
    device: Annotated[DeviceChoice, typer.Option(help="Where samples are formed; gpu needs pip install 'lostmotion[gpu]'.")] = DeviceChoice.cpu,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but where the report is.")] = False,  # noqa: FBT002 - a switch
) -> None:
    """Study an arm: print its accuracy, and write the report, the figures and the arrays."""
    from lostmotion.analyses.accuracy.command import study
    from lostmotion.analyses.accuracy.undescribed import undescribed
    from lostmotion.analyses.read import read
    from lostmotion.error_model.pose_selection import one_pose
    from lostmotion.error_model.poses import Poses, sample_poses
    from lostmotion.error_model.provenance import states
    from lostmotion.errors import Mistakes
    from lostmotion.io.pose_and_zone_text import read_pose, read_zone
    from lostmotion.propagation.montecarlo.stopping import Tolerance
    from lostmotion.reporting.folder import refuse_existing
    from lostmotion.reporting.screen import ProgressBar

    folder = out or Path(f"{file.stem}-accuracy")
    with Mistakes() as mistakes:
        arm = mistakes.of(read, file, sidecar)
        at_poses = [mistakes.of(read_pose, text, arm) for text in at or () if arm]
        zones = [mistakes.of(read_zone, text) for text in zone or ()]
        if until is not None:
            mistakes.of(Tolerance.of, until)
    refuse_existing(folder, force=force)  # before the work, not after it
    chosen: int | Poses = poses
    if poses_file is not None:
        from lostmotion.io.poses import read_poses

        chosen = Poses(read_poses(poses_file, arm), "given")
    if at_poses:
        visited = chosen if isinstance(chosen, Poses) else sample_poses(arm, chosen, pose_law.value, seed)
        for pose in at_poses:  # before the work, and not after it
            one_pose(visited.q, pose)
    if device is DeviceChoice.gpu:
        # JAX logs a driver that does not load with its whole traceback; one message tells how to see it.
        logging.getLogger("jax").setLevel(logging.CRITICAL)
    if not states(arm).described:
        _finish(undescribed(arm, chosen, pose_law.value, seed, file, sidecar), folder, force=force, quiet=quiet)
        return
    with ProgressBar() as bar:
        answer = study(
            arm,
            chosen,
            robots,
            visits,
            seed,
            pose_law=pose_law.value,
            approach=approach.value,
            method=method.value,
            zone=zones,
            until=until,
            most_robots=most_robots,
            threads=threads,
            device=device.value,
            progress=bar,
        )
    if stopped:
        raise typer.Exit(STOPPED)
    for pose in at_poses:
        answer = answer.blaming(pose=pose)
    _finish(answer, folder, force=force, quiet=quiet)


def _finish(answer: Study | AnalyticStudy | Undescribed, folder: Path, *, force: bool, quiet: bool) -> None:
    """Write the report and print the figures."""
    written = answer.report(folder, force=force)  # before anything is printed: a closed pipe must not cost the results
    if not quiet:
        answer.summary()
    say(f"\nReport: {written / 'report.html'}")
