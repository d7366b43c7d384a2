"""Plots of a comparison: the error of each arm, its distribution, and the budgets side by side."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.compare.page.figures import measure_of
from lostmotion.error_model.error_bins import bin_edges
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.poses import reachable_points
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.mechanism.vertical_axis import vertical_axis
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.reporting.chart import (
    grid,
    grouped,
    label,
    label_axes,
    legend,
    named_rows,
    one,
    stacked,
    zero_line,
)
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.section import SECTION_TEXT, PoseValues, sections

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.comparison.comparison import Change, Comparison

_COLOURS: Final = tuple(
    LIGHT[name] for name in ("robot", "design", "visit", "warn", "other", "quiet")
)
_PARTS: Final = 12
_CURVE: Final = 200
_APART: Final = 0.22


def compare_plots(comparison: Comparison) -> list[Plot]:
    """Return the plots in reading order."""
    several = len(comparison.changes) > 1
    out = []
    if any(_relative(comparison, change) for change in comparison.changes):
        words = (
            "Points with intervals: relative change of each figure against the first arm; a line "
            "at zero."
        )
        out.append(Plot("changes", "changes", relative_changes(comparison), words))
    for k, change in enumerate(comparison.changes, 2):
        end = f"-{k}" if several else ""
        of_parts, of_shares = (
            f"{section}{f'_{k}' if several else ''}" for section in ("parts", "parts_shares")
        )
        if any(each.alone.value or each.before for each in change.parts):
            out.append(
                Plot(
                    f"parts{end}",
                    of_parts,
                    budgets(comparison, change),
                    "Bars of the r.m.s. error of each part by itself in both arms.",
                )
            )
        if change.moving("parts"):
            out.append(
                Plot(
                    f"shares{end}",
                    of_shares,
                    shares(change),
                    "Bars of the share of each part in the change of the r.m.s. error.",
                )
            )
    for k, change in enumerate(comparison.changes, 2):
        out += _apart(comparison, change, f"-{k}" if several else "")
    words = "Share of all positions whose error is below each value, a curve for each arm."
    return [*out, Plot("distribution", "changes", distribution(comparison), words)]


def _apart(comparison: Comparison, change: Change, end: str) -> list[Plot]:
    """Return the sections through the workspace of the first arm with the distance of the commanded
    tool points; none where it is zero.
    """
    apart, first = change.apart, comparison.arms[0].arm
    if apart is None or apart.is_zero:
        return []
    unit, axes = (
        unit_of_length(apart.largest),
        [vertical_axis(arm) for arm in (first, change.arm.arm)],
    )
    turns = axes[0] is not None and axes[0] == axes[1]
    what = f"distance of the commanded tool points, {label(change.arm.label)}"
    values = apart.distances * factor_of(unit)
    shown = PoseValues(
        first,
        apart.tool,
        values,
        what,
        unit,
        apart.largest_at,
        "largest distance",
        reachable_points(first),
        turns=turns,
    )
    return [
        Plot(f"tool-points-{name}{end}", "tool_points", drawn, SECTION_TEXT[name])
        for name, drawn in sections(shown)
    ]


def _relative(comparison: Comparison, change: Change) -> list[tuple[str, Estimate]]:
    """Return the relative changes (%) of the figures of accuracy, each with its name."""
    out = []
    for measure in comparison.measures:
        before, size = measure.value(comparison.arms[0]).value, change.figures[measure.key]
        if measure.group == "accuracy" and before and math.isfinite(size.value):
            out.append(
                (
                    measure.name,
                    Estimate(*(100 * end / before for end in (size.value, size.low, size.high))),
                )
            )
    return out


def relative_changes(comparison: Comparison) -> Figure:
    """Draw the relative change of each figure of accuracy against the first arm, with its interval,
    and a line at zero.
    """
    drawn = [(change.arm.label, _relative(comparison, change)) for change in comparison.changes]
    names = [name for name, _ in drawn[0][1]]
    figure, on = one(
        f"Change against {label(comparison.arms[0].label)}", 30 + (5 + 3 * len(drawn)) * len(names)
    )
    for k, (name, changes) in enumerate(drawn):
        colour, lift = _COLOURS[k + 1], (k - (len(drawn) - 1) / 2) * _APART
        values = np.array([size.value for _, size in changes])
        ends = np.nan_to_num(
            np.array([[size.value - size.low, size.high - size.value] for _, size in changes]).T
        )
        on.errorbar(
            values,
            np.arange(len(values)) + lift,
            xerr=ends,
            color=colour,
            label=label(name),
            fmt="o",
            markersize=4,
            linewidth=1.3,
            capsize=3,
        )
    zero_line(on)
    grid(on, "x")
    named_rows(on, names)
    label_axes(on, "change [%]")
    legend(figure)
    return figure


def distribution(comparison: Comparison) -> Figure:
    """Draw the share of all positions whose error is below each value, a curve for each arm, with
    its 95th percentile.
    """
    figure, on = one("Distribution of the position error", 80)
    grid(on, "both")
    within = measure_of(comparison, "p95")
    levels = [within.value(each).value for each in comparison.arms] if within is not None else []
    unit = unit_of_length(max(levels, default=0.0))
    for each, level, colour in zip(comparison.arms, levels, _COLOURS, strict=False):
        counts = each.sampled.replicate_hist.sum(axis=0)
        below = np.concatenate([[0], np.cumsum(counts)])
        occupied = np.flatnonzero(counts)
        edges = bin_edges()
        first, last = int(occupied[0]), int(occupied[-1]) + 1
        at = np.unique(
            np.searchsorted(
                edges, np.linspace(edges[first], edges[min(last, len(edges) - 1)], _CURVE)
            ).clip(first, last)
        )
        on.plot(
            edges[at] * factor_of(unit),
            100 * below[at] / below[-1],
            color=colour,
            label=label(each.label),
        )
        on.axvline(level * factor_of(unit), color=colour, linewidth=0.8, linestyle=(0, (2, 2)))
    on.set_ylim(0, 102)
    on.set_xlim(left=0)
    label_axes(
        on, f"position error [{unit}]; dotted: 95 % of positions", "share of positions below [%]"
    )
    legend(figure)
    return figure


def budgets(comparison: Comparison, change: Change) -> Figure:
    """Draw the r.m.s. error of each part by itself in both arms, side by side."""
    shown = sorted(change.parts, key=lambda each: -max(each.before or 0.0, each.after or 0.0))[
        :_PARTS
    ]
    values = [
        np.array([each.before or 0.0 for each in shown]),
        np.array([each.after or 0.0 for each in shown]),
    ]
    unit = unit_of_length(float(max(values[0].max(), values[1].max())))
    figure, on = one("R.m.s. error of each part by itself", 30 + 8 * len(shown))
    labels = (comparison.arms[0].label, change.arm.label)
    grouped(
        on,
        [
            (label(name), colour, own * factor_of(unit))
            for name, colour, own in zip(labels, _COLOURS, values, strict=False)
        ],
    )
    named_rows(on, [short_name(each.part) for each in shown])
    label_axes(on, f"r.m.s. error [{unit}]")
    legend(figure)
    return figure


def shares(change: Change) -> Figure:
    """Draw the share of each part in the change of the r.m.s. error."""
    shown = sorted(change.moving("parts")[:_PARTS], key=lambda each: each.share.value)
    values = np.array([each.share.value for each in shown])
    unit = unit_of_length(float(np.abs(values).max()))
    figure, on = one("Change of the r.m.s. error by part", 24 + 5.2 * len(shown))
    sizes = values * factor_of(unit)
    stacked(
        on,
        [
            ("less error", LIGHT["visit"], np.minimum(sizes, 0.0)),
            ("more error", LIGHT["warn"], np.maximum(sizes, 0.0)),
        ],
        height=0.7,
    )
    zero_line(on)
    named_rows(on, [short_name(each.part) for each in shown])
    label_axes(on, f"change of the r.m.s. error [{unit}]")
    legend(figure)
    return figure
