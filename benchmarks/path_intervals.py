"""How often do the intervals of AT_p and RT_p of measured paths hold what many cycles would show?

Tests are made up: 20 planes of a path, 10 and 30 cycles, errors across the path normal. Planes err each for itself, like their neighbours, or all
together; as much everywhere, or up to 2.5 times as much in one place; the path's averages lie 1 to 3 off, rising along it, or 3 off everywhere. A
nominal 90 % is to hold 90 % of the tests, within sampling: with 1 000 of them two standard errors are 2 %. Errors of one part instead of two tell of
AT_a, b, c and RT_a, b, c.

    python benchmarks/path_intervals.py [--tests 1000] [--cycles 10 30] [--parts 2] [--workers 2]
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from itertools import product

import numpy as np
from rich.console import Console
from rich.table import Table

from lostmotion.studies.iso9283.worst_plane import largest_mean, largest_scatter

PLANES = np.linspace(0, 1, 20)
# What neighbours have in common, as a length along the path, and whether one place errs more.
SCATTERS = {
    "each for itself, alike": (0.0, False),
    "each for itself, more in one place": (0.0, True),
    "like their neighbours, alike": (0.15, False),
    "like their neighbours, more in one place": (0.15, True),
    "all together, alike": (3.0, False),
}
AVERAGES = {"1 to 3 along the path": 1 + 2 * PLANES, "3 everywhere": np.full(20, 3.0)}
LARGEST = 3.0
# Deviations that RT is of one part, and of a round normal scatter in a plane: mean + 3 s of the distances.
ROUND = {1: 3.0, 2: np.sqrt(np.pi / 2) + 3 * np.sqrt(2 - np.pi / 2)}


def held(scatter: str, averages: str, cycles: int, tests: int, parts: int) -> list[float]:
    """Count in percent how often the intervals of AT_p and RT_p lie above the truth, below it, or hold it."""
    common, uneven = SCATTERS[scatter]
    kernel = np.exp(-0.5 * ((PLANES[:, None] - PLANES) / common) ** 2) if common else np.eye(20)
    root = np.linalg.cholesky(kernel + 1e-9 * np.eye(20))
    size = 1 + 1.5 * np.exp(-(((PLANES - 0.3) / 0.2) ** 2)) if uneven else np.ones(20)
    rng = np.random.default_rng([list(SCATTERS).index(scatter), list(AVERAGES).index(averages), cycles])
    counts = np.zeros((2, 3))
    for _ in range(tests):
        errors = np.einsum("pq,qni->pni", root, rng.standard_normal((20, cycles, parts))) * size[:, None, None]
        errors[:, :, 0] += AVERAGES[averages][:, None]
        for row, interval, truth in ((0, largest_mean(errors, 0.9), LARGEST), (1, largest_scatter(errors, 0.9), ROUND[parts] * size.max())):
            low, high = interval
            counts[row] += truth < low, truth > high, low <= truth <= high
    return (counts.ravel() / tests * 100).tolist()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tests", type=int, default=1000)
    parser.add_argument("--cycles", type=int, nargs="+", default=[10, 30])
    parser.add_argument("--parts", type=int, default=2, choices=ROUND)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    console = Console(width=180)
    table = Table(title=f"In how many of {options.tests} tests a nominal 90 % lies above the truth, below it, or holds it, %")
    for head in ("planes err", "averages", "cycles", *(f"{name} {what}" for name in ("AT_p", "RT_p") for what in ("above", "below", "holds"))):
        table.add_column(head)
    cases = [(scatter, averages, cycles) for averages, cycles, scatter in product(AVERAGES, options.cycles, SCATTERS)]
    with ProcessPoolExecutor(options.workers) as pool:
        asked = zip(*((*case, options.tests, options.parts) for case in cases), strict=True)
        for case, found in zip(cases, pool.map(held, *asked), strict=True):
            table.add_row(*map(str, case), *(f"{value:.1f}" for value in found))
            console.print(f"{', '.join(map(str, case))} cycles: AT_p {found[2]:.1f}, RT_p {found[5]:.1f} %", highlight=False)
    console.print(table)


if __name__ == "__main__":
    main()
