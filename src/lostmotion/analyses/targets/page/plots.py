"""Plots of a target: stated and allowed size of each item, the allocation to all items, and yield
against target.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.targets.page.items import ordered
from lostmotion.analyses.targets.page.yields import criterion_label
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.chart import grid, label_axes, legend, logarithmic, named_rows, one
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Cell

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.analyses.targets.targets import Target
    from lostmotion.sizing.allowances import Allowance
    from lostmotion.spatial import Floats

_MOST_BARS: Final = 40
_FACTOR: Final = "factor on the error [1]"


def plots(result: Target) -> list[Plot]:
    """Return the plots in reading order."""
    out = []
    for key, title, allowed in (
        ("single", "Allowance for one item at a time", result.allowances),
        ("kinds", "Allowance for one cause in all parts of a kind", result.shared_allowances),
    ):
        some = ordered(allowed)[:_MOST_BARS]
        if some:
            out.append(
                Plot(
                    f"{key}-allowed",
                    key,
                    dumbbells(some, title),
                    "Dumbbells from the stated to the allowed size of each item.",
                )
            )
    if result.equal_factor is not None:
        out.append(
            Plot(
                "together-allowed",
                "together",
                allocation_plot(result),
                "Dumbbells from the stated size of each item to that of equal effect.",
            )
        )
    out.append(
        Plot(
            "yield",
            "yield",
            yield_curve(result),
            "Share of robots that meet a target, against the target, with its confidence interval.",
        )
    )
    return out


def dumbbells(allowed: Sequence[Allowance], title: str) -> Figure:
    """Plot the factor on the error of each item with which the target is just met."""
    made, on = one(title, 44 + 5.5 * len(allowed))
    values = np.array([each.factor.value for each in allowed])
    ends = [
        [
            value - _finite(each.factor.low, value)
            for each, value in zip(allowed, values, strict=True)
        ]
    ]
    ends += [
        [
            _finite(each.factor.high, value) - value
            for each, value in zip(allowed, values, strict=True)
        ]
    ]
    _from_one(on, values)
    for chosen, name, colour in (
        (values >= 1, "allowed, 95 % confidence interval", LIGHT["robot"]),
        (values < 1, "must be smaller", LIGHT["warn"]),
    ):
        at = np.flatnonzero(chosen)
        if len(at):
            how: dict[str, Any] = {
                "markersize": 4.5,
                "ecolor": LIGHT["ink"],
                "elinewidth": 0.9,
                "capsize": 2,
            }
            on.errorbar(
                values[at], at, xerr=np.array(ends)[:, at], fmt="o", color=colour, label=name, **how
            )
    return _formatted(made, on, [short_name(each.item.name) for each in allowed], values)


def allocation_plot(result: Target) -> Figure:
    """Plot the allocation of equal effect, and the equal factor on all errors."""
    factor, effect = result.equal_factor, result.equal_effect
    if factor is None:
        raise ValueError("nothing moves the tool")
    shown = [k for k in range(len(result.items)) if np.isfinite(factor.factors[k])]
    other = factor if effect is None else effect
    shown = sorted(shown, key=lambda k: float(other.factors[k]))[:_MOST_BARS]
    made, on = one(
        "Allocation to all items: as stated, and with equal effect", 44 + 5.5 * len(shown)
    )
    values = np.array([float(other.factors[k]) for k in shown])
    _from_one(on, values)
    kind = "equal effect" if effect is not None else "equal factor"
    for chosen, name, colour in (
        (values >= 1, kind, LIGHT["visit"]),
        (values < 1, f"{kind}, must be smaller", LIGHT["warn"]),
    ):
        at = np.flatnonzero(chosen)
        if len(at):
            on.plot(
                values[at],
                at,
                linestyle="none",
                marker="o",
                markersize=4.5,
                color=colour,
                label=name,
            )
    uniform = float(np.nanmax(factor.factors))
    on.axvline(
        uniform,
        color=LIGHT["design"],
        linewidth=1.4,
        linestyle=(0, (1.5, 1.5)),
        label=f"equal factor {Cell(uniform, '1')}",
    )
    names = [
        short_name(result.items[k].name) + (" (not limiting)" if other.not_limiting[k] else "")
        for k in shown
    ]
    return _formatted(made, on, names, np.append(values, uniform))


def yield_curve(result: Target) -> Figure:
    """Plot the yield (%) against the target (mm)."""
    made, on = one("Yield against target, with 95 % confidence interval", 84)
    grid(on, "both")
    for each, colour in zip(result.yields, (LIGHT["robot"], LIGHT["design"]), strict=True):
        targets, shares, ends = each.curve()
        on.fill_between(
            targets * 1e3,
            100 * ends[:, 0],
            100 * ends[:, 1],
            step="post",
            color=colour,
            alpha=0.2,
            linewidth=0,
        )
        name = criterion_label(each)
        on.step(targets * 1e3, 100 * shares, where="post", color=colour, linewidth=1.5, label=name)
    on.axvline(
        result.target * 1e3,
        color=LIGHT["warn"],
        linewidth=1.2,
        linestyle=(0, (1.5, 1.5)),
        label="target",
    )
    on.set_ylim(-2, 102)
    label_axes(on, "target [mm]", "yield [%]")
    legend(made)
    return made


def _finite(value: float, instead: float) -> float:
    return value if math.isfinite(value) else instead


def _from_one(on: Axes, values: Floats) -> None:
    """Draw a bar from the stated size, a factor of 1, to each value."""
    for row, value in enumerate(values):
        colour = LIGHT["robot"] if value >= 1 else LIGHT["warn"]
        on.plot(
            [1.0, value], [row, row], color=colour, linewidth=2.2, alpha=0.4, solid_capstyle="butt"
        )
    how: dict[str, Any] = {
        "linestyle": "none",
        "marker": "|",
        "markersize": 8,
        "markeredgewidth": 1.4,
    }
    on.plot(np.ones(len(values)), range(len(values)), color=LIGHT["ink"], label="as stated", **how)


def _formatted(made: Figure, on: Axes, names: Sequence[str], values: Floats) -> Figure:
    """Label dumbbells over a logarithmic factor."""
    from matplotlib.ticker import FixedLocator

    low, high = math.log10(min(1.0, float(values.min()))), math.log10(max(1.0, float(values.max())))
    margin = 0.06 * (high - low) + 0.02
    low, high = low - margin, high + margin
    marks = (
        (1.0,)
        if high - low > 2  # noqa: PLR2004
        else (1.0, 2.0, 5.0)
        if high - low > 0.6  # noqa: PLR2004
        else (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0)
    )
    ticks = [
        mark * 10.0**power
        for power in range(math.floor(low), math.ceil(high) + 1)
        for mark in marks
    ]
    logarithmic(on)
    on.set_xlim(10**low, 10**high)
    on.xaxis.set_major_locator(
        FixedLocator([tick for tick in ticks if low <= math.log10(tick) <= high])
    )
    named_rows(on, names)
    label_axes(on, _FACTOR)
    legend(made)
    return made
