"""Show an arm in the browser."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

from lostmotion.analyses.arguments import (
    DEFAULT_POSES,
    ArmArgument,
    CalibrationArgument,
    SeedArgument,
    SidecarArgument,
    pose_of,
)
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import LostmotionError

if TYPE_CHECKING:
    from lostmotion.analyses.arguments import At


# Endings of the files that state meshes in the way of URDF.
_WITH_MESHES: Final = (".urdf", ".xacro")


@question(folder=None)
def view(
    arm: ArmArgument,
    *,
    at: Annotated[
        "At | None",
        Argument(
            "Pose at the beginning, every joint: 'A=30deg B=-10deg'.", pose_of, metavar="POSE"
        ),
    ] = None,
    port: Annotated[
        int,
        Argument(
            "Port on this computer; the next free one where it is in use.", least=1024, most=65_000
        ),
    ] = 8080,
    open_browser: Annotated[
        bool, Argument("Open the browser as well.", aliases=("--open",))
    ] = False,
    seed: SeedArgument = 1,
    sidecar: SidecarArgument = None,
    calibration: CalibrationArgument = None,
) -> dict[str, Any]:
    """Show an arm in the browser: drag its joints and see its error, the parts that cause it, and
    the error over its workspace.

    The page is served on this computer alone (127.0.0.1), under an address with a token, until
    ctrl-C. Payload, gearboxes and link sections can be changed there; the file is not changed. The
    figures are those of `study` without sampling. Needs pip install 'lostmotion[view]'. Returns the
    last pose and the changes.

    Raises
    ------
    InputError
        With every mistake in the arguments and the file.
    LostmotionError
        Where viser is not installed.

    """
    asked = read_arguments(view, locals())
    if importlib.util.find_spec("viser") is None:
        raise LostmotionError(
            "the live view needs viser, which is not installed: pip install 'lostmotion[view]'"
        )
    import webbrowser

    import numpy as np

    from lostmotion.error_model.poses import sample_poses
    from lostmotion.error_model.provenance import refuse_undescribed
    from lostmotion.errors import legible
    from lostmotion.live_view.panel import pose_option
    from lostmotion.live_view.picture import first_pose
    from lostmotion.live_view.session import Session
    from lostmotion.live_view.window import Window

    def say(text: str) -> None:
        sys.stdout.write(f"{legible(text)}\n")
        sys.stdout.flush()

    refuse_undescribed(asked.arm)
    poses = sample_poses(asked.arm, DEFAULT_POSES, seed=asked.seed)
    q = (
        first_pose(asked.arm, poses)
        if asked.at is None
        else poses.q[asked.at]
        if isinstance(asked.at, int)
        else np.asarray(asked.at, dtype=float)
    )
    session = Session(asked.arm, poses, q)
    drawn = (
        (Path(arm), asked.sidecar)
        if isinstance(arm, str | Path) and Path(arm).suffix.lower() in _WITH_MESHES
        else None
    )
    window = Window(session, poses, asked.port, drawn, say)
    say(f"{asked.arm.name}: {window.url}   stop with ctrl-C")
    if asked.open_browser:
        webbrowser.open(window.url)
    window.wait()
    chosen = session.choices
    return {
        "at": pose_option(asked.arm, session.q),
        "payload": chosen.payload,
        "gearboxes": dict(chosen.gearboxes),
        "sections": dict(chosen.sections),
    }
