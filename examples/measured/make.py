"""Write z-arm.csv and z-arm-loads.csv: what a laser tracker would have read of one robot of
examples/z-arm.toml, simulated by lostmotion itself.

    python examples/measured/make.py visits > examples/measured/z-arm.csv
    python examples/measured/make.py loads > examples/measured/z-arm-loads.csv

One robot, built with another seed than a study's, in a cube of 500 mm, with the standard's order of
poses. The first file: P1 to P5, 30 cycles, and P1, P2, P4 from three sides, at the full payload.
The second: at 100 % and at 10 % of it P1 to P5, 30 cycles, and the line from P2 to P4, 10 cycles,
read about every 36 mm. Every reading is off by 5 µm (standard deviation, each coordinate), and base
and tool frame are known only to
about 0.1 mm.
"""

import sys
from pathlib import Path

import numpy as np

import lostmotion
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.exact import draws_of
from lostmotion.propagation.iso9283.cube import NAMES, Cube, cube_from_arguments
from lostmotion.propagation.iso9283.joint_motion import (
    cycle_approach,
    path_approach,
    path_poses,
    side_approach,
)
from lostmotion.propagation.iso9283.robots import DISTANCE, FROM_THREE_SIDES, with_payload_share
from lostmotion.spatial import pose_of

SEED, ROBOT, VISITS, CYCLES, READING = 2026, 4, 30, 10, 5e-6
ORDER = (4, 3, 2, 1, 0)
FRAME = pose_of((1e-4, -8e-5, 5e-5), (1e-4, -5e-5, 1e-4))
# Places along the path at which the robot has its own error, linear between them; each cycle is
# read there, within a share of their distance.
PLACES, BESIDE = 20, 0.03


def visited(
    arm: lostmotion.Arm, q: np.ndarray, approach: np.ndarray, first: int, visits: int = VISITS
) -> np.ndarray:
    """Return the errors (pose, visit, 3) of the one robot, m."""
    matrix = screws(state_of(arm, q), approach=approach)
    numbers = np.arange(visits)
    return np.stack(
        [
            (
                matrix.tool[k, 3:]
                @ draws_of(matrix, k, SEED, first + k, np.full(visits, ROBOT), numbers)
            ).T
            for k in range(len(q))
        ]
    )


def read(at: np.ndarray, readings: np.random.Generator) -> str:
    """Return what the tracker reads of a point (3,), m."""
    attained = FRAME[:3, :3] @ at + FRAME[:3, 3] + readings.normal(0, READING, 3)
    return ",".join(f"{1e3 * value:.4f}" for value in attained)


def stated(command: np.ndarray) -> str:
    """Return a commanded point (3,), m, as the file has it."""
    return ",".join(f"{1e3 * value:.4f}" for value in command)


def of_visits(arm: lostmotion.Arm, cube: Cube) -> None:
    """Print z-arm.csv."""
    command, readings = cube.poses[:, :3, 3], np.random.default_rng(SEED)
    arrives, _ = cycle_approach(cube.q)
    errors = visited(arm, cube.q, arrives, 0)
    rows = [
        (NAMES[k], cycle + 1, "", k, errors[k, cycle]) for cycle in range(VISITS) for k in ORDER
    ]
    for k in FROM_THREE_SIDES:
        errors = visited(
            arm, np.tile(cube.q[k], (3, 1)), side_approach(arm, cube, k, arrives[k]), 100 + 3 * k
        )
        rows += [
            (NAMES[k], visit + 1, "xyz"[side], k, errors[side, visit])
            for side in range(3)
            for visit in range(VISITS)
        ]
    print("pose,cycle,side,x [mm],y [mm],z [mm],xc [mm],yc [mm],zc [mm]")
    for name, cycle, side, k, error in rows:
        print(f"{name},{cycle},{side},{read(command[k] + error, readings)},{stated(command[k])}")


def of_loads(arm: lostmotion.Arm, cube: Cube) -> None:
    """Print z-arm-loads.csv."""
    command, readings = cube.poses[:, :3, 3], np.random.default_rng(SEED + 1)
    arrives, _ = cycle_approach(cube.q)
    q = path_poses(arm, cube, DISTANCE, PLACES)
    line = command[list(DISTANCE)]
    print("pose,path,cycle,load [%],x [mm],y [mm],z [mm],xc [mm],yc [mm],zc [mm]")
    for number, load in enumerate((1.0, 0.1)):
        loaded = with_payload_share(arm, load)
        errors = visited(loaded, cube.q, arrives, 200 + 100 * number)
        for cycle in range(VISITS):
            for k in ORDER:
                print(
                    f"{NAMES[k]},,{cycle + 1},{100 * load:g},{read(command[k] + errors[k, cycle], readings)},{stated(command[k])}"  # noqa: E501
                )
        errors = visited(
            loaded, q, path_approach(q, arrives[DISTANCE[0]]), 400 + 100 * number, CYCLES
        )
        places = np.linspace(0, 1, PLACES)
        for cycle in range(CYCLES):
            for way in places + readings.uniform(-BESIDE, BESIDE, PLACES) / (PLACES - 1):
                error = [np.interp(way, places, errors[:, cycle, axis]) for axis in range(3)]
                print(
                    f",P2-P4,{cycle + 1},{100 * load:g},{read(line[0] + way * (line[1] - line[0]) + error, readings)},,,"  # noqa: E501
                )


def main() -> None:
    """Print the file asked for."""
    arm = lostmotion.read(Path(__file__).parents[1] / "z-arm.toml")
    print(
        "# Simulated, not measured: one robot of examples/z-arm.toml, written by "
        "examples/measured/make.py with lostmotion itself."
    )
    print(
        "# Readings off by 5 µm (standard deviation of each coordinate); base frame off by "
        "about 0.1 mm."
    )
    {"visits": of_visits, "loads": of_loads}[sys.argv[1]](
        arm, cube_from_arguments(arm, np.array([0.52, 0.0, 1.05]), 0.5)
    )


if __name__ == "__main__":
    main()
