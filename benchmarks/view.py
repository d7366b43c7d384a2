"""How long does the live view compute for one pose, for the first pose after a change, and for the
workspace?

python benchmarks/view.py [ARM ...]
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import lostmotion
from lostmotion.live_view.choices import Choices, changed
from lostmotion.live_view.session import LiveArm

EXAMPLES = Path(__file__).parents[1] / "examples"
FILES = (
    "z-arm.toml",
    "z-arm-drawn.toml",
    "ur5e.urdf",
    "arm-from-drawings.toml",
    "arm-in-the-sun.toml",
)
POSES = 200


def measure(path: Path) -> str:
    arm = lostmotion.read(path)
    poses = lostmotion.sample_poses(arm, 2048)
    live = LiveArm(arm, poses)
    # compiles, and draws the points for poses where the error is not nearly normal
    for q in poses.q[:100]:
        live.figures(q)
    each = []
    for q in poses.q[100 : 100 + POSES]:
        begun = time.perf_counter()
        live.figures(q)
        each.append(time.perf_counter() - begun)
    begun = time.perf_counter()
    other = LiveArm(changed(arm, Choices(arm.payload.mass + 1.0)), poses)
    other.figures(poses.q[0])
    first = time.perf_counter() - begun
    for _ in other.workspace():
        pass
    workspace = time.perf_counter() - begun - first
    median, most = 1e3 * np.median(each), 1e3 * np.quantile(each, 0.95)
    return f"{path.name:24} {median:6.1f} {most:6.1f} {1e3 * first:8.0f} {workspace:8.2f}"


def main() -> None:
    print(
        "milliseconds a pose: median, 95th percentile; first pose after a change; workspace "
        "of 2048 poses (seconds)"
    )
    for path in [Path(name) for name in sys.argv[1:]] or [EXAMPLES / name for name in FILES]:
        print(measure(path))


if __name__ == "__main__":
    main()
