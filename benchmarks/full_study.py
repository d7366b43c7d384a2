"""How fast is a whole study of a real arm against a careful NumPy program of the same study, in the
same run, on one core?

The UR5e of examples/ with every part that its sidecar describes (gearbox play and wind-up,
bearings, links, mounting, encoders), 10 000 poses x 1 000 draws (100 robots x 10 visits). All give,
at every pose, mean, 50/95/99 % and largest error, AP and RP of every robot, and the histogram over
all.

    python benchmarks/full_study.py [--poses 10000] [--robots 100] [--visits 10]

Contestants, each on one thread, alternating, best of two, by the processor's time, which other work
beside disturbs least:
    exact NumPy     robots drawn once, visits drawn for each; each place of the arm is turned and
                    shifted by the errors there, and the tool point carried through all of them to
                    second order (error 1e-9), vectorised over a pose's draws. The sizes of the
                    errors are given to it. linear NumPy    the same, knowing the first-order trick:
                    one matrix product per pose. The matrices are given to it.
    lostmotion      the whole of montecarlo.run: frames, loads, sizes of all errors, kernel,
                    intervals, bounds, budget, exact check
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from against_numpy import EDGES, summed_up

import lostmotion
from lostmotion.mechanism.frames import steps_between
from lostmotion.propagation.montecarlo.kernel import MEAN
from lostmotion.propagation.montecarlo.montecarlo import run

if TYPE_CHECKING:
    from lostmotion.error_model.pose_matrix import PoseMatrix

UR5E = Path(__file__).parent.parent / "examples" / "ur5e.urdf"


class NumPyStudy:
    """The careful program: what it may know beforehand is worked out here and not timed."""

    def __init__(self, matrix: PoseMatrix, robots: int, visits: int) -> None:
        self.matrix, self.robots, self.visits = matrix, robots, visits
        self.steps = steps_between(matrix.state.frames)
        self.places = np.unique(matrix.place)
        self.columns = {place: np.flatnonzero(matrix.place == place) for place in self.places}
        self.local = {
            place: np.ascontiguousarray(matrix.local[:, :, columns])
            for place, columns in self.columns.items()
        }
        self.shift = np.ascontiguousarray(matrix.tool[:, 3:])
        rng = np.random.default_rng(1)
        self.drawn = np.ones((len(matrix.infos), robots, visits))
        streams = {}
        for k, info in enumerate(matrix.infos):
            if info.robot:
                u = streams.setdefault(info.robot.name, rng.random(robots))
                self.drawn[k] *= info.robot.law.quantile(u)[:, None]
        self.fixed = self.drawn.copy()
        moving = matrix.columns("visit", "robot x visit")
        self.visiting = moving[np.any(matrix.tool[:, 3:, moving] != 0, axis=(0, 1))]

    def draw_visits(self, rng: np.random.Generator) -> np.ndarray:
        """Draw what changes from visit to visit; the two halves of a harmonic share their
        uniforms.
        """
        streams = {}
        for k in self.visiting:
            stream = self.matrix.infos[k].visit
            if stream.name not in streams:
                streams[stream.name] = rng.random((self.robots, self.visits))
            np.multiply(self.fixed[k], stream.law.quantile(streams[stream.name]), out=self.drawn[k])
        return self.drawn.reshape(len(self.drawn), -1)

    def exact(self) -> list:
        rng, out, histogram = np.random.default_rng(2), [], np.zeros(len(EDGES) - 1, int)
        for pose in range(len(self.shift)):
            draws = self.draw_visits(rng)
            point = np.zeros((3, draws.shape[1]))
            for place in range(len(self.steps) - 1, -1, -1):
                if place in self.columns:
                    twist = self.local[place][pose] @ draws[self.columns[place]]
                    point = (
                        second_order(twist[:3], point)
                        + twist[3:]
                        + 0.5 * cross(twist[:3], twist[3:])
                    )
                step = self.steps[place, pose]
                point = step[:3, :3] @ point + step[:3, 3:]
            self.reduce(point - self.matrix.state.frames[-1, pose, :3, 3:], out, histogram)
        return out

    def linear(self) -> list:
        rng, out, histogram = np.random.default_rng(2), [], np.zeros(len(EDGES) - 1, int)
        for pose in range(len(self.shift)):
            self.reduce(self.shift[pose] @ self.draw_visits(rng), out, histogram)
        return out

    def reduce(self, errors: np.ndarray, out: list, histogram: np.ndarray) -> None:
        summed_up(errors, out, histogram)
        by_robot = errors.reshape(3, self.robots, self.visits)
        centre = by_robot.mean(axis=2, keepdims=True)
        distance = np.sqrt(((by_robot - centre) ** 2).sum(axis=0))
        ap = np.sqrt((centre**2).sum(axis=0))
        rp = distance.mean(axis=1) + 3 * distance.std(axis=1, ddof=1)
        out[-1] = (*out[-1], ap.mean(), rp.mean())


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def second_order(omega: np.ndarray, point: np.ndarray) -> np.ndarray:
    turned = cross(omega, point)
    return point + turned + 0.5 * cross(omega, turned)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--poses", type=int, default=10_000)
    parser.add_argument("--robots", type=int, default=100)
    parser.add_argument("--visits", type=int, default=10)
    options = parser.parse_args()
    arm = lostmotion.read(UR5E)
    poses = lostmotion.sample_poses(arm, options.poses, "uniform")
    # The NumPy programs take every tenth pose: their time per sample does not depend on the number
    # of poses, and nobody need wait.
    some = poses.q[::10]
    numpy_study = NumPyStudy(
        lostmotion.screws(lostmotion.state_of(arm, some)), options.robots, options.visits
    )
    run(arm, lostmotion.sample_poses(arm, 8), 64, 2, 1)  # compile
    draws = options.robots * options.visits
    contestants = {
        "exact NumPy": (numpy_study.exact, len(some)),
        "linear NumPy": (numpy_study.linear, len(some)),
        "lostmotion": (
            lambda: run(arm, poses, options.robots, options.visits, 1, threads=1),
            len(poses),
        ),
    }
    best, results = dict.fromkeys(contestants, math.inf), {}
    for _ in range(2):
        for name, (contestant, count) in contestants.items():
            start = time.process_time()
            results[name] = contestant()
            best[name] = min(best[name], (time.process_time() - start) / (count * draws))
    ours = results["lostmotion"]
    rows = {
        name: np.array(results[name])[:, [0, 5, 6]].mean(axis=0)
        for name in ("exact NumPy", "linear NumPy")
    }
    rows["lostmotion"] = np.array(
        [ours.per_pose[:, MEAN].mean(), ours.accuracy[:, 0].mean(), ours.repeatability[:, 0].mean()]
    )
    print(f"{arm!r}, {len(numpy_study.matrix.infos)} error terms")
    print(
        f"{len(poses)} poses x {options.robots} robots x {options.visits} visits, one thread, "
        "best of two, processor time"
    )
    print(f"{'':14} {'ns/sample':>10} {'times ours':>11} {'mean error':>12} {'AP':>12} {'RP':>12}")
    for name, seconds in best.items():
        shown = " ".join(f"{value * 1e3:9.4f} mm" for value in rows[name])
        print(f"{name:14} {seconds * 1e9:10.1f} {seconds / best['lostmotion']:11.1f} {shown}")


if __name__ == "__main__":
    # read when NumPy is loaded, so begin again with it
    if os.environ.get("OPENBLAS_NUM_THREADS") != "1":
        os.execve(  # noqa: S606
            sys.executable,
            [sys.executable, *sys.argv],
            {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
    main()
