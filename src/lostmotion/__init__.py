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
