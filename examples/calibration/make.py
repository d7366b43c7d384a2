"""Write printed-dial.csv and printed-tag.csv: what a dial gauge, and a webcam with a tag on the
gripper, would have read of one robot of examples/printed-hobby-arm.toml, simulated by lostmotion
itself.

    python examples/calibration/make.py dial > examples/calibration/printed-dial.csv
    python examples/calibration/make.py tag > examples/calibration/printed-tag.csv

Every joint arrives from the same side. The gauge reads 60 poses along one axis of the base each,
off by 10 µm (standard deviation), with a zero of its own for each axis. The camera sees the tag at
some of 240 poses, and each pixel is off by 0.2.
"""

import sys
from pathlib import Path

import numpy as np

import lostmotion
from lostmotion.calibration.tags import CORNERS
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.exact import compose, draws_of
from lostmotion.spatial import inverse, pose_of

SEED, ROBOT, READING, PIXEL = 2026, 4, 10e-6, 0.2
POSES = {"dial": 60, "tag": 240}
ZEROS = {"x": 1.2e-3, "y": -0.8e-3, "z": 0.5e-3}
# Share of its range that each joint keeps off its limits.
BESIDE = 0.1
FOCAL, CENTRE, SIZE = 800.0, np.array([640.0, 360.0]), 0.04
# Camera in the base, looking back at it, and tag on the gripper, facing away from the arm.
CAMERA = pose_of((0.75, 0.05, 0.25), (-np.pi / 2, 0.0, np.pi / 2))
TAG = pose_of((0.005, 0.002, -0.003), (np.pi / 2, 0.0, np.pi / 2))
# Cosine between the tag's normal and the line of sight from which the tag is seen.
SEEN = 0.4


def dial(q: np.ndarray, nominal: np.ndarray, tool: np.ndarray, chance: np.random.Generator) -> None:
    """Print the readings of the gauge."""
    moved = (tool - nominal)[:, :3, 3]
    for k, (pose, axis) in enumerate(zip(q, "xyz" * (len(q) // 3), strict=True)):
        reading = moved[k, "xyz".index(axis)] + ZEROS[axis] + chance.normal(0, READING)
        print(f"{row(pose)},{1e3 * reading:.2f},{axis}")


def tag(q: np.ndarray, _: np.ndarray, tool: np.ndarray, chance: np.random.Generator) -> None:
    """Print the pixels of the corners."""
    for pose, at in zip(q, inverse(CAMERA) @ tool @ TAG, strict=True):
        facing = -at[:3, 2] @ at[:3, 3] / np.linalg.norm(at[:3, 3])
        places = (SIZE * CORNERS) @ at[:3, :3].T + at[:3, 3]
        pixels = FOCAL * places[:, :2] / places[:, 2:] + CENTRE
        if facing < SEEN or not ((pixels > 0) & (pixels < 2 * CENTRE)).all():
            continue
        for number, (u, v) in enumerate(pixels + chance.normal(0, PIXEL, pixels.shape)):
            print(f"{row(pose)},{u:.2f},{v:.2f},{number},gripper")


def row(pose: np.ndarray) -> str:
    """Return the first cells of a row."""
    return ",".join([*(f"{np.degrees(each):.0f}" for each in pose), *("1" for _ in pose)])


def main() -> None:
    """Print the file."""
    arm = lostmotion.read(Path(__file__).parents[1] / "printed-hobby-arm.toml")
    kind, count = sys.argv[1], POSES[sys.argv[1]]
    chance = np.random.default_rng(SEED)
    low, high = arm.limits.T
    share = BESIDE + (1 - 2 * BESIDE) * chance.random((count, len(low)))
    q = np.radians(np.round(np.degrees(low + share * (high - low))))
    matrix, rows = screws(state_of(arm, q), approach=1.0), np.arange(count)
    draws = draws_of(matrix, rows, SEED, rows, np.full(count, ROBOT), rows)
    tool = compose(matrix, rows, draws.T[:, :, None])[:, 0]
    names = [joint.name for joint in arm.driven]
    print("# Simulated, not measured: one robot of ../printed-hobby-arm.toml, written by make.py.")
    heading = ",".join([*(f"{n} [deg]" for n in names), *(f"{n} approach" for n in names)])
    if kind == "dial":
        print(f"# instrument: dial\n{heading},dial [mm],along")
        dial(q, matrix.state.frames[-1], tool, chance)
    else:
        print(f"# camera: fx {FOCAL:g}, fy {FOCAL:g}, cx {CENTRE[0]:g}, cy {CENTRE[1]:g}")
        print(f"# tag size: {1e3 * SIZE:g} mm\n{heading},u,v,corner,tag")
        tag(q, matrix.state.frames[-1], tool, chance)


if __name__ == "__main__":
    main()
