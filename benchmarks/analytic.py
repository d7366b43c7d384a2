"""How long does a study without sampling take, and how far is it from Monte Carlo? Terms -> covariance -> figures at every pose.

    python benchmarks/analytic.py [--poses 10000] [--threads 2]

Best of five, warm (Numba's cache filled). Parts of the whole are timed apart on one thread.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from against_numpy import ur5e

import lostmotion
from lostmotion.laws.normal_length import normal_length
from lostmotion.studies.analytic import BLOCK, LEVELS, analytic, of_screws, pooled
from lostmotion.studies.montecarlo import run
from lostmotion.studies.poses import Poses

EXAMPLES = Path(__file__).parent.parent / "examples"


def best(what, repeats=5) -> float:
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        what()
        times.append(time.perf_counter() - begin)
    return 1e3 * min(times)


def measure(name, arm, count, threads) -> None:
    chosen = lostmotion.sample_poses(arm, count)
    poses = Poses(chosen.q[:count], "given")
    found = analytic(arm, poses, threads=threads)
    print(f"{name}: {count} poses, {len(lostmotion.screws(arm, poses.q[:1]).infos)} terms")
    print(f"  whole, {threads} threads          {best(lambda: analytic(arm, poses, threads=threads)):8.1f} ms")
    print(f"  whole, 1 thread           {best(lambda: analytic(arm, poses)):8.1f} ms")
    blocks = [lostmotion.screws(arm, poses.q[first : first + BLOCK]) for first in range(0, count, BLOCK)]
    print(f"  screws alone              {best(lambda: [lostmotion.screws(arm, poses.q[k : k + BLOCK]) for k in range(0, count, BLOCK)]):8.1f} ms")
    print(f"  sums over terms, figures  {best(lambda: [of_screws(block) for block in blocks]):8.1f} ms")
    print(f"  figures, normal vectors   {best(lambda: normal_length(found.bias, found.covariance, LEVELS)):8.1f} ms")
    print(f"  figures, fourth cumulants {best(lambda: normal_length(found.bias, found.covariance, LEVELS, found.fourth)):8.1f} ms")
    print(f"  figures over all poses    {best(lambda: pooled(found, 1, threads), 1):8.1f} ms")
    begin = time.perf_counter()
    run(arm, poses, 100, 10, 1, threads=threads)
    print(f"  Monte Carlo, 100 robots x 10 visits {1e3 * (time.perf_counter() - begin):8.1f} ms")
    told = np.isfinite(np.column_stack([found.mean, found.quantiles])).mean(axis=0)
    print("  told of the poses: mean, " + ", ".join(f"{100 * level:.4g} %" for level in LEVELS) + ": " + ", ".join(f"{100 * x:.1f} %" for x in told))


def main() -> None:
    asked = argparse.ArgumentParser()
    asked.add_argument("--poses", type=int, default=10_000)
    asked.add_argument("--threads", type=int, default=2)
    options = asked.parse_args()
    measure("UR5e, lumped joint errors", ur5e(), options.poses, options.threads)
    measure("UR5e, every part", lostmotion.read(EXAMPLES / "ur5e.urdf"), options.poses, options.threads)


if __name__ == "__main__":
    main()
