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

__version__ = "0.1.0"

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.arm import Arm, Payload, Tool, frames, joint_torques, worst_torques_over_tilts, wrenches
    from lostmotion.ask.gear import Gear, gear
    from lostmotion.ask.iso9283 import Iso9283, iso9283
    from lostmotion.ask.read import read
    from lostmotion.ask.runs import Sweep, replay, sweep
    from lostmotion.ask.size import Selection, Size, size
    from lostmotion.ask.study import Study, study
    from lostmotion.ask.targets import Target, production_yield, target
    from lostmotion.ask.zones import AccuracyMap, zones
    from lostmotion.errors import DidNotConvergeError, InputError, LostmotionError, OutputExistsError
    from lostmotion.studies.analytic.analytic import analytic
    from lostmotion.studies.budget import costs
    from lostmotion.studies.iso9283 import pose_accuracy, pose_repeatability
    from lostmotion.studies.iso9283.warm_up import WarmUp
    from lostmotion.studies.poses import Poses, sample_poses
    from lostmotion.studies.screws import root_sum_square, screws, worst_case
    from lostmotion.studies.statics.elastostatics import compliance, deflection, ellipsoid, stiffness
    from lostmotion.studies.workspace import workspace

# In reading order: from the file to the answer, then the pieces in between, then what can go wrong.
_HOME = {
    "read": "ask.read",
    "study": "ask.study",
    "Study": "ask.study",
    "gear": "ask.gear",
    "Gear": "ask.gear",
    "size": "ask.size",
    "Size": "ask.size",
    "Selection": "ask.size",
    "zones": "ask.zones",
    "AccuracyMap": "ask.zones",
    "target": "ask.targets",
    "Target": "ask.targets",
    "production_yield": "ask.targets",
    "sweep": "ask.runs",
    "Sweep": "ask.runs",
    "replay": "ask.runs",
    "iso9283": "ask.iso9283",
    "Iso9283": "ask.iso9283",
    "WarmUp": "studies.iso9283.warm_up",
    "Arm": "arm",
    "Tool": "arm",
    "Payload": "arm",
    "frames": "arm",
    "wrenches": "arm",
    "joint_torques": "arm",
    "worst_torques_over_tilts": "arm",
    "compliance": "studies.statics.elastostatics",
    "stiffness": "studies.statics.elastostatics",
    "deflection": "studies.statics.elastostatics",
    "ellipsoid": "studies.statics.elastostatics",
    "Poses": "studies.poses",
    "sample_poses": "studies.poses",
    "workspace": "studies.workspace",
    "analytic": "studies.analytic.analytic",
    "screws": "studies.screws",
    "worst_case": "studies.screws",
    "root_sum_square": "studies.screws",
    "costs": "studies.budget",
    "pose_accuracy": "studies.iso9283",
    "pose_repeatability": "studies.iso9283",
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
    kept = [here / room / "__pycache__" for room in ("laws", "studies", "studies/montecarlo")]
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
