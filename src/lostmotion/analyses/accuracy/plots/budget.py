"""The plots of the budget: which part is to blame, and the r.m.s. error without one level."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.budget import costs
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.chart import label_axes, legend, named_rows, one, stacked, text
from lostmotion.reporting.palette import LEVELS, LIGHT
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Cell, in_one_unit, length, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.error_model.budget import Budget, Cost
    from lostmotion.spatial import Floats

LEVELS_TEXT: Final = (
    "Stacked bars of the r.m.s. error as manufactured, with load and pose compensated, and each "
    "robot mapped as well."
)
CAUSES_TEXT: Final = "Stacked bars of each kind of error's share of the mean square, by level."
_PARTS_SHOWN: Final = 15
_LEAST_SHOWN: Final = 5e-4  # would show as 0.0 %


def levels(found: Budget) -> Figure:
    """Draw the r.m.s. error as manufactured, compensated, and with each robot mapped, split by
    level.
    """
    squares = found.rms**2 * np.maximum(found.levels, 0.0)
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


def by_level(found: Sequence[Cost], title: str) -> Figure:
    """Draw shares of the mean square in %, stacked by level; negative shares cancel others."""
    shown = [cost for cost in found if abs(cost.share) >= _LEAST_SHOWN][:_PARTS_SHOWN]
    rest = [cost for cost in found if cost not in shown]
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


def of_budget(found: Budget, places: Sequence[Budget]) -> list[Plot]:
    """Return the plots of the error budgets without sampling. None where nothing errs."""
    if not found.parts:
        return []
    parts = by_level(found.parts, "Share of mean square by part")
    causes = by_level(found.causes, "Share of mean square by kind of error")
    return [
        Plot("levels", "levels", levels(found), LEVELS_TEXT),
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
