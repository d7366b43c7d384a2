"""Ask for the sections of an arm's links by limits, or for all its parts by a target on the
tool.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from lostmotion.analyses.arguments import (
    DEFAULT_POSES,
    DEFAULT_ROBOTS,
    DEFAULT_VISITS,
    ArmArgument,
    ProgressArgument,
    ReadyArgument,
    ReducersArgument,
    SeedArgument,
    SidecarArgument,
    ThreadsArgument,
    path_or_mapping,
    poses_of,
    reducers_beside,
)
from lostmotion.analyses.quantities import Amount
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.analyses.sizing.selection import Selection
    from lostmotion.analyses.sizing.sizing import Size
    from lostmotion.spatial import Floats

# Poses that limits are checked at; of a search for a target, which a full study follows.
_LIMIT_POSES = 1024
_SEARCH_POSES = 128


@question(folder="sized")
def size(
    arm: ArmArgument,
    by: Annotated[
        "str | Path | Mapping[str, Any] | None",
        Argument(
            (
                "TOML with [sizing]: limits, and what each link may be made of; in Python also "
                "the keys of that table. Default: sections like its own."
            ),
            path_or_mapping,
            metavar="SIZING",
        ),
    ] = None,
    *,
    target: Annotated[
        Amount | None,
        Argument(
            (
                "Largest 95 % error of the tool over the workspace, '0.5 mm', for which links, "
                "and what `by` offers, are chosen."
            ),
            metavar="LENGTH",
        ),
    ] = None,
    target_of: Annotated[
        Literal["error", "rp_iso", "rp_any"] | None,
        Argument(
            "What the target limits: the 95 % error; rp_iso, RP of 95 % of robots in the ISO "
            "cycle; rp_any, of any approach. Default: error."
        ),
    ] = None,
    minimise: Annotated[
        str | None,
        Argument(
            "What is minimised with a target: 'mass', 'price', 'price + 20 * mass'. Default: mass.",
            metavar="COST",
        ),
    ] = None,
    slope: Annotated[
        Amount | None,
        Argument(
            "Largest slope of a link's tip, '0.5 arcmin'. Default: that, as in the paper.",
            metavar="ANGLE",
        ),
    ] = None,
    deflection: Annotated[
        Amount | None,
        Argument(
            (
                "Largest deflection of a link's tip: its length over this, '2500'. Default: that, "
                "as in the paper."
            ),
            metavar="NUMBER",
        ),
    ] = None,
    family: Annotated[
        Literal["tube"] | None,
        Argument("Kind of section of every link, with `outer` and `wall`; other kinds in `by`."),
    ] = None,
    outer: Annotated[
        Amount | None,
        Argument("Outside diameter of the tubes, '30 mm .. 200 mm'.", metavar="RANGE"),
    ] = None,
    wall: Annotated[
        Amount | None,
        Argument(
            "Wall of the tubes, '3 mm', '2 mm .. 6 mm' or '5 %' of the outside diameter.",
            metavar="RANGE",
        ),
    ] = None,
    tilt: Annotated[
        Amount | None,
        Argument("Tilt of the base from level, towards any side, '10 deg'.", metavar="ANGLE"),
    ] = None,
    step: Annotated[
        Amount | None,
        Argument(
            (
                "Step of free sizes, '0.1 mm', or '0 mm' for exact ones. Default: usual sizes of "
                "tubes, bars and profiles."
            ),
            metavar="LENGTH",
        ),
    ] = None,
    poses: Annotated[
        int | None,
        Argument(
            (
                "How many poses to check, rounded up to 8 x a power of two. Default: 1024, or 128 "
                "in a search for a target."
            ),
            least=1,
        ),
    ] = None,
    also: Annotated[
        "str | Path | Floats | None",
        Argument(
            (
                "CSV file of poses to check as well: one column per joint, header like 'A [deg]'. "
                "In Python also joint values in rad and m."
            ),
            poses_of,
            metavar="CSV",
            aliases=("--poses-file",),
        ),
    ] = None,
    seed: SeedArgument = 1,
    reducers: ReducersArgument = (),
    sidecar: SidecarArgument = None,
    threads: ThreadsArgument = None,
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> Size | Selection:
    """Choose the lightest sections that keep an arm's links within slope and deflection, or the
    cheapest parts within a target on the tool.

    Corners of the joints' ranges are checked besides. The answer to a target is verified by a full
    study. An arm given by its path is written with the selected parts as sized.toml.

    Raises
    ------
    InputError
        With every mistake in the arguments and the files.

    """
    asked = read_arguments(size, locals())
    from lostmotion.error_model.poses import sample_poses
    from lostmotion.error_model.provenance import refuse_undescribed
    from lostmotion.error_model.trust import with_figures
    from lostmotion.io.sizing import read_request
    from lostmotion.propagation.first_order import refuse_large_errors

    keys = {
        "target": target,
        "target_of": target_of,
        "minimise": minimise,
        "slope": slope,
        "deflection": deflection,
        "tilt": tilt,
        "step": step,
    }
    tube = {"kind": family, "outer": outer, "wall": wall}
    stated = {key: value for key, value in keys.items() if value is not None}
    if any(value is not None for value in tube.values()):
        stated["family"] = {
            key: value for key, value in {**tube, "kind": "tube"}.items() if value is not None
        }  # type: ignore[assignment]
    if target is not None:
        # before what the links lack: without errors there is no target to meet
        refuse_undescribed(asked.arm)
        refuse_large_errors(asked.arm)
    request = read_request(asked.by, stated, asked.arm, reducers_beside(arm, asked.reducers))
    asked.ready()
    source = Path(arm) if isinstance(arm, str | os.PathLike) else None
    if request.plan.target is None:
        from lostmotion.analyses.sizing.sizing import size_links

        sampled = sample_poses(asked.arm, asked.poses or _LIMIT_POSES, seed=asked.seed)
        given = None if also is None else asked.also.q
        plan = request.plan
        sized = size_links(
            asked.arm,
            request.link_options,
            plan.limits,
            sampled,
            tilt=plan.tilt,
            step=plan.step,
            also=given,
            progress=progress,
        )
        return replace(sized, source=source, sidecar=asked.sidecar)
    if also is not None:
        raise refuse_argument(
            "also", "poses given", "no poses with a target, which is over the workspace"
        )
    from lostmotion.analyses.sizing.selection import StudySize, select_parts

    refuse_undescribed(asked.arm)
    refuse_large_errors(asked.arm)
    selection = select_parts(
        asked.arm,
        request.slots,
        request.objective,
        request.plan.target,
        with_figures(
            asked.arm, sample_poses(asked.arm, asked.poses or _SEARCH_POSES, seed=asked.seed)
        ),
        with_figures(asked.arm, sample_poses(asked.arm, DEFAULT_POSES, seed=asked.seed)),
        constraints=request.constraints,
        study_size=StudySize(
            DEFAULT_ROBOTS, DEFAULT_VISITS, asked.seed, asked.threads or os.cpu_count() or 1
        ),
        of=request.plan.target_of,
        progress=progress,
    )
    droops = (
        "the arm droops: the search takes errors and loads at the command, the full study has the "
        "errors where it stands"
    )
    notes = (*([droops] if selection.sized.soft_freedoms else []), *request.notes)
    return replace(selection, notes=notes, source=source, sidecar=asked.sidecar)
