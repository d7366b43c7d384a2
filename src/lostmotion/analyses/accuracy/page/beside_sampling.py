"""Tables of the figures without sampling beside those of Monte Carlo."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.propagation.analytic import MOST_UNCERTAIN
from lostmotion.propagation.error_samples import Drawn, Summed
from lostmotion.propagation.figures import RMS, figures_of
from lostmotion.propagation.montecarlo import kernel
from lostmotion.reporting.sheet import Cell, Row, Section, length, several

if TYPE_CHECKING:
    from lostmotion.propagation.analytic import Analytic
    from lostmotion.propagation.montecarlo.montecarlo import Sampled
    from lostmotion.spatial import Floats

UNKNOWN: Final = "uncertain by more than 5 %: use Monte Carlo"


def comparisons(analytic: Analytic, summed: Summed, sampled: Sampled) -> tuple[Section, Section]:
    """Return the differences between both routes over all poses, and at each pose, in half-widths
    of Monte Carlo's interval.
    """
    return _over_all(summed, sampled), _at_each(analytic, sampled)


def _over_all(summed: Summed, sampled: Sampled) -> Section:
    """Compare every figure that both routes compute; 99.7 % here alone, since Monte Carlo keeps no
    such quantile at each pose.
    """
    drawn_errors = replace(Drawn.of(sampled), levels=summed.levels)
    compared = [
        (key, each.name, each.estimate(summed), each.estimate(drawn_errors))
        for key, each in figures_of(summed).items()
        if each.group == "error" and each is not RMS
    ]
    poses = len(sampled.per_pose)
    drawn = (
        f"{several(poses, 'pose')} x {several(sampled.robots, 'robot')} x "
        f"{several(sampled.visits, 'visit')}"
    )
    rows = []
    for key, name, exact, one in compared:
        half = one.half
        apart = abs(exact.value - one.value) / half if half > 0 else math.nan
        if not math.isfinite(exact.value):
            why = f"nothing to compare: {UNKNOWN}"
        elif not math.isfinite(apart):
            why = "nothing to compare: " + (
                "nothing errs" if half == 0 else "too few robots for Monte Carlo's interval"
            )
        else:
            why = "" if apart <= 1 else "beyond the interval"
        values = (length(one.value, one.low, one.high, drawn), Cell(apart, "1", samples=drawn))
        rows.append(Row(name, values, why, key))
    note = (
        "over all poses, which both routes share: how far the figure without sampling lies "
        "from Monte Carlo's, in half-widths of the latter's 95 % "
        "interval; beyond 1 the two disagree, but for one time in twenty"
    )
    return Section(
        "routes_all",
        "Without sampling against Monte Carlo, over all poses",
        ("Monte Carlo", "apart"),
        tuple(rows),
        note,
    )


def _at_each(analytic: Analytic, sampled: Sampled) -> Section:
    table = sampled.per_pose
    quantiles = np.where(
        analytic.quantiles_uncertainty <= MOST_UNCERTAIN * analytic.quantiles,
        analytic.quantiles,
        np.nan,
    )
    rows = [_apart("mean", analytic.mean, table[:, kernel.MEAN], table[:, kernel.MEAN_ERROR])]
    for k, level in enumerate(kernel.QUANTILES):
        if level in analytic.levels:
            value, low, high = (table[:, kernel.FIRST_QUANTILE + 3 * k + c] for c in range(3))
            rows.append(
                _apart(
                    f"{100 * level:.4g}th percentile",
                    quantiles[:, analytic.levels.index(level)],
                    value,
                    (high - low) / 2,
                )
            )
    kept = ", ".join(f"{100 * level:.4g}" for level in kernel.QUANTILES)
    note = (
        "differences at each pose in half-widths of Monte Carlo's 95 % interval there: most "
        "should lie below 1; all poses share their robots. "
        f"Monte Carlo keeps {kept} % at each pose: what lies beyond is compared over all poses "
        "alone"
    )
    return Section(
        "routes",
        "Without sampling against Monte Carlo, pose by pose",
        ("typical", "largest"),
        tuple(rows),
        note,
    )


def _apart(label: str, summed: Floats, drawn: Floats, half: Floats) -> Row:
    """Compare one figure at every pose that has it by both routes, and say why others cannot be."""
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.abs(summed - drawn) / half
    known = np.isfinite(shares)
    untold = np.isnan(summed)
    still = ~known & ~untold & (half == 0)
    reasons = (
        (int(untold.sum()), "uncertain without sampling"),
        (int(still.sum()), "without any scatter"),
        (int((~known & ~untold & ~still).sum()), "with too few robots for Monte Carlo's interval"),
    )
    why = "; ".join(f"{count} {reason}" for count, reason in reasons if count)
    counted = f"{known.sum()} of {several(len(known), 'pose')}"
    note = (counted if known.any() else "no pose to compare") + (f": {why}" if why else "")
    typical, largest = (
        (float(np.median(shares[known])), float(shares[known].max()))
        if known.any()
        else (math.nan, math.nan)
    )
    return Row(
        label, (Cell(typical, "1", samples=counted), Cell(largest, "1", samples=counted)), note
    )
