"""How long does a study without sampling take? Arm -> terms -> covariance -> figures at every pose,
and over all of them.

    python benchmarks/analytic.py [--poses 10000]

Best of some, warm (Numba's cache filled), by the clock and by the processor. The alternative takes
the same mean vectors and covariances: NumPy turns them to their axes, SciPy's noncentral chi-square
with the same three cumulants (Liu, Tang and Zhang 2009 with a shift) gives the quantiles, and Gauss
and Hermite's rule on three axes the mean: careful, vectorised, and good to some 1e-3 of the length.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from against_numpy import ur5e
from scipy import stats

import lostmotion
from lostmotion.error_model.poses import Poses
from lostmotion.propagation.analytic import DrawnColumns, analytic
from lostmotion.propagation.error_magnitude import LEVELS, POINTS, by_points, by_rays
from lostmotion.propagation.pooled import pooled

EXAMPLES = Path(__file__).parent.parent / "examples"


def best(what, repeats=5) -> tuple[float, float]:
    times = []
    for _ in range(repeats):
        wall, own = time.perf_counter(), time.process_time()
        what()
        times.append((1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - own)))
    return min(wall for wall, _ in times), min(own for _, own in times)


def by_scipy(bias, covariance):
    """Mean and quantiles of |bias + N(0, covariance)| with NumPy and SciPy alone."""
    spread, turn = np.linalg.eigh(covariance)
    spread = np.maximum(spread, 0)
    mean = np.einsum("nij,ni->nj", turn, bias)
    square = mean**2
    one, two = (spread + square).sum(axis=1), (2 * spread**2 + 4 * square * spread).sum(axis=1)
    three = (8 * spread**3 + 24 * square * spread**2).sum(axis=1)
    freedom = 8 * two**3 / three**2
    law = stats.chi2(freedom)
    quantiles = [
        np.sqrt(np.maximum(one + np.sqrt(two / (2 * freedom)) * (law.ppf(level) - freedom), 0))
        for level in LEVELS
    ]
    nodes, weights = np.polynomial.hermite_e.hermegauss(12)
    weights = weights / weights.sum()
    axes = [(mean[:, k, None] + np.sqrt(spread[:, k, None]) * nodes) ** 2 for k in range(3)]
    whole = np.sqrt(
        axes[0][:, :, None, None] + axes[1][:, None, :, None] + axes[2][:, None, None, :]
    )
    return np.einsum("nijk,i,j,k->n", whole, weights, weights, weights), np.column_stack(quantiles)


def measure(name, arm, count) -> None:
    q = lostmotion.sample_poses(arm, count).q[:count]
    # Rays and points are compared where all robots have the same plays closed, and so the same
    # draws.
    poses = Poses(
        q[~lostmotion.screws(lostmotion.state_of(arm, q)).closed_in_some.any(axis=0)], "given"
    )
    matrix, count = lostmotion.screws(lostmotion.state_of(arm, poses.q)), len(poses)
    drawn = DrawnColumns(matrix)
    shift, bias = drawn.shift(matrix), np.ascontiguousarray(matrix.bias[:, 3:])
    found, points = analytic(arm, poses, threads=2), drawn.draws(POINTS)
    print(
        f"{name}: {count} poses, {shift.shape[2]} drawn terms, nearly normal at "
        f"{100 * found.nearly_normal.mean():.0f} %"
    )
    print("  ms by the clock, by the processor")

    def show(label, what, repeats=5):
        wall, own = best(what, repeats)
        print(f"  {label:58s}{wall:9.1f}{own:9.1f}")
        return own

    covariance = np.ascontiguousarray(found.covariance)
    own = show("rays of the normal vector -> mean, four quantiles", lambda: by_rays(shift, bias))
    show("rays with third and fourth cumulants", lambda: by_rays(shift, bias, drawn.cumulants))
    other = show("NumPy and SciPy, mean and covariance", lambda: by_scipy(bias, covariance), 2)
    mean, quantiles = by_scipy(bias, covariance)
    normal = by_rays(shift, bias).values
    apart = np.max(
        np.abs(np.column_stack([mean, quantiles]) / normal[:, [0, 2, 3, 4, 5]] - 1), axis=0
    )
    print(
        f"  times lostmotion, by the processor: {other / own:.1f}; its largest errors: "
        + ", ".join(f"{x:.1e}" for x in apart)
    )
    tenth = slice(0, count // 10)
    show(
        f"{POINTS} Sobol points at a tenth of the poses",
        lambda: by_points(shift[tenth], bias[tenth], points),
        2,
    )
    show("arm -> figures at every pose, 1 thread", lambda: analytic(arm, poses), 2)
    show("the same, 2 threads", lambda: analytic(arm, poses, threads=2), 2)
    show(
        "over all poses: mean, deviation, four quantiles, 1 thread",
        lambda: pooled(arm, poses, found),
        2,
    )
    show("the same, 2 threads", lambda: pooled(arm, poses, found, threads=2), 2)


def main() -> None:
    asked = argparse.ArgumentParser()
    asked.add_argument("--poses", type=int, default=10_000)
    options = asked.parse_args()
    measure("UR5e, lumped joint errors", ur5e(), options.poses)
    measure("UR5e, every part", lostmotion.read(EXAMPLES / "ur5e.urdf"), options.poses)


if __name__ == "__main__":
    main()
