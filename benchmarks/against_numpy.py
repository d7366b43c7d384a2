"""How fast is a study against a careful NumPy program of the same study, in the same run, on one
core?

The paper's Monte Carlo on a UR5e: every joint angle errs by a normal law of sigma 3.27'/3, every
joint's centre by +-30 um along three axes; 10 000 poses x 1 000 draws; asked for are mean, 50/95/99
% and largest at every pose, and the histogram over all. (Ours cuts the normal law at three sigma,
as a tolerance is: its mean is 1 % smaller.)

    python benchmarks/against_numpy.py [--poses 10000] [--draws 1000]

Contestants, each on one thread, alternating, best of three, by the processor's time, which other
work beside disturbs least:
    exact NumPy     what one writes without this package: perturbed angles and offsets through the
                    exact kinematics, vectorised over a pose's draws linear NumPy    what one writes
                    knowing the first-order trick: a matrix product per pose with fresh draws
    lostmotion      the whole of montecarlo.run: frames, wrenches, terms, screws, kernel, intervals,
                    bounds, budget, exact check
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from lostmotion import Arm, sample_poses
from lostmotion.propagation.montecarlo.montecarlo import run

SIGMA = 3.27 * math.pi / 10800 / 3
OFFSET = 30e-6
A = np.array([0, -0.425, -0.3922, 0, 0, 0])
D = np.array([0.1625, 0, 0, 0.1333, 0.0997, 0.0996])
ALPHA = np.array([90, 0, 0, 90, -90, 0]) * math.pi / 180
LEVELS = (0.5, 0.95, 0.99)
EDGES = np.linspace(0, 5e-3, 500)


def ur5e(varies: str = "visit") -> Arm:
    joints = []
    for k in range(6):
        tip = {"xyz": (A[k], 0.0, D[k]), "rpy": (ALPHA[k], 0.0, 0.0)}
        lumped = {"angle": 3 * SIGMA, "law": "normal", "offset": OFFSET, "varies": varies}
        joints.append(
            {
                "name": f"{k + 1}",
                "type": "revolute",
                "axis": "z",
                "limits": (-math.pi, math.pi),
                "link": {"tip": tip},
                "lumped": lumped,
            }
        )
    return Arm.model_validate({"name": "UR5e, lumped errors", "joints": joints})


def tool(angles: np.ndarray, shifts: np.ndarray) -> np.ndarray:
    """Exact tool point (3, draw) for angles (6, draw) and joint-frame shifts (6, 3, draw), carried
    inward from the tool; no 4 x 4 products.
    """
    x = y = z = np.zeros(angles.shape[1])
    for k in range(5, -1, -1):
        ca, sa = math.cos(ALPHA[k]), math.sin(ALPHA[k])
        x, y, z = x + A[k], ca * y - sa * z, sa * y + ca * z + D[k]
        x, y, z = x + shifts[k, 0], y + shifts[k, 1], z + shifts[k, 2]
        c, s = np.cos(angles[k]), np.sin(angles[k])
        x, y = c * x - s * y, s * x + c * y
    return np.stack([x, y, z])


def summed_up(errors: np.ndarray, out: list, histogram: np.ndarray) -> None:
    """Reduce one pose's errors (3, draw)."""
    size = np.sqrt(np.einsum("cd,cd->d", errors, errors))
    ranks = [min(int(level * len(size)), len(size) - 1) for level in LEVELS]
    out.append((size.mean(), size.max(), *np.partition(size, ranks)[ranks]))
    histogram += np.histogram(size, EDGES)[0]


def exact_numpy(q: np.ndarray, draws: int) -> list:
    rng = np.random.default_rng(1)
    out, histogram = [], np.zeros(len(EDGES) - 1, int)
    zero = np.zeros((6, 3, 1))
    for row in q:
        angles = row[:, None] + SIGMA * rng.standard_normal((6, draws))
        shifts = rng.uniform(-OFFSET, OFFSET, (6, 3, draws))
        summed_up(tool(angles, shifts) - tool(row[:, None], zero), out, histogram)
    return out


def linear_numpy(draws: int, matrices: np.ndarray) -> list:
    """Matrices (pose, 3, 24) are given: only draws, product and statistics are timed, in this
    program's favour.
    """
    rng = np.random.default_rng(1)
    out, histogram = [], np.zeros(len(EDGES) - 1, int)
    drawn = np.empty((24, draws))
    for matrix in matrices:
        rng.standard_normal(out=drawn[:6])
        rng.random(out=drawn[6:])
        drawn[6:] *= 2 * OFFSET
        drawn[6:] -= OFFSET
        summed_up(matrix @ drawn, out, histogram)
    return out


def lever(q: np.ndarray) -> np.ndarray:
    """Derivatives of the tool point by central differences, as a careful programmer checks by hand:
    (pose, 3, 24).
    """
    out = np.empty((len(q), 3, 24))
    step = 1e-6
    for k in range(6):
        d = np.zeros(6)
        d[k] = step
        out[:, :, k] = (
            (tool((q + d).T, np.zeros((6, 3, 1))) - tool((q - d).T, np.zeros((6, 3, 1)))).T
            / (2 * step)
            * SIGMA
        )
        for c in range(3):
            s = np.zeros((6, 3, 1))
            s[k, c] = 1
            out[:, :, 6 + 3 * k + c] = (tool(q.T, s) - tool(q.T, 0 * s)).T
    return out


MEASURED = """
import resource, sys
sys.path.insert(0, {folder!r})
import against_numpy as b
arm = b.ur5e()
b.run(arm, b.sample_poses(arm, {poses}, "uniform"), {draws}, 1, 1)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


def memory(poses: int, draws: int) -> float:
    """Peak memory of a fresh process that runs the study, MB."""
    code = MEASURED.format(folder=str(Path(__file__).resolve().parent), poses=poses, draws=draws)
    return float(
        subprocess.run(
            [sys.executable, "-c", code], check=True, capture_output=True, text=True
        ).stdout
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--poses", type=int, default=10_000)
    parser.add_argument("--draws", type=int, default=1_000)
    options = parser.parse_args()
    arm = ur5e()
    poses = sample_poses(arm, options.poses, "uniform")
    matrices = lever(poses.q)
    samples = len(poses) * options.draws
    run(arm, sample_poses(arm, 8), 64, 1, 1)  # compile
    contestants = {
        "exact NumPy": lambda: exact_numpy(poses.q, options.draws),
        "linear NumPy": lambda: linear_numpy(options.draws, matrices),
        "lostmotion": lambda: run(arm, poses, options.draws, 1, 1, threads=1),
    }
    best, results = dict.fromkeys(contestants, math.inf), {}
    for _ in range(3):
        for name, contestant in contestants.items():
            start = time.process_time()
            results[name] = contestant()
            best[name] = min(best[name], time.process_time() - start)
    ours = results["lostmotion"].per_pose
    print(f"{len(poses)} poses x {options.draws} draws, one thread, best of three, processor time")
    print(f"{'':14} {'ns/sample':>10} {'times ours':>11} {'mean error':>12} {'mean 95 %':>12}")
    for name, seconds in best.items():
        table = ours[:, [0, 3, 6, 9, 12]] if name == "lostmotion" else np.array(results[name])
        mean, q95 = table[:, [0, 3]].mean(axis=0) * 1e3
        print(
            f"{name:14} {seconds / samples * 1e9:10.1f} {seconds / best['lostmotion']:11.1f} "
            f"{mean:9.4f} mm {q95:9.4f} mm"
        )
    for draws in (options.draws, 10 * options.draws):
        print(
            f"peak memory of a fresh process, {len(poses)} poses x {draws} draws: "
            f"{memory(options.poses, draws):.0f} MB"
        )


if __name__ == "__main__":
    # read when NumPy is loaded, so begin again with it
    if os.environ.get("OPENBLAS_NUM_THREADS") != "1":
        os.execve(  # noqa: S606
            sys.executable,
            [sys.executable, *sys.argv],
            {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
    main()
