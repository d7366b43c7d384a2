"""Plots of a sweep: error, AP and RP over one key, a map over two, main effects over more; error
distribution of each design.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.arrival import rp_name
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.propagation.figures import HEADLINE
from lostmotion.reporting.chart import (
    axes,
    figure,
    grid,
    label,
    label_axes,
    legend,
    logarithmic,
    one,
    text,
)
from lostmotion.reporting.map_chart import cells, class_legend, class_of
from lostmotion.reporting.palette import LIGHT, class_limits
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Cell
from lostmotion.runs.design_names import design_name, short_keys

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.io.sweep import Axis
    from lostmotion.runs.job import Order
    from lostmotion.runs.summary import Outcome
    from lostmotion.spatial import Floats

    _Curve = tuple[str, str, Callable[[Outcome], Estimate | None]]

_COLOURS: Final = tuple(
    LIGHT[name] for name in ("robot", "design", "visit", "warn", "ink", "other")
)
_DASHES: Final = ("-", "--", ":", "-.", (0, (8, 2)), (0, (8, 2, 2, 2)))
# Classes from this one on are so far from the paper in lightness that text on them has the paper's
# colour.
_DARK_FROM: Final = 3
_MOST_CURVES: Final = 6
_MOST_LABELLED: Final = 6
_PAIRED: Final = "paired differences from the first design are more precise"


def _plot(key: str, drawn: Figure, words: str) -> Plot:
    return Plot(key, key, drawn, words)


def sweep_plots(order: Order, outcomes: Sequence[Outcome]) -> list[Plot]:
    """Return the plots in reading order, over the keys that differ between designs."""
    order = order.model_copy(
        update={"axes": tuple(axis for axis in order.axes if len(axis.values) > 1) or order.axes}
    )
    out = []
    if len(order.axes) == 1:
        out.append(
            _plot(
                "designs",
                over_one(order, outcomes),
                "Curves of the 95th percentile and the mean of the error over the swept key.",
            )
        )
        if any(each.ap is not None for each in outcomes):
            out.append(
                _plot(
                    "iso9283",
                    iso_over_one(order, outcomes),
                    "Curves of AP and RP over the swept key.",
                )
            )
    elif len(order.axes) == 2:  # noqa: PLR2004 - a plane
        of_error = [each.figures.get(HEADLINE) for each in outcomes]
        out.append(
            _plot(
                "designs",
                over_two(order, of_error, "95th percentile of the position error", _PAIRED),
                "Map of the 95th percentile of the error over the two swept keys.",
            )
        )
        if any(each.rp is not None for each in outcomes):
            name = f"{rp_name(order.approach)}, 95th percentile of robots"
            out.append(
                _plot(
                    "iso9283",
                    over_two(order, [each.rp for each in outcomes], name),
                    "Map of RP over the two swept keys.",
                )
            )
    elif order.axes:
        out.append(
            _plot(
                "designs",
                effects(order, outcomes),
                "For each key, the 95th percentile of every design and the mean of each value.",
            )
        )
    standing = [each for each in outcomes if not each.falls]
    if len({each.mass for each in standing}) > 1 or len({each.price for each in standing}) > 1:
        words = "Points: the 95th percentile of the error and RP of each design over its mass, and "
        words += "over its price where stated."
        out.append(_plot("masses", against_mass(standing), words))
    if len(standing) <= _MOST_CURVES:
        out.append(
            Plot(
                "spread",
                "levels" if order.axes else "designs",
                spread(order, standing),
                "Cumulative distribution of the error.",
            )
        )
    return out


def _positions(on: Axes, axis: Axis, name: str) -> Floats:
    """Return the positions of a key's values on the x axis, and name the axis: quantities to scale,
    other values as text.
    """
    if axis.quantities is None:
        at = np.arange(len(axis.labels), dtype=float)
        on.set_xticks(at, [label(text) for text in axis.labels], parse_math=False)
        on.set_xlim(-0.5, len(at) - 0.5)
        label_axes(on, label(name))
        return at
    numbers, unit = axis.quantities
    rising = np.sort(numbers)
    ratios = rising[1:] / rising[:-1] if rising[0] > 0 and len(rising) > 2 else np.array([1.0, 2.0])  # noqa: PLR2004 - two have any ratio
    if np.allclose(ratios, ratios[0], rtol=1e-6) and ratios[0] > 1 + 1e-9:
        logarithmic(on)
        on.set_xticks(rising)
    label_axes(on, f"{label(name)} [{unit or 1}]")
    return np.asarray(numbers, dtype=float)


def _curves(
    order: Order, outcomes: Sequence[Outcome], curves: Sequence[_Curve], title: str
) -> Figure:
    """Plot estimates over one key, with intervals as bands, or as error bars where the values have
    no order.
    """
    axis = order.axes[0]
    made, on = one(title, 84)
    grid(on)
    x = _positions(on, axis, short_keys(order.axes)[0])
    ranked = np.argsort(x, kind="stable")
    estimates = {name: [pick(outcomes[k]) for k in ranked] for name, _, pick in curves}
    unit = unit_of_length(
        max(
            (each.value for members in estimates.values() for each in members if each is not None),
            default=1.0,
        )
    )
    for name, colour, _ in curves:
        found = [
            (x[k], each)
            for k, each in zip(ranked, estimates[name], strict=True)
            if each is not None
        ]
        along = np.array([place for place, _ in found])
        y, low, high = (
            np.array([getattr(each, end) for _, each in found]) * factor_of(unit)
            for end in ("value", "low", "high")
        )
        if axis.quantities is None:
            ends = np.nan_to_num([y - low, high - y], posinf=0.0)
            on.errorbar(
                along,
                y,
                yerr=ends,
                fmt="o",
                color=colour,
                markersize=5,
                elinewidth=1.1,
                capsize=3,
                label=name,
            )
            continue
        if np.isfinite(high - low).all():
            on.fill_between(along, low, high, color=colour, alpha=0.2, linewidth=0)
        on.plot(along, y, color=colour, linewidth=1.6, marker="o", markersize=4, label=name)
    on.set_ylim(bottom=0)
    label_axes(on, y=f"position error [{unit}]")
    legend(made)
    return made


def over_one(order: Order, outcomes: Sequence[Outcome]) -> Figure:
    """Plot the error over one key, with 95 % confidence intervals."""
    curves = (
        ("95th percentile", LIGHT["robot"], lambda each: each.figures.get(HEADLINE)),
        ("mean", LIGHT["design"], lambda each: each.figures.get("mean")),
    )
    return _curves(order, outcomes, curves, "Position error, with 95 % confidence interval")


def iso_over_one(order: Order, outcomes: Sequence[Outcome]) -> Figure:
    """Plot AP and RP over one key, with 95 % confidence intervals."""
    curves = (
        ("AP, 95th percentile of robots", LIGHT["visit"], lambda each: each.ap),
        (
            f"{rp_name(order.approach)}, 95th percentile of robots",
            LIGHT["warn"],
            lambda each: each.rp,
        ),
    )
    return _curves(
        order, outcomes, curves, "Accuracy and repeatability, with 95 % confidence intervals"
    )


def over_two(
    order: Order, estimates: Sequence[Estimate | None], title: str, hint: str = ""
) -> Figure:
    """Plot a map over two keys in classes; cells whose interval overlaps that of the smallest are
    marked, and those of designs that fall at some poses.

    The classes span the ends of the intervals, so that differences within them are faint. `hint`
    names a more precise comparison.
    """
    first, second = order.axes
    names = [label(name) for name in short_keys(order.axes)]
    shape = (len(first.values), len(second.values))
    found = [each for each in estimates if each is not None]
    unit = unit_of_length(max(each.value for each in found))
    factor = factor_of(unit)
    values = np.array(
        [math.nan if each is None else each.value * factor for each in estimates]
    ).reshape(shape)
    overlapping = _overlap_smallest(estimates)
    ends = [
        end * factor
        for each in found
        for end in (each.low, each.value, each.high)
        if math.isfinite(end)
    ]
    limits = class_limits(max(min(ends), 0.0), max(ends))
    classes = class_of(values, limits)
    made, on = one(title, min(50 + 9.0 * shape[0], 170.0))
    cells(on, np.arange(shape[1] + 1) - 0.5, np.arange(shape[0] + 1) - 0.5, classes.T)
    if shape[1] <= _MOST_LABELLED:
        for k, each in enumerate(estimates):
            row, column = divmod(k, shape[1])
            colour = LIGHT["ink"] if classes[row, column] < _DARK_FROM else LIGHT["paper"]
            words = (
                "falls"
                if each is None
                else ("≈ " if overlapping[k] else "")
                + str(Cell(each.value, unit, each.low, each.high))
            )
            text(on, column, row, words, colour=colour, ha="center", va="center")
    on.set_xticks(range(shape[1]), [label(each) for each in second.labels], parse_math=False)
    on.set_yticks(range(shape[0]), [label(each) for each in first.labels], parse_math=False)
    on.tick_params(length=0)
    note = ""
    if all(overlapping):
        note = "\n≈ all intervals overlap that of the smallest:\n" + (
            hint or "differences may be chance"
        )
    elif any(overlapping):
        note = "\n≈ interval overlaps that of the smallest:\n" + (hint or "may be as small")
    label_axes(on, names[1] + note, names[0])
    class_legend(made, limits, f"[{unit}]")
    return made


def _overlap_smallest(estimates: Sequence[Estimate | None]) -> list[bool]:
    """Return which intervals overlap that of the smallest estimate, unknown ends counted as
    overlapping; none if it is alone.
    """
    best = min((each for each in estimates if each is not None), key=lambda each: each.value)
    high = math.inf if math.isnan(best.high) else best.high
    overlapping = [
        each is not None and (math.isnan(each.low) or each.low <= high) for each in estimates
    ]
    return overlapping if sum(overlapping) > 1 else [False] * len(estimates)


def against_mass(outcomes: Sequence[Outcome]) -> Figure:
    """Plot the 95th percentile of the error and RP of each design, with intervals, over its mass
    and its price, as far as designs differ in them.
    """
    along = (
        [("mass of the arm [kg]", [each.mass for each in outcomes])]
        if len({each.mass for each in outcomes}) > 1
        else []
    )
    prices = [math.nan if each.price is None else each.price for each in outcomes]
    along += (
        [("price of the arm", prices)]
        if len({each for each in prices if math.isfinite(each)}) > 1
        else []
    )
    unit = unit_of_length(max(each.p95.value for each in outcomes))
    made = figure(22 + 62.0 * len(along))
    for on, (name, x) in zip(
        axes(made, "Error over mass and price", rows=len(along))[:, 0], along, strict=True
    ):
        grid(on, "both")
        curves = [("95th percentile", "robot", [each.p95 for each in outcomes])]
        curves += (
            [
                (
                    "RP, 95th percentile of robots",
                    "warn",
                    [each.rp for each in outcomes if each.rp is not None],
                )
            ]
            if outcomes[0].rp
            else []
        )
        for what, colour, found in curves:
            y, low, high = (
                np.array([getattr(each, end) for each in found]) * factor_of(unit)
                for end in ("value", "low", "high")
            )
            ends = np.nan_to_num([y - low, high - y], posinf=0.0)
            on.errorbar(
                x,
                y,
                yerr=ends,
                fmt="o",
                color=LIGHT[colour],
                markersize=4,
                elinewidth=1.0,
                capsize=2,
                label=what,
            )
        on.set_ylim(bottom=0)
        label_axes(on, name, f"error [{unit}]")
    legend(made)
    return made


def effects(order: Order, outcomes: Sequence[Outcome]) -> Figure:
    """Plot the main effect of each key: the mean over all other keys, and every design."""
    shape = tuple(len(axis.values) for axis in order.axes)
    values = [math.nan if each.falls else each.p95.value for each in outcomes]
    unit = unit_of_length(float(np.nanmax(values)))
    errors: Floats = (np.array(values) * factor_of(unit)).reshape(shape)
    made = figure(22 + 56.0 * len(shape))
    panels = axes(
        made, "Main effects on the 95th percentile of the error", rows=len(shape), sharey=True
    )[:, 0]
    for k, (on, axis, name) in enumerate(
        zip(panels, order.axes, short_keys(order.axes), strict=True)
    ):
        x = _positions(on, axis, name)
        at = np.indices(shape)[k].ravel()
        on.plot(
            x[at],
            errors.ravel(),
            linestyle="none",
            marker="o",
            markersize=3,
            color=LIGHT["robot"],
            alpha=0.5,
            label="one design",
        )
        means = errors.mean(axis=tuple(j for j in range(len(shape)) if j != k))
        ranked = np.argsort(x, kind="stable")
        on.plot(
            x[ranked],
            means[ranked],
            color=LIGHT["warn"],
            linewidth=1.6,
            marker="o",
            markersize=4,
            label="mean over the other keys",
        )
        label_axes(on, y=f"95th percentile [{unit}]")
    legend(made)
    return made


def spread(order: Order, outcomes: Sequence[Outcome]) -> Figure:
    """Plot the cumulative distribution of the error of each design."""
    unit = unit_of_length(max(each.worst[0].error for each in outcomes))
    made, on = one("Cumulative distribution of the position error", 88)
    grid(on, "both")
    for k, each in enumerate(outcomes):
        name = label(design_name(order.axes, each.design)) if len(outcomes) > 1 else None
        x, y = each.spread[0] * factor_of(unit), 100 * each.spread[1]
        on.plot(x, y, color=_COLOURS[k], linestyle=_DASHES[k], linewidth=1.6, label=name)
    on.set_xlim(left=0)
    on.set_ylim(0, 101)
    label_axes(on, f"position error [{unit}]", "samples [%]")
    legend(made)
    return made
