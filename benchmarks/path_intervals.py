"""Coverage of the intervals of AT_p and RT_p of measured paths.

Tests are synthetic: 20 planes of a path, 10 and 30 cycles, errors across the path normal. Planes
err each for itself, like their neighbours, or all together; as much everywhere, up to 2.5 times as
much in one place, or 2.5 times as much in a single plane or half of them; the path's averages lie 1
to 3 off, rising along it, 3 off everywhere, or 1 off and 3 in a single plane or half of them. A
nominal 90 % is to hold 90 % of the tests, within sampling: with 1 000 of them two standard errors
are 2 %. Errors with one component describe AT_a, b, c and RT_a, b, c. RT_p does not ask how far the
path is off, and is asked once.

    python benchmarks/path_intervals.py [--tests 1000] [--cycles 10 30] [--parts 2] [--workers 2]
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from itertools import product

import numpy as np
from rich.console import Console
from rich.table import Table

from lostmotion.error_model.worst_plane import largest_mean, largest_scatter

PLANES = np.linspace(0, 1, 20)
BUMP = np.exp(-(((PLANES - 0.3) / 0.2) ** 2))
SINGLE = np.arange(20) == 6
HALF = PLANES > 0.5
# What neighbours have in common, as a length along the path, and how much more each errs.
SCATTERS = {
    "each for itself, alike": (0.0, 0 * PLANES),
    "each for itself, more in one place": (0.0, BUMP),
    "like their neighbours, alike": (0.15, 0 * PLANES),
    "like their neighbours, more in one place": (0.15, BUMP),
    "all together, alike": (3.0, 0 * PLANES),
    "each for itself, more in one plane": (0.0, SINGLE),
    "each for itself, more in half of them": (0.0, HALF),
    "like their neighbours, more in one plane": (0.15, SINGLE),
}
AVERAGES = {
    "1 to 3 along the path": 1 + 2 * PLANES,
    "3 everywhere": np.full(20, 3.0),
    "3 in one plane": 1 + 2.0 * SINGLE,
    "3 in half of them": 1 + 2.0 * HALF,
}
LARGEST = 3.0
# Deviations that RT is of one part, and of a round normal scatter in a plane: mean + 3 s of the
# distances.
ROUND = {1: 3.0, 2: np.sqrt(np.pi / 2) + 3 * np.sqrt(2 - np.pi / 2)}


def held(scatter: str, averages: str, cycles: int, tests: int, parts: int) -> list[float]:
    """Count in percent how often the intervals of AT_p and RT_p lie above the truth, below it, or
    hold it.
    """
    common, more = SCATTERS[scatter]
    kernel = np.exp(-0.5 * ((PLANES[:, None] - PLANES) / common) ** 2) if common else np.eye(20)
    root = np.linalg.cholesky(kernel + 1e-9 * np.eye(20))
    size = 1 + 1.5 * more
    first = averages == next(iter(AVERAGES))
    rng = np.random.default_rng(
        [list(SCATTERS).index(scatter), list(AVERAGES).index(averages), cycles]
    )
    counts = np.full((2, 3), np.nan)
    counts[: 1 + first] = 0
    for _ in range(tests):
        errors = (
            np.einsum("pq,qni->pni", root, rng.standard_normal((20, cycles, parts)))
            * size[:, None, None]
        )
        errors[:, :, 0] += AVERAGES[averages][:, None]
        found = [(largest_mean(errors, 0.9), LARGEST)]
        if first:
            found.append((largest_scatter(errors, 0.9), ROUND[parts] * size.max()))
        for row, (each, truth) in enumerate(found):
            counts[row] += truth < each.low, truth > each.high, each.low <= truth <= each.high
    return (counts.ravel() / tests * 100).tolist()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--tests", type=int, default=1000)
    parser.add_argument("--cycles", type=int, nargs="+", default=[10, 30])
    parser.add_argument("--parts", type=int, default=2, choices=ROUND)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    console = Console(width=180)
    table = Table(
        title=(
            f"In how many of {options.tests} tests a nominal 90 % lies above the truth, below it, "
            "or holds it, %"
        )
    )
    for head in (
        "planes err",
        "averages",
        "cycles",
        *(f"{name} {what}" for name in ("AT_p", "RT_p") for what in ("above", "below", "holds")),
    ):
        table.add_column(head)
    cases = [
        (scatter, averages, cycles)
        for averages, cycles, scatter in product(AVERAGES, options.cycles, SCATTERS)
    ]
    with ProcessPoolExecutor(options.workers) as pool:
        asked = zip(*((*case, options.tests, options.parts) for case in cases), strict=True)
        for case, found in zip(cases, pool.map(held, *asked), strict=True):
            said = ["" if np.isnan(value) else f"{value:.1f}" for value in found]
            table.add_row(*map(str, case), *said)
            console.print(
                (
                    f"{', '.join(map(str, case))} cycles: AT_p {said[2]} "
                    f"{'and RT_p ' if said[5] else ''}{said[5]} %"
                ),
                highlight=False,
            )
    console.print(table)


if __name__ == "__main__":
    main()
