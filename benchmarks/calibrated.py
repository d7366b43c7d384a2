"""Time of a run and a budget of an arm as stated, and of the same arm with every draw estimated.

python benchmarks/calibrated.py
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

import lostmotion
from lostmotion.error_model.budget import tally
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.calibration import Calibration, known_streams
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.montecarlo.montecarlo import run

EXAMPLE = Path(__file__).parents[1] / "examples" / "z-arm.toml"
TIMES = 9  # the joints of the example one after another, as often as this


def main() -> None:
    """Print the seconds of each step, as stated and calibrated."""
    example = lostmotion.read(EXAMPLE)
    joints = tuple(
        joint.model_copy(update={"name": f"{joint.name}{k}"})
        for k in range(TIMES)
        for joint in example.joints
    )
    # almost weightless: one of this length would fall
    arm = example.model_copy(update={"joints": joints, "gravity": 0.01})
    streams = known_streams(arm.terms)
    factor = np.random.default_rng(1).normal(size=(len(streams),) * 2) * 0.4 / len(streams) ** 0.5
    covariance = factor @ factor.T
    estimates = Calibration(streams, np.zeros(len(streams)), (covariance + covariance.T) / 2)
    poses = sample_poses(arm, 512)
    for name, each in (("stated", arm), ("calibrated", arm.calibrated(estimates))):
        print(f"{name}: {len(each.terms)} terms, {len(streams)} draws of a robot")
        for step, work in (
            ("run of 1 000 robots x 30 visits", lambda each=each: run(each, poses, 1000, 30, 1)),
            ("budget", lambda each=each: tally(each, poses.q)),
            ("without sampling", lambda each=each: analytic(each, poses)),
        ):
            work()
            before = time.process_time()
            work()
            print(f"  {step}: {time.process_time() - before:.2f} s")


if __name__ == "__main__":
    main()
