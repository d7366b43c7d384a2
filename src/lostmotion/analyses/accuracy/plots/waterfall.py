"""The plot of the effects of calibration and compensation, step by step."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from lostmotion.reporting.plot import BLUE, GREEN, INK, PER_UNIT, RED, framed
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.propagation.montecarlo.waterfall import Waterfall

# The stages of `studies.montecarlo.waterfall.STAGES` that follow each other, and what is done from one to the next.
_STEPS = (
    ("as manufactured", "as<br>manufactured"),
    ("calibrated", "geometry<br>calibrated"),
    ("both", "load<br>compensated"),
    ("both, and each robot mapped", "harmonics, stiffness<br>mapped"),
)


def waterfall(found: Waterfall) -> go.Figure:
    """Draw the reduction of the 95th percentile by each remedy in turn, with 95 % intervals."""
    import plotly.graph_objects as go

    stages = {stage.name: stage for stage in found.stages}
    at = [stages[name].q95 for name, _ in _STEPS]
    unit = length(at[0].value).unit
    factor = PER_UNIT[unit]
    values = [estimate.value * factor for estimate in at]
    steps = [values[0], *(after - before for before, after in pairwise(values)), 0.0]
    names = [*(text for _, text in _STEPS), "left"]
    # As many digits as the interval of the drop leaves meaning.
    offs = [stages[name].reduction for name, _ in _STEPS]
    drops = [length(step / factor, step / factor, step / factor + off.high - off.low) for step, off in zip(steps[:-1], offs, strict=True)]
    shown = [str(length(at[0].value, at[0].low, at[0].high)), *(str(drop).replace("-", "−") for drop in drops[1:])]
    shown.append(str(length(at[-1].value, at[-1].low, at[-1].high)))
    bars = go.Waterfall(
        x=names,
        y=steps,
        measure=["absolute", *["relative"] * (len(steps) - 2), "total"],
        customdata=shown,
        width=0.62,
        connector={"line": {"color": "#888888", "width": 1, "dash": "dot"}},
        increasing={"marker": {"color": RED}},
        decreasing={"marker": {"color": GREEN}},
        totals={"marker": {"color": BLUE}},
        hovertemplate="%{x}: %{customdata}<extra></extra>",
        showlegend=False,
    )
    left = [*values, values[-1]]
    ends = [*at, at[-1]]
    bounds = go.Scatter(
        x=names,
        y=left,
        mode="markers",
        marker={"size": 1, "color": INK},
        error_y={
            "type": "data",
            "symmetric": False,
            "array": [estimate.high * factor - value for estimate, value in zip(ends, left, strict=True)],
            "arrayminus": [value - estimate.low * factor for estimate, value in zip(ends, left, strict=True)],
            "color": INK,
            "thickness": 1.3,
            "width": 7,
        },
        hovertemplate=f"remaining:  %{{y:.4~g}} {unit}<extra></extra>",
        showlegend=False,
    )
    figure = framed("95th percentile, one remedy after the other", bars, bounds, height=400)
    for k, text in enumerate(shown):
        top = max(left[k], left[max(k - 1, 0)] if k < len(left) - 1 else 0.0, ends[k].high * factor)
        figure.add_annotation(x=names[k], y=top, text=text, showarrow=False, yanchor="bottom", yshift=3, font={"size": 12})
    figure.update_yaxes(title_text=f"95th percentile of the position error [{unit}]", range=[0, 1.18 * max(*left, 1e-12)])
    figure.update_xaxes(tickvals=names, ticktext=names, showgrid=False, tickangle=0)
    return figure
