"""lostmotion: how accurate will this robot arm be before it is built, where in its workspace, and which part is to blame?

>>> import lostmotion
>>> arm = lostmotion.read("z-arm.toml")
>>> s = lostmotion.study(arm, robots=1000, visits=30, seed=1)
>>> s.summary()
>>> s.report("out/")

Names are loaded when first used, so that `import lostmotion` takes no time.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from lostmotion.version import __version__

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.accuracy.command import Study, study
    from lostmotion.analyses.accuracy.workspace import workspace
    from lostmotion.analyses.gearbox.command import Gear, gear
    from lostmotion.analyses.iso9283.characteristics import pose_accuracy, pose_repeatability
    from lostmotion.analyses.iso9283.command import Iso9283, iso9283
    from lostmotion.analyses.iso9283.warm_up import WarmUp
    from lostmotion.analyses.read import read
    from lostmotion.analyses.sizing.command import Selection, Size, size
    from lostmotion.analyses.sweep.command import Sweep, replay, sweep
    from lostmotion.analyses.targets.command import Target, production_yield, target
    from lostmotion.analyses.workspace_map.command import AccuracyMap, zones
    from lostmotion.error_model.budget import costs
    from lostmotion.error_model.pose_matrix import root_sum_square, screws, worst_case
    from lostmotion.error_model.poses import Poses, sample_poses
    from lostmotion.errors import DidNotConvergeError, InputError, LostmotionError, OutputExistsError
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.elastostatics import compliance, deflection, ellipsoid, stiffness
    from lostmotion.mechanism.serial import frames, joint_torques, worst_torques_over_tilts, wrenches
    from lostmotion.mechanism.tool import Payload, Tool
    from lostmotion.propagation.analytic import analytic

# In reading order: from the file to the answer, then the pieces in between, then what can go wrong.
_HOME = {
    "read": "analyses.read",
    "study": "analyses.accuracy.command",
    "Study": "analyses.accuracy.command",
    "gear": "analyses.gearbox.command",
    "Gear": "analyses.gearbox.command",
    "size": "analyses.sizing.command",
    "Size": "analyses.sizing.command",
    "Selection": "analyses.sizing.command",
    "zones": "analyses.workspace_map.command",
    "AccuracyMap": "analyses.workspace_map.command",
    "target": "analyses.targets.command",
    "Target": "analyses.targets.command",
    "production_yield": "analyses.targets.command",
    "sweep": "analyses.sweep.command",
    "Sweep": "analyses.sweep.command",
    "replay": "analyses.sweep.command",
    "iso9283": "analyses.iso9283.command",
    "Iso9283": "analyses.iso9283.command",
    "WarmUp": "analyses.iso9283.warm_up",
    "Arm": "mechanism.arm",
    "Tool": "mechanism.tool",
    "Payload": "mechanism.tool",
    "frames": "mechanism.serial",
    "wrenches": "mechanism.serial",
    "joint_torques": "mechanism.serial",
    "worst_torques_over_tilts": "mechanism.serial",
    "compliance": "mechanism.elastostatics",
    "stiffness": "mechanism.elastostatics",
    "deflection": "mechanism.elastostatics",
    "ellipsoid": "mechanism.elastostatics",
    "Poses": "error_model.poses",
    "sample_poses": "error_model.poses",
    "workspace": "analyses.accuracy.workspace",
    "analytic": "propagation.analytic",
    "screws": "error_model.pose_matrix",
    "worst_case": "error_model.pose_matrix",
    "root_sum_square": "error_model.pose_matrix",
    "costs": "error_model.budget",
    "pose_accuracy": "analyses.iso9283.characteristics",
    "pose_repeatability": "analyses.iso9283.characteristics",
    "LostmotionError": "errors",
    "InputError": "errors",
    "OutputExistsError": "errors",
    "DidNotConvergeError": "errors",
}

__all__ = [  # noqa: RUF022 - reading order
    "read",
    "study",
    "Study",
    "gear",
    "Gear",
    "size",
    "Size",
    "Selection",
    "zones",
    "AccuracyMap",
    "target",
    "Target",
    "production_yield",
    "sweep",
    "Sweep",
    "replay",
    "iso9283",
    "Iso9283",
    "WarmUp",
    "Arm",
    "Tool",
    "Payload",
    "frames",
    "wrenches",
    "joint_torques",
    "worst_torques_over_tilts",
    "compliance",
    "stiffness",
    "deflection",
    "ellipsoid",
    "Poses",
    "sample_poses",
    "workspace",
    "analytic",
    "screws",
    "worst_case",
    "root_sum_square",
    "costs",
    "pose_accuracy",
    "pose_repeatability",
    "LostmotionError",
    "InputError",
    "OutputExistsError",
    "DidNotConvergeError",
    "__version__",
]


def _let_numba_cache() -> None:
    """Give compiled code a folder of this process's own where it can be kept neither beside the package nor in the user's home.

    Numba refuses to compile at all without one. A folder that others could write to would let them run code here, so it is made anew and goes with
    the process, which then compiles each time.
    """
    import os
    from pathlib import Path

    if "NUMBA_CACHE_DIR" in os.environ:
        return
    here = Path(__file__).parent
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path(os.path.expanduser("~"), ".cache"))  # noqa: PTH111 - gives "~" back where there is no home
    kept = [
        here / room / "__pycache__" for room in ("error_model", "laws/cycloid", "laws/rolling", "mechanism", "propagation", "propagation/montecarlo")
    ]
    if all(map(_can_write, kept)) or (home.is_absolute() and _can_write(home / "numba")):
        return
    import atexit
    import contextlib
    import shutil
    import tempfile

    with contextlib.suppress(OSError):  # nowhere at all: Numba then says so
        folder = tempfile.mkdtemp(prefix="lostmotion-")
        os.environ["NUMBA_CACHE_DIR"] = folder
        atexit.register(shutil.rmtree, folder, ignore_errors=True)


def _can_write(folder: Path) -> bool:
    """May this folder, or the nearest one above it that is there, be written to?"""
    import os

    there = next((each for each in (folder, *folder.parents) if each.exists()), folder)
    return there.is_dir() and os.access(there, os.W_OK | os.X_OK)


_let_numba_cache()


def __getattr__(name: str) -> Any:  # noqa: ANN401 - whatever stands behind the name
    """Load a public name from its room when it is first asked for."""
    if name not in _HOME:
        raise AttributeError(f"module 'lostmotion' has no attribute '{name}'")
    value = getattr(importlib.import_module(f"lostmotion.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the front door's names."""
    return __all__
