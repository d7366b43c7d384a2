"""Write z-arm.csv: what a laser tracker would have read of one robot of examples/z-arm.toml, simulated by lostmotion itself.

    python examples/measured/make.py > examples/measured/z-arm.csv

One robot, built with another seed than a study's, visits P1 to P5 of a cube of 500 mm in the standard's order, 30 cycles, and P1, P2, P4 from three
sides; every reading is off by 5 µm (standard deviation, each coordinate), and base and tool frame are known only to about 0.1 mm.
"""

from pathlib import Path

import numpy as np

import lostmotion
from lostmotion.spatial import pose_of
from lostmotion.studies.iso9283.cube import NAMES, given_cube
from lostmotion.studies.iso9283.predicted import FROM_THREE_SIDES, cycle_approach, side_approach
from lostmotion.studies.montecarlo.exact import draws_of
from lostmotion.studies.screws import screws

SEED, ROBOT, VISITS, READING = 2026, 4, 30, 5e-6
ORDER = (4, 3, 2, 1, 0)


def visited(arm: lostmotion.Arm, q: np.ndarray, approach: np.ndarray, first: int) -> np.ndarray:
    """Give the errors (pose, visit, 3) of the one robot, m."""
    matrix = screws(arm, q, approach=approach)
    visits = np.arange(VISITS)
    return np.stack([(matrix.tool[k, 3:] @ draws_of(matrix, SEED, first + k, np.full(VISITS, ROBOT), visits)).T for k in range(len(q))])


def main() -> None:
    """Print the file."""
    arm = lostmotion.read(Path(__file__).parents[1] / "z-arm.toml")
    cube = given_cube(arm, np.array([0.52, 0.0, 1.05]), 0.5)
    command, readings = cube.poses[:, :3, 3], np.random.default_rng(SEED)
    frame = pose_of((1e-4, -8e-5, 5e-5), (1e-4, -5e-5, 1e-4))
    arrives, _ = cycle_approach(cube.q)
    rows = []
    errors = visited(arm, cube.q, arrives, 0)
    rows += [(NAMES[k], cycle + 1, "", k, errors[k, cycle]) for cycle in range(VISITS) for k in ORDER]
    for k in FROM_THREE_SIDES:
        errors = visited(arm, np.tile(cube.q[k], (3, 1)), side_approach(arm, cube, k, arrives[k]), 100 + 3 * k)
        rows += [(NAMES[k], visit + 1, "xyz"[side], k, errors[side, visit]) for side in range(3) for visit in range(VISITS)]
    print("# Simulated, not measured: one robot of examples/z-arm.toml, written by examples/measured/make.py with lostmotion itself.")
    print("# Readings off by 5 µm (standard deviation of each coordinate); base frame off by about 0.1 mm.")
    print("pose,cycle,side,x [mm],y [mm],z [mm],xc [mm],yc [mm],zc [mm]")
    for name, cycle, side, k, error in rows:
        attained = frame[:3, :3] @ (command[k] + error) + frame[:3, 3] + readings.normal(0, READING, 3)
        numbers = ",".join(f"{1e3 * value:.4f}" for value in (*attained, *command[k]))
        print(f"{name},{cycle},{side},{numbers}")


if __name__ == "__main__":
    main()
