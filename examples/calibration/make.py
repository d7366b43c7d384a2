"""Write printed-dial.csv: what a dial gauge would have read of one robot of
examples/printed-hobby-arm.toml, simulated by lostmotion itself.

    python examples/calibration/make.py > examples/calibration/printed-dial.csv

60 poses, each read along one axis of the base, where every joint arrives from the same side. Each
reading is off by 10 µm (standard deviation), and each gauge has a zero of its own.
"""

from pathlib import Path

import numpy as np

import lostmotion
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.exact import compose, draws_of

SEED, ROBOT, POSES, READING = 2026, 4, 60, 10e-6
ZEROS = {"x": 1.2e-3, "y": -0.8e-3, "z": 0.5e-3}
# Share of its range that each joint keeps off its limits.
BESIDE = 0.1


def main() -> None:
    """Print the file."""
    arm = lostmotion.read(Path(__file__).parents[1] / "printed-hobby-arm.toml")
    chance = np.random.default_rng(SEED)
    low, high = arm.limits.T
    share = BESIDE + (1 - 2 * BESIDE) * chance.random((POSES, len(low)))
    q = np.radians(np.round(np.degrees(low + share * (high - low))))
    matrix, rows = screws(state_of(arm, q), approach=1.0), np.arange(POSES)
    draws = draws_of(matrix, rows, SEED, rows, np.full(POSES, ROBOT), rows)
    tool = compose(matrix, rows, draws.T[:, :, None])[:, 0]
    moved = (tool - matrix.state.frames[-1])[:, :3, 3]
    names = [joint.name for joint in arm.driven]
    print("# Simulated, not measured: one robot of ../printed-hobby-arm.toml, written by make.py.")
    print("# instrument: dial")
    print(",".join([*(f"{n} [deg]" for n in names), *(f"{n} approach" for n in names)]), end="")
    print(",dial [mm],along")
    for k, (pose, axis) in enumerate(zip(q, "xyz" * (POSES // 3), strict=True)):
        reading = moved[k, "xyz".index(axis)] + ZEROS[axis] + chance.normal(0, READING)
        cells = [*(f"{np.degrees(each):.0f}" for each in pose), *("1" for _ in names)]
        print(",".join([*cells, f"{1e3 * reading:.2f}", axis]))


if __name__ == "__main__":
    main()
