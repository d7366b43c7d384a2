"""Plots of the error budget, the bending of links, the remedies, and a zone."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.accuracy.page.zone import seen_in
from lostmotion.error_model.budget import costs
from lostmotion.error_model.intervals import pooled_quantile
from lostmotion.error_model.remedies import MEASURED
from lostmotion.mechanism.load_causes import CAUSES, OUTBOARD_CAUSES, OWN_WEIGHT
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.propagation.montecarlo.histogram import counts_between, linear_bins
from lostmotion.reporting.chart import (
    grid,
    histogram,
    label_axes,
    legend,
    mark,
    named_rows,
    one,
    stacked,
    text,
)
from lostmotion.reporting.palette import LEVELS, LIGHT, OF_CAUSE
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Cell, in_one_unit, length, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.accuracy.answer import Answer
    from lostmotion.accuracy.route import FoundInZone
    from lostmotion.error_model.budget import Budget, Cost
    from lostmotion.propagation.montecarlo.waterfall import Waterfall
    from lostmotion.spatial import Floats


LEVELS_TEXT: Final = (
    "Stacked bars of the r.m.s. error as manufactured, with load and pose compensated, and each "
    "robot mapped as well."
)


CAUSES_TEXT: Final = "Stacked bars of each kind of error's share of the mean square, by level."


_PARTS_SHOWN: Final = 15


_LEAST_SHOWN: Final = 5e-4  # would show as 0.0 %


def levels(blame: Budget) -> Figure:
    """Draw the r.m.s. error as manufactured, compensated, and with each robot mapped, split by
    level.
    """
    squares = blame.rms**2 * np.maximum(blame.levels, 0.0)
    stages = ("as manufactured", "load and pose\ncompensated", "and each robot\nmapped")
    left = np.array([squares[k:].sum() for k in range(len(stages))])
    shown = in_one_unit([length(math.sqrt(whole)) for whole in left])
    unit, size = shown[0].shown, np.array([each.as_shown for each in shown])
    figure, on = one("Remaining r.m.s. error", 66)
    share = [
        np.array(
            [
                squares[k] / whole if stage <= k and whole > 0 else 0.0
                for stage, whole in enumerate(left)
            ]
        )
        for k in range(len(stages))
    ]
    stacked(
        on,
        [(name, colour, size * each) for (name, colour), each in zip(LEVELS, share, strict=True)],
    )
    for stage, remaining in enumerate(shown):
        text(on, remaining.as_shown, stage, str(remaining), xytext=(4, 0), va="center")
    named_rows(on, stages)
    on.set_xlim(0, max(float(size[0]), 1e-12) * 1.2)
    label_axes(on, f"r.m.s. error [{unit}], split by mean square")
    legend(figure)
    return figure


def budget(answer: Answer) -> Figure:
    """Draw the error budget by part: shares of the mean-square error in %, largest on top; a
    negative one cancels others.
    """
    found = costs(answer.sampled.tally)
    by_size = sorted(found, key=lambda cost: -abs(cost.share))
    shown = sorted(by_size[:_PARTS_SHOWN], key=lambda cost: -cost.share)
    rest = by_size[_PARTS_SHOWN:]
    names = [short_name(cost.part) for cost in shown]
    shares = [100 * cost.share for cost in shown]
    if rest:
        names.append(several(len(rest), "other"))
        shares.append(100 * sum(cost.share for cost in rest))
    figure, on = one("Share of mean square by part", 24 + 5.2 * len(names))
    values = np.array(shares)
    stacked(
        on,
        [
            ("adds to the error", LIGHT["robot"], np.maximum(values, 0.0)),
            ("cancels others", LIGHT["design"], np.minimum(values, 0.0)),
        ],
        height=0.7,
    )
    for row, share in enumerate(shares):
        text(on, max(share, 0.0), row, str(Cell(share / 100, "%")), xytext=(4, 0), va="center")
    _shares(on, names, values)
    if values.min() < 0:
        legend(figure)
    return figure


def by_level(contributions: Sequence[Cost], title: str) -> Figure:
    """Draw shares of the mean square in %, stacked by level; negative shares cancel others."""
    shown = [cost for cost in contributions if abs(cost.share) >= _LEAST_SHOWN][:_PARTS_SHOWN]
    rest = [cost for cost in contributions if cost not in shown]
    names = [short_name(cost.part) for cost in shown]
    shares = 100 * np.array([cost.levels for cost in shown]).reshape(-1, 3)
    if rest:
        names.append(f"{len(rest)} other{'s' if len(rest) > 1 else ''}")
        shares = np.vstack([shares, 100 * np.sum([cost.levels for cost in rest], axis=0)])
    figure, on = one(title, 30 + 5.2 * len(names))
    low, high = stacked(
        on, [(name, colour, shares[:, k]) for k, (name, colour) in enumerate(LEVELS)], height=0.7
    )
    for row, of_levels in enumerate(shares):
        text(
            on,
            high[row],
            row,
            str(Cell(float(of_levels.sum()) / 100, "%")),
            xytext=(4, 0),
            va="center",
        )
    _shares(on, names, np.concatenate([low, high]))
    legend(figure)
    return figure


def _shares(on: Axes, names: Sequence[str], values: Floats) -> None:
    """Label bars of shares (%), and leave room for their numbers."""
    low, high = min(0.0, float(values.min(initial=0.0))), max(0.0, float(values.max(initial=0.0)))
    room = (high - low) or 1.0
    on.set_xlim(low - (0.04 * room if low < 0 else 0), high + 0.16 * room)
    named_rows(on, names)
    label_axes(on, "share of mean square [%]")


def of_budget(blame: Budget, places: Sequence[Budget]) -> list[Plot]:
    """Return the plots of the error budgets without sampling. None where nothing errs."""
    if not blame.parts:
        return []
    parts = by_level(blame.parts, "Share of mean square by part")
    causes = by_level(blame.causes, "Share of mean square by kind of error")
    return [
        Plot("levels", "levels", levels(blame), LEVELS_TEXT),
        Plot(
            "budget",
            "budget_levels",
            parts,
            "Stacked bars of each part's share of the mean square, by level.",
        ),
        Plot("causes", "causes_levels", causes, CAUSES_TEXT),
        *at_places(places),
    ]


def at_places(places: Sequence[Budget]) -> list[Plot]:
    """Return the plots of the error budgets at poses and in zones."""
    return [
        Plot(
            f"budget-at-{k}",
            f"budget_at_{k}",
            by_level(found.parts, "Share of mean square by part"),
            f"Stacked bars by part: {found.where}.",
        )
        for k, found in enumerate(places, start=1)
        if found.parts
    ]


def bending(answer: Answer) -> Figure:
    """Draw the largest deflection of each link (µm), stacked by cause; a cause that reduces the
    bending extends to the left.
    """
    links = answer.bending
    figure, on = one("Largest deflection of each link", 36 + 8 * len(links))
    rows = []
    for cause in (OWN_WEIGHT, *CAUSES):
        parts = np.array([bent.by_cause.get(cause, (0.0, 0.0, 0.0))[0] * 1e6 for bent in links])
        if parts.any():
            rows.append((OUTBOARD_CAUSES.get(cause, cause), OF_CAUSE[cause], parts))
    stacked(on, rows)
    named_rows(on, [bent.joint for bent in links])
    label_axes(on, "deflection of the link's tip [µm]")
    legend(figure)
    return figure


# The stages of `error_model.remedies.STAGES` that follow each other, and what is done from one to
# the next.
_STEPS = (
    ("as manufactured", "as\nmanufactured"),
    (MEASURED, "calibrated with\nposes measured"),
    ("calibrated", "geometry\ncalibrated"),
    ("both", "load\ncompensated"),
    ("both, and each robot mapped", "harmonics,\nstiffness mapped"),
)


_WIDE = 0.62


def waterfall(remedies: Waterfall) -> Figure:
    """Draw what remains of the 95th percentile after each remedy with its 95 % interval, and above
    it, paler, what the remedy removes.
    """
    stages = {stage.name: stage for stage in remedies.stages}
    steps = [step for step in _STEPS if step[0] in stages]
    at = [stages[name].q95 for name, _ in steps]
    shown = in_one_unit([length(each.value, each.low, each.high) for each in at])
    unit, values = shown[0].shown, [figure.as_shown for figure in shown]
    figure, on = one("95th percentile, one remedy after the other", 76)
    grid(on)
    for k, remaining in enumerate(shown):
        value = remaining.as_shown
        before = values[k - 1] if k else value
        on.bar(k, value, width=_WIDE, color=LIGHT["robot"], linewidth=0)
        on.bar(
            k,
            before - value,
            bottom=value,
            width=_WIDE,
            color=LIGHT["visit"] if before >= value else LIGHT["warn"],
            alpha=0.3,
            linewidth=0,
        )
        if k:
            on.plot(
                [k - 1 + _WIDE / 2, k + _WIDE / 2],
                [before, before],
                color=LIGHT["quiet"],
                linewidth=0.8,
                linestyle=(0, (2, 2)),
            )
        ends = [end if math.isfinite(end) else value for end in (remaining.low, remaining.high)]
        on.errorbar(
            k,
            value,
            [[max(value - ends[0], 0.0)], [max(ends[1] - value, 0.0)]],
            color=LIGHT["ink"],
            linewidth=1.1,
            capsize=3,
        )
        text(on, k, max(value, ends[1]), str(remaining), xytext=(0, 4), ha="center", va="bottom")
    on.set_xticks(range(len(steps)), [words for _, words in steps], color=LIGHT["ink"])
    on.tick_params(axis="x", length=0)
    on.set_ylim(0, 1.14 * max(*values, 1e-12))
    label_axes(on, y=f"95th percentile of the error [{unit}]")
    return figure


def errors_in_zone(answer: Answer, zone: FoundInZone) -> Figure:
    """Draw the distribution of the error in a zone over that of the workspace, with the zone's 95th
    percentile.
    """
    inside = seen_in(answer, zone).sampled
    here, whole = inside.replicate_hist.sum(axis=0), answer.sampled.replicate_hist.sum(axis=0)
    edges, _ = linear_bins(here + whole)
    unit = unit_of_length(float(edges[-1]))
    factor = factor_of(unit)
    figure, on = one("Position error in the zone", 80)
    shares = [100 * counts_between(hist, edges) / hist.sum() for hist in (whole, here)]
    histogram(on, edges * factor, shares[0], LIGHT["line"], "whole workspace")
    on.stairs(shares[1], edges * factor, color=LIGHT["robot"], linewidth=1.5, label="in the zone")
    on.set_ylim(bottom=0)
    mark(
        on,
        pooled_quantile(inside.group_hist, inside.replicate_hist, 0.95),
        "95th percentile, in the zone",
        unit,
    )
    label_axes(
        on,
        f"position error [{unit}]",
        f"samples per {float(edges[1] - edges[0]) * factor:.3g} {unit} [%]",
    )
    legend(figure)
    return figure
