"""How long does a study without sampling take? Arm -> terms -> covariance -> figures at every pose, and over all of them.

    python benchmarks/analytic.py [--poses 10000]

Best of some, warm (Numba's cache filled), by the clock and by the processor. The alternative takes the same mean vectors and covariances: NumPy turns
them to their axes, SciPy's noncentral chi-square with the same three cumulants (Liu, Tang and Zhang 2009 with a shift) gives the quantiles, and
Gauss and Hermite's rule on three axes the mean: careful, vectorised, and good to some 1e-3 of the length.
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
from lostmotion.laws.normal_length import normal_length
from lostmotion.propagation.analytic.analytic import LEVELS, analytic
from lostmotion.propagation.analytic.pooled import pooled

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
    quantiles = [np.sqrt(np.maximum(one + np.sqrt(two / (2 * freedom)) * (law.ppf(level) - freedom), 0)) for level in LEVELS]
    nodes, weights = np.polynomial.hermite_e.hermegauss(12)
    weights = weights / weights.sum()
    axes = [(mean[:, k, None] + np.sqrt(spread[:, k, None]) * nodes) ** 2 for k in range(3)]
    whole = np.sqrt(axes[0][:, :, None, None] + axes[1][:, None, :, None] + axes[2][:, None, None, :])
    return np.einsum("nijk,i,j,k->n", whole, weights, weights, weights), np.column_stack(quantiles)


def shares(parts) -> str:
    return ", ".join(f"{100 * np.nanmedian(one):.2g}/{100 * np.nanmax(one):.2g}" for one in parts.T)


def measure(name, arm, count) -> None:
    chosen = lostmotion.sample_poses(arm, count)
    poses = Poses(chosen.q[:count], "given")
    found = analytic(arm, poses, threads=2)
    bias, covariance, fourth, third = found.bias, found.covariance, found.fourth, found.third
    terms = len(lostmotion.screws(arm, poses.q[:1]).infos)
    print(f"{name}: {count} poses, {terms} terms; ms by the clock, by the processor")

    def show(label, what, repeats=5):
        wall, own = best(what, repeats)
        print(f"  {label:58s}{wall:9.1f}{own:9.1f}")
        return own

    own = show("mean and covariance -> mean, four quantiles, 1 thread", lambda: normal_length(bias, covariance, LEVELS))
    show("the same, 2 threads", lambda: normal_length(bias, covariance, LEVELS, threads=2))
    show("third and fourth cumulants as well, 1 thread", lambda: normal_length(bias, covariance, LEVELS, fourth, third=third))
    other = show("NumPy and SciPy, mean and covariance", lambda: by_scipy(bias, covariance), 2)
    mean, quantiles = by_scipy(bias, covariance)
    own_figures = normal_length(bias, covariance, LEVELS)
    apart = np.max(np.abs(np.column_stack([mean, quantiles]) / np.column_stack([own_figures.mean, own_figures.quantiles]) - 1), axis=0)
    print(f"  times lostmotion, by the processor: {other / own:.0f}; its largest errors: " + ", ".join(f"{x:.1e}" for x in apart))
    show("arm -> quick figures and bounds at every pose, 1 thread", lambda: analytic(arm, poses, quick=True), 10)
    show("the same, 2 threads", lambda: analytic(arm, poses, quick=True, threads=2), 10)
    quick = analytic(arm, poses, quick=True)
    figures, bounds = np.column_stack([quick.mean, quick.quantiles]), np.column_stack([quick.mean_bound, quick.quantiles_bound])
    wrong = np.abs(figures / np.column_stack([found.mean, found.quantiles]) - 1)
    told_in = f"told at {100 * quick.normal.mean():.1f} % of the poses; there, mean and the levels, in %"
    print(f"  {told_in}: their bounds {shares(bounds / figures)}, from the sure figures {shares(wrong)} (median/largest)")
    show("arm -> sure figures and bounds at every pose, 1 thread", lambda: analytic(arm, poses), 1)
    show("the same, 2 threads", lambda: analytic(arm, poses, threads=2), 1)
    show("over all poses: mean, four quantiles, 1 thread", lambda: pooled(found, 1), 2)
    show("the same, 2 threads", lambda: pooled(found, 1, 2), 2)
    told = np.isfinite(np.column_stack([found.mean, found.quantiles])).mean(axis=0)
    print("  told of the poses: mean, " + ", ".join(f"{100 * level:.4g} %" for level in LEVELS) + ": " + ", ".join(f"{100 * x:.1f} %" for x in told))


def main() -> None:
    asked = argparse.ArgumentParser()
    asked.add_argument("--poses", type=int, default=10_000)
    options = asked.parse_args()
    measure("UR5e, lumped joint errors", ur5e(), options.poses)
    measure("UR5e, every part", lostmotion.read(EXAMPLES / "ur5e.urdf"), options.poses)


if __name__ == "__main__":
    main()
