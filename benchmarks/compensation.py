"""How much of the expected error do one and two passes of compensation leave, and do they ever add
to it?

python benchmarks/compensation.py [--poses 100000]

The tables print what the page on controllers states: shares left at regular poses away from the
joint limits, and how many poses are made worse of which most are stretched, folded, with axes in
line or nearly so, or at a joint limit. The truth is the equilibrium of the arm
at the command, by its parts and not by the tables of the controller.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np

import lostmotion
from lostmotion.controller_model.compensation import REGULAR
from lostmotion.controller_model.remainder import reached, shares_left

EXAMPLES = Path(__file__).parents[1] / "examples"
REGULAR_ARMS = ("ur5e.urdf", "z-arm.toml", "z-arm-drawn.toml", "arm-from-drawings.toml")
OTHERS = (
    "scara",
    "printed-hobby-arm",
    "palletiser",
    "planar-2r",
    "six-axis",
    "arm-in-the-sun",
    "tracked-base",
    "gantry",
)
REACH = 2.8
# Distances from the limits at regular poses, and from a special joint value at special ones, rad or
# m.
INSIDE = 0.02
BESIDE = (0.0, 0.0, 1e-4, -1e-3, 1e-2, 3e-2, -1e-2)


def special_poses(model: Any, count: int) -> Any:
    """Return poses in which a third of the joints have values of a stretched or folded arm, of axes
    in line or limits, or nearly so.
    """
    rng = np.random.default_rng(5)
    low, high = np.clip(model.tables.limits, -REACH, REACH).T
    q = rng.uniform(low, high, size=(count, len(low)))
    for joint, (least, largest) in enumerate(zip(low, high, strict=True)):
        special = rng.choice(
            [0.0, math.pi / 2, -math.pi / 2, least, largest], size=count
        ) + rng.choice(BESIDE, size=count)
        q[:, joint] = np.where(
            rng.random(count) < 0.35, np.clip(special, least, largest), q[:, joint]
        )
    return q


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--poses", type=int, default=100_000)
    count = parser.parse_args().poses
    print("arm, passes: regular poses | share left: median, 95 %, worst | above 1 %")
    for name in REGULAR_ARMS:
        arm = lostmotion.read(EXAMPLES / name)
        model = lostmotion.controller(arm)
        low, high = np.clip(model.tables.limits, -REACH, REACH).T
        rng, size = np.random.default_rng(11), (count // 4, len(low))
        q = rng.uniform(low + INSIDE, high - INSIDE, size=size)
        for passes in (1, 2):
            share, singular = shares_left(model, arm, q, passes)
            share = share[(singular > REGULAR) & np.isfinite(share)]
            figures = ", ".join(
                f"{100 * each:.2g} %"
                for each in (np.median(share), np.quantile(share, 0.95), share.max())
            )
            print(
                f"{name}, {passes}: {len(share)} | {figures} | {100 * np.mean(share > 0.01):.2g} %"
            )
    print("\narm, passes: special poses | made worse | worst ratio")
    for name in (*REGULAR_ARMS, *(f"{each}.toml" for each in OTHERS)):
        arm = lostmotion.read(EXAMPLES / name)
        model = lostmotion.controller(arm)
        q = special_poses(model, count)
        for passes in (1, 2):
            found = model.compensate(q, passes=passes)
            before, after = (
                np.linalg.norm(reached(arm, each) - found.prediction.point, axis=1)
                for each in (q, found.command)
            )
            ratio = after / np.where(before > 1e-12, before, np.inf)
            stands = np.isfinite(ratio)
            print(
                f"{name}, {passes}: {np.count_nonzero(stands)} | "
                f"{np.count_nonzero(ratio > 1 + 1e-6)} | {ratio[stands].max():.6f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
