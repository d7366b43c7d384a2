"""The plots of the budget: which part is to blame, and the r.m.s. error without one level."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.budget import costs
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.plot import BLUE, GREEN, LEGEND, ORANGE, PER_UNIT, Plot, framed, label, named
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    from collections.abc import Sequence

    import plotly.graph_objects as go

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.error_model.budget import Budget, Cost

LEVELS_TEXT: Final = "Stacked bars of the r.m.s. error as manufactured, with load and pose compensated, and each robot mapped as well."
CAUSES_TEXT: Final = "Stacked bars of each kind of error's share of the mean square, by level."
_PARTS_SHOWN: Final = 15
_LEAST_SHOWN: Final = 5e-4  # would show as 0.0 %


def levels(found: Budget) -> go.Figure:
    """Draw the r.m.s. error as manufactured, compensated, and with each robot mapped, split by level."""
    import plotly.graph_objects as go

    squares = found.rms**2 * np.maximum(found.levels, 0.0)
    stages = ("as manufactured", "load and pose<br>compensated", "and each robot<br>mapped")
    left = np.array([squares[k:].sum() for k in range(len(stages))])
    unit = length(math.sqrt(left[0])).unit
    size = np.sqrt(left) * PER_UNIT[unit]
    figure = framed("Remaining r.m.s. error", height=330)
    for k, (name, colour) in enumerate((("load and pose", ORANGE), ("each robot", BLUE), ("each visit", GREEN))):
        share = np.array([squares[k] / whole if stage <= k and whole > 0 else 0.0 for stage, whole in enumerate(left)])
        bar = go.Bar(
            y=list(range(len(stages))),
            x=size * share,
            orientation="h",
            name=name,
            marker={"color": colour},
            width=0.6,
            customdata=100 * share,
            hovertemplate=f"{name}: %{{customdata:.3~g}} % of this bar's mean square<extra></extra>",
        )
        figure.add_trace(bar)
    for stage, whole in enumerate(left):
        text = str(length(math.sqrt(whole)))
        figure.add_annotation(x=math.sqrt(whole) * PER_UNIT[unit], y=stage, text=text, showarrow=False, xanchor="left", xshift=5)
    figure.update_yaxes(**named(stages))
    figure.update_xaxes(title_text=f"r.m.s. error [{unit}], split by mean square", range=[0, max(float(size[0]), 1e-12) * 1.25])
    figure.update_layout(barmode="stack", legend=LEGEND, margin_t=80)
    return figure


def budget(answer: Answer) -> go.Figure:
    """Draw the error budget by part: shares of the mean-square error in %, largest on top; a negative one cancels others."""
    import plotly.graph_objects as go

    found = costs(answer.sampled.tally)
    by_size = sorted(found, key=lambda cost: -abs(cost.share))
    shown = sorted(by_size[:_PARTS_SHOWN], key=lambda cost: -cost.share)
    rest = by_size[_PARTS_SHOWN:]
    names = [label(short_name(cost.part)) for cost in shown]
    shares = [100 * cost.share for cost in shown]
    hover = [
        f"{name}<br>{share:.3g} % of the mean square<br>{cost.alone * 1e6:.4g} µm r.m.s. alone"
        for name, share, cost in zip(names, shares, shown, strict=True)
    ]
    if rest:
        names.append(f"{len(rest)} others")
        shares.append(100 * sum(cost.share for cost in rest))
        hover.append(f"{len(rest)} others together<br>{shares[-1]:.3g} % of the mean square")
    bars = go.Bar(
        x=shares,
        y=list(range(len(names))),
        orientation="h",
        width=0.7,
        marker={"color": [ORANGE if share < 0 else BLUE for share in shares]},
        text=[_percent(share) for share in shares],
        textposition="outside",
        cliponaxis=False,
        textfont={"size": 12},
        hovertext=hover,
        hovertemplate="%{hovertext}<extra></extra>",
        showlegend=False,
    )
    figure = framed("Share of mean square by part", bars, height=130 + 23 * len(names))
    low, high = min([0.0, *shares]), max([0.0, *shares])
    room = 0.14 * ((high - low) or 1.0)
    figure.update_xaxes(
        title_text="share of mean square [%]", range=[low - (room if low < 0 else 0), high + room], zeroline=True, zerolinecolor="#888888"
    )
    figure.update_yaxes(**named(names))
    if low < 0:
        figure.add_annotation(
            x=0, y=1, xref="x", yref="paper", yanchor="bottom", xanchor="right", xshift=-4, text="cancels others", showarrow=False, font={"size": 12}
        )
    return figure


def by_level(found: Sequence[Cost], title: str) -> go.Figure:
    """Draw shares of the mean square in %, stacked by level; negative shares cancel others."""
    import plotly.graph_objects as go

    shown = [cost for cost in found if abs(cost.share) >= _LEAST_SHOWN][:_PARTS_SHOWN]
    rest = [cost for cost in found if cost not in shown]
    names = [label(short_name(cost.part)) for cost in shown]
    shares = np.array([cost.levels for cost in shown]).reshape(-1, 3)
    if rest:
        names.append(f"{len(rest)} other{'s' if len(rest) > 1 else ''}")
        shares = np.vstack([shares, np.sum([cost.levels for cost in rest], axis=0)])
    figure = framed(title, height=140 + 25 * len(names))
    for k, (name, colour) in enumerate((("load and pose", ORANGE), ("each robot", BLUE), ("each visit", GREEN))):
        bar = go.Bar(
            x=100 * shares[:, k],
            y=list(range(len(names))),
            orientation="h",
            width=0.7,
            name=name,
            marker={"color": colour},
            hovertemplate=f"{name}: %{{x:.3~g}} % of the mean square<extra></extra>",
        )
        figure.add_trace(bar)
    for row, levels_of in enumerate(shares):
        end = 100 * float(levels_of[levels_of > 0].sum())
        figure.add_annotation(x=end, y=row, text=_percent(100 * float(levels_of.sum())), showarrow=False, xanchor="left", xshift=5, font={"size": 12})
    low, high = min(0.0, 100 * float(shares.min(initial=0.0))), 100 * float(np.maximum(shares, 0).sum(axis=1).max(initial=0.0))
    figure.update_xaxes(title_text="share of mean square [%]", range=[1.05 * low, 1.16 * (high or 1.0)], zeroline=True, zerolinecolor="#888888")
    figure.update_yaxes(**named(names))
    figure.update_layout(barmode="relative", legend=LEGEND, margin_t=80)
    return figure


def of_budget(found: Budget, places: Sequence[Budget]) -> list[Plot]:
    """Return the plots of the error budgets without sampling. None where nothing errs."""
    if not found.parts:
        return []
    parts = by_level(found.parts, "Share of mean square by part")
    causes = by_level(found.causes, "Share of mean square by kind of error")
    return [
        Plot("levels", "levels", levels(found), LEVELS_TEXT),
        Plot("budget", "budget_levels", parts, "Stacked bars of each part's share of the mean square, by level."),
        Plot("causes", "causes_levels", causes, CAUSES_TEXT),
        *at_places(places),
    ]


def at_places(places: Sequence[Budget]) -> list[Plot]:
    """Return the plots of the error budgets at poses and in zones."""
    return [
        Plot(f"budget-at-{k}", f"budget_at_{k}", by_level(found.parts, "Share of mean square by part"), f"Stacked bars by part: {found.where}.")
        for k, found in enumerate(places, start=1)
        if found.parts
    ]


def _percent(share: float) -> str:
    return f"{share:.1f} %" if abs(share) >= 0.05 else "< 0.1 %"  # noqa: PLR2004 - would show as 0.0
